"""Records at the door: read with their units, or refused with what is wrong; cycles found, gaps and drift said."""

import re

import numpy as np
import pytest

from stickslip.laboratory.measurement.cycles import LoadRemoval, read_load_removal, whole_cycles, zero_by_load_removal
from stickslip.laboratory.measurement.records import Record, read_record
from stickslip.support.checks import InputError

SAMPLES, CYCLES, RATE = 200, 12, 5.0
TIME = np.arange(SAMPLES * CYCLES) / (SAMPLES * RATE)


def signals(seed=0):
    noise = np.random.default_rng(seed).standard_normal((4, TIME.size))
    angle = 2.0 * np.pi * RATE * TIME
    return {
        "platform_x": 30e-6 * np.sin(angle) + 8e-8 * noise[0],
        "force_x": 40.0 + 15.0 * np.tanh(3.0 * np.sin(angle + 0.4)) + 0.05 * noise[1],
        "force_y": 45.0 + 9.0 * np.sin(angle + 0.2) + 0.05 * noise[2],
        "rotation": 3e-4 * np.sin(angle) + 8e-6 * noise[3],
    }


def write(path, columns):
    """Columns as a table, {header: values}."""
    rows = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    return path


def in_file_units():
    s = signals()
    return {
        "t [ms]": 1e3 * TIME,
        "h_LP [um]": 1e6 * s["platform_x"],
        "H_R (N)": s["force_x"],
        "V_R [N]": s["force_y"],
        "beta [mrad]": 1e3 * s["rotation"],
        "temperature [C]": 20.0 + 0.0 * TIME,
    }


def test_a_table_is_read_in_si_with_other_names(tmp_path):
    record = read_record(write(tmp_path / "oop.csv", in_file_units()))
    for name, values in signals().items():
        np.testing.assert_allclose(record.signals[name], values, rtol=1e-6)
    np.testing.assert_allclose(record.time, TIME, atol=1e-9)
    assert any("temperature" in sentence for sentence in record.warnings)


def test_a_decimal_comma_is_read_where_semicolons_separate(tmp_path):
    path = write(tmp_path / "a.csv", in_file_units())
    numbers = read_record(path)
    path.write_text(path.read_text().replace(",", ";").replace(".", ","))
    commas = read_record(path)
    np.testing.assert_array_equal(commas.time, numbers.time)
    np.testing.assert_array_equal(commas.signals["rotation"], numbers.signals["rotation"])


@pytest.mark.parametrize("coding", ["cp1252", "utf-16", "utf-8-sig"])
def test_a_table_is_read_as_a_logger_writes_it(tmp_path, coding):
    """What was measured, titles and units in lines of their own, in any code page."""
    path = write(tmp_path / "a.csv", in_file_units())
    plain = read_record(path)
    names, *rows = path.read_text().splitlines()
    titles, units = zip(*(re.fullmatch(r"(\S+) [\[(](.*)[\])]", name).groups() for name in names.split(",")), strict=True)
    lines = ["Damper rig, 20 °C", "Recorded: 2024-05-01 10:00", ",".join(titles), ",".join(units).replace("um", "µm"), *rows]
    path.write_text("\n".join(lines), encoding=coding)
    logged = read_record(path)
    np.testing.assert_array_equal(logged.time, plain.time)
    for name, values in plain.signals.items():
        np.testing.assert_array_equal(logged.signals[name], values)
    assert logged.warnings == plain.warnings


