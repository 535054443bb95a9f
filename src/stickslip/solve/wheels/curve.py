"""The curve of one mistuned wheel over a band and the highest amplitude of each of its blades.

Few shapes a sector carry the curve and the proof that no maximum of a blade is missed; the highest blades are then climbed to on
more of them. The curve begins where the tuned wave is, at an end of the band.

Newton's method and steps along a curve for a wheel, in place of the compiled ones.

A step counts by the change of the motion that it leads to, ‖R M⁻¹ F‖ (the natural monitor of Deuflhard): beside a resonance the
residual itself stalls Newton's method.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.linalg import LinAlgError

from stickslip.model.contact.point import Contact
from stickslip.model.disks.tuned import TunedDisk
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.energy import contact_cycle, cycle_work
from stickslip.solve.balance.measure import Measure
from stickslip.solve.balance.system import BORDERED, DIRECTION
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, Metric, Tangent, moving_sizes, relative_metric
from stickslip.solve.continuation.newton import NEAR, Correction, Found, correct, fixed
from stickslip.solve.continuation.steps import LEAST as LEAST_SIZE
from stickslip.solve.continuation.steps import Place, Solver, StepControl, Stepped, stepped
from stickslip.solve.peaks.climb import NoPeakError, PeakSolver
from stickslip.solve.peaks.search import PeakSearch, Unproven
from stickslip.solve.wheels.balance import WheelBalance, WheelFactors
from stickslip.solve.wheels.tuned import Shapes, TunedWheel
from stickslip.support.checks import Array

TOLERANCE = 1e-5
"""Relative change of the motion of the contacts by a further step, up to which a point counts as solved."""

INNER = 1e-3
"""Relative accuracy of Newton's steps, with which he gains three digits each."""

STALE = 6
"""Products of GMRES beyond which another preconditioner pays."""

LEAST_GAIN = 0.3
"""Share of a step by which it must reduce the next one."""


@correct.register
@np.errstate(over="ignore", invalid="ignore")  # trials far away, which the search of a step refuses
def correct_wheel(
    balance: WheelBalance,
    start: Point,
    condition: PathCondition,
    iterations: int = 10,
    halvings: int = 4,
    patience: int = 0,
    direction: float | None = None,
) -> Correction:
    """`correct` for a wheel; without patience."""
    if condition.weight is None:
        start = replace(start, omega=condition.target / condition.slope)
    evaluation = first = balance.evaluate(start)
    factors: WheelFactors | None = None
    history, converged, singular, along = [(evaluation.error, 0.0)], False, False, None
    try:
        for _ in range(iterations if np.isfinite(evaluation.error) else 0):
            if factors is None or factors.products > STALE:
                factors = WheelFactors.of(balance, evaluation, condition)
            else:
                factors = factors.at(evaluation)
            length, following, converged = _search(balance, factors, evaluation, halvings)
            history.append((evaluation.error if following is None else following.error, length))
            if following is None:
                break
            evaluation = following
            if converged:
                break
        if converged and factors is not None and direction is not None:
            factors = factors.at(evaluation)
            along = balance.tangent(evaluation, "omega", factors)
    except LinAlgError:
        converged, singular, along = False, True, None
    return Correction(first.w, evaluation, factors, along, np.array(history), converged, singular)  # type: ignore[arg-type]


def _search(
    balance: WheelBalance, factors: WheelFactors, evaluation: Evaluation, halvings: int
) -> tuple[float, Evaluation | None, bool]:
    """The longest of Newton's steps 1, 1/2, 1/4, ... after which the next one is shorter, the evaluation there, and whether it is
    solved; None for none."""
    condition, point = factors.condition, evaluation.point
    step = factors.solve(-evaluation.residual, -condition.gap(evaluation), INNER)
    before, length = float(np.linalg.norm(step.motion[: balance.rows])), 1.0
    for _ in range(halvings + 1 if np.isfinite(before) else 0):
        trial = balance.evaluate(point.moved(length * step.forces, "omega", length * step.omega))
        if trial.point.omega > 0.0 and np.isfinite(trial.error):
            after = factors.estimate(-trial.residual, -condition.gap(trial)).motion[: balance.rows]
            size = float(np.linalg.norm(after))
            if length == 1.0 and size <= TOLERANCE * float(np.linalg.norm(trial.w[: balance.rows])):
                return length, trial, True
            if size < (1.0 - LEAST_GAIN * length) * before or trial.error < (1.0 - LEAST_GAIN * length) * evaluation.error:
                return length, trial, False
        length *= 0.5
    return 0.0, None, False


