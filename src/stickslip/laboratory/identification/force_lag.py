"""Lag of a measured friction force behind the displacement, by which kt is wrong: estimated with the law that was fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from stickslip.laboratory.identification.loop_law import ContactLoop, force_of
from stickslip.support.checks import Array

LONGEST = 0.05
"""Share of a period up to which a lag is looked for."""


@dataclass(frozen=True)
class ForceLag:
    """lag: share of a period by which the force comes late (below zero: early); kt [N/m] and mu with it taken away; left: sum of
    squares of the residuals over that without a lag."""

    lag: float
    kt: float
    mu: float
    left: float


def force_lag(loops: Sequence[ContactLoop], law: str, theta: Array) -> ForceLag:
    """The lag that explains loops best, fitted with the parameters (ln kt, ln mu, shape) of a law from where it fits without.

    At a reversal a contact sticks: its force turns with the displacement, however stiff it is. A force that turns later does so
    by its sensor or filter, unless the law lacks what makes it.
    """

    def apart(parameters: Array) -> Array:
        left = [advanced(np.asarray(loop.force), parameters[-1]) - force_of(loop, law, parameters[:-1]) for loop in loops]
        return np.concatenate([one - one.mean() for one in left])

    start = np.append(theta, 0.0)
    low, high = start - 2.0, start + 2.0
    low[2:-1], high[2:-1], low[-1], high[-1] = 0.0, 1.0, -LONGEST, LONGEST
    scale = np.append(np.full(theta.size, 0.1), 0.01)
    start = np.clip(start, low + 1e-9, high - 1e-9)
    found = least_squares(apart, start, bounds=(low, high), x_scale=scale)
    kt, mu = np.exp(found.x[:2])
    before = float(np.sum(apart(start) ** 2))
    return ForceLag(float(found.x[-1]), float(kt), float(mu), 2.0 * float(found.cost) / before if before > 0.0 else 1.0)


def advanced(values: Array, share: float) -> Array:
    """One cycle (n,), earlier by a share of its period."""
    spectrum = np.fft.rfft(values)
    turned = spectrum * np.exp(2j * np.pi * share * np.arange(spectrum.size))
    return np.asarray(np.fft.irfft(turned, values.size))
