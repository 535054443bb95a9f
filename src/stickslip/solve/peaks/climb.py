"""One resonance peak: from a point near it, the stationary size of an output along the response curve.

A peak solves R = 0 together with dA/ds = 0, s the arc length of the curve in ω at fixed level and A a `Measure`: |X_1|,
ω²|X_1|, ... The slope is exact, from the tangent of the curve in motion and ω; its root is found by secants and by the meeting
of tangents, which is exact for a peak that sits on a kink. Arc length turns with the phase of the response, so folds are no
obstacle and the curvature of a lone linear mode is −A.

How well the frequency of a peak is known, the band in which the amplitude stays within a share of it says. The curvature at the
peak is no measure of it: sampling divides a flat top into facets, and a peak is the corner of two. The ends of the band are
solved, beyond the facets.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.newton import correct
from stickslip.solve.peaks.search import PROMINENCE
from stickslip.support.checks import Array

SAMPLING, COARSEST = 4.0, 6e-5
"""The relative amplitude by which a peak may be below the top that its slopes predict: this over the squared samples of a
period, what the small cusps come to that samples make in a curve; but no more than the second.
"""

FREQUENCY_SCALE = 0.05
"""Relative change of frequency that counts as much as a change of the motion by its own size."""

STRIDE, TRIALS, NARROWEST = 0.7, 40, 1e-7
DETOURS = (1.0, 0.6, 1.7)
"""A place may lie on a cusp where Newton's method fails: others, as shares of the step."""

NEAR, AS_HIGH = 0.02, 0.01
"""Relative distances in frequency and height from which on two peaks are never taken for one."""

CUSPS = 40.0
"""Relative height of the corners that samples make in a flat top: this over the squared samples of a period."""

FLATTEST = 0.05
"""Relative curvature assumed until two slopes give it."""
SHARPEST = 10.0
"""Relative curvature beyond which two slopes mean a kink."""
KINK = 0.05
"""Jump of the slope, relative to the amplitude, from which a peak counts as on a kink: samples alone make smaller ones."""


