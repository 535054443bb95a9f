"""Exact extremes in time of a truncated Fourier series."""

from __future__ import annotations

import numpy as np

from stickslip.support.checks import Array
from stickslip.support.kernels import boxed, inner, kernel

CANDIDATES = 4
"""How many of the best samples are refined."""


@inner
def series(motion: Array, angle: float) -> tuple[float, float, float]:
    """x, x' and x'' by angle, for real storage (2H+1,)."""
    value, first, second = motion[0], 0.0, 0.0
    one, other, cosine, sine = np.cos(angle), np.sin(angle), 1.0, 0.0
    for h in range(1, (motion.size + 1) // 2):
        cosine, sine = cosine * one - sine * other, sine * one + cosine * other
        a, b = motion[2 * h - 1], motion[2 * h]
        value += a * cosine + b * sine
        first += h * (b * cosine - a * sine)
        second -= h * h * (a * cosine + b * sine)
    return value, first, second


@kernel
def largest_absolute(motion: Array) -> tuple[float, Array]:
    """max over time of |x(t)| for real storage (2H+1,), and its gradient by the storage.

    The best samples of a fine grid, refined by Newton's method on x'.
    """
    size = 8 * motion.size
    step = 2.0 * np.pi / size
    values = np.empty(size)
    for n in range(size):
        values[n] = -abs(series(motion, n * step)[0])
    largest, place = -1.0, 0.0
    for n in np.argsort(values)[:CANDIDATES]:
        angle = n * step
        for _ in range(6):
            _, first, second = series(motion, angle)
            if second != 0.0:
                angle = min(max(angle - first / second, (n - 1) * step), (n + 1) * step)
        for candidate in (n * step, angle):
            value = abs(series(motion, candidate)[0])
            if value > largest:
                largest, place = value, candidate
    gradient = np.empty(motion.size)
    gradient[0] = 1.0
    for h in range(1, (motion.size + 1) // 2):
        gradient[2 * h - 1], gradient[2 * h] = np.cos(h * place), np.sin(h * place)
    if series(motion, place)[0] < 0.0:
        gradient = -gradient
    return boxed((largest, gradient))
