"""Intervals of parameters by the profile of the sum of squares: all values at which the others can still make up for it.

For fits whose residuals vanish over a whole region, as those against bounds do: curvature at one point says nothing there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.laboratory.identification.response_fit import ResponseFit
from stickslip.support.checks import Array, Index

LIMIT = 3.84
"""By which the sum of squares, in standard errors, may exceed the least one: 95 % quantile of χ² with one degree of freedom."""

FIRST, GROWTH = 0.02, 2.0
"""The first step of a parameter away from its value, as logarithm or as share of its bounds, and how steps grow."""

NARROWINGS = 5
"""Steps between the last value inside and the first one outside."""

WIDER = 0.99
"""Sum of squares over that before a search for wider bounds below which the others are adapted once more."""

ADAPTED = 8
"""Evaluations in which the other parameters are adapted to one value, at most."""


@dataclass(frozen=True, eq=False)
class ProfileIntervals:
    """Ends (2, parameters) of the variables that all tests share, low and high; middle: the mean of the variables (n,) that were
    found at the ends, inside the region wherever that is convex."""

    ends: Array
    middle: Array


def profile_intervals(fit: ResponseFit, x: Array) -> ProfileIntervals:
    """The intervals of the shared parameters around the least sum of squares at x."""
    cost = fit.cost(x)
    outside = int(np.count_nonzero(fit.residuals(x)))
    limit = cost + LIMIT * max(1.0, cost / max(outside - x.size, 1))
    shared = [k for k, v in enumerate(fit.variables) if v.test < 0]
    found = {(side, k): profile_end(fit, x, k, side, limit) for k in shared for side in (-1.0, 1.0)}
    ends = np.array([[found[side, k][0] for k in shared] for side in (-1.0, 1.0)])
    return ProfileIntervals(ends, np.mean([there for _, there in found.values()], axis=0))


def profile_end(fit: ResponseFit, x: Array, k: int, side: float, limit: float) -> tuple[float, Array]:
    """Where the profile of variable k crosses the limit, or its bound, and the last variables found inside."""
    bound = float(fit.bounds[0 if side < 0.0 else 1][k])
    inside, root, step = x, np.sqrt(fit.cost(x)), FIRST
    while True:
        value = inside[k] + side * step
        value = bound if side * (value - bound) >= 0.0 else value
        there, cost = _beyond(fit, inside, k, value, limit)
        if cost > limit:
            break
        inside, root, step = there, np.sqrt(cost), GROWTH * step
        if value == bound:
            return bound, inside
    out, beyond, wanted = float(value), float(np.sqrt(cost)), float(np.sqrt(limit))
    for _ in range(NARROWINGS):
        share = float(np.clip((wanted - root) / (beyond - root), 0.3, 0.7))
        value = inside[k] + share * (out - inside[k])
        there, cost = _beyond(fit, inside, k, value, limit)
        if cost > limit:
            out, beyond = value, float(np.sqrt(cost))
        else:
            inside, root = there, np.sqrt(cost)
    return inside[k] + float((wanted - root) / (beyond - root)) * (out - inside[k]), inside


def _beyond(fit: ResponseFit, x: Array, k: int, value: float, limit: float) -> tuple[Array, float]:
    """`_adapted`; beyond the limit only if that stays so after a search for wider bounds at the points that are outside."""
    there, cost = _adapted(fit, x, k, value, limit)
    if cost > limit and fit.widened(there) and fit.cost(there) < WIDER * cost:
        there, cost = _adapted(fit, there, k, value, limit)
    return there, cost


def _adapted(fit: ResponseFit, x: Array, k: int, value: float, limit: float) -> tuple[Array, float]:
    """The variables with variable k at a value and the others adapted, by damped Gauss-Newton steps, until the sum of squares is
    below the limit or falls no further."""
    x = x.copy()
    x[k] = value
    others: Index = np.delete(np.arange(x.size), k)
    cost, damping = fit.cost(x), 1e-3
    for _ in range(ADAPTED):
        if cost <= limit or not others.size:
            break
        residuals, J = fit.residuals(x), fit.jacobian(x)[:, others]
        scale = np.maximum(np.linalg.norm(J, axis=0), 1e-12)
        stacked = np.vstack([J, np.diag(np.sqrt(damping) * scale)])
        step = np.linalg.lstsq(stacked, np.concatenate([-residuals, np.zeros(others.size)]))[0]
        trial = x.copy()
        trial[others] = np.clip(x[others] + step, fit.bounds[0][others], fit.bounds[1][others])
        there = fit.cost(trial)
        if there < cost:
            fell, x, cost, damping = cost - there, trial, there, 0.1 * damping
            if fell < 1e-3 * cost:
                break
        else:
            damping *= 30.0
    return x, cost