class NoPeakError(Exception):
    """No peak near the start; the argument says why."""


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Arc length along a tangent: weight · w + slope ω = origin + s. `forces`, `omega`: rates of λ and ω with s."""

    weight: Array
    slope: float
    origin: float
    forces: Array
    omega: float

    def at(self, s: float) -> PathCondition:
        """The condition that picks the point at arc length s."""
        return PathCondition("omega", self.weight, self.slope, self.origin + s)

    def through(self, w: Array, omega: float) -> PathCondition:
        """The condition that picks the point of a curve in the plane through a motion and a frequency."""
        return PathCondition("omega", self.weight, self.slope, float(np.vdot(self.weight, w)) + self.slope * omega)


@dataclass(frozen=True, slots=True, eq=False)
class _Sample:
    """A solved place: arc length, amplitude and its slope there, and the rates of λ and ω."""

    s: float
    amplitude: float
    slope: float
    forces: Array
    omega: float
    evaluation: Evaluation


@dataclass(frozen=True, slots=True, eq=False)
class SolvedPeak:
    """A solved peak. amplitude A in units of its measure; curvature d²A/ds²; jump: of dA/ds where it stands on a kink, else 0.

    plane: the arc length in which s is counted; solves, iterations: what it took.
    """

    evaluation: Evaluation
    amplitude: float
    curvature: float
    jump: float
    plane: Plane
    solves: int
    iterations: int

    @property
    def point(self) -> Point:
        return self.evaluation.point

    @property
    def omega(self) -> float:
        """Frequency of the peak, rad/s."""
        return self.evaluation.point.omega

    @property
    def on_kink(self) -> bool:
        """Whether the amplitude rises to the peak and falls from it at an angle."""
        return self.jump > KINK * self.amplitude

    @property
    def reach(self) -> float:
        """Arc length in which the amplitude falls by 0.1 % by the curvature: a guess, for a peak stands where facets meet."""
        bend = np.clip(-self.curvature / self.amplitude, FLATTEST, 1.0)
        return float(np.sqrt(2e-3 / bend))


def plane_at(balance: HarmonicBalance, evaluation: Evaluation) -> Plane:
    """The arc length along the tangent of the curve at a solved point; motions count relative to their size."""
    rows, w = balance.rows, evaluation.w
    weight = np.zeros_like(w)
    for part in (slice(0, rows), slice(rows, None)):
        size = float(np.linalg.norm(w[part, 1:]))
        if size > 0.0:
            weight[part, 1:] = 1.0 / size**2
    omega = evaluation.point.omega
    slope = 1.0 / (FREQUENCY_SCALE * omega) ** 2
    factors = balance.factorise(evaluation, PathCondition("omega", None, 1.0 / omega, 0.0))
    forces, motion, rate, _ = balance.tangent(evaluation, "omega", factors)
    length = float(np.sqrt(np.vdot(weight * motion, motion) + slope * rate**2)) * (1.0 if rate >= 0.0 else -1.0)
    normal, slope = weight * motion / length, slope * rate / length
    origin = float(np.vdot(normal, w)) + slope * omega
    return Plane(normal, slope, origin, forces / length, rate / length)


class PeakSolver:
    """Climbs from a start to the peak of an output along the curve of a balance at one level.

    measure: of what it is a peak; tolerance: relative amplitude by which the peak may be below the top; what samples do to a
    curve unless given.
    """

    def __init__(self, balance: HarmonicBalance, output: int, measure: Measure, tolerance: float | None = None) -> None:
        self.balance, self.output, self.measure, self.row = balance, output, measure, balance.rows + output
        self.tolerance = tolerance or min(SAMPLING / balance.tables.E.shape[0] ** 2, COARSEST)
        self.solves = self.iterations = 0

    def amplitude(self, evaluation: Evaluation) -> float:
        """The size of the output."""
        return self.measure.size(evaluation.w[self.row], evaluation.point.omega)

    def from_near(self, start: Point, plane: Plane, curvature: float | None = None) -> SolvedPeak:
        """The peak near a start that need not be solved: the curve is met in the plane through it; raises `NoPeakError`."""
        first = self.balance.evaluate(start)
        evaluation = self._corrected(start, plane.through(first.w, start.omega))
        if evaluation is None:
            raise NoPeakError("Newton's method failed beside the peak.")
        return self.from_solved(evaluation, curvature)

    def from_solved(self, evaluation: Evaluation, curvature: float | None = None) -> SolvedPeak:
        """The peak that a solved point climbs to; curvature: relative to the amplitude, as far as it is known."""
        plane = plane_at(self.balance, evaluation)
        sample = self._sample(evaluation, plane, 0.0)
        bend = float(np.clip(curvature, -3.0, -FLATTEST) if curvature is not None else -1.0) * sample.amplitude
        return self._climb([sample], plane, bend)

    def from_top(self, evaluation: Evaluation) -> SolvedPeak:
        """The peak of a solved point that a search found to be the top of its curve; it climbs no higher than corners do."""
        with suppress(NoPeakError):
            peak = self.from_solved(evaluation)
            if peak.amplitude <= (1.0 + self.dip) * self.amplitude(evaluation):
                return peak
        amplitude = self.amplitude(evaluation)
        return SolvedPeak(evaluation, amplitude, -amplitude, 0.0, plane_at(self.balance, evaluation), 1, 0)

    @property
    def dip(self) -> float:
        """The share by which a curve dips between two peaks, and not only between corners that samples make."""
        return max(PROMINENCE, CUSPS / float(self.balance.tables.E.shape[0]) ** 2)

    def beside(self, peak: SolvedPeak, s: float) -> Evaluation | None:
        """The curve at arc length s from a peak; None where Newton's method fails."""
        point, plane = peak.point, peak.plane
        start = Point(point.forces + s * plane.forces, point.omega + s * plane.omega, point.level)
        return self._corrected(start, plane.at(s))

    def same_peak(self, a: SolvedPeak, b: SolvedPeak) -> bool:
        """Whether two peaks of the same problem are one peak: near, as high, and the curve between them does not dip, in the
        middle, by more than `PROMINENCE`, or what samples make of a flat top.
        """
        lower, higher = sorted((a.amplitude, b.amplitude))
        dip = self.dip
        if abs(a.omega - b.omega) > NEAR * a.omega or higher - lower > max(AS_HIGH, dip) * lower:
            return False
        point, other = a.point, b.point
        start = Point(0.5 * (point.forces + other.forces), 0.5 * (point.omega + other.omega), point.level)
        motion = 0.5 * (a.evaluation.w + b.evaluation.w)
        middle = self._corrected(start, a.plane.through(motion, start.omega))
        return middle is not None and (1.0 - dip) * lower <= self.amplitude(middle) <= (1.0 + AS_HIGH) * higher

    def _climb(self, samples: list[_Sample], plane: Plane, bend: float) -> SolvedPeak:
        """Samples around the peak until no more than the tolerance is to be gained."""
        for trial in range(TRIALS):
            below, above = _bracket(samples)
            best = max(samples, key=lambda sample: sample.amplitude)
            bend = _bend(samples, bend)
            if self._done(below, above, best, bend, len(samples) > 1):
                return self._peak(below, above, best, bend, plane)
            s = _next(below, above, bend, trial, np.sqrt(2.0 * self.tolerance))
            samples = sorted([*samples, self._solved(samples, plane, s)], key=lambda sample: sample.s)
            if abs(s) > 6.0:
                raise NoPeakError("The curve rises without a peak.")
        raise NoPeakError("The search for the peak did not end.")

    def _solved(self, samples: list[_Sample], plane: Plane, s: float) -> _Sample:
        """The sample at arc length s, or a little nearer or farther where Newton's method fails there."""
        beside = min(samples, key=lambda sample: abs(sample.s - s))
        for stretch in DETOURS:
            place = beside.s + stretch * (s - beside.s)
            point, step = beside.evaluation.point, place - beside.s  # on the tangent there
            start = Point(point.forces + step * beside.forces, point.omega + step * beside.omega, point.level)
            evaluation = self._corrected(start, plane.at(place))
            if evaluation is not None:
                return self._sample(evaluation, plane, place)
        raise NoPeakError("Newton's method failed beside the peak.")

    def _done(self, below: _Sample | None, above: _Sample | None, best: _Sample, bend: float, several: bool) -> bool:
        """Whether slopes predict no gain: of the best sample by the curvature, or of the bracket by its tangents."""
        goal = self.tolerance * best.amplitude
        if below is not None and above is not None and below.slope > 0.0 > above.slope:
            meeting, bound = _meeting(below, above)
            return above.s - below.s <= NARROWEST or (below.s <= meeting <= above.s and bound - best.amplitude <= goal)
        if below is not None and above is not None and above.s - below.s <= NARROWEST:
            raise NoPeakError("The curve jumps beside the peak.")
        alone = below is None or above is None
        return several and alone and best.slope**2 <= 2.0 * abs(bend) * goal

    def _peak(self, below: _Sample | None, above: _Sample | None, best: _Sample, bend: float, plane: Plane) -> SolvedPeak:
        jump = 0.0
        if below is not None and above is not None:
            change, width = below.slope - above.slope, above.s - below.s
            jump = change if change > best.amplitude * max(KINK, SHARPEST * width) else 0.0
        own = replace(plane, forces=best.forces, omega=best.omega, origin=plane.origin + best.s)
        curvature = max(min(bend, 0.0), -SHARPEST * best.amplitude)
        return SolvedPeak(best.evaluation, best.amplitude, curvature, jump, own, self.solves, self.iterations)

    def _corrected(self, start: Point, condition: PathCondition) -> Evaluation | None:
        self.solves += 1
        correction = correct(self.balance, start, condition, iterations=15, halvings=6)
        self.iterations += correction.iterations
        if correction.converged:
            return correction.evaluation
        self.solves += 1
        correction = correct(self.balance, start, condition, iterations=25, patience=12)
        self.iterations += correction.iterations
        return correction.evaluation if correction.converged else None

    def _sample(self, evaluation: Evaluation, plane: Plane, s: float) -> _Sample:
        factors = self.balance.factorise(evaluation, plane.at(s))
        forces, motion, omega, _ = self.balance.tangent(evaluation, "omega", factors)
        size, slope = self.measure.slope(evaluation.w[self.row], evaluation.point.omega, motion[self.row], omega)
        return _Sample(s, size, float(slope), forces, omega, evaluation)


