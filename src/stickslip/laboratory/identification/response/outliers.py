"""Outliers: points of measured responses far from the fit, such as those of a clipped sensor; and the fit without them.

One of them moves parameters by more than intervals hold, since these take the residuals for noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.laboratory.identification.response.fit import ResponseFit
from stickslip.laboratory.identification.response.intervals import statistics
from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.support.checks import Array, counted, rounded

OUTLIER = 5.0
"""Standard errors from which a point is an outlier: noise exceeds them once in two million."""

NORMAL = 0.6745
"""Median of the size of noise of standard deviation 1."""

KNOWN, FLAT = 1e-8, 1e-6
"""Share of the largest singular value below which a direction is unknown; least variance of a residual, relative."""

MOST = 0.1
"""Share of the points that may be outliers, one in any case: of more the model is at fault."""

GOOD, SURE = 0.1, 2.0
"""Relative error of a test without its outliers, root mean square, from which the model is at fault; where residuals go together
along the curves, so many stated errors."""

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
    whole, errors = x, _errors(fit, x, marks)
    for _ in range(ROUNDS):
        before, marks = marks, [one > OUTLIER for one in errors]
        if sum(map(np.count_nonzero, marks)) > max(MOST * sum(one.size for one in marks), 1.0):
            marks = [np.zeros_like(one) for one in marks]
        if all(map(np.array_equal, marks, before)):
            break
        x = fit.without(marks).solved(x, evaluations=evaluations).x
        errors = _errors(fit, x, marks)
    found = np.concatenate(marks) & (np.concatenate(errors) > OUTLIER)
    found &= not np.any(found) or _good(fit, x, marks)
    x = x if np.any(found) else whole
    # Distance of the measured from the computed response per force, relative to the latter, below 0 where it is smaller.
    fit.residuals(x)
    deviations = []
    for t, model in enumerate(fit.tests):
        measured, shown = model.test.per_force, fit.shown(x, t)
        size = np.maximum(np.abs(shown), 1e-300)
        away = np.abs(measured - (shown if model.test.phase is not None else size)) / size
        deviations.append(np.where(np.abs(measured) < size, -away, away))
    return Outliers(np.where(found, np.concatenate(errors), 0.0), np.where(found, np.concatenate(deviations), 0.0), x)


def _good(fit: ResponseFit, x: Array, marks: Sequence[Marks]) -> bool:
    """Whether the fit explains the points that are not marked; what a bound or a wrong law misses is no outlier."""
    parts = zip(fit.parted(fit.residuals(x)), marks, strict=True)
    sizes = np.array([float(np.sqrt(np.mean(residuals[:, ~mark] ** 2))) if np.any(~mark) else 0.0 for residuals, mark in parts])
    errors = sizes * np.array([model.test.error for model in fit.tests])
    if float(errors.max()) > GOOD:
        return False
    return float(np.median(sizes)) < SURE or statistics(fit.without(marks), x).one_in == 1.0


def _errors(fit: ResponseFit, x: Array, marks: Sequence[Marks]) -> list[Array]:
    """By how many standard errors the points of each test miss the fit to the others: by the stated errors, or those of the usual
    residuals of the test or of all where these are larger. 0 of points without a solution. Marked points are those that the fit
    at x does not know.

    With the covariance H of its computed rows, the residual r of a point has the covariance 1 − H in the fit, and 1 + H where the
    fit does not know it. Usual residuals are those by their median, which few outliers do not move, or those that are left
    without the point, r (1 − H)⁻¹ r less, if these are smaller: one alone at a resonance bends the fit to itself.
    """
    residuals, J = fit.residuals(x), fit.jacobian(x)
    priors = np.ones(sum(variable.deviation is not None for variable in fit.variables), dtype=bool)
    kept = np.concatenate([*(np.tile(~mark, rows) for mark, rows in zip(marks, fit.rows, strict=True)), priors])
    J = J / np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    _, values, directions = np.linalg.svd(J[kept], full_matrices=False)
    known = values > KNOWN * np.max(values, initial=1e-300)
    ways = J @ directions[known].T / values[known]
    blind = np.sum(J**2, axis=1) - np.sum((J @ directions[known].T) ** 2, axis=1) > KNOWN
    count, lost = int(np.count_nonzero(kept)), int(np.count_nonzero(known))
    square, usual = float(np.sum(residuals[kept] ** 2)), _usual(residuals[: residuals.size - priors.size])
    found = []
    by_test = (fit.parted(residuals), fit.parted(ways), fit.parted(blind), fit.computed, marks)
    for parts, way, lost_ones, computed, mark in zip(*by_test, strict=True):
        miss = _misses(parts, np.moveaxis(way, 0, 1), mark)
        gone, share = np.where(mark, 0.0, miss), parts[:, ~mark].size / max(count, 1)
        left = [
            np.sqrt(np.maximum(whole - gone, 0.0) / max(freedom - len(parts), 1.0))
            for whole, freedom in ((square, count - lost), (float(np.sum(parts[:, ~mark] ** 2)), share * (count - lost)))
        ]
        scale = np.maximum(1.0, np.maximum(np.minimum(usual, left[0]), np.minimum(_usual(parts), left[1])))
        unknown = mark & np.any(lost_ones, axis=0)
        found.append(np.where(computed.solved & ~unknown, np.sqrt(miss) / scale, 0.0))
    return found


def _misses(parts: Array, ways: Array, mark: Marks) -> Array:
    """r (1 ∓ H)⁻¹ r of each point (points,), from its residuals (rows, points): what the sum of squares loses with it."""
    signs = np.where(mark, 1.0, -1.0)[:, None, None]
    values, directions = np.linalg.eigh(np.eye(len(parts)) + signs * ways @ np.moveaxis(ways, 1, 2))
    along = np.einsum("pki,kp->pi", directions, parts)
    return np.asarray(np.sum(along**2 / np.maximum(values, FLAT), axis=1))


def _usual(residuals: Array) -> float:
    """Standard deviation of residuals by their median size, which a few outliers do not move."""
    return float(np.median(np.abs(residuals))) / NORMAL


def notes_on_outliers(tests: Sequence[MeasuredResponse], errors: Sequence[Array], deviations: Sequence[Array]) -> list[str]:
    """The outliers of each test."""
    found = []
    for test, error, share in zip(tests, errors, deviations, strict=True):
        at = np.argsort(-error, kind="stable")[: np.count_nonzero(error)]
        if not at.size:
            continue
        places = [
            f"{np.asarray(test.frequency)[k]:.5g} Hz by {rounded(100.0 * abs(share[k]), 2)} %, {error[k]:.0f} standard errors"
            for k in at
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
