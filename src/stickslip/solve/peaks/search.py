"""Resonance peaks, solved: the points of a curve at which a measure of an output, its first harmonic say, is largest.

Sampling and stick-slip make a curve piecewise smooth: near a flat top stand many small cusps, one for each sample that an
event passes. The search is therefore a branch and bound: slopes around an interval, and how far slopes nearby were from what
their neighbours predicted, bound the amplitude inside it; the interval of the highest bound is divided until no bound exceeds
the best point by more than the tolerance. What one search has solved serves the searches of all other outputs and measures.

Between two solved places the size of an output follows the cubic through their values with their slopes.
"""

from bisect import bisect_left, bisect_right, insort
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import copysign, sqrt
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure
from stickslip.solve.continuation.curve_points import ROUNDING, CurvePoint, Tangent, hermite
from stickslip.solve.continuation.interpolation import Interpolation, with_own_tangent
from stickslip.solve.continuation.newton import correct
from stickslip.support.checks import Array


class Cubic(NamedTuple):
    """Values a and b at the fractions 0 and 1 with slopes da and db over the whole interval: a' = da + d f + c f²."""

    a: float
    b: float
    da: float
    db: float

    @property
    def _bend(self) -> tuple[float, float]:
        """c and d."""
        return 3.0 * (2.0 * (self.a - self.b) + self.da + self.db), 2.0 * (3.0 * (self.b - self.a) - 2.0 * self.da - self.db)

    @property
    def controls(self) -> tuple[float, float, float, float]:
        """The control points; values in between lie between the least and the largest of them."""
        return self.a, self.a + self.da / 3.0, self.b - self.db / 3.0, self.b

    def at(self, f: float) -> float:
        """The value at a fraction."""
        change = f * f * (3.0 - 2.0 * f) * (self.b - self.a)
        return self.a + f * (1.0 - f) ** 2 * self.da - f * f * (1.0 - f) * self.db + change

    def slope(self, f: float) -> float:
        """The slope over the whole interval at a fraction."""
        mean = 6.0 * f * (1.0 - f) * (self.b - self.a)
        return mean + (1.0 - f) * (1.0 - 3.0 * f) * self.da - f * (2.0 - 3.0 * f) * self.db

    @property
    def inner_extremes(self) -> list[float]:
        """Fractions of the two extremes that a cubic may have between ends whose slopes have one sign."""
        if self.da * self.db <= 0.0:
            return []
        square, linear = self._bend
        discriminant = linear * linear - 4.0 * square * self.da
        if square == 0.0 or discriminant <= 0.0:
            return []
        outer = -0.5 * (linear + copysign(sqrt(discriminant), linear))
        turns = sorted((outer / square, self.da / outer))
        return turns if turns[0] > 0.0 and turns[1] < 1.0 else []

    @property
    def trough(self) -> float:
        """Fraction of the lowest place of a cubic that falls, or is level, at its beginning and rises at its end."""
        square, linear = self._bend
        # The root that the slope crosses upwards, in the form that subtracts no two numbers of one sign. Where the linear term is
        # not positive, the square one is, since the slope rises.
        root = sqrt(max(linear * linear - 4.0 * square * self.da, 0.0))
        fraction = (root - linear) / (2.0 * square) if linear <= 0.0 else -2.0 * self.da / (linear + root)
        return min(fraction, 1.0)

    @property
    def top(self) -> float:
        """Fraction of the highest place of a cubic that rises at its beginning and falls at its end."""
        return Cubic(-self.a, -self.b, -self.da, -self.db).trough

    @property
    def lowest(self) -> float:
        """The lower end, or the lowest value of a cubic that falls and rises again."""
        return self.at(self.trough) if self.da < 0.0 < self.db else min(self.a, self.b)


PROMINENCE = 1e-3
"""Two maxima count as one peak unless the curve dips between them by this share of the lower one."""

SAME_PEAK = 1e-3
"""Relative distance, in frequency or in height, within which two peaks are taken for the same one."""

STEEPER = 2.0
"""By how many times the errors of slopes nearby slopes inside an interval may be off, and how much steeper than any known nearby
they may be where no errors are known."""

SPREAD = 0.5
"""Share of their own range by which slopes inside an interval may exceed those known of it."""

