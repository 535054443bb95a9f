"""Outliers: points of measured responses far from the fit, such as those of a clipped sensor; and the fit without them.

One of them moves parameters by more than intervals hold, since these take the residuals for noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.identification.response_fit import ResponseFit
from stickslip.checks import Array, counted
from stickslip.measurement.measured_response import MeasuredResponse

OUTLIER = 5.0
"""Standard errors from which a point is an outlier: noise exceeds them once in two million."""

NORMAL = 0.6745
"""Median of the size of noise of standard deviation 1."""

MOST = 0.1
"""Share of the points that may be outliers: of more the model is at fault."""

ROUNDS = 5
"""Fits without outliers, at most: each may show others."""

LISTED = 3
"""Points that a sentence names."""

Marks = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Outliers:
    """Of all points in turn: errors: residuals of outliers in standard errors, 0 of the other points; deviation: relative to the
    computed response per force, below 0 where the measured one is smaller; x: the variables without the outliers."""

    errors: Array
    deviation: Array
    x: Array


def fitted_without(fit: ResponseFit, x: Array, evaluations: int) -> Outliers:
    """The outliers of a fit, which are those of the fit without them."""
    marks = [np.zeros(np.size(model.test.frequency), dtype=bool) for model in fit.tests]
    errors = _errors(fit, x, marks)
    for _ in range(ROUNDS):
        before, marks = marks, [one > OUTLIER for one in errors]
        if sum(map(np.count_nonzero, marks)) > MOST * sum(one.size for one in marks):
            marks = [np.zeros_like(one) for one in marks]
        if all(map(np.array_equal, marks, before)):
            break
        x = fit.without(marks).solved(x, evaluations)
        errors = _errors(fit, x, marks)
    found = np.concatenate(marks)
    return Outliers(np.where(found, np.concatenate(errors), 0.0), np.where(found, _deviation(fit, x), 0.0), x)


def _errors(fit: ResponseFit, x: Array, marks: Sequence[Marks]) -> list[Array]:
    """By how many standard errors the points of each test miss the fit, marked ones one that does not know them: by the stated
    errors, or those of the usual residuals of the test or of all where these are larger. 0 of points without a solution.

    The residual of a point in the fit has the variance 1 − h, h its leverage: one alone at a resonance draws the
    damping to itself.
    """
    residuals, J = fit.residuals(x), fit.jacobian(x)
    kept = np.concatenate([*(np.tile(~mark, rows) for mark, rows in zip(marks, fit.rows, strict=True)), _priors(fit)])
    Q = np.linalg.svd(J[kept] / np.maximum(np.linalg.norm(J[kept], axis=0), 1e-300), full_matrices=False)[0]
    leverage = np.zeros(residuals.size)
    leverage[kept] = np.sum(Q**2, axis=1)
    parts = fit.parted(residuals / np.sqrt(np.maximum(1.0 - leverage, 1.0 / residuals.size)))
    usual = _usual(np.concatenate([part.ravel() for part in parts]))
    solved = [np.asarray(fit.found(t).solved, dtype=float) for t in range(len(parts))]
    return [
        one * np.sqrt(np.sum(part**2, axis=0)) / max(1.0, usual, _usual(part)) for one, part in zip(solved, parts, strict=True)
    ]


def _priors(fit: ResponseFit) -> Marks:
    return np.ones(sum(variable.deviation is not None for variable in fit.variables), dtype=bool)


def _usual(residuals: Array) -> float:
    """Standard deviation of residuals by their median size, which a few outliers do not move."""
    return float(np.median(np.abs(residuals))) / NORMAL


def _deviation(fit: ResponseFit, x: Array) -> Array:
    """Distance of the measured from the computed response per force, relative to the latter, below 0 where it is smaller."""
    fit.residuals(x)
    found = []
    for t, model in enumerate(fit.tests):
        measured, shown = model.test.per_force, fit.shown(x, t)
        size = np.maximum(np.abs(shown), 1e-300)
        away = np.abs(measured - (shown if model.test.phase is not None else size)) / size
        found.append(np.where(np.abs(measured) < size, -away, away))
    return np.concatenate(found)


def notes_on_outliers(tests: Sequence[MeasuredResponse], errors: Sequence[Array], deviations: Sequence[Array]) -> list[str]:
    """The outliers of each test."""
    found = []
    for test, error, share in zip(tests, errors, deviations, strict=True):
        at = np.argsort(-error, kind="stable")[: np.count_nonzero(error)]
        if not at.size:
            continue
        places = [
            f"{np.asarray(test.frequency)[k]:.5g} Hz by {100.0 * abs(share[k]):.2g} %, {error[k]:.0f} standard errors" for k in at
        ]
        listed = "; ".join(places[:LISTED]) + (f"; and {at.size - LISTED} more" if at.size > LISTED else "")
        why = "Is the sensor clipped there?" if np.all(share[at] < 0.0) else "Are these rows right?"
        verb = "misses" if at.size == 1 else "miss"
        found.append(f"{counted(at.size, 'point')} of {test.name} {verb} the fit to the others: at {listed}. {why}")
    return found


def moved(names: Sequence[str], values: Array, ends: tuple[Array, Array], without: Array) -> str:
    """How far the parameters move without the outliers; ends: of their 95 % intervals."""
    words = []
    for name, value, low, high, other in zip(names, values, *ends, without, strict=True):
        change = f"{100.0 * (other - value) / abs(value):+.2g} %" if value else f"{other - value:+.2g}"
        words.append(f"{name} {other:.5g} ({change}{'' if low <= other <= high else ', outside the interval'})")
    return f"Without such points: {', '.join(words)}. Leave these points out if they are wrong."
