"""Universal files of laboratories: read as an independent writer wrote them and as pyuff reads them; damaged ones are refused."""

import re
import tomllib

import numpy as np
import pytest
from measurement import universal_writer as write

import stickslip as ss
from stickslip.laboratory.measurement.measured_response import joined
from stickslip.laboratory.measurement.universal_file import read_universal

OMEGA0, RATIO = 2.0 * np.pi * 15.0, 0.02
INCH, POUND = 0.0254, 4.4482216152605
EVEN = np.linspace(10.0, 20.0, 101)
UNEVEN = 10.0 + 10.0 * np.linspace(0.0, 1.0, 101) ** 1.3


def receptance(frequency):
    """Of a mass of 1 kg on a spring, m/N."""
    omega = 2.0 * np.pi * frequency
    return 1.0 / (OMEGA0**2 - omega**2 + 2j * RATIO * OMEGA0 * omega)


def accelerance(frequency):
    return -((2.0 * np.pi * frequency) ** 2) * receptance(frequency)


def written(tmp_path, *sets, name="test.unv"):
    path = tmp_path / name
    path.write_bytes(b"".join(sets))
    return path


@pytest.mark.parametrize("binary", ["", "<", ">"])
def test_all_cases_of_the_format_are_read(tmp_path, binary):
    """Real or complex, single or double precision, even or uneven, to the digits that the file holds."""
    cases = [(x, y, double) for x in (EVEN, UNEVEN) for y in (accelerance(x), abs(accelerance(x))) for double in (False, True)]
    path = written(tmp_path, *(write.function(x, y, double=double, binary=binary) for x, y, double in cases))
    read = read_universal(path).functions
    assert len(read) == len(cases)
    for (x, y, double), one in zip(cases, read, strict=True):
        assert one.y.dtype == y.dtype
        assert one.x == pytest.approx(x, rel=1e-5)
        assert one.y == pytest.approx(y, rel=1e-12 if double else 1e-5)
        assert one.name == "12:+Z / 1:+X"


@pytest.mark.parametrize("binary", ["", "<", ">"])
def test_pyuff_reads_the_same(tmp_path, binary):
    """But for double values over uneven frequencies in 58b: the format has single ones there, and pyuff reads double ones."""
    pyuff = pytest.importorskip("pyuff")
    cases = [(x, y, double) for x in (EVEN, UNEVEN) for y in (accelerance(x), abs(accelerance(x))) for double in (False, True)]
    cases = [case for case in cases if not (binary and case[0] is UNEVEN and case[2])]
    places = {1: (0.0, 0.1, 0.2), 12: (0.5, -1.0, 1e-3)}
    sets = [write.header(), write.units(5, 1e3, 1e3), write.nodes(places), write.nodes_in_double(places)]
    path = written(tmp_path, *sets, *(write.function(x, y, double=double, binary=binary) for x, y, double in cases))
    ours, theirs = read_universal(path), pyuff.UFF(str(path)).read_sets()
    for one, other in zip(ours.functions, theirs[4:], strict=True):
        assert np.array_equal(one.x, other["x"])
        assert np.array_equal(one.y, other["data"])
        assert (one.kind, one.abscissa.kind, one.ordinate.kind) == (other["func_type"], 18, other["ordinate_spec_data_type"])
        assert (one.response.node, one.reference.direction) == (other["rsp_node"], other["ref_dir"])
    for nodes in theirs[2:4]:
        assert ours.nodes == dict(zip(nodes["node_nums"], zip(*(nodes[axis] for axis in "xyz"), strict=True), strict=True))
    assert (ours.functions[0].units.length, ours.functions[0].units.force) == (theirs[1]["length"], theirs[1]["force"])