NEAR_AN_END = 0.25
"""Share of an interval from its ends within which a division leaves most of it, which is then divided in the middle."""

CORNER = 0.1
"""Share of the change of slope over an interval from which on an error of the predicted slope is taken for a corner."""


@dataclass(frozen=True, slots=True, eq=False)
class SegmentPoint:
    """A solved place at `fraction` of segment `segment`: arc length, and slopes of motion, λ and ω along it."""

    segment: int
    fraction: float
    length: float
    motion_slope: Array
    forces_slope: Array
    omega_slope: float
    point: CurvePoint


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """A place with the size of one output there, by the measure that is searched, and its slope."""

    place: SegmentPoint
    amplitude: float
    slope: float


@dataclass(frozen=True, slots=True, eq=False)
class Interval:
    """Two samples of one segment; slope_error: how far slopes at its ends were from what their neighbours predicted, None where
    none of the same segment is known. left: what its division near one end has left, which is divided in the middle."""

    low: Sample
    high: Sample
    slope_error: float | None = None
    left: bool = False

    @property
    def width(self) -> float:
        return self.high.place.length - self.low.place.length

    @property
    def ends(self) -> tuple[float, float]:
        """Arc lengths of both ends."""
        return self.low.place.length, self.high.place.length

    @property
    def mean_slope(self) -> float:
        """Slope from end to end; of the ends where they have come together to rounding."""
        if self.width == 0.0:
            return 0.5 * (self.low.slope + self.high.slope)
        return (self.high.amplitude - self.low.amplitude) / self.width

    @property
    def uncertainty(self) -> float:
        """By how much slopes inside may differ from those known: the error of earlier predictions or of the mean."""
        return max(abs(self.mean_slope - 0.5 * (self.low.slope + self.high.slope)), self.slope_error or 0.0)

    @property
    def height(self) -> float:
        """Where the tangents of a rising and a falling end meet, about the highest amplitude inside."""
        a, b = self.low, self.high
        if not a.slope > 0.0 > b.slope:
            return max(a.amplitude, b.amplitude)
        return a.amplitude + a.slope * (b.amplitude - a.amplitude - b.slope * self.width) / (a.slope - b.slope)

    @property
    def cubic(self) -> Cubic:
        """The cubic through the amplitudes and slopes of both ends."""
        return Cubic(self.low.amplitude, self.high.amplitude, self.low.slope * self.width, self.high.slope * self.width)

    def fraction(self, share: float) -> float:
        """Fraction of the segment at a share of the interval."""
        return self.low.place.fraction + share * (self.high.place.fraction - self.low.place.fraction)

    def bound(self, least: float, largest: float) -> float:
        """Highest amplitude inside, for slopes between `least` and `largest`."""
        a, b = self.low, self.high
        if largest <= 0.0 or least >= 0.0 or not self.width:
            return max(a.amplitude, b.amplitude)
        return a.amplitude + largest * (b.amplitude - a.amplitude - least * self.width) / (largest - least)

    def division(self) -> float:
        """Fraction of the segment to solve next: the maximum of the cubic where earlier ones predicted slopes well, that of the
        tangents of both ends where there is a corner, else the middle, as in what such a division has left."""
        a, b = self.low, self.high
        share = 0.5
        if a.slope > 0.0 > b.slope and self.width and not self.left:
            smooth = self.slope_error is not None and self.slope_error < CORNER * (a.slope - b.slope)
            meeting = (b.amplitude - a.amplitude - b.slope * self.width) / (a.slope - b.slope) / self.width
            share = min(max(self.cubic.top if smooth else meeting, 0.01), 0.99)
        return self.fraction(share)

    def divided(self, middle: Sample) -> "list[Interval]":
        """The two parts; the slope error of both is the difference, in the middle, to the cubic through the ends."""
        share = (middle.place.length - self.low.place.length) / self.width if self.width else 0.5
        predicted = self.cubic.slope(share) / self.width if self.width else self.mean_slope
        slope_error = abs(middle.slope - predicted)
        last, first = share > 1.0 - NEAR_AN_END, share < NEAR_AN_END
        return [Interval(self.low, middle, slope_error, last), Interval(middle, self.high, slope_error, first)]


