"""Sampled responses over start states, with bounds and percentiles where available."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stickslip.results.view import along_curve_as, frequencies, measure_in, peak_unit
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, from_zero
from stickslip.show.plots.look import EMPHASIS, LOWER, SAMPLE, UPPER, shown_levels
from stickslip.show.plots.response_curves import HERTZ, phase, words_on_axis
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


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
            layers += _bounds(bounds, float(level), unit.metres)
        panels.append(Panel(HERTZ, sizes, layers, f"force {level:g}, {cases.size} start states"))
    return Chart(f"Responses of one problem: {dataset.attrs['title']}", panels, note=note, shared_x=True)


def _bounds(bounds: xr.Dataset, level: float, unit: float) -> list[Layer]:
    scale = measure_in(bounds).per(level) / unit
    return [
        Line(bounds["resonance"].values[case, k], scale * bounds["amplitude"].values[case, k], style, words)
        for case in np.flatnonzero(np.isclose(bounds["force_level"].values, level))
        for k, (style, words) in enumerate(((LOWER, "lower bound"), (UPPER, "upper bound")))
    ]
