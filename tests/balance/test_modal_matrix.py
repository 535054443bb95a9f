"""Newton's linear system on the states of the structure against the one on the unknowns of λ: one solution to rounding."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from balance.problems import everything
from balance.test_linear_part import CASES as DAMPINGS
from balance.test_linear_part import critically_damped

from bench.plate import plate
from stickslip.model.contact.protocol import HELD
from stickslip.model.rigs import chain_varying_load, lumped_blisk, three_mass_wedge
from stickslip.solve.balance.balance import HarmonicBalance, PathCondition
from stickslip.solve.balance.newton_parts import compile_parts
from stickslip.solve.balance.system import ON_FORCES, ON_STATES, Control
from stickslip.solve.continuation.branch_points import _spectrum
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import relative_metric
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.sensitivity import respond, solved_factors, weights_of_contact_forces

TIGHT = 1e-10

CASES = {
    "everything": (everything(), 0.9, 1.0),
    "undamped": (DAMPINGS["undamped"], 0.9, 1.0),
    "general damping": (DAMPINGS["general"], 0.9, 1.5),
    "gyroscopic": (DAMPINGS["gyroscopic"], 0.9, 1.5),
    "critical damping": (critically_damped(), 0.9, 1.5),
    "massless": (DAMPINGS["massless, general"], 0.9, 1.5),
    "held mean": (DAMPINGS["held mean"], 0.9, 1.0),
    "loads by the frequency": (DAMPINGS["loads by the frequency"], 0.9, 1.0),
    "wedge": (three_mass_wedge(0.3), 2 * np.pi * 222.0, 1.0),
    "chain": (chain_varying_load(), 0.2419, 1.0),
    "disk": (lumped_blisk(), 935.0, 1.0),
    "friction disc": (plate(12, 12, "friction disc"), 1.15, 1.0),
    "macroslip": (plate(12, 12, "macroslip"), 1.15, 1.0),
}


def solved_on(balance: HarmonicBalance, form: int) -> HarmonicBalance:
    """The same balance with Newton's linear system on the states, or on the unknowns of λ."""
    other = copy(balance)
    other.system = balance.system._replace(form=form)
    compile_parts(other.system)
    return other


def both(balance: HarmonicBalance) -> list[HarmonicBalance]:
    return [solved_on(balance, form) for form in (ON_FORCES, ON_STATES)]


def assert_close(found, expected, tight: float = TIGHT) -> None:
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=tight * np.abs(expected).max(initial=1e-300))


def conditions(evaluation, omega: float) -> list[PathCondition]:
    weight = np.random.default_rng(3).standard_normal(evaluation.w.shape) / np.abs(evaluation.w).max()
    planes = [PathCondition(parameter, weight, 0.3, 0.1) for parameter in ("omega", "level")]
    return [fixed("omega", omega), fixed("level", 1.0), *planes]


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("name", CASES)
def test_steps_directions_and_determinants_are_the_same(name, held):
    """Four of Newton's iterates from the stuck state, for given frequency, level and arc length; with a held amplitude, too."""
    problem, omega, level = CASES[name]
    balance = HarmonicBalance(problem, 3, 48)
    if held:
        balance = balance.holding(Control(balance.rows, 0, 1.1))
    pair, point = both(balance), balance.stuck_point(omega, level)
    for _ in range(4):
        evaluation = balance.evaluate(point)
        for condition in conditions(evaluation, omega):
            if held and condition.parameter == "level":
                continue
            forces, states = (one.factorise(evaluation, condition) for one in pair)
            assert states.bordered.columns.size == (1 + held) * forces.size
            assert (states.size, states.rows) == (forces.size, forces.rows)
            assert states.orientation == forces.orientation
            logarithms = [np.sum(np.log(np.abs(one.pivots))) for one in (forces, states)]
            assert logarithms[0] == pytest.approx(logarithms[1], abs=1e-8)
            steps = [one.newton_step(evaluation, condition, found) for one, found in zip(pair, (forces, states), strict=True)]
            assert_close(steps[1][0], steps[0][0])
            assert_close(steps[1][1], np.array(steps[0][1]))
            along = [
                one.tangent(evaluation, condition.parameter, found) for one, found in zip(pair, (forces, states), strict=True)
            ]
            for found, expected in zip(along[1], along[0], strict=True):
                assert_close(found, np.asarray(expected))
            right = np.random.default_rng(4).standard_normal((2, forces.rows))
            assert_close(states.solve_many(right), forces.solve_many(right))
            assert_close(states.solve_transposed(right), forces.solve_transposed(right))
        point = correct(pair[0], point, fixed("omega", omega), iterations=1, halvings=8).evaluation.point
    assert np.any(evaluation.unknown != HELD)


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("name", CASES)
def test_weights_of_contact_forces_are_the_transpose_of_responses(name, held):
    """Weighted sums of the changes of λ and w by any changes of λ̂, with either matrix and without symmetry."""
    problem, omega, level = CASES[name]
    balance = HarmonicBalance(problem, 3, 48)
    if held:
        balance = balance.holding(Control(balance.rows, 0, 1.1))
    evaluation = correct(balance, balance.stuck_point(omega, level), fixed("omega", omega), iterations=3).evaluation
    rng = np.random.default_rng(5)
    forces, motion = rng.standard_normal(evaluation.residual.shape), rng.standard_normal(evaluation.w.shape)
    changes = rng.standard_normal((3, *evaluation.residual.shape))
    for one in both(balance):
        factors = solved_factors(one, evaluation)
        change = respond(one, evaluation, factors, changes)
        expected = np.einsum("kij,ij->k", change.forces, forces) + np.einsum("kij,ij->k", change.motion, motion)
        weights = weights_of_contact_forces(one, evaluation, factors, forces, motion)
        assert_close(np.einsum("kij,ij->k", changes, weights), expected)


