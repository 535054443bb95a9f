"""Curves at frequencies of the user's choice: against curves solved exactly there, closed forms, and a finer continuation."""

import numpy as np
import pytest
import xarray as xr

import stickslip as ss
from robustness.problems import random_case
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.curves.curve import refined, solve_curve
from stickslip.support.outcome import Outcome

RIGS = {
    "one mass": (ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0), 0.5, 7),
    "chain": (ss.rigs.chain(), ss.radians_per_second(0.05, 0.35), 1.0, 7),
    "wedge": (ss.rigs.three_mass_wedge(), ss.hertz(145, 235), 0.5, 5),
}


def grid(band: ss.Band, points: int = 200) -> np.ndarray:
    return np.linspace(band.start, band.stop, points)


@pytest.mark.parametrize("name", RIGS)
def test_values_are_within_the_tolerance_of_solved_ones_and_most_are_interpolated(name):
    problem, band, level, harmonics = RIGS[name]
    at = ss.forced_response(problem, band, force=level, harmonics=harmonics).at(grid(band))
    exact = ss.forced_response(problem, list(grid(band)), force=level, harmonics=harmonics).dataset
    assert at.sizes["branch"] == 1
    assert (at["outcome"] == Outcome.CONVERGED).all()
    difference = np.abs(at["response"].values[0, 0] - exact["response"].values[0])
    whole = np.sqrt(np.sum(difference**2, axis=(2, 3)))
    error = np.max(whole / exact["amplitude"].values[0], axis=1)
    errors = np.where(at["solved"][0, 0] == 1, 1e-9, at["error"].values[0, 0])
    assert np.all(errors <= 1e-3)
    assert np.all(error <= errors + 1e-9)
    assert np.max(error) > 1e-5  # nothing was interpolated to no purpose
    assert np.mean(at["solved"]) < 0.12


def test_an_overhanging_curve_has_a_value_on_every_branch():
    """Duffing, one harmonic: ((1 − ω² + 3/4 k3 a²)² + c²ω²) a² = F², a cubic in a² with one or three solutions."""
    k3, c, F = 0.5, 0.04, 0.1
    ground = ss.between("1.x", "ground")
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=c * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(k3), (ground,))
    problem = ss.Problem(structure, (spring,), (ss.Force("1.x", F),), ("1.x",))
    at = ss.forced_response(problem, ss.radians_per_second(0.6, 2.0), harmonics=1).at(grid(ss.radians_per_second(0.6, 2.0)))
    assert at.sizes["branch"] == 3
    for i, omega in enumerate(2.0 * np.pi * at["frequency"].values):
        beside = 1.0 - omega**2
        squares = np.roots([(0.75 * k3) ** 2, 1.5 * k3 * beside, beside**2 + (c * omega) ** 2, -(F**2)])
        closed = np.sort(np.sqrt(squares.real[np.abs(squares.imag) < 1e-9]))
        there = at["outcome"].values[0, :, i] == Outcome.CONVERGED
        np.testing.assert_allclose(np.sort(at["amplitude"].values[0, there, i, 0]), closed, rtol=1e-3)
    assert np.mean(at["solved"].values[at["outcome"].values == Outcome.CONVERGED]) < 0.1
    assert at["amplitude"].max("branch").shape == (1, 200, 1)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "seed"), [("lift-off", 3), pytest.param("varying load", 3, marks=pytest.mark.nightly)])
def test_curves_with_lift_off_kinks_and_folds_pass_each_frequency_as_often_as_a_finer_continuation(kind, seed):
    case = random_case(kind, seed)
    wanted = grid(case.band)
    response = ss.forced_response(case.problem, case.band, force=case.level)
    at = response.at(wanted)
    assert response.dataset["share_open"].max() > 0.1 or kind != "lift-off"
    balance, ends = HarmonicBalance(case.problem, 5, 256), [2.0 * np.pi * f for f in (case.band.start, case.band.stop)]
    control = StepControl(largest=0.1, error=0.003)
    curve = refined(balance, solve_curve(balance, ends, case.level, exactly=False, control=control), tolerance=2e-4)
    omegas = np.array([point.point.omega for point in curve.points])
    amplitudes = np.array([np.hypot(*point.evaluation.w[balance.rows, 1:3]) for point in curve.points])
    assert at.sizes["branch"] > 1
    for i, omega in enumerate(2.0 * np.pi * wanted[1:-1], start=1):
        passed = np.flatnonzero((omegas[:-1] - omega) * (omegas[1:] - omega) < 0.0)
        there = at["outcome"].values[0, :, i] == Outcome.CONVERGED
        assert there.sum() == passed.size, omega
        share = (omega - omegas[passed]) / (omegas[passed + 1] - omegas[passed])
        fine = (1.0 - share) * amplitudes[passed] + share * amplitudes[passed + 1]
        np.testing.assert_allclose(at["amplitude"].values[0, there, i, 0], fine, rtol=1.5e-3)


