"""Presentation of a contact law from measured loops: answer, figures, tables of laws and cycles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from stickslip.laboratory.identification.contact_law.result import sentences
from stickslip.show.plots.contact_law import held_out, loops_and_fit, over_cycles
from stickslip.show.plots.files import Figures
from stickslip.show.report.presentation import Presentation, presents

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def failures(dataset: xr.Dataset) -> list[str]:
    """Loops that cannot be fitted are refused before there are results."""
    return []


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Parameters of all laws, those of the chosen law cycle by cycle, and friction over the load."""
    import pandas as pd

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
    import pandas as pd

    if "friction" not in dataset:
        return {}
    bounds = {f"mu, {end} (95 %)": dataset["friction_interval"].sel(bound=end).values for end in ("low", "high")}
    return {
        "friction": pd.DataFrame(
            {"normal load in N": dataset["friction_load"].values, "mu": dataset["friction"].values, **bounds}
        )
    }


def figures(dataset: xr.Dataset) -> Figures:
    """Loops and fit; with several cycles their parameters, with several laws their errors."""
    cycles: Figures = {"cycles": over_cycles} if dataset.sizes["cycle"] > 1 else {}
    laws: Figures = {"laws": held_out} if dataset.sizes["law"] > 1 else {}
    return {"loops": loops_and_fit, **cycles, **laws}


PRESENTATION = presents("contact_law", Presentation("Law of a contact", sentences, failures, figures, tables))
