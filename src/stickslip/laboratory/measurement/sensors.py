"""Several sensors of one ring-down as one record: a weighted sum that moves as the first does, with the least of all else.

A mode has one frequency, one damping ratio, and at each sensor a ratio c to the first. With the covariance S of what else the
sensors hold near the mode's frequency, the sum with the weights

    w = S⁻¹ c / (cᵀ S⁻¹ c)

holds the mode with the amplitude at the first sensor, and the least of the rest: hum and other modes cancel where the sensors
hold them in other ratios than the mode.
"""

from typing import NamedTuple

import numpy as np
from scipy.signal import hilbert

from stickslip.laboratory.measurement.decay_windows import Record, Window, fitted_windows, motion_of
from stickslip.support.checks import Array, listed

NEAR = 0.125
"""Relative distance from the frequency within which all that is not the mode counts. Delays of its inverse, in cycles,
separate close modes."""

LOUD = 8.0
"""Power relative to that beside the mode, a sensor, from which a line is no noise; e⁻⁸ of the lines of a sensor are as large."""

LITTLE = 0.1
"""Share of a ratio from which its imaginary part, or its change along the decay, is said."""


class Sensors(NamedTuple):
    """Of each sensor its weight, its complex ratio to the first with the standard error of its parts, and by how much this ratio
    changes between the halves of the energy."""

    weight: Array
    ratio: Array
    error: Array
    change: Array

    def sentence(self) -> str:
        """The ratios, and what does not fit to one mode that stands."""
        size, unsure = np.abs(self.ratio), 3.0 * self.error
        ratios = ", ".join(f"{value:.3g}" for value in self.ratio.real)
        text = f"{size.size} sensors as one record with the amplitude at the first, ratios to it {ratios}"
        turned = np.abs(self.ratio.imag) > np.maximum(unsure, LITTLE * size)
        changed = self.change > np.maximum(2.0 * unsure, LITTLE * size)
        for found, words in (
            (size < unsure, "no motion in the mode"),
            (turned & (size >= unsure), "out of phase"),
            (changed & (size >= unsure), "another ratio at the end of the decay, where another mode moves or the shape changes"),
        ):
            if np.any(found):
                text += f"; {words}: sensor {listed([str(number + 1) for number in np.flatnonzero(found)])}"
        return text


def summed(signals: Array, record: Record, omega: float) -> tuple[Record, Sensors | None]:
    """The record of the weighted sum of signals (n, sensors), and the sensors; None where no record has two windows."""
    start = record._replace(x=signals @ _separated(signals[record.first :], record.step, omega))
    windows = fitted_windows(start, omega, None)
    if len(windows) < 2 and len(windows := fitted_windows(record, omega, None)) < 2:
        return record, None
    sensors = _weighted(signals, record, windows)
    return record._replace(x=signals @ sensors.weight, resolution=0.0), sensors


def _separated(x: Array, step: float, omega: float) -> Array:
    """Weights (sensors,) that hold the larger of two modes near ω alone, from covariances at two delays, between which each mode
    turns by its own angle and noise is forgotten."""
    near = np.exp(-(((np.fft.fftfreq(len(x), step) * 2.0 * np.pi / omega - 1.0) / NEAR) ** 2))
    y = np.fft.ifft(np.fft.fft(x, axis=0) * near[:, None], axis=0)
    lag = min(round(2.0 * np.pi / (NEAR * omega * step)), len(y) // 4)
    once, twice = (y[delay:].T @ y[: len(y) - delay].conj() for delay in (lag, 2 * lag))
    left, sizes, right = np.linalg.svd(once)
    count = min(2, int(np.count_nonzero(sizes > 1e-9 * sizes[0])))  # of modes; one where nothing else is in the record
    left, right = left[:, :count], right[:count]
    shapes = left @ np.linalg.eig(left.conj().T @ twice @ right.conj().T / sizes[:count])[1]
    moves = np.sum(np.abs(np.linalg.pinv(shapes) @ y.T) ** 2, axis=1) * np.sum(np.abs(shapes) ** 2, axis=0)
    shapes = np.real(shapes / shapes[np.argmax(np.abs(shapes), axis=0), np.arange(count)])
    return np.asarray(np.linalg.pinv(shapes)[np.argmax(moves)])


def _weighted(signals: Array, record: Record, windows: list[Window]) -> Sensors:
    """The sensors, from the motion that windows find."""
    count = windows[0].motion.size
    turning = hilbert(motion_of(record, [each._replace(both=each.motion) for each in windows]))
    moving = signals[record.first : record.first + turning.size].T
    energy = np.cumsum(np.abs(turning) ** 2)
    half = int(np.searchsorted(energy, 0.5 * energy[-1]))
    halves = (slice(half), slice(half, None))
    begin, end = (2.0 * moving[:, part] @ turning[part].conj() / np.sum(np.abs(turning[part]) ** 2) for part in halves)
    shape = 2.0 * moving @ turning.conj() / energy[-1]
    rest = moving - np.real(shape[:, None] * turning)
    around, c = np.hanning(turning.size), np.real(shape)
    lines = np.fft.rfft((rest - rest.mean(axis=1, keepdims=True)) * around) * np.sqrt(2.0 * record.step / (around @ around))
    hertz, middle = np.fft.rfftfreq(turning.size, record.step), windows[0].omega / (2.0 * np.pi)
    width = 3.0 / (count * record.step)
    away = np.abs(hertz - middle)
    hole, beside = away < width, (away >= width) & (away <= 3.0 * width)
    floor = (np.finfo(float).eps * np.abs(shape).max() * np.abs(turning[0])) ** 2 * record.step * np.eye(c.size)
    S = np.real(lines[:, beside] @ lines[:, beside].conj().T) / np.count_nonzero(beside) + floor
    # In the hole the fits leave their own errors, which move with c; only lines that stand out from beside it apart from c count.
    best = np.linalg.solve(S, c)
    apart = lines - np.outer(c, best @ lines / (best @ c))
    used = ~hole | (np.sum(np.abs(apart) ** 2 / np.diagonal(S)[:, None], axis=0) > LOUD * c.size)
    error = np.sqrt(np.sum(np.abs(lines[:, hole & used]) ** 2, axis=1) / np.count_nonzero(hole) + np.diagonal(S))
    near = np.exp(-(((hertz / middle - 1.0) / NEAR) ** 2))
    S = np.real(lines[:, used] * near[used] @ lines[:, used].conj().T) + np.sum(near[~used]) * S
    best = np.linalg.solve(S, c)
    weight, size = best * c[0] / (best @ c), shape[0]
    return Sensors(weight, shape / size, error / np.sqrt(energy[-1] * record.step) / abs(size), np.abs((end - begin) / size))
