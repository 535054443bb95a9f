"""Responses at listed frequencies: the order that was given, upwards and downwards, and starts that are hard to have."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.curves import curve
from stickslip.solve.curves.curve import _monotonic_runs, solve_curve

UP = np.linspace(0.15, 0.35, 12)


def duffing():
    """x'' + 0.02 x' + x + x³ = 0.05 cos ωt: its resonance overhangs from 0.22 to 0.28 Hz."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=0.02 * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(1.0), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",))


def amplitudes(problem, frequencies, force=0.05):
    dataset = ss.forced_response(problem, list(frequencies), force=force).dataset
    np.testing.assert_array_equal(dataset.frequency.values[0], frequencies)
    return dataset.amplitude.values[0, :, 0]


@pytest.mark.parametrize("order", [(0.25, 0.2, 0.15, 0.1), (0.1, 0.2, 0.3, 0.25, 0.15), (0.2, 0.1, 0.15)])
def test_points_come_in_the_order_of_the_list(order):
    problem = ss.rigs.single_mass()
    known = dict(zip(sorted(order), amplitudes(problem, sorted(order), 0.5), strict=True))
    np.testing.assert_allclose(amplitudes(problem, order, 0.5), [known[f] for f in order], rtol=1e-9)


def test_a_list_up_and_down_shows_the_jumps_of_an_overhang():
    """Upwards on the upper branch until it ends, downwards on the lower one: between 0.17 and 0.26 Hz they differ."""
    both = amplitudes(duffing(), [*UP, *(UP[::-1][1:] + 1e-6)])
    up, down = both[: UP.size], both[UP.size - 1 :][::-1]
    np.testing.assert_allclose(amplitudes(duffing(), UP[::-1])[::-1], down, rtol=1e-3)
    apart = np.abs(up / down - 1.0) > 0.1
    np.testing.assert_array_equal(np.flatnonzero(apart), np.arange(2, 7))
    assert np.all(up[apart] > 3.0 * down[apart])


@pytest.mark.parametrize("first", [0.2, 0.22, 0.24, 0.26])
def test_a_list_that_begins_inside_an_overhang_is_answered_whole(first):
    dataset = ss.forced_response(duffing(), [first, *UP[first + 1e-3 < UP]], force=0.05).dataset
    assert dataset.case_outcome.values[0] == ss.Outcome.CONVERGED
    assert np.isfinite(dataset.amplitude.values[0, :, 0]).all()


def test_what_the_curve_does_not_reach_is_solved_by_itself_and_the_rest_keeps_its_place(monkeypatch):
    balance = HarmonicBalance(ss.rigs.single_mass(), 3, 64)
    listed = [0.8, 1.0, 1.2, 1.4]
    whole = solve_curve(balance, listed, 0.5, exactly=True)
    monkeypatch.setattr(curve, "points_at", lambda balance, points, wanted: {})
    alone = solve_curve(balance, listed, 0.5, exactly=True)
    assert "4 of 4 frequencies were solved by themselves" in alone.message
    for one, other in zip(whole.points, alone.points, strict=True):
        np.testing.assert_allclose(one.evaluation.w, other.evaluation.w, atol=1e-9)
    solved = curve._alone
    monkeypatch.setattr(curve, "_alone", lambda balance, omega, level: None if omega == 1.0 else solved(balance, omega, level))
    gap = solve_curve(balance, listed, 0.5, exactly=True)
    assert gap.missing == ((1, 1.0),)
    assert gap.outcome == ss.Outcome.NOT_CONVERGED
    assert "1 of 4 frequencies could not be solved, the first at 0.159155 Hz" in gap.message
    dataset = ss.forced_response(ss.rigs.single_mass(), [f / (2.0 * np.pi) for f in listed], 0.5, 3, 64).dataset
    np.testing.assert_allclose(2.0 * np.pi * dataset.frequency.values[0], listed)
    np.testing.assert_array_equal(np.isfinite(dataset.amplitude.values[0, :, 0]), [True, False, True, True])
    assert dataset.outcome.values[0, 1] == ss.Outcome.NOT_CONVERGED


def test_runs_go_one_way_each_and_share_their_ends():
    assert _monotonic_runs([1.0]) == [[0]]
    assert _monotonic_runs([1.0, 2.0, 3.0]) == [[0, 1, 2]]
    assert _monotonic_runs([1.0, 3.0, 2.0, 1.5, 4.0]) == [[0, 1], [1, 2, 3], [3, 4]]
