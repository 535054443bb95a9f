"""Intervals of mean traction along a curve, and the contacts that cause the variability."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, band
from stickslip.show.plots.look import contact
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

MOST_ROWS = 6


@FIGURES.of("FrictionFreedom")
def freedom(dataset: xr.Dataset) -> Chart:
    """Above: admissible mean traction of the rows that carry most, summed over their elements; below: what they carry."""
    names = np.asarray(dataset["element_row"].values)
    rows = list(dict.fromkeys(names.tolist()))
    hertz, relative = dataset["frequency"].values, np.abs(dataset["carried"].values) / dataset["amplitude"].values[:, None]
    carried = {row: relative[:, names == row].sum(axis=1) for row in rows}
    above: list[Layer] = []
    below: list[Layer] = []
    for k, row in enumerate(sorted(rows, key=lambda row: -float(carried[row].max()))[:MOST_ROWS]):
        low, mean, high = (dataset[end].values[:, names == row].sum(axis=1) for end in ("low", "mean", "high"))
        above += [band(hertz, low, high, contact(k, opacity=0.18), row)]
        above += [Line(hertz, mean, contact(k), row, {"lowest in N": low, "highest in N": high}, listed=False)]
        below += [Line(hertz, 100.0 * carried[row], contact(k), row)]
    panels = [
        Panel(HERTZ, Axis("mean traction", "N"), above, "Mean traction and its admissible interval", 2.6),
        Panel(HERTZ, Axis("change of the amplitude", "%"), below, "What the slider alone could change, to first order", 2.6),
    ]
    return Chart("Freedom of the friction forces", panels, shared_x=True)