@pytest.mark.parametrize(
    ("ordinate", "denominator", "sets", "order", "factor"),
    [
        ((write.ACCELERATION, "m/s^2"), (write.FORCE, "N"), (), 2, 1.0),
        ((write.ACCELERATION, "g"), (write.FORCE, "N"), (), 2, 1.0 / 9.80665),
        ((write.DISPLACEMENT, "mm"), (write.FORCE, "kN"), (), 0, 1e6),
        ((write.VELOCITY, "(mm/s)/N"), (0, "NONE"), (), 1, 1e3),
        ((1, "(1/N)*(m/s²)"), (0, "NONE"), (), 2, 1.0),
        ((write.VELOCITY, "NONE"), (write.FORCE, "NONE"), (write.units(),), 1, 1.0),
        ((write.DISPLACEMENT, "NONE"), (write.FORCE, "NONE"), (write.units(5, 1e3, 1e3),), 0, 1.0),
        ((write.DISPLACEMENT, "NONE"), (write.FORCE, "NONE"), (write.units(7, 1 / INCH, 1 / POUND),), 0, POUND / INCH),
        ((write.DISPLACEMENT, "mm"), (write.FORCE, "NONE"), (write.units(),), 0, 1e3),
    ],
)  # fmt: skip
def test_units_and_quantities(tmp_path, ordinate, denominator, sets, order, factor):
    """All are one receptance at 3 N: by labels of units, by data set 164, or both."""
    shown = factor * (2j * np.pi * EVEN) ** order * receptance(EVEN)
    path = written(tmp_path, *sets, write.function(EVEN, shown, ordinate=ordinate, denominator=denominator))
    test = ss.read_measured_response(path, force=3.0)
    assert test.quantity == ("displacement", "velocity", "acceleration")[order]
    assert test.per_force == pytest.approx((2.0 * np.pi * EVEN) ** order * receptance(EVEN), rel=2e-5)
    assert test.name == "test"
    assert not any(unit.assumed for unit in test.units.values())
    again = ss.read_measured_response(path, force=3.0, units={"amplitude": ("m/N", "(m/s)/N", "(m/s2)/N")[order]})
    assert again.per_force == pytest.approx(factor * test.per_force)


def test_what_the_file_says_and_is_not_obeyed_is_noted(tmp_path):
    other = write.data_set(82, "         1         2         0")
    sets = (write.header("ANALYSER 3"), write.units(), other)
    path = written(tmp_path, *sets, write.function(EVEN, accelerance(EVEN), response=(12, -3), ordinate=(12, "g")))
    notes = " ".join(ss.read_measured_response(path, force=1.0).notes)
    for said in (
        "Program and date of test.unv: ANALYSER 3, 02-Jan-26 13:00:00.",
        "not read: 82",
        "taken for g, its label, though data set 164 says 1 m/s2",
        "Function 1 of test.unv is read, 12:-Z / 1:+X: H, Run 1.",
        "along 12:-Z",
    ):
        assert said in notes
    assumed = ss.read_measured_response(written(tmp_path, write.function(EVEN, accelerance(EVEN))), force=1.0)
    assert [key for key, unit in assumed.units.items() if unit.assumed] == ["acceleration"]


def swapped(path):
    """The file with the other order of bytes in the first line of its 58b, whose values stay."""
    data = path.read_bytes()
    place = data.index(b"58b") + 8
    path.write_bytes(data[:place] + (b"2" if data[place : place + 1] == b"1" else b"1") + data[place + 1 :])
    return path


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("double", [False, True])
@pytest.mark.parametrize("even", [False, True])
@pytest.mark.parametrize("values", ["a response", "round numbers", "noise", "far apart"])
def test_a_58b_whose_order_of_bytes_is_a_lie_is_refused(tmp_path, order, double, even, values):
    """And one that tells the truth is read, whatever it holds."""
    x = EVEN if even else UNEVEN
    y = {
        "a response": accelerance(x),
        "round numbers": np.full(x.size, 0.5 - 0.25j),
        "noise": np.random.default_rng(0).normal(size=(x.size, 2)) @ [1e-6, 1e-6j],
        "far apart": 10.0 ** np.linspace(-9.0, 9.0, x.size) * (1.0 - 0.5j),
    }[values]
    path = written(tmp_path, write.function(x, y, double=double, binary=order))
    read = read_universal(path).functions[0].y
    assert read == pytest.approx(y, rel=1e-6)
    with pytest.raises(ss.InputError, match="order of bytes, must be that of its values"):
        read_universal(swapped(path))


