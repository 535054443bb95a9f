"""Interpolation of a curve between solved points by cubics of the contact forces; each value is checked or solved.

A step of the curve between two solved points is a segment: cubics through points and tangents, over planes across the straight
way. The step of Newton's method from a value to the curve estimates its error. The factors of the nearer solved point serve for
it, so that a value costs one evaluation of the balance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from stickslip.solve.balance.balance import Evaluation, Factors, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.system import Direction
from stickslip.solve.continuation.curve_points import CurvePoint, Metric, Tangent, hermite, moving_sizes, relative_metric
from stickslip.solve.continuation.newton import Correction, correct, fixed
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
    a, b = low.evaluation, high.evaluation
    chord = _Slope(b.point.forces - a.point.forces, b.w - a.w, b.point.omega - a.point.omega)
    weight, amount = metric.weight * chord.motion, metric.parameter * chord.omega
    square = float(np.vdot(weight, chord.motion)) + amount * chord.omega
    plane = PathCondition("omega", weight / square, amount / square, 0.0)
    plane = replace(plane, target=plane.gap(low.evaluation))
    first, last = (_slope(knot.direction, chord, plane, metric) for knot in (low, high))
    controls = low.omega, low.omega + first.omega / 3.0, high.omega - last.omega / 3.0, high.omega
    return Segment(low, high, plane, (first, last), controls)


def _slope(direction: Direction | None, chord: _Slope, plane: PathCondition, metric: Metric) -> _Slope:
    """The direction so that the plane advances at rate one; the straight way where the curve has a corner."""
    if direction is None:
        return chord
    rate = plane.rate(direction.motion, direction.rate)
    length = metric.length(direction.motion, direction.rate)
    if not rate * metric.length(chord.motion, chord.omega) > SHARP * length:
        return chord
    return _Slope(direction.forces / rate, direction.motion / rate, direction.rate / rate)


FOLD_DIVISIONS = 2
"""How often a step is divided where its frequency turns, so that the fold is a solved point."""

SAFETY = 2.0
"""Safety factor on the error estimate, Newton's step with the factors of a point nearby: it is of first order only."""

DIVISIONS = 6
"""How often a step is divided to find a point that Newton's method does not reach from the cubic."""


@dataclass(frozen=True, slots=True, eq=False)
class Value:
    """A point at a frequency: its evaluation, None where Newton's method failed; its estimated error relative to the
    amplitudes of the outputs; whether it was solved."""

    evaluation: Evaluation | None
    error: float
    solved: bool


NOT_SOLVED = Value(None, np.nan, solved=True)


