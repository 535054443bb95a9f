"""Measured frequency responses from text files: titles, units, and what is refused."""

import numpy as np
import pytest

import stickslip as ss


def written(tmp_path, text):
    file = tmp_path / "level_2.csv"
    file.write_text(text)
    return file


def test_titles_and_units(tmp_path):
    text = "Phase [deg]; Force [mN]; Frequency [kHz]; Acceleration [g]\n-90;500;0,08;0,5\n-91;600;0,081;0,5\n-92;700;0,082;1\n"
    test = ss.read_measured_response(written(tmp_path, text), held="response", settings={"load": 2.0})
    assert test.name == "level_2"
    assert test.frequency == pytest.approx([80.0, 81.0, 82.0])
    assert test.force == pytest.approx([0.5, 0.6, 0.7])
    assert test.amplitude == pytest.approx([4.903325, 4.903325, 9.80665])
    assert test.phase == pytest.approx(np.radians([-90, -91, -92]))
    assert test.held == "response"
    assert test.per_force[0] == pytest.approx(-9.80665j)


def test_without_phase_and_with_a_force_that_is_known(tmp_path):
    test = ss.read_measured_response(written(tmp_path, "f,a\n80,1\n81,2\n82,1\n"), force=3.0, name="three")
    assert test.phase is None
    assert test.name == "three"
    assert test.per_force == pytest.approx([1 / 3, 2 / 3, 1 / 3])


def test_refused(tmp_path):
    with pytest.raises(ss.InputError, match="must name force"):
        ss.read_measured_response(written(tmp_path, "f,a\n80,1\n81,2\n82,1\n"))
    with pytest.raises(ss.InputError, match=r"The unit of force in level_2\.csv must be one of"):
        ss.read_measured_response(written(tmp_path, "f [Hz],a [m/s2],force [slug]\n80,1,1\n81,2,1\n82,1,1\n"))
    with pytest.raises(ss.InputError, match=r"acceleration in level_2\.csv must be finite and positive, but is '-2 in row 2"):
        ss.read_measured_response(written(tmp_path, "f [Hz],a [m/s2],force [N]\n80,1,1\n81,-2,1\n82,1,1\n"))


def test_rows_that_are_no_numbers_are_named(tmp_path):
    rows = "".join(f"{80 + k},{'nan' if k in (41, 70) else 1 + k},1,-90\n" for k in range(100))
    with pytest.raises(
        ss.InputError, match=r"but is 'nan in row 42 of the numbers and so in 1 more'\. Correct these rows"
    ) as raised:
        ss.read_measured_response(written(tmp_path, "f [Hz],a [m/s2],force [N],phase [deg]\n" + rows))
    assert len(str(raised.value)) < 200


def test_a_title_twice_is_refused(tmp_path):
    with pytest.raises(ss.InputError, match="must name frequency once"):
        ss.read_measured_response(written(tmp_path, "f [Hz],f [Hz],a [m/s2],force [N]\n80,80,1,1\n81,81,2,1\n82,82,1,1\n"))


def test_the_column_of_the_quantity_is_taken_in_a_unit_of_it(tmp_path):
    text = "frequency [Hz], acceleration [m/s2], displacement [um], force [N]\n" + "\n".join(
        f"{80 + k}, {10.0 + k}, {40.0 + k}, 2.0" for k in range(4)
    )
    path = written(tmp_path, text)
    assert ss.read_measured_response(path).amplitude[0] == 10.0
    assert ss.read_measured_response(path, quantity="displacement").amplitude[0] == pytest.approx(40e-6)
    only = written(tmp_path, "frequency [Hz], displacement [um], force [N]\n80, 1, 1\n81, 2, 1\n82, 1, 1\n")
    assert ss.read_measured_response(only).quantity == "displacement"
    assert ss.read_measured_response(only).amplitude[1] == pytest.approx(2e-6)
    with pytest.raises(ss.InputError, match="must name amplitude"):
        ss.read_measured_response(only, quantity="velocity")
    with pytest.raises(ss.InputError, match=r"unit of acceleration in .* must be one of m/s2"):
        ss.read_measured_response(only.with_name("level_2.csv"), quantity="acceleration", columns={"amplitude": 2})
    titled = written(tmp_path, "frequency [Hz], amplitude [mm], force [N]\n80, 1, 1\n81, 2, 1\n82, 1, 1\n")
    assert ss.read_measured_response(titled).quantity == "displacement"
    assert ss.read_measured_response(titled).amplitude[1] == pytest.approx(2e-3)


