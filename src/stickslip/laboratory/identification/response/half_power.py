"""The peak of a response curve, computed or measured: frequency, size, and damping ratio from the width at half power."""

from __future__ import annotations

import numpy as np

from stickslip.support.checks import Array


def at_frequencies(wanted: Array, frequency: Array, size: Array) -> Array:
    """The size at wanted frequencies (n,) by straight lines along a curve, the largest where it is folded; NaN beside it."""
    found = np.full(wanted.shape, np.nan)
    if frequency.size < 2:
        return found
    for a, b, x, y in zip(frequency[:-1], frequency[1:], size[:-1], size[1:], strict=True):
        here = np.flatnonzero((wanted >= min(a, b)) & (wanted <= max(a, b)))
        if here.size:
            share = (wanted[here] - a) / (b - a) if a != b else np.zeros(here.size)
            found[here] = np.fmax(found[here], (1.0 - share) * x + share * y)
    return found


def curve_peak(frequency: Array, size: Array, peak: tuple[float, float] | None) -> Array:
    """Frequency, size and damping ratio (3,) of a computed curve with a known peak, in the order of travel; NaN without one."""
    if peak is None:
        return np.full(3, np.nan)
    at = int(np.argmin(np.abs(frequency / peak[0] - 1.0) + np.abs(size / peak[1] - 1.0)))
    return np.array([*peak, half_power(frequency, size, at, *peak)])


def measured_peak(frequency: Array, size: Array) -> Array:
    """Frequency, size and damping ratio (3,) of a measured curve, ascending: by the parabola through its largest point and both
    neighbours; NaN where the largest is an end. Points without a size are left out."""
    there = np.isfinite(size)
    frequency, size = frequency[there], size[there]
    if size.size < 3:
        return np.full(3, np.nan)
    at = int(np.argmax(size))
    if at in (0, size.size - 1):
        return np.full(3, np.nan)
    f, s = frequency[at - 1 : at + 2], size[at - 1 : at + 2]
    bend, slope, _ = np.polyfit(f - f[1], s, 2)
    away = float(np.clip(-0.5 * slope / bend, f[0] - f[1], f[2] - f[1])) if bend < 0.0 else 0.0
    top = float(s[1] + (slope + bend * away) * away)
    return np.array([f[1] + away, top, half_power(frequency, size, at, f[1] + away, top)])


def half_power(frequency: Array, size: Array, at: int, peak_frequency: float, peak_size: float) -> float:
    """Damping ratio Δf/(2 f) between the points on both sides where a curve has fallen to 1/√2 of its peak, point `at`; NaN where
    it does not fall so far."""
    wanted, ends = peak_size / np.sqrt(2.0), []
    for step in (-1, 1):
        k = at
        while 0 <= k + step < size.size and size[k] > wanted:
            k += step
        if size[k] > wanted:
            return float("nan")
        before = k - step
        share = (size[before] - wanted) / (size[before] - size[k])
        ends.append(float(frequency[before] + share * (frequency[k] - frequency[before])))
    return abs(ends[1] - ends[0]) / (2.0 * peak_frequency)
