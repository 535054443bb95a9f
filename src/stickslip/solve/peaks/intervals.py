"""A curve between its points, as one output sees it: solved places, the size of the output there, and intervals that bound it.

Between two places the size follows the cubic through their values with their slopes.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import copysign, sqrt
from typing import NamedTuple

from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.curve_points import CurvePoint
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
    def steepness(self) -> float:
        """The largest slope known in the interval, or by how much slopes inside may differ."""
        return max(abs(self.low.slope), abs(self.high.slope), self.uncertainty)

    @property
    def height(self) -> float:
        """Where the tangents of a rising and a falling end meet, about the highest amplitude inside."""
        a, b = self.low, self.high
        if not a.slope > 0.0 > b.slope:
            return max(a.amplitude, b.amplitude)
        return a.amplitude + a.slope * (b.amplitude - a.amplitude - b.slope * self.width) / (a.slope - b.slope)

    @property
    def trough(self) -> float:
        """The lower end, or the lowest place of the cubic where the curve falls and rises again."""
        return self.cubic.lowest

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
        steepness = STEEPER * max(each.steepness for each in around)
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
        dips = interval.trough < (1.0 - PROMINENCE) * height
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