def test_meganewtons_are_no_millinewtons(tmp_path):
    rows = "80, 1, 1\n81, 2, 1\n82, 1, 1\n"
    for unit, factor in (("MN", 1e6), ("mN", 1e-3), ("kn", 1e3)):
        path = written(tmp_path, f"frequency [Hz], acceleration [m/s2], force [{unit}]\n{rows}")
        assert ss.read_measured_response(path).force[0] == pytest.approx(factor)


RECEPTANCE = np.array([2e-3 - 1e-4j, 3e-4 - 4e-3j, -1e-3 - 1e-3j])
"""m/N at 80, 81 and 82 Hz."""
FREQUENCY = np.array([80.0, 81.0, 82.0])


def rows(*columns):
    return "".join(",".join(f"{value:.17g}" for value in row) + "\n" for row in np.stack([FREQUENCY, *columns], axis=1))


@pytest.mark.parametrize(
    ("titles", "factor", "order"),
    [
        ("Frequency [Hz],Re(H) [m/N],Im(H) [m/N]", 1.0, 0),
        ("freq_Hz,Real [mm/N],Imag [mm/N]", 1e3, 0),
        ("f,H_real [um/mN],H_imag [um/mN]", 1e3, 0),
        ("f [Hz],Receptance real,Receptance imag", 1.0, 0),
        ("f [Hz],Re(H) [(m/s)/N],Im(H)", 1.0, 1),
        ("f [Hz],real part [(m/s^2)/N],imaginary part [(m/s^2)/N]", 1.0, 2),
        ("f [Hz],Accelerance Re [g/N],Accelerance Im [g/N]", 1.0 / 9.80665, 2),
        ("f [Hz],Re (m/(N s^2)),Im (m/(N s^2))", 1.0, 2),
    ],
)
def test_complex_responses_per_force(tmp_path, titles, factor, order):
    """All are one receptance, at 3 N; a first row at 0 Hz, as analysers write it, is left out."""
    shown = factor * (2j * np.pi * FREQUENCY) ** order * RECEPTANCE
    path = written(tmp_path, titles + "\n0,0,0\n" + rows(shown.real, shown.imag))
    test = ss.read_measured_response(path, force=3.0)
    assert test.quantity == ("displacement", "velocity", "acceleration")[order]
    assert test.frequency == pytest.approx(FREQUENCY)
    assert test.per_force == pytest.approx((2.0 * np.pi * FREQUENCY) ** order * RECEPTANCE)
    assert test.amplitude == pytest.approx(3.0 * np.abs(test.per_force))
    assert "1 row at 0 Hz left out" in " ".join(test.notes)
    with pytest.raises(ss.InputError, match=r"must name force, .* force=2\.0 \(--force 2\.0\)"):
        ss.read_measured_response(path)


