"""Contact stiffness against normal load."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.plots.look import CONTACTS, GREY, house_style

if TYPE_CHECKING:
    import xarray as xr


def stiffness_over_load(dataset: xr.Dataset) -> Figure:
    """Normal stiffness by every formula, the initial tangential ones dotted (across) and dashed (along), the load of interest."""
    load, at = dataset["load"].values, float(dataset.attrs["load_of_interest"])
    with house_style():
        figure = Figure(figsize=(7.6, 4.2), layout="constrained")
        axes = figure.add_subplot()
        for formula, colour in zip(dataset["formula"].values, CONTACTS, strict=False):
            axes.plot(load, dataset["normal_stiffness"].sel(formula=formula) / 1e6, color=colour, label=f"normal, {formula}")
        axes.plot(
            load,
            dataset["tangential_across"] / 1e6,
            color="black",
            linestyle=":",
            label="tangential, across the line (initial)",
        )
        axes.plot(
            load, dataset["tangential_along"] / 1e6, color=GREY, linestyle="--", label="tangential, along the line (initial)"
        )
        if np.isfinite(at):
            axes.axvline(at, color=GREY, linewidth=0.9)
            axes.annotate(f"{at:.4g} N", (at, 0.02), xycoords=("data", "axes fraction"), ha="left", color=GREY)
        axes.set(title="Stiffness of the line contact", xlabel="normal load in N", ylabel="stiffness in N/µm", xlim=(0.0, None))
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    return figure