class Interpolation:
    """One curve, by its solved points in the order of travel; tolerance: relative error up to which a value is not solved."""

    def __init__(self, balance: HarmonicBalance, points: Sequence[Point], tolerance: float) -> None:
        self.balance, self.tolerance = balance, tolerance
        self.evaluations = [balance.evaluate(point) for point in points]
        self.omegas = np.array([point.omega for point in points])
        sizes = np.array([moving_sizes(evaluation.w, balance.rows) for evaluation in self.evaluations])
        self.least = 0.02 * sizes.max(axis=0)
        self.scale = float(np.ptp(self.omegas)) / 10.0 or 1.0
        self.known: dict[int, Knot] = {}

    def values(self, wanted: Array) -> list[list[Value]]:
        """The values at each frequency in rad/s, one for every time that the curve passes it, in the order of travel."""
        met = np.abs(wanted[:, None] - self.omegas) <= SAME * wanted[:, None]
        found: list[list[Value]] = [[] for _ in wanted]
        for k, evaluation in enumerate(self.evaluations):
            for i in np.flatnonzero(met[:, k]):
                found[i].append(Value(evaluation, 0.0, solved=True))
            if k + 1 < len(self.evaluations):
                self._within(k, wanted, found)
        return found

    def between(self, k: int, fraction: float) -> Evaluation | None:
        """The point at a fraction of the step from point k to the next, solved on a plane across it; None where that fails."""
        part = segment(self._knot(k), self._knot(k + 1), self._metric(k))
        correction = self._across(part, fraction)
        return correction.evaluation if correction.converged else None

    def curve(self) -> list[CurvePoint]:
        """The solved points with their tangents, as a continuation has them; of two at one place only the first, and none where
        the curve has no direction.
        """
        kept: list[CurvePoint] = []
        for k, evaluation in enumerate(self.evaluations):
            if k and not self._apart(k - 1):
                continue
            found, metric, length = self._knot(k), self._metric(k), 0.0
            direction = found.direction
            if direction is None:
                continue
            scale = metric.length(direction.motion, direction.rate)
            tangent = Tangent(direction.forces / scale, direction.motion / scale, direction.rate / scale)
            if kept:
                plane, before = kept[-1].across("omega"), kept[-1]
                ends = [plane.rate(e.w, e.point.omega) for e in (before.evaluation, evaluation)]
                length = abs(ends[1] - ends[0])  # behind a sharp corner the curve goes back through the planes
            kept.append(CurvePoint(evaluation, tangent, metric, 0, found.factors.size, length))
        return kept

    def _within(self, k: int, wanted: Array, found: list[list[Value]]) -> None:
        """Add the values between the points k and k + 1, of which one may be at a frequency itself."""
        around = self.omegas[max(k - 1, 0) : k + 3]
        margin = float(np.ptp(around))
        near = np.flatnonzero((wanted > around.min() - margin) & (wanted < around.max() + margin))
        if not near.size or not self._apart(k):
            return
        metric = self._metric(k)
        for part in self._divided_at_folds(segment(self._knot(k), self._knot(k + 1), metric), metric, FOLD_DIVISIONS):
            for i in near[(wanted[near] >= min(part.controls)) & (wanted[near] <= max(part.controls))]:
                found[i] += self._passed(part, metric, float(wanted[i]), DIVISIONS)

    def _apart(self, k: int) -> bool:
        """Whether the points k and k + 1 are two."""
        a, b = self.evaluations[k : k + 2]
        return a.point.omega != b.point.omega or not np.array_equal(a.w, b.w)

    def _metric(self, k: int) -> Metric:
        w, rows = self.evaluations[k].w, self.balance.rows
        return relative_metric(w, rows, np.maximum(moving_sizes(w, rows), self.least).tolist(), self.scale)

    def _knot(self, k: int) -> Knot:
        if k not in self.known:
            around = self.evaluations[max(k - 1, 0)], self.evaluations[min(k + 1, len(self.evaluations) - 1)]
            self.known[k] = knot(self.balance, self.evaluations[k], self._metric(k), *around)
            self.known.pop(k - 2, None)
        return self.known[k]

    def _divided_at_folds(self, part: Segment, metric: Metric, divisions: int) -> Iterator[Segment]:
        folds = part.folds()
        halves = self._halves(part, metric, folds[0]) if folds and divisions else None
        if halves is None:
            yield part
            return
        for half in halves:
            yield from self._divided_at_folds(half, metric, divisions - 1)

    def _halves(self, part: Segment, metric: Metric, fraction: float) -> tuple[Segment, Segment] | None:
        """The segment divided at a point solved on a plane across it; None where Newton's method fails."""
        correction = self._across(part, fraction)
        if not correction.converged:
            return None
        middle = knot(self.balance, correction.evaluation, metric, part.low.evaluation, part.high.evaluation)
        return segment(part.low, middle, metric), segment(middle, part.high, metric)

    def _across(self, part: Segment, fraction: float) -> Correction:
        """Newton's method on a plane across a segment."""
        plane = replace(part.plane, target=part.plane.target + fraction)
        start = Point(part.forces(fraction), part.omega(fraction), part.low.evaluation.point.level)
        return correct(self.balance, start, plane, iterations=12, halvings=8)

    def _passed(self, part: Segment, metric: Metric, omega: float, divisions: int) -> list[Value]:
        """The values at a frequency on a segment; it is divided until each solved point is the one that its cubic predicted."""
        places = part.crossings(omega)
        values = [self._value(part, place, omega) for place in places]
        if all(_predicted(part, place, value, len(places)) for place, value in zip(places, values, strict=True)):
            return values
        halves = self._halves(part, metric, 0.5) if divisions else None
        if halves is None:
            return [NOT_SOLVED for _ in values]
        return [value for half in halves for value in self._passed(half, metric, omega, divisions - 1)]

    def _value(self, part: Segment, place: float, omega: float) -> Value:
        start = Point(part.forces(place), omega, part.low.evaluation.point.level)
        evaluation = self.balance.evaluate(start)
        error = self._error(part, place, evaluation)
        if error <= self.tolerance:
            return Value(evaluation, error, solved=False)
        correction = correct(self.balance, start, fixed("omega", omega), iterations=12, halvings=8)
        return Value(correction.evaluation, 0.0, solved=True) if correction.converged else NOT_SOLVED

    def _error(self, part: Segment, place: float, evaluation: Evaluation) -> float:
        """Largest share of an output's amplitude in Newton's step to the curve, and back along it, times the safety factor."""
        balance, point = self.balance, evaluation.point
        along, rate = part.slope(place)
        if rate == 0.0:
            return np.inf
        nearer = part.high if place > 0.5 else part.low
        if np.array_equal(nearer.evaluation.unknown, evaluation.unknown):
            condition, factors = nearer.condition, nearer.factors
        else:
            condition = part.plane
            factors = balance.factorise(evaluation, condition)
        condition = replace(condition, target=condition.rate(evaluation.w, point.omega))
        forces, amount = balance.newton_step(evaluation, condition, factors)
        off = balance.linear.change(forces, point.omega)
        off += amount * (balance.linear.slope(point.forces, point.omega, point.level, by_level=False) - along / rate)
        outputs = slice(balance.rows, None)
        amplitudes = np.hypot(*evaluation.w[outputs, self.balance.first].T)
        share = np.linalg.norm(off[outputs], axis=1) / np.maximum(amplitudes, np.finfo(float).tiny)
        return SAFETY * float(share.max())


def _predicted(part: Segment, place: float, value: Value, places: int) -> bool:
    """Whether a value lies where its segment was to pass the frequency, and not where it passes it another time."""
    if value.evaluation is None:
        return False
    return not value.solved or abs(part.fraction(value.evaluation) - place) < 0.5 / places
