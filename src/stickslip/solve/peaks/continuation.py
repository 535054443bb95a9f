"""Continuation of resonance peaks in a parameter: force level, preload, friction, stiffness, or several scaled together.

Each peak is a branch. From value to value it is predicted by extrapolation and climbed to again: two to four solutions where a
sweep takes a hundred. A peak that cannot be followed has merged with a trough or left the band; one that appears is not on any
branch. Full sweeps at every so many values see both, and new branches are followed back to where they were born.

Followed far enough a peak may come to lie on an isola, which no sweep meets. Whether it is found
then depends on where sweeps were made; where the highest branch was not on the curves of both sweeps beside it, there is another.
"""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.continuation import trace
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.continuation.sweep import swept_curve
from stickslip.solve.peaks.climb import NoPeakError, PeakBand, PeakSolver, SolvedPeak, settled
from stickslip.solve.peaks.search import PeakSearch
from stickslip.support.checks import Array

LEAST = 0.5
"""Peaks lower than this share of the highest are left out; one that grows is met by a later sweep."""

LONGEST = 400
"""Points along which the way from a peak to an end of the band is sought."""


def swept_peaks(
    balance: HarmonicBalance, level: float, band: tuple[float, float], output: int, measure: Measure
) -> tuple[list[SolvedPeak], int, int]:
    """Peaks of a measure over a band in rad/s, the points of the curve, and the solutions spent on the peaks.

    Raises `LostCurveError` where the curve does not reach the end of the band.
    """
    points = swept_curve(balance, level, band)
    solver = PeakSolver(balance, output, measure)
    search = PeakSearch(balance, points, solver.tolerance)
    kept: list[SolvedPeak] = []
    for top in search.peaks(output, measure, LEAST).points:
        peak = solver.from_top(top.evaluation)
        if not band[0] < peak.omega < band[1]:
            continue
        if kept and solver.same_peak(kept[-1], peak):
            kept[-1] = max(kept[-1], peak, key=lambda each: each.amplitude)
        else:
            kept.append(peak)
    return kept, len(points), search.solves + solver.solves


def reaches_an_end(balance: HarmonicBalance, peak: SolvedPeak, band: tuple[float, float]) -> bool:
    """Whether the curve through a peak comes to an end of the band in rad/s; a closed one turns back on both sides."""
    first = correct(balance, peak.point, fixed("omega", peak.omega), iterations=40, halvings=12)
    for end in band if first.converged else ():
        with suppress(LostCurveError):
            for _ in trace(balance, first, "omega", end, StepControl(points=LONGEST)):
                pass
            return True
    return False


PeakProblem = Callable[[float], tuple[HarmonicBalance, float]]
"""The balance and the force level that belong to a value of the parameter."""

FARTHEST = 0.02
"""Relative change of frequency beyond its prediction that a followed peak may make in one step; else the step is halved."""

SPREAD = 3.0
"""The same in half bands within which the amplitude stays within 0.1 % of the peak, where damping makes these wide."""

HALVINGS, ORDERS = 3, (3, 1)
"""How often a step to the next peak is halved, and the orders of its prediction, the better one first."""

ABOVE = 1.001
"""A peak counts as higher than another one beyond this ratio: samples make cusps."""


@dataclass(frozen=True, eq=False)
class ParameterPeak:
    """A peak at a value of the parameter; `stiffness` (rows,) is the K_c that its λ counts from."""

    value: float
    peak: SolvedPeak
    stiffness: Array

    @property
    def carried(self) -> Array:
        """Contact forces F = λ + K_c w, (rows, 2H+1)."""
        rows = self.stiffness.size
        return np.asarray(self.peak.point.forces + self.stiffness[:, None] * self.peak.evaluation.w[:rows])


@dataclass(eq=False)
class Branch:
    """One peak along the parameter: places by value; `ended`: why it could not be followed on, "" while it lives."""

    places: dict[float, ParameterPeak] = field(default_factory=dict)
    ended: str = ""

    def near(self, value: float) -> list[ParameterPeak]:
        """The places nearest to a value, the nearest one first."""
        return sorted(self.places.values(), key=lambda place: abs(_abscissa(place.value) - _abscissa(value)))


