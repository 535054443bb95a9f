"""One response curve at one force level, over a band or at given frequencies, with its outcome.

A controlled response curve: the force level that holds the amplitude of an output, along frequency, and phase resonances.

The unknown force level makes the balance one equation longer; the continuation of forced responses follows it as it is.

Continuation takes steps as long as its predictor allows, tens of points a curve. A traced curve is refined by solved points
between its points, so that straight lines draw it, and by its peaks, which a separate search finds. Between two points the cubic
through points and tangents is a start so good that Newton's method needs a step or two, on planes across the curve: folds are no
obstacle.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from stickslip.model.problem import Problem
from stickslip.model.structure.cyclic import CyclicStructure
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.fourier import Harmonics, orders
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure
from stickslip.solve.continuation.continuation import at_right_angle, control_size, first_point, ramped, scaled, stuck_held, trace
from stickslip.solve.continuation.curve_points import CurvePoint, between
from stickslip.solve.continuation.interpolation import Interpolation
from stickslip.solve.continuation.newton import Correction, correct
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.continuation.sweep import Sweep, SweepStopped, from_start, points_at, sweep
from stickslip.solve.peaks.search import PROMINENCE, TOLERANCE, Cubic, Peaks, PeakSearch, Unproven
from stickslip.support.checks import Array, counted, fault, first_of
from stickslip.support.outcome import Outcome

RESTARTS = 3
"""How often a list of frequencies is begun anew where a curve does not reach the rest of it."""

ARRIVED = "The curve reached the end of the band."
FROM_THE_END = "The sweep failed from the start of the band, so it was computed from the other end."

SWEEP = 0.3
"""Share of the work that is the sweep, about; the rest is the search for its peaks."""

UNDAMPED = "The structure has no damping: where contacts take no energy its response is infinite at a resonance."

AT_THE_END, PASSED = 1e-4, 0.9
"""Relative distance in frequency from where a curve was lost, within which a peak counts only if the curve then fell so far."""

HIDDEN = 1e-5
"""Share of a force that the rounding of kn · gap of an open contact may be: little damping amplifies it in the motion."""

HELD_BY_FRICTION = "A body is held by friction alone: where it slips, its mean position is not determined."


@dataclass(frozen=True, eq=False)
class Curve:
    """Solved points in order; outcome and sentence of the end; where it was lost, in rad/s, or None.

    peaks: of `measure`, per output; steps: the step, from points[k] to the next one, that each of them lies in, until `refined`
    made them points of the curve; largest: where the same quantity is largest in time, per output, or None without a peak;
    missing: of listed frequencies, the place in the list and ω of those without a point. band: its ends, ω in rad/s; points
    outside belong to the path of the curve alone, and what is read of a curve is read of `inside`. outside: peaks there, per
    output, whose steps follow those of the peaks.
    """

    level: float
    points: tuple[CurvePoint, ...]
    outcome: Outcome
    message: str
    lost_at: float | None
    peaks: tuple[tuple[CurvePoint, ...], ...] = ()
    largest: tuple[CurvePoint | None, ...] = ()
    steps: tuple[tuple[int, ...], ...] = ()
    measure: Measure = DISPLACEMENT_AMPLITUDE
    missing: tuple[tuple[int, float], ...] = ()
    band: tuple[float, float] = (0.0, float("inf"))
    outside: tuple[tuple[CurvePoint, ...], ...] = ()

    def holds(self, omega: float) -> bool:
        """Whether a frequency in rad/s lies inside the band, its ends included."""
        return self.band[0] <= omega <= self.band[1]

    @property
    def places_outside(self) -> list[int]:
        """The places of the points outside the band."""
        return [k for k, point in enumerate(self.points) if not self.holds(point.point.omega)]

    def tops(self, output: int) -> tuple[CurvePoint, ...]:
        """The peaks of an output; the points inside the band where it has none."""
        return (self.peaks and self.peaks[output]) or self.inside

    @cached_property
    def inside(self) -> tuple[CurvePoint, ...]:
        """The points inside the band, in order."""
        return tuple(point for point in self.points if self.holds(point.point.omega))


class CurveStopped(KeyboardInterrupt):
    """Ctrl-C while a curve is computed, with the points that are solved, as a curve without peaks."""

    @property
    def curve(self) -> Curve:
        return self.args[0]  # type: ignore[no-any-return]


def solve_curve(
    balance: HarmonicBalance,
    frequencies: Sequence[float],
    level: float,
    exactly: bool,
    progress: Callable[[float], None] = lambda fraction: None,
    control: StepControl | None = None,
    begin: Point | None = None,
    peak_tolerance: float = TOLERANCE,
    measure: Measure = DISPLACEMENT_AMPLITUDE,
) -> Curve:
    """The curve from frequencies[0] to frequencies[-1] in rad/s; `exactly`: the points at the given frequencies, in their order.

    begin: a solved point at frequencies[0], when one is known; peak_tolerance: relative amplitude by which peaks may be too low;
    measure: what they are peaks of. Raises `InputError` where a gap is so large that rounding hides the force.
    """
    refuse_hidden(balance.problem, (level,))
    if exactly:
        return _listed(balance, frequencies, level, progress, control, begin, measure)
    start, end = frequencies[0], frequencies[-1]
    points: Sequence[CurvePoint] = ()
    try:
        found = sweep(balance, start, end, level, lambda done: progress(SWEEP * done), control, begin)
        if isinstance(found, Outcome):
            message = " ".join((found.sentence, *balance.problem.warnings))
            return Curve(level, (), found, message, start, measure=measure)
        points = found.points
        return with_peaks(balance, ended(balance, level, found, (start, end), measure), progress, peak_tolerance)
    except KeyboardInterrupt as stop:
        points = stop.points if isinstance(stop, SweepStopped) else points
        raise CurveStopped(stopped_curve(balance, level, points, (start, end), measure)) from stop


def refuse_hidden(problem: Problem, levels: Sequence[float]) -> None:
    """Refuse gaps so large that rounding hides the force: an open contact has the force −kn g beside that of a closed one."""
    excited = max((abs(factor) for force in problem.forces for factor in force.factors.values()), default=0.0)
    smallest = excited * min((abs(level) for level in levels if level), default=0.0)
    for contact in problem.contacts:
        normal = contact.elements.normal
        if normal is None or any(force.power for force in problem.forces):
            continue
        away = -float(np.min(normal.constant))
        if smallest and np.finfo(float).eps * away > HIDDEN * smallest:
            rule = "must not be so large that rounding of kn · gap hides the force"
            given = f"kn · gap = {away:.3g} N against {smallest:.3g} N"
            raise fault(f"The gap of {contact.name}", rule, given, "Leave out a contact that never closes.")


def stopped_curve(
    balance: HarmonicBalance,
    level: float,
    points: Sequence[CurvePoint],
    ends: tuple[float, float],
    measure: Measure = DISPLACEMENT_AMPLITUDE,
) -> Curve:
    """The points that were solved of a curve over a band before it was stopped; peaks are not sought."""
    message = Outcome.STOPPED.sentence
    if points:
        reached = balance.hertz(points[-1].point.omega)
        message = f"The run was stopped when this curve had got to {reached:.6g} Hz; its peaks were not searched for."
    return Curve(level, tuple(points), Outcome.STOPPED, message, None, measure=measure, band=_band(ends))


def _listed(
    balance: HarmonicBalance,
    frequencies: Sequence[float],
    level: float,
    progress: Callable[[float], None],
    control: StepControl | None,
    begin: Point | None,
    measure: Measure,
) -> Curve:
    """Points at listed frequencies: followed upwards where the list goes up and downwards where it goes down.

    What a curve does not reach is begun anew from the next frequency, `RESTARTS` times; what is left is solved by itself.
    """
    found: dict[int, CurvePoint] = {}
    reason, outcome, anew = "", Outcome.NOT_CONVERGED, 0
    for run in _monotonic_runs(frequencies):
        left = list(run)
        known = found[run[0]].point if run[0] in found else begin if run[0] == 0 else None
        for _ in range(1 + RESTARTS):
            part = from_start(balance, frequencies[left[0]], frequencies[left[-1]], level, control=control, begin=known)
            if isinstance(part, Outcome):
                reason, outcome = part.sentence, part
            else:
                found |= points_at(balance, part.points, {k: frequencies[k] for k in left if k not in found})
                reason = part.lost or reason
            progress((run[-1] + 1) / len(frequencies))
            left, known = [k for k in left[1:] if k not in found], None
            if not left:
                break
            anew += 1
    alone = {k: point for k, omega in enumerate(frequencies) if k not in found and (point := _alone(balance, omega, level))}
    missing = tuple((k, frequencies[k]) for k in range(len(frequencies)) if k not in found and k not in alone)
    points = tuple(point for _, point in sorted((found | alone).items()))
    if not points:
        message = " ".join((reason or outcome.sentence, *balance.problem.warnings))
        return Curve(level, (), outcome, message, frequencies[0], measure=measure)
    count = len(frequencies)
    message = f"All {count} frequencies were solved." if count > 1 else "The frequency was solved."
    if missing:
        first = f"the first at {balance.hertz(missing[0][1]):g} Hz"
        unsolved = f"{len(missing)} of {count} frequencies could not be solved, {first}."
        message = " ".join((unsolved, *balance.problem.warnings))
    elif anew and not alone:
        message = f"The curve was begun anew at {anew} of {count} frequencies. {reason}".strip()
    elif alone:
        message = f"{len(alone)} of {count} frequencies were solved by themselves, since the curve does not reach them."
    outcome = Outcome.NOT_CONVERGED if missing else Outcome.CONVERGED
    return Curve(level, points, outcome, message, None, measure=measure, missing=missing)


def _monotonic_runs(frequencies: Sequence[float]) -> list[list[int]]:
    """Numbers of the frequencies in runs that go up or down; each begins where the one before it ends."""
    runs = [[0]]
    for k in range(1, len(frequencies)):
        run = runs[-1]
        if len(run) > 1 and (frequencies[k] > frequencies[run[-1]]) != (frequencies[run[1]] > frequencies[run[0]]):
            runs.append([run[-1]])
        runs[-1].append(k)
    return runs


def _alone(balance: HarmonicBalance, omega: float, level: float) -> CurvePoint | None:
    """The point at one frequency, solved without others."""
    first = first_point(balance, omega, level)
    return next(iter(trace(balance, first, "omega", 1.01 * omega))) if first.converged else None


def with_peaks(balance: HarmonicBalance, curve: Curve, progress: Callable[[float], None], tolerance: float) -> Curve:
    """A curve with the peaks of its measure."""
    points, message, measure = curve.points, curve.message, curve.measure
    outputs = range(balance.problem.output_rows.shape[0])
    search = PeakSearch(balance, points, tolerance, band=curve.band)
    found, outside, largest, in_time = [], [], [], measure.with_kind("max_abs")
    for output in outputs:
        every = _passed(curve, balance.rows + output, search.peaks(output, measure))
        found.append(_chosen(every, curve.holds))
        outside.append(_chosen(every, lambda omega: not curve.holds(omega)))
        largest.append(search.highest(output, in_time, least=0.8))
        progress(SWEEP + (1.0 - SWEEP) * (output + 1) / len(outputs))
    unproven = [each for some in (*found, *largest) for each in some.unproven if curve.holds(each.omega)]
    if unproven:
        message += f" {_may_be_higher(balance, unproven)}"
        message += "" if balance.problem.damped or UNDAMPED in message else f" {UNDAMPED}"
    highest = tuple(next(iter(each.points), None) for each in largest)
    peaks, beyond = tuple(each.points for each in found), tuple(each.points for each in outside)
    steps = tuple(inner.steps + outer.steps for inner, outer in zip(found, outside, strict=True))
    return replace(curve, message=message, peaks=peaks, largest=highest, steps=steps, outside=beyond)


def _chosen(peaks: Peaks, where: Callable[[float], bool]) -> Peaks:
    """The peaks at frequencies in rad/s for which a test holds."""
    kept = [k for k, point in enumerate(peaks.points) if where(point.point.omega)]
    unproven = tuple(each for each in peaks.unproven if where(each.omega))
    return Peaks(tuple(peaks.points[k] for k in kept), tuple(peaks.steps[k] for k in kept), unproven)


def _may_be_higher(balance: HarmonicBalance, unproven: Sequence[Unproven]) -> str:
    """Where a peak may be higher than the one that was found, and by how much."""
    most = max(each.share for each in unproven)
    much = f"up to {100.0 * most:.2g} %" if most < 1.0 else "much"
    listed = dict.fromkeys(f"{balance.hertz(omega):.6g}" for omega in sorted(each.omega for each in unproven))
    near = f"{first_of(list(listed))} Hz"
    return f"{counted(len(unproven), 'place')} beside peaks could not be solved, near {near}; a peak there may be {much} higher."


def _passed(curve: Curve, row: int, peaks: Peaks) -> Peaks:
    """The peaks of a row that a curve has passed. Where it was lost it may go round on the spot, and rise or fall beyond."""
    if curve.lost_at is None:
        return peaks
    last, lost_at = _size(curve.measure, row, curve.points[-1]), curve.lost_at

    def is_passed(point: CurvePoint) -> bool:
        away = abs(point.point.omega / lost_at - 1.0) > AT_THE_END
        return away or last < PASSED * _size(curve.measure, row, point)

    kept = [k for k, point in enumerate(peaks.points) if is_passed(point)]
    return replace(peaks, points=tuple(peaks.points[k] for k in kept), steps=tuple(peaks.steps[k] for k in kept))


def ended(
    balance: HarmonicBalance, level: float, swept: Sweep, ends: tuple[float, float], measure: Measure = DISPLACEMENT_AMPLITUDE
) -> Curve:
    """The curve of a sweep over a band, without peaks: its points, outcome and sentence."""
    points, message = swept.points, ARRIVED if swept.lost is None else _lost_message(balance, swept, ends)
    if swept.from_the_end is not None:
        message = f"{ARRIVED} {FROM_THE_END} Cause: {swept.from_the_end}"
    outcome = Outcome.CONVERGED if swept.lost is None else Outcome.NOT_CONVERGED
    lost_at = points[-1].point.omega if swept.lost is not None and points else None
    curve = Curve(level, tuple(points), outcome, message, lost_at, measure=measure, band=_band(ends))
    return replace(curve, message=f"{message}{_beyond(balance, curve)}")


def _band(ends: tuple[float, float]) -> tuple[float, float]:
    """The band of a sweep between two frequencies; of one at a single frequency every one."""
    return (min(ends), max(ends)) if ends[0] != ends[1] else (0.0, float("inf"))


def _beyond(balance: HarmonicBalance, curve: Curve) -> str:
    """How far a curve leaves its band; empty where it does not."""
    outside = [curve.points[k].point.omega for k in curve.places_outside]
    if not outside:
        return ""
    way, farthest = ("down", min(outside)) if min(outside) < curve.band[0] else ("up", max(outside))
    back = " and comes back" if curve.holds(curve.points[-1].point.omega) else ""
    return f" The curve leaves the band {way} to {balance.hertz(farthest):.4g} Hz{back}: what lies outside does not count."


def _lost_message(balance: HarmonicBalance, swept: Sweep, ends: tuple[float, float]) -> str:
    """Why a curve ended before the end of its band, how far it got, how the rest can be had, and what may be the cause."""
    rest = "sweep from the other end of the band, start a new band beyond, or list single frequencies there (`at` in a study)."
    problem, omegas = balance.problem, [point.point.omega for point in swept.points]
    if ends[0] == ends[1]:
        where = ""
    elif omegas:
        farthest = max(omegas) if ends[1] > ends[0] else min(omegas)
        where = f"The sweep stopped at {balance.hertz(farthest):.6g} Hz. For the rest, {rest}"
    else:
        where = f"To compute it, {rest}"
    causes = "" if problem.damped else UNDAMPED, held_by_friction(problem, balance.harmonics)
    return " ".join(filter(None, (swept.lost, where, *problem.warnings, *causes)))


def held_by_friction(problem: Problem, harmonics: Harmonics) -> str:
    """That friction alone holds a body, and what to do; empty where that is not so, and where the mean is not balanced."""
    if orders(harmonics)[0] != 0 or not held_by_friction_alone(problem):
        return ""
    return f"{HELD_BY_FRICTION} Hold it by mean_springs ([[mean_spring]] in a study), or leave harmonic 0 out."


def held_by_friction_alone(problem: Problem) -> bool:
    """Whether structure, mean springs and normal directions of contacts leave a motion free (of tuned disks in all sectors).

    Not asked of whole disks, whose matrices are large.
    """
    return (type(problem) is Problem or isinstance(problem.structure, CyclicStructure)) and len(problem.loose_motions) > 0


def _size(measure: Measure, row: int, point: CurvePoint) -> float:
    return measure.size(point.evaluation.w[row], point.point.omega)


LARGEST = 0.15
"""Longest step in arc length: with the amplitude held, motion turns by 180° through a resonance, in some twenty points."""

SAME_PHASE = 1e-9
"""Relative part of a load at 90° to the rest of it up to which all of it has one phase."""

APART = 1e-6
"""Relative difference in frequency below which two phase resonances are one."""


def controlled_curve(
    balance: HarmonicBalance,
    frequencies: Sequence[float],
    exactly: bool,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Curve:
    """The curve of a balance that holds an amplitude, from frequencies[0] to frequencies[-1] in rad/s, or exactly there.

    `level` of each point is the force level that holds the amplitude; that of the curve is not a number.
    """
    if exactly:
        return solve_curve(balance, frequencies, math.nan, exactly=True, progress=progress)
    start, end = frequencies[0], frequencies[-1]
    found = sweep(balance, start, end, math.nan, progress, StepControl(largest=LARGEST))
    if isinstance(found, Outcome):
        return Curve(math.nan, (), found, " ".join((found.sentence, *balance.problem.warnings)), start)
    return ended(balance, math.nan, found, (start, end))


def force_phase(problem: Problem, omega: float) -> float | None:
    """Phase in rad of the first harmonic of the loads, or None where they have none, or several."""
    powers = problem.load_powers(max([1, *(h for force in problem.forces for h in force.amplitudes)]))
    load = np.einsum("k,knh->nh", omega ** np.arange(len(powers)), powers)[:, 1:3] @ np.array([1.0, -1.0j])
    largest = load[int(np.argmax(np.abs(load)))] if load.size else 0.0
    if not abs(largest) > 0.0:
        return None
    turned = load * np.conj(largest) / abs(largest)
    return float(np.angle(largest)) if np.abs(turned.imag).max() <= SAME_PHASE * abs(largest) else None


def turned_motion(balance: HarmonicBalance, evaluation: Evaluation, row: int, phase: float) -> complex:
    """X_1 e^{−iφ} of a row of motion: real where it is in phase with a force of phase φ and a positive level."""
    a, b = evaluation.w[row, 1:3]
    sign = math.copysign(1.0, evaluation.point.level)
    return complex(a, -b) * complex(math.cos(phase), -math.sin(phase)) * sign


def phase_resonances(balance: HarmonicBalance, points: Sequence[CurvePoint], phase: float) -> list[Correction]:
    """The points of a controlled curve where force and held motion are at 90°, the lowest force level first."""
    row = balance.system.control.row
    parts = [turned_motion(balance, point.evaluation, row, phase).real for point in points]
    found: list[Correction] = []
    for (low, high), (a, b) in zip(pairwise(points), pairwise(parts), strict=True):
        if a * b > 0.0:
            continue
        solved = _between(balance, low, high, a / (a - b) if a != b else 0.5, phase)
        place = np.array([solved.evaluation.point.omega, solved.evaluation.point.level])
        known = ((other.evaluation.point.omega, other.evaluation.point.level) for other in found)
        if solved.converged and not any(np.all(np.abs(place / other - 1.0) < APART) for other in known):
            found.append(solved)
    return sorted(found, key=lambda each: abs(each.evaluation.point.level))


def _between(balance: HarmonicBalance, low: CurvePoint, high: CurvePoint, fraction: float, phase: float) -> Correction:
    """The phase resonance between two points of a curve."""
    ends = low.point, high.point
    omega, level = ((1.0 - fraction) * a + fraction * b for a, b in zip(*((e.omega, e.level) for e in ends), strict=True))
    start = Point(between(low, high, fraction), omega, level)
    return correct(balance, start, at_right_angle(balance, omega, phase), iterations=20, halvings=8)


def followed_resonances(
    balance: HarmonicBalance, amplitudes: Array, omega: float, phase: float, ends: tuple[float, float]
) -> list[Correction]:
    """Phase resonances at ascending amplitudes, each from the one before; the first from that of the stuck structure near ω.

    Without viscous damping the stuck structure needs no force, and nothing begins there: then, and wherever Newton's method
    fails, the controlled curve between the ends of the band [rad/s] is searched. Where one is not found stands what Newton's
    method left.
    """
    found: list[Correction] = []
    for amplitude in amplitudes.tolist():
        one = balance.holding(balance.system.control._replace(amplitude=amplitude))
        before = found[-1].evaluation if found and found[-1].converged else None
        solved = _followed(one, before, omega, phase)
        if not solved.converged:
            on_curve = phase_resonances(one, controlled_curve(one, ends, exactly=False).points, phase)
            solved = on_curve[0] if on_curve else solved  # that of the least force
        found.append(solved)
    return found


def _followed(balance: HarmonicBalance, before: Evaluation | None, omega: float, phase: float) -> Correction:
    """The phase resonance at the held amplitude, from that of a smaller one, or from the stuck structure near ω."""
    condition, control = at_right_angle(balance, omega, phase), balance.system.control

    def begun(one: HarmonicBalance) -> Correction:
        return correct(one, stuck_held(one, omega), condition, iterations=30, halvings=10)

    if before is None:
        solved = begun(balance)
    else:
        ratio = control.amplitude / control_size(control, before)
        solved = correct(balance, scaled(before.point, ratio), condition, iterations=30, halvings=10)
    return solved if solved.converged else ramped(balance, begun, condition) or solved


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


def through_peaks(curve: Curve) -> Curve:
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
