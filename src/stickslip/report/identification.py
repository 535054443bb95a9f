"""How identifications are reported: parameters with intervals, how well each loop is met, warnings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.plots.files import Figures
from stickslip.plots.identification import loops_and_fit, posterior, residuals
from stickslip.report.presentation import Presentation

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def sentences(dataset: xr.Dataset) -> list[str]:
    """Every parameter with its interval, then what must be known."""
    lines = []
    for name in dataset["parameter"].values:
        one = dataset.sel(parameter=name)
        units = str(one["parameter_units"].values)
        factor, shown = (1.0, "") if units == "1" else (1e-6, " N/um")
        value, (low, high) = float(one["value"]) * factor, one["interval"].values * factor
        known = f"95 % between {low:.4g} and {high:.4g}{shown}" if np.isfinite(low) else "no interval"
        lines.append(f"{name:<6} {value:.4g}{shown}, {known}")
    if "held_out" in dataset:
        errors = zip(dataset["law"].values, dataset["held_out"].values, strict=True)
        listed = ", ".join(f"{law} {error:.3g}" for law, error in errors)
        lines.append(f"law    {dataset.attrs['law']}; errors on loops held out, in standard deviations: {listed}")
    return [*lines, *(f"note: {line}" for line in str(dataset.attrs["warnings"]).splitlines())]


def failures(dataset: xr.Dataset) -> list[str]:
    """A fit that explains its loops too badly is refused before there are results."""
    return []


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Parameters, and misfits of the loops."""
    import pandas as pd

    parameters = pd.DataFrame(
        {
            "parameter": dataset["parameter"].values,
            "value": dataset["value"].values,
            "low (95 %)": dataset["interval"].values[:, 0],
            "high (95 %)": dataset["interval"].values[:, 1],
            "units": dataset["parameter_units"].values,
        }
    )
    misfit = pd.DataFrame(dataset["misfit"].values, columns=list(dataset["channel"].values))
    misfit.insert(0, "loop", dataset["case"].values)
    gains = pd.DataFrame({"channel": dataset["channel"].values, "gain error": dataset["gain"].values})
    found = {"parameters": parameters, "misfit relative to the varying part": misfit, "gains": gains}
    if "held_out" in dataset:
        found["laws"] = pd.DataFrame({"law": dataset["law"].values, "error on loops held out": dataset["held_out"].values})
    return found


def figures(dataset: xr.Dataset) -> Figures:
    """Measured against fitted, residuals, posterior."""
    return {"loops": loops_and_fit, "residuals": residuals, "posterior": posterior}


PRESENTATION = Presentation("Identification of contact parameters", sentences, failures, figures, tables)
