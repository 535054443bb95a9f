"""How the design of a damper is told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.plots.design import design_space
from stickslip.plots.files import Figures
from stickslip.report.presentation import Presentation

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def sentences(dataset: xr.Dataset) -> list[str]:
    """The best design, how flat it is, and what matters."""
    names = [str(name) for name in dataset["variable"].values]
    units = dataset["worst_peak"].attrs["units"]
    lines = [f"worst resonance of the best design: {float(dataset['optimum_peak']):.4g} {units}"]
    for k, name in enumerate(names):
        low, high, slope = (float(dataset[key].values[k]) for key in ("near_low", "near_high", "sensitivity"))
        lines.append(
            f"  {name} = {float(dataset['optimum'].values[k]):.4g}; designs within 5 % have {low:.4g} to {high:.4g}; "
            f"1 % more of it changes the worst resonance by {slope:+.2g} %"
        )
    searched = float(dataset["searched_peak"])
    if np.isfinite(searched):
        more = searched / float(dataset["optimum_peak"]) - 1.0
        lines.append(
            f"over all start states a search finds {searched:.4g} {units} there, {100.0 * more:+.2g} % of the drawn ones"
        )
    refused = int(np.count_nonzero(dataset["allowed"].values == 0))
    return [*lines, f"{dataset.sizes['design']} designs computed, {refused} of them break a constraint"]


def failures(dataset: xr.Dataset) -> list[str]:
    """How many conditions gave no peak."""
    failed = int(np.sum(dataset["failed"].values))
    return [f"{failed} conditions of all designs gave no solved peak"] if failed else []


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Every design, the best ones first."""
    import pandas as pd

    table = pd.DataFrame({str(name): dataset["value"].values[:, k] for k, name in enumerate(dataset["variable"].values)})
    table[f"worst peak [{dataset['worst_peak'].attrs['units']}]"] = dataset["worst_peak"].values
    table["at Hz"] = dataset["worst_frequency"].values
    table["at force level"] = dataset["worst_force"].values
    table["at friction"] = dataset["worst_friction"].values
    table["constraints"] = np.where(dataset["allowed"].values == 1, "met", "broken")
    return {"designs": table.iloc[np.lexsort((dataset["worst_peak"].values, -dataset["allowed"].values))]}


def figures(dataset: xr.Dataset) -> Figures:
    """The design space."""
    return {"design_space": design_space}


PRESENTATION = Presentation("Design of a damper", sentences, failures, figures, tables)