@pytest.mark.parametrize("lost", [30, 35, 40, 44, 26, 24, 12])
@pytest.mark.parametrize("width", [67, 80, None])
@pytest.mark.parametrize("count", [1, 2])
def test_a_line_of_an_axis_that_has_lost_letters_is_refused(tmp_path, lost, width, count):
    """The unit lbf came into the label, and newtons were taken."""
    text = write.function(EVEN, accelerance(EVEN), denominator=(write.FORCE, "lbf")).decode().splitlines()
    at = next(k for k, line in enumerate(text) if line.rstrip().endswith("lbf"))
    axis = f"{13:10d}{0:5d}{0:5d}{0:5d} {'Excitation force':20s} {'lbf':20s}"
    text[at - 2 : at + 2] = [line.ljust(width) if width else line.rstrip() for line in (*text[at - 2 : at], axis, text[at + 1])]
    (tmp_path / "whole.unv").write_text("\n".join(text) + "\n")
    whole = ss.read_measured_response(tmp_path / "whole.unv", force=1.0)
    text[at] = text[at][:lost] + text[at][lost + count :]
    (tmp_path / "test.unv").write_text("\n".join(text) + "\n")
    with pytest.raises(ss.InputError, match=r"line of an axis|must be a whole number"):
        ss.read_measured_response(tmp_path / "test.unv", force=1.0)
    assert whole.amplitude == pytest.approx(np.abs(accelerance(EVEN)) / 4.4482216152605, rel=1e-5)


@pytest.mark.parametrize(
    ("unit", "quantity", "factor"),
    [
        ("g/lbf", "acceleration", 9.80665 / 4.4482216152605),
        ("in/lbf", "displacement", 0.0254 / 4.4482216152605),
        ("(in/s)/lbf", "velocity", 0.0254 / 4.4482216152605),
        ("ft/sec^2/lbf", "acceleration", 0.3048 / 4.4482216152605),
        ("(in/sec**2)/lbf", "acceleration", 0.0254 / 4.4482216152605),
        ("mil/lbf", "displacement", 2.54e-05 / 4.4482216152605),
        ("ips/kN", "velocity", 2.54e-05),
        ("ft/(lbf s2)", "acceleration", 0.3048 / 4.4482216152605),
        ("cm/daN", "displacement", 0.001),
        ("gn/kgf", "acceleration", 1.0),
        ("mm/N", "displacement", 0.001),
        ("mm/mN", "displacement", 1.0),
        ("m/MN", "displacement", 1e-06),
    ],
)
def test_units_of_inch_foot_and_pound(tmp_path, unit, quantity, factor):
    """By the international yard and pound and standard gravity; in universal files, in text and where a unit is given."""
    y = accelerance(EVEN)
    path = written(
        tmp_path, write.function(EVEN, y, ordinate=({"displacement": 8, "velocity": 11, "acceleration": 12}[quantity], "NONE"))
    )
    given = ss.read_measured_response(path, force=1.0, units={"amplitude": unit})
    assert given.amplitude == pytest.approx(factor * np.abs(y), rel=1e-5)
    rows = "\n".join(f"{x:.8g},{abs(value):.8g}" for x, value in zip(EVEN, y, strict=True))
    (tmp_path / "a.csv").write_text(f"frequency [Hz],response [{unit}]\n{rows}\n")
    test = ss.read_measured_response(tmp_path / "a.csv", force=1.0)
    assert (test.quantity, test.amplitude) == (quantity, pytest.approx(factor * np.abs(y), rel=1e-5))


def test_frequencies_in_rad_per_second(tmp_path):
    angular = write.function(2.0 * np.pi * EVEN, accelerance(EVEN), abscissa=(18, "rad/s"))
    assert ss.read_measured_response(written(tmp_path, angular), force=1.0).frequency == pytest.approx(EVEN, rel=1e-5)
    silent = write.function(2.0 * np.pi * EVEN, accelerance(EVEN), abscissa=(18, "NONE"))
    test = ss.read_measured_response(written(tmp_path, silent), force=1.0, units={"frequency": "rad/s"})
    assert test.frequency == pytest.approx(EVEN, rel=1e-5)