@dataclass(frozen=True)
class Event:
    """Something that happened to peaks between two values: kind is born, ended, merged or swapped."""

    kind: str
    low: float
    high: float
    frequency: float
    words: str


@dataclass(frozen=True)
class Check:
    """A full sweep at a value: its highest amplitude and that of the branches, the points the sweep took (0: it was lost), and
    the branches on its curve.
    """

    value: float
    swept: float
    followed: float
    points: int
    branches: frozenset[int] = frozenset()


@dataclass(eq=False)
class ContinuedPeaks:
    """Branches over the values, what happened to them, the sweeps that checked them, and the solutions that following took."""

    values: tuple[float, ...]
    branches: list[Branch]
    events: list[Event]
    checks: list[Check]
    solves: int = 0
    iterations: int = 0

    def highest(self, value: float) -> tuple[int, ParameterPeak] | None:
        """The branch and place of the highest peak at a value, of the curve of a sweep where there was one; or None."""
        return _highest(item for item in self.there(value) if not self.missed_by_sweep(item[0], value))

    def detached(self, value: float) -> tuple[int, ParameterPeak] | None:
        """The branch and place of the highest peak on an isola that lies above the swept curve, or None."""
        found, highest = _highest(item for item in self.there(value) if self.missed_by_sweep(item[0], value)), self.highest(value)
        above = found is not None and (highest is None or found[1].peak.amplitude > ABOVE * highest[1].peak.amplitude)
        return found if above else None

    def check(self, value: float) -> Check | None:
        """The last sweep at a value that was not lost."""
        return next((check for check in reversed(self.checks) if check.value == value and check.points), None)

    def missed_by_sweep(self, branch: int, value: float) -> bool:
        """Whether a sweep at a value did not meet a branch."""
        check = self.check(value)
        return check is not None and bool(check.branches) and branch not in check.branches

    def there(self, value: float) -> list[tuple[int, ParameterPeak]]:
        """The branches at a value with their places."""
        return [(k, branch.places[value]) for k, branch in enumerate(self.branches) if value in branch.places]


