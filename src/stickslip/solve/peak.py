"""Resonance peaks, solved: the points of a curve at which a measure of an output, its first harmonic say, is largest.

Sampling and stick-slip make a curve piecewise smooth: near a flat top stand many small cusps, one for each sample that an
event passes. The search is therefore a branch and bound: slopes around an interval bound the amplitude inside it, and the
interval of the highest bound is divided until no bound exceeds the best point by more than the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.checks import Array
from stickslip.harmonic.balance import HarmonicBalance, PathCondition, Point
from stickslip.solve.continuation import CurvePoint, Tangent, hermite
from stickslip.solve.newton import correct

TOLERANCE = 1e-8
"""Relative amplitude by which a peak may be below the highest bound."""

PROMINENCE = 1e-3
"""Two maxima count as one peak unless the curve dips between them by this share of the lower one."""

STEEPER = 1.5
"""How much steeper than the slopes around it the curve is taken to be inside an interval."""

SOLVES = 300
NEIGHBOURS = 2


@dataclass(frozen=True, slots=True, eq=False)
class _Sample:
    """A solved place at `fraction` of segment `segment`: arc length, amplitude, and slopes of amplitude and λ along it."""

    segment: int
    fraction: float
    place: float
    amplitude: float
    slope: float
    forces_slope: Array
    point: CurvePoint


@dataclass(frozen=True, slots=True, eq=False)
class _Interval:
    low: _Sample
    high: _Sample

    @property
    def width(self) -> float:
        return self.high.place - self.low.place

    @property
    def steepness(self) -> float:
        return max(abs(self.low.slope), abs(self.high.slope))

    def bound(self, steepness: float) -> float:
        """Highest amplitude inside, for a curve nowhere steeper than `steepness`."""
        return 0.5 * (self.low.amplitude + self.high.amplitude + steepness * self.width)

    def division(self) -> float:
        """Fraction of the segment to solve next: where the tangents of both ends meet in a maximum, else the middle."""
        a, b = self.low, self.high
        share = 0.5
        if a.slope > 0.0 > b.slope:
            meeting = (b.amplitude - a.amplitude - b.slope * self.width) / (a.slope - b.slope) / self.width
            share = float(np.clip(meeting, 0.01, 0.99))
        return a.fraction + share * (b.fraction - a.fraction)


Measure = Callable[[Array], tuple[float, Array]]
"""A size of one row of motion (2H+1,), m, and its gradient by that row."""


@dataclass(frozen=True, eq=False)
class Peaks:
    """Peaks along a curve, and how many places near them Newton's method could not solve (0: each peak is proven highest)."""

    points: tuple[CurvePoint, ...]
    unsolved: int


def first_harmonic(motion: Array) -> tuple[float, Array]:
    """|X_1| = √(a1² + b1²)."""
    amplitude = float(np.hypot(motion[1], motion[2]))
    gradient = np.zeros_like(motion)
    gradient[1:3] = motion[1:3] / max(amplitude, np.finfo(float).tiny)
    return amplitude, gradient


def peaks(
    balance: HarmonicBalance,
    curve: Sequence[CurvePoint],
    output: int,
    measure: Measure = first_harmonic,
    least: float = 0.0,
    tolerance: float = TOLERANCE,
) -> Peaks:
    """All peaks of a measure of an output along a curve in ω, each solved; the ends of the band do not count.

    least: peaks that stand below this share of the highest point of the curve are left out unsolved; tolerance: relative
    amplitude by which a peak may be too low.
    """
    row = balance.rows + output
    search = _Search(balance, curve, row, measure, tolerance)
    measured = [measure(point.evaluation.w[row]) for point in curve]
    sizes = np.array([size for size, _ in measured])
    rising = [float(gradient @ p.tangent.motion[row]) > 0.0 for (_, gradient), p in zip(measured, curve, strict=True)]
    floor = least * float(sizes.max(initial=0.0))
    found = [
        search.highest(k) for k in range(len(curve) - 1) if rising[k] and not rising[k + 1] and sizes[k : k + 2].max() >= floor
    ]
    return Peaks(tuple(sample.point for sample in _prominent(found, sizes)), search.unsolved)


def _prominent(found: list[_Sample], sizes: Array) -> list[_Sample]:
    """Maxima between which the curve, of given sizes at its points, dips; of the others only the highest."""
    kept: list[_Sample] = []
    for sample in found:
        if kept:
            last = kept[-1]
            lower = min(last.amplitude, sample.amplitude)
            if min(sizes[last.segment + 1 : sample.segment + 1], default=lower) > (1.0 - PROMINENCE) * lower:
                if sample.amplitude > last.amplitude:
                    kept[-1] = sample
                continue
        kept.append(sample)
    return kept