def test_columns_and_units_can_be_given(tmp_path):
    columns = {"Zeit": TIME, "Kraft": signals()["force_x"], "Weg": 1e6 * signals()["platform_x"]}
    names = {"time": "Zeit", "force_x": "Kraft", "platform_x": "Weg"}
    record = read_record(write(tmp_path / "a.csv", columns), names, {"time": "s", "force_x": "N", "platform_x": "um"})
    np.testing.assert_allclose(record.signals["platform_x"], signals()["platform_x"], rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c | {"H_R (N)": np.where(TIME > 1, np.nan, c["H_R (N)"])}, "must be finite"),
        (lambda c: c | {"H_R (N)": 0.0 * TIME + 3.0}, "must vary"),
        (lambda c: c | {"H_R (N)": np.minimum(c["H_R (N)"], 50.0)}, "must not be clipped"),
        (lambda c: {k.replace("[um]", "[mm]"): v for k, v in c.items()}, "Is its unit right"),
        (lambda c: {k.replace("[um]", "[N]"): v for k, v in c.items()}, "must be one of m, mm, um"),
        (lambda c: {k.replace("[um]", "[parsec]"): v for k, v in c.items()}, "must be a known one"),
        (lambda c: {k.replace(" [um]", ""): v for k, v in c.items()}, "must be stated"),
        (lambda c: {k: v for k, v in c.items() if "t [" not in k}, "must hold time"),
        (lambda c: {k: v[:: -1 if k == "t [ms]" else 1] for k, v in c.items()}, "must increase"),
    ],
)
def test_a_bad_table_is_refused(tmp_path, change, words):
    with pytest.raises(InputError, match=words):
        read_record(write(tmp_path / "bad.csv", change(in_file_units())))


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "is 'empty'"), ("time [s],force_x [N]\n1,2\n3,4\n5\n", "must have 2 cells"), ("1,2\n3,4\n", "must have titles")],
)
def test_a_broken_file_is_refused(tmp_path, text, words):
    path = tmp_path / "x.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        read_record(path)


def test_a_signal_at_the_end_of_its_range_is_saturated():
    with pytest.raises(InputError, match="saturated"):
        Record(TIME, signals(), ranges={"force_x": (-50.0, 50.0)})


def test_cycles_of_a_record_with_its_frequency():
    cycles = whole_cycles(Record(TIME, signals()))
    assert cycles.frequency == pytest.approx(RATE, rel=1e-5)
    assert cycles.harmonics.shape == (CYCLES, 4, 61)
    assert cycles.channel("platform_x")[2] == pytest.approx(30e-6, rel=2e-3)
    assert cycles.warnings == ()


def test_the_mean_cycle_is_better_than_one():
    cycles = whole_cycles(Record(TIME, signals(3)))
    one = np.abs(cycles.harmonics[:, 0, 5:]).mean()
    assert np.abs(cycles.mean[0, 5:]).mean() == pytest.approx(one / np.sqrt(CYCLES), rel=0.3)
    assert cycles.standard_error[0, 5:].mean() == pytest.approx(np.abs(cycles.mean[0, 5:]).mean(), rel=0.6)


def test_gaps_and_drift_are_said_and_the_cycle_is_left_out():
    s = signals()
    keep = (TIME < 3.1 / RATE) | (TIME > 3.4 / RATE)
    s["force_x"] = s["force_x"] + 5.0 * TIME / TIME[-1]
    cycles = whole_cycles(Record(TIME[keep], {name: values[keep] for name, values in s.items()}))
    assert len(cycles.harmonics) == CYCLES - 1
    said = " ".join(cycles.warnings)
    assert "cycles with gaps are left out: 4 of 12" in said
    assert "force_x drifts by" in said
    assert "force_y" not in said


def test_a_few_missing_rows_do_not_cost_their_cycles():
    """Rows 700, 1100, 1101 and the first of a cycle; harmonics up to the thirtieth are those of the whole record."""
    s, keep = signals(), np.ones(TIME.size, dtype=bool)
    keep[[700, 1100, 1101, 5 * SAMPLES]] = False
    holed = whole_cycles(Record(TIME[keep], {name: values[keep] for name, values in s.items()}), RATE)
    whole = whole_cycles(Record(TIME, s), RATE)
    assert holed.harmonics.shape == whole.harmonics.shape
    assert not holed.warnings
    scale = np.abs(whole.mean).max(axis=1)
    assert np.max(np.abs(holed.mean - whole.mean) / scale[:, None]) < 2e-3
    keep[1100:1112] = False
    left = whole_cycles(Record(TIME[keep], {name: values[keep] for name, values in s.items()}), RATE)
    assert "cycles with gaps are left out: 6 of 12" in left.warnings[0]


