"""Measured and computed responses of an identification, and the misfit of each test."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.results.view import shown_unit
from stickslip.show.plots.chart import Axis, Bars, Chart, Layer, Line, Panel, band, spans
from stickslip.show.plots.look import Style, contact, entries, level
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


@FIGURES.of("ResponseIdentification")
def measured_and_computed(dataset: xr.Dataset) -> Chart:
    """Response per force of every test over frequency, measured (dots) and computed (lines), or the area between its bounds; the
    phase where it is known."""
    count, names = dataset.sizes["test"], [str(name) for name in dataset["test"].values]
    quantity = str(dataset["quantity"].values[0])
    units = {"displacement": "m/N", "velocity": "m/(s N)", "acceleration": "m/(s2 N)"}[quantity]
    unit = shown_unit(units, float(np.nanmax(dataset["measured"].values)))
    listed = entries(names)
    top: list[Layer] = []
    bottom: list[Layer] = []
    for t, name in enumerate(names):
        test, shown = dataset.isel(test=t), name in listed
        style, dots = level(t, count), level(t, count, dash="none", marker="circle", size=2.5)
        f = test["frequency"].values
        if "lower" in dataset:
            low, high = (test[key].values / unit.metres for key in ("lower", "upper"))
            top.append(band(f, low, high, level(t, count, opacity=0.25), "between the bounds" if count == 1 else ""))
        for key, look, own in (("measured", dots, False), ("computed", style, shown)):
            top.append(Line(f, test[key].values / unit.metres, look, name, listed=own))
            if np.isfinite(test["measured_phase"].values).any():
                bottom.append(Line(f, test[f"{key}_phase"].values, look, name, listed=own))
    size = Axis(
        f"{quantity} per force", unit.name, log=spans(dataset["measured"].values[np.isfinite(dataset["measured"].values)], 8.0)
    )
    panels = [Panel(HERTZ, size, top, height=3.2)]
    panels += [Panel(HERTZ, Axis("phase", "°"), bottom, height=1.9)] if bottom else []
    title = "Measured responses (dots), those between the bounds nearest to them (lines), bounds (areas)"
    if "lower" not in dataset:
        title = "Measured (dots) and computed (lines) responses"
    return Chart(title, panels, shared_x=True)


@FIGURES.of("ResponseIdentification", "misfits")
def misfits(dataset: xr.Dataset) -> Chart:
    """Misfit of each test, and what the others predict of it where tests were left out."""
    names = {float(t): str(name) for t, name in enumerate(dataset["test"].values)}
    places = np.arange(len(names), dtype=float)
    shown = [("misfit", "fitted", 0)]
    if np.isfinite(dataset["held_out"].values).any():
        shown.append(("held_out", "predicted by the other tests", 1))
    width = 0.8 / len(shown)
    across: dict[str, Any] = {"width": 0.9 * width, "horizontal": True}
    layers: list[Layer] = [
        Bars(places + (k - 0.5 * (len(shown) - 1)) * width, 100.0 * dataset[key].values, contact(k), label, **across)
        for key, label, k in shown
    ]
    axes = Axis("misfit relative to the largest response", "%"), Axis("", names=names, upside_down=True)
    return Chart("Misfit of each test", [Panel(*axes, layers, height=0.8 + 0.3 * len(names))])


@FIGURES.of("ResponseIdentification", "intervals")
def intervals(dataset: xr.Dataset) -> Chart:
    """95 % intervals of the parameters, relative to their values."""
    names = {float(k): str(name) for k, name in enumerate(dataset["parameter"].values)}
    value = np.abs(dataset["value"].values)
    low, high = (
        100.0 * (dataset[key].values - dataset["value"].values) / np.where(value > 0.0, value, 1.0) for key in ("low", "high")
    )
    places = np.arange(len(names), dtype=float)
    bars = Bars(places, high - low, Style("contact 0"), "95 % interval", base=low, horizontal=True)
    axes = Axis("distance from the value", "%"), Axis("", names=names, upside_down=True)
    return Chart("Intervals of the parameters", [Panel(*axes, [bars], height=0.6 + 0.3 * len(names))])