@stepped.register
def step_wheel(balance: WheelBalance, place: Place, along: Tangent, distance: float, solver: Solver) -> Stepped:
    """`step` for a wheel over ω."""
    metric = place.metric
    plane = PathCondition("omega", metric.weight * along.motion, metric.parameter * along.parameter, 0.0)
    plane = replace(plane, target=plane.rate(place.w, place.omega) + distance)
    forces, amount = place.forces + distance * along.forces, distance * along.parameter
    if place.length > 0.0 and np.array_equal(place.unknown, place.unknown_before):
        ratio = metric.length(place.before.motion, place.before.parameter)
        bend = 0.5 * distance**2 / (place.length * ratio)
        forces = forces + bend * (along.forces - place.before.forces / ratio)
        amount += bend * (along.parameter - place.before.parameter / ratio)
    start = Point(forces, place.omega + amount, place.level)
    found = correct(balance, start, plane, solver.iterations, solver.halvings, 0, NEAR)
    evaluation, direction = found.evaluation, found.direction or DIRECTION
    active = np.array([np.count_nonzero(evaluation.unknown)])
    point, state = evaluation.point, evaluation.without_derivatives().state
    sign = found.factors.orientation if found.converged and found.factors is not None else 1.0
    bordered = BORDERED._replace(offsets=active, sign=sign)
    ended = found.converged, found.singular
    done = Found(found.start_motion, state, point.omega, point.level, bordered, direction, found.history, *ended)
    if not found.converged:
        none = np.empty((0, 0))
        return Stepped(done, Tangent(none, none, 0.0), Metric(none, 0.0), solver.contacts, solver.outputs, 0.0, 0.0, 0.0, False)
    sizes = moving_sizes(state.w, balance.rows)
    most = [max(pair) for pair in zip(sizes, (solver.contacts, solver.outputs), strict=True)]
    scales = [max(size, LEAST_SIZE * largest) for size, largest in zip(sizes, most, strict=True)]
    own = relative_metric(state.w, balance.rows, scales, solver.scale)
    length = own.length(direction.motion, direction.rate) * np.sign(solver.orientation * sign)
    tangent = Tangent(direction.forces / length, direction.motion / length, direction.rate / length)
    error = metric.length(state.w - found.start_motion, point.omega - start.omega)
    chord = metric.length(state.w - place.w, point.omega - place.omega)
    turn = float(np.vdot(metric.weight * along.motion, tangent.motion)) + metric.parameter * along.parameter * tangent.parameter
    turn /= metric.length(tangent.motion, tangent.parameter)
    return Stepped(done, tangent, own, most[0], most[1], error, turn, chord, False)


PATH, TOP = 5e-3, 5e-4
"""Shares of the largest weight of a sector's shapes down to which they carry the curve, and the highest blades."""

SEARCHED = 10.0
"""Multiple of the tolerance of a peak to which the search on few shapes proves each blade's."""

CLOSE = 0.01
"""Share of the highest amplitude within which blades are climbed to on more shapes: few of them are off by 0.3 %."""

STEPS = StepControl(error=0.1, largest=1.5)
"""Longer steps than those of other curves: searches of peaks divide those that hold one."""

FOLDED = StepControl(error=0.1, largest=1.5, points=400)
"""The same along oriented curves; more points would take longer than the whole disk, whose time is that of 400 on 12 sectors."""

LEAST = 0.9
"""Peaks of a blade whose curve stays below this share of its highest point are left out unsolved."""


@dataclass(frozen=True, eq=False)
class WheelCurve:
    """omega (points,) rad/s and sizes (points, N) along the curve; peak, place (N,): the highest size of each blade inside the
    band and its ω; work (N,): friction work of each damper per period at the highest, J; unproven: where one may be higher."""

    omega: Array
    sizes: Array
    peak: Array
    place: Array
    work: Array
    unproven: tuple[Unproven, ...]


