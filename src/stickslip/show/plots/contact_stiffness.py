"""Contact stiffness against normal load."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, Rule, from_zero
from stickslip.show.plots.look import Style, contact
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


@FIGURES.of("ContactStiffness")
def stiffness_over_load(dataset: xr.Dataset) -> Chart:
    """Normal stiffness by every formula, the initial tangential ones dotted (across) and dashed (along), the load of interest."""
    load, at = dataset["load"].values, float(dataset.attrs["load_of_interest"])
    layers: list[Layer] = [
        Line(load, dataset["normal_stiffness"].sel(formula=formula).values / 1e6, contact(k), f"normal, {formula}")
        for k, formula in enumerate(dataset["formula"].values)
    ]
    across, along = (dataset[f"tangential_{direction}"].values / 1e6 for direction in ("across", "along"))
    layers.append(Line(load, across, Style("ink", "dot"), "tangential, across the line (initial)"))
    layers.append(Line(load, along, Style("grey", "dash"), "tangential, along the line (initial)"))
    layers += [Rule(at, Style("grey", width=0.9), f"{at:.4g} N")] if np.isfinite(at) else []
    panel = Panel(from_zero(Axis("normal load", "N")), Axis("stiffness", "N/µm"), layers, height=3.5)
    return Chart("Stiffness of the line contact", [panel])
