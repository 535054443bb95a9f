"""True extremes in time of a truncated Fourier series, between the samples."""

from __future__ import annotations

import numpy as np

from stickslip.checks import Array


def largest_absolute(motion: Array) -> tuple[float, Array]:
    """max over time of |x(t)| for real storage (2H+1,), and its gradient by the storage.

    The best samples of a fine grid, refined by Newton's method on x'.
    """
    order = np.arange(1, (motion.size + 1) // 2)
    size = 16 * order.size + 16
    grid = 2.0 * np.pi * np.arange(size) / size
    best = grid[np.argsort(np.abs(_basis(grid, order, 0) @ motion))[-4:]]
    refined = best.copy()
    for _ in range(6):
        curvature = _basis(refined, order, 2) @ motion
        move = -(_basis(refined, order, 1) @ motion) / np.where(curvature == 0.0, np.inf, curvature)
        refined = np.clip(refined + move, best - grid[1], best + grid[1])
    rows = _basis(np.concatenate([best, refined]), order, 0)
    values = rows @ motion
    k = int(np.argmax(np.abs(values)))
    return float(abs(values[k])), np.asarray(np.sign(values[k]) * rows[k])


def _basis(angles: Array, order: Array, derivative: int) -> Array:
    """Rows of 1, cos hθ, sin hθ, ... or of their first or second derivative by θ, (angles, 2H+1)."""
    phases = np.outer(angles, order) + 0.5 * np.pi * derivative
    rows = np.empty((angles.size, 2 * order.size + 1))
    rows[:, 0] = 1.0 if derivative == 0 else 0.0
    rows[:, 1::2] = np.cos(phases) * order**derivative
    rows[:, 2::2] = np.sin(phases) * order**derivative
    return rows
