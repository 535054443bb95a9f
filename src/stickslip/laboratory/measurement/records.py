"""Records of a rig: time and named signals in SI, read from a table and checked.

platform_x, platform_y   motion of the left platform relative to the right one, m
force_x, force_y         force of the damper on the right platform, from its load cells, N
rotation, damper_y       of the damper: counter-clockwise rotation, rad; motion along the pull, m
laser_1, laser_2         motion of two points of the damper along the pull, from lasers, m
left_outward, left_upward, right_outward, right_upward   force of each damper of the blade rig on its separator, from its cells, N
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip.laboratory.measurement.number_table import bare, text_table, to_si
from stickslip.support.checks import Array, InputError, fault, nearest

BLADE_CELLS = ("left_outward", "left_upward", "right_outward", "right_upward")
"""The load cells behind the dampers of the blade rig, two each."""

QUANTITIES = {
    "time": "s",
    **dict.fromkeys(("platform_x", "platform_y", "laser_1", "laser_2", "damper_y"), "m"),
    **dict.fromkeys(("force_x", "force_y", *BLADE_CELLS), "N"),
    "rotation": "rad",
}
"""Names of columns and the SI unit of each."""

RANGES = {"m": (1e-7, 5e-3), "N": (1e-2, 1e5), "rad": (1e-6, 0.5)}
"""Smallest and largest peak-to-peak value of a signal on a damper rig: outside, the unit is taken for wrong."""

ALIASES = {"t": "time", "h_lp": "platform_x", "w_lp": "platform_y", "h_r": "force_x", "v_r": "force_y", "beta": "rotation"}
"""Other names of columns: those of Gola and Gastaldi."""

IDLE = 1e-6
"""A direction of the platform that moves by less [m] is at rest; one of the two must move."""

LONGEST_CLIP = 4
"""Equal extreme samples in a row from which a signal counts as clipped."""


@dataclass(frozen=True, eq=False)
class Record:
    """time (n,) [s] and signals {name: (n,)}, SI; warnings: what was noticed, one sentence each; ranges {name: (low, high)}:
    the measuring range of a signal, where known, against which saturation is judged."""

    time: Array
    signals: Mapping[str, Array]
    name: str = "record"
    warnings: tuple[str, ...] = ()
    ranges: Mapping[str, tuple[float, float]] | None = None

    def __post_init__(self) -> None:
        name, time = self.name, self.time
        if time.ndim != 1 or time.size < 16:
            raise fault(f"{name}", "must have at least 16 samples", int(np.size(time)))
        if not np.all(np.isfinite(time)):
            raise fault(f"time of {name}", "must be finite", f"not so in {np.count_nonzero(~np.isfinite(time))} rows")
        back = np.flatnonzero(np.diff(time) <= 0.0)
        if back.size:
            raise fault(f"time of {name}", "must increase", f"not so after row {back[0] + 1}", "Was the record cut together?")
        signals = {key: np.asarray(values, dtype=float) for key, values in self.signals.items()}
        for key, values in signals.items():
            _check_signal(f"{key} of {self.name}", key, values, self.time.size)
            if key not in ("platform_x", "platform_y") or np.ptp(values) >= IDLE:
                _check_clipping(f"{key} of {self.name}", values, (self.ranges or {}).get(key))
        object.__setattr__(self, "signals", signals)

    def needs(self, *names: str) -> None:
        """Refuse a record in which a signal is missing."""
        missing = [name for name in names if name not in self.signals]
        if missing:
            raise fault(f"Columns of {self.name}", f"must hold {', '.join(missing)}", sorted(self.signals))


def _check_signal(what: str, key: str, values: Array, size: int) -> None:
    if key not in QUANTITIES or key == "time":
        raise InputError(f"{what} has no known meaning. {nearest(key, [name for name in QUANTITIES if name != 'time'])}")
    if values.shape != (size,):
        raise fault(what, f"must have {size} samples, as time has", values.shape)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise fault(what, "must be finite", f"not so in {bad.size} rows, first in row {bad[0] + 1}", "Cut them out.")
    smallest, largest = RANGES[QUANTITIES[key]]
    span = float(np.ptp(values))
    if key.startswith("platform") and span < IDLE:
        return
    if span == 0.0:
        raise fault(what, "must vary", f"constant at {values[0]:g}", "Is the channel connected?")
    if not smallest <= span <= largest:
        rule = f"must vary by {smallest:g} to {largest:g} {QUANTITIES[key]} peak to peak"
        raise fault(what, rule, float(f"{span:.4g}"), "Is its unit right?")


def _check_clipping(what: str, values: Array, limits: tuple[float, float] | None) -> None:
    """Refuse a saturated signal: runs of equal samples at its highest or lowest value, or samples at the end of its range."""
    if limits is not None and (values.max() >= limits[1] or values.min() <= limits[0]):
        raise fault(what, f"must stay inside its range {limits[0]:g} to {limits[1]:g}", "saturated", "Choose a larger range.")
    for extreme, side in ((values.max(), "highest"), (values.min(), "lowest")):
        longest = longest_run(values == extreme)
        if longest >= LONGEST_CLIP:
            raise fault(what, "must not be clipped", f"{longest} samples in a row at its {side} value {extreme:.6g}")


def longest_run(marks: Array) -> int:
    """Length of the longest run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(marks, dtype=np.int8), [0]])))
    return int(np.max(edges[1::2] - edges[::2], initial=0))


def read_record(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> Record:
    """A record from a table (CSV; comma, semicolon or tab; a decimal comma where commas separate no columns) whose first line
    names the columns, with units: `force_x [N]`.

    columns: {name here: header in the file} where they differ; units: {name: unit} where the header states none. Columns that
    are not known are left out, with a warning.
    """
    time, found, warnings = read_columns(path, columns, units)
    return Record(time, found, Path(path).stem, warnings, ranges)


def read_columns(
    path: str | Path, columns: Mapping[str, str] | None = None, units: Mapping[str, str] | None = None
) -> tuple[Array, dict[str, Array], tuple[str, ...]]:
    """Time and the other known columns of a table, in SI, and warnings; see `read_record`."""
    path, renamed = Path(path), {bare(title).lower(): name for name, title in (columns or {}).items()}

    def name_of(title: str) -> str:
        return renamed.get(title.lower()) or ALIASES.get(title.lower(), title.lower())

    if not path.is_file():
        raise fault("Record", "must be a file", str(path))
    table = text_table(path, lambda title: name_of(title) in QUANTITIES)
    if table.titles is None:
        raise fault(f"Columns of {path.name}", "must have titles", "missing", "Name them `time [s]`, `force_x [N]` and so on.")
    found: dict[str, Array] = {}
    warnings, strange = list(table.notes), []
    for title, stated, values in zip(table.titles, table.units, table.numbers.T, strict=True):
        name = name_of(title)
        if name not in QUANTITIES:
            strange.append(title)
            continue
        if name in found:
            raise fault(f"Columns of {path.name}", "must have different names", list(table.titles))
        unit = (units or {}).get(name) or stated
        if unit is None:
            remedy = f"Name the column `{name} [{QUANTITIES[name]}]`, or give it in `units`."
            raise fault(f"The unit of {name} in {path.name}", "must be stated", "missing", remedy)
        found[name] = values * to_si(f"The unit of {name} in {path.name}", unit, QUANTITIES[name])
    if strange:
        warnings.append(f"{path.name}: columns without a known meaning are left out: {', '.join(strange)}.")
    if "time" not in found:
        raise fault(f"Columns of {path.name}", "must hold time", list(table.titles), "Name it `time [s]`.")
    return found.pop("time"), found, tuple(warnings)
