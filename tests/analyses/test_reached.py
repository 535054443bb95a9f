"""Which of several motions a machine shows, of a hardening oscillator and of one with an absorber that has a detached curve."""

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import stickslip as ss
from stickslip.analyses.reached import MotionsOfLevel, Place, reached
from stickslip.cli.app import app
from stickslip.results.quantities import words_of_flags
from stickslip.show.report.responses import sentences, tables
from stickslip.study import job
from stickslip.support.checks import InputError


def oscillator(sign=1.0, stiffness=1.0):
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=0.1 * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(sign * stiffness), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",))


def response(problem, ends, level, **how):
    return ss.forced_response(problem, ss.radians_per_second(*ends), level, harmonics=5, samples=64, **how)


@pytest.fixture(scope="module")
def hardening():
    return response(oscillator(), (0.5, 2.2), [0.02, 0.2])


def test_a_hardening_peak_is_reached_by_a_sweep_up_alone(hardening):
    """Under 0.02 the curve has no fold, and everything leads to its peak; the motion above the fold needs a sweep up."""
    table = hardening.reached(steps_per_period=200)
    assert table[["from_rest", "sweep_up", "sweep_down"]].values.tolist() == [[True, True, True], [False, True, False]]
    assert np.isnan(table.next_lower[0])
    # The unstable motion at the frequency of the peak, which is the next lower one there.
    at = hardening.at([table.frequency[1]]).isel(case=1, frequency=0, output=0)
    amplitudes = np.sort(at.amplitude.values[np.isfinite(at.amplitude.values)])
    assert amplitudes.size == 3
    np.testing.assert_allclose(table.next_lower[1], amplitudes[1], rtol=0.05)


def test_at_the_frequency_of_a_solved_point_no_other_motion_is_lost():
    """A curve that is begun below a fold and ended above passes each frequency an odd number of times, a fold itself apart."""
    found = response(oscillator(-1.0, 0.1), (0.4, 1.5), 0.17, isolated=False)
    frequency = found.dataset.frequency.values[0]
    inner = [f for f in frequency[1:-1] if frequency[0] < f < frequency[-1]]
    counts = np.isfinite(found.at(inner).amplitude.values[0, :, :, 0]).sum(axis=0)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(frequency))))
    assert turns.size == 2
    assert np.isin(counts, (1, 3)).all()
    assert (counts == 3).sum() > 10


def test_a_softening_peak_is_reached_by_a_sweep_down_alone():
    table = response(oscillator(-1.0, 0.1), (0.4, 1.5), 0.16).reached(steps_per_period=200)
    assert table[["sweep_up", "sweep_down"]].values.tolist() == [[False, True]]


def test_a_sweep_begins_at_rest_where_the_curve_ends_on_its_upper_part():
    """The band ends below the fold: a sweep down begins on the lower motion, which the curve does not reach."""
    problem = oscillator()
    up = response(problem, (0.5, 1.5), 0.2, quantity="receptance", isolated=False).reached(steps_per_period=200)
    down = response(problem, (1.5, 0.5), 0.2, isolated=False).reached(steps_per_period=200)
    assert up[["sweep_up", "sweep_down"]].values.tolist() == [[True, None]]
    assert up.unknown[0].endswith("sweep_down: a motion of no curve at 0.23873 Hz")
    assert down[["sweep_up", "sweep_down"]].values.tolist()[0][1] is False
    assert up.amplitude[0] < 5.0  # a displacement, not a receptance


def test_no_sweep_reaches_a_detached_curve():
    m, k, c = 0.05, 0.0454, 0.0073
    structure = ss.Structure(np.diag([1.0, m]), np.array([[1.0 + k, -k], [-k, k]]), ("1.x", "2.x"), C=[[0.0005 + c, -c], [-c, c]])
    problem = ss.Problem(structure, oscillator().contacts, (ss.Force("1.x", 1.0),), ("1.x",))
    found = response(problem, (0.7, 2.0), 0.038)
    table = found.reached(steps_per_period=200)
    assert table.curve.tolist() == ["sweep", "isolated"]
    assert table[["sweep_up", "sweep_down"]].values.tolist() == [[True, False], [False, False]]
    assert not table.from_rest[1]
    assert table.next_lower[1] < table.amplitude[1]
    kept = found.with_reached(steps_per_period=200)
    assert kept.dataset.attrs["cpu_seconds"] > found.dataset.attrs["cpu_seconds"]
    assert words_of_flags(kept.dataset.reached, kept.dataset.reached.values[1]) == ["not reached"] * 3
    assert words_of_flags(kept.dataset.reached, kept.dataset.reached.values[0]) == ["not reached", "reached", "not reached"]
    said = [line for line in sentences(kept.dataset) if "reached" in line]
    assert "is reached by a slow sweep up, neither from rest nor by a slow sweep down." in said[0]
    assert (
        "is reached neither from rest nor by a slow sweep up nor by a slow sweep down; only a disturbance leads to it" in said[1]
    )
    assert f"of roughly more than {table.next_lower[1]:.4g} m at" in said[1]
    assert any("[reached]" in line for line in sentences(found.dataset))


def test_what_time_integration_does_not_settle_is_not_known(hardening):
    table = hardening.reached(steps_per_period=200, periods=2)
    assert table.from_rest.tolist() == [None, None]
    assert table.unknown[0].startswith("from_rest: not periodic after 2 periods at 0.16107 Hz")
    assert table.sweep_up.tolist() == [True, True]  # no fold comes before the peak
    assert table.sweep_down.tolist() == [None, None]  # where it begins is not known
    said = [line for line in sentences(hardening.with_reached(steps_per_period=200, periods=2).dataset) if "reached" in line]
    assert (
        "is reached by a slow sweep up; not known to be reached from rest: not periodic after 2 periods at 0.16107 Hz" in said[0]
    )