@pytest.mark.parametrize(
    ("title", "factor"),
    [
        ("Phase [deg]", 180.0 / np.pi),
        ("phase_rad", 1.0),
        ("arg(H)", 1.0),
        ("Angle (°)", 180.0 / np.pi),
        ("phase lag [deg]", -180.0 / np.pi),
    ],
)
def test_sizes_and_phases_per_force(tmp_path, title, factor):
    """Of an accelerance the phase is its own, which a note says; of a plain acceleration it is the displacement's."""
    accelerance = -((2.0 * np.pi * FREQUENCY) ** 2) * RECEPTANCE
    text = rows(np.abs(accelerance) / 9.80665, factor * np.angle(accelerance))
    path = written(tmp_path, f"Frequency [Hz],|H| [g/N],{title}\n" + text)
    test = ss.read_measured_response(path, force=3.0)
    assert test.per_force == pytest.approx(-accelerance)
    assert "taken for that of the acceleration" in " ".join(test.notes)
    assert ss.read_measured_response(path, force=3.0, phase_of="displacement").per_force == pytest.approx(accelerance)
    plain = written(tmp_path, f"Frequency [Hz],acceleration [g],{title.replace('(H)', '')}\n" + text)
    assert ss.read_measured_response(plain, force=1.0).per_force == pytest.approx(accelerance)
    assert ss.read_measured_response(plain, force=1.0, phase_of="quantity").per_force == pytest.approx(-accelerance)


def test_columns_and_units_that_the_file_does_not_name(tmp_path):
    path = written(tmp_path, rows(1e3 * RECEPTANCE.real, 1e3 * RECEPTANCE.imag, np.full(3, 2e-3)))
    columns = {"frequency": 1, "real": 2, "imaginary": 3, "force": 4}
    test = ss.read_measured_response(path, columns=columns, units={"real": "mm/N", "force": "kN"})
    assert test.per_force == pytest.approx(RECEPTANCE)
    assert test.force == pytest.approx([2.0, 2.0, 2.0])
    path = written(tmp_path, "f [Hz],Re(H) [m/N],Im(H) [m/N]\n" + rows(1e3 * RECEPTANCE.real, 1e3 * RECEPTANCE.imag))
    test = ss.read_measured_response(path, units={"real": "mm/N"}, force=1.0)
    assert test.per_force == pytest.approx(RECEPTANCE)
    assert "taken for mm/N, as given, though the file says m/N" in " ".join(test.notes)


@pytest.mark.parametrize(
    ("titles", "about", "words"),
    [
        ("f [Hz],real,imag", {}, "unit of the real part in level_2.csv must be stated"),
        ("f [Hz],real [m/N],disp [m]", {}, "must name imaginary"),
        ("f [Hz],Re(H) [m/N],Im(H) [mm/N]", {}, "must be equal, but is 'm/N and mm/N'"),
        ("f [Hz],Accelerance [g],phase [rad]", {}, "must be per force, but is 'g'. Say units={'amplitude': 'g/N'}"),
        ("f [Hz],Re(H1),Re(H2)", {}, "must name real once"),
        ("f [Hz],H [lbf/in],phase [rad]", {}, "must be one of m, mm"),
        ("f [Hz],a [m/s2],force [N]", {}, "force of level_2.csv must be given once"),
        ("f [Hz],a [m/s2],phase", {}, "unit of phase in level_2.csv must be stated, but is 'missing, with values to 8'"),
        ("f [Hz],a [m/s2],b", {"columns": {"amplitude": 7}}, "must be a number from 1 to 3"),
        ("f [Hz],a [m/s2],b", {"columns": {"phrase": 3}}, "columns must name real, imaginary, phase"),
        ("f [Hz],a [m/s2],b", {"units": {"phase": "deg"}}, "units must be of columns of level_2.csv"),
        ("f [Hz],a [m/s2],b", {"phase_of": "force"}, "phase_of must be"),
    ],
)
def test_what_the_titles_leave_open_is_refused(tmp_path, titles, about, words):
    with pytest.raises(ss.InputError) as raised:
        ss.read_measured_response(written(tmp_path, titles + "\n" + rows([6.0, 7.0, 8.0], [6.0, 7.0, 8.0])), force=1.0, **about)
    assert words in str(raised.value)


