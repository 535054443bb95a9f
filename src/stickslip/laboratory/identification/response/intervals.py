"""Intervals of parameters from frequency responses, two ways.

By the covariance, widened where residuals go together along a curve, and to how far tests disagree; and as lower bounds of
friction where no contact slips, or where the responses do not show that one does, by the profile of the sum of squares.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import special

from stickslip.laboratory.identification.least_squares import CERTAINTY
from stickslip.laboratory.identification.response.fit import ResponseFit
from stickslip.laboratory.measurement.measured_response import by_joint
from stickslip.support.checks import Array, Index

TINY = 1e-10
"""Share of the largest curvature below which the data say nothing of a direction."""

SIGNIFICANT = 2.0
"""Correlation of residuals, in standard errors of that of independent ones, below which it counts as none."""

TOGETHER = 2.0
"""Residuals go together from which on so many count as one: of fewer the model need lack nothing."""

FEWEST_TESTS = 3
"""Tests from which their disagreement gives a standard error: of two it would have one degree of freedom."""

ALONE = 0.99
"""Share of what is known of a direction from which on one test alone determines it, and no other can disagree."""

LIMIT = CERTAINTY**2
"""By which the sum of squares, in standard errors, may exceed the least one: 95 % quantile of χ² with one degree of freedom."""

FIRST, GROWTH = 0.02, 2.0
"""The first step of a parameter away from its value, as logarithm or as share of its bounds, and how steps grow."""

NARROWINGS = 5
"""Steps between the last value inside and the first one outside."""

ADAPTED = 8
"""Evaluations in which the other parameters are adapted to one value, at most."""

HALVINGS = 10
"""Of the distance between the value found and its bound, or of their logarithms."""

RAISED = (0.5, 0.999)
"""Shares of the way to its upper bound by which friction is raised until no contact slips."""

LEAST_NOISE = 1e-6
"""Variance of the residuals, relative to the stated errors, below which it is that of the solutions."""


@dataclass(frozen=True, eq=False)
class FitStatistics:
    """Standard errors and correlation of the variables; noise: residual variance over that of the stated errors; quantile: of a
    95 % interval in standard errors; blind: variables that the data say nothing of; one_in: of so many residuals one is
    independent."""

    error: Array
    correlation: Array
    noise: float
    quantile: float
    blind: np.ndarray[Any, np.dtype[np.bool_]]
    one_in: float = 1.0


def statistics(fit: ResponseFit, x: Array) -> FitStatistics:
    """Standard errors and correlations at a solution.

    Residuals that go together along the curves count by the number of independent ones, and errors are then not smaller than
    those by the disagreement of the tests.
    """
    residuals, J = fit.residuals(x), fit.jacobian(x)
    data = residuals[: residuals.size - sum(v.deviation is not None for v in fit.variables)]
    own = J[: data.size]
    root, lost = inverse_root(J.T @ J)
    covariance = root @ root.T
    # Variables that a prior holds count by the share of them that the data determine.
    determined = float(np.sum((own @ root) ** 2))
    freedom = max(data.size - determined, 1.0)
    noise = float(np.sum(data**2) / freedom)
    blind = np.sum(lost**2, axis=1) > 0.1
    one_in = independent_one_in(fit.series(x))
    quantile = float(special.stdtrit(max(data.size / one_in - determined, 1.0), 0.975))
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    error = np.sqrt(noise * one_in * np.diag(covariance))
    groups = [tests for _, tests in by_joint([model.test for model in fit.tests])]
    apart = len(groups) < len(fit.tests)  # joints differ whatever the residuals along their curves do
    if (one_in > 1.0 or apart) and len(groups) >= FEWEST_TESTS:
        between = error_between_tests(*by_tests(fit, residuals, J, groups))
        between *= float(special.stdtrit(len(groups) - 1, 0.975)) / quantile
        error[: between.size] = np.maximum(error[: between.size], between)
    return FitStatistics(np.where(blind, np.inf, error), covariance / np.outer(size, size), noise, quantile, blind, one_in)


def inverse_root(curvature: Array) -> tuple[Array, Array]:
    """R of the inverse R Rᵀ of a curvature in the directions that it knows, and the others, orthonormal in scaled variables."""
    scale = np.sqrt(np.maximum(np.diag(curvature), 1e-300))
    values, vectors = np.linalg.eigh(curvature / np.outer(scale, scale))
    known = values > TINY * values.max(initial=1e-300)
    root = vectors[:, known] / np.sqrt(values[known]) / scale[:, None]
    root[np.diag(curvature) == 0.0] = 0.0  # what is not seen at all has rounding there, over next to nothing
    return root, vectors[:, ~known]


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


def by_tests(
    fit: ResponseFit, residuals: Array, J: Array, groups: Sequence[Sequence[int]]
) -> tuple[list[tuple[Array, Array, Index]], Array, int]:
    """What `error_between_tests` takes of groups of tests, with the priors of each test among its residuals."""
    count, shared = sum(part.size for part in fit.parted(residuals)), len(fit.shared)
    held = np.array([v.test for v in fit.variables if v.deviation is not None], dtype=int)
    parts = []
    for t, (left, slopes) in enumerate(zip(fit.parted(residuals), fit.parted(J), strict=True)):
        rows = np.concatenate([slopes.reshape(-1, J.shape[1]), J[count:][held == t]])
        own = np.array([k for k, variable in enumerate(fit.variables) if variable.test == t], dtype=np.int64)
        parts.append((np.concatenate([left.ravel(), residuals[count:][held == t]]), rows, own))
    known = J[count:][held < 0][:, :shared]
    joined = []
    for tests in groups:
        left, rows, own = (np.concatenate([parts[t][k] for t in tests]) for k in range(3))
        joined.append((left, rows, own.astype(np.int64)))
    return joined, known.T @ known, shared


def error_between_tests(parts: Sequence[tuple[Array, Array, Index]], known: Array, shared: int) -> Array:
    """Standard errors (shared,) of the first variables by the disagreement of tests, (tests − 1) degrees of freedom.

    parts: of each test its residuals (n,), their derivatives (n, variables) and the numbers of its own variables, which are
    fitted to it; known (shared, shared): curvature of what is known beforehand.

    With g_t = J_tᵀ r_t and A = Σ J_tᵀ J_t the covariance is A⁻¹ Σ h_t h_tᵀ A⁻¹, h_t = A^½ (1 − A^-½ J_tᵀ J_t A^-½)^-½ A^-½ g_t
    (R. M. Bell, D. F. McCaffrey, Survey Methodology 28, 2002).
    """
    reduced = [_without_own(*part, shared) for part in parts]
    curvature = known + sum(J.T @ J for _, J in reduced)
    root, moved = inverse_root(curvature)[0], []
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


def profile_end(fit: ResponseFit, x: Array, k: int, side: float, limit: float) -> tuple[float, Array]:
    """Where the profile of variable k crosses the limit, or its bound, and the last variables found inside."""

    def adapted(value: float) -> tuple[Array, float]:
        """The others adapted to a value, where it needs that."""
        there = np.where(np.arange(x.size) == k, value, inside)
        if (cost := fit.cost(there)) <= limit:
            return there, cost
        found = fit.solved(there, [k], ADAPTED, ftol=1e-3)
        return found.x, found.cost

    bound = float(fit.bounds[0 if side < 0.0 else 1][k])
    inside, root, step = x, np.sqrt(fit.cost(x)), FIRST
    while True:
        value = side * min(side * (inside[k] + side * step), side * bound)
        there, cost = adapted(value)
        if cost > limit:
            break
        inside, root, step = there, np.sqrt(cost), GROWTH * step
        if value == bound:
            return bound, inside
    out, beyond, wanted = value, np.sqrt(cost), np.sqrt(limit)
    for _ in range(NARROWINGS):
        share = float(np.clip((wanted - root) / (beyond - root), 0.3, 0.7))
        value = inside[k] + share * (out - inside[k])
        there, cost = adapted(value)
        if cost > limit:
            out, beyond = value, np.sqrt(cost)
        else:
            inside, root = there, np.sqrt(cost)
    return float(inside[k] + (wanted - root) / (beyond - root) * (out - inside[k])), inside


def friction_bounds(fit: ResponseFit, x: Array, evaluations: int) -> tuple[Array, Array]:
    """The variables without slip where these fit as well as the least squares x, else x; and of each variable that all tests
    share the least value of friction, NaN of the others."""
    cost, known, found = fit.cost(x), statistics(fit, x), np.full(len(fit.shared), np.nan)
    stuck, raised = _never_slipping(fit, x, known.noise, evaluations)
    limit, numbers = cost + LIMIT * max(1.0, known.noise), np.arange(x.size)
    for k in raised:
        end = profile_end(fit, x, k, -1.0, limit)[0]
        found[k] = end if end > fit.bounds[0][k] else np.nan
    if raised:
        fit.forget()
    elif not any(np.any(one.slips) for one in fit.computed):
        # What the responses do not know: the least value at which, with the others as they are, they are explained as well.
        for k in [k for k in fit.shared if known.blind[k]]:
            low, high = float(fit.bounds[0][k]), float(x[k])
            if fit.cost(np.where(numbers == k, low, x)) > limit:
                for _ in range(HALVINGS):
                    middle = 0.5 * (low + high)
                    low, high = (low, middle) if fit.cost(np.where(numbers == k, middle, x)) <= limit else (middle, high)
                found[k] = high
    fit.residuals(stuck)
    return stuck, found


def _never_slipping(fit: ResponseFit, x: Array, noise: float, evaluations: int) -> tuple[Array, list[int]]:
    """The least squares with friction raised until no contact slips or opens, and the numbers of the raised variables: those of
    all tests that points without slip do not depend on. x and none where all stick at x, where that does not end slip, or where
    the sum of squares rises by 3.84 standard errors or more."""
    cost, J = fit.cost(x), fit.jacobian(x)
    rows = np.concatenate([np.tile(one.slips, count) for one, count in zip(fit.computed, fit.rows, strict=True)])
    sizes = np.array([np.max(np.abs(J[: rows.size][where]), axis=0, initial=0.0) for where in (rows, ~rows)])
    raised = [k for k in fit.shared if sizes[0, k] > 0.0 and sizes[1, k] <= TINY * sizes[0, k]]
    if not np.any(rows) or np.all(rows) or not raised:
        return x, []
    models = [replace(model, known=list(model.known)) for model in fit.tests]
    trial = replace(fit, tests=models, _last={})

    def slips(there: Array) -> bool:
        """Whether a contact slips or opens, or a point has no solution."""
        trial.residuals(there)
        return any(np.any(one.slips) or not np.all(one.solved) for one in trial.computed)

    for share in RAISED:
        there = x.copy()
        there[raised] += share * (fit.bounds[1][raised] - x[raised])
        if not slips(there):
            found = trial.solved(there, raised, evaluations)
            return (found.x, raised) if found.cost < cost + LIMIT * max(LEAST_NOISE, noise) and not slips(found.x) else (x, [])
    return x, []
