"""Harmonics of the whole cycles of a record, with mean, scatter, frequency, and the cycles that were rejected.

Each cycle is fitted by harmonics (30 by default), which smooths it: measured displacements drive a model, and their noise
would look like motion of the contacts. Eight harmonics are too few for kt, a single unsmoothed cycle is worse. The motion of
a platform that drives a damper is smoothed alike.

Zeros of load cells by removing the load: piezo cells measure changes only, so the drop to no load is the static force.

A table of the cells' readings while the weights are taken off, at once or one after the other, with the platforms at rest and
without resetting the cells after the loops; what the cells show in the end is the zero of these loops.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from stickslip.laboratory.measurement.records import BLADE_CELLS, IDLE, Record, read_columns, read_record
from stickslip.model.dampers.between_platforms import PlatformMotion
from stickslip.support.checks import Array, counted, fault, not_negative

HARMONICS = 30
FEWEST_CYCLES = 3
FEW_CYCLES = 8
GAP = 1.5
"""A step in time of more than this times the median is a gap. Up to half a period of the highest harmonic it does no harm."""

DRIFT = 0.02
"""Drift over the record, relative to the peak-to-peak value, from which it is stated."""

CLOSED = 1e-6
"""Difference of the first and the last row, relative to the range, at which the last repeats the first."""


@dataclass(frozen=True, eq=False)
class CycleSet:
    """Cycles of one case: harmonics (cycles, channels, 2H+1), SI, rows a0, a1, b1, ...; the channels, the frequency [Hz], the
    name of the record, warnings, the pull on the damper [N] where it is the case's own, and the standard deviations [N] of
    the zeros of its load cells where a load removal gave them."""

    name: str
    channels: tuple[str, ...]
    harmonics: Array
    frequency: float
    warnings: tuple[str, ...] = ()
    pull: float | None = None
    zero_errors: Mapping[str, float] = field(default_factory=dict)

    @property
    def mean(self) -> Array:
        """Harmonics of the mean cycle, (channels, 2H+1)."""
        return np.asarray(self.harmonics.mean(axis=0))

    @property
    def standard_error(self) -> Array:
        """Of the mean cycle's harmonics from the scatter of cycles, (channels, 2H+1)."""
        return np.asarray(self.harmonics.std(axis=0, ddof=1) / np.sqrt(len(self.harmonics)))

    def channel(self, name: str) -> Array:
        """The mean harmonics of one channel, (2H+1,)."""
        return np.asarray(self.mean[self.index(name)])

    def cycle(self, name: str, samples: int = 500) -> Array:
        """The mean cycle of one channel at equal times, (samples,)."""
        return synthesis(samples, (self.harmonics.shape[2] - 1) // 2) @ self.channel(name)

    def has(self, name: str) -> bool:
        return name in self.channels

    def with_channels(self, values: dict[str, Array]) -> "CycleSet":
        """A copy with channels replaced or added, (cycles, 2H+1) each."""
        kept = {name: self.harmonics[:, i] for i, name in enumerate(self.channels)} | values
        return replace(self, channels=tuple(kept), harmonics=np.stack(list(kept.values()), axis=1))

    def without_lag(self, lag: float) -> "CycleSet":
        """A copy whose forces come earlier by a lag [s], such as an identification finds."""
        cells = [c for c, name in enumerate(self.channels) if name.startswith("force")]
        found = self.harmonics.copy()
        found[:, cells] = delayed(found[:, cells], -2.0 * np.pi * self.frequency * lag)
        return replace(self, harmonics=found)

    def resampled(self, generator: np.random.Generator) -> "CycleSet":
        """A copy whose cycles are drawn with replacement."""
        count = len(self.harmonics)
        return replace(self, harmonics=self.harmonics[generator.integers(0, count, count)])

    def index(self, name: str) -> int:
        """Place of a channel."""
        if name not in self.channels:
            raise fault(f"Channels of {self.name}", f"must hold {name}", list(self.channels))
        return self.channels.index(name)


def synthesis(samples: int, harmonics: int) -> Array:
    """From harmonics to values at equal times of one cycle, (samples, 2H+1)."""
    return columns_at(np.arange(samples) / samples, harmonics)


def analysis(values: Array, harmonics: int) -> Array:
    """Harmonics (..., 2H+1) of one cycle in equal times (..., samples)."""
    spectrum = np.fft.rfft(values, axis=-1)[..., : harmonics + 1] / values.shape[-1]
    found = np.empty((*values.shape[:-1], 2 * harmonics + 1))
    found[..., 0] = spectrum[..., 0].real
    found[..., 1::2], found[..., 2::2] = 2.0 * spectrum[..., 1:].real, -2.0 * spectrum[..., 1:].imag
    return found


def delayed(harmonics: Array, angle: Array | float) -> Array:
    """Harmonics (..., 2H+1) of the same signal later by an angle [rad] of the first harmonic, which broadcasts against (...)."""
    count = (harmonics.shape[-1] - 1) // 2
    turn = np.asarray(angle)[..., None] * np.arange(1, count + 1)
    cosine, sine, a, b = np.cos(turn), np.sin(turn), harmonics[..., 1::2], harmonics[..., 2::2]
    found = np.array(harmonics)
    found[..., 1::2], found[..., 2::2] = cosine * a - sine * b, sine * a + cosine * b
    return found


def columns_at(phase: Array, harmonics: int) -> Array:
    """1, cos and sin of all harmonics at phases, (samples, 2H+1)."""
    angles = 2.0 * np.pi * phase[:, None] * np.arange(1, harmonics + 1)
    matrix = np.ones((phase.size, 2 * harmonics + 1))
    matrix[:, 1::2], matrix[:, 2::2] = np.cos(angles), np.sin(angles)
    return matrix


def whole_cycles(
    record: Record, frequency: float | None = None, harmonics: int = HARMONICS, pull: float | None = None
) -> CycleSet:
    """The whole cycles of a record. frequency [Hz]: found from the platform's motion unless given. Phase 0 is the first sample.

    Cycles with gaps longer than half a period of the highest harmonic are left out and drift is stated, both as warnings; a few
    missing rows do no harm. Fewer than three whole cycles are refused.
    """
    driver = _driver(record)
    rate = found_frequency(record.time, record.signals[driver]) if frequency is None else frequency
    phase = (record.time - record.time[0]) * rate
    count = int(np.floor(phase[-1] + 1.5 * np.median(np.diff(phase))))
    per_cycle = record.time.size / max(phase[-1], 1e-9)
    if count < FEWEST_CYCLES:
        raise fault(f"{record.name}", f"must hold at least {FEWEST_CYCLES} whole cycles", count, "Record more of them.")
    if per_cycle < 2 * harmonics + 3:
        rule = f"must have more than {2 * harmonics + 2} samples a cycle for {harmonics} harmonics"
        raise fault(f"{record.name}", rule, round(float(per_cycle), 1), "Sample faster, or request fewer harmonics.")
    gaps = _cycles_with_gaps(phase, harmonics)
    kept = [k for k in range(count) if k not in gaps]
    warnings = [*record.warnings]
    if listed := ", ".join(str(k + 1) for k in sorted(gaps) if k < count):
        warnings.append(f"{record.name}: cycles with gaps are left out: {listed} of {count}.")
    if len(kept) < FEWEST_CYCLES:
        raise fault(f"{record.name}", f"must hold at least {FEWEST_CYCLES} cycles without gaps", len(kept))
    if len(kept) < FEW_CYCLES:
        warnings.append(f"{record.name}: only {len(kept)} cycles; their scatter is a poor measure of the error.")
    cycles = []
    for k in kept:  # the first and last sample of a cycle may be half a step short
        inside = (phase >= k - 1e-9) & (phase < k + 1 - 1e-9)
        values = np.stack([signal[inside] for signal in record.signals.values()])
        cycles.append(fitted_cycle(phase[inside] - k, values, harmonics))
    found = np.stack(cycles)
    channels = tuple(record.signals)
    warnings += _said_drift(record.name, channels, found, kept)
    return CycleSet(record.name, channels, found, rate, tuple(warnings), pull)


def _driver(record: Record) -> str:
    """The platform direction that moves most; on the blade rig, where no platform is measured, the cell whose force does."""
    names = [name for name in ("platform_x", "platform_y") if name in record.signals]
    cells = [name for name in BLADE_CELLS if name in record.signals]
    if cells and not names:
        return max(cells, key=lambda name: float(np.ptp(record.signals[name])))
    if not names:
        raise fault(f"Columns of {record.name}", "must hold platform_x or platform_y", sorted(record.signals))
    driver = max(names, key=lambda name: float(np.ptp(record.signals[name])))
    if np.ptp(record.signals[driver]) < IDLE:
        rule = f"must move by at least {IDLE:g} m peak to peak"
        raise fault(f"The platform of {record.name}", rule, float(np.ptp(record.signals[driver])), "Is its unit right?")
    return driver


def found_frequency(time: Array, values: Array) -> float:
    """The frequency [Hz] of a periodic signal: from its spectrum, then by least squares of one harmonic and a trend."""
    even = np.linspace(time[0], time[-1], time.size)
    centred = np.interp(even, time, values) - values.mean()
    spectrum = np.abs(np.fft.rfft(centred * np.hanning(even.size)))
    peak = int(np.argmax(spectrum[1:])) + 1
    span = time[-1] - time[0]

    def left(rate: float) -> float:
        angle = 2.0 * np.pi * rate * (time - time[0])
        matrix = np.stack([np.cos(angle), np.sin(angle), np.ones_like(time), time - time[0]], axis=1)
        return float(np.sum((values - matrix @ np.linalg.lstsq(matrix, values, rcond=None)[0]) ** 2))

    low, high = max(peak - 1.0, 0.3) / span, (peak + 1.0) / span
    rate = minimize_scalar(left, bounds=(low, high), method="bounded", options={"xatol": 1e-7 * peak / span}).x
    if left(rate) > 0.2 * float(np.sum((values - values.mean()) ** 2)):
        raise fault("The motion", "must be periodic", "not so", "Give the frequency, or check the record.")
    return float(rate)


def _cycles_with_gaps(phase: Array, harmonics: int) -> set[int]:
    """Cycles in which a gap hides half a period of the highest harmonic, or in which too few samples are left for all of them."""
    steps = np.diff(phase)
    wide = np.flatnonzero(steps > max(GAP * float(np.median(steps)), 0.5 / harmonics))
    holed = {k for i in wide for k in range(int(phase[i]), int(np.ceil(phase[i + 1] - 1e-9)))}
    samples = np.bincount(np.floor(phase + 1e-9).astype(np.int64))
    return holed | {k for k, count in enumerate(samples) if count < 2 * harmonics + 3}


def fitted_cycle(phase: Array, values: Array, harmonics: int) -> Array:
    """Harmonics (signals, 2H+1) of values (signals, samples) at phases (samples,) in [0, 1) by least squares."""
    return np.asarray(np.linalg.lstsq(columns_at(phase, harmonics), values.T, rcond=None)[0].T)


def _said_drift(name: str, channels: tuple[str, ...], harmonics: Array, kept: list[int]) -> list[str]:
    """Which channels wander from cycle to cycle."""
    warnings, numbers = [], np.asarray(kept, dtype=float)
    size = synthesis(200, (harmonics.shape[2] - 1) // 2)
    for c, channel in enumerate(channels):
        span = float(np.ptp(size @ harmonics[:, c].mean(axis=0)))
        slope = float(np.polyfit(numbers, harmonics[:, c, 0], 1)[0]) * float(np.ptp(numbers))
        chance = float(np.std(np.diff(harmonics[:, c, 0]))) * np.sqrt(6.0 / numbers.size)
        if abs(slope) > max(DRIFT * span, 4.0 * chance) and span > 0.0:
            warnings.append(f"{name}: {channel} drifts by {slope:.3g} over the record, {abs(slope) / span:.0%} of its range.")
    return warnings


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
