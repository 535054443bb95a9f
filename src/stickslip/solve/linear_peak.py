"""The resonance peaks of the two linear limits, contacts absent and contacts stuck: what performance curves run between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.linear_response import linear_amplitudes

NEAR = 0.02
"""Share of a natural frequency within which its peak lies."""


@dataclass(frozen=True)
class LinearPeak:
    """frequency [Hz] and amplitude per unit force level [m] of the highest peak of an output; NaN without damping."""

    frequency: float
    amplitude: float


def linear_peak(balance: HarmonicBalance, output: int, stuck: bool) -> LinearPeak:
    """The highest resonance peak of |X_1| of an output without nonlinearity."""

    def amplitude(frequency: float) -> float:
        with np.errstate(all="ignore"):
            value = linear_amplitudes(balance, np.array([frequency]))[int(stuck)][0, output]
        return float(value) if np.isfinite(value) else np.inf

    natural = balance.problem.frequencies(stuck=stuck)
    natural = natural[natural > 1e-4 * natural[-1]]
    if not balance.problem.C.any():
        sizes = [amplitude(1.001 * f) for f in natural]
        return LinearPeak(float(natural[int(np.argmax(sizes))]), np.nan)
    best = float(natural[int(np.argmax([amplitude(f) for f in natural]))])
    ends = ((1.0 - NEAR) * best, (1.0 + NEAR) * best)
    found = minimize_scalar(lambda f: -amplitude(f), bounds=ends, method="bounded", options={"xatol": 1e-7 * best})
    return LinearPeak(float(found.x), float(-found.fun))
