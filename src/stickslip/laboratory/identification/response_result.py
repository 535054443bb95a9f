"""What an identification of frequency responses gives: the labelled dataset, and what the tests cannot say in sentences."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.laboratory.identification.enclosed_test import EnclosedTest
from stickslip.laboratory.identification.model_error import FEWEST_TESTS, above_noise
from stickslip.laboratory.identification.outliers import moved, notes_on_outliers
from stickslip.laboratory.identification.response_fit import GAIN, FitStatistics, ResponseFit
from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.support.checks import Array, first_of, rounded

if TYPE_CHECKING:
    import xarray as xr

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


def misfit(fit: ResponseFit, x: Array, t: int) -> float:
    """Root mean square of computed − measured response per force, relative to the largest measured one."""
    fit.residuals(x)
    shown, measured = fit.shown(x, t), fit.tests[t].test.per_force
    apart = shown - measured if fit.tests[t].test.phase is not None else np.abs(shown) - measured
    return float(np.sqrt(np.mean(np.abs(apart) ** 2)) / np.abs(measured).max())


def _described(dims: Any, values: Any, units: str, words: str) -> tuple[Any, Any, dict[str, str]]:
    return dims, values, {"units": units, "long_name": words}


def dataset_of_fit(
    fit: ResponseFit, x: Array, statistics: FitStatistics, held_out: Array, solution: Mapping[str, Any]
) -> xr.Dataset:
    """The labelled result; solution: what the fit gave beside x, with outliers and the variables without them."""
    import xarray as xr

    variables, tests = fit.variables, [model.test for model in fit.tests]
    shared = [k for k, variable in enumerate(variables) if variable.test < 0]
    names = [variables[k].name for k in shared]
    reach = statistics.quantile * statistics.error
    ends = [np.clip(x + side * reach, *fit.bounds) for side in (-1.0, 1.0)]
    low, high = ([fit.free[n].value(float(end[k])) for n, k in zip(names, shared, strict=True)] for end in ends)
    values = [fit.free[n].value(float(x[k])) for n, k in zip(names, shared, strict=True)]
    longest = max(np.size(test.frequency) for test in tests)

    def along(of: Callable[[int], Any], fill: float = np.nan) -> Array:
        rows = [np.asarray(of(t), dtype=float) for t in range(len(tests))]
        return np.array([np.pad(row, (0, longest - row.size), constant_values=fill) for row in rows])

    shown = [fit.shown(x, t) for t in range(len(tests))]
    own_names, own = _own_values(fit, x)
    correlation = statistics.correlation[np.ix_(shared, shared)]
    at = ("test", "point")
    data = {
        "value": _described("parameter", values, "as given", "identified value"),
        "low": _described("parameter", low, "as given", "lower end of the 95 % interval, not below the bound"),
        "high": _described("parameter", high, "as given", "upper end of the 95 % interval, not above the bound"),
        "least": _described("parameter", _least(fit, solution, names), "as given", "lower bound of friction that never slips"),
        "correlation": _described(("parameter", "parameter_2"), correlation, "1", "correlation of the errors"),
        "own_value": _described(("test", "own"), own, "as given", "what each test has by itself"),
        "frequency": _described(at, along(lambda t: tests[t].frequency), "Hz", "frequency"),
        "force": _described(at, along(lambda t: tests[t].force), "1", "measured force level"),
        "response": _described(at, along(lambda t: tests[t].amplitude), "SI", "measured amplitude"),
        "measured": _described(at, along(lambda t: np.abs(tests[t].per_force)), "SI", "measured response per force"),
        "computed": _described(at, along(lambda t: np.abs(shown[t])), "SI", "computed response per force"),
        "measured_phase": _described(at, along(lambda t: _phase(tests[t])), "degree", "measured phase of the displacement"),
        "computed_phase": _described(
            at, along(lambda t: np.degrees(np.angle(shown[t]))), "degree", "computed phase of the displacement"
        ),
        "solved": _described(at, along(lambda t: fit.found(t).solved, 0.0), "1", "1 where the problem has a solution"),
        "slips": _described(at, along(lambda t: fit.found(t).slips, 0.0), "1", "1 where a contact slips or opens"),
        "misfit": _described(
            "test", [misfit(fit, x, t) for t in range(len(tests))], "1", "misfit relative to the largest response"
        ),
        "held_out": _described("test", held_out, "1", "misfit with the parameters of the other tests"),
    }
    if "outlier" in solution:
        ends_of = np.cumsum([np.size(test.frequency) for test in tests])[:-1]
        errors, deviations = (np.split(np.asarray(solution[key]), ends_of) for key in ("outlier", "outlier_deviation"))
        without = np.asarray(solution["x_without"])
        other = [fit.free[n].value(float(without[k])) for n, k in zip(names, shared, strict=True)]
        data["outlier"] = _described(
            at, along(lambda t: errors[t], 0.0), "1", "residual of an outlier in standard errors, else 0"
        )
        data["outlier_deviation"] = _described(at, along(lambda t: deviations[t], 0.0), "1", "of an outlier, relative to the fit")
        data["value_without_outliers"] = _described("parameter", other, "as given", "value without the outliers")
    widest = max(fit.starts(x, t).size for t in range(len(tests)))
    if widest:
        rows = [np.pad(s, (0, widest - s.size), constant_values=np.nan) for s in (fit.starts(x, t) for t in range(len(tests)))]
        data["start_variables"] = _described(("test", "variable"), np.array(rows), "1", "start state of each test")
    coords = {
        "parameter": _described("parameter", names, "1", "parameter"),
        "parameter_2": _described("parameter_2", names, "1", "parameter"),
        "test": _described("test", [test.name for test in tests], "1", "test"),
        "own": _described("own", own_names, "1", "what each test has by itself"),
        "quantity": _described("test", [test.quantity for test in tests], "1", "measured quantity"),
    }
    return xr.Dataset(data, coords, {"title": "Parameters from frequency responses", "noise": float(np.sqrt(statistics.noise))})


def _least(fit: ResponseFit, solution: Mapping[str, Any], names: Sequence[str]) -> list[float]:
    """Lower bounds of the parameters; NaN of those that are known otherwise, or not at all."""
    bounds = np.asarray(solution.get("least", np.full(len(names), np.nan)))
    return [fit.free[name].value(float(end)) if np.isfinite(end) else np.nan for name, end in zip(names, bounds, strict=True)]


def _phase(test: MeasuredResponse) -> Array:
    if test.phase is None:
        return np.full(np.size(test.frequency), np.nan)
    return np.asarray(np.degrees(np.asarray(test.phase)))


def _own_values(fit: ResponseFit, x: Array) -> tuple[list[str], Array]:
    """What each test has by itself, by name: parameters, gain (a factor) and phase offset (rad)."""
    names = list(dict.fromkeys(v.name for v in fit.variables if v.test >= 0 and v.name != "start"))
    table = np.full((len(fit.tests), len(names)), np.nan)
    for k, variable in enumerate(fit.variables):
        if variable.name in names and variable.test >= 0:
            value = float(x[k])
            if variable.name in fit.free:
                value = fit.free[variable.name].value(value)
            elif variable.name == GAIN:
                value = float(np.exp(value))
            table[variable.test, names.index(variable.name)] = value
    return names, table


def notes_of_fit(
    fit: ResponseFit, x: Array, statistics: FitStatistics, dataset: xr.Dataset, known_mistake: bool = False
) -> list[str]:
    """What the tests cannot say, in sentences; known_mistake: one in the tests is named, and all else may be its consequence."""
    if known_mistake:
        repeated = _repeated([model.test for model in fit.tests])
        return ["Values and intervals mean nothing before the mistake above is mended.", *repeated]
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
        if statistics.blind[k] or not np.isfinite(high) or high - low > known_within:
            found.append(f"{name} is not found: its 95 % interval is {low:.3g} to {high:.3g}.")
    found += _at_bounds(fit, x)
    for i in range(len(names)):
        for j in range(i):
            r = float(dataset["correlation"].values[i, j])
            if abs(r) > CORRELATED:
                found.append(f"{names[j]} and {names[i]} can hardly be separated by these tests: correlation {r:.3f}.")
    found += _doubtful_gains(dataset)
    found += _repeated([model.test for model in fit.tests])
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
    suspects = f"quantity, units, contact law, the number of harmonics{_about_phase(fit)}"
    words = f"The model does not explain the tests: {sizes}. Check {suspects}"
    if "lower" in dataset or min(one.size for one in series) < FEWEST_POINTS:
        return [f"{words}; the intervals mean little."] if large else []
    if statistics.one_in == 1.0:
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


def _about_phase(fit: ResponseFit) -> str:
    """What to check of phases, where there are any."""
    known = any(model.test.phase is not None for model in fit.tests)
    return " and the phase (of the displacement, not of the acceleration, which is 180° from it)" if known else ""


def _repeated(tests: Sequence[MeasuredResponse]) -> list[str]:
    """Tests that hold the same points, such as a file that was named twice."""
    keys = ("frequency", "amplitude", "force", "phase")
    content = [b"".join(np.asarray(getattr(test, key), dtype=float).tobytes() for key in keys) for test in tests]
    firsts = [content.index(one) for one in content]
    words = "hold the same points, which count twice: the intervals are too narrow."
    return [f"{tests[first].name} and {tests[t].name} {words}" for t, first in enumerate(firsts) if first < t]
