"""Truncation error: the effect of the harmonics above H on a solution, the estimate behind the choice of H.

Two small H can agree with each other and both be wrong: contact forces have harmonics that the solution drops, and where one of
them falls on a mode of the dampers it matters. The estimate applies the receptance to the truncated harmonics of λ̂.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.energy import cycle_work
from stickslip.solve.continuation.more_harmonics import pad
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
    """share (h,): motion of the contacts in harmonic h = 1, 2, ... that is truncated, relative to their whole dynamic motion."""

    share: Array

    @property
    def total(self) -> float:
        """Root sum of squares of the shares."""
        return float(np.sqrt(np.sum(self.share**2)))

    @property
    def largest(self) -> int:
        """The truncated harmonic that would move the contacts most."""
        return int(np.argmax(self.share)) + 1

    def needed(self, tolerance: float) -> int:
        """The least H beyond which the shares sum to no more than the tolerance."""
        beyond = np.sqrt(np.cumsum((self.share**2)[::-1])[::-1])
        return int(np.count_nonzero(beyond > tolerance))


def truncation_at(balance: HarmonicBalance, finer: HarmonicBalance, evaluation: Evaluation) -> Truncation:
    """The estimate for a solved point, with the harmonics of `finer`, a balance of the same problem with more of them."""
    padded = finer.evaluate(Point(pad(evaluation.point.forces, finer.columns), evaluation.point.omega, evaluation.point.level))
    change = -padded.residual
    change[:, balance.kept] = 0.0
    moved = finer.linear.change(change, evaluation.point.omega)[: finer.rows, 1:]
    size = max(float(np.linalg.norm(padded.w[: finer.rows, 1:])), np.finfo(float).tiny)
    return Truncation(np.sqrt(np.sum(moved[:, 0::2] ** 2 + moved[:, 1::2] ** 2, axis=0)) / size)


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
