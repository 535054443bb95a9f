"""Records of one contact: every layout is read to the same numbers, and each bad input gets a sentence that says what to do."""

import h5py
import numpy as np
import pytest
from scipy import io

import stickslip as ss
from stickslip.laboratory.measurement.contact_cycles import contact_cycles, reversals
from stickslip.solve.balance.energy import cycle_work
from stickslip.support.checks import InputError
from verify.identification import loop_of

KT, MU, N, AMPLITUDE = 20e6, 0.4, 100.0, 10e-6


def signals(cycles=5, samples=200, seed=0, noise=1e-3):
    """Time [s], displacement [m] and force [N] of one slider at 10 Hz, with noise relative to the amplitudes."""
    generator = np.random.default_rng(seed)
    u, force = (np.tile(one, cycles) for one in loop_of(np.ones(1), KT, MU, N, AMPLITUDE, samples))
    time = np.arange(u.size) / (10.0 * samples)
    noisy = [
        u + noise * AMPLITUDE * generator.standard_normal(u.size),
        force + noise * MU * N * generator.standard_normal(u.size),
    ]
    return time, *noisy


def rows(*columns, separator=",", decimal="."):
    lines = [separator.join(f"{value:.9g}" for value in row).replace(".", decimal) for row in zip(*columns, strict=True)]
    return "\n".join(lines) + "\n"


TIME, U, FORCE = signals()


@pytest.mark.parametrize(
    "text",
    [
        "time [s],displacement [um],friction force [N]\n" + rows(TIME, 1e6 * U, FORCE),
        "Time (s)\tNormal (N)\tPosition (mm)\tFriction (uN)\n" + rows(TIME, 0 * TIME + N, 1e3 * U, 1e6 * FORCE, separator="\t"),
        "Rig 7\nTest of Monday\n\nZeit / s;Weg / um;F / kN\n" + rows(TIME, 1e6 * U, 1e-3 * FORCE, separator=";", decimal=","),
        "# time displacement force\n# s m N\n" + rows(TIME, U, FORCE, separator=" "),
        "disp_um  force_N\n" + rows(1e6 * U, FORCE, separator="   "),
        "# time [s] displacement [um] force [N]\n" + rows(TIME, 1e6 * U, FORCE, separator=" "),
        rows(U, FORCE),
        rows(TIME, 1e3 * U, FORCE, separator=" "),
        '"t [s]","Slip [um]","Temperature [C]","Tangential force [N]"\n' + rows(TIME, 1e6 * U, 0 * U + 20.0, FORCE),
        "u [um], COF, Ft [N],\n" + rows(1e6 * U, FORCE / N, FORCE),
    ],
    ids=[
        "comma",
        "tabs",
        "decimal comma",
        "commented units",
        "blanks",
        "commented",
        "bare",
        "bare with time",
        "quoted",
        "coefficient",
    ],
)
def test_text_of_every_layout_is_read_to_the_same_numbers(tmp_path, text):
    (tmp_path / "record.txt").write_text(text)
    (record,) = ss.read_contact_records(tmp_path / "record.txt", normal_load=N)
    assert record.displacement == pytest.approx(U, abs=1e-8 * AMPLITUDE)
    assert record.force == pytest.approx(FORCE, abs=1e-8 * MU * N)
    assert record.normal == N
    assert record.time is None or record.time == pytest.approx(TIME)


def test_text_in_other_encodings(tmp_path):
    text = "Weg [µm];Kraft F [N]\n" + rows(1e6 * U, FORCE, separator=";")
    for encoding in ("cp1252", "utf-8-sig", "utf-16"):
        (tmp_path / "record.txt").write_bytes(text.encode(encoding))
        (record,) = ss.read_contact_records(tmp_path / "record.txt", normal_load=N)
        assert record.displacement == pytest.approx(U, abs=1e-8 * AMPLITUDE)


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_hyst_files_of_single_cycles_are_read_without_options(tmp_path, version):
    """The layout of Fantetti and others (2024): n × 2 under the name hyst, one file a cycle number."""
    u, force = loop_of(np.ones(1), KT, MU, N, AMPLITUDE, 500)
    for number in (1000, 1, 100):
        table = np.stack([1e6 * np.roll(u, 60), np.roll(force, 60) * (1.0 + 1e-4 * number)], axis=1)
        path = tmp_path / f"test_a_{number}.mat"
        if version == "5":
            io.savemat(path, {"hyst": table})
        else:
            with h5py.File(path, "w", userblock_size=512) as file:
                file["hyst"] = table.T
    records = ss.read_contact_records(sorted(tmp_path.iterdir()), normal_load=N)
    cycles = contact_cycles(records)
    assert list(cycles.numbers) == [1, 100, 1000]
    assert "um is assumed" in " ".join(records[0].notes)
    assert cycles.amplitude == pytest.approx(AMPLITUDE, rel=1e-3)
    assert cycles.energy[2] == pytest.approx(1.1 * 4.0 * MU * N * (AMPLITUDE - MU * N / KT), rel=2e-3)


