"""Presentations of identifications and of what is predicted from them.

Parameters with intervals, the fit of each loop, test or law, warnings; predicted responses and decays.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from stickslip.laboratory.identification.contact_law.work import sentences as law_sentences
from stickslip.laboratory.identification.damper.work import chain_sentences
from stickslip.laboratory.identification.least_squares import CERTAINTY
from stickslip.laboratory.identification.response.decay_prediction import comparison_table as decay_comparison_table
from stickslip.laboratory.identification.response.decay_prediction import decay_table, whole_tables
from stickslip.laboratory.identification.response.decay_prediction import failures as decay_failures
from stickslip.laboratory.identification.response.decay_prediction import summary as decay_summary
from stickslip.laboratory.identification.response.prediction_result import comparison_table, curve_table, peak_table, summary
from stickslip.laboratory.identification.response.prediction_result import failures as prediction_failures
from stickslip.laboratory.identification.response.result import summary as response_summary
from stickslip.laboratory.identification.response.result import times
from stickslip.results.schema import Row, in_system, system_of
from stickslip.show.plots import identification as figures
from stickslip.show.plots.paper import Figures
from stickslip.show.report.markup import percent, presents
from stickslip.support.checks import counted
from stickslip.support.late import pd, xr


def sentences(dataset: xr.Dataset) -> list[str]:
    """How well the loops are explained, every parameter with its interval, then what must be known."""
    rows = []
    for name in dataset["parameter"].values:
        parameter = dataset.sel(parameter=name)
        factor, unit = _shown(str(parameter["parameter_units"].values), dataset)
        shown = "" if unit == "1" else f" {unit}"
        value, (low, high) = float(parameter["value"]) * factor, parameter["interval"].values * factor
        known = f"95 % between {low:.4g} and {high:.4g}{shown}" if np.isfinite(low) else "no interval"
        rows.append(Row(f"{name:<6} {value:.4g}{shown}, {known}"))
    worst = percent(float(dataset["misfit"].max()))
    count = counted(dataset.sizes["parameter"], "parameter")
    lines = [f"{count} from {counted(dataset.sizes['case'], 'loop')}; largest misfit {worst}", *rows]
    if "held_out" in dataset:
        errors = zip(dataset["law"].values, dataset["held_out"].values, strict=True)
        listed = ", ".join(f"{law} {error:.3g}" for law, error in errors)
        lines.append(f"law    {dataset.attrs['law']}; errors on loops held out, in standard deviations: {listed}")
    lines += chain_sentences(dataset)
    return [*lines, *(f"note: {line}" for line in str(dataset.attrs["warnings"]).splitlines())]


def _shown(units: str, dataset: xr.Dataset) -> tuple[float, str]:
    """The factor from SI to the unit that a parameter is shown in, N/µm unless the study states others, and this unit."""
    factor, shown = in_system("N/µm", system_of(dataset))
    return (1.0, units) if units == "1" else (1e-6 * factor, shown)


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Parameters, and misfits of the loops."""
    factors, units = zip(*(_shown(str(unit), dataset) for unit in dataset["parameter_units"].values), strict=True)
    parameters = pd.DataFrame(
        {
            "parameter": dataset["parameter"].values,
            "value": dataset["value"].values * factors,
            "low (95 %)": dataset["interval"].values[:, 0] * factors,
            "high (95 %)": dataset["interval"].values[:, 1] * factors,
            "units": units,
        }
    )
    misfit = pd.DataFrame(dataset["misfit"].values, columns=list(dataset["channel"].values))
    misfit.insert(0, "loop", dataset["case"].values)
    gains = pd.DataFrame({"channel": dataset["channel"].values, "gain error [%]": 100.0 * dataset["gain"].values})
    cells = [name for name in dataset["channel"].values if str(name).startswith("force")]
    rows = [(case, cell, dataset.sel(case=case, channel=cell)) for case in dataset["case"].values for cell in cells]
    zeros = pd.DataFrame(
        {
            "loop": [case for case, _, _ in rows],
            "cell": [cell for _, cell, _ in rows],
            "zero in N": [float(loop["zero"]) for _, _, loop in rows],
            "low (95 %)": [float(loop["zero"] - CERTAINTY * loop["zero_error"]) for _, _, loop in rows],
            "high (95 %)": [float(loop["zero"] + CERTAINTY * loop["zero_error"]) for _, _, loop in rows],
        }
    )
    frames = {"parameters": parameters, "misfit relative to the varying part": misfit, "gains": gains, "zeros": zeros}
    if "right_motion" in dataset:
        span = 1e6 * (dataset["right_motion"].max("sample") - dataset["right_motion"].min("sample"))
        error = 1e6 * dataset["right_motion_error"].max("sample")
        motion = pd.DataFrame({"loop": dataset["case"].values})
        for name in dataset["motion"].values:
            motion[str(name)] = span.sel(motion=name).values
            motion[f"{name}: standard deviation, largest"] = error.sel(motion=name).values
        frames["measured motion at the right contact, peak to peak, µm"] = motion
    if "held_out" in dataset:
        frames["laws"] = pd.DataFrame({"law": dataset["law"].values, "error on loops held out": dataset["held_out"].values})
    return frames


PRESENTATION = presents(
    "identification",
    "Identification of contact parameters",
    sentences,
    {"loops": figures.loops_and_fit, "residuals": figures.residuals, "posterior": figures.posterior},
    tables,
    answer="parameters",
)


