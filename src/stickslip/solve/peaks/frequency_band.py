"""The band around a peak in which the amplitude stays within a share of it: how well the frequency of a peak is known.

The curvature at the peak is no measure of it: sampling divides a flat top into facets, and a peak is the corner of two. The ends
of the band are solved, beyond the facets.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from math import sqrt

import numpy as np

from stickslip.solve.peaks.climb import NoPeakError, PeakSolver, SolvedPeak

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
