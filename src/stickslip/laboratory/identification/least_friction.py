"""Lower bounds of friction where no contact slips, or where the responses do not show that one does.

Noise at a few points is fitted by a little slip, so the least sum of squares may have some. Where never slipping fits as well,
the responses hold no more than a lower bound: below it a contact would slip, and they would show it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stickslip.laboratory.identification.computed_response import FittedTest
from stickslip.laboratory.identification.profile_interval import LIMIT, profile_end
from stickslip.laboratory.identification.response_fit import TINY, ResponseFit
from stickslip.support.checks import Array

HALVINGS = 10
"""Of the distance between the value found and its bound, or of their logarithms."""

RAISED = (0.5, 0.999)
"""Shares of the way to its upper bound by which friction is raised until no contact slips."""

LEAST_NOISE = 1e-6
"""Variance of the residuals, relative to the stated errors, below which it is that of the solutions."""


def friction_bounds(fit: ResponseFit, x: Array, evaluations: int) -> tuple[Array, Array]:
    """The variables without slip where these fit as well as the least squares x, else x; and of each variable that all tests
    share the least value of friction, NaN of the others."""
    stuck, raised = _never_slipping(fit, x, evaluations)
    if not raised:
        return x, _least_friction(fit, x)
    statistics = fit.statistics(x)
    limit, shared = fit.cost(x) + LIMIT * max(1.0, statistics.noise), sum(v.test < 0 for v in fit.variables)
    found = np.full(shared, np.nan)
    for k in raised:
        end = profile_end(fit, x, k, -1.0, limit)[0]
        found[k] = end if end > fit.bounds[0][k] else np.nan
    fit.forget()
    fit.residuals(stuck)
    return stuck, found


def _never_slipping(fit: ResponseFit, x: Array, evaluations: int) -> tuple[Array, list[int]]:
    """The least squares with friction raised until no contact slips or opens, and the numbers of the raised variables: those of
    all tests that points without slip do not depend on. x and none where all stick at x, where that does not end slip, or where
    the sum of squares rises by 3.84 standard errors or more."""
    cost, statistics, J = fit.cost(x), fit.statistics(x), fit.jacobian(x)
    slips = [fit.found(t).slips for t in range(len(fit.tests))]
    rows = np.concatenate([np.tile(one, count) for one, count in zip(slips, fit.rows, strict=True)])
    own = J[: rows.size]
    sizes = np.array([np.max(np.abs(own[where]), axis=0, initial=0.0) for where in (rows, ~rows)])
    friction = (sizes[0] > 0.0) & (sizes[1] <= TINY * sizes[0])
    raised = [k for k, v in enumerate(fit.variables) if v.test < 0 and friction[k]]
    if not np.any(rows) or np.all(rows) or not raised:
        return x, []
    limit = cost + LIMIT * max(LEAST_NOISE, statistics.noise)
    models = [replace(model, known=list(model.known)) for model in fit.tests if isinstance(model, FittedTest)]
    trial = replace(fit, tests=models, computed=[], _last={})
    for share in RAISED:
        there = x.copy()
        there[raised] += share * (fit.bounds[1][raised] - x[raised])
        trial.residuals(there)
        if not _any_slips(trial):
            there = trial.solved_others(there, raised, evaluations)
            if trial.cost(there) < limit and not _any_slips(trial):
                return there, raised
            break
    return x, []


def _any_slips(fit: ResponseFit) -> bool:
    """Whether a contact slips or opens where residuals were last evaluated, or a point has no solution."""
    found = [fit.found(t) for t in range(len(fit.tests))]
    return any(np.any(one.slips) or not np.all(one.solved) for one in found)


def _least_friction(fit: ResponseFit, x: Array) -> Array:
    """Of each variable that all tests share and that the responses do not know: the least value at which, with the others as
    they are, the sum of squares is at most 3.84 standard errors above that at x. NaN where contacts slip or open at x, and where
    the responses do not see the parameter down to its bound either."""
    cost, statistics = fit.cost(x), fit.statistics(x)
    shared = [k for k, variable in enumerate(fit.variables) if variable.test < 0]
    found = np.full(len(shared), np.nan)
    if any(np.any(fit.found(t).slips) for t in range(len(fit.tests))):
        return found
    limit = cost + LIMIT * max(1.0, statistics.noise)

    def cost_at(k: int, value: float) -> float:
        return fit.cost(np.where(np.arange(x.size) == k, value, x))

    for place, k in enumerate(shared):
        low, high = float(fit.bounds[0][k]), float(x[k])
        if not statistics.blind[k] or cost_at(k, low) <= limit:
            continue
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if cost_at(k, middle) <= limit else (middle, high)
        found[place] = high
    fit.residuals(x)
    return found
