"""Optimum of a performance curve (lowest peak per force) and its plateau, both solved between the given values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, log

import numpy as np
import scipy

from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.peaks.continuation import ContinuedPeaks, ParameterPeak, PeakContinuation
from stickslip.support.checks import Array

PLATEAU = 0.1
"""The plateau is where the peak is higher than at the optimum by at most this share."""

CLOSE, TRIALS = 2e-4, 40
"""To how much of its logarithm F_C/F_E is searched, and the most peaks that each search solves."""


@dataclass(frozen=True)
class LowestPeak:
    """F_C/F_E of the lowest peak, its amplitude per force in m/N and frequency in Hz; the ends of the plateau, NaN where the
    values end before; warning: why the optimum may not be the lowest, "" where none is known.
    """

    ratio: float
    amplitude_per_force: float
    frequency: float
    plateau: tuple[float, float]
    warning: str


class PeakBetween:
    """Peaks per force at any F_C/F_E, by its logarithm: those known, else followed from the values, else swept.

    force_at: excitation amplitude in N at a ratio.
    """

    def __init__(self, continuation: PeakContinuation, found: ContinuedPeaks, force_at: Callable[[float], float]) -> None:
        self.continuation, self.found, self.force_at = continuation, found, force_at
        known = {value: place[1] for value in found.values if (place := found.highest(value)) is not None}
        self.places: dict[float, ParameterPeak] = {log(value): place for value, place in known.items()}

    def __call__(self, x: float) -> float:
        """The peak per force, m/N, at ln(F_C/F_E); raises `LostCurveError` where no peak is found."""
        x = float(x)
        if x not in self.places:
            place = self.continuation.at(self.found, exp(x)) or self.continuation.swept(exp(x))
            if place is None:
                raise LostCurveError(f"no peak was found at F_C/F_E = {exp(x):.4g}")
            self.places[x] = place
        return self.places[x].peak.amplitude / self.force_at(self.places[x].value)

    @property
    def known(self) -> Array:
        """All ln(F_C/F_E) at which the peak is known, ascending."""
        return np.array(sorted(self.places))

    @property
    def lowest(self) -> float:
        """ln(F_C/F_E) of the lowest peak known."""
        return min(self.places, key=self)


def lowest_peak(peak: PeakBetween) -> LowestPeak:
    """The lowest peak, searched between the neighbours of the lowest known one, and the plateau around it."""
    values, best = peak.known, peak.lowest
    k, messages = int(np.searchsorted(values, best)), []
    if 0 < k < values.size - 1:
        try:
            ends = (float(values[k - 1]), float(values[k + 1]))
            scipy.optimize.minimize_scalar(peak, bounds=ends, method="bounded", options={"xatol": CLOSE, "maxiter": TRIALS})
        except LostCurveError as lost:
            messages.append(f"the search for the lowest peak ended, since {lost}")
    else:
        messages.append(f"the lowest peak is at an end of the values, F_C/F_E = {exp(best):.4g}: it may be lower beyond")
    best = peak.lowest
    peak.places[best], peak_band = peak.continuation.settled(peak.places[best])
    plateau = []
    for side in (-1, 1):
        try:
            plateau.append(_reached(peak, best, side))
        except LostCurveError as lost:
            plateau.append(np.nan)
            messages.append(f"an end of the plateau is not known, since {lost}")
    return LowestPeak(exp(best), peak(best), peak_band.omega / (2.0 * np.pi), (plateau[0], plateau[1]), "; ".join(messages))


def _reached(peak: PeakBetween, best: float, side: int) -> float:
    """The ratio beside the best one at which the peak is higher by the share of the plateau; NaN where the values end before."""
    height = (1.0 + PLATEAU) * peak(best)
    inner = best
    for x in peak.known[::side]:
        if (x - best) * side > 0.0:
            if peak(x) > height:
                return exp(
                    scipy.optimize.brentq(lambda x: log(peak(x) / height), inner, x, xtol=CLOSE, maxiter=TRIALS, disp=False)
                )
            inner = x
    return np.nan
