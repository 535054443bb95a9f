"""All peaks of a full sweep over a band, ready to be followed on."""

from __future__ import annotations

from contextlib import suppress

from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.continuation import trace
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.continuation.sweep import swept_curve
from stickslip.solve.peaks.climb import PeakSolver, SolvedPeak
from stickslip.solve.peaks.search import PeakSearch

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
