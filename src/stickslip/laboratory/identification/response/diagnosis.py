"""What responses cannot say of the parameters, and what seems wrong with them or with the model, in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stickslip.laboratory.identification.response.enclosed import EnclosedTest
from stickslip.laboratory.identification.response.fit import GAIN, ResponseFit
from stickslip.laboratory.identification.response.intervals import FEWEST_TESTS, TOGETHER, FitStatistics, above_noise
from stickslip.laboratory.identification.response.mistakes import moved, notes_on_mistakes, notes_on_outliers
from stickslip.laboratory.measurement.measured_response import MeasuredResponse, assumed_units, flat_top, joined, mixed_units
from stickslip.support.checks import Array, first_of, rounded
from stickslip.support.late import xr

UNCERTAIN = 0.5
"""Half width of an interval, relative to the value, from which on a parameter counts as not found; of one that is searched
linearly the width, relative to that of its bounds."""

CORRELATED = 0.95
"""Correlation from which on two parameters are named as one."""

FEWEST_POINTS = 10
"""Points of a curve from which its residuals show whether they go together."""

SEEN = 0.5
"""Residuals in stated errors from which it is said that they go together."""

AT_BOUND = 1e-4
"""Distance from a bound, relative to that of both bounds, from which on a parameter has not ended there."""

GAINS = (0.5, 2.0)
"""Gains of a measuring chain outside which one is doubted."""

LISTED = 4
"""Tests that a sentence names."""

UNEXPLAINED = 2.0
"""A misfit this many times the median one, and the stated error, is named."""

OUTSIDE = 2.0
"""Distance from the bounds, in standard errors, from which on a point counts as outside."""

SUSPICION = (
    "This is a suspicion: a model with a wrong mass or stiffness looks the same. The values and intervals that follow mean "
    "nothing before the cause is found."
)


def notes(
    tests: Sequence[MeasuredResponse],
    solved: tuple[ResponseFit, Array, FitStatistics],
    dataset: xr.Dataset,
    solution: Mapping[str, Any],
    remarks: Sequence[str],
) -> tuple[str, ...]:
    """What must be known of the result. Where a mistake in the tests is suspected, all else may be its consequence."""
    mistakes = notes_on_mistakes(tests, dataset["misfit"].values, solution) if "plain_gain" in solution else []
    about = [(test.name, note) for test in tests for note in (*test.notes, *([] if mistakes else flat_top(test)))]
    suspected = [*mistakes, SUSPICION] if mistakes else []
    found = [*suspected, *assumed_units(tests), *(() if mistakes else mixed_units(tests)), *joined(about), *remarks]
    if "bounds" in solution:
        found += notes_on_bounds(dataset, solved[0])
    if mistakes:
        return (*found, *_repeated(solved[0]))
    return (*found, *notes_of_fit(*solved, dataset))


def notes_of_fit(fit: ResponseFit, x: Array, statistics: FitStatistics, dataset: xr.Dataset) -> list[str]:
    """What the tests cannot say, how well they are explained, and whether the fit has ended."""
    names = [str(name) for name in dataset["parameter"].values]
    found = []
    contacts = [contact for t, model in enumerate(fit.tests) for contact in model.problem(fit.values(x, t)).contacts]
    if not np.any(dataset["slips"].values) and any(contact.law.rubs for contact in contacts):
        known = np.isfinite(dataset["least"].values).any()
        words = "no more of friction than that it holds" if known else "nothing of friction coefficients"
        found.append(f"No contact slips or opens at any point: the responses say {words}.")
    elif not np.any(dataset["slips"].values) and any(contact.normal is not None for contact in contacts):
        found.append("No contact opens or closes at any point: the responses say nothing of gaps.")
    for k, name in enumerate(names):
        value, low, high = (float(dataset[key].values[k]) for key in ("value", "low", "high"))
        if np.isfinite(dataset["least"].values[k]):
            continue
        free = fit.free[name]  # a value near zero between bounds on both sides of it may be well known
        known_within = 2.0 * UNCERTAIN * abs(value) if free.logarithmic else UNCERTAIN * (free.high - free.low)
        if (statistics.blind[k] and "lower" not in dataset) or not np.isfinite(high) or high - low > known_within:
            found.append(f"{name} is not found: its 95 % interval is {low:.3g} to {high:.3g}.")
    found += _at_bounds(fit, x)
    for i in range(len(names)):
        for j in range(i):
            r = float(dataset["correlation"].values[i, j])
            if abs(r) > CORRELATED:
                found.append(f"{names[j]} and {names[i]} can hardly be separated by these tests: correlation {r:.3f}.")
    found += _doubtful_gains(dataset)
    found += _repeated(fit)
    apart = dataset["misfit"].values
    stated = np.array([model.test.error for model in fit.tests])
    for t in np.flatnonzero((apart > UNEXPLAINED * np.median(apart)) & (apart > UNEXPLAINED * stated)):
        how = "by any start state" if {"start_variables", "lower"} & {*dataset} else "by these parameters"
        sizes = f"misfit {rounded(100.0 * apart[t], 2)} % against {rounded(100.0 * float(np.median(apart)), 2)} % in the median"
        found.append(f"{dataset['test'].values[t]} is not explained {how}: {sizes}.")
    found += _about_outliers(fit, dataset)
    found += _about_misfit(fit, x, statistics, dataset)
    if fit.unfinished(x):
        found.append("The fit stopped before it converged: raise `evaluations`. The intervals mean little.")
    lost = int(np.sum(np.isfinite(dataset["frequency"].values)) - np.sum(dataset["solved"].values))
    if lost:
        found.append(f"{lost} points have no solution at the identified parameters; they count as wrong by their whole size.")
    return found


def _at_bounds(fit: ResponseFit, x: Array) -> list[str]:
    """The parameters, also those of single tests, that end at one of their bounds."""
    found, (low, high) = [], fit.bounds
    for k, variable in enumerate(fit.variables):
        if variable.name in fit.free:
            free = fit.free[variable.name]
            where = "" if variable.test < 0 else f" of {fit.tests[variable.test].test.name}"
            for side, end, value in (("lower", low[k], free.low), ("upper", high[k], free.high)):
                if abs(x[k] - end) < AT_BOUND * (high[k] - low[k]):
                    words = f"{variable.name}{where} ends at its {side} bound, {value:.4g}"
                    found.append(f"{words}: widen it, or the model lacks something.")
    return found


def _about_outliers(fit: ResponseFit, dataset: xr.Dataset) -> list[str]:
    """The outliers, and how far the parameters move without them."""
    if "outlier" not in dataset or not np.any(dataset["outlier"].values):
        return []
    tests, errors, deviations = [model.test for model in fit.tests], dataset["outlier"], dataset["outlier_deviation"]
    found = notes_on_outliers(tests, list(errors.values), list(deviations.values))
    known = dataset.isel(parameter=np.isnan(dataset["least"].values))
    if isinstance(fit.tests[0], EnclosedTest):  # the value is one of many
        return found
    names, ends = [str(name) for name in known["parameter"].values], (known["low"].values, known["high"].values)
    return [*found, moved(names, known["value"].values, ends, known["value_without_outliers"].values)]


def _doubtful_gains(dataset: xr.Dataset) -> list[str]:
    """A sentence where the free gain of a test is far from 1."""
    if GAIN not in dataset["own"].values:
        return []
    gains = dataset["own_value"].sel(own=GAIN).values
    found = [
        f"{gain:.4g} of {test}"
        for test, gain in zip(dataset["test"].values, gains, strict=True)
        if np.isfinite(gain) and not GAINS[0] <= gain <= GAINS[1]
    ]
    words = "The measured response is so many times what the model computes: check units, and calibration of the sensors."
    return [f"The gain is {first_of(found, LISTED)}. {words}"] if found else []


def _about_misfit(fit: ResponseFit, x: Array, statistics: FitStatistics, dataset: xr.Dataset) -> list[str]:
    """How the residuals compare with the stated errors, and what the intervals hold of them."""
    apart, stated = float(np.median(dataset["misfit"].values)), float(np.median([model.test.error for model in fit.tests]))
    large, series = apart > UNEXPLAINED * stated, fit.series(x)
    sizes = f"misfit {rounded(100.0 * apart, 2)} % in the median, stated errors {rounded(100.0 * stated, 2)} %"
    suspects = "quantity, units, mass and stiffness of the model, contact law, the number of harmonics"
    if any(model.test.phase is not None for model in fit.tests):
        suspects += " and the phase (of the displacement, not of the acceleration, which is 180° from it)"
    words = f"The model does not explain the tests: {sizes}. Check {suspects}"
    if "lower" in dataset or min(one.size for one in series) < FEWEST_POINTS:
        return [f"{words}; the intervals mean little."] if large else []
    if statistics.one_in < TOGETHER:
        noise = "From point to point the residuals are independent, as noise is: the intervals hold that."
        if "outlier" in dataset and np.any(dataset["outlier"].values):
            noise = "Outliers are part of it."
        return [f"The tests scatter more than stated: {sizes}. {noise}"] if large else []
    if not large and np.sqrt(statistics.noise) < SEEN:
        return []
    together = f"Residuals go together over {statistics.one_in:.0f} points, at {above_noise(series):.2g} times their noise"
    held = "The intervals are widened for that"
    if len(fit.tests) >= FEWEST_TESTS:
        held += ", by how the tests disagree; an error that all tests share, such as a wrong contact law, they do not hold."
    else:
        held += ", but hold only if the model is right."
    return [f"{words}. {together}. {held}" if large else f"{together}: the model lacks something. {held}"]


def _repeated(fit: ResponseFit) -> list[str]:
    """Tests that hold the same points, such as a file that was named twice."""
    tests = [model.test for model in fit.tests]
    keys = ("frequency", "amplitude", "force", "phase")
    content = [b"".join(np.asarray(getattr(test, key), dtype=float).tobytes() for key in keys) for test in tests]
    firsts = [content.index(one) for one in content]
    words = "hold the same points, which count twice: the intervals are too narrow."
    return [f"{tests[first].name} and {tests[t].name} {words}" for t, first in enumerate(firsts) if first < t]


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
