"""Stability in a result: flags, changes, peaks, figures and sentences."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from problem.loose_wedge import wedge_between
from typer.testing import CliRunner

import stickslip as ss
from stickslip.analyses import stability
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.cli import app
from stickslip.model import rigs
from stickslip.model.problem.systems import soft_springs
from stickslip.results.quantities import stability_sentences
from stickslip.show.plots.response_curves import response_curves
from stickslip.show.report.answer import peaks_at_a_glance, warnings_of
from stickslip.show.report.responses import sentences, tables
from stickslip.solve.stability.multipliers import Stability


@pytest.fixture(scope="module")
def duffing():
    """q̈ + 0.1 q̇ + q + q³/2 = cos ωt, with two folds."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=0.1 * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(0.5), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",), "Duffing")
    return ss.forced_response(problem, ss.Band(0.1, 0.5), harmonics=7).with_stability()


def test_stability_changes_at_the_folds_of_a_duffing_oscillator(duffing):
    dataset = duffing.dataset
    frequency = dataset.frequency.values[0]
    turns = frequency[np.flatnonzero(np.diff(np.sign(np.diff(frequency)))) + 1]
    found = dataset.stability_change_frequency.values[0]
    assert found == pytest.approx(turns, rel=2e-3)
    assert dataset.stability_change.values[0].tolist() == [1, 1]
    assert dataset.stability_change.attrs["flag_meanings"].split()[1] == "fold"


@pytest.mark.slow
def test_changes_over_two_periods_are_at_frequencies_of_the_excitation():
    """The folds of motions of twice the period, and of a motion that repeats after one and is expanded over two."""
    structure = ss.Structure(np.eye(1), 0.3 * np.eye(1), ("1.x",), C=0.08 * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(1.0), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (spring,), (ss.Force("1.x", 1.2, static=0.6),), ("1.x",), "Duffing")
    band = ss.radians_per_second(0.85, 1.3)
    one, two = (ss.forced_response(problem, band, harmonics=9, periods=periods) for periods in (1, 2))
    branch = one.branch(periods=2).with_stability().dataset
    frequency = branch.frequency.values[0]
    turns = frequency[np.flatnonzero(np.diff(np.sign(np.diff(frequency)))) + 1]
    folds = branch.stability_change_frequency.values[0, branch.stability_change.values[0] == 1]
    assert folds.size > 2
    assert [np.abs(turns / fold - 1.0).min() for fold in folds] == pytest.approx(np.zeros(folds.size), abs=2e-3)
    changes = [each.with_stability().dataset.stability_change_frequency.values[0] for each in (one, two)]
    assert changes[1] == pytest.approx(changes[0], rel=1e-5)


def test_no_change_where_rounding_moves_multipliers_about_the_unit_circle():
    """One mass without damping, held by a slider that sticks: every multiplier lies on the unit circle but for rounding."""
    slider = ss.Contact("slider", ss.Macroslip(kt=0.5, mu=1.0, normal_load=1.0), (ss.between("1.x", "ground"),))
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",))
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 0.4),), ("1.x",))
    result = ss.forced_response(problem, ss.radians_per_second(0.7, 1.6)).with_stability()
    verdict = result.dataset.stability.values
    assert {int(Stability.STABLE), int(Stability.UNDECIDED)} <= set(verdict[verdict > 0])
    assert not np.any(verdict == Stability.UNSTABLE)
    assert not np.any(np.isfinite(result.dataset.stability_change_frequency.values))


def test_undecided_points_between_a_stable_and_an_unstable_one_hide_no_change(duffing):
    """With the points beside both folds undecided, the folds are found still."""
    dataset, near = duffing.dataset, np.zeros(duffing.dataset.sizes["point"], dtype=bool)
    verdict = dataset.stability.values.copy()
    for flip in np.flatnonzero(np.diff(verdict[0])):
        near[flip : flip + 2] = True
    verdict[0, near] = Stability.UNDECIDED
    values = {"stability": verdict, "multiplier": dataset.multiplier.values @ [1.0, 1.0j]}
    solved = SolvedPoints(dataset, duffing.problem)
    changes = stability._changes(dataset, values, 0, solved, stability.StabilityOf(solved.balance, 2.0 * np.pi * 0.5).leading)
    assert [change.kind for change in changes] == [stability.Instability.FOLD] * 2
    assert [change.frequency for change in changes] == pytest.approx(dataset.stability_change_frequency.values[0], rel=1e-6)