def _bound(intervals: list[_Interval], i: int) -> float:
    """Bound of interval i with the slopes of its neighbours."""
    around = intervals[max(i - 1, 0) : i + 2]
    return intervals[i].bound(STEEPER * max(interval.steepness for interval in around))


class _Search:
    """Solves points between those of a curve and remembers how a segment is parametrised."""

    def __init__(
        self, balance: HarmonicBalance, curve: Sequence[CurvePoint], row: int, measure: Measure, tolerance: float
    ) -> None:
        self.balance, self.curve, self.row, self.measure, self.tolerance = balance, curve, row, measure, tolerance
        self.unsolved = 0
        self.places = np.cumsum([point.length for point in curve])

    def highest(self, segment: int) -> _Sample:
        """The highest place on the segments around a change from rising to falling."""
        first, last = max(segment - NEIGHBOURS, 0), min(segment + NEIGHBOURS, len(self.curve) - 2)
        intervals = [self._whole(k) for k in range(first, last + 1)]
        bounds = [_bound(intervals, i) for i in range(len(intervals))]
        best = max((end for i in intervals for end in (i.low, i.high)), key=lambda sample: sample.amplitude)
        for _ in range(SOLVES):
            i = int(np.argmax(bounds))
            if bounds[i] <= (1.0 + self.tolerance) * best.amplitude:
                break
            divided = intervals[i]
            middle = self._solve(divided, divided.division())
            if middle is None:
                self.unsolved += 1
                bounds[i] = 0.0
                continue
            intervals[i : i + 1] = [_Interval(divided.low, middle), _Interval(middle, divided.high)]
            bounds[i : i + 1] = [0.0, 0.0]
            for k in range(max(i - 1, 0), min(i + 3, len(intervals))):
                bounds[k] = _bound(intervals, k)
            best = max(best, middle, key=lambda sample: sample.amplitude)
        return best

    def _whole(self, k: int) -> _Interval:
        """Segment k from end to end."""
        condition, span = self._plane(k, 0.0)
        return _Interval(*(self._sample(k, f, self.curve[k + int(f)], condition, span) for f in (0.0, 1.0)))

    def _plane(self, k: int, fraction: float) -> tuple[PathCondition, float]:
        """The path condition at a fraction of segment k, and how far it reaches over the whole segment."""
        current, following = self.curve[k], self.curve[k + 1]
        weight = current.metric.weight * current.tangent.motion
        slope = current.metric.parameter * current.tangent.parameter
        ends = [float(np.vdot(weight, p.evaluation.w)) + slope * p.point.omega for p in (current, following)]
        span = ends[1] - ends[0]
        return PathCondition("omega", weight, slope, ends[0] + fraction * span), span

    def _sample(self, k: int, fraction: float, point: CurvePoint, condition: PathCondition, span: float) -> _Sample:
        size, gradient = self.measure(point.evaluation.w[self.row])
        tangent = point.tangent
        rate = condition.rate(tangent.motion, tangent.parameter)
        slope = float(gradient @ tangent.motion[self.row]) / rate
        return _Sample(k, fraction, self.places[k] + fraction * span, size, slope, tangent.forces / rate, point)

    def _solve(self, interval: _Interval, fraction: float) -> _Sample | None:
        """The place at a fraction of the interval's segment; None where Newton's method fails."""
        low, high = interval.low, interval.high
        share = (fraction - low.fraction) / (high.fraction - low.fraction)
        a, b = low.point.point, high.point.point
        forces = hermite(a.forces, interval.width * low.forces_slope, b.forces, interval.width * high.forces_slope, share)
        condition, span = self._plane(low.segment, fraction)
        start = Point(forces, a.omega + share * (b.omega - a.omega), a.level)
        correction = correct(self.balance, start, condition, iterations=20, halvings=8)
        if not correction.converged:
            return None
        factors = self.balance.factorise(correction.evaluation, condition)
        tangent = Tangent(*self.balance.tangent(correction.evaluation, "omega", factors))
        metric = self.curve[low.segment].metric
        point = CurvePoint(correction.evaluation, tangent, metric, correction.iterations, factors.size, 0.0)
        return self._sample(low.segment, fraction, point, condition, span)
