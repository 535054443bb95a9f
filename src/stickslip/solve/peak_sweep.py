"""All peaks of a curve from a full sweep over a band: each local maximum of the traced curve is solved as a peak."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

import numpy as np

from stickslip.harmonic.balance import Evaluation, HarmonicBalance
from stickslip.harmonic.measure import Measure
from stickslip.solve.continuation import StepControl, first_point, trace
from stickslip.solve.curve import RUN_UPS
from stickslip.solve.curve_points import CurvePoint, LostCurveError
from stickslip.solve.newton import correct, fixed
from stickslip.solve.peak import PROMINENCE, PeakSearch
from stickslip.solve.peak_solver import NoPeakError, PeakSolver, SolvedPeak

LEAST = 0.5
"""Peaks lower than this share of the highest are left out; one that grows is met by a later sweep."""

AROUND = 3
"""Points of the curve on both sides of a top between which its peak is searched where climbs from them go elsewhere."""

STRAYED = 1.01
"""A climb that ends elsewhere and so many times higher has left its top."""

LONGEST = 400
"""Points along which the way from a peak to an end of the band is sought."""


def swept_peaks(
    balance: HarmonicBalance, level: float, band: tuple[float, float], output: int, measure: Measure
) -> tuple[list[SolvedPeak], int, int]:
    """Peaks of a measure over a band in rad/s, the points of the curve, and the solutions spent on the peaks.

    Raises `LostCurveError` where the curve does not reach the end of the band.
    """
    points = swept_curve(balance, level, band)
    measured = [_slope(measure, point, balance.rows + output) for point in points]
    sizes = np.array([size for size, _ in measured])
    tops = [k for k in _tops([slope > 0.0 for _, slope in measured], sizes) if sizes[k] >= LEAST * sizes.max()]
    found: list[tuple[int, SolvedPeak]] = []
    solves = 0
    for k in tops:
        solver = PeakSolver(balance, output, measure)
        peak = _climbed(solver, points, sizes, k)
        found += [] if peak is None else [(k, peak)]
        solves += solver.solves
    inside = [(k, peak) for k, peak in found if band[0] < peak.omega < band[1]]
    return _prominent(PeakSolver(balance, output, measure), inside, sizes), len(points), solves


def swept_curve(balance: HarmonicBalance, level: float, band: tuple[float, float]) -> list[CurvePoint]:
    """The points from one end of the band to the other, from further out where Newton fails there or the curve turns back."""
    reason = "No point could be solved at the start of the band."
    for run_up in RUN_UPS:
        first = first_point(balance, run_up * band[0], level)
        if not first.converged:
            continue
        try:
            points = list(trace(balance, first, "omega", band[1]))
        except LostCurveError as lost:
            reason = str(lost)
            continue
        if points[-1].point.omega == band[1]:
            return [point for point in points if point.point.omega >= band[0]]
        reason = "The curve turned back."
    raise LostCurveError(reason)


def reaches_an_end(balance: HarmonicBalance, peak: SolvedPeak, band: tuple[float, float]) -> bool:
    """Whether the curve through a peak comes to an end of the band in rad/s; a closed one turns back on both sides."""
    first = correct(balance, peak.point, fixed("omega", peak.omega), iterations=40, halvings=12)
    for end in band if first.converged else ():
        with suppress(LostCurveError):
            *_, last = trace(balance, first, "omega", end, StepControl(points=LONGEST))
            if last.point.omega == end:
                return True
    return False


def _slope(measure: Measure, point: CurvePoint, row: int) -> tuple[float, float]:
    """The size of a row at a point of a curve, and its slope along it."""
    tangent = point.tangent
    size, slope = measure.slope(point.evaluation.w[row], point.point.omega, tangent.motion[row], tangent.parameter)
    return size, float(slope)


def _tops(rising: Sequence[bool], sizes: np.ndarray) -> list[int]:
    """Points beside a change from rising to falling, the higher one of the two."""
    turns = [k for k in range(len(rising) - 1) if rising[k] and not rising[k + 1]]
    return [k if sizes[k] >= sizes[k + 1] else k + 1 for k in turns]


def _climbed(solver: PeakSolver, points: Sequence[CurvePoint], sizes: np.ndarray, k: int) -> SolvedPeak | None:
    """The peak of the top beside point k, from the points around it; where they climb elsewhere, from the peak between them."""
    around = points[max(k - AROUND, 0) : k + AROUND + 1]

    def near() -> Iterator[Evaluation]:
        yield from (points[beside].evaluation for beside in (k, k + 1, k - 1) if 0 <= beside < len(points))
        search = PeakSearch(solver.balance, around, solver.tolerance)
        yield from (peak.evaluation for peak in search.peaks(solver.output, solver.measure).points)

    for start in near():
        with suppress(NoPeakError):
            peak = solver.from_solved(start)
            if not _strayed(peak, points[max(k - 1, 0) : k + 2], sizes[k]):
                return peak
    return None


def _strayed(peak: SolvedPeak, beside: Sequence[CurvePoint], size: float) -> bool:
    """Whether a climb went away from a top of a given size to a higher one, which may lie on an isola."""
    omegas = [point.point.omega for point in beside]
    span = max(omegas) - min(omegas)
    elsewhere = not min(omegas) - span <= peak.omega <= max(omegas) + span
    return elsewhere and peak.amplitude > STRAYED * size


def _prominent(solver: PeakSolver, found: list[tuple[int, SolvedPeak]], sizes: np.ndarray) -> list[SolvedPeak]:
    """Of maxima between which the curve does not dip, only the highest."""
    kept: list[tuple[int, SolvedPeak]] = []
    for k, peak in found:
        if kept:
            last, before = kept[-1]
            lower = min(before.amplitude, peak.amplitude)
            dip = min(sizes[last : k + 1], default=lower)
            if dip > (1.0 - PROMINENCE) * lower or solver.same_peak(before, peak):
                if peak.amplitude > before.amplitude:
                    kept[-1] = (k, peak)
                continue
        kept.append((k, peak))
    return [peak for _, peak in kept]