def highest_inside(intervals: list[Interval], i: int) -> float:
    """Bound of the amplitude inside interval i: its slopes, and the uncertainty of its neighbours' too.

    Slopes inside lie between those of the ends and the mean one, or exceed them by a share of their range and by the uncertainty
    of slopes nearby. Where no division has shown yet how well slopes are predicted, they may be as steep as any nearby.
    """
    interval, around = intervals[i], intervals[max(i - 1, 0) : i + 2]
    if interval.slope_error is None:
        steepness = STEEPER * max(max(abs(each.low.slope), abs(each.high.slope), each.uncertainty) for each in around)
        return interval.bound(-steepness, steepness)
    known = interval.low.slope, interval.high.slope, interval.mean_slope
    spare = STEEPER * max(each.uncertainty for each in around) + SPREAD * (max(known) - min(known))
    return interval.bound(min(known) - spare, max(known) + spare)


def sampled(place: SegmentPoint, row: int, measure: Measure) -> Sample:
    return Sample(place, *slope_along(measure, place.point, row, place.motion_slope, place.omega_slope))


def slope_along(measure: Measure, point: CurvePoint, row: int, motion: Array, omega: float) -> tuple[float, float]:
    """The size of a row at a point, and its slope along a direction of the curve in motion and ω."""
    size, slope = measure.slope(point.evaluation.w[row], point.point.omega, motion[row], omega)
    return size, float(slope)


def hill(intervals: list[Interval], tops: list[Interval]) -> list[Interval]:
    """The intervals around tops, up to a trough that parts them from a higher place or dips by `PROMINENCE`."""
    ends = [next(i for i, part in enumerate(intervals) if part.low.place is top.low.place) for top in (tops[0], tops[-1])]
    height = max(sample.amplitude for top in tops for sample in (top.low, top.high))

    def parted(interval: Interval, far: Sample) -> bool:
        if not interval.low.slope <= 0.0 < interval.high.slope:
            return False
        dips = interval.cubic.lowest < (1.0 - PROMINENCE) * height
        return dips or far.amplitude > (1.0 + PROMINENCE) * height

    first, last = ends
    while first > 0 and not parted(intervals[first - 1], intervals[first - 1].low):
        first -= 1
    while last < len(intervals) - 1 and not parted(intervals[last + 1], intervals[last + 1].high):
        last += 1
    return intervals[first : last + 1]


def intervals_between(samples: list[Sample]) -> list[Interval]:
    """The intervals between samples of a segment in order; each inner sample gives the slope error beside it."""
    inner = range(1, len(samples) - 1)
    errors = {i: Interval(samples[i - 1], samples[i + 1]).divided(samples[i])[0].slope_error or 0.0 for i in inner}
    beside = [[errors[k] for k in (i, i + 1) if k in errors] for i in range(len(samples) - 1)]
    return [Interval(a, b, max(known, default=None)) for (a, b), known in zip(pairwise(samples), beside, strict=True)]


TOLERANCE = 1e-8
"""Relative amplitude by which a peak may be below the highest bound."""

SHALLOW = 0.01
"""Depth of a trough, relative to the height beside it, up to which the corners that samples make may stand in it."""

SOLVES = 300
SHARES = (0.5, 0.25, 0.75)
"""Shares of an interval at which it is divided where Newton's method fails at the one of choice."""

NARROW = 1e-9
"""Share of the arc length searched below which an interval is not divided again: where the curve turns back through the planes of
a step, its slope there has no bound."""

DEPTH = 3
"""How often an interval that could not be divided is searched as a curve of its own."""

MATTERS = 1e-3
"""Share by which a peak may be higher where Newton's method failed beside it, or divisions ran out, from which on curves say so:
in less, rounding and the corners that samples make end the search."""

NEIGHBOURS = 2
"""Intervals searched on each side of those whose tops stand out."""


@dataclass(frozen=True, slots=True)
class Unproven:
    """Where a peak may be higher than the one that was found: ω in rad/s, the height found, and the bound of what may be."""

    omega: float
    height: float
    bound: float

    @property
    def share(self) -> float:
        """By which share of the height found the peak may be higher, at most."""
        return self.bound / self.height - 1.0


