"""Units at the edge: everything inside is SI. Constants for typing numbers in, and frequency bands.

>>> 25 * N_per_um
25000000.0
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import fault, positive

N_per_um = 1e6
um = 1e-6
mm = 1e-3
g = 1e-3
STANDARD_GRAVITY = 9.81
"""Acceleration that turns the dead weights of the rigs into newtons, m/s² (the value the published cases use)."""


@dataclass(frozen=True)
class Band:
    """A frequency band, in Hz; `start` above `stop` sweeps downwards."""

    start: float
    stop: float

    def __post_init__(self) -> None:
        positive("Band.start", self.start)
        positive("Band.stop", self.stop)
        if self.start == self.stop:
            raise fault("Band", "must have two different ends", (self.start, self.stop), "Widen it, or use `at`.")

    @property
    def low(self) -> float:
        return min(self.start, self.stop)

    @property
    def high(self) -> float:
        return max(self.start, self.stop)


def hertz(start: float, stop: float) -> Band:
    """The band from `start` to `stop`, both in Hz."""
    return Band(float(start), float(stop))


def radians_per_second(start: float, stop: float) -> Band:
    """The band from `start` to `stop`, both in rad/s."""
    return Band(start / (2.0 * pi), stop / (2.0 * pi))


def logspace(start: float, stop: float, points: int = 50) -> NDArray[np.float64]:
    """So many values from `start` to `stop` in equal ratios, say of F_C/F_E."""
    if points < 2:
        raise fault("points", "must be at least 2", points)
    return np.geomspace(positive("start", start), positive("stop", stop), points)
