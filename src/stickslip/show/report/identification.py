"""Presentation of an identification: parameters with intervals, fit of each loop, warnings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.laboratory.identification.damper.result import CERTAINTY, chain_sentences
from stickslip.results.shown_units import in_system, system_of
from stickslip.show.plots.files import Figures
from stickslip.show.plots.identification import loops_and_fit, posterior, residuals
from stickslip.show.report.markup import percent
from stickslip.show.report.presentation import Presentation, presents
from stickslip.support.checks import counted

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def sentences(dataset: xr.Dataset) -> list[str]:
    """How well the loops are explained, every parameter with its interval, then what must be known."""
    rows = []
    for name in dataset["parameter"].values:
        parameter = dataset.sel(parameter=name)
        factor, unit = _shown(str(parameter["parameter_units"].values), dataset)
        shown = "" if unit == "1" else f" {unit}"
        value, (low, high) = float(parameter["value"]) * factor, parameter["interval"].values * factor
        known = f"95 % between {low:.4g} and {high:.4g}{shown}" if np.isfinite(low) else "no interval"
        rows.append(f"{name:<6} {value:.4g}{shown}, {known}")
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


def failures(dataset: xr.Dataset) -> list[str]:
    """A fit that explains its loops too badly is refused before there are results."""
    return []


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Parameters, and misfits of the loops."""
    import pandas as pd

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
    gains = pd.DataFrame({"channel": dataset["channel"].values, "gain error": dataset["gain"].values})
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


def figures(dataset: xr.Dataset) -> Figures:
    """Measured against fitted, residuals, posterior."""
    return {"loops": loops_and_fit, "residuals": residuals, "posterior": posterior}


PRESENTATION = presents(
    "identification",
    Presentation("Identification of contact parameters", sentences, failures, figures, tables, answer="parameters"),
)