def test_many_changes_are_counted_not_listed(duffing):
    many = {name: duffing.dataset[name][:, [0] * 9] for name in ("stability_change", "stability_change_frequency")}
    text = "\n".join(stability_sentences(duffing.dataset.drop_dims("change").assign(many)))
    assert text.count("fold at") == 6
    assert "... (9 in all)" in text


def test_the_size_of_the_multiplier_says_what_the_flag_says(duffing):
    dataset = duffing.dataset
    size = np.hypot(*dataset.multiplier.values[0].T)
    assert np.array_equal(dataset.stability.values[0] == 2, (size > 1.0) & (dataset.stability.values[0] != 3))
    assert {1, 2} <= set(dataset.stability.values[0].tolist())


def test_peaks_say_whether_they_are_stable(duffing):
    assert duffing.peaks()["stability"].iloc[0] == "stable"
    assert tables(duffing.dataset)["peaks"]["stability"].iloc[0] == "stable"


def test_an_unstable_peak_is_said_in_print_and_report(duffing):
    dataset = duffing.dataset.copy()
    assert "unstable" not in str(duffing).split("stability")[0]
    assert "unstable" not in peaks_at_a_glance("a", dataset)
    dataset["stability"] = dataset["stability"].copy(data=np.full_like(dataset["stability"].values, 2))
    assert str(replace(duffing, dataset=dataset)).splitlines()[2].endswith(", unstable")
    assert "unstable; " in peaks_at_a_glance("a", dataset)
    assert any("is an unstable motion" in warning for warning in warnings_of(dataset))


def test_unstable_parts_are_dashed_and_belong_to_the_curve(duffing):
    lines = [
        layer for layer in response_curves(duffing.dataset).panels[0].layers if layer.label == "1 N" and np.size(layer.x) > 1
    ]
    solid, dashed = lines
    assert (solid.style.dash, dashed.style.dash) == ("solid", "dash")
    drawn = np.isfinite(solid.y) | np.isfinite(dashed.y)
    assert drawn.all()
    assert np.count_nonzero(np.isfinite(solid.y) & np.isfinite(dashed.y)) == 2
    assert np.array_equal(np.isfinite(dashed.y)[1:-1], _grown(duffing.dataset.stability.values[0] == 2)[1:-1])


def _grown(flags):
    """Flags with their neighbours."""
    return flags | np.append(flags[1:], False) | np.append(False, flags[:-1])


def test_sentences_name_the_folds_and_the_sliders_that_never_slip(duffing):
    text = "\n".join(sentences(duffing.dataset))
    assert "unstable; fold at" in text
    response = ss.forced_response(rigs.single_mass(), [0.1], harmonics=3).with_stability()
    assert response.dataset.stuck_sliders.values.tolist() == [[1]]
    assert "never slip" in "\n".join(sentences(response.dataset))


def test_results_with_stability_are_kept_in_files(duffing, tmp_path):
    read = xr.load_dataset(duffing.save(tmp_path / "duffing.nc"), engine="h5netcdf")
    assert np.array_equal(read.stability.values, duffing.dataset.stability.values)


def test_soft_mean_springs_leave_the_stability_as_it_is():
    """A wedge that friction alone holds along its axis: its slow return depends on the spring, what is unstable does not."""
    problem, found = wedge_between(), []
    (spring,) = soft_springs(problem)
    for times in (0.1, 1.0):
        held = replace(problem, mean_springs=(replace(spring, stiffness=times * spring.stiffness),))
        found.append(ss.forced_response(held, ss.hertz(4.0, 4.9), 5.0, harmonics=3, samples=128).with_stability().dataset)
    few, more = (np.hypot(*np.moveaxis(dataset.multiplier.values[0], -1, 0)).max() for dataset in found)
    assert few == pytest.approx(more, rel=1e-5)
    assert few > 1.01
    stiff = replace(problem, mean_springs=(replace(spring, stiffness=100.0 * spring.stiffness),))
    with pytest.raises(ss.InputError, match="stiff mean springs act on harmonic 0"):
        ss.forced_response(stiff, [4.2], 1.0, harmonics=3, samples=64).with_stability()


