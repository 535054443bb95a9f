"""Percentiles of the response over start states as bands around the median, one panel per force level."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.analyses.variability.percentiles import percentiles
from stickslip.plots.look import CONTACTS, GREY, headed, house_style, shown_levels
from stickslip.plots.response_curves import words_on_axis
from stickslip.results.view import measure_in, peak_unit

if TYPE_CHECKING:
    import xarray as xr

EDGES, INNER = (5.0, 95.0), (25.0, 75.0)


def response_percentiles(dataset: xr.Dataset, output: int = 0) -> Figure:
    """Median, quartiles and the middle nine tenths of the amplitude at each frequency, within the lowest and highest sample."""
    table, unit = percentiles(dataset, (0.0, *EDGES, *INNER, 50.0, 100.0), output), peak_unit(dataset)
    levels, note = shown_levels(table["force_level"].values)
    with house_style():
        figure = Figure(figsize=(7.6, 0.8 + 2.4 * levels.size), layout="constrained")
        for level, axes in zip(levels, figure.subplots(levels.size, 1, squeeze=False, sharex=True).ravel(), strict=True):
            here = {float(p): table.sel(force_level=level, percent=p).values / unit.metres for p in table["percent"].values}
            hertz = table["frequency"].values
            axes.fill_between(
                hertz, here[EDGES[0]], here[EDGES[1]], color=CONTACTS[0], alpha=0.18, linewidth=0, label="5 to 95 %"
            )
            axes.fill_between(
                hertz, here[INNER[0]], here[INNER[1]], color=CONTACTS[0], alpha=0.35, linewidth=0, label="25 to 75 %"
            )
            axes.plot(hertz, here[50.0], color=CONTACTS[0], label="median")
            for end in (0.0, 100.0):
                axes.plot(hertz, here[end], ":", color=GREY, linewidth=1.0, label="extremes" if end else None)
            fewest, cases = int(table["solved"].sel(force_level=level).min()), int(np.sum(dataset["force_level"].values == level))
            label = f"{words_on_axis(measure_in(dataset))} in {unit.name}"
            axes.set(title=f"force {level:g}, at least {fewest} of {cases} start states solved", ylabel=label)
            axes.set_ylim(bottom=0.0)
        axes.set_xlabel("frequency in Hz")
        figure.axes[0].legend(loc="upper left")
        headed(figure, f"Percentiles over start states: {dataset.attrs['title']}", note)
    return figure
