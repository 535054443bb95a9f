"""A fit against the bounds over all start states: fit and search for wider bounds by turns, intervals, and their result."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stickslip.laboratory.identification.enclosed_test import Bound, EnclosedTest
from stickslip.laboratory.identification.profile_interval import profile_intervals
from stickslip.laboratory.identification.response_fit import ResponseFit
from stickslip.runs.work import Arrays
from stickslip.support.checks import Array

if TYPE_CHECKING:
    import xarray as xr

ROUNDS, GAINED = 3, 0.99
"""Fits in a row, each after a search for wider bounds, and the sum of squares over the last from which on there is no other."""

OUTSIDE = 2.0
"""Distance from the bounds, in standard errors, from which on a point counts as outside."""


def enclosed(fit: ResponseFit, x: Array, evaluations: int) -> tuple[Array, Arrays]:
    """The variables of a fit against bounds, in the middle of all that do as well, and what its result holds.

    bounds (tests, 2, points): of the response per force; ends (2, parameters): of the intervals, variables; starts (tests, 2,
    points, start variables): where the bounds are.
    """
    cost = fit.cost(x)
    for _ in range(ROUNDS):
        fit.searched(x)
        if fit.cost(x) > GAINED * cost:
            break
        x = fit.solved(x, evaluations)
        cost = fit.cost(x)
    intervals = profile_intervals(fit, x)
    middle = fit.solved(intervals.middle, evaluations)
    x = middle if fit.cost(middle) <= fit.cost(x) else x
    bounds = _padded(fit.searched(x))
    starts = _padded([_starts(model) for model in fit.tests if isinstance(model, EnclosedTest)])
    return x, {"bounds": bounds, "ends": intervals.ends, "starts": starts}


def _starts(model: EnclosedTest) -> Array:
    """Start variables of the bounds of a test, (2, points, start variables); NaN where there are none."""
    size = max((known[0].variables.size for known in model.known if known is not None), default=0)
    found = np.full((2, len(model.known), size), np.nan)
    for k, known in enumerate(model.known):
        if known is not None:
            found[:, k] = [bound.variables for bound in known]
    return found


def _padded(parts: Sequence[Array]) -> Array:
    """Arrays of several tests as one, (tests, ...), NaN behind the shorter ones."""
    found = np.full((len(parts), *np.max([part.shape for part in parts], axis=0)), np.nan)
    for one, part in zip(found, parts, strict=True):
        one[tuple(slice(size) for size in part.shape)] = part
    return found


def resumed(fit: ResponseFit, starts: Array) -> None:
    """Let the residuals start from the start states (tests, 2, points, start variables) of a finished search."""
    for model, own in zip(fit.tests, starts, strict=True):
        if isinstance(model, EnclosedTest):
            for k in range(len(model.known)):
                low, high = (values[np.isfinite(values)] for values in own[:, k])
                model.known[k] = (Bound(low), Bound(high)) if low.size else None


def with_bounds(dataset: xr.Dataset, fit: ResponseFit, found: Arrays) -> xr.Dataset:
    """The dataset with the bounds (test, point) and with the intervals of the profile; errors have no correlation there."""
    shared = [v.name for v in fit.variables if v.test < 0]
    ends = np.array([[fit.free[name].value(float(end)) for name, end in zip(shared, row, strict=True)] for row in found["ends"]])
    data = dataset.assign(correlation=dataset["correlation"] * np.nan)
    for name, end, row in (("low", "lower", ends[0]), ("high", "upper", ends[1])):
        data[name] = ("parameter", row, dataset[name].attrs)
        about = {"units": "SI", "long_name": f"{end} bound of the response per force over all start states"}
        data[end] = (("test", "point"), np.asarray(found["bounds"])[:, 0 if end == "lower" else 1], about)
    return data


def notes_on_bounds(dataset: xr.Dataset, fit: ResponseFit) -> list[str]:
    """How the intervals are to be read, what the bounds leave open, and tests that no start state explains."""
    measured, lower, upper = (dataset[name].values for name in ("measured", "lower", "upper"))
    inside = int(np.sum((measured >= lower) & (measured <= upper)))
    count = int(np.sum(np.isfinite(measured)))
    found = [
        f"{inside} of {count} points lie inside their bounds and say nothing more: each value in an interval explains the tests "
        "as well, with the others adapted, and the values above are one of them."
    ]
    for k, name in enumerate(str(one) for one in dataset["parameter"].values):
        free = fit.free[name]
        ends = zip(("low", "high"), (free.low, free.high), ("below", "above"), strict=True)
        open_ends = [(side, bound) for key, bound, side in ends if np.isclose(float(dataset[key][k]), bound, rtol=1e-6)]
        for side, bound in open_ends:
            found.append(f"{name} is not determined {side}: start states explain the tests up to its bound, {bound:.4g}.")
    for t, model in enumerate(fit.tests):
        own = dataset.isel(test=t)
        size = own["measured"].values[: model.test.deviation.size]
        apart = np.maximum(own["lower"].values[: size.size] - size, size - own["upper"].values[: size.size])
        beyond = int(np.sum(apart > OUTSIDE * model.test.deviation))
        if beyond:
            words = f"{beyond} of {size.size} points lie outside of the bounds by more than two standard errors"
            found.append(f"{model.test.name}: {words}. No start state explains them.")
    return found
