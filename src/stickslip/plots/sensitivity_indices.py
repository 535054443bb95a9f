"""Tornado plot: the effect of each parameter's range on the peak, strongest first, with Sobol' indices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.harmonic.measure import DISPLACEMENT_AMPLITUDE
from stickslip.plots.look import CONTACTS, GREY, house_style, plain
from stickslip.results.view import measure_in

if TYPE_CHECKING:
    import xarray as xr


def tornado(dataset: xr.Dataset) -> Figure:
    """A panel for amplitude and one for frequency: bars to the low and to the high end in per cent, one below the
    other, since both may lie on the same side; total indices beside them."""
    measure = measure_in(dataset)
    peak = "peak amplitude" if measure == DISPLACEMENT_AMPLITUDE else f"peak {measure.symbol}"
    titles = (peak, "peak frequency")
    names = [plain(str(name)) for name in dataset["parameter"].values]
    with house_style():
        figure = Figure(figsize=(7.6, 1.4 + 0.5 * len(names)), layout="constrained")
        for q, axes in enumerate(figure.subplots(1, 2)):
            middle = float(dataset["middle"].values[q])
            ends = [100.0 * (dataset[key].values[:, q] / middle - 1.0) for key in ("low_end", "high_end")]
            order = np.argsort(np.max(np.abs(ends), axis=0))
            for place, k in enumerate(order):
                for values, colour, beside in zip(ends, (CONTACTS[0], CONTACTS[1]), (0.16, -0.16), strict=True):
                    axes.barh(place + beside, values[k], color=colour, height=0.32)
                total = float(dataset["total"].values[k, q])
                axes.text(1.01, place, f"{total:.2f}", transform=axes.get_yaxis_transform(), va="center", fontsize=8.5)
            axes.axvline(0.0, color=GREY, linewidth=0.8)
            axes.set_yticks(range(len(names)), [names[k] for k in order])
            axes.set(title=titles[q], xlabel="change in %; right: total index")
        handles = [figure.axes[0].patches[0], figure.axes[0].patches[1]]
        figure.legend(handles, ["low end", "high end"], loc="outside upper right", ncols=2)
    return figure
