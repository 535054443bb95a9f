"""Resonance peaks of the two linear limits, contacts absent and stuck, between which performance curves run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.linear_response import linear_amplitudes
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure

NEAR = 0.02
"""Share of a natural frequency within which its peak is sought first."""

WIDEST = 0.3
"""The share is doubled where the search ends at it, as with much damping, until it is beyond this."""


@dataclass(frozen=True)
class LinearPeak:
    """frequency [Hz] and size per unit force level of the highest peak of an output; NaN without damping."""

    frequency: float
    amplitude: float


def linear_peak(
    balance: HarmonicBalance,
    output: int,
    stuck: bool,
    measure: Measure = DISPLACEMENT_AMPLITUDE,
    band: tuple[float, float] = (0.0, np.inf),
) -> LinearPeak:
    """The resonance peak of an output without nonlinearity, as a measure of its first harmonic alone, of the mode that has the
    highest displacement: accelerations of higher modes, which no band holds, do not count.

    band: in Hz; of its modes where it holds any, else of all.
    """

    def amplitude(frequency: float) -> float:
        with np.errstate(all="ignore"):
            value = linear_amplitudes(balance, np.array([frequency]))[int(stuck)][0, output]
        return float(value) if np.isfinite(value) else np.inf

    def size(frequency: float) -> float:
        return float(measure.of_harmonic(np.array(amplitude(frequency)), np.array(2.0 * np.pi * frequency)))

    natural = balance.problem.frequencies(stuck=stuck)
    natural = natural[natural > 1e-4 * natural[-1]]
    inside = natural[(natural >= band[0]) & (natural <= band[1])]
    natural = inside if inside.size else natural
    if not balance.problem.C.any():
        sizes = [amplitude(1.001 * f) for f in natural]
        return LinearPeak(float(natural[int(np.argmax(sizes))]), np.nan)
    best = float(natural[int(np.argmax([amplitude(f) for f in natural]))])
    near = NEAR
    while True:
        ends = ((1.0 - near) * best, (1.0 + near) * best)
        found = scipy.optimize.minimize_scalar(lambda f: -size(f), bounds=ends, method="bounded", options={"xatol": 1e-7 * best})
        if abs(float(found.x) / best - 1.0) < 0.99 * near or near > WIDEST:
            return LinearPeak(float(found.x), float(-found.fun))
        near *= 2.0
