"""Verdicts over contact stiffness and number of harmonics: drawn masses on sliders and springs, 300 in all.

Under constant loads no motion is unstable, by the theorem. Where loads vary, the multipliers of the orbit are compared with those
of SciPy's integration from event to event.
"""

import numpy as np
import pytest
from stability.hybrid import of_problem

import stickslip as ss
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.contact.protocol import STICK
from stickslip.solve.stability.event_march import EventMarch
from stickslip.solve.stability.judge import MOST_COORDINATES, Judge, OrbitSearch
from stickslip.solve.stability.multipliers import Stability

STABLE, UNSTABLE, UNDECIDED = Stability.STABLE, Stability.UNSTABLE, Stability.UNDECIDED


def constant_loads(rng):
    """One or two masses, one or two sliders, kt/k from 1 to 1e5."""
    n = int(rng.integers(1, 3))
    K = np.diag(rng.uniform(1.0, 3.0, n)) - 0.5 * (np.ones((n, n)) - np.eye(n))
    dofs = tuple(f"{i}.x" for i in range(n))
    contacts = tuple(
        ss.Contact(
            f"c{i}",
            ss.Macroslip(kt=float(10.0 ** rng.uniform(0.0, 5.0)), mu=1.0, normal_load=float(rng.uniform(0.1, 1.0))),
            ({dof: 1.0},),
        )
        for i, dof in enumerate(dofs[: int(rng.integers(1, n + 1))])
    )
    structure = ss.Structure(np.diag(rng.uniform(0.5, 2.0, n)), K, dofs, C=float(10.0 ** rng.uniform(-2.5, -1.0)) * np.eye(n))
    return ss.Problem(structure, contacts, (ss.Force(dofs[0], 1.0),), dofs)


def loads_that_vary(rng):
    """A mass in the plane on a contact that may lift off, kt/k from 1 to 1e3."""
    K = np.array([[1.0, 0.1], [0.1, float(rng.uniform(1.0, 2.0))]])
    structure = ss.Structure(np.eye(2), K, ("1.x", "1.y"), C=float(rng.uniform(0.01, 0.1)) * np.eye(2))
    kt = float(10.0 ** rng.uniform(0.0, 3.0))
    law = ss.Macroslip(kt, float(rng.uniform(0.1, 0.6)), kt * float(rng.uniform(0.5, 2.0)), float(rng.uniform(0.2, 2.0)))
    contact = ss.Contact("c", law, (ss.between("1.x", "ground"),), ss.between("1.y", "ground"))
    forces = (ss.Force("1.x", 1.0), ss.Force("1.y", float(rng.uniform(0.2, 1.0)) * 1j))
    return ss.Problem(structure, (contact,), forces, ("1.x",))


def solved(problem, rng):
    """The solution of a listed frequency, of 3 to 21 harmonics; None where there is none."""
    frequency, harmonics = float(rng.uniform(0.6, 1.6)) / (2.0 * np.pi), int(rng.choice([3, 5, 11, 21]))
    try:
        found = ss.forced_response(problem, [frequency], harmonics=harmonics, samples=1024)
    except ss.InputError:
        return None
    if int(found.dataset["outcome"].values[0, 0]) != ss.Outcome.CONVERGED:
        return None
    points = SolvedPoints(found.dataset, problem)
    return points.balance, points.evaluation(0, 0)


@pytest.mark.parametrize("half", [pytest.param(0, marks=pytest.mark.slow), pytest.param(1, marks=pytest.mark.nightly)])
def test_no_motion_under_constant_loads_is_unstable(half):
    """All are decided; and the multipliers of the march say the same, without the theorem."""
    count = 0
    for seed in range(half, 200, 2):
        rng = np.random.default_rng([31, seed])
        point = solved(constant_loads(rng), rng)
        if point is None:
            continue
        balance, evaluation = point
        verdict = Judge(balance, evaluation.point.omega, numbers=True).verdict(evaluation)
        assert verdict.stability == STABLE, seed
        assert np.isnan(verdict.multiplier) or abs(verdict.multiplier) < 1.0 + 1e-9, seed
        count += np.isfinite(verdict.multiplier)
    assert count >= 70


@pytest.mark.parametrize(
    "part", [pytest.param(0, marks=pytest.mark.slow), *(pytest.param(part, marks=pytest.mark.nightly) for part in (1, 2, 3))]
)
def test_multipliers_where_loads_vary_are_those_of_integration_from_event_to_event(part):
    decided, all_of_them = 0, 0
    for seed in range(part, 100, 4):
        rng = np.random.default_rng([32, seed])
        problem = loads_that_vary(rng)
        point = solved(problem, rng)
        if point is None:
            continue
        balance, evaluation = point
        omega = evaluation.point.omega
        verdict = Judge(balance, omega).verdict(evaluation)
        all_of_them += 1
        if verdict.stability not in (STABLE, UNSTABLE):
            assert any(character.isdigit() for character in verdict.reason) or "no periodic motion" in verdict.reason, seed
            continue
        decided += 1
        march = EventMarch(problem, np.inf, MOST_COORDINATES, omega)
        orbit = OrbitSearch(march, balance).beside(evaluation)
        k, (state, y) = march.coordinates.size, march.entry(orbit.begin)
        q, v = march.coordinates.shapes @ orbit.begin.motion[:k], march.coordinates.shapes @ orbit.begin.motion[k:]
        modes = [2 if slider not in (STICK, 1, -1) else int(slider) for slider in state.sliders]
        exact = np.linalg.eigvals(of_problem(problem, 1.0).periodic(np.concatenate([q, v, y]), modes, omega))
        free = np.sort(np.abs(exact))[::-1][orbit.exact_ones :]
        assert abs(verdict.multiplier) == pytest.approx(free[0], abs=5e-4), seed
        assert (free[0] > 1.0) == (verdict.stability == UNSTABLE), seed
    assert decided >= 0.7 * all_of_them