def test_one_of_several_functions_is_chosen_by_name_or_number(tmp_path):
    functions = [
        write.function(EVEN, k * accelerance(EVEN), response=(node, 3), entities=("wing", "NONE"))
        for k, node in enumerate((12, 13, 13), start=1)
    ]
    path = written(tmp_path, write.nodes({12: (0.1, 0.0, 0.2)}), *functions)
    with pytest.raises(ss.InputError) as raised:
        ss.read_measured_response(path, force=1.0)
    for said in (
        "1 = wing:12:+Z / 1:+X (a frequency response function of acceleration, H, node 12 at 0.1, 0, 0.2); 2 = wing:13:+Z",
        "columns={'amplitude': 'wing:12:+Z / 1:+X'} (--column 'amplitude=wing:12:+Z / 1:+X')",
    ):
        assert said in str(raised.value)
    for name in ("wing:12:+Z / 1:+X", "12:Z/1:X", "12:+z", 1, "1"):
        assert ss.read_measured_response(path, force=1.0, columns={"amplitude": name}).per_force == pytest.approx(
            -accelerance(EVEN), rel=2e-5
        )
    with pytest.raises(ss.InputError, match=r"chosen\. It holds 2 = .* columns={'amplitude': 2} .* or .* by='function' \(--by"):
        ss.read_measured_response(path, force=1.0, columns={"amplitude": "13:+Z"})
    tests = ss.read_measured_responses(path, "function", force=1.0, columns={"amplitude": "13:+Z"})
    assert [test.name for test in tests] == ["test wing:13:+Z / 1:+X (2)", "test wing:13:+Z / 1:+X (3)"]
    assert tests[1].amplitude == pytest.approx(1.5 * tests[0].amplitude, rel=2e-5)
    with pytest.raises(ss.InputError, match="Say which, by its name or number"):
        ss.read_measured_responses(path, "function", force=1.0)
    with pytest.raises(ss.InputError, match=r"must be one of its functions, but is '12:Y / 1:X'\. Did you mean 'wing:12"):
        ss.read_measured_response(path, force=1.0, columns={"amplitude": "12:Y / 1:X"})
    with pytest.raises(ss.InputError, match="must be a number from 1 to 3"):
        ss.read_measured_response(path, force=1.0, columns={"amplitude": 4})
    with pytest.raises(ss.InputError, match="by must be 'function'"):
        ss.read_measured_responses(path, "curve", force=1.0)
    with pytest.raises(ss.InputError, match="columns must name amplitude or force for a universal file, but is 'phase'"):
        ss.read_measured_response(path, force=1.0, columns={"phase": 2})


def test_force_levels_from_a_spectrum_of_the_force(tmp_path):
    """A response per force takes its level from it; two spectra are themselves a response per force."""
    force = (2.0 + 0.1 * (EVEN - 15.0)) * np.exp(0.7j)
    spectrum = write.function(
        EVEN, force, kind=12, response=(1, 1), reference=(0, 0), ordinate=(13, "N"), denominator=(0, "NONE")
    )
    motion = write.function(
        EVEN, force * accelerance(EVEN), kind=12, reference=(0, 0), ordinate=(12, "m/s2"), denominator=(0, "NONE")
    )
    response = write.function(EVEN, accelerance(EVEN))
    for sets in ((response, spectrum), (motion, spectrum), (spectrum, response, motion)):
        test = ss.read_measured_response(written(tmp_path, *sets))
        assert test.force == pytest.approx(abs(force), rel=2e-5)
        assert test.per_force == pytest.approx(-accelerance(EVEN), rel=3e-5)
        assert any("RMS" in note for note in test.notes)
    assert ss.read_measured_response(written(tmp_path, response, spectrum), force=5.0).force == pytest.approx(5.0)
    sets = (response, spectrum, response, write.function(EVEN, 3.0 * force, kind=12, response=(1, 1), ordinate=(13, "N")))
    tests = ss.read_measured_responses(written(tmp_path, *sets), "function")
    assert [float(test.force[0] / abs(force[0])) for test in tests] == pytest.approx([1.0, 3.0], rel=2e-5)
    alone = ss.read_measured_response(written(tmp_path, motion), force=2.0)
    assert alone.phase is None
    assert alone.amplitude == pytest.approx(abs(force * accelerance(EVEN)), rel=2e-5)
    with pytest.raises(ss.InputError, match=r"must be chosen\. It holds 2 = .* columns={'force': 2} \(--column force=2\)"):
        ss.read_measured_response(written(tmp_path, response, spectrum, spectrum))
    elsewhere = write.function(
        EVEN, force, kind=12, response=(7, 1), reference=(0, 0), ordinate=(13, "N"), denominator=(0, "NONE")
    )
    with pytest.raises(ss.InputError, match="friction depends on it, but is 'missing'"):
        ss.read_measured_response(written(tmp_path, response, elsewhere))
    named = ss.read_measured_response(written(tmp_path, response, elsewhere), columns={"force": "7:+X"})
    assert named.force == pytest.approx(abs(force), rel=2e-5)


