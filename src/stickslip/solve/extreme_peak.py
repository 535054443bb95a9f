"""The highest resonance peak over a band as a function of the start state, for the search of its extremes.

From one start state to the next the peak moves a little: it is followed by the slope d|X_1|/dω. Whole curves are traced for
the start states that searches begin from and for what they find: far-off start states have curves a hundred times dearer.
"""

from __future__ import annotations

import numpy as np

from stickslip.checks import Array
from stickslip.harmonic.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.continuation import CurvePoint, LostCurveError, StepControl, trace
from stickslip.solve.extremes import Extreme, amplitude, start_gradient
from stickslip.solve.newton import correct, fixed
from stickslip.solve.peak import PeakSearch
from stickslip.solve.sensitivity import solved_factors
from stickslip.solve.start_solutions import StartSolutions, UnsolvedError
from stickslip.solve.start_space import StartSpace

TOLERANCE = 1e-6
"""Relative amplitude to which a peak is found."""

LONGEST = 300
"""Points of the longest curve that is traced for its peak; a virgin one takes about forty."""

STRIDE, STRIDES, TIGHTENINGS = 1e-3, 12, 40
"""First step in frequency towards a peak, relative; how many growing steps may follow; how many narrowings of the bracket."""


def highest_peak(curve_start: Evaluation, balance: HarmonicBalance, output: int, end: float) -> CurvePoint | None:
    """The highest peak of |X_1| from a solved point to the frequency `end` in rad/s; None where the curve is lost or has none."""
    first = correct(balance, curve_start.point, fixed("omega", curve_start.point.omega))
    if not first.converged:
        return None
    try:
        curve = list(trace(balance, first, "omega", end, StepControl(points=LONGEST)))
    except LostCurveError:
        return None
    row = balance.rows + output
    found = PeakSearch(balance, curve, TOLERANCE).peaks(output)
    return max(found.points, key=lambda p: float(np.hypot(*p.evaluation.w[row, 1:3])), default=None)


class AtPeak:
    """|X_1| at the highest peak of the curve over a band in rad/s; the gradient at the peak is the one at fixed frequency."""

    def __init__(self, balance: HarmonicBalance, space: StartSpace, output: int, band: tuple[float, float], level: float) -> None:
        self.space, self.output, self.band = space, output, band
        self.begin = StartSolutions(balance, space, band[0], level)
        self.known: list[tuple[Array, Point]] = []
        self.solves = self.traces = 0

    def point(self, variables: Array) -> Extreme:
        """What a start state gives near the peak of a known one."""
        return self.value(variables)[0]

    def value(self, variables: Array) -> tuple[Extreme, Array]:
        """What a start state gives near the peak of a known one, and the gradient; where none is known its curve is traced."""
        if not self.known:
            return self.traced(variables)
        balance = self.space.balance(self.begin.balance, variables)
        evaluation = self._followed(balance, variables)
        if evaluation is None:
            raise UnsolvedError
        return self._at(balance, variables, evaluation)

    def traced(self, variables: Array) -> tuple[Extreme, Array]:
        """The same by tracing the whole curve; raises `UnsolvedError`."""
        self.traces += 1
        balance, first = self.begin.solve(variables)
        peak = highest_peak(first, balance, self.output, self.band[1])
        if peak is None:
            raise UnsolvedError
        return self._at(balance, variables, peak.evaluation)

    def _at(self, balance: HarmonicBalance, variables: Array, evaluation: Evaluation) -> tuple[Extreme, Array]:
        self.known = [*self.known[-30:], (variables.copy(), evaluation.point)]
        value, slope_of = amplitude(self.output)(balance, evaluation)
        return Extreme(variables.copy(), value, balance, evaluation), start_gradient(balance, self.space, evaluation, slope_of)

    def _followed(self, balance: HarmonicBalance, variables: Array) -> Evaluation | None:
        """The peak near the one of the nearest known start state."""
        origin, point = min(self.known, key=lambda item: float(np.linalg.norm(item[0] - variables)))
        low = self._reached(balance, variables, origin, point)
        if low is None:
            return None
        high, step = low, STRIDE * np.sign(low[1])
        for _ in range(STRIDES):
            high_omega = high[0].point.omega * (1.0 + step)
            following = self._solved(balance, high[0].point, high_omega) if self.band[0] < high_omega < self.band[1] else None
            if following is None:
                return None
            low, high = high, following
            if low[1] * high[1] <= 0.0:
                return self._narrowed(balance, low, high)
            step *= 1.5
        return None

    def _reached(
        self, balance: HarmonicBalance, variables: Array, origin: Array, point: Point
    ) -> tuple[Evaluation, float] | None:
        """The solution at the frequency of a known peak: at once, else by way of start states between its own and this one."""
        there = self._solved(balance, point, point.omega)
        if there is not None:
            return there
        way = StartSolutions(self.begin.balance, self.space, point.omega, point.level)
        way.remember(origin, point.forces)
        try:
            return self._solved(balance, way.solve(variables)[1].point, point.omega)
        except UnsolvedError:
            return None

    def _narrowed(
        self, balance: HarmonicBalance, low: tuple[Evaluation, float], high: tuple[Evaluation, float]
    ) -> Evaluation | None:
        """The peak between two frequencies at which the amplitude slopes towards each other (regula falsi, Illinois)."""
        weights = [low[1], high[1]]
        ends = [low, high]
        for _ in range(TIGHTENINGS):
            a, b = ends[0][0].point.omega, ends[1][0].point.omega
            size = float(np.hypot(*ends[0][0].w[balance.rows + self.output, 1:3]))
            if abs(b - a) * max(abs(ends[0][1]), abs(ends[1][1])) <= TOLERANCE * size:
                break
            share = float(np.clip(weights[0] / (weights[0] - weights[1]), 0.02, 0.98))
            middle = self._solved(balance, ends[0 if share < 0.5 else 1][0].point, a + share * (b - a))
            if middle is None:
                return None
            side = 0 if middle[1] * ends[0][1] > 0.0 else 1
            ends[side], weights[side] = middle, middle[1]
            weights[1 - side] *= 0.5
        return max((end[0] for end in ends), key=lambda e: float(np.hypot(*e.w[balance.rows + self.output, 1:3])))

    def _solved(self, balance: HarmonicBalance, near: Point, omega: float) -> tuple[Evaluation, float] | None:
        """The solution at a frequency from one nearby, and d|X_1|/dω along the curve there."""
        self.solves += 1
        correction = correct(balance, Point(near.forces, omega, near.level), fixed("omega", omega), iterations=15, halvings=6)
        if not correction.converged:
            return None
        evaluation = correction.evaluation
        _, motion, amount = balance.tangent(evaluation, "omega", solved_factors(balance, evaluation))
        _, slope_of = amplitude(self.output)(balance, evaluation)
        return evaluation, float(slope_of(np.empty(0), motion[None])[0] / amount)
