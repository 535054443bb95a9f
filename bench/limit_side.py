"""Near the limit: what one Newton iteration costs, beside the parts of it that no Python around them could make cheaper.

The parts are repeated inside compiled loops, so that they hold no call from Python, which costs as much as one mass does.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from cases import BY_NAME, HARMONICS, SAMPLES
from channel import Answer
from numba import njit
from problems import problem_of
from scipy.linalg import lapack

from stickslip.model import rigs
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.contact_forces import contact_forces
from stickslip.solve.balance.receptance import driven_states, frequency_gains, motion, receptance
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.continuation.newton import correct
from stickslip.solve.continuation.steps import StepControl
from stickslip.support.kernels.views import view


def parts(request: dict) -> Answer:
    """CPU seconds of one Newton iteration and of its irreducible parts, at the point with the most unknowns of a sweep."""
    if request["case"] == "blade":
        problem, harmonics, level = rigs.single_blade(preload_mass=4.6), request["harmonics"], request["force"]
        low, high = (2.0 * np.pi * frequency for frequency in request["band"])
    else:
        case = BY_NAME[request["case"]]
        problem, harmonics, level, (low, high) = problem_of(case), HARMONICS, case.level, case.band
    balance = HarmonicBalance(problem, harmonics, SAMPLES)
    first = first_point(balance, low, level)
    points = list(trace(balance, first, "omega", high, StepControl()))
    per_point = best_time(lambda: list(trace(balance, first, "omega", high, StepControl()))) / len(points)
    busiest = max(points, key=lambda point: point.active)
    return {
        "points": len(points),
        "per_point": per_point,
        "iterations": float(np.mean([point.iterations for point in points])),
        "active": busiest.active,
        **_timed(balance, busiest),
    }


def _timed(balance: HarmonicBalance, point: CurvePoint) -> dict[str, float]:
    """Times at one point: the parts, their sum, a whole iteration, and the ratio of the two."""
    state, omega = balance.evaluate(point.point).state, point.point.omega  # points of a curve hold no derivatives
    target, unknown = np.empty_like(state.residual), np.zeros_like(state.unknown)
    own, coupling, cross = np.empty_like(state.own), np.empty_like(state.coupling), np.empty_like(state.cross)
    modes, active = balance.system.modes, np.flatnonzero(state.unknown)
    factors = balance.factorise(point.evaluation, _plane(balance, point))
    matrix = np.asfortranarray(np.eye(factors.size + 1) + 1e-3 * np.random.default_rng(1).normal(size=(factors.size + 1,) * 2))

    by_omega = np.zeros_like(target)
    blocks = (state.w, omega, target, unknown, own, coupling, cross, by_omega)
    found = {
        "contact_sweep": time_of_one(_sweeps, balance.table, balance.tables, *blocks),
        "motion": time_of_one(_motions, modes, state.forces, omega, point.point.level),
        "receptance": time_of_one(_receptances, modes, state.gains, omega, active) if active.size else 0.0,
        "factorisation": best_time(partial(lapack.dgetrf, matrix)),
    }
    whole = _iteration_time(balance, point)
    return found | {"parts": sum(found.values()), "iteration": whole, "ratio": whole / sum(found.values())}


@njit
def _sweeps(times, table, tables, w, omega, target, unknown, own, coupling, cross, by_omega):
    for _ in range(times):
        contact_forces(view(table), view(tables), w, omega, target, unknown, own, coupling, cross, by_omega)


@njit
def _motions(times, modes, forces, omega, level):
    total = 0.0
    for _ in range(times):
        total += motion(view(modes), frequency_gains(view(modes), omega, (forces.shape[1] - 1) // 2), forces, omega, level)[0, 0]
    return total


@njit
def _receptances(times, modes, gains, omega, active):
    total = 0.0
    for _ in range(times):
        total += receptance(view(modes), driven_states(view(modes), gains, omega, active), active)[0, 0, 0, 0]
    return total


def time_of_one(repeated: Callable[..., Any], *arguments: Any, times: int = 20) -> float:
    """CPU seconds of one repetition inside a compiled loop: that of many more, less that of one."""
    return (best_time(partial(repeated, times + 1, *arguments)) - best_time(partial(repeated, 1, *arguments))) / times


def _iteration_time(balance: HarmonicBalance, point: CurvePoint) -> float:
    """CPU seconds of one more Newton iteration, as the difference between corrections that stop after two and after one."""
    condition = _plane(balance, point)
    tangent = point.tangent
    start = point.point.moved(0.05 * tangent.forces, "omega", 0.05 * tangent.parameter)
    # A target far away, so that neither correction ends early.
    condition = replace(condition, target=condition.target + 0.05)
    times = [best_time(partial(correct, balance, start, condition, iterations)) for iterations in (1, 2)]
    return times[1] - times[0]


def _plane(balance: HarmonicBalance, point: CurvePoint) -> Any:
    """The plane through a point, normal to its tangent, as continuation uses it."""
    from stickslip.solve.balance.balance import PathCondition

    weight, slope = point.metric.weight * point.tangent.motion, point.metric.parameter * point.tangent.parameter
    reached = float(np.vdot(weight, point.evaluation.w)) + slope * point.point.omega
    return PathCondition("omega", weight, slope, reached)


def best_time(action: Callable[[], object], seconds: float = 0.15, rounds: int = 5) -> float:
    """CPU seconds of one call: the best mean of several rounds of repeated calls."""
    action()
    calls = 1
    while True:
        began = time.process_time()
        for _ in range(calls):
            action()
        spent = time.process_time() - began
        if spent > seconds / rounds:
            break
        calls = max(2 * calls, int(calls * seconds / rounds / max(spent, 1e-6)))
    best = spent / calls
    for _ in range(rounds - 1):
        began = time.process_time()
        for _ in range(calls):
            action()
        best = min(best, (time.process_time() - began) / calls)
    return best
