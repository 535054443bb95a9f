"""What parameters from frequency responses are given as: the result, its dataset, and the answer in sentences."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.laboratory.identification.response.decay_prediction import predict_decay
from stickslip.laboratory.identification.response.decay_prediction_result import DecayPrediction
from stickslip.laboratory.identification.response.diagnosis import SUSPICION
from stickslip.laboratory.identification.response.draws import free_as_text, kept_for_draws, names_of_fit
from stickslip.laboratory.identification.response.fit import GAIN, PHASE, ResponseFit
from stickslip.laboratory.identification.response.intervals import FitStatistics
from stickslip.laboratory.identification.response.prediction import predict_response
from stickslip.laboratory.identification.response.prediction_result import ResponsePrediction
from stickslip.model.problem import Problem
from stickslip.results.files import save
from stickslip.results.result import Result
from stickslip.results.schema import stamped
from stickslip.support.checks import Array, counted, digits_between, rounded
from stickslip.support.late import xr

LISTED = 4
"""Tests up to which what each has by itself is listed; of more their range is shown."""


@dataclass(frozen=True, eq=False, repr=False)
class ResponseIdentification(Result):
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

    def save(self, path: str | Path) -> Path:
        """Write the dataset as NetCDF, as the command does."""
        return save(stamped(self.dataset, "response_identification"), path)

    def __str__(self) -> str:
        """Parameters with intervals, misfit of each test, notes."""
        return "\n".join(summary(self.dataset))


def dataset_of_fit(
    fit: ResponseFit, x: Array, statistics: FitStatistics, held_out: Array, solution: Mapping[str, Any]
) -> xr.Dataset:
    """The labelled result; solution: what the fit gave beside x, outliers and the variables without them, lower bounds of
    friction, and of a fit against bounds these and the ends of the profiles, which have no correlation."""
    tests, longest = [model.test for model in fit.tests], max(np.size(model.test.frequency) for model in fit.tests)
    names = [fit.variables[k].name for k in fit.shared]
    reach, enclosed = statistics.quantile * statistics.error, "bounds" in solution
    ends = [np.clip(x + side * reach, *fit.bounds)[fit.shared] for side in (-1.0, 1.0)]
    low, high = np.asarray(solution["ends"]) if enclosed else ends
    correlation = statistics.correlation[np.ix_(fit.shared, fit.shared)]
    shown = [fit.shown(x, t) for t in range(len(tests))]
    nowhere = [np.full(np.size(test.frequency), np.nan) for test in tests]
    phases = [none if test.phase is None else np.degrees(test.phase) for test, none in zip(tests, nowhere, strict=True)]
    own_names, own = _own_values(fit, x)

    def of_parameters(variables: Any, words: str) -> tuple[Any, ...]:
        values = [fit.free[name].value(float(v)) if np.isfinite(v) else np.nan for name, v in zip(names, variables, strict=True)]
        return "parameter", values, {"units": "as given", "long_name": words}

    def of_points(rows: Any, units: str, words: str, fill: float = np.nan) -> tuple[Any, ...]:
        whole = [np.pad(np.asarray(row, dtype=float), (0, longest - len(row)), constant_values=fill) for row in rows]
        return ("test", "point"), np.array(whole), {"units": units, "long_name": words}

    def named(dims: Any, values: Any, words: str, units: str = "1") -> tuple[Any, ...]:
        return dims, values, {"units": units, "long_name": words}

    data = {
        "value": of_parameters(x[fit.shared], "identified value"),
        "low": of_parameters(low, "lower end of the 95 % interval, not below the bound"),
        "high": of_parameters(high, "upper end of the 95 % interval, not above the bound"),
        "least": of_parameters(solution.get("least", np.full(len(names), np.nan)), "lower bound of friction that never slips"),
        "correlation": named(
            ("parameter", "parameter_2"), correlation * (np.nan if enclosed else 1.0), "correlation of the errors"
        ),
        "own_value": named(("test", "own"), own, "what each test has by itself", "as given"),
        "frequency": of_points([test.frequency for test in tests], "Hz", "frequency"),
        "force": of_points([test.force for test in tests], "1", "measured force level"),
        "response": of_points([test.amplitude for test in tests], "SI", "measured amplitude"),
        "measured": of_points([np.abs(test.per_force) for test in tests], "SI", "measured response per force"),
        "computed": of_points([np.abs(s) for s in shown], "SI", "computed response per force"),
        "measured_phase": of_points(phases, "degree", "measured phase of the displacement"),
        "computed_phase": of_points([np.degrees(np.angle(s)) for s in shown], "degree", "computed phase of the displacement"),
        "solved": of_points([one.solved for one in fit.computed], "1", "1 where the problem has a solution", 0.0),
        "slips": of_points([one.slips for one in fit.computed], "1", "1 where a contact slips or opens", 0.0),
        "misfit": named("test", [fit.misfit(x, t) for t in range(len(tests))], "misfit relative to the largest response"),
        "held_out": named("test", held_out, "misfit with the parameters of the other tests"),
        **kept_for_draws(fit, x, statistics, solution),
    }
    if "outlier" in solution:
        parts = np.cumsum([np.size(test.frequency) for test in tests])[:-1]
        errors, deviations = (np.split(np.asarray(solution[key]), parts) for key in ("outlier", "outlier_deviation"))
        data["outlier"] = of_points(errors, "1", "residual of an outlier in standard errors, else 0", 0.0)
        data["outlier_deviation"] = of_points(deviations, "1", "of an outlier, relative to the fit", 0.0)
        data["value_without_outliers"] = of_parameters(
            np.asarray(solution["x_without"])[fit.shared], "value without the outliers"
        )
    starts = [fit.starts(x, t) for t in range(len(tests))]
    if widest := max(one.size for one in starts):
        rows = np.array([np.pad(one, (0, widest - one.size), constant_values=np.nan) for one in starts])
        data["start_variables"] = named(("test", "variable"), rows, "start state of each test")
    if enclosed:
        for end, bounds in zip(("lower", "upper"), np.moveaxis(np.asarray(solution["bounds"]), 1, 0), strict=True):
            data[end] = named(("test", "point"), bounds, f"{end} bound of the response per force over all start states", "SI")
    coords = {
        "parameter": named("parameter", names, "parameter"),
        "parameter_2": named("parameter_2", names, "parameter"),
        "test": named("test", [test.name for test in tests], "test"),
        "own": named("own", own_names, "what each test has by itself"),
        "quantity": named("test", [test.quantity for test in tests], "measured quantity"),
        "joint": named("test", [test.joint for test in tests], "joint that was measured"),
        **names_of_fit(fit),
    }
    attrs = {"title": "Parameters from frequency responses", "noise": float(np.sqrt(statistics.noise))}
    attrs |= {"free": free_as_text(fit.free), "output_number": tests[0].output, "held": tests[0].held}
    # As a file keeps them: numbers and texts; null for what is neither.
    settings = [{k: v if isinstance(v, (bool, int, float, str)) else None for k, v in test.settings.items()} for test in tests]
    attrs["settings"] = json.dumps(settings)
    return xr.Dataset(data, coords, attrs)


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
    lines = [_parameter(dataset, k) for k in range(dataset.sizes["parameter"])]
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
        return f"{name} ≥ {known}: no contact slips or opens, with less one would"
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
