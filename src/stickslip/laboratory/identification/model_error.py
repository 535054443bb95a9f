"""Errors of the model in intervals: residuals that go together along a curve, and pull parameters apart from test to test.

Least squares with independent residuals do not know them. Where the residuals are independent, nothing here changes an interval.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stickslip.support.checks import Array, Index

SIGNIFICANT = 2.0
"""Correlation of residuals, in standard errors of that of independent ones, below which it counts as none."""

FEWEST_TESTS = 3
"""Tests from which their disagreement gives a standard error: of two it would have one degree of freedom."""

ALONE = 0.99
"""Share of what is known of a direction from which on one test alone determines it, and no other can disagree."""


def independent_one_in(series: Sequence[Array]) -> float:
    """One in how many residuals is independent, 1 + 2 Σ ρ_k over the lags k before ρ_k is no longer significant; ρ_k is the
    autocorrelation over all series, each (points,) along one curve. 1 where neighbours are independent."""
    square, count = sum(float(one @ one) for one in series), sum(one.size for one in series)
    found = 1.0
    for lag in range(1, min(one.size for one in series) // 2):
        correlation = sum(float(one[lag:] @ one[:-lag]) for one in series) / max(square, 1e-300)
        if correlation < SIGNIFICANT / np.sqrt(count):
            break
        found += 2.0 * correlation
    return found


def above_noise(series: Sequence[Array]) -> float:
    """Residuals, root mean square, over their noise, which second differences show: those of independent ones are √6 times as
    large, those of smooth ones vanish."""
    square, count = sum(float(one @ one) for one in series), sum(one.size for one in series)
    second = np.concatenate([np.diff(one, 2) for one in series])
    return float(np.sqrt(square / count / max(float(np.mean(second**2)) / 6.0, 1e-300)))


def error_between_tests(parts: Sequence[tuple[Array, Array, Index]], known: Array, shared: int) -> Array:
    """Standard errors (shared,) of the first variables by the disagreement of tests, (tests − 1) degrees of freedom.

    parts: of each test its residuals (n,), their derivatives (n, variables) and the numbers of its own variables, which are
    fitted to it; known (shared, shared): curvature of what is known beforehand.

    With g_t = J_tᵀ r_t and A = Σ J_tᵀ J_t the covariance is A⁻¹ Σ h_t h_tᵀ A⁻¹, h_t = A^½ (1 − A^-½ J_tᵀ J_t A^-½)^-½ A^-½ g_t
    (R. M. Bell, D. F. McCaffrey, Survey Methodology 28, 2002).
    """
    reduced = [_without_own(*part, shared) for part in parts]
    curvature = known + sum(J.T @ J for _, J in reduced)
    scale = np.sqrt(np.maximum(np.diag(curvature), 1e-300))
    values, vectors = np.linalg.eigh(curvature / np.outer(scale, scale))
    seen = values > 1e-10 * values.max(initial=1e-300)
    root = vectors[:, seen] / np.sqrt(values[seen]) / scale[:, None]
    moved = []
    for residuals, J in reduced:
        own, directions = np.linalg.eigh((J @ root).T @ (J @ root))
        factor = 1.0 / np.sqrt(1.0 - np.clip(own, 0.0, ALONE))
        moved.append(root @ (directions * factor @ (directions.T @ ((J @ root).T @ residuals))))
    return np.asarray(np.sqrt(np.sum(np.square(moved), axis=0)))


def _without_own(residuals: Array, J: Array, own: Index, shared: int) -> tuple[Array, Array]:
    """Residuals and derivatives by the shared variables, with a test's own variables fitted to it."""
    both = np.column_stack([residuals, J[:, :shared]])
    if own.size:
        both = both - J[:, own] @ np.linalg.lstsq(J[:, own], both, rcond=1e-10)[0]
    return both[:, 0], both[:, 1:]