STUDY = """
[study]
title = "One mass on a hardening spring"
analysis = "forced_response"
[structure]
matrices = { M = [[1.0]], K = [[1.0]], C = [[0.1]] }
dofs = ["1.x"]
[[contact]]
law = "cubic_spring"
k3 = 1.0
between = ["1.x", "ground"]
[[force]]
direction = "1.x"
amplitude = 1.0
[sweep]
frequency = [0.08, 0.35]
force_levels = [0.2]
harmonics = 5
samples = 64
outputs = ["1.x"]
[reached]
steps_per_period = 200
"""


@pytest.mark.usefixtures("unsaved_figures")
def test_a_study_says_which_peaks_are_reached(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    command = ["run", str(tmp_path / "study.toml"), "--out", str(tmp_path / "out"), "--workers", "1"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    assert "is reached by a slow sweep up, neither from rest nor by a slow sweep down." in result.output
    results = ss.open_results(tmp_path / "out" / "results.nc")
    assert words_of_flags(results.reached, results.reached.values[0]) == ["not reached", "reached", "not reached"]
    assert float(results.next_lower[0]) < float(results.peak_amplitude[0, 0, 0])
    exported = tables(results)["reached"]
    assert exported.loc[0, ["from_rest", "sweep_up", "sweep_down"]].tolist() == ["not reached", "reached", "not reached"]
    assert exported["next_lower [m]"][0] == float(results.next_lower[0])


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("frequency = [0.08, 0.35]", "at = [0.1, 0.2]", "needs a band"),
        ("steps_per_period = 200", 'output = "2.x"', "must be an output, but is '2.x'"),
        ("steps_per_period = 200", "steps_per_period = 4", "steps_per_period"),
        ("steps_per_period = 200", "steps_per_period = 10", r"steps_per_period must be more than twice the 5 harmonics"),
        ("[reached]", "[isolated]\nperiods = 2\n[reached]", r"\[isolated\] periods must be 1 beside \[reached\]"),
    ],
)
def test_a_study_that_cannot_say_it_is_refused(tmp_path, before, after, words):
    (tmp_path / "study.toml").write_text(STUDY.replace(before, after))
    with pytest.raises(InputError, match=words):
        job((tmp_path / "study.toml").read_text(), tmp_path, "study.toml")


def test_listed_frequencies_are_refused():
    listed = ss.forced_response(oscillator(), [0.16], 0.1, harmonics=3, samples=64)
    with pytest.raises(InputError, match="`reached` needs a response over a band"):
        listed.reached()


def test_a_curve_that_passes_its_peak_twice_has_one_motion_there(hardening):
    """Of light damping a curve may go over the same resonance again: neither is below the other, and a sweep passes both."""
    dataset = hardening.dataset.isel(case=[0])
    twice = xr.concat([dataset, dataset], "point", data_vars="minimal", coords="minimal")
    problem = hardening.problem
    once = reached(dataset, problem, 0, 200, 2000, None)
    again = reached(twice, problem, 0, 200, 2000, None)
    assert again[["from_rest", "sweep_up", "sweep_down"]].values.tolist() == [[True, True, True]]
    assert np.isnan(again.next_lower[0])
    assert np.isnan(once.next_lower[0])


def test_what_a_curve_that_breaks_off_reaches_is_not_known():
    found = response(oscillator(), (0.5, 0.8), 0.02, isolated=False)
    found.dataset["case_outcome"].values[0] = 2
    (line,) = (line for line in sentences(found.with_reached(steps_per_period=200).dataset) if "known to be reached" in line)
    assert "the largest motion, no peak, at" in line
    assert line.endswith("is not known to be reached: the curve ends before a peak.")


def test_a_curve_that_breaks_off_is_followed_to_its_end_without_time_integration(hardening, monkeypatch):
    """A sweep up passes the peak before that end; of a sweep down nothing is known."""
    dataset = hardening.dataset.isel(case=[1]).copy(deep=True)
    peak = int(hardening.peak_point(1))
    dataset["outcome"].values[0, peak + 5 :] = 0
    dataset["case_outcome"].values[0] = 2
    asked = []
    monkeypatch.setattr(MotionsOfLevel, "settled", lambda self, question, *_: asked.append(question))
    motions = MotionsOfLevel(dataset, hardening.problem, [0], 200, 100)
    place = Place(0, peak)
    end = float(dataset["frequency"].values[0, peak + 4])
    passed, known = motions.swept("sweep_up")
    folds = float(dataset["frequency"].values[0, peak + 4]) < float(dataset["frequency"].values[0, peak])
    assert motions.passes(passed, place)
    assert asked == (["sweep_up"] if folds else [])
    passed, known = motions.swept("sweep_down")
    assert not passed
    assert known == pytest.approx(2.2 / (2.0 * np.pi))
    assert motions.unknown["sweep_down"] == f"the curve broke off at {end:.5g} Hz"
    assert asked.count("sweep_down") == 0


def test_an_unstable_motion_is_not_reached(hardening):
    """Though a sweep along its curve passes it."""
    dataset = hardening.dataset.copy(deep=True)
    dataset["highest_stability"].values[:] = 2
    table = reached(dataset, hardening.problem, 0, 200, 2000, None)
    assert set(table["stability"]) == {"unstable"}
    assert not any(table[question].fillna(False).any() for question in ("from_rest", "sweep_up", "sweep_down"))
