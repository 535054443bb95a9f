"""The forced response of a finite-element model of which no contact row is kept, against the same model with all its rows."""

from dataclasses import replace

import numpy as np
import pytest
from structure.test_stuck_mesh import KN, KT, beam

import stickslip as ss
from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.problem.meshed import meshed_problem
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.stress import StressRecovery
from stickslip.support.checks import InputError

BAND, LEVELS, MODES_TO = ss.hertz(1200.0, 2800.0), [1.0, 20.0, 60.0], 6e3


def parts(clamped=True):
    """Contacts, forces and outputs of the beam on its pad, pressed by a load on its tip and by preloads."""
    structure, _, tip = beam(clamped)
    pad = ss.NodeSurface.of(structure, "pad", (0.0, 0.0, -1.0))
    law = ss.Macroslip(kt=3.0 * KT, mu=0.3, kn=3.0 * KN, preload=300.0)
    contacts = ss.surface_contacts("pad", law, pad, tangent=(1.0, 0.0, 0.0), balanced=True)
    return structure, contacts, (ss.Force(f"{tip}.y", 1.0, static=20.0),), (f"{tip}.y",)


@pytest.fixture(scope="module")
def whole():
    structure, *others = parts()
    dense = Structure(structure.M, structure.K, structure.dofs, damping=structure.damping, nodes=structure.nodes)
    return ss.forced_response(ss.Problem(dense, *others), BAND, LEVELS, harmonics=3, samples=128)


@pytest.fixture(scope="module")
def meshed():
    return ss.forced_response(meshed_problem(*parts(), modes_to=MODES_TO), BAND, LEVELS, harmonics=3, samples=128)


def highest(response):
    """Frequencies and heights of the highest peaks, (levels,)."""
    data = response.dataset
    best = np.nanargmax(data.peak_amplitude.values[:, :, 0], axis=1)
    return (
        np.array([data[name].values[case, k, 0] for case, k in enumerate(best)]) for name in ("peak_frequency", "peak_amplitude")
    )


def test_peaks_are_those_of_all_rows_and_the_error_is_known(whole, meshed):
    """Contacts that stick and slip; what is left is said with its sign, to a twentieth."""
    slip = whole.dataset.share_slip.max(("point", "contact", "direction")).values
    assert slip[0] == 0.0 < slip[1] < slip[2]
    (hertz, height), (exact, right) = highest(meshed), highest(whole)
    assert meshed.dataset.attrs["coordinates"] < 0.2 * whole.problem.structure.size
    assert hertz == pytest.approx(exact, rel=4e-4)
    assert height == pytest.approx(right, rel=1e-3)
    error = right / height - 1.0
    assert np.abs(error).max() > 5e-5
    assert meshed.dataset.modal_error.values[:, 0] == pytest.approx(error, rel=0.05, abs=5e-8)


def test_shapes_of_the_peaks_take_away_what_those_of_stuck_modes_leave(whole, monkeypatch):
    """With so many modes that these leave nothing: fifty times less at the highest peak, where all contacts slip."""
    problem, (_, right) = meshed_problem(*parts(), modes_to=8e3), highest(whole)
    left = []
    for shapes in (lambda work, progress: work, ForcedResponseWork.with_shapes):
        monkeypatch.setattr(ForcedResponseWork, "with_shapes", shapes)
        _, height = highest(ss.forced_response(problem, BAND, LEVELS[2:], harmonics=3, samples=128))
        left.append(abs(height[0] / right[2] - 1.0))
    assert left[0] > 1e-5
    assert left[1] < 0.1 * left[0]


def test_natural_frequencies_are_those_of_modes_alone(whole):
    """Up to those that are kept, stuck, and up to the highest that is balanced, without contacts."""
    problem = meshed_problem(*parts(), modes_to=MODES_TO)
    for stuck, limit in ((True, MODES_TO), (False, MODES_TO / 3.0)):
        found, right = problem.frequencies(stuck), whole.problem.frequencies(stuck)
        assert found == pytest.approx(right[right <= limit], rel=1e-6)
        assert found.size > 0


@pytest.mark.parametrize("band", [BAND, ss.hertz(700.0, 900.0)])
def test_first_curves_with_the_harmonics_of_the_loads_lead_to_the_shapes_of_all(monkeypatch, band):
    """Around the resonance, and where there is no peak."""
    problem = meshed_problem(*parts(), modes_to=MODES_TO)
    few = ss.forced_response(problem, band, LEVELS[2:], harmonics=3, samples=128)
    monkeypatch.setattr("stickslip.analyses.peak_shapes.with_loaded_harmonics", lambda balance: balance)
    whole = ss.forced_response(problem, band, LEVELS[2:], harmonics=3, samples=128)
    most = [response.dataset.amplitude.max("point").values for response in (few, whole)]
    assert most[0] == pytest.approx(most[1], rel=2e-5)
    assert few.dataset.attrs["coordinates"] <= 1.3 * whole.dataset.attrs["coordinates"]


