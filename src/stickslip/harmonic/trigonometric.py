"""True extremes in time of a truncated Fourier series, between the samples."""

from __future__ import annotations

import numpy as np

from stickslip.checks import Array


def largest_absolute(motion: Array) -> float:
    """max over time of |x(t)| for real storage (2H+1,): the best samples of a fine grid, refined by Newton's method on x'."""
    order = np.arange(1, (motion.size + 1) // 2)
    a, b = motion[1::2], motion[2::2]

    def series(angle: Array, derivative: int) -> Array:
        phases = np.outer(angle, order) + 0.5 * np.pi * derivative
        return np.asarray((np.cos(phases) * order**derivative) @ a + (np.sin(phases) * order**derivative) @ b)

    grid = 2.0 * np.pi * np.arange(16 * order.size + 16) / (16 * order.size + 16)
    values = np.abs(motion[0] + series(grid, 0))
    best = grid[np.argsort(values)[-4:]]
    step = grid[1]
    refined = best.copy()
    for _ in range(6):
        curvature = series(refined, 2)
        move = -series(refined, 1) / np.where(curvature == 0.0, np.inf, curvature)
        refined = np.clip(refined + move, best - step, best + step)
    return float(max(values.max(), np.abs(motion[0] + series(refined, 0)).max()))
