"""Percentiles of the response over start states as bands around the median, one panel per force level."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.variability.percentiles import percentiles
from stickslip.results.view import measure_in, peak_unit
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, band, from_zero
from stickslip.show.plots.look import SAMPLE, Style, contact, shown_levels
from stickslip.show.plots.response_curves import HERTZ, words_on_axis
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

OUTER, INNER = (5.0, 95.0), (25.0, 75.0)
EXTREME = Style(SAMPLE.colour, "dot", 1.0)


@FIGURES.of("ResponseSamples", "percentiles")
def response_percentiles(dataset: xr.Dataset, output: int = 0) -> Chart:
    """Median, quartiles and the middle nine tenths of the amplitude at each frequency, within the lowest and highest sample."""
    table, unit = percentiles(dataset, (0.0, *OUTER, *INNER, 50.0, 100.0), output), peak_unit(dataset)
    levels, note = shown_levels(table["force_level"].values)
    sizes, panels = from_zero(Axis(words_on_axis(measure_in(dataset)), unit.name)), []
    for level in levels:
        at = table.sel(force_level=level)
        here = {float(p): at.sel(percent=p).values / unit.metres for p in table["percent"].values}
        fewest, cases = int(table["solved"].sel(force_level=level).min()), int(np.sum(dataset["force_level"].values == level))
        words = f"force {level:g}, at least {fewest} of {cases} start states solved"
        panels.append(Panel(HERTZ, sizes, _layers(table["frequency"].values, here), words))
    return Chart(f"Percentiles over start states: {dataset.attrs['title']}", panels, note=note, shared_x=True)


def _layers(hertz: np.ndarray, here: dict[float, np.ndarray]) -> list[Layer]:
    hover = {f"{percent:g} %": here[percent] for percent in (*OUTER, *INNER)}
    return [
        band(hertz, here[OUTER[0]], here[OUTER[1]], contact(0, opacity=0.18), "5 to 95 %"),
        band(hertz, here[INNER[0]], here[INNER[1]], contact(0, opacity=0.35), "25 to 75 %"),
        Line(hertz, here[50.0], contact(0), "median", hover),
        Line(hertz, here[0.0], EXTREME, "extremes"),
        Line(hertz, here[100.0], EXTREME, "extremes"),
    ]