def test_stress_is_that_on_the_coordinates_of_the_result(tmp_path):
    """Rows of stress go with the coordinates, of which a result has more than the problem it began with and one read anew."""
    structure, *others = parts()
    dofs = structure.dofs[300:312]
    rows = np.random.default_rng(4).standard_normal((1, 6, len(dofs))) * 1e11
    structure = replace(structure, stresses=(StressRecovery(("here",), rows, dofs),))
    dense = {name: getattr(structure, name) for name in ("M", "K", "dofs", "damping", "nodes", "stresses")}
    whole = ss.forced_response(ss.Problem(Structure(**dense), *others), BAND, LEVELS[2:], harmonics=3, samples=128)
    few = ss.forced_response(meshed_problem(structure, *others, modes_to=MODES_TO), BAND, LEVELS[2:], harmonics=3, samples=128)
    anew = ss.ForcedResponse(
        ss.open_results(few.save(tmp_path / "few.nc")), meshed_problem(structure, *others, modes_to=MODES_TO)
    )
    assert anew.problem.structure.size < few.problem.structure.size
    right, made, again = (each.with_stress().dataset for each in (whole, few, anew))
    for name in ("stress_alternating", "stress_mean"):
        largest = [np.abs(each[name]).max("point").values for each in (right, made, again)]
        assert largest[1] == pytest.approx(largest[0], rel=1e-3)
        assert largest[2] == pytest.approx(largest[1], rel=1e-9)
    peak = few.peak_point(0)
    assert anew.stress(0, peak).von_mises.values == pytest.approx(few.stress(0, peak).von_mises.values, rel=1e-9)
    with pytest.raises(InputError, match="must not be given for a problem on few coordinates of a mesh"):
        few.with_stress(few.problem.structure.stresses[0])


def test_results_remember_the_shapes(meshed, tmp_path):
    """A problem that was read anew solves the kept points; without what they remember it does not."""
    kept = ss.open_results(meshed.save(tmp_path / "results.nc"))
    anew = meshed_problem(*parts(), modes_to=MODES_TO)
    point = meshed.peak_point(2)
    motion = SolvedPoints(kept, anew).whole_motion(2, point)
    assert motion == pytest.approx(SolvedPoints(meshed.dataset, meshed.problem).whole_motion(2, point), rel=1e-9, abs=1e-15)
    with pytest.raises(InputError, match="misses the balance"):
        SolvedPoints(kept.drop_vars("shape_force"), anew).evaluation(2, point)


def test_two_processes_and_one_find_the_same(meshed):
    problem = meshed_problem(*parts(), modes_to=MODES_TO)
    both = ss.forced_response(problem, BAND, LEVELS, harmonics=3, samples=128, workers=2)
    assert np.array_equal(both.dataset.peak_amplitude.values, meshed.dataset.peak_amplitude.values, equal_nan=True)
    assert both.dataset.modal_error.values == pytest.approx(meshed.dataset.modal_error.values, abs=1e-9)


def test_other_analyses_refuse_it(meshed):
    for problem in (meshed.problem, meshed_problem(*parts(), modes_to=MODES_TO)):
        with pytest.raises(InputError, match="keep the rows of its contacts"):
            ss.controlled_response(problem, BAND, 1e-6)


def test_performance_curves_and_start_states_know_what_their_shapes_leave(whole, meshed):
    """Peaks at F_C/F_E = 300 N over two levels, and sliders that start elsewhere, against all rows."""
    settings = {"band": BAND, "pull": 300.0, "harmonics": 3, "samples": 128}
    ratios = 300.0 / np.array(LEVELS[:0:-1])
    few, right = (ss.performance_curve(each.problem, ratios, **settings).dataset for each in (meshed, whole))
    assert "modal_error" not in right
    error = (right.amplitude_per_force / few.amplitude_per_force - 1.0).values
    assert np.abs(error).max() > 1e-5
    assert few.modal_error.values == pytest.approx(error, rel=0.05, abs=5e-6)  # peaks are known to some 1e-6
    starts = np.random.default_rng(2).uniform(-1.0, 1.0, (1, 2 * len(whole.problem.contacts)))
    at = [float(few.frequency[0, 1])]
    few, right = (
        ss.response_samples(each.problem, at, LEVELS[1], starts=starts, share="direction", harmonics=3, samples=128).dataset
        for each in (meshed, whole)
    )
    error = (right.amplitude / few.amplitude - 1.0).values.ravel()
    assert np.abs(error).max() > 1e-5
    assert few.modal_error.values.ravel() == pytest.approx(error, rel=0.1, abs=2e-7)


def test_curves_are_solved_again_with_the_shapes_of_their_own_forces(monkeypatch):
    """Where the first solutions have none, and an error of 1e-4 is not allowed: 30 times as stiff contacts."""
    monkeypatch.setattr("stickslip.analyses.truncation.ALLOWED", 1e-4)
    structure, contacts, *others = parts()
    stiff = [replace(each, law=replace(each.law, kt=30.0 * each.law.kt, kn=30.0 * each.law.kn)) for each in contacts]
    problem = meshed_problem(structure, stiff, *others, modes_to=4.0 * MODES_TO)
    monkeypatch.setattr(ForcedResponseWork, "with_shapes", lambda work, progress: work)
    settled = ss.forced_response(problem, BAND, LEVELS[2:], harmonics=3, samples=128)
    monkeypatch.setattr(ForcedResponseWork, "settled", lambda work, curves, *others: (work, curves))
    first = ss.forced_response(problem, BAND, LEVELS[2:], harmonics=3, samples=128)
    errors = [float(each.dataset.modal_error[0, 0]) for each in (first, settled)]
    heights = [float(each.dataset.peak_amplitude.max()) for each in (first, settled)]
    assert abs(errors[0]) > 1e-4
    assert abs(errors[1]) < 0.1 * abs(errors[0])
    assert heights[1] / heights[0] - 1.0 == pytest.approx(errors[0], rel=0.1)
    assert settled.dataset.attrs["coordinates"] > first.dataset.attrs["coordinates"]