class PeakContinuation:
    """Continues all peaks of a measure of an output over a band in rad/s."""

    def __init__(self, problem_of: PeakProblem, band: tuple[float, float], output: int, measure: Measure) -> None:
        self.problem_of, self.band, self.output, self.measure = problem_of, band, output, measure
        self.solves = self.iterations = 0

    def follow(
        self, values: Sequence[float], every: int = 10, report: Callable[[float], None] = lambda fraction: None
    ) -> ContinuedPeaks:
        """All peaks at all values, in this order; `every`: how many values lie between two full sweeps. A value to which no peak
        could be followed, since it lies too far from the others, is swept too.
        """
        found = ContinuedPeaks(tuple(values), [], [], [])
        for k, value in enumerate(values):
            report(k / len(values))
            if k:
                self._advance(found, values[k - 1], value)
            if k % every == 0 or k == len(values) - 1:
                self._check(found, k)
        for k, value in enumerate(values):
            if not found.there(value):
                self._check(found, k)
        for k in _to_check(found):
            self._check(found, k)
        found.events += self._swaps(found)
        found.solves, found.iterations = self.solves, self.iterations
        return found

    def at(self, found: ContinuedPeaks, value: float) -> ParameterPeak | None:
        """The highest peak at a value between those followed; None where the highest branch on a side of it does not reach it."""
        below = max((known for known in found.values if known <= value), default=None)
        above = min((known for known in found.values if known >= value), default=None)
        beside = [None if known is None else found.highest(known) for known in (below, above)]
        if any(one is None or not _spans(found.branches[one[0]], value) for one in beside):
            return None
        near = min(found.values, key=lambda known: abs(_abscissa(known) - _abscissa(value)))
        inside = [
            branch for k, branch in enumerate(found.branches) if _spans(branch, value) and not found.missed_by_sweep(k, near)
        ]
        places = [place for place in (self._reach(branch, value, HALVINGS) for branch in inside) if place is not None]
        return max(places, key=lambda place: place.peak.amplitude, default=None)

    def swept(self, value: float) -> ParameterPeak | None:
        """The highest peak of a full sweep at a value; None where the sweep is lost or has none."""
        balance, level = self.problem_of(value)
        try:
            peaks, _, solves = swept_peaks(balance, level, self.band, self.output, self.measure)
        except LostCurveError:
            return None
        self.solves += solves
        highest = max(peaks, key=lambda peak: peak.amplitude, default=None)
        return None if highest is None else ParameterPeak(value, highest, balance.stiffness)

    def _advance(self, found: ContinuedPeaks, before: float, value: float) -> None:
        """Every living branch from one value to the next."""
        for branch in found.branches:
            if branch.ended or before not in branch.places:
                continue
            place = self._reach(branch, value, HALVINGS)
            if place is None:
                branch.ended = (
                    "The peak could not be followed on: it merged with a trough, left the band, or the next value is far."
                )
                last = branch.places[before].peak
                found.events.append(Event("ended", before, value, last.omega / (2.0 * np.pi), branch.ended))
                continue
            self._settle(found, branch, before, place)

    def _settle(self, found: ContinuedPeaks, branch: Branch, before: float, place: ParameterPeak) -> None:
        """The new place of a branch, unless another branch is there already."""
        for other in found.branches:
            if other is not branch and place.value in other.places and self._one(other.places[place.value], place):
                branch.ended = "The peak merged with another one."
                found.events.append(Event("merged", before, place.value, place.peak.omega / (2.0 * np.pi), branch.ended))
                return
        branch.places[place.value] = place

    def _reach(self, branch: Branch, value: float, halvings: int) -> ParameterPeak | None:
        """The branch at a value, by steps as long as they succeed; None where it cannot be followed."""
        known = branch.near(value)
        for order in sorted({min(order, len(known)) for order in ORDERS}, reverse=True):
            place = self._step(known[:order], value)
            if place is not None:
                return place
        if halvings == 0:
            return None
        a, b = known[0].value, value
        middle = float(np.sqrt(a * b)) if a > 0.0 and b > 0.0 else 0.5 * (a + b)
        half = self._reach(branch, middle, halvings - 1)
        if half is None:
            return None
        branch.places[middle] = half
        return self._reach(branch, value, halvings - 1)

    def _step(self, known: Sequence[ParameterPeak], value: float) -> ParameterPeak | None:
        """One step with a prediction from known places, the nearest one first."""
        balance, level = self.problem_of(value)
        start = _predicted(known, value, balance, level)
        last = known[0].peak
        if not 0.8 * self.band[0] < start.omega < 1.25 * self.band[1]:
            return None
        solver = PeakSolver(balance, self.output, self.measure)
        try:
            peak = solver.from_near(start, last.plane, last.curvature / last.amplitude)
        except NoPeakError:
            return None
        finally:
            self.solves += solver.solves
            self.iterations += solver.iterations
        outside = not self.band[0] < peak.omega < self.band[1]
        leapt = abs(peak.omega - start.omega) > max(FARTHEST * start.omega, SPREAD * last.reach * abs(last.plane.omega))
        return None if outside or leapt else ParameterPeak(value, peak, balance.stiffness)

    def _check(self, found: ContinuedPeaks, k: int) -> None:
        """A full sweep at value k: compare, and begin a branch at every peak that none of them has."""
        value = found.values[k]
        balance, level = self.problem_of(value)
        try:
            peaks, points, solves = swept_peaks(balance, level, self.band, self.output, self.measure)
        except LostCurveError:
            found.checks.append(Check(value, np.nan, np.nan, 0))
            return
        self.solves += solves
        mine, met = found.highest(value), set()
        for peak in peaks:
            swept = ParameterPeak(value, peak, balance.stiffness)
            there = [b for b in found.branches if value in b.places and self._one(b.places[value], swept)]
            for branch in there:
                if peak.amplitude > branch.places[value].peak.amplitude:
                    branch.places[value] = swept
            if not there:
                self._begin(found, k, swept)
            met |= {found.branches.index(branch) for branch in there or found.branches[-1:]}
        highest = max((peak.amplitude for peak in peaks), default=np.nan)
        followed = mine[1].peak.amplitude if mine is not None else np.nan
        for b, place in found.there(value):
            if b not in met and place.peak.amplitude > ABOVE * highest and reaches_an_end(balance, place.peak, self.band):
                met.add(b)
        found.checks.append(Check(value, highest, followed, points, frozenset(met)))

    def _swaps(self, found: ContinuedPeaks) -> list[Event]:
        """Where another branch becomes the highest, unless the two are one peak there."""
        events = []
        for before, value in pairwise(found.values):
            a, b = found.highest(before), found.highest(value)
            if a is None or b is None or a[0] == b[0]:
                continue
            pairs = ((a[1], found.branches[b[0]].places.get(before)), (found.branches[a[0]].places.get(value), b[1]))
            if not any(one is not None and other is not None and self._one(one, other) for one, other in pairs):
                pair = (a[1].peak.omega / (2.0 * np.pi), b[1].peak.omega / (2.0 * np.pi))
                words = f"The highest peak changed from {pair[0]:.5g} to {pair[1]:.5g} Hz."
                events.append(Event("swapped", before, value, pair[1], words))
        return events

    def _one(self, a: ParameterPeak, b: ParameterPeak) -> bool:
        """Whether two places at the same value are one peak."""
        solver = PeakSolver(self.problem_of(a.value)[0], self.output, self.measure)
        one = solver.same_peak(a.peak, b.peak)
        self.solves, self.iterations = self.solves + solver.solves, self.iterations + solver.iterations
        return one

    def settled(self, place: ParameterPeak) -> tuple[ParameterPeak, PeakBand]:
        """A place on the highest corner that the middle of its band leads to, and that band."""
        solver = PeakSolver(self.problem_of(place.value)[0], self.output, self.measure)
        peak, peak_band = settled(solver, place.peak)
        self.solves, self.iterations = self.solves + solver.solves, self.iterations + solver.iterations
        return ParameterPeak(place.value, peak, place.stiffness), peak_band

    def _begin(self, found: ContinuedPeaks, k: int, place: ParameterPeak) -> None:
        """A branch from a swept peak, followed back to the earlier values as far as it goes."""
        branch = Branch({place.value: place})
        found.branches.append(branch)
        for j in range(k - 1, -1, -1):
            value, after = found.values[j], found.values[j + 1]
            earlier = self._reach(branch, value, 1)
            taken = earlier is not None and any(
                other is not branch and value in other.places and self._one(other.places[value], earlier)
                for other in found.branches
            )
            if earlier is None or taken:
                frequency = branch.near(value)[0].peak.omega / (2.0 * np.pi)
                words = "The peak split off from another one." if taken else "A peak appeared to which none was followed."
                found.events.append(Event("born", value, after, frequency, words))
                return
            branch.places[value] = earlier