@pytest.mark.parametrize(
    ("what", "words"),
    [
        ({"kind": 1, "abscissa": (17, "s"), "y": np.ones(101)}, "a time history of acceleration"),
        ({"kind": 6}, "a coherence of acceleration"),
        ({"kind": 9}, "what is no frequency response function and no spectrum"),
        ({"abscissa": (19, "rpm")}, "what is not over the frequency"),
        ({"response": (12, 5)}, "rotations and moments"),
        ({"ordinate": (13, "N"), "denominator": (12, "m/s2")}, "forces per motion"),
        ({"ordinate": (3, "NONE")}, "what is no displacement, velocity or acceleration"),
        ({"ordinate": (0, "NONE")}, "--unit 'amplitude=(m/s2)/N'"),
        ({"denominator": (12, "m/s2")}, "Not read: motions per motion."),
        ({"denominator": (0, "NONE")}, "units={'amplitude': '(m/s2)/N'}"),
        ({"ordinate": (12, "V")}, "The unit of acceleration in test.unv must be one of m/s2"),
        ({"denominator": (13, "slug")}, "The unit of force in test.unv must be one of n, kn"),
        ({"abscissa": (18, "CPM")}, "The unit of frequency in test.unv must be one of hz"),
        ({"y": np.linspace(-1.0, 1.0, 101)}, "must be complex, or hold amplitudes"),
        ({"kind": 12, "denominator": (0, "NONE"), "force": None}, "friction depends on it"),
    ],
)
def test_other_functions_are_refused(tmp_path, what, words):
    about = {"force": what.pop("force", 1.0)}
    path = written(tmp_path, write.function(EVEN, what.pop("y", accelerance(EVEN)), **what))
    with pytest.raises(ss.InputError) as raised:
        ss.read_measured_response(path, **{key: value for key, value in about.items() if value is not None})
    assert words in str(raised.value)


def test_a_sensor_against_an_axis_is_named_with_what_the_study_needs(tmp_path):
    """The output and the force that the note writes can be copied into a study."""
    (note,) = _against_axes(tmp_path, (105, -3), (103, -1))
    output, force = re.findall(r"(outputs = \[.*?\]) in \[sweep\] and (direction = \{.*?\}) in \[\[force\]\]", note)[0]
    assert tomllib.loads(output) == {"outputs": [{"name": "105:-Z", "direction": {"105.z": -1.0}}]}
    assert tomllib.loads(force) == {"direction": {"103.x": -1.0}}
    (alone,) = _against_axes(tmp_path, (105, -3), (103, 1))
    assert "[[force]]" not in alone
    assert not _against_axes(tmp_path, (105, 3), (103, 1))


def _against_axes(tmp_path, response, reference):
    path = written(tmp_path, write.function(EVEN, accelerance(EVEN), response=response, reference=reference))
    return [note for note in ss.read_measured_response(path, force=1.0).notes if "along" in note]


def test_units_that_contradict_themselves_are_refused(tmp_path):
    sets = (write.units(1, 3.2808, 0.2248), write.function(EVEN, accelerance(EVEN)))
    with pytest.raises(
        ss.InputError, match=r"must go with its code 1, 1 and 1 for length and force, but is '3\.2808 and 0\.2248'"
    ):
        ss.read_measured_response(written(tmp_path, *sets), force=1.0)
    with pytest.raises(ss.InputError, match=r"must be per force, but is 'mm'. Say units=\{'amplitude': 'mm/N'\}"):
        ss.read_measured_response(
            written(tmp_path, write.function(EVEN, receptance(EVEN), ordinate=(8, "NONE"))), force=1.0, units={"amplitude": "mm"}
        )


