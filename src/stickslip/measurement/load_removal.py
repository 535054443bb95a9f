"""The zero of load cells by removing the load: piezo cells measure changes only, so the drop to no load is the static force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.checks import Array, fault, not_negative

SETTLED = 0.25
"""Share of the record at either end over which levels are averaged."""


@dataclass(frozen=True)
class Zero:
    """Reading of a cell without load, its standard error, and the force that the drop stands for, N."""

    reading: float
    error: float
    drop: float


def zero_by_load_removal(force: ArrayLike, calibration_error: float = 0.04, what: str = "The cell") -> Zero:
    """The zero of one cell from its reading while the load is taken away (n,) [N]: F = reading − zero.

    The first and the last quarter are taken as loaded and unloaded. error = √(noise²/n + (calibration_error × drop)²), the
    calibration factor being known to 3 to 5 %. Source: Gola and Gastaldi, ASME GT2014-25240.
    """
    values = np.asarray(force, dtype=float)
    if values.ndim != 1 or values.size < 40 or not np.all(np.isfinite(values)):
        raise fault(f"{what} during load removal", "must be at least 40 finite samples", values.shape)
    not_negative("calibration_error", calibration_error)
    size = int(SETTLED * values.size)
    loaded, unloaded = values[:size], values[-size:]
    noise = float(np.hypot(_scatter(loaded), _scatter(unloaded)))
    drop = float(loaded.mean() - unloaded.mean())
    if abs(drop) <= 5.0 * noise / np.sqrt(size) or abs(drop) <= noise:
        raise fault(f"{what} during load removal", "must drop by more than its noise", float(f"{drop:.3g}"), "Was load removed?")
    wander = abs(float(np.polyfit(np.arange(size), unloaded, 1)[0])) * size
    if wander > 0.1 * abs(drop):
        raise fault(f"{what} without load", "must be steady", f"drifting by {wander:.3g} N", "Let it settle.")
    return Zero(float(unloaded.mean()), float(np.hypot(_scatter(unloaded) / np.sqrt(size), calibration_error * drop)), drop)


def _scatter(values: Array) -> float:
    return float(np.std(np.diff(values)) / np.sqrt(2.0))