FIRST, SHORTEST = 0.25, 1.0 / 32.0
"""The first and the shortest step of a problem that changes, as shares of the whole change. A failed step takes up to eight times
as long as one that arrives, and three of these cover the change."""


def followed(solver_at: Callable[[float], PeakSolver], known: SolvedPeak) -> SolvedPeak | None:
    """The known peak followed while its problem changes, from share 0 to 1 of the change; None where it is lost."""
    done, step, failed = 0.0, FIRST, False
    last, before = 0.0, known
    while done < 1.0:
        share = min(done + step, 1.0)
        ahead = (share - done) / (done - last) if done > last else 0.0
        off, away = known.point.forces - before.point.forces, known.omega - before.omega
        start = known.point.moved(ahead * off, "omega", ahead * away)  # on the line through the last two peaks
        try:
            found = solver_at(share).from_near(start, known.plane)
        except NoPeakError:
            if step <= SHORTEST:
                return None
            step, failed = 0.5 * step, True
        else:
            last, before, done, known = done, known, share, found
            # A step that fails costs as much as several that do not: after one, the length is tried again first.
            step, failed = step if failed else 2.0 * step, False
    return known


def _bracket(samples: list[_Sample]) -> tuple[_Sample | None, _Sample | None]:
    """The highest sample with the neighbour on the side to which it rises: (rising one, falling one)."""
    k = max(range(len(samples)), key=lambda i: samples[i].amplitude)
    if samples[k].slope > 0.0:
        return samples[k], samples[k + 1] if k + 1 < len(samples) else None
    return samples[k - 1] if k > 0 else None, samples[k]


