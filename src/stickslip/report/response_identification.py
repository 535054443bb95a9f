"""Presentation of parameters from frequency responses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.identification.response_summary import summary
from stickslip.plots.files import Figures
from stickslip.plots.response_identification import intervals, measured_and_computed, misfits
from stickslip.report.presentation import Presentation

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
    """Parameters with intervals and correlations, and the tests with their misfit and what they have by themselves."""
    import pandas as pd

    names = [str(name) for name in dataset["parameter"].values]
    columns = {"parameter": names, **{key: dataset[key].values for key in ("value", "low", "high", "least")}}
    columns |= {f"correlation with {name}": dataset["correlation"].values[:, k] for k, name in enumerate(names)}
    own = {str(name): dataset["own_value"].values[:, k] for k, name in enumerate(dataset["own"].values)}
    tests = {"test": dataset["test"].values, "misfit [1]": dataset["misfit"].values, "left out [1]": dataset["held_out"].values}
    return {"parameters": pd.DataFrame(columns), "tests": pd.DataFrame(tests | own)}


def figures(dataset: xr.Dataset) -> Figures:
    """Curves, misfits, intervals."""
    return {"measured_and_computed": measured_and_computed, "misfits": misfits, "intervals": intervals}


PRESENTATION = Presentation("Parameters from frequency responses", sentences, failures, figures, tables)