def test_a_complex_response_from_matlab(tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "frf.mat", {"f_Hz": np.arange(80.0, 90.0), "H": np.linspace(1.0, 2.0, 10) * (1.0 - 1.0j)})
    test = ss.read_measured_response(tmp_path / "frf.mat", force=2.0, units={"real": "mm/N"})
    assert test.per_force == pytest.approx(1e-3 * np.linspace(1.0, 2.0, 10) * (1.0 - 1.0j))


def test_a_file_of_several_curves_is_refused_and_other_columns_are_named(tmp_path):
    head, rows = "curve,f [Hz],a [m/s2],force [N],temperature\n", [f"{1 + k // 3},{80 + k % 3},{1 + k},1,20" for k in range(6)]
    with pytest.raises(
        ss.InputError, match=r"by its column 'curve', must be 1, but is 2\. Split it, by='curve' \(--by 'curve'\)"
    ):
        ss.read_measured_response(written(tmp_path, head + "\n".join(rows) + "\n"))
    one = ss.read_measured_response(written(tmp_path, head + "\n".join(rows[:3]) + "\n"))
    assert any("not used: curve, temperature" in note for note in one.notes)


def test_a_file_of_several_curves_is_split_by_a_column(tmp_path):
    """By its title or its number; each curve has its own rows, name and numbers."""
    head, rows = (
        "curve,f [Hz],a [m/s2],force [N],temperature\n",
        [f"{3 - k % 2},{80 + k // 2},{1 + k},{1 + k % 2},20" for k in range(8)],
    )
    path = written(tmp_path, head + "\n".join(rows) + "\n")
    for by in ("curve", 1, "1"):
        tests = ss.read_measured_responses(path, by, error=0.02)
        assert [test.name for test in tests] == ["level_2 curve 3", "level_2 curve 2"]
        assert tests[1].amplitude == pytest.approx([2.0, 4.0, 6.0, 8.0])
        assert [float(np.max(test.force)) for test in tests] == [1.0, 2.0]
        assert tests[0].error == 0.02
        assert any("not used: temperature" in note for note in tests[0].notes)
    with pytest.raises(ss.InputError, match=r"column f of level_2.csv must distinguish curves of 3 rows or more"):
        ss.read_measured_responses(written(tmp_path, head.replace("curve", "b") + "\n".join(rows)), 2, columns={"frequency": 1})
    with pytest.raises(ss.InputError, match="by must be a column that holds nothing else"):
        ss.read_measured_responses(path, "force")
    with pytest.raises(ss.InputError, match="must be one of its titles"):
        ss.read_measured_responses(path, "curves")


def test_units_of_columns_are_kept_and_the_assumed_ones_marked(tmp_path):
    rows = "80,1,1,-1\n81,2,1,-2\n82,1,1,-3\n"
    none = ss.read_measured_response(written(tmp_path, "frequency,acceleration,force,phase\n" + rows))
    assert {key: unit.text for key, unit in none.units.items() if unit.assumed} == {
        "frequency": "Hz",
        "acceleration": "m/s2",
        "force": "N",
        "phase": "rad",
    }
    for titles in ("frequency [Hz],a [g],force [N],phase [rad]", "frequency_hz,acceleration_m_s2,force_n,phase_rad"):
        stated = ss.read_measured_response(written(tmp_path, titles + "\n" + rows))
        assert not any(unit.assumed for unit in stated.units.values())
    assert stated.units["acceleration"].factor == 1.0
    angular = ss.read_measured_response(written(tmp_path, "omega,accelerance\n80,1\n81,2\n82,1\n"), force=2.0)
    assert {key: unit.text for key, unit in angular.units.items()} == {"frequency": "rad/s", "acceleration": "(m/s2)/N"}
    assert angular.frequency[0] == pytest.approx(80.0 / (2.0 * np.pi))