@dataclass(frozen=True, eq=False)
class Peaks:
    """Peaks along a curve; with nothing `unproven` each of them is proven highest, to `MATTERS` of itself.

    steps: for each peak the k of the step of the curve, from point k to the next one, that it lies in.
    """

    points: tuple[CurvePoint, ...]
    steps: tuple[int, ...]
    unproven: tuple[Unproven, ...]


_fraction = attrgetter("fraction")

Dips = Callable[[SegmentPoint, SegmentPoint, float], bool]
"""Whether a curve dips between two places, by `PROMINENCE` of a height."""


def _gather(tops: list[list[Interval]], more: list[Interval], dips: Dips) -> None:
    """Add tops, in the order of the curve, to the last group, or begin another one where the curve dips after its highest."""
    for top in more:
        highest = max(tops[-1], key=lambda each: each.height) if tops else None
        if highest is None or dips(highest.high.place, top.low.place, min(highest.height, top.height)):
            tops.append([top])
        else:
            tops[-1].append(top)


def _prominent(found: list[Sample], dips: Dips) -> list[Sample]:
    """Maxima between which the curve dips; of the others only the highest."""
    kept: list[Sample] = []
    for sample in found:
        if kept:
            last = kept[-1]
            if not dips(last.place, sample.place, min(last.amplitude, sample.amplitude)):
                if sample.amplitude > last.amplitude:
                    kept[-1] = sample
                continue
        kept.append(sample)
    return kept