def test_damaged_files_are_refused(tmp_path):
    """Cut off anywhere, or with bytes that are missing or wrong, a file is refused or read as it was: never as another."""
    rng = np.random.default_rng(1)
    for binary in ("", "<"):
        sets = [
            write.header(),
            write.units(),
            *(write.function(x, accelerance(x), double=d, binary=binary) for x in (EVEN, UNEVEN) for d in (False, True)),
        ]
        whole = b"".join(sets)
        sound = read_universal(written(tmp_path, whole)).functions

        def same(data, sound=sound):
            try:
                file = read_universal(written(tmp_path, data))
            except ss.InputError:
                return None
            return len(file.functions) == len(sound) and all(
                np.array_equal(a.x, b.x) and np.array_equal(a.y, b.y) for a, b in zip(file.functions, sound, strict=True)
            )

        ends = [sum(map(len, sets[:k])) for k in range(1, len(sets))]
        between = {end + k for end in ends for k in range(-1, 5)}  # nothing but a new line and blanks is missing or left
        cuts = {int(k) for k in rng.integers(1, len(whole) - 8, 150)} - between
        assert {same(whole[:k]) for k in cuts} == {None}
        gone = rng.integers(1, 100, 150)
        starts = [int(k) for k in rng.integers(len(sets[0]), len(whole) - 100, 150)]
        results = [same(whole[:k] + whole[k + n :]) for k, n in zip(starts, gone, strict=True)]
        assert False not in results
        assert results.count(None) > 120


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((b"       101         1", b"2147483647         1"), "must go with the"),
        ((b"       101         1", b"       100         1"), "must go with the"),
        ((b"       101         1", b"     -101          1"), "must go with the"),
        ((b"       101         1", b"       1e9         1"), "must be a whole number in its columns, but is '1e9'"),
        ((b"         5       101", b"         3       101"), "type of ordinate, must be one of 2, 4, 5, 6"),
        ((b"       101         1", b"       101         2"), "spacing, must be 0 (uneven) or 1 (even)"),
        ((b"    -1\n    58", b"    -1\n"), "must be the number of a data set"),
        ((b"        12   3 NONE", b"        12   9 NONE"), "direction, must be a number from -6 to 6"),
        ((b"    -1\n    58\n", b"stray\n    -1\n    58\n"), 'Line 1 of test.unv must be "    -1" before a data set'),
    ],
)
def test_headers_that_are_wrong(tmp_path, change, words):
    data = write.function(EVEN, accelerance(EVEN))
    assert change[0] in data
    with pytest.raises(ss.InputError) as raised:
        read_universal(written(tmp_path, data.replace(*change, 1)))
    assert words in str(raised.value)


def test_headers_of_bytes_that_are_wrong(tmp_path):
    data = write.function(EVEN, accelerance(EVEN), binary="<")
    first = data.split(b"\n")[1]
    for cells, words in (
        ((3, 2, 11, 808), "order of bytes, must be 1"),
        ((1, 1, 11, 808), "must be 2, IEEE 754"),
        ((1, 3, 11, 808), "must be 2, IEEE 754"),
        ((1, 2, 12, 808), "lines of its header, must be 11"),
    ):
        line = f"{58:6d}b{cells[0]:6d}{cells[1]:6d}{cells[2]:12d}{cells[3]:12d}".encode()
        with pytest.raises(ss.InputError) as raised:
            read_universal(written(tmp_path, data.replace(first, line)))
        assert words in str(raised.value)
    with_new_line = data[:-7] + b"\r\n    -1\r\n"  # as some programs end it
    assert read_universal(written(tmp_path, with_new_line)).functions[0].y.size == 101
    doubles = write.function(UNEVEN, accelerance(UNEVEN), binary="<", double=True)
    as_pyuff = np.stack([UNEVEN, accelerance(UNEVEN).real, accelerance(UNEVEN).imag], axis=1).astype("<f8").tobytes()
    head = doubles[: -7 - 101 * 20].replace(b"2020", b"2424")
    one = read_universal(written(tmp_path, head + as_pyuff + b"    -1\n")).functions[0]
    assert np.array_equal(one.x, UNEVEN)


