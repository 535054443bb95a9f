"""Run-up in time: amplitude of each cycle over the rotor speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import unit_for
from stickslip.show.plots.chart import Axis, Chart, Line, Panel
from stickslip.show.plots.look import level
from stickslip.show.plots.speed_sweep import SPEED
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


@FIGURES.of("RunUp")
def over_speed(dataset: xr.Dataset) -> Chart:
    """Amplitude of the first harmonic of every cycle over the speed, a curve for each output."""
    names, values = [str(name) for name in dataset["output"].values], dataset["amplitude"].values
    unit = unit_for(float(np.nanmax(values, initial=0.0)))
    hover = {"time in s": dataset["time"].values, "frequency in Hz": dataset["frequency"].values}
    lines = [
        Line(dataset["speed"].values, values[:, k] / unit.metres, level(k, len(names)), name, hover=hover)
        for k, name in enumerate(names)
    ]
    note = f"{dataset.attrs['duration']:g} s, engine order {dataset.attrs['engine_order']}"
    return Chart(str(dataset.attrs["title"]), [Panel(SPEED, Axis("amplitude", unit.name), lines, height=4.1)], note=note)