def test_a_transposed_solution_solves_the_transposed_system():
    balance = solved_on(HarmonicBalance(everything(), 3, 48), ON_STATES)
    evaluation = balance.evaluate(balance.stuck_point(0.9, 1.0))
    factors = balance.factorise(evaluation, conditions(evaluation, 0.9)[2])
    inverse = factors.solve_many(np.eye(factors.rows)).T
    np.testing.assert_allclose(factors.solve_transposed(np.eye(factors.rows)), inverse, atol=1e-11 * np.abs(inverse).max())


@pytest.mark.parametrize("name", ["friction disc", "macroslip", "everything", "general damping", "disk"])
def test_curves_are_the_same(name):
    """Traced once on the states; at frequencies between their points both find the same motion."""
    problem, omega, level = CASES[name]
    balance = HarmonicBalance(problem, 3, 48)
    forces, states = both(balance)
    first = first_point(states, 0.95 * omega, level)
    points = list(trace(states, first, "omega", 1.05 * omega))
    assert len(points) > 3
    for point in points[:: max(len(points) // 4, 1)]:
        start = replace(point.point, forces=0.999 * point.point.forces)
        found = [correct(one, start, fixed("omega", start.omega), iterations=30, halvings=8) for one in (forces, states)]
        assert all(each.converged for each in found)
        assert_close(found[1].evaluation.w, found[0].evaluation.w)
        assert_close(found[0].evaluation.w, point.evaluation.w)


def test_singular_values_are_the_same():
    """What branch points are found by."""
    balance = HarmonicBalance(CASES["friction disc"][0], 3, 48)
    solved = correct(balance, balance.stuck_point(1.15, 1.0), fixed("omega", 1.15), iterations=30, halvings=8).evaluation
    metric = relative_metric(solved.w, balance.rows, (1.0, 1.0), 1.0)
    plane = conditions(solved, 1.15)[2]
    values = [_spectrum(one, solved, plane, metric).values for one in both(balance)]
    np.testing.assert_allclose(values[0], values[1], rtol=1e-8)


@pytest.mark.parametrize(("nodes", "on_states"), [(2, False), (32, True)])
def test_the_smaller_system_is_chosen(nodes, on_states):
    """12 modes with 3 directions a node: at most 6 directions slip, or 96."""
    balance = HarmonicBalance(plate(nodes, 12, "macroslip"), 3, 48)
    evaluation = balance.evaluate(balance.stuck_point(1.15, 1.0))
    factors = balance.factorise(evaluation, fixed("omega", 1.15))
    assert bool(factors.bordered.columns.size) == on_states
    assert factors.pivots.size == (12 * 7 if on_states else factors.size) + 1


@pytest.mark.parametrize("name", ["undamped", "general damping", "gyroscopic", "critical damping"])
def test_complex_modes_take_no_more_rows_than_real_ones(name):
    """Six degrees of freedom, twice as many states where C couples the modes; 7 columns."""
    problem, omega, level = CASES[name]
    balance = solved_on(HarmonicBalance(problem, 3, 48), ON_STATES)
    evaluation = balance.evaluate(balance.stuck_point(omega, level))
    assert balance.system.modes.kind.size == (6 if name == "undamped" else 12)
    assert balance.factorise(evaluation, fixed("omega", omega)).pivots.size == 6 * 7 + 1


def work(nodes: int) -> tuple[int, float, int, int]:
    """Unknowns, and of a factorisation multiplications, numbers kept and the rows of the matrix."""
    balance = HarmonicBalance(plate(nodes, 12, "friction disc"), 3, 48)
    evaluation = balance.evaluate(balance.stuck_point(1.15, 1.0))
    before = balance.system.effort[2]
    bordered = balance.factorise(evaluation, fixed("omega", 1.15)).bordered
    kept = sum(part.size for part in bordered if isinstance(part, np.ndarray))
    return int(bordered.offsets[-1]), float(balance.system.effort[2] - before), kept, bordered.lu.shape[0]


def test_work_and_memory_grow_linearly_with_the_contacts():
    """The matrix stays as it is; what is multiplied and kept for each unknown does too."""
    unknowns, multiplications, kept, sizes = (np.array(part) for part in zip(*(work(n) for n in (40, 80, 160)), strict=True))
    assert set(sizes) == {12 * 7 + 1}
    assert unknowns[2] > 1.9 * unknowns[1] > 3.6 * unknowns[0]
    np.testing.assert_allclose(np.diff(multiplications) / np.diff(unknowns), (12 * 7) * 12, rtol=1e-12)
    assert np.ptp(np.diff(kept) / np.diff(unknowns)) < 0.1 * np.mean(np.diff(kept) / np.diff(unknowns))
