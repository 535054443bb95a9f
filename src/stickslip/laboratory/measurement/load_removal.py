"""Zeros of load cells by removing the load: piezo cells measure changes only, so the drop to no load is the static force.

A table of the cells' readings while the weights are taken off, at once or one after the other, with the platforms at rest and
without resetting the cells after the loops; what the cells show in the end is the zero of these loops.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from stickslip.laboratory.measurement.cycles import CycleSet, whole_cycles
from stickslip.laboratory.measurement.records import Record, read_columns
from stickslip.support.checks import Array, counted, fault, not_negative

CALIBRATION = 0.04
"""Error of the calibration factor at load removal, relative: 3 to 5 % in Gola and Gastaldi, ASME GT2014-25240."""

WINDOW = 0.01
"""Share of the record over which readings are averaged to see whether they change."""

FLAT = 0.02
"""Change from one window to the next, relative to the range, below which a reading is flat, unless its noise is larger."""

CLEAR = 6.0
"""Standard deviations of the noise from which a change is one."""

SHORTEST = 0.02
"""Shortest level, as a share of the record."""

WANDER = 0.1
"""Wandering within a level, and rise from level to level, relative to the whole drop, that is refused."""

CELLS = ("force_x", "force_y")


@dataclass(frozen=True)
class Zero:
    """Reading of a cell without load, its standard error, the force that the drop stands for, and the levels on the way, N."""

    reading: float
    error: float
    drop: float
    levels: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class LoadRemoval:
    """Readings {force_x, force_y: (n,)} [N] of the cells while the load is taken away."""

    forces: Mapping[str, Array]
    name: str = "load removal"

    def __post_init__(self) -> None:
        missing = [cell for cell in CELLS if cell not in self.forces]
        if missing:
            raise fault(f"Columns of {self.name}", f"must hold {', '.join(missing)}", sorted(self.forces))

    def zeros(self, calibration: float = CALIBRATION) -> dict[str, Zero]:
        """The zero of each cell. Refused where a reading rises: the damper presses both cells, so that it must fall."""
        found = {cell: zero_by_load_removal(self.forces[cell], calibration, f"{cell} of {self.name}") for cell in CELLS}
        for cell, zero in found.items():
            if zero.drop < 0.0:
                rule, remedy = "must fall while the load is removed", "Is its sign reversed, or was load put on?"
                raise fault(f"{cell} of {self.name}", rule, f"rising by {-zero.drop:.4g} N", remedy)
        return found


def read_load_removal(
    path: str | Path, columns: Mapping[str, str] | None = None, units: Mapping[str, str] | None = None
) -> LoadRemoval:
    """A load removal from a table with `time`, `force_x` and `force_y` as of `read_record`; other columns are left out."""
    _, found, _ = read_columns(path, columns, units)
    return LoadRemoval({cell: found[cell] for cell in CELLS if cell in found}, Path(path).name)


def zeroed(
    loops: Sequence[CycleSet | Record], removals: LoadRemoval | Sequence[LoadRemoval], calibration: float = CALIBRATION
) -> tuple[CycleSet, ...]:
    """Loops as cycles with the zeros of their cells removed, and with the errors of these zeros: one load removal for all loops,
    or one each."""
    each = [removals] * len(loops) if isinstance(removals, LoadRemoval) else list(removals)
    each = each * len(loops) if len(each) == 1 else each
    if len(each) != len(loops):
        raise fault("load_removal", f"must be one for all loops, or {len(loops)}, one a loop", len(each))
    cases = (whole_cycles(one) if isinstance(one, Record) else one for one in loops)
    found = []
    for case, one in zip(cases, each, strict=True):
        zeros, channels = one.zeros(calibration), {}
        for cell, zero in zeros.items():
            values = case.harmonics[:, case.index(cell)].copy()
            values[:, 0] -= zero.reading
            channels[cell] = values
        found.append(replace(case.with_channels(channels), zero_errors={cell: zero.error for cell, zero in zeros.items()}))
    return tuple(found)


def zero_by_load_removal(force: ArrayLike, calibration_error: float = CALIBRATION, what: str = "The cell") -> Zero:
    """The zero of one cell from its reading while the load is taken away (n,) [N], in one step or several: F = reading − zero.

    The first flat level is the loaded one, the last the unloaded one, which must reach to the end of the record. error =
    √(noise²/n + (calibration_error × drop)²), n the samples of the last level. Source: Gola and Gastaldi, ASME GT2014-25240.
    """
    values = np.asarray(force, dtype=float)
    if values.ndim != 1 or values.size < 40 or not np.all(np.isfinite(values)):
        raise fault(f"{what} during load removal", "must be at least 40 finite samples", values.shape)
    not_negative("calibration_error", calibration_error)
    noise = float(np.median(np.abs(np.diff(values))) / (0.6745 * np.sqrt(2.0)))
    parts = [values[part] for part in _levels(values, noise)]
    drop = float(parts[0].mean() - parts[-1].mean()) if parts else 0.0
    if len(parts) < 2 or abs(drop) <= CLEAR * noise / np.sqrt(min(map(len, parts))):
        remedy = "Was load removed? The record must begin loaded and end unloaded, each for a while."
        raise fault(
            f"{what} during load removal",
            "must fall from one flat level to another",
            f"at {counted(len(parts), 'flat level')}",
            remedy,
        )
    for part, state in ((parts[0], "under load"), (parts[-1], "without load")):
        wander = abs(float(np.polyfit(np.arange(part.size), part, 1)[0])) * part.size
        if wander > WANDER * abs(drop):
            raise fault(f"{what} {state}", "must be steady", f"drifting by {wander:.3g} N", "Let it settle.")
    levels = tuple(float(part.mean()) for part in parts)
    if np.any(np.diff(levels) * np.sign(drop) > WANDER * abs(drop)):
        shown = ", ".join(f"{level:.4g}" for level in levels)
        raise fault(f"Levels of {what} during load removal", "must go one way", f"{shown} N", "Was load put on again?")
    return Zero(levels[-1], float(np.hypot(noise / np.sqrt(parts[-1].size), calibration_error * drop)), drop, levels)


def _levels(values: Array, noise: float) -> list[slice]:
    """Where the reading is flat, from the first sample on and to the last; the transients between are left out."""
    width = max(4, round(WINDOW * values.size))
    means = np.convolve(values, np.full(width, 1.0 / width), "valid")
    change = np.abs(means[width:] - means[:-width])
    moving = change > max(FLAT * float(np.ptp(means)), CLEAR * noise * np.sqrt(2.0 / width))
    edges = np.flatnonzero(np.diff(np.concatenate([[1], moving.astype(np.int8), [1]])))
    shortest = max(10, round(SHORTEST * values.size))
    found = []
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        first = 0 if start == 0 else int(start) + width
        last = values.size if stop == moving.size else int(stop) + width
        if last - first >= shortest:
            found.append(slice(first, last))
        elif first == 0 or last == values.size:
            return []
    touches = found and found[0].start == 0 and found[-1].stop == values.size
    return found if touches else []