def test_messages_show_the_numbers_of_the_file(tmp_path):
    with pytest.raises(ss.InputError, match=r"acceleration in level_2\.csv must be finite and positive, but is '-2 in row 2"):
        ss.read_measured_response(written(tmp_path, "f [Hz],a [g],force [N]\n80,1,1\n81,-2,1\n82,1,1\n"))
    with pytest.raises(ss.InputError, match=r"frequency in level_2\.csv must be finite and positive, but is '-0\.5 in row 1"):
        ss.read_measured_response(written(tmp_path, "f [kHz],a [g],force [N]\n-0.5,1,1\n81,2,1\n82,1,1\n"))


LOGGERS = {
    "names and units": "Frequency,Acceleration,Force\nHz,m/s2,N\n80,1,1\n81,2,1\n82,1,1\n",
    "units above names": "Hz,m/s2,N\nFrequency,Acceleration,Force\n80,1,1\n81,2,1\n82,1,1\n",
    "a preamble": "Device;MX840\nDate;2026-01-02\n\nFrequency;Acceleration;Force\n[Hz];[m/s²];[N]\n80;1;1\n81;2;1\n82;1;1\n",
    "named lines": "Channel name:\tFrequency\tAcceleration\tForce\nUnit:\tHz\tm/s2\tN\n\t80\t1\t1\n\t81\t2\t1\n\t82\t1\t1\n",
    "named lines beside a number": "Name,Frequency,Acceleration,Force\nUnit,Hz,m/s2,N\n1,80,1,1\n2,81,2,1\n3,82,1,1\n",
    "types": "Frequency,Acceleration,Force\nHz,m/s2,N\nfloat,float,float\n80,1,1\n81,2,1\n82,1,1\n",
    "channels": "Channel 1,Channel 2,Channel 3\nFrequency,Acceleration,Force\nHz,m/s2,N\n80,1,1\n81,2,1\n82,1,1\n",
    "sensors": "Frequency;Acceleration;Force\nsensor A;sensor B;sensor C\nHz;m/s2;N\n80;1;1\n81;2;1\n82;1;1\n",
    "another unit": "Frequency,Acceleration,Force,Temperature\nHz,m/s2,N,°C\n80,1,1,20\n81,2,1,20\n82,1,1,20\n",
    "times": "Time,Frequency,Acceleration,Force\ns,Hz,m/s2,N\n10:00:01,80,1,1\n10:00:02.5,81,2,1\n10:00:03,82,1,1\n",
    "dates": "Date;Frequency;Acceleration;Force\n;Hz;m/s2;N\n2026-01-02 10:00;80;1;1\n2026-01-02;81;2;1\n02.01.2026;82;1;1\n",
    "statistics": "Frequency [Hz],Acceleration [m/s2],Force [N]\nmin,1,1\n\n80,1,1\n81,2,1\n82,1,1\n",
}
"""Layouts of data loggers, all of one curve."""


@pytest.mark.parametrize("layout", LOGGERS)
def test_names_and_units_above_the_numbers_of_data_loggers(tmp_path, layout):
    test = ss.read_measured_response(written(tmp_path, LOGGERS[layout]))
    assert test.frequency == pytest.approx([80.0, 81.0, 82.0])
    assert test.amplitude == pytest.approx([1.0, 2.0, 1.0])
    assert test.quantity == "acceleration"
    assert not any(unit.assumed for unit in test.units.values())


def test_a_unit_of_a_data_logger_that_is_not_known_is_not_passed_over(tmp_path):
    with pytest.raises(ss.InputError, match=r"unit of force in level_2\.csv must be one of n, .*, but is 'slug'"):
        ss.read_measured_response(written(tmp_path, LOGGERS["names and units"].replace(",N\n", ",slug\n")))
    with pytest.raises(
        ss.InputError, match=r"column of frequency in level_2\.csv must be finite and positive, but is 'nan in row 2"
    ):
        ss.read_measured_response(written(tmp_path, LOGGERS["names and units"].replace("81,", "10:30,")))
