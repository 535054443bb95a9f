"""Solutions at one frequency and level as a function of the start state, each reached from a known neighbour."""

from __future__ import annotations

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.sensitivity import solved_factors
from stickslip.solve.continuation.sweep import SINGULAR, failure
from stickslip.solve.starts.space import StartSpace
from stickslip.support.checks import Array
from stickslip.support.outcome import Outcome

KNOWN = 64
"""Solutions remembered; the oldest are forgotten first, the very first never."""

SHORTEST = 1.0 / 32.0
"""The shortest step on the way from a known start state to a wanted one, as a share of the way."""


class UnsolvedError(Exception):
    """No solution was found at a start state; `outcome` says why."""

    def __init__(self, outcome: Outcome = Outcome.NOT_CONVERGED) -> None:
        self.outcome = outcome
        super().__init__(outcome.sentence)


class StartSolutions:
    """Solves at a frequency in rad/s and a level, and remembers where solutions were found; `solves` counts them."""

    def __init__(self, balance: HarmonicBalance, space: StartSpace, omega: float, level: float) -> None:
        self.balance, self.space, self.omega, self.level = balance, space, omega, level
        self.known: list[tuple[Array, Array]] = []
        self.solves = 0

    def remember(self, variables: Array, forces: Array) -> None:
        """Keep forces λ as a place to start from."""
        if len(self.known) >= KNOWN:
            del self.known[1]
        self.known.append((variables.copy(), forces))

    def solve(self, variables: Array) -> tuple[HarmonicBalance, Evaluation]:
        """The balance and solution at a start state: from the nearest known solution, else along the way from it; raises
        `UnsolvedError`.
        """
        self.solves += 1
        balance, evaluation = self._from_known(variables) if self.known else self._first(variables)
        self.remember(variables, evaluation.point.forces)
        return balance, evaluation

    def _first(self, variables: Array) -> tuple[HarmonicBalance, Evaluation]:
        balance = self.space.balance(self.balance, variables)
        first = first_point(balance, self.omega, self.level)
        if not first.converged:
            raise UnsolvedError(failure(balance, first))
        if self.space.prescribes and _singular(balance, first.evaluation):
            raise UnsolvedError(Outcome.BODY_HELD_BY_NOTHING)
        return balance, first.evaluation

    def _from_known(self, variables: Array) -> tuple[HarmonicBalance, Evaluation]:
        origins = np.array([origin for origin, _ in self.known])
        origin, forces = self.known[int(np.argmin(np.linalg.norm(origins - variables, axis=1)))]
        done, step = 0.0, 1.0
        while True:
            share = min(done + step, 1.0)
            balance = self.space.balance(self.balance, origin + share * (variables - origin))
            start = Point(forces, self.omega, self.level)
            correction = correct(balance, start, fixed("omega", self.omega), iterations=15, halvings=6)
            if correction.converged and share == 1.0:
                return balance, correction.evaluation
            if correction.converged:
                done, step, forces = share, 2.0 * step, correction.evaluation.point.forces
            elif step <= SHORTEST:
                raise UnsolvedError
            else:
                step *= 0.5


def _singular(balance: HarmonicBalance, evaluation: Evaluation) -> bool:
    """Whether a body could be anywhere at a solved point: prescribed friction holds it in balance, but does not hold it."""
    pivots = np.abs(solved_factors(balance, evaluation).pivots)
    return bool(pivots.min() <= SINGULAR * pivots.max())
