"""Lower bounds of friction where no contact slips: below them one would, and the responses would show it."""

from __future__ import annotations

import numpy as np

from stickslip.analyses.identification.profile_interval import LIMIT
from stickslip.analyses.identification.response_fit import ResponseFit
from stickslip.checks import Array

HALVINGS = 10
"""Of the distance between the value found and its bound, or of their logarithms."""


def least_friction(fit: ResponseFit, x: Array) -> Array:
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
