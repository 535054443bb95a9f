"""All peaks of a curve by a full sweep over a band: the continuation of the curve, each local maximum climbed to its summit."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from stickslip.harmonic.balance import HarmonicBalance
from stickslip.solve.continuation import StepControl, first_point, trace
from stickslip.solve.curve import RUN_UPS
from stickslip.solve.curve_points import CurvePoint, LostCurveError
from stickslip.solve.newton import correct, fixed
from stickslip.solve.peak import PROMINENCE
from stickslip.solve.summit import Ascent, NoSummitError, Summit, same

LEAST = 0.5
"""Peaks lower than this share of the highest are left out; one that grows is met by a later sweep."""

LONGEST = 400
"""Points along which the way from a peak to an end of the band is sought."""


def swept_summits(
    balance: HarmonicBalance, level: float, band: tuple[float, float], output: int
) -> tuple[list[Summit], int, int]:
    """Summits over a band in rad/s, the points of the curve, and the solutions spent on the summits.

    Raises `LostCurveError` where the curve does not reach the end of the band.
    """
    points = swept_curve(balance, level, band)
    row = balance.rows + output
    sizes = np.array([float(np.hypot(*point.evaluation.w[row, 1:3])) for point in points])
    tops = [k for k in _tops(points, row, sizes) if sizes[k] >= LEAST * sizes.max()]
    found: list[tuple[int, Summit]] = []
    solves = 0
    for k in tops:
        ascent = Ascent(balance, output)
        for beside in (k, k + 1, k - 1):
            with suppress(NoSummitError):
                found.append((k, ascent.from_solved(points[beside].evaluation)))
                break
        solves += ascent.solves
    inside = [(k, summit) for k, summit in found if band[0] < summit.omega < band[1]]
    return _prominent(inside, sizes), len(points), solves


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


def reaches_an_end(balance: HarmonicBalance, summit: Summit, band: tuple[float, float]) -> bool:
    """Whether the curve through a peak comes to an end of the band in rad/s; a closed one turns back on both sides."""
    first = correct(balance, summit.point, fixed("omega", summit.omega), iterations=40, halvings=12)
    for end in band if first.converged else ():
        with suppress(LostCurveError):
            *_, last = trace(balance, first, "omega", end, StepControl(points=LONGEST))
            if last.point.omega == end:
                return True
    return False


def _tops(points: Sequence[CurvePoint], row: int, sizes: np.ndarray) -> list[int]:
    """Points beside a change from rising to falling, the higher one of the two."""
    rising = []
    for point in points:
        a, b = point.evaluation.w[row, 1:3]
        rising.append(float(a * point.tangent.motion[row, 1] + b * point.tangent.motion[row, 2]) > 0.0)
    turns = [k for k in range(len(points) - 1) if rising[k] and not rising[k + 1]]
    return [k if sizes[k] >= sizes[k + 1] else k + 1 for k in turns]


def _prominent(found: list[tuple[int, Summit]], sizes: np.ndarray) -> list[Summit]:
    """Of maxima between which the curve does not dip, only the highest."""
    kept: list[tuple[int, Summit]] = []
    for k, summit in found:
        if kept:
            last, before = kept[-1]
            lower = min(before.amplitude, summit.amplitude)
            if same(before, summit) or min(sizes[last : k + 1], default=lower) > (1.0 - PROMINENCE) * lower:
                if summit.amplitude > before.amplitude:
                    kept[-1] = (k, summit)
                continue
        kept.append((k, summit))
    return [summit for _, summit in kept]
