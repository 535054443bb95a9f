"""Only what slips is unknown: the eliminated Newton system against the full one, its size, and the balance it solves."""

import numpy as np
import pytest
from balance.full_balance import (
    balance_residual,
    differenced_matrix,
    full_matrix,
    full_newton_step,
    marched_forces,
    unknowns_by_theory,
)
from balance.problems import everything

from stickslip.model.contact.point import MeanTraction, SliderOffset, TractionRatio
from stickslip.model.contact.protocol import HELD, SLIPPING, STATIC
from stickslip.model.problem import Problem
from stickslip.model.rigs import chain_varying_load, single_blade, three_mass_wedge
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.newton import correct, fixed

NONSYMMETRIC = 0.05 * np.eye(6) + 0.03 * np.triu(np.ones((6, 6)), 1)
CASES = {
    "everything": (everything(), 0.9, 1.0),
    "everything, virgin": (everything(SliderOffset()), 1.3, 2.0),
    "everything, ratio": (everything(TractionRatio(0.5)), 0.7, 0.6),
    "everything, mean": (everything(MeanTraction(0.1)), 1.1, 1.0),
    "everything, general damping": (everything(C=NONSYMMETRIC), 0.9, 1.5),
    "wedge": (three_mass_wedge(0.3), 2 * np.pi * 222.0, 1.0),
    "wedge, virgin": (three_mass_wedge(SliderOffset()), 2 * np.pi * 170.0, 1.0),
    "chain": (chain_varying_load(), 0.2419, 1.0),
}


def setting(name: str, harmonics: int = 4, samples: int = 64):
    problem, omega, level = CASES[name]
    balance = HarmonicBalance(problem, harmonics, samples)
    return balance, balance.stuck_point(omega, level), fixed("omega", omega)


@pytest.mark.parametrize("name", CASES)
def test_newton_iterates_are_those_of_the_full_system(name):
    """Six plain Newton steps from the stuck state, each from the eliminated and from the full system: the same to 1e-10."""
    balance, point, condition = setting(name)
    sizes = set()
    for _ in range(6):
        evaluation = balance.evaluate(point)
        factors = balance.factorise(evaluation, condition)
        change, amount = balance.newton_step(evaluation, condition, factors)
        full = full_newton_step(balance, evaluation)
        np.testing.assert_allclose(change, full, atol=1e-10 * np.abs(full).max())
        assert amount == pytest.approx(0.0, abs=1e-14)
        point = point.moved(change, "omega", 0.0)
        sizes.add(factors.size)
    assert max(sizes) > 0


@pytest.mark.parametrize("name", CASES)
def test_full_matrix_is_the_derivative_of_the_residual(name):
    balance, point, condition = setting(name, harmonics=2, samples=32)
    point = correct(balance, point, condition, iterations=3).evaluation.point
    evaluation = balance.evaluate(point)
    exact = full_matrix(balance, evaluation)
    step = 1e-7 * max(np.abs(point.forces).max(), 1e-3)
    differenced = differenced_matrix(balance, point, step)
    np.testing.assert_allclose(exact, differenced, atol=1e-5 * np.abs(exact).max())


@pytest.mark.parametrize("name", CASES)
def test_solution_satisfies_the_equations_of_motion(name):
    """Contact forces marched element by element in plain Python, inserted into M q̈ + C q̇ + K q + Bᵀf = p."""
    balance, point, condition = setting(name)
    solved = correct(balance, point, condition, iterations=60, halvings=12)
    assert solved.converged
    assert balance_residual(balance, solved.evaluation.point) < 1e-8


@pytest.mark.parametrize("name", CASES)
def test_solution_of_the_full_system_is_the_same(name):
    balance, point, condition = setting(name)
    solved = correct(balance, point, condition, iterations=60, halvings=12).evaluation
    disturbed = solved.point.moved(1e-6 * np.abs(solved.point.forces).max() * np.cos(solved.point.forces), "omega", 0.0)
    for _ in range(8):
        disturbed = disturbed.moved(full_newton_step(balance, balance.evaluate(disturbed)), "omega", 0.0)
    scale = np.abs(balance.carried_forces(solved)).max()
    np.testing.assert_allclose(disturbed.forces, solved.point.forces, atol=1e-10 * scale)
    np.testing.assert_allclose(balance.evaluate(disturbed).w, solved.w, atol=1e-10 * np.abs(solved.w).max())


@pytest.mark.parametrize("name", CASES)
def test_size_of_the_newton_system(name):
    """2H+1 per direction that slips or opens, one per direction clipped or tied to a ratio or mean; states found by marching."""
    balance, point, condition = setting(name)
    evaluation = correct(balance, point, condition, iterations=60, halvings=12).evaluation
    size = balance.factorise(evaluation, condition).size
    assert size == unknowns_by_theory(balance.problem, evaluation.w[: balance.rows], 64)


def test_the_cases_hold_every_state():
    found = set()
    for name in CASES:
        balance, point, condition = setting(name)
        found |= set(correct(balance, point, condition, iterations=60, halvings=12).evaluation.unknown)
    assert found == {HELD, STATIC, SLIPPING}


@pytest.fixture(scope="module")
def rig() -> Problem:
    return single_blade(4.6)


@pytest.mark.parametrize(("level", "frequency"), [(20.0, 543.0), (80.0, 528.0)])
def test_the_single_blade(rig, level, frequency):
    """48 rows of 11 harmonics: size, iterates, solution and equations of motion at the resonance, 528 full unknowns."""
    balance = HarmonicBalance(rig, 5, 256)
    condition = fixed("omega", 2.0 * np.pi * frequency)
    solved = correct(balance, balance.stuck_point(2.0 * np.pi * frequency, level), condition, iterations=60, halvings=12)
    assert solved.converged
    evaluation = solved.evaluation
    size = balance.factorise(evaluation, condition).size
    assert size == unknowns_by_theory(rig, evaluation.w[:48], 256)
    assert 0 < size < 400 < full_matrix(balance, evaluation).shape[0]
    away = evaluation.point.moved(1e-3 * evaluation.point.forces, "omega", 0.0)
    disturbed = balance.evaluate(away)
    change, _ = balance.newton_step(disturbed, condition, balance.factorise(disturbed, condition))
    full = full_newton_step(balance, disturbed)
    np.testing.assert_allclose(change, full, atol=1e-10 * np.abs(full).max())
    carried = balance.carried_forces(evaluation)
    marched = marched_forces(rig, evaluation.w[:48], 256)
    np.testing.assert_allclose(marched, carried, atol=1e-8 * np.abs(carried).max())
