"""Least squares of a law along measured loops, judged by loops held out; the lag of a force that explains them better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from stickslip.laboratory.identification.contact_law.intervals import standard_errors
from stickslip.laboratory.identification.contact_law.model import LAWS, ContactLoop, advanced, force_of
from stickslip.laboratory.identification.least_squares import LeastSquares, Solution
from stickslip.support.checks import Array

LONGEST = 0.05
"""Share of a period up to which a lag is looked for."""


@dataclass(frozen=True, eq=False)
class LoopFit(LeastSquares):
    """A law along measured loops. Variables: ln kt, ln mu, shape; and the lag of the force over the longest where it is `late`.

    about: variables about which the bounds lie.
    """

    loops: Sequence[ContactLoop]
    law: str
    about: Array
    late: bool = False

    @property
    def bounds(self) -> tuple[Array, Array]:
        count, lag = LAWS[self.law][1], [1.0] * self.late
        low = [self.about[0] - 4.0, self.about[1] - 3.0, *[0.0] * count, *(-1.0 * one for one in lag)]
        return np.array(low), np.array([self.about[0] + 5.0, self.about[1] + 3.0, *[0.999] * count, *lag])

    def residuals(self, x: Array) -> Array:
        """Measured less computed force of all loops, one after the other, without the unknown zero of each."""
        theta = x[: 2 + LAWS[self.law][1]]
        forces = [np.asarray(loop.force) for loop in self.loops]
        if self.late:
            forces = [advanced(force, LONGEST * x[-1]) for force in forces]
        left = [force - force_of(loop, self.law, theta) for force, loop in zip(forces, self.loops, strict=True)]
        return np.concatenate([one - one.mean() for one in left])


def first_guess(loops: Sequence[ContactLoop], law: str, factor: float = 1.0) -> Array:
    """Where the search begins: μ by the range of the force; kt by the elastic travel F/kt = X − W/(4F) of one slider, with F
    and X half the ranges of force and displacement and W the energy per cycle."""
    travel = [max(one.amplitude - one.energy / (4.0 * one.friction), 0.01 * one.amplitude) for one in loops]
    kt = max(loop.friction / one for loop, one in zip(loops, travel, strict=True))
    return np.array([np.log(factor * kt), np.log(max(one.friction / one.load for one in loops)), *[0.5] * LAWS[law][1]])


def fitted(loops: Sequence[ContactLoop], law: str, start: Array | None = None) -> Solution:
    """The least squares in (ln kt, ln mu, shape), from a start or from two that range, amplitude and energy give."""
    starts = [start] if start is not None else [first_guess(loops, law, factor) for factor in (1.0, 1.5)]
    return LoopFit(loops, law, starts[0]).solutions(starts, lambda found: False)[0]


def judged(loops: Sequence[ContactLoop], law: str, compared: Sequence[ContactLoop]) -> tuple[Array, Array, float, float]:
    """Parameters of a law, their standard errors, its misfit and its error on loops held out one at a time (NaN for one loop).

    compared: what is held out, the loops themselves or those with a load that makes up for wear.
    """
    found, errors = fitted(loops, law), []
    rms = np.sqrt(np.mean(np.concatenate([np.asarray(loop.force) - np.mean(np.asarray(loop.force)) for loop in loops]) ** 2))
    for i, loop in enumerate(compared if len(loops) > 1 else ()):
        others = fitted((*compared[:i], *compared[i + 1 :]), law, found.x)
        errors.append(LoopFit((loop,), law, found.x).residuals(others.x))
    held_out = np.sqrt(np.mean(np.concatenate(errors) ** 2)) / rms if errors else np.nan
    misfit = np.sqrt(np.mean(found.residuals**2)) / rms
    return found.x, standard_errors(found, loops, law), float(misfit), float(held_out)


class ForceLag(NamedTuple):
    """lag: share of a period by which the force comes late (below zero: early); kt [N/m] with it taken away; left: sum of squares
    of the residuals over that without a lag."""

    lag: float
    kt: float
    left: float


def force_lag(loops: Sequence[ContactLoop], law: str, theta: Array) -> ForceLag:
    """The lag that explains loops best, fitted with the parameters (ln kt, ln mu, shape) of a law from where it fits without.

    At a reversal a contact sticks: its force turns with the displacement, however stiff it is. A force that turns later does so
    by its sensor or filter, unless the law lacks what makes it.
    """
    fit, start = LoopFit(loops, law, theta, late=True), np.append(theta, 0.0)
    found, before = fit.solved(start), fit.cost(start)
    return ForceLag(LONGEST * float(found.x[-1]), float(np.exp(found.x[0])), found.cost / before if before > 0.0 else 1.0)
