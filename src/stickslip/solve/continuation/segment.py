"""One step of a curve between two solved points: cubics through points and tangents, over planes across the straight way."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from stickslip.solve.balance.balance import Evaluation, Factors, HarmonicBalance, PathCondition
from stickslip.solve.balance.system import Direction
from stickslip.solve.continuation.curve_points import CurvePoint, Metric, Tangent, hermite
from stickslip.support.checks import Array

SAME = 1e-12
"""Relative difference of frequencies that count as one."""

SHARP = 0.3
"""Cosine between curve and straight way below which a cubic takes the straight way for its slope: at corners."""


@dataclass(frozen=True, slots=True, eq=False)
class Knot:
    """A solved point, the condition and factors of the curve there, and its direction, or None where it has none."""

    evaluation: Evaluation
    condition: PathCondition
    factors: Factors
    direction: Direction | None

    @property
    def omega(self) -> float:
        return self.evaluation.point.omega


@dataclass(frozen=True, slots=True, eq=False)
class _Slope:
    """Change along a segment, per unit of its fraction s: dλ/ds, dw/ds, dω/ds."""

    forces: Array
    motion: Array
    omega: float


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """The curve between two knots; fraction s from 0 to 1 on planes across the straight way between them.

    controls: the control points of the cubic ω(s), rad/s; it lies between the least and the largest.
    """

    low: Knot
    high: Knot
    plane: PathCondition
    slopes: tuple[_Slope, _Slope]
    controls: tuple[float, float, float, float]

    def folds(self) -> list[float]:
        """Fractions at which the frequency turns."""
        a, b, c, d = self.controls
        if a < b < c < d or a > b > c > d:
            return []
        roots = np.roots([d - 3.0 * c + 3.0 * b - a, 2.0 * (c - 2.0 * b + a), b - a])
        return sorted(float(root) for root in roots.real[roots.imag == 0.0] if 0.0 < root < 1.0)

    def crossings(self, omega: float) -> list[float]:
        """Fractions at which the segment passes a frequency between its ends; behind a fold it may return to that of an end."""
        turns = [0.0, *self.folds(), 1.0]
        beyond = [self.omega(turn) - omega for turn in turns]
        for end, beside in ((0, 1), (-1, -2)):
            if abs(beyond[end]) <= SAME * omega:
                beyond[end] = beyond[beside]
        pieces = [pair for pair, (a, b) in zip(pairwise(turns), pairwise(beyond), strict=True) if (a < 0.0) != (b < 0.0)]
        return [float(scipy.optimize.brentq(lambda s: self.omega(s) - omega, *pair)) for pair in pieces]

    def forces(self, fraction: float) -> Array:
        """λ at a fraction."""
        low, high = self.slopes
        a, b = (knot.evaluation.point.forces for knot in (self.low, self.high))
        return hermite(a, low.forces, b, high.forces, fraction)

    def omega(self, fraction: float) -> float:
        """ω at a fraction, rad/s; at the ends that of the knots to the last bit."""
        a, b, c, d = self.controls
        rest = 1.0 - fraction
        return rest**3 * a + 3.0 * rest**2 * fraction * b + 3.0 * rest * fraction**2 * c + fraction**3 * d

    def fraction(self, evaluation: Evaluation) -> float:
        """Fraction of the plane that a point lies on."""
        return self.plane.gap(evaluation)

    def slope(self, fraction: float) -> tuple[Array, float]:
        """dw/ds and dω/ds at a fraction."""
        low, high = self.slopes
        a, b, c, d = self.controls
        rest = 1.0 - fraction
        rate = 3.0 * (rest**2 * (b - a) + 2.0 * rest * fraction * (c - b) + fraction**2 * (d - c))
        return rest * low.motion + fraction * high.motion, rate


def knot(balance: HarmonicBalance, evaluation: Evaluation, metric: Metric, before: Evaluation, after: Evaluation) -> Knot:
    """A solved point with the direction of the curve there, that in which it goes from the point before to the point after."""
    motion, amount = metric.weight * (after.w - before.w), metric.parameter * (after.point.omega - before.point.omega)
    condition = PathCondition("omega", motion, amount, 0.0)
    factors = balance.factorise(evaluation, condition)
    direction = balance.tangent(evaluation, "omega", factors) if factors.orientation else None
    return Knot(evaluation, condition, factors, direction)


def with_own_tangent(balance: HarmonicBalance, point: CurvePoint, before: Evaluation, after: Evaluation) -> CurvePoint:
    """A point with the tangent solved there, in the direction from the point before to the point after; as it is where the curve
    has none."""
    direction = knot(balance, point.evaluation, point.metric, before, after).direction
    if direction is None:
        return point
    length = point.metric.length(direction.motion, direction.rate)
    return replace(point, tangent=Tangent(direction.forces / length, direction.motion / length, direction.rate / length))


def segment(low: Knot, high: Knot, metric: Metric) -> Segment:
    """The segment between two knots in a metric."""
    chord = _straight(low, high)
    weight, amount = metric.weight * chord.motion, metric.parameter * chord.omega
    square = float(np.vdot(weight, chord.motion)) + amount * chord.omega
    plane = PathCondition("omega", weight / square, amount / square, 0.0)
    plane = replace(plane, target=plane.gap(low.evaluation))
    first, last = (_slope(knot.direction, chord, plane, metric) for knot in (low, high))
    controls = low.omega, low.omega + first.omega / 3.0, high.omega - last.omega / 3.0, high.omega
    return Segment(low, high, plane, (first, last), controls)


def _straight(low: Knot, high: Knot) -> _Slope:
    a, b = low.evaluation, high.evaluation
    return _Slope(b.point.forces - a.point.forces, b.w - a.w, b.point.omega - a.point.omega)


def _slope(direction: Direction | None, chord: _Slope, plane: PathCondition, metric: Metric) -> _Slope:
    """The direction so that the plane advances at rate one; the straight way where the curve has a corner."""
    if direction is None:
        return chord
    rate = plane.rate(direction.motion, direction.rate)
    length = metric.length(direction.motion, direction.rate)
    if not rate * metric.length(chord.motion, chord.omega) > SHARP * length:
        return chord
    return _Slope(direction.forces / rate, direction.motion / rate, direction.rate / rate)