class PeakSearch:
    """Searches the peaks of a curve in ω; the ends of the curve do not count.

    tolerance: relative amplitude by which a peak may be too low; depth: of searches in parts of steps of other searches; band: ω
    in rad/s, outside of which nothing is the highest; solves: solutions computed so far.
    """

    def __init__(
        self,
        balance: HarmonicBalance,
        curve: Sequence[CurvePoint],
        tolerance: float = TOLERANCE,
        depth: int = 0,
        band: tuple[float, float] = (0.0, np.inf),
    ) -> None:
        self.balance, self.tolerance, self.depth, self.band = balance, tolerance, depth, band
        self.curve = _with_own_tangents(balance, curve)
        self.lengths = np.cumsum([point.length for point in curve])
        self.moving = np.max([np.abs(point.evaluation.w[:, 1:]).max(axis=1) for point in curve], axis=0) if curve else np.zeros(0)
        self.solved: dict[int, list[SegmentPoint]] = {}
        self.failed: set[tuple[int, float]] = set()
        self.solves = 0
        self.planes: dict[int, tuple[PathCondition, float]] = {}
        self.samples: dict[SegmentPoint, Sample] = {}
        self.apart: dict[tuple[tuple[float, float], int, Measure], tuple[list[Sample], list[Unproven]]] = {}

    def peaks(self, output: int, measure: Measure = DISPLACEMENT_AMPLITUDE, least: float = 0.0) -> Peaks:
        """All peaks of a measure of an output, also outside the band; left out unsolved are those below the share `least` of the
        highest point inside it."""
        row = self.balance.rows + output
        tops, dips = self._tops(row, measure, least)
        searched = [self._highest(together, row, measure) for together in tops]
        found = [best for best, _ in searched if best is not None]
        places = [sample.place for sample in _prominent(found, dips)]
        unproven = tuple(each for _, missed in searched for each in missed)
        return Peaks(tuple(place.point for place in places), tuple(place.segment for place in places), unproven)

    def highest(self, output: int, measure: Measure, least: float) -> Peaks:
        """The highest peak of a measure of an output inside the band alone: a lower one is searched until it is shown to be
        lower."""
        row = self.balance.rows + output
        best, unproven = None, []
        tops, _ = self._tops(row, measure, least)
        tops = [
            each for each in tops if any(self.holds(end.place.point.point.omega) for top in each for end in (top.low, top.high))
        ]
        for together in sorted(tops, key=lambda tops: -max(top.height for top in tops)):
            floor = best.amplitude if best is not None else 0.0
            found, missed = self._highest(together, row, measure, floor)
            unproven += missed
            if found is not None and found.amplitude > floor and self.holds(found.place.point.point.omega):
                best = found
        place = [] if best is None else [best.place]
        return Peaks(tuple(each.point for each in place), tuple(each.segment for each in place), tuple(unproven))

    def holds(self, omega: float) -> bool:
        """Whether a frequency lies inside the band, its ends included."""
        return self.band[0] <= omega <= self.band[1]

    def _tops(self, row: int, measure: Measure, least: float) -> tuple[list[list[Interval]], Dips]:
        """The tops of a row of motion, in groups between which the curve dips, and the test whether it dips."""
        tops: list[list[Interval]] = []
        rounding = ROUNDING * self.moving.max(initial=0.0)
        if not self.curve or self.moving[row] <= rounding:
            return tops, lambda first, last, height: False
        self.samples.clear()
        measured = [slope_along(measure, p, row, p.tangent.motion, p.tangent.parameter) for p in self.curve]
        sizes = np.array([size for size, _ in measured])
        slopes = [slope for _, slope in measured]
        dips = self._dips(row, measure, sizes, slopes)
        inside = [self.holds(point.point.omega) for point in self.curve]
        # An output behind a gap that is open rests but for rounding, which has peaks, too.
        still = rounding / self.moving[row] * float(sizes.max())
        floor = max(least * float(sizes[inside].max(initial=0.0)), still)
        for k in range(len(self.curve) - 1):
            if sizes[k : k + 2].max() < floor:
                continue
            length = self.curve[k + 1].length
            cubic = Cubic(sizes[k], sizes[k + 1], length * slopes[k], length * slopes[k + 1])
            for turn in cubic.inner_extremes:
                self._solve_inside(k, turn)
            if cubic.da < 0.0 < cubic.db and cubic.lowest > (1.0 - SHALLOW) * max(cubic.a, cubic.b):
                self._solve_inside(k, cubic.trough)
                for part in self._intervals(k, row, measure):
                    for turn in part.cubic.inner_extremes:
                        self._solve_inside(k, part.fraction(turn))
            if slopes[k] > 0.0 >= slopes[k + 1] or k in self.solved:
                _gather(tops, [i for i in self._intervals(k, row, measure) if _holds_a_top(i) and i.height > still], dips)
        return tops, dips

    def _dips(self, row: int, measure: Measure, sizes: Array, slopes: Sequence[float]) -> Dips:
        """The test whether the curve dips between two of its places; where none known shows it, troughs between are solved."""

        def lowest(first: SegmentPoint, last: SegmentPoint) -> float:
            least = float(sizes[first.segment + 1 : last.segment + 1].min(initial=np.inf))
            for k in range(first.segment, last.segment + 1):
                known = self.solved.get(k, [])
                begin = bisect_left(known, first.fraction, key=_fraction) if k == first.segment else 0
                end = bisect_right(known, last.fraction, key=_fraction) if k == last.segment else len(known)
                least = min([least, *(sample.amplitude for sample in self._samples(known[begin:end], row, measure))])
            return least

        def dips(first: SegmentPoint, last: SegmentPoint, height: float) -> bool:
            enough = (1.0 - PROMINENCE) * height
            if lowest(first, last) < enough:
                return True
            for k in range(first.segment + 1, min(last.segment + 1, len(self.curve) - 1)):
                length = self.curve[k + 1].length
                if length > 0.0 and slopes[k] < 0.0 < slopes[k + 1]:
                    self._solve_inside(k, Cubic(sizes[k], sizes[k + 1], length * slopes[k], length * slopes[k + 1]).trough)
            return lowest(first, last) < enough

        return dips

    def _highest(
        self, tops: list[Interval], row: int, measure: Measure, floor: float = 0.0
    ) -> tuple[Sample | None, list[Unproven]]:
        """The highest place around tops that no trough parts, None where the curve rises on to another peak; and where Newton's
        method failed, or divisions ran out, although a higher one may lie there. Nothing below `floor` is searched for."""
        first = max(tops[0].low.place.segment - NEIGHBOURS, 0)
        last = min(tops[-1].low.place.segment + NEIGHBOURS, len(self.curve) - 2)
        intervals = hill([i for k in range(first, last + 1) for i in self._intervals(k, row, measure)], tops)
        unsolved: set[tuple[float, float]] = set()

        def bound(i: int) -> float:
            return 0.0 if intervals[i].ends in unsolved else highest_inside(intervals, i)

        bounds = [bound(i) for i in range(len(intervals))]
        best = max((end for i in intervals for end in (i.low, i.high)), key=lambda end: end.amplitude)
        narrow = NARROW * (intervals[-1].high.place.length - intervals[0].low.place.length)
        for _ in range(SOLVES):
            i = bounds.index(max(bounds))
            if bounds[i] <= (1.0 + self.tolerance) * max(best.amplitude, floor):
                break
            place = self._divide(intervals[i]) if intervals[i].width > narrow else None
            if place is None:
                unsolved.add(intervals[i].ends)
                bounds[i] = 0.0
                continue
            middle = sampled(place, row, measure)
            intervals[i : i + 1] = intervals[i].divided(middle)
            bounds[i : i + 1] = [0.0, 0.0]
            for k in range(max(i - 1, 0), min(i + 3, len(intervals))):
                bounds[k] = bound(k)
            best = max(best, middle, key=lambda end: end.amplitude)
        low, high = intervals[0].low, intervals[-1].high
        rises_on = (best is low and low.slope < 0.0) or (best is high and high.slope > 0.0)
        if rises_on:
            return None, []
        bounds = [highest_inside(intervals, i) for i in range(len(intervals))]
        unproven: list[Unproven] = []
        for interval, most in zip(intervals, bounds, strict=True):
            if most > (1.0 + MATTERS) * max(best.amplitude, floor):
                key = interval.ends, row, measure
                if key not in self.apart:  # hills that overlap share it
                    self.apart[key] = self._by_itself(interval, row, measure, most)
                higher, missed = self.apart[key]
                best = max(best, *higher, key=lambda end: end.amplitude) if higher else best
                unproven += missed
        unproven = [replace(each, height=max(best.amplitude, floor)) for each in unproven]
        return best, [each for each in unproven if each.share > MATTERS]

    def _by_itself(self, interval: Interval, row: int, measure: Measure, most: float) -> tuple[list[Sample], list[Unproven]]:
        """The peaks of an interval that could not be divided, searched on planes and arc lengths of its own: those of a whole
        step of the curve meet a narrow resonance on both of its sides; most: the bound without that."""
        low, high = interval.low.place, interval.high.place
        part = Interpolation(self.balance, [low.point.point, high.point.point], MATTERS).curve() if self.depth < DEPTH else []
        if len(part) < 2:
            return [], [Unproven(low.point.point.omega, most, most)]
        search = PeakSearch(self.balance, part, self.tolerance, self.depth + 1)
        found = search.peaks(row - self.balance.rows, measure)
        self.solves += search.solves
        middle = 0.5 * (low.fraction + high.fraction)
        condition, span = self._plane(low.segment, middle)
        places = [self._place(low.segment, middle, point, condition, span) for point in found.points]
        return [sampled(place, row, measure) for place in places], list(found.unproven)

    def _divide(self, interval: Interval) -> SegmentPoint | None:
        """A place inside an interval: where the highest is expected, else in the middle or beside it."""
        for fraction in (interval.division(), *(interval.fraction(share) for share in SHARES)):
            place = self._solve(interval.low.place, interval.high.place, fraction)
            if place is not None:
                return place
        return None

    def _intervals(self, k: int, row: int, measure: Measure) -> list[Interval]:
        """The intervals between the solved places of segment k."""
        return intervals_between(self._samples(self._places(k), row, measure))

    def _samples(self, places: Sequence[SegmentPoint], row: int, measure: Measure) -> list[Sample]:
        """The size of an output at places, found once a search: a top is compared with all between it and the highest."""
        self.samples.update((place, sampled(place, row, measure)) for place in places if place not in self.samples)
        return [self.samples[place] for place in places]

    def _places(self, k: int) -> list[SegmentPoint]:
        """What is solved of segment k, in order; its two ends at least."""
        if k not in self.solved:
            condition, span = self._plane(k, 0.0)
            self.solved[k] = [self._place(k, f, self.curve[k + int(f)], condition, span) for f in (0.0, 1.0)]
        return self.solved[k]

    def _plane(self, k: int, fraction: float) -> tuple[PathCondition, float]:
        """The path condition at a fraction of segment k, and how far it reaches over the whole segment."""
        if k not in self.planes:
            current, following = self.curve[k], self.curve[k + 1]
            plane = current.across("omega")
            ends = [plane.rate(p.evaluation.w, p.point.omega) for p in (current, following)]
            self.planes[k] = replace(plane, target=ends[0]), ends[1] - ends[0]
        plane, span = self.planes[k]
        return PathCondition("omega", plane.weight, plane.slope, plane.target + fraction * span), span

    def _place(self, k: int, fraction: float, point: CurvePoint, condition: PathCondition, span: float) -> SegmentPoint:
        tangent = point.tangent
        # Behind a sharp corner the curve goes back through the planes of the step; slopes stay those along the way.
        rate = abs(condition.rate(tangent.motion, tangent.parameter))
        length = float(self.lengths[k]) + fraction * abs(span)
        return SegmentPoint(k, fraction, length, tangent.motion / rate, tangent.forces / rate, tangent.parameter / rate, point)

    def _solve_inside(self, k: int, fraction: float) -> None:
        """Solve segment k at a fraction, unless a place nearby is solved; it joins the places of the segment."""
        places = self._places(k)
        after = next(i for i, place in enumerate(places) if place.fraction >= fraction)
        low, high = places[max(after - 1, 0)], places[after]
        if min(fraction - low.fraction, high.fraction - fraction) > 0.02:
            self._solve(low, high, fraction)

    def _solve(self, low: SegmentPoint, high: SegmentPoint, fraction: float) -> SegmentPoint | None:
        """A place between two of one segment, kept for other searches; None where Newton's method fails."""
        if (low.segment, fraction) in self.failed:
            return None
        share, width = (fraction - low.fraction) / (high.fraction - low.fraction), high.length - low.length
        a, b = low.point.point, high.point.point
        forces = hermite(a.forces, width * low.forces_slope, b.forces, width * high.forces_slope, share)
        condition, span = self._plane(low.segment, fraction)
        omega = Cubic(a.omega, b.omega, width * low.omega_slope, width * high.omega_slope).at(share)
        start = Point(forces, min(max(omega, min(a.omega, b.omega)), max(a.omega, b.omega)), a.level)
        self.solves += 1
        correction = correct(self.balance, start, condition, iterations=20, halvings=8, direction=0.0)
        direction, factors = correction.direction, correction.factors
        if direction is None or factors is None or not _between(low, high, correction.evaluation):
            self.failed.add((low.segment, fraction))
            return None
        tangent, metric = Tangent(*direction), self.curve[low.segment].metric
        point = CurvePoint(correction.evaluation, tangent, metric, correction.iterations, factors.size, 0.0)
        found = self._place(low.segment, fraction, point, condition, span)
        insort(self.solved[low.segment], found, key=_fraction)
        return found


