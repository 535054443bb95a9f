"""Figures of response bounds: both bounds with the samples, range of the peak, loss factors, start states."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import Length, force_text, measure_in, shown_unit
from stickslip.show.plots.chart import Axis, Cells, Chart, Key, Layer, Line, Panel, band, edges_between, from_zero
from stickslip.show.plots.look import BETWEEN, LOWER, SAMPLE, STUCK, UPPER, Style, colour, entries, level, rgb, shown_levels
from stickslip.show.plots.response_curves import HERTZ, force_axis, size_label
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


@FIGURES.of("ResponseBounds")
def response_bounds(dataset: xr.Dataset) -> Chart:
    """Amplitude bounds against frequency, a panel per force level, with the sampled start states; of peaks, their ranges."""
    if dataset.attrs["objective"] == "peak":
        return peak_ranges(dataset)
    cases, note = shown_levels(np.arange(dataset.sizes["case"]))
    hertz, unit = dataset["frequency"].values, bound_unit(dataset)
    sampled = replace(SAMPLE, dash="none", marker="circle", size=2.0)
    sizes, panels = from_zero(Axis(size_label(dataset), unit.name)), []
    for case in cases.tolist():
        low, high = dataset["amplitude"].values[case] / unit.metres
        cloud, loss = dataset["sampled_amplitude"].values[case] / unit.metres, dataset["loss_factor"].values[case]
        layers: list[Layer] = [
            band(hertz, low, high, BETWEEN, "between the bounds"),
            Line(np.broadcast_to(hertz, cloud.shape).ravel(), cloud.ravel(), sampled, "sampled start states"),
            Line(hertz, low, LOWER, "lower bound", {"loss factor": loss[0]}),
            Line(hertz, high, UPPER, "upper bound", {"loss factor": loss[1]}),
        ]
        panels.append(Panel(HERTZ, sizes, layers, force_text(dataset, case)))
    title = f"Bounds by {dataset.attrs['objective'].replace('_', ' ')}: {dataset.attrs['title']}"
    return Chart(title, panels, note=note, shared_x=True)


def bound_unit(dataset: xr.Dataset) -> Length:
    """The unit to draw sizes in."""
    return shown_unit(dataset["amplitude"].attrs["units"], float(np.nanmax(dataset["amplitude"].values, initial=0.0)))


def peak_ranges(dataset: xr.Dataset) -> Chart:
    """Range of the resonance amplitude per force, and of its frequency, against the force level."""
    levels, measure, unit = dataset["force_level"].values, measure_in(dataset), bound_unit(dataset)
    divisor = unit.metres * (np.ones(levels.size) if measure.per_force else levels)
    low, high = (dataset["amplitude"].values[:, :, 0] / divisor[:, None]).T
    hertz, loss = dataset["resonance"].values[:, :, 0].T, dataset["loss_factor"].values[:, :, 0].T
    what = "peak amplitude" if measure.kind == "amplitude" and not measure.order else f"peak {measure.symbol}"
    sizes = Axis(what, unit.name) if measure.per_force else Axis(f"{what} per force", f"{unit.name} per unit level")
    force = force_axis(dataset, levels)
    left: list[Layer] = [
        band(levels, low, high, BETWEEN, "between the bounds"),
        Line(levels, low, LOWER, "lower bound", {"frequency in Hz": hertz[0], "loss factor": loss[0]}),
        Line(levels, high, UPPER, "upper bound", {"frequency in Hz": hertz[1], "loss factor": loss[1]}),
        Line(levels, dataset["sampled_amplitude"].values[:, 0, 0] / divisor, STUCK, "virgin contacts"),
    ]
    right = [Line(levels, hertz[0], LOWER, "lower bound"), Line(levels, hertz[1], UPPER, "upper bound")]
    panels = [Panel(force, sizes, left, "Peak", 2.8), Panel(force, HERTZ, right, "Its frequency", 2.8)]
    return Chart(f"Range of the resonance: {dataset.attrs['title']}", panels, columns=2)


@FIGURES.of("ResponseBounds", "loss_factors")
def loss_factors(dataset: xr.Dataset) -> Chart:
    """Loss factor along the lower (solid) and the upper bound (dash-dotted), one colour per force level."""
    names = [force_text(dataset, case) for case in range(dataset.sizes["case"])]
    across = dataset["frequency"].values if dataset.attrs["objective"] != "peak" else dataset["resonance"].values
    layers = []
    for case, name in enumerate(names):
        for bound, words in enumerate(("lower", "upper")):
            style = level(case, len(names), dash=("solid", "dashdot")[bound], marker="circle", size=3)
            x = across if across.ndim == 1 else across[case, bound]
            shown = bound == 0 and name in entries(names)
            values = dataset["loss_factor"].values[case, bound]
            layers.append(Line(x, values, style, name, {"": [f"{words} bound"] * values.size}, listed=shown))
    title = "Loss factor along the bounds: lower solid, upper dash-dotted"
    return Chart(title, [Panel(HERTZ, Axis("loss factor"), layers, height=3.0)])


@FIGURES.of("ResponseBounds", "start_states")
def start_states(dataset: xr.Dataset, case: int = 0) -> Chart:
    """The start variables that make the bounds, against frequency: blue −1, white 0, red 1."""
    hertz, variables = dataset["frequency"].values, dataset["start_variable"].values[case]
    rows = variables.shape[-1]
    keys = Key("−1", Style("contact 0")), Key("1", Style("contact 5"))
    ends = [rgb(colour(key.style.colour)) for key in keys]
    panels = []
    for bound, word in enumerate(("lower", "upper")):
        values = variables[bound].T
        texts = [
            [f"start variable {k + 1}, {f:.2f} Hz: {value:.3g}" for f, value in zip(hertz, along, strict=True)]
            for k, along in enumerate(values)
        ]
        # Mixtures of white, at zero, with the colour of the nearer end.
        mixed = 1.0 + np.abs(values)[..., None] * (np.where(values[..., None] < 0.0, *ends) - 1.0)
        cells = Cells(edges_between(hertz), mixed, texts)
        axis = Axis("start variable", limits=(-0.5, rows - 0.5), upside_down=True)
        panels.append(Panel(HERTZ, axis, [cells, *keys], f"{word} bound", 1.9))
    return Chart(f"Start states of the bounds, {force_text(dataset, case)}", panels, shared_x=True)
