"""Tornado plot: the effect of each parameter's range on the peak, strongest first, with Sobol' indices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import measure_in
from stickslip.show.plots.chart import Axis, Bars, Chart, Layer, Panel, Rule
from stickslip.show.plots.look import Style, contact, spoken
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


@FIGURES.of("SensitivityIndices")
def tornado(dataset: xr.Dataset) -> Chart:
    """A panel for amplitude and one for frequency: bars to the low and to the high end in per cent, one below the
    other, since both may lie on the same side; total indices beside the names."""
    measure = measure_in(dataset)
    peak = "peak amplitude" if measure == DISPLACEMENT_AMPLITUDE else f"peak {measure.symbol}"
    panels = []
    for q, quantity in enumerate((peak, "peak frequency")):
        middle, total = float(dataset["middle"].values[q]), dataset["total"].values[:, q]
        ends = [100.0 * (dataset[key].values[:, q] / middle - 1.0) for key in ("low_end", "high_end")]
        order = np.argsort(np.max(np.abs(ends), axis=0))
        names = [f"{spoken(str(dataset['parameter'].values[k]))}, {total[k]:.2f}" for k in order]
        rows, hover = np.arange(len(names), dtype=float), {"total index": total[order]}
        layers: list[Layer] = [
            Bars(rows + beside, values[order], contact(k), label, width=0.32, horizontal=True, hover=hover)
            for k, (values, label, beside) in enumerate(zip(ends, ("low end", "high end"), (0.16, -0.16), strict=True))
        ]
        layers.append(Rule(0.0, Style("grey", width=0.8)))
        axes = Axis(f"change of the {quantity}", "%"), Axis("", names={float(row): name for row, name in enumerate(names)})
        panels.append(Panel(*axes, layers, quantity.capitalize(), 0.6 + 0.4 * len(names)))
    return Chart("Effect of each parameter, with its total index", panels, columns=2)