def _holds_a_top(interval: Interval) -> bool:
    """Whether the amplitude has a maximum inside: it rises into the interval and falls out of it, or it rises at both ends (falls
    at both ends) although the far end is the lower one, as at a corner in which Newton's method fails."""
    low, high = interval.low, interval.high
    if low.slope > 0.0:
        return high.slope <= 0.0 or low.amplitude > high.amplitude
    return high.slope < 0.0 and high.amplitude > low.amplitude


def _between(low: SegmentPoint, high: SegmentPoint, found: Evaluation) -> bool:
    """Whether a place is on the curve between two others: a plane across a narrow resonance meets both of its sides.

    Where everything sticks the response is linear, and no frequency comes twice.
    """
    ends, width = (low.point.point.omega, high.point.point.omega), high.length - low.length
    linear = not any(evaluation.unknown.any() for evaluation in (low.point.evaluation, high.point.evaluation, found))
    if linear:
        return min(ends) <= found.point.omega <= max(ends)
    controls = *ends, ends[0] + width * low.omega_slope / 3.0, ends[1] - width * high.omega_slope / 3.0
    spare = max(controls) - min(controls)
    return min(controls) - spare <= found.point.omega <= max(controls) + spare


def _with_own_tangents(balance: HarmonicBalance, curve: Sequence[CurvePoint]) -> list[CurvePoint]:
    """The curve with the tangents of its two ends solved there, in the direction of travel.

    An end of the band is solved between two points and carries the tangent of one beyond it, which may lie past a maximum.
    """
    points = list(curve)
    for k, before, after in ((0, 0, 1), (-1, -2, -1)) if len(points) > 1 else ():
        points[k] = with_own_tangent(balance, points[k], points[before].evaluation, points[after].evaluation)
    return points