@pytest.mark.parametrize("binary", ["<", ">"])
@pytest.mark.parametrize(("x", "double"), [(EVEN, False), (EVEN, True), (UNEVEN, False), (UNEVEN, True)])
def test_a_wrong_number_of_bytes_is_made_up_for_by_the_number_of_values(tmp_path, x, double, binary):
    """A file is refused only where neither leads to the mark that ends the data set."""
    data = write.function(x, accelerance(x), double=double, binary=binary)
    right = read_universal(written(tmp_path, data)).functions[0]
    first = data.split(b"\n")[1]
    count = int(first[31:43])
    for wrong in (0, count // 2, count - 4, 999999999999):
        changed = data.replace(first, first[:31] + f"{wrong:12d}".encode() + first[43:])
        one = read_universal(written(tmp_path, changed)).functions[0]
        assert np.array_equal(one.x, right.x)
        assert np.array_equal(one.y, right.y)
        for damaged in (changed[:-30], changed.replace(b"       101         ", b"       100         ", 1)):
            with pytest.raises(ss.InputError, match="The counts disagree"):
                read_universal(written(tmp_path, damaged))


@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_complex_bytes_that_pyuff_writes_are_read(tmp_path):
    """pyuff 2.5.8 counts half the bytes of complex values."""
    pyuff = pytest.importorskip("pyuff")
    y, path = accelerance(EVEN), tmp_path / "test.unv"
    even = {"abscissa_spacing": 1, "abscissa_min": EVEN[0], "abscissa_inc": EVEN[1] - EVEN[0], "num_pts": EVEN.size}
    axes = {"abscissa_spec_data_type": 18, "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 13}
    ends = {"rsp_node": 12, "rsp_dir": 3, "ref_node": 1, "ref_dir": 3}
    texts = dict.fromkeys(("id1", "id2", "id3", "id4", "id5", "rsp_ent_name", "ref_ent_name"), "NONE")
    set_ = pyuff.prepare_58(binary=1, func_type=4, data=y, x=EVEN, ord_data_type=6, **ends, **texts, **even, **axes)
    pyuff.UFF(str(path)).write_sets(set_)
    np.testing.assert_array_equal(read_universal(path).functions[0].y, y)


def test_values_that_are_not_finite_are_refused(tmp_path):
    y = accelerance(EVEN)
    for value in (np.inf, np.nan, 1e50):
        y[7] = value
        for binary in ("", "<"):
            path = written(tmp_path, write.function(EVEN, y, binary=binary, double=True))
            with pytest.raises(ss.InputError, match=r"Function 1 of test.unv must hold finite numbers up to 1e\+40"):
                ss.read_measured_response(path, force=1.0)


def test_garbage_is_refused(tmp_path):
    rng = np.random.default_rng(0)
    for data in (
        b"",
        b"\n\n",
        rng.bytes(5000),
        b"    -1\n" + rng.bytes(5000),
        b"    -1\n    58\n" + rng.bytes(5000) + b"\n    -1\n",
    ):
        with pytest.raises(ss.InputError):
            ss.read_measured_response(written(tmp_path, data), force=1.0)


def test_lines_of_windows_and_any_ending_of_the_name(tmp_path):
    data = write.function(EVEN, accelerance(EVEN)).replace(b"\n", b"\r\n")
    for name in ("test.txt", "test.UFF", "test"):
        test = ss.read_measured_response(written(tmp_path, b"\r\n", data, name=name), force=1.0)
        assert test.per_force == pytest.approx(-accelerance(EVEN), rel=2e-5)


def test_notes_of_several_files_of_one_program_are_one(tmp_path):
    lines = [*["NONE"] * 5, "LabTest 3.1", "28-Nov-26  18:50:22"]
    notes = []
    for name in ("low", "high"):
        path = written(tmp_path, write.data_set(151, *lines), write.function(EVEN, accelerance(EVEN)), name=f"{name}.unv")
        notes += [(name, note) for note in ss.read_measured_response(path, force=1.0).notes]
    assert "Program and date of low.unv, high.unv: LabTest 3.1, 28-Nov-26 18:50:22." in joined(notes)