class Wheels:
    """All wheels of a tuned disk under one force level, over a band in rad/s."""

    def __init__(
        self, disk: TunedDisk, blade: Sequence[str], harmonics: int, samples: int, band: tuple[float, float], level: float
    ) -> None:
        self.samples, self.level = disk.systems.enough_samples(samples), level
        self.tuned = TunedWheel(disk, blade, harmonics, band, 2.0 * harmonics * band[1] / (2.0 * np.pi))
        self.few, self.more = (Shapes(self.tuned, self.tuned.shapes(least)) for least in (PATH, TOP))

    @cached_property
    def _ends(self) -> tuple[tuple[float, Array], ...]:
        """The tuned wave at both ends of the band: ω and contact forces λ of the first sector."""
        tuned, ends = self.tuned, []
        balance = HarmonicBalance(tuned.disk, tuned.highest, self.samples)
        for omega in tuned.band:
            found = first_point(balance, omega, self.level)
            if not found.converged:
                raise LostCurveError("The tuned disk could not be solved at an end of the band.")
            ends.append((omega, found.evaluation.point.forces))
        return tuple(ends)

    def curve(
        self,
        blade: Array,
        pull: Array,
        contacts: Sequence[Contact],
        measure: Measure,
        tolerance: float,
        report: Callable[[float], None] = lambda share: None,
        oriented: bool = False,
    ) -> WheelCurve:
        """The wheel with deviations of its blade frequencies (N,), factors of its static loads (N,), and contacts of all sectors.

        tolerance: relative, of the highest peak; oriented: as of `WheelBalance`. Raises `LostCurveError` where the curve does not
        cross the band.
        """
        balance = WheelBalance(self.tuned, self.few, self.samples, contacts, blade, pull)
        balance.oriented = oriented
        points = self._traced(balance, report)
        search = PeakSearch(balance, points, SEARCHED * tolerance, band=self.tuned.band)
        omega, sizes = np.array([p.point.omega for p in points]), np.array([sizes_of(balance, p, measure) for p in points])
        best = [points[k] for k in sizes.argmax(axis=0)]
        peak, unproven = sizes.max(axis=0), []
        for b in range(peak.size):
            report(0.5 * (1.0 + b / peak.size))
            found = search.peaks(b, measure, LEAST)
            unproven += [each for each in found.unproven if each.bound > peak[b]]
            for place in found.points:
                size = sizes_of(balance, place, measure)[b]
                if size > peak[b] and search.holds(place.point.omega):
                    peak[b], best[b] = size, place
        omegas = np.array([each.point.omega for each in best])
        finer = WheelBalance(self.tuned, self.more, self.samples, contacts, blade, pull)
        climbed = {}
        for b in np.flatnonzero(peak >= (1.0 - CLOSE) * peak.max()).tolist():
            climbed[b] = self._climbed(finer, best[b].point, b, measure, tolerance)
            peak[b], omegas[b] = climbed[b][:2]
        return WheelCurve(omega, sizes, peak, omegas, climbed[int(peak.argmax())][2], tuple(unproven))

    def _traced(self, balance: WheelBalance, report: Callable[[float], None]) -> list[CurvePoint]:
        """The points from one end of the band to the other, the first that arrives of the ways from both ends."""
        low, high = self.tuned.band
        lost: list[str] = []
        for (omega, forces), end in zip(self._ends, (high, low), strict=True):
            start = Point(self.tuned.wave(forces, self.few.U), omega, self.level)
            first = correct_wheel(balance, start, fixed("omega", omega), iterations=40, halvings=8)
            points: list[CurvePoint] = []
            try:
                for point in (
                    trace(balance, first, "omega", end, FOLDED if balance.oriented else STEPS) if first.converged else ()
                ):
                    points.append(point)
                    report(0.5 * abs(point.point.omega - omega) / (high - low))
                if points:
                    return points
                lost.append(f"Newton's method failed at {omega / (2.0 * np.pi):g} Hz, an end of the band.")
            except LostCurveError as reason:
                lost.append(f"From {omega / (2.0 * np.pi):g} Hz: {reason}{_open(balance, points[-1])}")
        raise LostCurveError(" ".join(lost))

    def _climbed(
        self, balance: WheelBalance, near: Point, blade: int, measure: Measure, tolerance: float
    ) -> tuple[float, float, Array]:
        """The peak of a blade on more shapes, from that on few: its size, ω, and the friction work of the dampers there."""
        between, c = self.more.U.T @ self.few.U, balance.columns
        forces = (between @ near.forces.reshape(self.tuned.sectors, -1, c)).reshape(-1, c)
        found = correct(balance, Point(forces, near.omega, near.level), fixed("omega", near.omega), iterations=20, halvings=8)
        if not found.converged:
            raise LostCurveError("Newton's method failed at the peak of a blade.")
        evaluation = found.evaluation
        with suppress(NoPeakError):  # at an end of the band the amplitude is highest without a peak
            evaluation = PeakSolver(balance, blade, measure, tolerance).from_solved(evaluation).evaluation
        low, high = self.tuned.band
        if not low <= evaluation.point.omega <= high:
            evaluation = found.evaluation
        rows = slice(0, balance.rows)
        work = cycle_work(evaluation.point.forces - evaluation.residual, evaluation.w[rows])
        size = measure.size(evaluation.w[balance.rows + blade], evaluation.point.omega)
        return size, evaluation.point.omega, work.reshape(self.tuned.sectors, -1).sum(axis=1)


def _open(balance: WheelBalance, last: CurvePoint) -> str:
    """How many contacts lift off during a period at the last point, as a sentence."""
    omega, normal = last.point.omega, balance.table.normal_row[balance.table.normal_row >= 0]
    force = contact_cycle(balance.table, balance.tables, balance.contacts_of(last.evaluation.w), omega).force[normal]
    return f" There, at {omega / (2.0 * np.pi):.6g} Hz, {np.any(force <= 0.0, axis=1).sum()} of {normal.size} contacts lift off."


def sizes_of(balance: HarmonicBalance, point: CurvePoint, measure: Measure) -> Array:
    """The measure of every blade."""
    return np.array([measure.size(row, point.point.omega) for row in point.evaluation.w[balance.rows :]])
