"""Windows of a measured decay: a damped sine fitted to each, with the error that all else in the record causes.

A fit by weighted least squares (Gauss–Newton) of

    x(s) = m + exp(−δ s − κ s²) (a cos(ω s + ν s²) + b sin(ω s + ν s²)),

s from the middle of a window; κ and ν are the change of δ and ω within it. A second sine without κ and ν stands beside it where
two lines lie in the band. At the solution ω, δ and the amplitude are linear maps g of the samples, and what is left over of the
record, with the spectrum S(f) around the window, gives them the variance

    var = ∫ |G(f)|² S(f) df,

G the transform of g: noise, hum, other modes and a suspension count with what the window lets through. At the mode itself, where
the fit leaves nothing, S is taken from beside it. The length of the windows is that with the smallest error.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import fft

from stickslip.support.checks import Array

LENGTHS = (2.0, 3.0, 5.0, 8.0, 12.0, 18.0, 27.0, 40.0, 60.0, 90.0, 135.0)
"""Lengths of windows that are tried, in cycles, in steps of about one and a half."""

TRIED = 6
"""Windows of each length from the beginning on, from which it is judged."""

ITERATIONS, ENOUGH = 30, 1e-9
"""Of Gauss-Newton in a window at most, and the relative step that ends it."""

FALLS = {True: 1.2, False: 0.7}
"""Largest exponent by which the amplitude may fall within a window whose ends are faded out, and in one with equal weights: the
fit knows two terms of its change."""

FADED = 0.45
"""Length of equal weights on which squares of a Hann window act alike, by their second moment, relative to its own."""

SURE, STEPS, SMALLEST = 5.0, 4.0, 1e-3
"""A decay ends where its amplitude is below so many standard errors, or steps of the resolution, or share of the largest."""

CONTRADICTED = 1.5
"""Joint standard errors by which damping ratios of short windows differ from those of longer ones, from which the difference is
taken as their error."""

STANDS_OUT = 30.0
"""Ratio of a line of what is left over to the median around it from which it is a second mode; the largest of 1000 values of
noise is ten times the median."""

DRIFTING = 1.5
"""Cycles of a window from which the change of frequency and damping within it is fitted too."""

MOST = 50.0
"""Largest exponent of the amplitude within a window."""


@dataclass(frozen=True)
class Shape:
    """How windows are cut: length in cycles; faded, weights of a squared Hann window, else equal ones; second: ω of a second mode
    in rad/s, 0 without one."""

    cycles: float
    faded: bool = True
    second: float = 0.0


class Record(NamedTuple):
    """What is evaluated: samples x at even times t [s], of the displacement (order 0), velocity (1) or acceleration (2), from the
    sample `first` on; band [rad/s]: where the mode lies; resolution: the step of the samples, 0 where they have none."""

    t: Array
    x: Array
    order: int
    first: int
    band: tuple[float, float]
    resolution: float

    @property
    def step(self) -> float:
        return float(self.t[1] - self.t[0])


class Window(NamedTuple):
    """A fitted window: its first sample and the time of its middle [s]; amplitude, ω, δ of the displacement, ν and κ there; ω of
    the second sine, 0 without one; maps (3, samples), how amplitude, ω and δ follow from the samples; motion (samples,) of the
    mode, and of both sines; standard errors of the three."""

    first: int
    middle: float
    amplitude: float
    omega: float
    delta: float
    bend: float
    fall: float
    second: float
    maps: Array
    motion: Array
    both: Array
    errors: Array


class Left(NamedTuple):
    """What windows of `length` samples leave over of a record from its first sample on, values (n,), and the width [Hz] to either
    side of a mode in which they leave nothing."""

    values: Array
    length: int
    width: float


Tried = tuple[Shape, list[Window]]


def fitted_windows(record: Record, omega: float, cycles: float | None) -> list[Window]:
    """The windows of a decay near ω, of the given length or of that with the smallest errors; none where no sine fits."""
    windows: list[Window] = []
    left: Left | None = None
    for shape in _ranked(record, omega):
        windows, left = _windows(record, omega, shape, hop=0.25)
        if len(windows) > 1:
            # Short windows follow hum and other modes, of which longer ones leave more over.
            left = left if cycles is not None and shape.cycles > cycles else None
            break
    if cycles is None:
        return windows
    both = [_windows(record, omega, Shape(cycles, faded), hop=0.25, left=left)[0] for faded in (True, False)]
    return min((each for each in both if each), key=_error, default=[])


def _ranked(record: Record, omega: float) -> list[Shape]:
    """The shapes of windows that fit, that with the smallest errors first."""
    most = 0.9 * omega / (2.0 * np.pi) * (record.t[-1] - record.t[record.first])
    tried = _tried(record, omega, [Shape(length, faded) for faded in (True, False) for length in LENGTHS if length < most])
    if tried and (second := _second(record, max(tried, key=lambda each: each[0].cycles)[1])) > 0.0:
        tried += _tried(record, omega, [replace(shape, second=second) for shape, _ in tried])
    tried = [each for each in tried if _falls(record, each[1]) < FALLS[each[0].faded]] or tried[:1]
    return [tried[number][0] for number in np.argsort(_judged(tried))] if tried else []


def _tried(record: Record, omega: float, shapes: Sequence[Shape]) -> list[Tried]:
    """The first windows of each shape, of those that fit two at least."""
    found = [(shape, _windows(record, omega, shape, hop=0.5, most=TRIED)[0]) for shape in shapes]
    return [each for each in found if len(each[1]) > 1]


def _half(windows: Sequence[Window]) -> Sequence[Window]:
    return windows[: max(2, len(windows) // 2)]


def _falls(record: Record, windows: Sequence[Window]) -> float:
    """The exponent by which the amplitude falls within a window."""
    return float(np.median([abs(each.delta) * each.motion.size * record.step for each in _half(windows)]))


def _judged(tried: Sequence[Tried]) -> list[float]:
    """The error of δ of each shape; where longer windows contradict, as they do short ones of two modes that beat, the
    difference."""
    judged, along = (
        [],
        [
            [
                np.array(values)
                for values in zip(*((each.middle, each.delta, float(each.errors[2])) for each in windows), strict=True)
            ]
            for _, windows in tried
        ],
    )
    for (shape, windows), (middle, own, error) in zip(tried, along, strict=True):
        least = _error(windows)
        for (longer, _), (beside, value, spread) in zip(tried, along, strict=True):
            inside = (beside >= middle[0]) & (beside <= middle[-1])  # of the short ones, which are denser, one reads between
            if longer.cycles <= shape.cycles or not np.any(inside):
                continue
            apart = np.median(np.abs(np.interp(beside[inside], middle, own) - value[inside]))
            joint = np.median(np.hypot(np.interp(beside[inside], middle, error), spread[inside]))
            if apart > CONTRADICTED * joint:
                least = max(least, float(apart))
        judged.append(least)
    return judged


def _error(windows: Sequence[Window]) -> float:
    return float(np.median([each.errors[2] for each in _half(windows)]))


def _windows(
    record: Record, omega: float, shape: Shape, hop: float, most: int | None = None, left: Left | None = None
) -> tuple[list[Window], Left | None]:
    """The windows of a shape, each `hop` of its length after the one before, at most so many, and what they leave over; with
    their errors, from what others leave over if that is given."""
    count, start = round(shape.cycles * 2.0 * np.pi / omega / record.step), record.first
    fitted: list[Window] = []
    rates = np.array([[omega, shape.second], [0.0, 0.0]])[:, : 1 + (shape.second > 0.0)]
    while start + count <= record.x.size and (most is None or len(fitted) < most):
        window = _fitted(record, start, count, rates, shape)
        if window is None or (fitted and window.amplitude < SMALLEST * fitted[0].amplitude):
            break
        fitted.append(window)
        rates = np.array([[window.omega, window.second], [window.delta, window.delta]])[:, : rates.shape[1]]
        start += max(int(hop * count), 1)
    if not fitted:
        return [], None
    # Seven parameters leave nothing of as many lines, of faded ones wider.
    width = (3.0 if shape.faded else 2.0) / (count * record.step)
    own = Left(record.x[record.first : fitted[-1].first + count] - motion_of(record, fitted), count, width)
    found: list[Window] = []
    for each in fitted:
        window = each._replace(errors=_errors(record, each, left or own, shape))
        if window.amplitude < max(SURE * window.errors[0], STEPS * record.resolution):
            break
        found.append(window)
    return found, own


def _fitted(record: Record, start: int, count: int, rates: Array, shape: Shape) -> Window | None:
    """The window from a sample on, from start values ω and δ (2, sines).

    None where the fit fails, or the motion ends within the window: it falls ever faster, κ > δ²/4, and is gone at the end.
    """
    t, x = record.t[start : start + count], record.x[start : start + count]
    middle, sines, least = 0.5 * float(t[0] + t[-1]), rates.shape[1], rates[0].copy()
    s, drifting = t - middle, shape.cycles >= DRIFTING
    weight = np.hanning(count + 2)[1:-1] ** 2 if shape.faded else np.ones(count)
    drift = np.zeros(2)  # ν and κ of the first
    if count < 2 * (3 + 4 * sines):
        return None
    for _ in range(ITERATIONS):
        turning, falling = rates[0, :, None] * s, rates[1, :, None] * s
        turning[0] += drift[0] * s**2
        falling[0] += drift[1] * s**2
        fading = np.exp(-np.clip(falling, -MOST, MOST))
        basis = np.vstack([np.ones_like(s), fading * np.cos(turning), fading * np.sin(turning)])
        coefficients = _least_squares(basis, weight, x)
        if coefficients is None:
            return None
        a, b = coefficients[1:].reshape(2, sines, 1)
        moving, across = a * basis[1 : 1 + sines] + b * basis[1 + sines :], b * basis[1 : 1 + sines] - a * basis[1 + sines :]
        drifts = [s**2 * across[0], -(s**2) * moving[0]] if drifting else []
        J = np.vstack([basis, s * across, -s * moving, *drifts])
        both = moving.sum(axis=0)
        change = _least_squares(J, weight, x - coefficients[0] - both)
        if change is None:
            return None
        steps = change[len(basis) : len(basis) + 2 * sines].reshape(2, sines)
        rates = rates + steps
        drift = drift + (change[-2:] if drifting else 0.0)
        if np.any((rates[0] <= 0.5 * least) | (rates[0] >= 2.0 * least) | (np.abs(rates[1]) > least)):
            return None
        if np.abs(steps[:, 0]).max() <= ENOUGH * rates[0, 0]:
            break
    else:
        return None
    if drifting and rates[1, 0] * s[-1] > 1.0 and drift[1] > 0.25 * rates[1, 0] ** 2:
        return None
    size, maps = float(np.hypot(a[0, 0], b[0, 0])), _least_squares(J, weight)
    if maps is None or size == 0.0:
        return None
    # The displacement is A/ω^order, and ω changes by 2ν in a unit of time.
    turn = 2.0 * record.order / rates[0, 0] if drifting else 0.0
    own = maps[[1, len(basis), len(basis) + sines]]
    own[0] = (a[0, 0] * maps[1] + b[0, 0] * maps[1 + sines]) / size
    own[2] += turn * maps[-2]
    delta, second = rates[1, 0] + turn * drift[0], rates[0, 1] if sines > 1 else 0.0
    bend, fall = drift.tolist()
    return Window(start, middle, size, rates[0, 0], delta, bend, fall, second, own, moving[0], both, np.zeros(3))


def _least_squares(rows: Array, weight: Array, x: Array | None = None) -> Array | None:
    """Coefficients (m,) of functions (m, n) with the least weighted squares of samples x (n,); without samples the linear maps
    (m, n) from them to the coefficients. None where the functions are not independent."""
    lengths = np.linalg.norm(rows, axis=1)
    if not np.all(lengths > 0.0):
        return None
    unit = rows / lengths[:, None]
    weighted = unit * weight
    try:
        return np.asarray((np.linalg.solve(weighted @ unit.T, weighted if x is None else weighted @ x).T / lengths).T)
    except np.linalg.LinAlgError:
        return None


def motion_of(record: Record, windows: Sequence[Window]) -> Array:
    """The motion of the sines from the first sample to the end of the last window, where windows overlap faded from one to the
    next."""
    count = windows[0].motion.size
    total = np.zeros((2, windows[-1].first + count - record.first))
    fade = np.hanning(count + 2)[1:-1] + 1e-6
    for each in windows:
        at = slice(each.first - record.first, each.first - record.first + count)
        total[:, at] += fade * each.both, fade
    return np.asarray(np.divide(total[0], total[1], out=np.zeros(total.shape[1]), where=total[1] > 0.0))


def _errors(record: Record, window: Window, left: Left, shape: Shape) -> Array:
    """Standard errors of amplitude, ω and δ from what is left over around a window, on a length of three, and the bias of what
    the third order of ln A and of the phase leaves in ω and δ: 2κδ/3 and 2νδ/3 as where friction takes the same from
    each cycle."""
    count, begin = window.motion.size, window.first - record.first
    beside = max(count, left.length)
    end = min(begin + count + beside, left.values.size)
    around = left.values[max(min(begin, end - beside) - beside, 0) : end]
    size = fft.next_fast_len(max(around.size, count), real=True)
    length, hertz = count * record.step, fft.rfftfreq(size, record.step)
    spectrum = _spectrum(around, size, record.step)
    for omega in (window.omega, window.second):
        if omega > 0.0:
            _fill(spectrum, hertz, omega / (2.0 * np.pi), left.width)
    spectrum += 2.0 * record.step * (np.finfo(float).eps * window.amplitude) ** 2  # of rounding
    passed = np.abs(fft.rfft(window.maps, size, axis=1)) ** 2
    variance = passed @ spectrum / (size * record.step)
    reach = 0.5 * length * (FADED if shape.faded else 1.0)
    third = 0.6 * reach**2 * 2.0 / 3.0 * window.delta * np.array([0.0, window.bend, window.fall])
    return np.asarray(np.sqrt(variance + third**2))


def _spectrum(values: Array, size: int, step: float) -> Array:
    """The one-sided power spectral density of values, by a Hann window."""
    fade = np.hanning(values.size)
    return np.asarray(2.0 * step / (fade @ fade) * np.abs(fft.rfft((values - values.mean()) * fade, size)) ** 2)


def _fill(spectrum: Array, hertz: Array, middle: float, width: float) -> None:
    """Raise a spectrum within `width` of a frequency to its mean on both sides there."""
    away = np.abs(hertz - middle)
    beside = (away >= width) & (away <= 3.0 * width)
    if np.any(beside):
        hole = away < width
        spectrum[hole] = np.maximum(spectrum[hole], spectrum[beside].mean())


def _second(record: Record, windows: Sequence[Window]) -> float:
    """ω of a second line in the band, within a third of the first, that stands out of what long windows leave over; 0 if none
    does."""
    count = windows[0].motion.size
    left = record.x[record.first : windows[-1].first + count] - motion_of(record, windows)
    size = fft.next_fast_len(2 * left.size, real=True)
    omega, spectrum = 2.0 * np.pi * fft.rfftfreq(size, record.step), _spectrum(left, size, record.step)
    own = windows[0].omega
    around = np.abs(omega - own) < own / 3.0
    hole = np.abs(omega - own) < 2.0 * np.pi * 2.0 / (count * record.step)
    inside = around & ~hole & (omega >= record.band[0]) & (omega <= record.band[1])
    if not np.any(inside):
        return 0.0
    best = int(np.argmax(np.where(inside, spectrum, 0.0)))
    return float(omega[best]) if spectrum[best] > STANDS_OUT * np.median(spectrum[around]) else 0.0
