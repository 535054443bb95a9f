"""Sampled responses over start states, with bounds where there are any, and their percentiles as bands around the median."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.variability.percentiles import percentiles
from stickslip.results.view import along_curve_as, frequencies, measure_in, peak_unit
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, band, from_zero
from stickslip.show.plots.look import EMPHASIS, LOWER, SAMPLE, UPPER, Style, contact, shown_levels
from stickslip.show.plots.response_curves import HERTZ, phase, words_on_axis
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

OUTER, INNER = (5.0, 95.0), (25.0, 75.0)
"""Ends of the two bands, per cent."""
EXTREME = Style(SAMPLE.colour, "dot", 1.0)


@FIGURES.of("ResponseSamples")
def response_cloud(dataset: xr.Dataset, bounds: xr.Dataset | None = None, output: int = 0) -> Chart:
    """Every curve, a panel per force level, the first (virgin unless a law was given) drawn out; bounds: of the same levels."""
    measure, unit = measure_in(dataset), peak_unit(dataset)
    levels, note = shown_levels(np.unique(dataset["force_level"].values))
    sizes, panels = from_zero(Axis(words_on_axis(measure), unit.name)), []
    for level in levels:
        cases = np.flatnonzero(dataset["force_level"].values == level)
        layers: list[Layer] = []
        for case in cases[::-1].tolist():
            style, label = (EMPHASIS, "first start state") if case == cases[0] else (SAMPLE, "further start states")
            size = along_curve_as(dataset, measure, case, output) / unit.metres
            start = [int(dataset["start"][case]) + 1 if "start" in dataset.coords else case + 1] * size.size
            hover: dict[str, ArrayLike] = {"phase in °": phase(dataset, case, output, measure.order), "start state": start}
            layers.append(Line(frequencies(dataset, case), size, style, label, hover))
        if bounds is not None:
            scale = measure_in(bounds).per(float(level)) / unit.metres
            layers += [
                Line(bounds["resonance"].values[case, k], scale * bounds["amplitude"].values[case, k], style, label)
                for case in np.flatnonzero(np.isclose(bounds["force_level"].values, level))
                for k, (style, label) in enumerate(((LOWER, "lower bound"), (UPPER, "upper bound")))
            ]
        panels.append(Panel(HERTZ, sizes, layers, f"force {level:g}, {cases.size} start states"))
    return Chart(f"Responses of one problem: {dataset.attrs['title']}", panels, note=note, shared_x=True)


@FIGURES.of("ResponseSamples", "percentiles")
def response_percentiles(dataset: xr.Dataset, output: int = 0) -> Chart:
    """Median, quartiles and the middle nine tenths of the amplitude at each frequency, within the lowest and highest sample."""
    table, unit = percentiles(dataset, (0.0, *OUTER, *INNER, 50.0, 100.0), output), peak_unit(dataset)
    levels, note = shown_levels(table["force_level"].values)
    hertz, sizes = table["frequency"].values, from_zero(Axis(words_on_axis(measure_in(dataset)), unit.name))
    panels = []
    for level in levels:
        at = table.sel(force_level=level)
        of = {float(p): at.sel(percent=p).values / unit.metres for p in table["percent"].values}
        bands: list[Layer] = [
            band(hertz, of[OUTER[0]], of[OUTER[1]], contact(0, opacity=0.18), "5 to 95 %"),
            band(hertz, of[INNER[0]], of[INNER[1]], contact(0, opacity=0.35), "25 to 75 %"),
            Line(hertz, of[50.0], contact(0), "median", {f"{p:g} %": of[p] for p in (*OUTER, *INNER)}),
            Line(hertz, of[0.0], EXTREME, "extremes"),
            Line(hertz, of[100.0], EXTREME, "extremes"),
        ]
        fewest, cases = int(at["solved"].min()), int(np.sum(dataset["force_level"].values == level))
        panels.append(Panel(HERTZ, sizes, bands, f"force {level:g}, at least {fewest} of {cases} start states solved"))
    return Chart(f"Percentiles over start states: {dataset.attrs['title']}", panels, note=note, shared_x=True)