def test_stiff_mean_springs_are_refused():
    problem = rigs.lumped_blisk("R", sectors=4, engine_order=1)
    response = ss.forced_response(problem, [float(problem.frequencies(stuck=True)[0])], harmonics=1, samples=24)
    with pytest.raises(ss.InputError, match="mean springs act on harmonic 0 alone"):
        response.with_stability()


def test_modes_that_follow_at_once_change_the_largest_multiplier_by_what_is_said():
    """A chain of 20 masses on 10 contacts: two modes and the static shapes of the contacts against all modes."""
    response = ss.forced_response(rigs.chain(), [0.012, 0.0125], harmonics=1, samples=64)
    few, whole = response.with_stability().dataset, response.with_stability(float("inf")).dataset
    assert few.attrs["stability_dropped_modes"] > 0 == whole.attrs["stability_dropped_modes"]
    sizes = [np.hypot(*np.moveaxis(dataset.multiplier.values, -1, 0)) for dataset in (few, whole)]
    allowed = few.attrs["stability_mode_error"] + few.multiplier_error.values + whole.multiplier_error.values
    assert np.all(np.abs(sizes[0] - sizes[1]) <= 1.1 * allowed + 1e-9)
    with pytest.raises(ss.InputError, match="highest"):
        response.with_stability(-1.0)


def test_a_study_asks_for_stability_by_a_table(tmp_path):
    text = """[study]
title = "One mass"
analysis = "forced_response"
[structure]
rig = "single_mass"
[stability]
[sweep]
frequency = [0.15, 0.2]
force_levels = [0.5]
harmonics = 3
"""
    (tmp_path / "mass.toml").write_text(text)
    done = CliRunner().invoke(app, ["run", str(tmp_path / "mass.toml"), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert "points stable" in done.output
    (kept,) = (tmp_path / "out").rglob("*.nc")
    assert set(np.unique(xr.load_dataset(kept, engine="h5netcdf").stability.values)) <= {0, 1}


def lightly_damped(ratio, level, harmonics):
    """A mass that meets a stop; stability, and whether the curve goes back in frequency, away from its turns."""
    structure = ss.Structure([[1.0]], [[1.0]], ("1.x",), C=[[2.0 * ratio]])
    stop = ss.Contact("stop", ss.Gap(3.0, gap=1.0), normal=ss.between("1.x", "ground"))
    problem = ss.Problem(structure, (stop,), (ss.Force("1.x", 1.0),), ("1.x",))
    found = ss.forced_response(problem, ss.radians_per_second(0.9, 1.9), level, harmonics=harmonics, samples=256)
    found = found.with_stability()
    solved = found.dataset.outcome.values[0] == ss.Outcome.CONVERGED
    back = np.gradient(found.dataset.frequency.values[0][solved]) < 0.0
    inside = np.ones(back.size, dtype=bool)
    for turn in np.flatnonzero(np.diff(back)):
        inside[max(turn - 1, 0) : turn + 3] = False
    return found, found.dataset.stability.values[0][solved][inside], back[inside]


@pytest.mark.parametrize(
    "ratio", [1e-4, pytest.param(1e-5, marks=pytest.mark.nightly), pytest.param(1e-6, marks=pytest.mark.nightly)]
)
def test_stability_is_decided_however_light_the_damping(ratio):
    """Unstable where the curve goes back in frequency, stable on both sides."""
    _, stability, back = lightly_damped(ratio, 0.5 * ratio, 9)
    assert not back.any()
    assert np.all(stability == Stability.STABLE)
    _, stability, back = lightly_damped(ratio, 10.0 * ratio, 40)
    assert back.any()
    decided = stability != Stability.UNDECIDED
    assert np.mean(decided) > 0.9
    np.testing.assert_array_equal(stability[decided] == Stability.UNSTABLE, back[decided])


def test_multipliers_that_contradict_the_jacobian_are_no_verdict():
    """With few harmonics the motion is not periodic enough for the multipliers of light damping."""
    found, stability, back = lightly_damped(1e-5, 1e-4, 5)
    assert np.any(stability[back] == Stability.UNDECIDED)
    assert not np.any(stability[back] == Stability.STABLE)
    assert not np.any(stability[~back] == Stability.UNSTABLE)
    assert "was not found: take more harmonics" in str(found)
