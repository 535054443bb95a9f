"""The highest resonance peak over a band as a function of the start state, for the search of its extremes.

From one start state to the next the peak moves a little: it is climbed to from the nearest one known. Whole curves are traced for
the start states that searches begin from and for what they find: far-off start states have curves a hundred times dearer.
"""

from __future__ import annotations

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.continuation import trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.peaks.climb import NoPeakError, PeakSolver, Plane, plane_at
from stickslip.solve.peaks.search import PeakSearch
from stickslip.solve.starts.extremes import Extreme, size_of, start_gradient
from stickslip.solve.starts.solutions import StartSolutions, UnsolvedError
from stickslip.solve.starts.space import StartSpace
from stickslip.support.checks import Array
from stickslip.support.outcome import Outcome

TOLERANCE = 1e-6
"""Relative amplitude to which a peak is found."""

LONGEST = 300
"""Points of the longest curve that is traced for its peak; a virgin one takes about forty."""

APART = 1e-3
"""Relative distance in frequency from where on two peaks of one curve are different ones."""

KNOWN = 30
"""Peaks remembered to climb from."""


def highest_peak(
    curve_start: Evaluation, balance: HarmonicBalance, output: int, end: float, measure: Measure
) -> CurvePoint | None:
    """The highest peak from a solved point to the frequency `end` in rad/s; None where the curve is lost or has none."""
    first = correct(balance, curve_start.point, fixed("omega", curve_start.point.omega))
    if not first.converged:
        return None
    try:
        curve = list(trace(balance, first, "omega", end, StepControl(points=LONGEST)))
    except LostCurveError:
        return None
    row = balance.rows + output
    found = PeakSearch(balance, curve, TOLERANCE).peaks(output, measure)
    return max(found.points, key=lambda p: measure.size(p.evaluation.w[row], p.point.omega), default=None)


class AtPeak:
    """A measure of an output at its highest peak over a band in rad/s; the gradient at the peak is the one at fixed frequency,
    since along the curve the measure is stationary there.
    """

    def __init__(
        self, balance: HarmonicBalance, space: StartSpace, output: int, measure: Measure, band: tuple[float, float], level: float
    ) -> None:
        self.space, self.output, self.measure, self.band = space, output, measure, band
        self.begin = StartSolutions(balance, space, band[0], level)
        self.known: list[tuple[Array, Point, Plane]] = []
        self.solves = self.traces = 0

    def point(self, variables: Array) -> Extreme:
        """What a start state gives near the peak of a known one."""
        return self.value(variables)[0]

    def value(self, variables: Array) -> tuple[Extreme, Array]:
        """What a start state gives near the peak of a known one, and the gradient; where none is known its curve is traced."""
        if not self.known:
            return self.traced(variables)
        balance = self.space.balance(self.begin.balance, variables)
        solver = PeakSolver(balance, self.output, self.measure, TOLERANCE)
        try:
            evaluation = self._climbed(solver, variables)
        except NoPeakError:
            raise UnsolvedError from None
        finally:
            self.solves += solver.solves
        if not self.band[0] < evaluation.point.omega < self.band[1]:
            raise UnsolvedError
        return self._at(balance, variables, evaluation)

    def sample(self, variables: Array) -> Extreme:
        """What a start state gives on its whole curve."""
        return self.traced(variables)[0]

    def confirmed(self, found: Extreme, sign: float) -> Extreme | None:
        """The highest peak of the whole curve: the one that was followed may not be it. Then that one is climbed to from now on.

        Where the curve is lost, its highest peak is at least the followed one: a search of the largest takes that, one of the
        smallest nothing.
        """
        try:
            highest = self.sample(found.variables)
        except UnsolvedError:
            return found if sign > 0.0 else None
        if abs(highest.evaluation.point.omega - found.evaluation.point.omega) > APART * found.evaluation.point.omega:
            self.known = self.known[-1:]
        return highest

    def traced(self, variables: Array) -> tuple[Extreme, Array]:
        """The same by tracing the whole curve; raises `UnsolvedError`."""
        self.traces += 1
        balance, first = self.begin.solve(variables)
        peak = highest_peak(first, balance, self.output, self.band[1], self.measure)
        if peak is None:
            raise UnsolvedError(Outcome.NO_PEAK)
        return self._at(balance, variables, peak.evaluation)

    def _at(self, balance: HarmonicBalance, variables: Array, evaluation: Evaluation) -> tuple[Extreme, Array]:
        known = (variables.copy(), evaluation.point, plane_at(balance, evaluation))
        self.known = [*self.known[-KNOWN:], known]
        value, slope_of = size_of(self.output, self.measure)(balance, evaluation)
        return Extreme(variables.copy(), value, balance, evaluation), start_gradient(balance, self.space, evaluation, slope_of)

    def _climbed(self, solver: PeakSolver, variables: Array) -> Evaluation:
        """The peak near that of the nearest known start state: at once, else by way of start states between its own and this."""
        origin, point, plane = min(self.known, key=lambda item: float(np.linalg.norm(item[0] - variables)))
        try:
            return solver.from_near(point, plane).evaluation
        except NoPeakError:
            way = StartSolutions(self.begin.balance, self.space, point.omega, point.level)
            way.remember(origin, point.forces)
            return solver.from_solved(way.solve(variables)[1]).evaluation