def test_a_smaller_tolerance_is_met_by_more_solutions():
    problem, band, level, harmonics = RIGS["one mass"]
    response = ss.forced_response(problem, band, force=level, harmonics=harmonics)
    loose, tight = (response.at(grid(band, 60), tolerance) for tolerance in (1e-2, 1e-6))
    assert loose["solved"].sum() < tight["solved"].sum()
    np.testing.assert_allclose(loose["amplitude"], tight["amplitude"], rtol=1e-2)
    assert float(tight["error"].max()) <= 1e-6


def test_solved_points_are_given_back_and_ends_of_the_band_met_whatever_the_rounding():
    response = ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0), force=[0.1, 1.0])
    known = response.dataset["frequency"].values[1]
    at = response.at(known[~np.isnan(known)] * (1.0 + 2e-16))
    assert (at["solved"][1] == 1).all()
    np.testing.assert_allclose(at["amplitude"][1, 0], response.dataset["amplitude"][1, : at.sizes["frequency"]], rtol=1e-9)
    assert (at["outcome"] == Outcome.CONVERGED).all()


def test_beyond_the_end_of_a_lost_curve_stands_its_outcome():
    response = ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0), force=[0.1, 1.0])
    dataset = response.dataset.copy(deep=True)
    dataset["outcome"][1, 5:], dataset["case_outcome"][1] = Outcome.EMPTY, Outcome.NOT_CONVERGED
    lost = float(dataset["frequency"][1, 4])
    at = ss.ForcedResponse(dataset, response.problem).at([0.99 * lost, 1.01 * lost])
    assert at["outcome"].values[:, 0].tolist() == [[1, 1], [1, Outcome.NOT_CONVERGED]]
    assert np.isnan(at["amplitude"].values[1, 0, 1]).all()


def test_the_result_is_labelled_saved_and_converted_like_others(tmp_path):
    response = ss.forced_response(ss.rigs.three_mass_wedge(), ss.hertz(145, 235), force=0.5)
    at = response.at([150.0, 160.0])
    for variable in at.data_vars.values():
        assert variable.attrs["units"]
        assert variable.attrs["long_name"]
    velocity = ss.as_quantity(at, "velocity")["amplitude"]
    np.testing.assert_allclose(velocity[0, 0], at["amplitude"][0, 0] * 2.0 * np.pi * at["frequency"].values[:, None])
    kept = ss.open_results(ss.ForcedResponse(at, response.problem).save(tmp_path / "at.nc"))
    xr.testing.assert_allclose(kept["amplitude"], at["amplitude"])


@pytest.mark.parametrize(
    ("frequencies", "tolerance", "words"),
    [
        ([400.0], 1e-3, "must lie in the band of the response, from 145 to 235 Hz, but is 400"),
        ([], 1e-3, "must hold at least one value"),
        ([-1.0], 1e-3, "A frequency must be positive"),
        ("fast", 1e-3, "frequencies must hold numbers"),
        ([150.0], 0.0, "tolerance must be positive"),
        ([150.0], 0.5, "tolerance must lie between 0 and 0.1"),
    ],
)
def test_wrong_input_is_refused(frequencies, tolerance, words):
    response = ss.forced_response(ss.rigs.three_mass_wedge(), ss.hertz(145, 235), force=0.5, harmonics=1)
    with pytest.raises(ss.InputError, match=words):
        response.at(frequencies, tolerance)
