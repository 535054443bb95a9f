"""Measurement errors of a damper rig, for synthetic records, reconstruction and fits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from stickslip.support.checks import Array, not_negative

SIGNALS = ("force_x", "force_y", "rotation", "damper_y")
"""The channels that a damper answers with."""


@dataclass(frozen=True)
class RigErrors:
    """Standard deviations. Of each cell: gain, shape (linearity, greatest deviation) [N], zero after load removal [N], noise of
    a sample [N]; of lasers: noise of a sample [m]; of rotation and damper motion: gain (from distances on photographs); of
    the lag of all forces behind all motions [s]; of the calibration factor at load removal (3 to 5 %), which gives the error of
    a zero that is found so.

    Defaults follow Gola and Gastaldi (ASME GT2014-25240): cell 1 %, linearity 2 % (1 N, here a bound of two deviations),
    calibration at load removal 0.7 to 0.9 N, laser 0.08 µm, rotation and contact motion 5 %. The noise of a force sample is
    this project's. `lag` None: looked for, and fitted where it is more than gradual slip looks like; 0: forces and motions are
    synchronous; else always fitted. `zero_x`, `zero_y`: of the cells of
    force_x and force_y, where they differ from `zero`; for a cell whose zero is not known give as much as it may be off.
    """

    cell_gain: float = 0.01
    linearity: float = 0.5
    zero: float = 0.8
    force_noise: float = 0.05
    laser_noise: float = 0.08e-6
    motion_gain: float = 0.05
    zero_x: float | None = None
    zero_y: float | None = None
    lag: float | None = None
    calibration: float = 0.04

    def __post_init__(self) -> None:
        for field in fields(self):
            if getattr(self, field.name) is not None:
                not_negative(field.name, getattr(self, field.name))

    def zero_of(self, channel: str) -> float:
        """Standard deviation of the zero of a cell, N."""
        own = {"force_x": self.zero_x, "force_y": self.zero_y}[channel]
        return self.zero if own is None else own

    def with_zeros(self, zeros: Mapping[str, float]) -> RigErrors:
        """A copy with the standard deviations [N] of the zeros of some cells, by channel, as load removal gives them."""
        return replace(self, **{f"zero_{channel[-1]}": error for channel, error in zeros.items()})

    def gain(self, channel: str) -> float:
        """Standard deviation of the gain of a channel."""
        return self.cell_gain if channel.startswith("force") else self.motion_gain

    def draw(self, generator: np.random.Generator) -> dict[str, tuple[float, float, float]]:
        """One draw of the systematic errors: {channel: (gain error, linearity [N], zero [N])}."""
        drawn = {}
        for channel in SIGNALS:
            gain, shape, zero = generator.normal(size=3)
            drawn[channel] = gain * self.motion_gain, 0.0, 0.0
            if channel.startswith("force"):
                drawn[channel] = gain * self.cell_gain, shape * self.linearity, zero * self.zero_of(channel)
        return drawn


def distorted(values: Array, systematic: tuple[float, float, float]) -> Array:
    """What a channel shows instead of `values` (n,): (1 + gain) values + linearity × bow + zero, the bow being 0 at both ends
    of the range and 1 in its middle."""
    gain, linearity, zero = systematic
    middle, half = 0.5 * (values.max() + values.min()), max(0.5 * float(np.ptp(values)), 1e-300)
    return np.asarray((1.0 + gain) * values + linearity * (1.0 - ((values - middle) / half) ** 2) + zero)
