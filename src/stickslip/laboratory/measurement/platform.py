"""Measured platform motion from a table, to drive a damper between platforms."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stickslip.laboratory.measurement.cycles import HARMONICS, fitted_cycle, whole_cycles
from stickslip.laboratory.measurement.records import Record, read_record
from stickslip.model.dampers.platform_motion import PlatformMotion
from stickslip.support.checks import Array, fault

CLOSED = 1e-6
"""Difference of the first and the last row, relative to the range, at which the last repeats the first."""


def read_motion(path: str | Path, harmonics: int = HARMONICS, frequency: float | None = None) -> PlatformMotion:
    """The motion of the left platform from a table with `time`, `platform_x`, `platform_y` and their units; `platform_motion`."""
    return platform_motion(read_record(path), harmonics, frequency)


def platform_motion(record: Record, harmonics: int = HARMONICS, frequency: float | None = None) -> PlatformMotion:
    """The motion smoothed to so many harmonics; phase 0 is the first row, and a direction that is missing is at rest.

    frequency None: the table is one period, its last row one step short of the next (or a repetition of the first).
    frequency [Hz]: the mean of the whole cycles of a longer record.
    """
    names = [name for name in ("platform_x", "platform_y") if name in record.signals]
    if not names:
        raise fault(f"Columns of {record.name}", "must hold platform_x or platform_y", sorted(record.signals))
    if frequency is None:
        found = _one_period(record, names, harmonics)
    else:
        cycles = whole_cycles(record, frequency, harmonics)
        found = {name: cycles.channel(name) for name in names}
    rest = np.zeros(2 * harmonics + 1)
    return PlatformMotion([found.get("platform_x", rest), found.get("platform_y", rest)])


def _one_period(record: Record, names: list[str], harmonics: int) -> dict[str, Array]:
    """Harmonics of one period by least squares."""
    signals = np.stack([record.signals[name] for name in names])
    closed = np.all(np.abs(signals[:, -1] - signals[:, 0]) <= CLOSED * np.ptp(signals, axis=1).max())
    rows = record.time.size - int(closed)
    if rows < 2 * harmonics + 3:
        rule = f"must have more than {2 * harmonics + 2} rows for {harmonics} harmonics"
        raise fault(f"{record.name}", rule, rows, "Ask for fewer harmonics.")
    span = float(record.time[-1] - record.time[0]) + (0.0 if closed else float(np.median(np.diff(record.time))))
    values = fitted_cycle((record.time[:rows] - record.time[0]) / span, signals[:, :rows], harmonics)
    strength = np.sum(values[:, 1::2] ** 2 + values[:, 2::2] ** 2, axis=0)
    if int(np.argmax(strength)) > 0:
        rule = "must be one period of the motion"
        raise fault(f"{record.name}", rule, f"{np.argmax(strength) + 1} periods or so", "Cut one out, or give `frequency`.")
    return dict(zip(names, values, strict=True))
