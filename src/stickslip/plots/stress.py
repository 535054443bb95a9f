"""Von Mises' stress along the curves, a panel per place, a curve per force level."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.plots.look import house_style, level_colours, plain
from stickslip.results_view import along_curve, frequencies, level_text

if TYPE_CHECKING:
    import xarray as xr

MPa = 1e6


def stress_curves(dataset: xr.Dataset) -> Figure:
    """Largest von Mises stress over the period against Hz at each place; dots mark the largest of each curve."""
    places = [str(place) for place in dataset["place"].values]
    with house_style():
        figure = Figure(figsize=(7.6, 0.9 + 2.3 * len(places)), layout="constrained")
        for k, axes in enumerate(figure.subplots(len(places), 1, squeeze=False, sharex=True).ravel()):
            for case, colour in enumerate(level_colours(dataset.sizes["case"])):
                hertz, stress = frequencies(dataset, case), along_curve(dataset, "stress_von_mises", case)[:, k] / MPa
                axes.plot(hertz, stress, color=colour, label=level_text(dataset, case))
                if np.any(np.isfinite(stress)):
                    top = int(np.nanargmax(stress))
                    axes.plot(hertz[top], stress[top], "o", color=colour, markersize=4)
            axes.set(title=plain(places[k]), ylabel="von Mises stress in MPa", yscale="log")
        axes.set_xlabel("frequency in Hz")
        figure.axes[0].legend(loc="best", ncols=2)
        figure.suptitle(plain(f"Stress: {dataset.attrs['title']}"), x=0.01, ha="left", fontweight="bold", fontsize=10.5)
    return figure
