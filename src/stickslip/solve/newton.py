"""Newton's method with a line search on the residual: the one loop in which every point of every curve is solved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.harmonic.balance import Evaluation, Factors, HarmonicBalance, Parameter, PathCondition, Point

TOLERANCE = 1e-12
"""Residual relative to the contact forces, or to the harmonic load, at which a point counts as solved."""

FLOOR = 1e-9
"""Residual that is still accepted where rounding lets no step reduce it further."""

CONDITION_TOLERANCE = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """Outcome of Newton's method: the evaluation of the start and the last one, the last factors and whose they are."""

    start: Evaluation
    evaluation: Evaluation
    factors: Factors | None
    factored: Evaluation | None
    iterations: int
    converged: bool
    singular: bool


def fixed(parameter: Parameter, value: float) -> PathCondition:
    """The condition that prescribes the parameter alone."""
    scale = 1.0 / max(abs(value), 1e-300)
    return PathCondition(parameter, None, scale, scale * value)


def correct(
    balance: HarmonicBalance,
    start: Point,
    condition: PathCondition,
    iterations: int = 10,
    halvings: int = 4,
    patience: int = 0,
) -> Correction:
    """Solve R = 0 with a path condition from a start.

    patience: how many times a full step is taken although no step reduces the residual; on the far side of a kink it often
    falls again. Without patience Newton fails there.
    """
    evaluation = first = balance.evaluate(start)
    factors: Factors | None = None
    factored: Evaluation | None = None
    for iteration in range(iterations + 1):
        gap = condition.gap(evaluation)
        if evaluation.error <= TOLERANCE and abs(gap) <= CONDITION_TOLERANCE:
            return Correction(first, evaluation, factors, factored, iteration, True, False)
        if iteration == iterations:
            break
        factors, factored = balance.factorise(evaluation, condition), evaluation
        if factors.orientation == 0.0:
            return Correction(first, evaluation, factors, factored, iteration, False, True)
        change, amount = balance.newton_step(evaluation, condition, factors)
        trial = _search(balance, evaluation, condition, change, amount, gap, halvings)
        if trial is None and patience > 0:
            patience -= 1
            trial = _full_step(balance, evaluation, condition, change, amount)
        if trial is None:
            accepted = evaluation.error <= FLOOR and abs(gap) <= CONDITION_TOLERANCE
            return Correction(first, evaluation, factors, factored, iteration + 1, accepted, False)
        evaluation = trial
    return Correction(first, evaluation, factors, factored, iterations, False, False)


def _full_step(
    balance: HarmonicBalance, evaluation: Evaluation, condition: PathCondition, change: np.ndarray, amount: float
) -> Evaluation | None:
    """The evaluation after Newton's whole step, whatever it does to the residual."""
    if evaluation.error <= FLOOR or not (np.isfinite(amount) and np.all(np.isfinite(change))):
        return None
    point = evaluation.point.moved(change, condition.parameter, amount)
    return balance.evaluate(point) if point.omega > 0.0 else None


def _search(
    balance: HarmonicBalance,
    evaluation: Evaluation,
    condition: PathCondition,
    change: np.ndarray,
    amount: float,
    gap: float,
    halvings: int,
) -> Evaluation | None:
    """The evaluation after the longest of the steps 1, 1/2, 1/4, ... that reduces residual and gap together, or None."""
    if not (np.isfinite(amount) and np.all(np.isfinite(change))):
        return None
    before = np.hypot(evaluation.error, gap)
    length = 1.0
    for _ in range(halvings + 1):
        point = evaluation.point.moved(length * change, condition.parameter, length * amount)
        if point.omega > 0.0:
            trial = balance.evaluate(point)
            if np.hypot(trial.error, condition.gap(trial)) < (1.0 - 1e-4 * length) * before:
                return trial
        length *= 0.5
    return None
