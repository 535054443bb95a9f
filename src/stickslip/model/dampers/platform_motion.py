"""Periodic motion of the left platform relative to the right one, which drives a damper between platforms."""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import sha256

import numpy as np
from numpy.typing import ArrayLike

from stickslip.support.checks import Array, between, fault, finite, numbers, positive, whole


@dataclass(frozen=True, eq=False)
class PlatformMotion:
    """x and y of the left platform as real harmonics (2, 2H+1) [m]: rows a0, a1, b1, a2, b2, ...

    Platforms of neighbouring blades that move against each other close and open horizontally: `out_of_phase`. Blades in phase
    move the platforms past each other vertically: `in_phase`.
    """

    harmonics: ArrayLike

    def __post_init__(self) -> None:
        values = np.asarray(self.harmonics, dtype=float)
        if values.ndim != 2 or values.shape[0] != 2 or values.shape[1] % 2 == 0 or not np.all(np.isfinite(values)):
            raise fault("Harmonics of a platform motion", "must be finite, of shape (2, 2H+1)", np.shape(values))
        if not np.any(values[:, 1:]):
            raise fault("A platform motion", "must move", "all harmonics are zero", "Give a horizontal or a vertical amplitude.")
        object.__setattr__(self, "harmonics", values)

    @property
    def digest(self) -> str:
        """Identifies the motion."""
        return sha256(np.asarray(self.harmonics).tobytes()).hexdigest()[:12]

    def samples(self, steps: int) -> Array:
        """The motion at t_n = 2πn/(steps ω), (steps, 2) [m]."""
        values = np.asarray(self.harmonics)
        highest = (values.shape[1] - 1) // 2
        if whole("steps", steps) < max(8, 4 * highest):
            raise fault("steps", f"must be at least {max(8, 4 * highest)} for this motion", steps)
        angles = 2.0 * np.pi * ((np.arange(steps)[:, None] * np.arange(1, highest + 1)) % steps) / steps
        return np.asarray(values[:, 0] + np.cos(angles) @ values[:, 1::2].T + np.sin(angles) @ values[:, 2::2].T)


def out_of_phase(amplitude: float) -> PlatformMotion:
    """x = amplitude sin ωt: the gap between the platforms opens and closes. amplitude [m]."""
    return elliptic(positive("amplitude", amplitude), 0.0)


def in_phase(amplitude: float) -> PlatformMotion:
    """y = amplitude sin ωt: the platforms move past each other. amplitude [m]."""
    return elliptic(0.0, positive("amplitude", amplitude))


def elliptic(horizontal: float, vertical: float, phase: float = 90.0) -> PlatformMotion:
    """x = horizontal sin ωt, y = vertical sin(ωt + phase); amplitudes in m, phase in degrees."""
    angle = np.radians(finite("phase", phase)) if horizontal else 0.0
    x, y = finite("horizontal", horizontal), finite("vertical", vertical)
    return PlatformMotion([[0.0, 0.0, x], [0.0, y * np.sin(angle), y * np.cos(angle)]])


def measured(x: ArrayLike, y: ArrayLike, harmonics: int = 30) -> PlatformMotion:
    """The motion of one recorded cycle in equal time steps, x and y (n,) [m], smoothed to so many harmonics."""
    between("harmonics", harmonics, 1)
    across, up = numbers("x", x), numbers("y", y)
    if across.shape != up.shape:
        raise fault("x and y of a measured cycle", "must have equal length", f"of shapes {across.shape} and {up.shape}")
    signals = np.array([across, up])
    if signals.ndim != 2 or signals.shape[1] <= 2 * harmonics or not np.all(np.isfinite(signals)):
        raise fault("A measured cycle", f"must be finite and have more than {2 * harmonics} samples of x and y", signals.shape)
    spectrum = np.fft.rfft(signals, axis=1)[:, : harmonics + 1] / signals.shape[1]
    values = np.empty((2, 2 * harmonics + 1))
    values[:, 0] = spectrum[:, 0].real
    values[:, 1::2], values[:, 2::2] = 2.0 * spectrum[:, 1:].real, -2.0 * spectrum[:, 1:].imag
    return PlatformMotion(values)