def _highest(items: Iterable[tuple[int, ParameterPeak]]) -> tuple[int, ParameterPeak] | None:
    return max(items, key=lambda item: item[1].peak.amplitude, default=None)


def _to_check(found: ContinuedPeaks) -> list[int]:
    """Values without a sweep at which the highest branch was not on the curve of the sweeps on both sides."""
    swept = [k for k, value in enumerate(found.values) if found.check(value) is not None]
    unsettled = []
    for before, after in pairwise(swept):
        for k in range(before + 1, after):
            highest, ends = found.highest(found.values[k]), [found.check(found.values[end]) for end in (before, after)]
            if highest is not None and not all(check is not None and highest[0] in check.branches for check in ends):
                unsettled.append(k)
    return unsettled


def _predicted(known: Sequence[ParameterPeak], value: float, balance: HarmonicBalance, level: float) -> Point:
    """The point that a polynomial through the known places predicts, in the logarithm of a positive parameter."""
    x = np.array([_abscissa(place.value) for place in known])
    weights = [
        float(np.prod([(_abscissa(value) - x[j]) / (x[i] - x[j]) for j in range(x.size) if j != i])) for i in range(x.size)
    ]
    carried = sum(weight * place.carried for weight, place in zip(weights, known, strict=True))
    motion = sum(weight * place.peak.evaluation.w[: balance.rows] for weight, place in zip(weights, known, strict=True))
    omega = sum(weight * place.peak.omega for weight, place in zip(weights, known, strict=True))
    return Point(np.asarray(carried - balance.stiffness[:, None] * motion), float(omega), level)


def _abscissa(value: float) -> float:
    return float(np.log(value)) if value > 0.0 else value


def _spans(branch: Branch, value: float) -> bool:
    return bool(branch.places) and min(branch.places) <= value <= max(branch.places)
