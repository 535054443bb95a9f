"""The curve of one mistuned wheel over a band and the highest amplitude of each of its blades.

Few shapes a sector carry the curve and the proof that no maximum of a blade is missed; the highest blades are then climbed to on
more of them. The curve begins where the tuned wave is, at an end of the band.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stickslip.model.contact.point import Contact
from stickslip.model.disks.tuned import TunedDisk
from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.balance.energy import contact_cycle, cycle_work
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.peaks.climb import NoPeakError, PeakSolver
from stickslip.solve.peaks.search import PeakSearch, Unproven
from stickslip.solve.wheels.balance import WheelBalance
from stickslip.solve.wheels.newton import correct_wheel
from stickslip.solve.wheels.tuned import Shapes, TunedWheel
from stickslip.support.checks import Array

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
