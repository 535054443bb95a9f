"""Truncation error: the effect of the harmonics above H on a solution, by one Newton step of a balance with more of them.

Two small H can agree with each other and both be wrong: contact forces have harmonics that the solution drops, and where one of
them falls on a mode of the dampers it matters. The step starts from the solution padded with zeros and ends on a plane across the
curve, so that it is regular at folds and measures how far the two curves are apart, not how far a resonance has shifted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.energy import cycle_work
from stickslip.solve.continuation.more_harmonics import pad
from stickslip.solve.continuation.newton import correct
from stickslip.support.checks import Array

MARGIN = 16
"""Harmonics beyond H that are estimated, at least; up to 2H if that is more."""

MOST_UNKNOWNS = 3000
"""Size of a Newton matrix beyond which a step would cost as much as a curve."""

AT_REST, ROUNDING = 1e-6, 1e-10
"""Amplitudes of an output, relative to the largest output and to the largest motion of all, below which it counts as being at
rest."""

TINY = float(np.finfo(float).tiny)


def enough_beyond(harmonics: int) -> int:
    """The harmonics with which those beyond H are estimated."""
    return max(2 * harmonics, harmonics + MARGIN)


def beyond_within(harmonics: int, rows: float, unknowns: int) -> int:
    """With how many harmonics those beyond H are estimated where `rows` rows of contacts move, so that Newton's matrix has no
    more than so many unknowns: with two more at least, and 0 for none where these are too many."""
    fitting = min(enough_beyond(harmonics), max(harmonics + 2, int((unknowns / rows - 1.0) / 2.0)))
    return fitting if rows * (2 * fitting + 1) <= MOST_UNKNOWNS else 0


@dataclass(frozen=True, eq=False)
class Truncation:
    """share (h,): motion of the contacts in harmonic h = 1, 2, ... that is truncated, relative to their whole dynamic motion;
    total: change of the dynamic motion, in all harmonics, of contacts or an output, whichever is relatively larger."""

    share: Array
    total: float

    def needed(self, tolerance: float) -> int:
        """The least H beyond which the shares sum to no more than the tolerance."""
        beyond = np.sqrt(np.cumsum((self.share**2)[::-1])[::-1])
        return int(np.count_nonzero(beyond > tolerance))


def moving(w: Array, rows: int, counted: slice) -> tuple[Array, NDArray[np.bool_]]:
    """The sizes of outputs in the counted columns, and which of them move by more than rounding."""
    sizes, whole = np.linalg.norm(w[rows:, counted], axis=1), np.linalg.norm(w[:, 1:], axis=1)
    return sizes, sizes > max(AT_REST * whole[rows:].max(initial=0.0), ROUNDING * whole.max(initial=0.0))


class Step(NamedTuple):
    """padded: the solution as the finer balance sees it; condition: the plane through it; moved: the point after one Newton step;
    motion: its change on the way there (rows + outputs, 2H+1), m, not finite where the matrix is singular; further: the change
    by a second step with the same matrix. Where rigid friction reverses between two samples the first step sees nothing."""

    padded: Evaluation
    condition: PathCondition
    moved: Point
    motion: Array
    further: Array


def finer_step(finer: HarmonicBalance, evaluation: Evaluation, across: PathCondition) -> Step:
    """One Newton step of `finer`, a balance of the same problem with more harmonics or samples, from a solution.

    across: a plane across the curve, or a prescribed frequency, whatever its target: the one through the solution is taken.
    """
    point = evaluation.point
    padded = finer.evaluate(Point(pad(point.forces, finer.columns), point.omega, point.level))
    weight = None if across.weight is None else pad(across.weight, finer.columns)
    condition = replace(across, weight=weight, target=0.0)
    condition = replace(condition, target=condition.gap(padded))
    factors = finer.factorise(padded, condition)
    if factors.orientation == 0.0:
        unknown = np.full_like(padded.w, np.inf)
        return Step(padded, condition, padded.point, unknown, unknown)
    by_omega = finer.linear.slope(padded.point.forces, point.omega, point.level, by_level=False)

    def stepped(start: Evaluation) -> tuple[Point, Array]:
        change, by = finer.newton_step(start, condition, factors)
        return start.point.moved(change, "omega", by), finer.linear.change(change, point.omega) + by * by_omega

    moved, motion = stepped(padded)
    if not (moved.omega > 0.0 and np.isfinite(moved.forces).all()):
        return Step(padded, condition, padded.point, np.full_like(padded.w, np.inf), motion)
    return Step(padded, condition, moved, motion, stepped(finer.evaluate(moved))[1])


def solved_across(finer: HarmonicBalance, step: Step) -> Evaluation | None:
    """The solution of `finer` on the plane of a step; None where Newton's method does not arrive, behind kinks neither."""
    for iterations, halvings, patience in ((30, 10, 0), (60, 4, 20)):
        correction = correct(finer, step.padded.point, step.condition, iterations, halvings, patience)
        if correction.converged:
            return correction.evaluation
    return None


def truncation_at(balance: HarmonicBalance, finer: HarmonicBalance, evaluation: Evaluation, across: PathCondition) -> Truncation:
    """What the harmonics of `finer` change of a solved point on a plane across the curve: solved, else by one step alone."""
    step, rows = finer_step(finer, evaluation, across), finer.rows
    solution = solved_across(finer, step)
    moved = step.motion if solution is None else solution.w - step.padded.w
    size = max(float(np.linalg.norm(step.padded.w[:rows, 1:])), TINY)
    sizes, moves = moving(step.padded.w, rows, slice(1, None))
    of_outputs = np.linalg.norm(moved[rows:, 1:], axis=1)[moves] / sizes[moves]
    left_out = moved[:rows].copy()
    left_out[:, balance.kept] = 0.0
    share = np.sqrt(np.sum(left_out[:, 1::2] ** 2 + left_out[:, 2::2] ** 2, axis=0)) / size
    return Truncation(share, max(float(np.linalg.norm(moved[:rows, 1:])) / size, float(of_outputs.max(initial=0.0))))


def contact_work(balance: HarmonicBalance, evaluation: Evaluation) -> float:
    """Work of all contacts in a period of the balance, J."""
    return float(cycle_work(evaluation.point.forces - evaluation.residual, evaluation.w[: balance.rows]).sum())