@pytest.mark.parametrize("names", [("run_1.txt", "run_2.txt"), ("run_9.txt", "run_30.txt"), ("a.txt", "b.txt")])
def test_cycles_of_several_files_of_many_are_numbered_on(tmp_path, names):
    """The number in the name of a file is that of the file then, not of a cycle."""
    for name in names:
        (tmp_path / name).write_text(HEAD + rows(TIME, 1e6 * U, FORCE))
    records = ss.read_contact_records([tmp_path / name for name in names], normal_load=N)
    assert contact_cycles(records).numbers.tolist() == [1, 2, 3, 4, 5, 6, 7, 8]
    assert contact_cycles([ss.ContactRecord(U, FORCE, N), ss.ContactRecord(U, FORCE, N, number=100)]).numbers.tolist() == [
        *range(1, 5),
        *range(100, 104),
    ]


def test_vectors_of_a_matlab_file_are_known_by_name(tmp_path):
    io.savemat(tmp_path / "a.mat", {"time": TIME, "displacement_um": 1e6 * U, "force_N": FORCE})
    (record,) = ss.read_contact_records(tmp_path / "a.mat", normal_load=N)
    assert record.displacement == pytest.approx(U)
    assert record.time == pytest.approx(TIME)


HEAD = "time [s],displacement [um],force [N]\n"


def table(u=U, force=FORCE, time=TIME, head=HEAD):
    return head + rows(time, 1e6 * u, force)


def with_nan(values, row=7):
    found = values.copy()
    found[row] = np.nan
    return found


