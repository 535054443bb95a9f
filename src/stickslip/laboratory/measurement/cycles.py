"""Harmonics of the whole cycles of a record, with mean, scatter, frequency, and the cycles that were rejected.

Each cycle is fitted by harmonics (30 by default), which smooths it: measured displacements drive a model, and their noise
would look like motion of the contacts. Eight harmonics are too few for kt, a single unsmoothed cycle is worse. The motion of
a platform that drives a damper is smoothed alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize_scalar

from stickslip.laboratory.measurement.records import BLADE_CELLS, IDLE, Record, read_record
from stickslip.model.dampers.platform_motion import PlatformMotion
from stickslip.support.checks import Array, fault

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

    def with_channels(self, values: dict[str, Array]) -> CycleSet:
        """A copy with channels replaced or added, (cycles, 2H+1) each."""
        kept = {name: self.harmonics[:, i] for i, name in enumerate(self.channels)} | values
        return replace(self, channels=tuple(kept), harmonics=np.stack(list(kept.values()), axis=1))

    def without_lag(self, lag: float) -> CycleSet:
        """A copy whose forces come earlier by a lag [s], such as an identification finds."""
        cells = [c for c, name in enumerate(self.channels) if name.startswith("force")]
        found = self.harmonics.copy()
        found[:, cells] = delayed(found[:, cells], -2.0 * np.pi * self.frequency * lag)
        return replace(self, harmonics=found)

    def resampled(self, generator: np.random.Generator) -> CycleSet:
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
