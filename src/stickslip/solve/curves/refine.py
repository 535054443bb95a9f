"""Refinement of a traced curve: solved points between its points, so that straight lines draw it, and its peaks, which a separate
search finds.

Continuation takes steps as long as its predictor allows, tens of points a curve. Between two of them the cubic through points and
tangents is a start so good that Newton's method needs a step or two, on planes across the curve: folds are no obstacle.
"""

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.continuation.curve_points import CurvePoint, between
from stickslip.solve.continuation.interpolation import Interpolation
from stickslip.solve.continuation.newton import correct
from stickslip.solve.curves.curve import Curve
from stickslip.solve.peaks.intervals import PROMINENCE, Cubic
from stickslip.solve.peaks.search import PeakSearch
from stickslip.support.checks import Array

MOST = 18
"""Into how many pieces a step is divided at most."""

THIRDS = (1.0 / 3.0, 2.0 / 3.0)

NEARLY_SOLVED = 3e-3
"""Residual up to which the cubic through a step shows how straight it is."""

FARTHEST = 1.5
"""How much farther than along the straight way a point inside a step may lie from its first end."""

SEEN = 1e-6
"""Share by which a peak may be below the highest point between its troughs."""


def refined(balance: HarmonicBalance, curve: Curve, tolerance: float = 5e-3) -> Curve:
    """The curve with its peaks, and with points where straight lines would miss an amplitude by more than `tolerance` of it."""
    dense = _filled(curve, lambda current, following: _Step(balance, current, following).inside(tolerance))
    return _with_missed_peaks(balance, dense)


def _with_missed_peaks(balance: HarmonicBalance, curve: Curve) -> Curve:
    """The curve with the peaks that stand among its points and were not seen from the ends of the steps around them."""
    peaks = [list(found) for found in curve.peaks]
    inserted: dict[int, list[CurvePoint]] = defaultdict(list)
    for output, found in enumerate(peaks):
        row = balance.rows + output
        sizes = np.array([curve.measure.size(point.evaluation.w[row], point.point.omega) for point in curve.points])
        places = {id(point): k for k, point in enumerate(curve.points)}
        known = [places[id(peak)] for peak in found]
        for low, high in _hills(sizes, PROMINENCE):
            inside = [k for k in known if low <= k <= high]
            top = low + int(np.argmax(sizes[low : high + 1]))
            if not curve.holds(curve.points[top].point.omega) or any(sizes[k] >= (1.0 - SEEN) * sizes[top] for k in inside):
                continue
            solved = [point.point for point in curve.points[max(low - 1, 0) : high + 2]]
            part = Interpolation(balance, solved, tolerance=1e-3).curve()
            peaks_of_part = PeakSearch(balance, part).peaks(output, curve.measure)
            # The ends of the part are beyond the troughs: a peak there is that of another hill.
            ends = solved[0].omega, solved[-1].omega
            pairs = zip(peaks_of_part.points, peaks_of_part.steps, strict=True)
            missed = [(peak, k) for peak, k in pairs if peak.point.omega not in ends and curve.holds(peak.point.omega)]
            if missed:
                found[:] = [peak for peak in found if not any(peak is curve.points[k] for k in inside)]
            for peak, k in missed:
                found.append(peak)
                before = next(i for i, point in enumerate(solved) if point is part[k].point)
                inserted[max(low - 1, 0) + before].append(peak)
    points = [each for k, point in enumerate(curve.points) for each in (point, *inserted[k])]
    return replace(curve, points=tuple(points), peaks=tuple(map(tuple, peaks)))


def _hills(sizes: Array, prominence: float) -> list[tuple[int, int]]:
    """From trough to trough around each maximum inside a row of sizes that rises by a share of itself out of them."""
    tops = [k for k in range(1, sizes.size - 1) if sizes[k - 1] < sizes[k] >= sizes[k + 1]]
    while tops:
        troughs = [0, *(a + int(np.argmin(sizes[a:b])) for a, b in pairwise(tops)), sizes.size - 1]
        higher = [max(sizes[troughs[i]], sizes[troughs[i + 1]]) for i in range(len(tops))]
        rises = [1.0 - trough / sizes[top] for top, trough in zip(tops, higher, strict=True)]
        if min(rises) >= prominence:
            return list(pairwise(troughs))
        del tops[int(np.argmin(rises))]
    return []


def with_peaks(curve: Curve) -> Curve:
    """The curve with its peaks as points of it."""
    return _filled(curve, lambda current, following: [])


