"""Intervals of mean traction along a curve, and the contacts that cause the variability."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.plots.look import CONTACTS, house_style, plain

if TYPE_CHECKING:
    import xarray as xr

MOST_ROWS = 6


def freedom(dataset: xr.Dataset) -> Figure:
    """Above: admissible mean traction of the rows that carry most, summed over their elements; below: what they carry."""
    names = np.asarray(dataset["element_row"].values)
    rows = list(dict.fromkeys(names.tolist()))
    hertz, relative = dataset["frequency"].values, np.abs(dataset["carried"].values) / dataset["amplitude"].values[:, None]
    carried = {row: relative[:, names == row].sum(axis=1) for row in rows}
    shown = sorted(rows, key=lambda row: -float(carried[row].max()))[:MOST_ROWS]
    with house_style():
        figure = Figure(figsize=(7.6, 6.0), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        for row, colour in zip(shown, CONTACTS, strict=False):
            low, high = (dataset[end].values[:, names == row].sum(axis=1) for end in ("low", "high"))
            above.fill_between(hertz, low, high, color=colour, alpha=0.18, linewidth=0)
            above.plot(hertz, dataset["mean"].values[:, names == row].sum(axis=1), color=colour, label=plain(row))
            below.plot(hertz, 100.0 * carried[row], color=colour)
        above.set(title="Mean traction and its admissible interval", ylabel="N")
        above.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        below.set(
            title="What the slider alone could change, to first order", ylabel="% of the amplitude", xlabel="frequency in Hz"
        )
    return figure
