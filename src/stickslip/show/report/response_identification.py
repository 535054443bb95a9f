"""Presentation of parameters from frequency responses."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.laboratory.identification.response.result import summary, times
from stickslip.show.plots.files import Figures
from stickslip.show.plots.identification import intervals, measured_and_computed, misfits
from stickslip.show.report.presentation import Presentation, presents

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def sentences(dataset: xr.Dataset) -> list[str]:
    """Parameters with intervals, misfit, and what the tests cannot say."""
    return summary(dataset)


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each test with points that have no solution."""
    there = np.isfinite(dataset["frequency"].values)
    lost = (there & (dataset["solved"].values == 0.0)).sum(axis=1)
    names = dataset["test"].values
    return [f"{names[t]}: {lost[t]} points have no solution at the identified parameters" for t in np.flatnonzero(lost)]


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Parameters with intervals, their correlations, and the tests with their misfit and what they have by themselves."""
    import pandas as pd

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


def figures(dataset: xr.Dataset) -> Figures:
    """Curves, misfits, intervals."""
    return {"measured_and_computed": measured_and_computed, "misfits": misfits, "intervals": intervals}


PRESENTATION = presents(
    "response_identification",
    Presentation("Parameters from frequency responses", sentences, failures, figures, tables, answer="parameters"),
)