def _filled(curve: Curve, inside: Callable[[CurvePoint, CurvePoint], Sequence[CurvePoint]]) -> Curve:
    """The curve with its peaks and the points inside each step, in the order of travel."""
    peaks: dict[int, list[CurvePoint]] = defaultdict(list)
    for output, steps in enumerate(curve.steps):
        for point, k in zip(curve.peaks[output] + curve.outside[output], steps, strict=True):
            if not any(point is other for other in (*curve.points[k : k + 2], *peaks[k])):
                peaks[k].append(point)
    points: list[CurvePoint] = list(curve.points[:1])
    for k, (current, following) in enumerate(pairwise(curve.points)):
        plane = current.across("omega")
        more = [*inside(current, following), *peaks[k]]
        points += sorted(more, key=lambda point: plane.rate(point.evaluation.w, point.point.omega))
        points.append(following)
    return replace(curve, points=tuple(points), steps=())


class _Step:
    """One step of a curve: the cubics of λ and ω through both ends and their tangents, over the fraction of the step.

    Points inside are solved on planes across the tangent of the first end; reach: how far these are apart over the whole step.
    """

    def __init__(self, balance: HarmonicBalance, current: CurvePoint, following: CurvePoint) -> None:
        self.balance, self.current, self.following = balance, current, following
        scale, length = following.metric.length(current.tangent.motion, current.tangent.parameter), following.length
        slopes = length * current.tangent.parameter, length * scale * following.tangent.parameter
        self.omega = Cubic(current.point.omega, following.point.omega, *slopes)
        plane = current.across("omega")
        first, last = (plane.rate(point.evaluation.w, point.point.omega) for point in (current, following))
        self.plane, self.reach = replace(plane, target=first), last - first
        self.ends = self._amplitudes(current.evaluation), self._amplitudes(following.evaluation)

    def inside(self, tolerance: float) -> list[CurvePoint]:
        """Solved points inside: none, or so many that the error of straight lines, of second order, is below tolerance."""
        if self.following.length <= 0.0 or self._straight(tolerance):
            return []
        thirds = {fraction: self._solved(fraction) for fraction in THIRDS}
        known = [point for point in thirds.values() if point is not None]
        error = max((self._chord_error(point.evaluation) for point in known), default=0.0)
        if error <= tolerance:
            return []
        pieces = min(3 * int(np.ceil(np.sqrt(error / tolerance) / 3.0)), MOST)
        fractions = [k / pieces for k in range(1, pieces)]
        found = [thirds[fraction] if fraction in thirds else self._solved(fraction) for fraction in fractions]
        return [point for point in found if point is not None]

    def _straight(self, tolerance: float) -> bool:
        """Whether the step is so straight that the cubic shows it, whose residual is evaluated and which costs no solution."""
        inside = (self.balance.evaluate(self._on_cubic(fraction)) for fraction in THIRDS)
        return all(each.error <= NEARLY_SOLVED and self._chord_error(each) <= 0.5 * tolerance for each in inside)

    def _on_cubic(self, fraction: float) -> Point:
        """The place at a fraction on the cubics."""
        forces = between(self.current, self.following, fraction)
        return Point(forces, self.omega.at(fraction), self.current.point.level)

    def _chord_error(self, inside: Evaluation) -> float:
        """Relative error of the straight line over frequency between both ends, at a point of the curve inside."""
        low, high, omega = self.omega.a, self.omega.b, inside.point.omega
        share = (omega - low) / (high - low) if min(low, high) < omega < max(low, high) else 0.5
        line, amplitude = (1.0 - share) * self.ends[0] + share * self.ends[1], self._amplitudes(inside)
        return float(np.max(np.abs(line - amplitude) / np.maximum(amplitude, np.finfo(float).tiny)))

    def _amplitudes(self, evaluation: Evaluation) -> Array:
        """|X_1| of every output, m."""
        return np.asarray(np.hypot(*evaluation.w[self.balance.rows :, self.balance.first].T))

    def _solved(self, fraction: float) -> CurvePoint | None:
        """The point on the plane at a fraction; None where Newton fails."""
        current = self.current
        condition = replace(self.plane, target=self.plane.target + fraction * self.reach)
        correction = correct(self.balance, self._on_cubic(fraction), condition, iterations=8)
        size = 0 if correction.factors is None else correction.factors.size
        found = CurvePoint(correction.evaluation, current.tangent, current.metric, correction.iterations, size, 0.0)
        controls = self.omega.controls
        # A plane across the tangent may meet the curve far away as well: on the other side of a narrow resonance, say.
        inside = min(controls) <= found.point.omega <= max(controls)
        near = current.chord(found, "omega") <= FARTHEST * fraction * current.chord(self.following, "omega")
        return found if correction.converged and inside and near else None
