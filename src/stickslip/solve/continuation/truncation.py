"""Truncation error: the effect of the harmonics above H on a solution, by one Newton step of a balance with more of them.

Two small H can agree with each other and both be wrong: contact forces have harmonics that the solution drops, and where one of
them falls on a mode of the dampers it matters. The step starts from the solution padded with zeros and ends on a plane across the
curve, so that it is regular at folds and measures how far the two curves are apart, not how far a resonance has shifted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.energy import cycle_work
from stickslip.solve.continuation.more_harmonics import pad
from stickslip.solve.continuation.newton import correct
from stickslip.solve.continuation.sensitivity import respond, solved_factors
from stickslip.support.checks import Array

MARGIN = 16
"""Harmonics beyond H that are estimated, at least; up to 2H if that is more."""

AT_REST, ROUNDING = 1e-6, 1e-10
"""Amplitudes of an output, relative to the largest output and to the largest motion of all, below which it counts as being at
rest."""


def enough_beyond(harmonics: int) -> int:
    """The harmonics with which those beyond H are estimated."""
    return max(2 * harmonics, harmonics + MARGIN)


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


class Step(NamedTuple):
    """padded: the solution as the finer balance sees it; condition: the plane through it; moved: the point after one Newton step;
    motion: its change on the way there (rows + outputs, 2H+1), m, not finite where the matrix is singular."""

    padded: Evaluation
    condition: PathCondition
    moved: Point
    motion: Array


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
        return Step(padded, condition, padded.point, np.full_like(padded.w, np.inf))
    change, by = finer.newton_step(padded, condition, factors)
    by_omega = finer.linear.slope(padded.point.forces, point.omega, point.level, by_level=False)
    return Step(
        padded, condition, padded.point.moved(change, "omega", by), finer.linear.change(change, point.omega) + by * by_omega
    )


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
    change, motion = (np.linalg.norm(each[:, 1:], axis=1) for each in (moved, step.padded.w))
    size = max(float(np.linalg.norm(motion[:rows])), np.finfo(float).tiny)
    outputs = motion[rows:] > AT_REST * motion[rows:].max(initial=0.0)
    of_outputs = change[rows:][outputs] / motion[rows:][outputs]
    remainder = moved[:rows].copy()
    remainder[:, balance.kept] = 0.0
    share = np.sqrt(np.sum(remainder[:, 1::2] ** 2 + remainder[:, 2::2] ** 2, axis=0)) / size
    return Truncation(share, max(float(np.linalg.norm(change[:rows])) / size, float(of_outputs.max(initial=0.0))))


class Changed(NamedTuple):
    """motion: ΔX/|X| of the outputs, (outputs, columns of the finer balance, 0 in those that do not count); work: of all contacts
    in a period after the change, J; following: length of the next step with the same matrix, relative too, (outputs,)."""

    motion: Array
    work: float
    following: Array


def contact_work(balance: HarmonicBalance, evaluation: Evaluation) -> float:
    """Work of all contacts in a period of the balance, J."""
    return float(cycle_work(evaluation.point.forces - evaluation.residual, evaluation.w[: balance.rows]).sum())


def change_by(finer: HarmonicBalance, balance: HarmonicBalance, evaluation: Evaluation, counted: slice) -> Changed:
    """By how much each output would change with the harmonics and samples of `finer`, relative, in the counted columns of the
    motion, and the work that the contacts would do.

    One Newton step of `finer` at the same frequency, from the padded solution: it includes the coupling of the truncated
    harmonics, which matters where one of them falls on a mode. 0 for an output at rest. Where a further step with the same matrix
    is not much shorter, contacts change between stick and slip on the way, and the first step says little.
    """
    point, rows = evaluation.point, slice(balance.rows, None)
    padded = finer.evaluate(Point(pad(point.forces, finer.columns), point.omega, point.level))
    factors = solved_factors(finer, padded)
    step = respond(finer, padded, factors, -padded.residual[None])
    moved = finer.evaluate(Point(padded.point.forces + step.forces[0], point.omega, point.level))
    further = respond(finer, padded, factors, -moved.residual[None]).motion[0]
    change, contacts = step.motion[0], slice(finer.rows)
    work = float(cycle_work(moved.point.forces, padded.w[contacts] + change[contacts]).sum())
    size = np.linalg.norm(evaluation.w[rows, counted], axis=1)
    whole = np.linalg.norm(evaluation.w[:, 1:], axis=1)
    moving = size > max(AT_REST * whole[rows].max(initial=0.0), ROUNDING * whole.max(initial=0.0))
    relative = np.zeros((size.size, finer.columns))
    relative[moving, counted] = change[rows, counted][moving] / size[moving, None]
    following = np.zeros(size.size)
    following[moving] = np.linalg.norm(further[rows, counted][moving], axis=1) / size[moving]
    return Changed(relative, work, following)
