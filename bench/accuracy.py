"""How right a sweep is: its points joined by one interpolation rule for every code, compared with exact solutions.

The rule is monotone cubic interpolation (Fritsch and Butland) of the first harmonic's amplitude over frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

PEAK_RIGHT = 1e-3
CURVE_RIGHT = 1e-2


@dataclass(frozen=True)
class Reference:
    """Exact amplitudes over the band, and the peak (amplitude, rad/s)."""

    omega: np.ndarray
    amplitude: np.ndarray
    peak: float
    peak_omega: float


@dataclass(frozen=True)
class Errors:
    """peak: of the highest point; of_peak: of the curve, largest over the band, relative to the peak; curve: relative to the
    local amplitude, which an antiresonance makes harsh; linear: as `of_peak`, with the points joined by straight lines."""

    peak: float
    curve: float
    of_peak: float
    linear: float

    @property
    def right(self) -> bool:
        return self.peak <= PEAK_RIGHT and self.of_peak <= CURVE_RIGHT

    def as_dict(self) -> dict[str, float]:
        return {"peak_error": self.peak, "curve_error": self.of_peak, "local_error": self.curve, "linear_error": self.linear}


def amplitudes(motion: Sequence[Sequence[float]]) -> np.ndarray:
    """First harmonic of points (mean, cosine, sine, ...)."""
    parts = np.asarray(motion)
    return np.hypot(parts[:, 1], parts[:, 2])


def errors(omega: Sequence[float], amplitude: np.ndarray, reference: Reference) -> Errors:
    """Errors of a sweep's points against the reference; infinite where the sweep does not cover the band."""
    x, first = np.unique(np.asarray(omega), return_index=True)
    y = amplitude[first]
    inside = (reference.omega >= x[0] - 1e-12) & (reference.omega <= x[-1] + 1e-12)
    if x.size < 2 or not inside.all():
        return Errors(np.inf, np.inf, np.inf, np.inf)
    smooth = np.abs(PchipInterpolator(x, y)(reference.omega) - reference.amplitude)
    straight = np.abs(np.interp(reference.omega, x, y) - reference.amplitude)
    return Errors(
        peak=float(abs(y.max() / reference.peak - 1.0)),
        curve=float(np.max(smooth / reference.amplitude)),
        of_peak=float(np.max(smooth) / reference.peak),
        linear=float(np.max(straight) / reference.peak),
    )