@pytest.mark.parametrize(
    ("count", "step", "words"), [(2, 1, "at least 3 whole cycles"), (12, 4, "samples a cycle"), (5, 1, None)]
)
def test_too_few_cycles_or_samples(count, step, words):
    part = slice(0, count * SAMPLES, step)
    record = Record(TIME[part], {name: values[part] for name, values in signals().items()})
    if words:
        with pytest.raises(InputError, match=words):
            whole_cycles(record)
    else:
        assert any("only 5 cycles" in sentence for sentence in whole_cycles(record).warnings)


def test_a_platform_at_rest_is_refused():
    still = signals() | {"platform_x": 1e-9 * signals()["force_y"]}
    with pytest.raises(InputError, match="must move"):
        whole_cycles(Record(TIME, still))


def test_the_zero_of_a_cell_from_load_removal():
    generator = np.random.default_rng(1)
    reading = np.concatenate([np.full(300, 23.0), np.linspace(23.0, -34.0, 100), np.full(300, -34.0)])
    zero = zero_by_load_removal(reading + 0.1 * generator.standard_normal(700))
    assert zero.reading == pytest.approx(-34.0, abs=0.05)
    assert zero.drop == pytest.approx(57.0, abs=0.1)
    assert zero.error == pytest.approx(0.04 * 57.0, rel=0.01)
    assert len(zero.levels) == 2
    with pytest.raises(InputError, match="Was load removed"):
        zero_by_load_removal(0.1 * generator.standard_normal(700))


def test_with_an_exact_calibration_the_error_of_a_zero_is_that_of_a_mean():
    """σ/√n of the samples of the last level, σ = 0.1 N as the differences of neighbours show it."""
    zero = zero_by_load_removal(falling([23.0, -34.0], [3000, 4000]), calibration_error=0.0)
    assert zero.error == pytest.approx(0.1 / np.sqrt(4000), rel=0.1)


def falling(levels, lengths, noise=0.1):
    reading = np.repeat(np.asarray(levels, dtype=float), lengths)
    return reading + noise * np.random.default_rng(3).standard_normal(reading.size)


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_load_removed_in_steps_of_any_length(noise):
    """Short loaded level, then three steps; the last level alone counts."""
    zero = zero_by_load_removal(falling([23.0, 4.0, -16.0, -34.0], [60, 150, 40, 200], noise))
    assert zero.levels == pytest.approx([23.0, 4.0, -16.0, -34.0], abs=0.05)
    assert zero.reading == pytest.approx(-34.0, abs=0.05)
    assert zero.error == pytest.approx(0.04 * 57.0, rel=0.01)


@pytest.mark.parametrize(
    ("reading", "words"),
    [
        (falling([23.0], [400]), "Was load removed"),
        (np.linspace(23.0, -34.0, 400), "Was load removed"),
        (np.concatenate([falling([23.0], [200]), np.linspace(23.0, -34.0, 40)]), "must begin loaded and end unloaded"),
        (np.concatenate([falling([23.0], [200]), np.linspace(-20.0, -34.0, 2000)]), "drifting"),
        (falling([23.0, -34.0, 0.0, -34.0], [100] * 4), "must go one way"),
        (falling([23.0, -34.0], [10, 10]), "at least 40"),
    ],
)
def test_a_load_removal_without_a_zero_is_refused(reading, words):
    with pytest.raises(InputError, match=words):
        zero_by_load_removal(reading)


def test_a_load_removal_that_rises_is_refused(tmp_path):
    force = falling([23.0, 0.0], [100, 100])
    with pytest.raises(InputError, match="force_y of load removal must fall while the load is removed, but is 'rising by"):
        LoadRemoval({"force_x": force, "force_y": -force}).zeros()
    path = tmp_path / "off.csv"
    rows = np.stack([np.arange(200.0), 1e3 * force, force], axis=1)
    np.savetxt(path, rows, delimiter=",", header="time [s],H_R [mN],V_R [N]", comments="")
    zeros = read_load_removal(path).zeros(0.03)
    assert zeros["force_x"].drop == pytest.approx(zeros["force_y"].drop)
    assert zeros["force_x"].error == pytest.approx(0.03 * 23.0, rel=0.02)