def _bend(samples: list[_Sample], known: float) -> float:
    """Curvature from the slopes of the two samples nearest the top; what was known before without two."""
    if len(samples) < 2:
        return known
    a, b = sorted(sorted(samples, key=lambda sample: -sample.amplitude)[:2], key=lambda sample: sample.s)
    found = (b.slope - a.slope) / max(b.s - a.s, np.finfo(float).tiny)
    return found if found < 0.0 else known


def _meeting(below: _Sample, above: _Sample) -> tuple[float, float]:
    """Where the tangents of a rising and a falling sample meet: (s, amplitude), a bound of what lies between."""
    rise = above.amplitude - below.amplitude - above.slope * (above.s - below.s)
    along = rise / (below.slope - above.slope)
    return below.s + along, below.amplitude + below.slope * along


def _next(below: _Sample | None, above: _Sample | None, bend: float, trial: int, least: float) -> float:
    """The arc length to solve next; `least`: the shortest step to a new side, which also distinguishes top from trough."""
    if below is None or above is None:
        end = below or above
        assert end is not None
        step = float(np.clip(abs(end.slope / bend), least, STRIDE)) * (1.0 if trial < 4 else 1.5)
        return end.s + (step if end.slope > 0.0 else -step)
    width = above.s - below.s
    if below.slope <= above.slope or below.slope * above.slope > 0.0:
        return 0.5 * (below.s + above.s)
    root, meeting = below.s + width * below.slope / (below.slope - above.slope), _meeting(below, above)[0]
    wanted = meeting if trial % 3 == 0 and below.s < meeting < above.s else root
    return float(np.clip(wanted, below.s + 0.02 * width, above.s - 0.02 * width))