BAD = {
    "clipped": (
        table(force=np.clip(FORCE, -0.8 * MU * N, 0.8 * MU * N)),
        {},
        "must not be clipped, but is '[0-9]+ samples in a row at",
    ),
    "clipped in mN": (
        table(force=1e3 * np.clip(FORCE, -0.8 * MU * N, 0.8 * MU * N), head=HEAD.replace("[N]", "[mN]")),
        {},
        "must not be clipped, but is '[0-9]+ samples in a row at -?32000 mN'",
    ),
    "constant in mN": (table(force=0.0 * FORCE + 3.0, head=HEAD.replace("[N]", "[mN]")), {}, "constant at 3 mN"),
    "kN as N": (table(force=1e-3 * FORCE), {}, "0.0004.*Is a unit wrong.*force in kN it would be 0.4"),
    "mN as N": (table(force=1e3 * FORCE), {}, "Is a unit wrong.*in mN"),
    "metres": (table(u=1e6 * U), {}, r"must vary by 10 nm to 10 mm, but is '[\d.e+]+ um'.*unit"),
    "NaN": (table(force=with_nan(FORCE)), {}, "must be finite, but is 'not so in 1 row, first in row 8'"),
    "no force": ("time [s],displacement [um]\n" + rows(TIME, 1e6 * U), {}, "must hold force.*columns="),
    "no load": (table(), {"normal_load": None}, "normal load of record.txt must be known.*--normal-load"),
    "one way": (table(u=np.linspace(0.0, 1e-5, U.size)), {}, "must reverse.*right column"),
    "half a cycle": (table(U[:130], FORCE[:130], TIME[:130]), {}, "at least one whole cycle"),
    "constant": (table(force=0.0 * FORCE + 3.0), {}, "must vary.*connected"),
    "time back": (table(time=TIME[::-1]), {}, "Time of record.txt must increase.*cut together"),
    "a word": (HEAD + rows(TIME, 1e6 * U, FORCE) + "1,2,broken\n", {}, "Line 1002, column 3 of record.txt must be a number"),
    "cut off": (HEAD + rows(TIME, 1e6 * U, FORCE) + "1,2\n", {}, "Line 1002 of record.txt must have 3 cells"),
    "twice": ("force [N],displacement [um],friction [N]\n" + rows(FORCE, 1e6 * U, FORCE), {}, "must hold force once.*columns="),
    "unknown unit": (table(head="time [s],displacement [furlong],force [N]\n"), {}, "unit of displacement.*must be a known one"),
    "another unit": (table(head="time [s],displacement [N],force [N]\n"), {}, "unit of displacement.*must be one of m, mm"),
    "bare, four": (rows(TIME, U, FORCE, FORCE), {}, "must have titles.*columns="),
    "no column": (table(), {"columns": {"force": "Kraft"}}, "must be one of its titles.*Kraft"),
    "column 9": (table(), {"columns": {"force": 9}}, "must be a number from 1 to 3"),
    "quantity": (table(), {"units": {"kraft": "N"}}, "must name time, displacement, force, normal"),
    "no numbers": ("nothing\nhere\n", {}, "two rows of numbers or more, .* but is '2 lines without two such rows in turn'"),
    "one row": (HEAD + "0,1,2\n", {}, "two rows of numbers or more"),
    "empty": ("", {}, "but is 'empty'"),
    "motion": (rows(1e8 * U, FORCE), {}, "between 0.5 um and 0.5 mm.*units="),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_refused_with_a_remedy(tmp_path, name):
    text, options, words = BAD[name]
    (tmp_path / "record.txt").write_text(text)
    with pytest.raises(InputError, match=words):
        contact_cycles(ss.read_contact_records(tmp_path / "record.txt", **({"normal_load": N} | options)))


def test_bad_matlab_files(tmp_path):
    (tmp_path / "a.mat").write_bytes(b"\x00" * 300)
    with pytest.raises(InputError, match=r"a.mat: The file is damaged"):
        ss.read_contact_records(tmp_path / "a.mat", normal_load=N)
    io.savemat(tmp_path / "b.mat", {"x": np.ones((9, 3)), "y": np.ones((9, 2))})
    with pytest.raises(InputError, match=r"b.mat must hold the matrix hyst"):
        ss.read_contact_records(tmp_path / "b.mat", normal_load=N)
    with pytest.raises(InputError, match="must be a file that exists"):
        ss.read_contact_records(tmp_path / "c.mat", normal_load=N)
    with pytest.raises(InputError, match=r"a folder'\. Name the files in it"):
        ss.read_contact_records(tmp_path, normal_load=N)
    io.savemat(tmp_path / "d.mat", {"hyst": np.stack([U, FORCE], axis=1)})
    (tmp_path / "d.mat").write_bytes((tmp_path / "d.mat").read_bytes()[:3000])
    with pytest.raises(InputError, match=r"d.mat: The file is damaged"):
        ss.read_contact_records(tmp_path / "d.mat", normal_load=N)
    (tmp_path / "e.txt").write_bytes(bytes(range(1, 256)) * 40)
    with pytest.raises(InputError, match=r"e.txt must hold two rows of numbers"):
        ss.read_contact_records(tmp_path / "e.txt", normal_load=N)


def test_a_unit_against_that_of_the_file_is_taken_and_said(tmp_path):
    (tmp_path / "a.txt").write_text("u [um],F [N]\n" + rows(1e6 * U, 1e-3 * FORCE))
    (record,) = ss.read_contact_records(tmp_path / "a.txt", normal_load=N, units={"force": "kN", "displacement": "µm"})
    assert np.ptp(record.force) == pytest.approx(np.ptp(FORCE))
    assert record.notes == ("The unit of force in a.txt is taken for kN, as given, though the file says N.",)


def test_a_record_twice_is_said():
    record = ss.ContactRecord(U, FORCE, N, name="a.txt")
    assert "a.txt and a.txt hold the same samples, which count twice: leave one out." in contact_cycles([record, record]).notes


def test_a_load_beside_its_column_is_compared(tmp_path):
    (tmp_path / "a.txt").write_text("u [um],F [N],Normal load [N]\n" + rows(1e6 * U, FORCE, 0 * U + 90.0))
    (record,) = ss.read_contact_records(tmp_path / "a.txt", normal_load=N)
    assert record.normal == N
    assert record.notes == ("Check the normal load: 100 N is given, but the column of a.txt has 90 N in the median.",)
    (record,) = ss.read_contact_records(tmp_path / "a.txt")
    assert record.normal == pytest.approx(90.0)


def test_what_is_removed_is_said():
    """Approach and rest, drift, offsets and a turned sign; the energy is that of the loop all the same."""
    time, u, force = signals(cycles=20)
    drift = 4e-6 * np.arange(u.size) / u.size
    rest = np.full(150, u[0])
    moved = np.concatenate([rest, u + drift, rest + 4e-6]) + 3e-4
    turned = -np.concatenate([0.0 * rest, force, 0.0 * rest]) + 5.0
    record = ss.ContactRecord(moved, turned, N, np.arange(moved.size) * (time[1] - time[0]))
    cycles = contact_cycles(record)
    assert len(cycles.numbers) == 19
    assert cycles.period == pytest.approx(0.1, rel=1e-3)
    said = " ".join(cycles.removed)
    for words in (
        "samples lie outside",
        "Drift of the displacement removed: 3.8",
        "Mean displacement removed: 299.8 um",
        "Mean force",
    ):
        assert words in said
    assert "sign of the force is turned" in said
    assert cycles.energy.mean() == pytest.approx(4.0 * MU * N * (AMPLITUDE - MU * N / KT), rel=2e-3)


def test_cycles_with_pauses_or_another_load_are_dropped():
    time, u, force = signals(cycles=12)
    normal = np.full(u.size, N)
    normal[700:900] = 0.5 * N
    late = np.where(np.arange(u.size) >= 1600, time + 0.05, time)
    cycles = contact_cycles(ss.ContactRecord(u, force, normal, late))
    assert "2 of 11 cycles are dropped" in " ".join(cycles.removed)
    assert list(cycles.numbers) == [1, 2, 3, 5, 6, 7, 9, 10, 11]
    assert cycles.normal[:, 0] == pytest.approx(N, rel=5e-3)


@pytest.mark.parametrize("start", [0, 37, 50, 120, 170])
def test_two_cycles_are_never_taken_for_one(start):
    """Wherever a record of two or three cycles begins, each cycle has the energy of one."""
    _, u, force = signals(cycles=4)
    for count in (2, 3):
        part = slice(start, start + 200 * count)
        cycles = contact_cycles(ss.ContactRecord(u[part], force[part], N))
        assert count - 1 <= len(cycles.numbers) <= count
        assert cycles.energy == pytest.approx(4.0 * MU * N * (AMPLITUDE - MU * N / KT), rel=5e-3)


def test_reversals_of_a_noisy_motion():
    phase = 2.0 * np.pi * np.arange(1000) / 200.0
    motion = np.sin(phase) + 0.05 * np.random.default_rng(0).standard_normal(phase.size)
    places = reversals(motion, 0.4)
    assert np.asarray(places) == pytest.approx(50 + 100 * np.arange(10), abs=20)


def test_every_harmonic_of_both_signals_counts_in_the_area():
    """∮ F du by the rectangle rule, which is exact for so few harmonics."""
    u, f = np.random.default_rng(3).normal(size=(2, 7))
    angle, orders = 2.0 * np.pi * np.arange(64)[:, None] / 64, np.arange(1, 4)
    cosine, sine = np.cos(angle * orders), np.sin(angle * orders)
    force = f[0] + cosine @ f[1::2] + sine @ f[2::2]
    rate = sine @ (-orders * u[1::2]) + cosine @ (orders * u[2::2])
    assert cycle_work(f, u) == pytest.approx(2.0 * np.pi * np.mean(force * rate), rel=1e-12)


def test_the_area_from_harmonics_is_that_of_the_polygon():
    u, force = loop_of(np.ones(1), KT, MU, N, AMPLITUDE, 4000)
    harmonics = [np.fft.rfft(signal) / signal.size for signal in (u, force)]
    table = np.zeros((2, 401))
    for row, spectrum in zip(table, harmonics, strict=True):
        row[1::2], row[2::2] = 2.0 * spectrum[1:201].real, -2.0 * spectrum[1:201].imag
    assert cycle_work(table[1], table[0]) == pytest.approx(4.0 * MU * N * (AMPLITUDE - MU * N / KT), rel=1e-5)


def test_the_displacement_chooses_the_harmonics():
    """A sine needs few of them, whatever its noise; the corners of a trapezoid need more."""
    _, u, force = signals(cycles=6, samples=800)
    assert contact_cycles(ss.ContactRecord(u, force, N)).harmonics == 30
    place = np.arange(u.size) / 800.0 % 1.0
    trapezoid = AMPLITUDE * np.clip(3.0 * np.sin(2.0 * np.pi * place), -1.0, 1.0)
    clean = trapezoid + 1e-4 * AMPLITUDE * np.random.default_rng(0).standard_normal(u.size)
    assert contact_cycles(ss.ContactRecord(clean, force, N)).harmonics >= 60


def test_a_column_is_named_by_its_title_as_it_stands_in_the_file(tmp_path):
    path = tmp_path / "record.csv"
    path.write_text("Weg A [um],Weg B [um],Weg B [mm],Kraft [N]\n" + rows(0 * U, 1e6 * U, 0 * U + 1.0, FORCE))
    for title in ("Weg B [um]", " Weg B [um]", 2):
        (found,) = ss.read_contact_records(path, N, {"displacement": title, "force": "Kraft [N]"})
        np.testing.assert_allclose(found.displacement, U, rtol=1e-6, atol=1e-12)
    with pytest.raises(InputError, match="must be one of its titles"):
        ss.read_contact_records(path, N, {"displacement": "Weg B [nm]", "force": "Kraft"})


def test_a_loop_that_does_not_close_is_left_out():
    """One file a cycle, the first with the stroke of the virgin contact: from 0 to -mu N at the first reversal and so on."""
    u, force = loop_of(np.ones(1), KT, MU, N, AMPLITUDE, 400)
    turn = int(np.argmin(u))
    u, force = np.roll(u, -turn), np.roll(force, -turn)
    virgin = np.minimum(KT * (u - u[0]), MU * N)
    virgin[int(np.argmax(u)) :] = force[int(np.argmax(u)) :]
    noise = np.random.default_rng(0).standard_normal((2, 3, 400))
    forces = [virgin + 0.5 * noise[1, 0], force + 0.5 * noise[1, 1], force + 0.5 * noise[1, 2]]
    records = [
        ss.ContactRecord(u + 0.1e-6 * moved, carried, N, name=f"cycle {number}", number=number)
        for number, moved, carried in zip((100, 200, 300), noise[0], forces, strict=True)
    ]
    cycles = contact_cycles(records)
    assert cycles.numbers.tolist() == [200, 300]
    (note,) = cycles.notes
    assert "Left out: cycle 100 (" in note
    assert "its force does not close" in note
    found = ss.contact_law(records, laws=["jenkins", "iwan"])
    assert found.kt == pytest.approx(KT, rel=0.02)
    assert not any("changes" in warning for warning in found.warnings)
    assert contact_cycles(records[1:]).notes == ()


@pytest.mark.parametrize(("step", "noise"), [(0.5, 0.1), (2.0, 0.2)])
def test_a_coarse_converter_is_not_taken_for_a_clipped_sensor(step, noise):
    """The plateau of a slider is one level of it, as long as its noise is below the resolution."""
    generator = np.random.default_rng(0)
    force = FORCE + noise * generator.standard_normal(U.size)
    coarse = ss.ContactRecord(U, np.round(force / step) * step, N)
    assert all("below its resolution" in note for note in coarse.notes)
    with pytest.raises(InputError, match="must not be clipped"):
        ss.ContactRecord(U, np.clip(force, -0.8 * MU * N, 0.8 * MU * N), N)


def test_a_displacement_that_may_be_in_mm_says_so(tmp_path):
    (tmp_path / "a.txt").write_text("time [s],displacement,force [N]\n" + rows(TIME, 2e5 * U, FORCE))
    (record,) = ss.read_contact_records(tmp_path / "a.txt", normal_load=N)
    assert np.ptp(record.displacement) == pytest.approx(4e-6, rel=0.02)
    assert "um peak to peak are mm, as on a tribometer, kt is a thousandth" in " ".join(record.notes)