def law_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Parameters of all laws, those of the chosen law cycle by cycle, and friction over the load."""
    laws = pd.DataFrame({"law": dataset["law"].values})
    least = dataset.attrs.get("least_mu")
    for name, factor, unit in (("kt", 1e-6, " in N/µm"), ("mu", 1.0, "")):
        if name == "mu" and least is not None:
            laws["mu, at least"] = float(least)
            continue
        laws[f"{name}{unit}"] = factor * dataset[name].values
        for bound in ("low", "high"):
            laws[f"{name}, {bound} (95 %){unit}"] = factor * dataset[f"{name}_interval"].sel(bound=bound).values
    for name in ("misfit", "held_out"):
        laws[name.replace("_", " ")] = dataset[name].values
    friction = {"mu": dataset["cycle_mu"].values, "standard deviation of mu": dataset["cycle_mu_error"].values}
    cycles = pd.DataFrame(
        {
            "cycle": dataset["cycle_number"].values,
            "kt in N/µm": 1e-6 * dataset["cycle_kt"].values,
            "standard deviation of kt in N/µm": 1e-6 * dataset["cycle_kt_error"].values,
            **(friction if least is None else {}),
            "plateau of the force over the load": dataset["plateau"].values,
            "energy measured in mJ": 1e3 * dataset["energy_measured"].values,
            "energy fitted in mJ": 1e3 * dataset["energy_fitted"].values,
        }
    )
    return {"laws": laws, "cycles": cycles} | _over_load(dataset)


def _over_load(dataset: xr.Dataset) -> dict[str, pd.DataFrame]:
    """Friction over the normal load, where it was asked for."""
    if "friction" not in dataset:
        return {}
    bounds = {f"mu, {end} (95 %)": dataset["friction_interval"].sel(bound=end).values for end in ("low", "high")}
    return {
        "friction": pd.DataFrame(
            {"normal load in N": dataset["friction_load"].values, "mu": dataset["friction"].values, **bounds}
        )
    }


def law_figures(dataset: xr.Dataset) -> Figures:
    """Loops and fit; with several cycles their parameters, with several laws their errors."""
    cycles: Figures = {"cycles": figures.over_cycles} if dataset.sizes["cycle"] > 1 else {}
    laws: Figures = {"laws": figures.held_out} if dataset.sizes["law"] > 1 else {}
    return {"loops": figures.law_loops_and_fit, **cycles, **laws}


presents("contact_law", "Law of a contact", law_sentences, law_figures, law_tables)


def response_failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each test with points that have no solution."""
    there = np.isfinite(dataset["frequency"].values)
    lost = (there & (dataset["solved"].values == 0.0)).sum(axis=1)
    names = dataset["test"].values
    return [f"{names[t]}: {lost[t]} points have no solution at the identified parameters" for t in np.flatnonzero(lost)]


def response_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Parameters with intervals, their correlations, and the tests with their misfit and what they have by themselves."""
    names = [str(name) for name in dataset["parameter"].values]
    factors: dict[str, tuple[list[float], str]] = json.loads(dataset.attrs.get("factors", "{}"))
    columns: dict[str, Any] = {"parameter": [f"{name} ×" if name in factors else name for name in names]}
    columns |= {"value": dataset["value"].values, "low (95 %)": dataset["low"].values, "high (95 %)": dataset["high"].values}
    if np.isfinite(dataset["least"].values).any():
        columns["at least"] = dataset["least"].values
    if factors:
        values = zip(names, dataset["value"].values, dataset["least"].values, strict=True)
        columns["in the problem"] = [_in_the_problem(*factors.get(name, ([], "")), value, least) for name, value, least in values]
    correlations = {"parameter": names} | {f"with {name}": dataset["correlation"].values[:, k] for k, name in enumerate(names)}
    own = {str(name): dataset["own_value"].values[:, k] for k, name in enumerate(dataset["own"].values)}
    tests = {"test": dataset["test"].values, "misfit [1]": dataset["misfit"].values, "left out [1]": dataset["held_out"].values}
    found = {"parameters": columns, "correlations": correlations, "tests": tests | own}
    return {caption: pd.DataFrame(table) for caption, table in found.items()}


def _in_the_problem(own: list[float], unit: str, value: float, least: float) -> str:
    """What a factor makes of the values of the problem; empty where there are none."""
    if not own:
        return ""
    return f"≥ {times(own, least, unit)}" if np.isfinite(least) else times(own, value, unit)


presents(
    "response_identification",
    "Parameters from frequency responses",
    response_summary,
    {"measured_and_computed": figures.measured_and_computed, "misfits": figures.misfits, "intervals": figures.intervals},
    response_tables,
    failures=response_failures,
    answer="parameters",
)


def with_comparison(
    answer: str, table: Callable[[xr.Dataset], pd.DataFrame], comparison: Callable[[xr.Dataset], pd.DataFrame], axis: str
) -> Callable[[xr.Dataset], Mapping[str, pd.DataFrame]]:
    """The tables of a prediction: the answer, and where a result has the axis of what is measured, that against it."""
    return lambda dataset: (
        {answer: table(dataset)} | ({"measured against predicted": comparison(dataset)} if axis in dataset.sizes else {})
    )


def histories(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The predicted curves with their bands."""
    return {"predicted curves": curve_table(dataset)}


presents(
    "response_prediction",
    "Predicted responses",
    summary,
    {"predicted": figures.predicted, "predicted_peaks": figures.predicted_peaks},
    with_comparison("predicted peaks", peak_table, comparison_table, "measured"),
    failures=prediction_failures,
    answer="predicted peaks",
    histories=histories,
)


presents(
    "decay_prediction",
    "Predicted decay",
    decay_summary,
    {"predicted_decay": figures.predicted_decay},
    with_comparison("predicted decay", decay_table, decay_comparison_table, "decay"),
    failures=decay_failures,
    answer="predicted decay",
    histories=whole_tables,
)