SHARE = 1e-3
"""Share of the peak by which the amplitude falls to the ends of the band."""

CLOSE = 1.4
"""An end is predicted from a place that has fallen by between 1/1.4 and 1.4 times the share."""

ROUNDS, LEAP = 4, 5e-3
"""How often a higher corner of the same top is looked for, and how much higher one may be."""

FLAT = 1e-4
"""Half-way to its ends a smooth top has fallen by a quarter of `SHARE`; where by less than this, there may be a higher corner."""

SOLVES = 8
WIDEN = 2.5
FARTHEST = 0.3
"""Arc length beyond which the middle of a band is not sought for a peak."""


@dataclass(frozen=True)
class PeakBand:
    """The band in rad/s in which the amplitude of a peak stays within `SHARE` of it."""

    low: float
    high: float

    @property
    def omega(self) -> float:
        """The middle of the band, rad/s: the frequency of the peak without the corners that samples make."""
        return 0.5 * (self.low + self.high)

    @property
    def width(self) -> float:
        """Half the band, rad/s."""
        return 0.5 * (self.high - self.low)


def settled(solver: PeakSolver, peak: SolvedPeak) -> tuple[SolvedPeak, PeakBand]:
    """The highest peak that is climbed to from inside the band, as corners of samples are, and the band around it."""
    peak_band = peak_band_of(solver, peak)
    for _ in range(ROUNDS):
        other = _higher(solver, peak, peak_band)
        if other is None:
            break
        gained = other.amplitude / peak.amplitude - 1.0
        peak = other
        if gained < 0.1 * SHARE:
            break
        peak_band = peak_band_of(solver, peak)
    return peak, peak_band


def _higher(solver: PeakSolver, peak: SolvedPeak, peak_band: PeakBand) -> SolvedPeak | None:
    """A higher peak from the middle of the band, or from where the band is flatter than a parabola would be, if any."""
    for share in (0.0, -0.5, 0.5):
        away = peak_band.omega + share * peak_band.width - peak.omega
        s = away / peak.plane.omega if peak.plane.omega else 0.0
        evaluation = solver.beside(peak, float(np.clip(s, -FARTHEST, FARTHEST)))
        if evaluation is None or (share and solver.amplitude(evaluation) < (1.0 - FLAT) * peak.amplitude):
            continue
        with suppress(NoPeakError):
            other = solver.from_solved(evaluation)
            if 0.0 < other.amplitude / peak.amplitude - 1.0 <= LEAP:
                return other
    return None


def peak_band_of(solver: PeakSolver, peak: SolvedPeak) -> PeakBand:
    """The band around a peak, about two solutions for each end."""
    ends = [peak.omega, *(_end(solver, peak, side) for side in (-1.0, 1.0))]
    return PeakBand(min(ends), max(ends))


def _end(solver: PeakSolver, peak: SolvedPeak, side: float) -> float:
    """The frequency at which the amplitude has fallen by the share; where Newton's method fails before, the last one solved."""
    inner, outer, s, omega = 0.0, 0.0, peak.reach, peak.omega
    for _ in range(SOLVES):
        evaluation = solver.beside(peak, side * s)
        if evaluation is None:
            outer, s = s, 0.5 * (inner + s)
            continue
        here = evaluation.point.omega
        fallen = max(1.0 - solver.amplitude(evaluation) / peak.amplitude, 1e-12)
        stretch = sqrt(SHARE / fallen)
        if 1.0 / CLOSE <= fallen / SHARE <= CLOSE:
            return peak.omega + stretch * (here - peak.omega)
        if fallen < SHARE:
            inner, omega = s, here
        else:
            outer = s
        s *= min(max(stretch, 1.0 / WIDEN), WIDEN)
        if outer and not inner < s < outer:
            s = 0.5 * (inner + outer)
    return omega
