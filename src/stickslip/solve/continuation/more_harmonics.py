"""A solution carried to more harmonics at the same frequency and level: padded with zeros, then Newton's method.

Where contacts are stiff the Newton matrix is nearly singular in what slips: a step may be right and yet raise the residual, and a
line search stops. Then steps are damped by their own length, which no scaling of the equations changes.
"""

from __future__ import annotations

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.continuation.newton import FLOOR, Correction, correct, fixed
from stickslip.support.checks import Array

SHORTEST = 3e-3
"""Share of a step that is taken whatever it does: kinks of friction lie so close that shorter ones do not get across. Of 3e-3,
1e-2 and 1e-3, that with which most of 56 solutions of a rubbing mass were found, from 13 to 151 harmonics.
"""

STEPS = 200
"""Damped steps before a solution is given up."""

TINY = float(np.finfo(float).tiny)


def pad(forces: Array, columns: int) -> Array:
    """λ with more harmonics (zeros) or fewer."""
    padded = np.zeros((forces.shape[0], columns))
    kept = min(forces.shape[1], columns)
    padded[:, :kept] = forces[:, :kept]
    return padded


def resolved(finer: HarmonicBalance, evaluation: Evaluation, steps: int = STEPS) -> Correction:
    """The same point with the harmonics of `finer`, started from the padded solution; by way of half as many more harmonics where
    it is not found at once."""
    correction = _carried(finer, evaluation, steps)
    known = (evaluation.point.forces.shape[1] - 1) // 2
    half = (known + finer.highest) // 2
    if correction.converged or half <= known:
        return correction
    between = _carried(finer.with_harmonics(half), evaluation, steps)
    return _carried(finer, between.evaluation, steps) if between.converged else correction


def _carried(finer: HarmonicBalance, evaluation: Evaluation, steps: int) -> Correction:
    point = evaluation.point
    start = Point(pad(point.forces, finer.columns), point.omega, point.level)
    correction = correct(finer, start, fixed("omega", point.omega), iterations=30, halvings=10)
    if correction.converged or correction.singular:
        return correction
    near = _damped(finer, start, steps)
    return correction if near is None else correct(finer, near, fixed("omega", point.omega), iterations=30, halvings=10)


@np.errstate(over="ignore")  # a step of a body that drifts may exceed all numbers: its length is infinite, and the search ends
def _damped(balance: HarmonicBalance, start: Point, steps: int) -> Point | None:
    """A point with a residual below `FLOOR` at the frequency and level of the start; None where the steps do not lead to one.

    A share s of a step d is taken if the next step with the same matrix, d', is shorter than d. How much d' differs from
    (1 − s) d, which it is where the residual is straight, says which share to try instead; how much it differs from the next step
    with its own matrix, which share that begins with.
    Source: P. Deuflhard, Newton Methods for Nonlinear Problems (2004), section 3.3.
    """
    condition, evaluation = fixed("omega", start.omega), balance.evaluate(start)
    share, before, following = 1.0, 0.0, start.forces
    for _ in range(steps):
        if evaluation.error <= FLOOR:
            return evaluation.point
        factors = balance.factorise(evaluation, condition)
        step = balance.newton_step(evaluation, condition, factors)[0]
        length = float(np.linalg.norm(step))
        if factors.orientation == 0.0 or not np.isfinite(length):
            return None
        if before:
            straight = share * before * float(np.linalg.norm(following))
            share = max(SHORTEST, straight / max(float(np.linalg.norm(following - step)) * length, straight, TINY))
        while True:
            trial = balance.evaluate(evaluation.point.moved(share * step, "omega", 0.0))
            following = balance.newton_step(trial, condition, factors)[0]
            if share <= SHORTEST or np.linalg.norm(following) < length:
                break
            bent = float(np.linalg.norm(following - (1.0 - share) * step))
            share = max(SHORTEST, min(0.5 * share, 0.5 * length * share**2 / bent))
        evaluation, before = trial, length
    return None
