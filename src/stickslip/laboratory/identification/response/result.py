"""What parameters from frequency responses are given as: the result, its dataset, and the answer in sentences.

What responses cannot say of the parameters, and what seems wrong with them or with the model, in sentences.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stickslip.laboratory.identification.response.decay_prediction import DecayPrediction, predict_decay
from stickslip.laboratory.identification.response.draws import FIT, OTHER, free_as_text, kept_for_draws
from stickslip.laboratory.identification.response.fit import GAIN, PHASE, ResponseFit
from stickslip.laboratory.identification.response.intervals import FEWEST_TESTS, TOGETHER, FitStatistics, above_noise
from stickslip.laboratory.identification.response.mistakes import moved, notes_on_mistakes, notes_on_outliers
from stickslip.laboratory.identification.response.prediction import predict_response
from stickslip.laboratory.identification.response.prediction_result import ResponsePrediction
from stickslip.laboratory.measurement.measured_response import MeasuredResponse, assumed_units, flat_top, joined
from stickslip.model.problem import Problem
from stickslip.results.files import SavedResult
from stickslip.results.schema import Row, stacked, tabulated
from stickslip.support.checks import Array, counted, digits_between, first_of, rounded
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
"""Tests that a sentence names, and up to which what each has by itself is listed; of more their range is shown."""

UNEXPLAINED = 2.0
"""A misfit this many times the median one, and the stated error, is named."""

SUSPICION = (
    "This is a suspicion: a model with a wrong mass or stiffness looks the same. Do not use the values and "
    "intervals that follow before the cause is found."
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
    found = [*suspected, *assumed_units(tests), *joined(about), *remarks]
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
        words = "only lower bounds of the friction coefficients" if known else "no friction coefficient"
        found.append(f"No contact slips or opens at any point, so these tests give {words}.")
    elif not np.any(dataset["slips"].values) and any(contact.normal is not None for contact in contacts):
        found.append("No contact opens or closes at any point, so these tests do not determine gaps.")
    for k, name in enumerate(names):
        value, low, high = (float(dataset[key].values[k]) for key in ("value", "low", "high"))
        if np.isfinite(dataset["least"].values[k]):
            continue
        free = fit.free[name]  # a value near zero between bounds on both sides of it may be well known
        known_within = 2.0 * UNCERTAIN * abs(value) if free.logarithmic else UNCERTAIN * (free.high - free.low)
        if statistics.blind[k] or not np.isfinite(high) or high - low > known_within:
            found.append(f"{name} is not determined: its 95 % interval is {low:.3g} to {high:.3g}.")
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
        how = "by any start state" if "start_variables" in dataset else "by these parameters"
        sizes = f"misfit {rounded(100.0 * apart[t], 2)} % against {rounded(100.0 * float(np.median(apart)), 2)} % in the median"
        found.append(f"{dataset['test'].values[t]} is not explained {how}: {sizes}.")
    found += _about_outliers(fit, dataset)
    found += _about_misfit(fit, x, statistics, dataset)
    if fit.unfinished(x):
        found.append("The fit stopped before it converged: raise `evaluations`. The intervals are too narrow.")
    lost = int(np.sum(np.isfinite(dataset["frequency"].values)) - np.sum(dataset["solved"].values))
    if lost:
        found.append(f"{lost} points could not be computed with the identified parameters; they count as errors of 100 %.")
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
                    found.append(f"{words}. Widen the bound; if it stays there, the model is probably incomplete.")
    return found


def _about_outliers(fit: ResponseFit, dataset: xr.Dataset) -> list[str]:
    """The outliers, and how far the parameters move without them."""
    if "outlier" not in dataset or not np.any(dataset["outlier"].values):
        return []
    tests, errors, deviations = [model.test for model in fit.tests], dataset["outlier"], dataset["outlier_deviation"]
    found = notes_on_outliers(tests, list(errors.values), list(deviations.values))
    known = dataset.isel(parameter=np.isnan(dataset["least"].values))
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
    words = "It is the ratio of measured to computed response: check the units, and the calibration of the sensors."
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
    if min(one.size for one in series) < FEWEST_POINTS:
        return [f"{words}. The intervals are not reliable."] if large else []
    if statistics.one_in < TOGETHER:
        noise = "The residuals are independent from point to point, like noise, and the intervals include this."
        if "outlier" in dataset and np.any(dataset["outlier"].values):
            noise = "Outliers are part of it."
        return [f"The tests scatter more than stated: {sizes}. {noise}"] if large else []
    if not large and np.sqrt(statistics.noise) < SEEN:
        return []
    times = f"{above_noise(series):.2g} times their noise"
    together = f"Residuals of about {statistics.one_in:.0f} neighbouring points are correlated, at {times}"
    held = "The intervals are widened accordingly"
    if len(fit.tests) >= FEWEST_TESTS:
        held += ", by how the tests disagree; they do not include an error common to all tests, such as a wrong contact law."
    else:
        held += ", but are valid only if the model is right."
    return [f"{words}. {together}. {held}" if large else f"{together}: the model is incomplete. {held}"]


def _repeated(fit: ResponseFit) -> list[str]:
    """Tests that hold the same points, such as a file that was named twice."""
    tests = [model.test for model in fit.tests]
    keys = ("frequency", "amplitude", "force", "phase")
    content = [b"".join(np.asarray(getattr(test, key), dtype=float).tobytes() for key in keys) for test in tests]
    firsts = [content.index(one) for one in content]
    words = "contain the same points, which count twice: the intervals are too narrow."
    return [f"{tests[first].name} and {tests[t].name} {words}" for t, first in enumerate(firsts) if first < t]


@dataclass(frozen=True, eq=False, repr=False)
class ResponseIdentification(SavedResult):
    """`dataset`: value, low, high (parameter) of the 95 % intervals and their correlation; own_value (test, own) of what each
    test has by itself; along the tests (test, point) frequency, measured and computed response per force, and phase; misfit
    (test), the root mean square of computed − measured relative to the largest measured; held_out (test), the same with the
    parameters of the other tests; start_variables. `notes`: what the tests cannot say.
    """

    dataset: xr.Dataset
    problem_of: Callable[..., Problem]
    notes: tuple[str, ...]

    @property
    def values(self) -> dict[str, float]:
        """The parameters that all tests have in common."""
        return {
            str(name): float(v) for name, v in zip(self.dataset["parameter"].values, self.dataset["value"].values, strict=True)
        }

    def problem(self, **others: Any) -> Problem:
        """The problem with the identified parameters, for predictions; others: what each test has by itself, settings."""
        return self.problem_of(**{**self.values, **others})

    def predict(self, force: Any = (), **settings: Any) -> ResponsePrediction:
        """Responses that were not measured, with 95 % intervals: at force levels, N, or at held amplitudes (`amplitude`); further
        arguments are those of `predict_response`."""
        return predict_response(self, force, **settings)

    def predict_decay(self, amplitude: tuple[float, float], **settings: Any) -> DecayPrediction:
        """Frequency and damping of a free decay between two amplitudes of the displacement, m, with 95 % intervals; further
        arguments are those of `predict_decay`."""
        return predict_decay(self, amplitude, **settings)


def dataset_of_fit(
    fit: ResponseFit, x: Array, statistics: FitStatistics, held_out: Array, solution: Mapping[str, Any]
) -> xr.Dataset:
    """The labelled result; solution: what the fit gave beside x, outliers and the variables without them, lower bounds of
    friction."""
    tests = [model.test for model in fit.tests]
    names = [fit.variables[k].name for k in fit.shared]
    reach = statistics.quantile * statistics.error
    low, high = [np.clip(x + side * reach, *fit.bounds)[fit.shared] for side in (-1.0, 1.0)]
    shown = [fit.shown(x, t) for t in range(len(tests))]
    nowhere = [np.full(np.size(test.frequency), np.nan) for test in tests]
    phases = [none if test.phase is None else np.degrees(test.phase) for test, none in zip(tests, nowhere, strict=True)]
    own_names, own = _own_values(fit, x)

    def of_parameters(variables: Any) -> list[float]:
        return [fit.free[name].value(float(v)) if np.isfinite(v) else np.nan for name, v in zip(names, variables, strict=True)]

    data = {
        "value": of_parameters(x[fit.shared]),
        "low": of_parameters(low),
        "high": of_parameters(high),
        "least": of_parameters(solution.get("least", np.full(len(names), np.nan))),
        "correlation": statistics.correlation[np.ix_(fit.shared, fit.shared)],
        "own_value": own,
        "frequency": stacked([test.frequency for test in tests]),
        "force": stacked([test.force for test in tests]),
        "response": stacked([test.amplitude for test in tests]),
        "measured": stacked([np.abs(test.per_force) for test in tests]),
        "computed": stacked([np.abs(s) for s in shown]),
        "measured_phase": stacked(phases),
        "computed_phase": stacked([np.degrees(np.angle(s)) for s in shown]),
        "solved": stacked([one.solved for one in fit.computed], 0.0),
        "slips": stacked([one.slips for one in fit.computed], 0.0),
        "misfit": [fit.misfit(x, t) for t in range(len(tests))],
        "held_out": held_out,
        **kept_for_draws(fit, x, statistics, solution),
    }
    if "outlier" in solution:
        parts = np.cumsum([np.size(test.frequency) for test in tests])[:-1]
        for name in ("outlier", "outlier_deviation"):
            data[name] = stacked(np.split(np.asarray(solution[name]), parts), 0.0)
        data["value_without_outliers"] = of_parameters(np.asarray(solution["x_without"])[fit.shared])
    starts = [fit.starts(x, t) for t in range(len(tests))]
    if any(one.size for one in starts):
        data["start_variables"] = stacked(starts)
    variables = np.array([each.name for each in fit.variables], dtype=np.str_)
    coords = {
        "parameter": names,
        "parameter_2": names,
        "test": [test.name for test in tests],
        "own": own_names,
        "quantity": [test.quantity for test in tests],
        "joint": [test.joint for test in tests],
        FIT: variables,
        OTHER: variables,
    }
    attrs = {"title": "Parameters from frequency responses", "noise": float(np.sqrt(statistics.noise))}
    attrs |= {"free": free_as_text(fit.free), "output_number": tests[0].output, "held": tests[0].held}
    # As a file keeps them: numbers and texts; null for what is neither.
    settings = [{k: v if isinstance(v, (bool, int, float, str)) else None for k, v in test.settings.items()} for test in tests]
    attrs["settings"] = json.dumps(settings)
    return tabulated("response_identification", data, coords, attrs)


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


def summary(dataset: xr.Dataset) -> list[str]:
    """Parameters with intervals, what each test has by itself, misfit of each test, notes; mistakes that are suspected first."""
    said = [note for note in str(dataset.attrs.get("notes", "")).split("\n") if note]
    suspected = said.index(SUSPICION) + 1 if SUSPICION in said else 0
    lines: list[str] = [Row(_parameter(dataset, k)) for k in range(dataset.sizes["parameter"])]
    lines += [_of_each_test(dataset, str(name)) for name in dataset["own"].values]
    sizes, predicted = 100.0 * dataset["misfit"].values, 100.0 * dataset["held_out"].values
    worst = int(np.argmax(sizes))
    lines.append(
        f"{counted(sizes.size, 'test')}, misfit {rounded(float(np.median(sizes)), 2)} % of the largest response in the median, "
        f"at most {rounded(sizes[worst], 2)} % ({dataset['test'].values[worst]})"
    )
    if np.isfinite(predicted).any():
        joint = str(dataset["joint"].values[int(np.nanargmax(predicted))]) if "joint" in dataset.coords else ""
        which, where = ("each joint left out", f" (joint {joint})") if joint else ("left out", "")
        lines.append(f"{which} and predicted by the others: at most {rounded(float(np.nanmax(predicted)), 2)} %{where}")
    return said[:suspected] + lines + said[suspected:]


def _parameter(dataset: xr.Dataset, k: int) -> str:
    """A parameter with its interval, a factor with what it makes of the value of the problem; or the lower bound of friction."""
    name = str(dataset["parameter"].values[k])
    value, low, high, least = (float(dataset[key].values[k]) for key in ("value", "low", "high", "least"))
    own, unit = json.loads(dataset.attrs.get("factors", "{}")).get(name, (None, ""))
    if np.isfinite(least):
        known = f"{least:.5g}" if own is None else f"{times(own, least, unit)} (× {least:.5g})" if own else f"× {least:.5g}"
        return f"{name} ≥ {known}: lower bound: with less a contact would slip or open"
    digits = digits_between(low, high, 5)
    shown, ends = f"{value:.{digits}g}", f"{low:.{digits}g} to {high:.{digits}g}"
    if own is None:
        return f"{name} = {shown}, 95 % interval {ends}"
    if not own:
        return f"{name} × {shown}, 95 % interval × {ends}"
    if own[0] < own[1]:
        return f"{name} × {shown} = {times(own, value, unit, digits)} over the contacts, 95 % interval × {ends}"
    of_value = f"{low * own[0]:.{digits}g} to {times(own, high, unit, digits)}"
    return f"{name} × {shown} = {times(own, value, unit, digits)}, 95 % interval {of_value} (× {ends})"


def times(own: list[float], factor: float, unit: str, digits: int = 5) -> str:
    """The value of the problem, or its least and largest one, times a factor."""
    values = " to ".join(dict.fromkeys(f"{factor * value:.{digits}g}" for value in own))
    return f"{values} {unit}".rstrip()


def _of_each_test(dataset: xr.Dataset, name: str) -> str:
    """The values of what each test has by itself, or their range."""
    values: Array = dataset["own_value"].sel(own=name).values
    there = np.isfinite(values)
    tests, values = dataset["test"].values[there], np.degrees(values[there]) if name == PHASE else values[there]
    unit = "°" if name == PHASE else ""
    if values.size > LISTED:
        return f"{name}: {values.min():.4g} to {values.max():.4g}{unit} over {counted(values.size, 'test')}"
    return f"{name}: " + ", ".join(f"{value:.4g}{unit} ({test})" for test, value in zip(tests, values, strict=True))
