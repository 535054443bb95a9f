"""Figures of predicted responses: curves with their bands and measured points, and peaks with intervals over the levels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.laboratory.identification.response.prediction_result import held_share
from stickslip.results.view import shown_unit
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, band, spans
from stickslip.show.plots.look import entries, level
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.checks import Array
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


def _largest(values: Array) -> float:
    """The largest number of an array, 0 of none."""
    return float(values[np.isfinite(values)].max(initial=0.0))


@FIGURES.of("ResponsePrediction")
def predicted(dataset: xr.Dataset) -> Chart:
    """Of each level the median of the draws (lines) and the 95 % band (areas) over frequency, and measured points (dots)."""
    levels, count = dataset["level"], dataset.sizes["level"]
    names = [f"{value:.4g} {levels.attrs['units']}" for value in levels.values]
    listed, values = entries(names), dataset["amplitude"].values
    unit = shown_unit(dataset["amplitude"].attrs["units"], _largest(values))
    layers: list[Layer] = []
    for k, name in enumerate(names):
        one = dataset.isel(level=k)
        f, low, high = (one[key].values for key in ("frequency", "amplitude_low", "amplitude_high"))
        label = f"{held_share(dataset):.0f} % interval" if count == 1 else ""
        layers.append(band(f, low / unit.metres, high / unit.metres, level(k, count, opacity=0.25), label))
        layers.append(Line(f, one["amplitude"].values / unit.metres, level(k, count), name, listed=name in listed))
    for t in range(dataset.sizes.get("measured", 0)):
        one = dataset.isel(measured=t)
        dots = level(int(one["predicted_level"]), count, dash="none", marker="circle", size=2.5)
        f, size = one["measured_frequency"].values, one["measured_amplitude"].values / unit.metres
        layers.append(Line(f, size, dots, hover={"": [str(one["measured"].values)] * f.size}))
    quantity = f"{dataset.attrs['quantity']}{' per force' if dataset.attrs['held'] == 'response' else ''}"
    axis = Axis(quantity, unit.name, log=spans(values[np.isfinite(values)], 8.0))
    dotted = ", measured points (dots)" if "measured" in dataset.sizes else ""
    return Chart(
        f"Predicted responses (lines) with {held_share(dataset):.0f} % bands (areas){dotted}",
        [Panel(HERTZ, axis, layers, height=3.6)],
    )


@FIGURES.of("ResponsePrediction", "peaks")
def predicted_peaks(dataset: xr.Dataset) -> Chart:
    """Peak response and peak frequency over the levels with their 95 % intervals."""
    levels = dataset["level"]
    at = Axis(str(levels.attrs["long_name"]), str(levels.attrs["units"]), log=levels.size > 1)
    unit = shown_unit(dataset["peak_amplitude"].attrs["units"], _largest(dataset["peak_amplitude"].values))
    panels: list[Panel] = []
    share = f"{held_share(dataset):.0f} % interval"
    order = np.argsort(levels.values)
    for key, axis, factor in (
        ("peak_amplitude", Axis(f"peak {dataset.attrs['quantity']}", unit.name), unit.metres),
        ("peak_frequency", Axis("peak frequency", "Hz"), 1.0),
    ):
        low, middle, high = (dataset[f"{key}{end}"].values[order] / factor for end in ("_low", "", "_high"))
        x = levels.values[order]
        points = level(0, 1, dash="none", marker="circle", size=4.0)
        whiskers = np.column_stack([low, high, np.full(x.size, np.nan)]).ravel()
        bars = Line(np.repeat(x, 3), whiskers, level(0, 1), share, listed=not panels)
        panels.append(Panel(at, axis, [bars, Line(x, middle, points, "median", listed=not panels)], height=2.2))
    return Chart(f"Predicted peaks with {share}s", panels, shared_x=True)
