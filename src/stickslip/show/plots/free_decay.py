"""Free decay: the motion over time, and frequency and damping over the amplitude of the half cycles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import unit_for
from stickslip.show.plots.chart import Axis, Chart, Line, Panel
from stickslip.show.plots.look import Dash, Style, level
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

HEIGHT = 2.9

MODE_DASHES: tuple[Dash, ...] = ("dash", "dot", "dashdot")
"""Of nonlinear modes."""


@FIGURES.of("FreeDecay")
def decay(dataset: xr.Dataset) -> Chart:
    """Displacement of the outputs against time; frequency and damping ratio of each half cycle against its amplitude, beside
    those of nonlinear modes (dashed) where there are any."""
    names = [str(name) for name in dataset["output"].values]
    unit = unit_for(float(np.abs(dataset["displacement"].values).max(initial=0.0)))
    milliseconds, amplitude = 1e3 * dataset["time"].values, dataset["amplitude"].values / unit.metres

    def lines(name: str, factor: float) -> list[Line]:
        values = factor * dataset[name].values
        found = [Line(amplitude[k], values[k], level(k, len(names)), each) for k, each in enumerate(names)]
        for mode in range(dataset.sizes.get("mode", 0)):
            x, y = dataset["mode_amplitude"].values[mode, :, 0] / unit.metres, factor * dataset[f"mode_{name}"].values[mode]
            label = f"nonlinear mode {int(dataset['mode'].values[mode])}"
            found.append(Line(x, y, Style("ink", MODE_DASHES[mode % len(MODE_DASHES)], 1.1), label))
        return found

    motion = [
        Line(milliseconds, dataset["displacement"].values[k] / unit.metres, level(k, len(names)), each)
        for k, each in enumerate(names)
    ]
    panels = [
        Panel(Axis("time", "ms"), Axis("displacement", unit.name), motion, "Outputs", HEIGHT),
        Panel(Axis("amplitude", unit.name), Axis("frequency", "Hz"), lines("frequency", 1.0), "Half cycles", HEIGHT),
        Panel(Axis("amplitude", unit.name), Axis("damping ratio", "%"), lines("damping_ratio", 100.0), "Half cycles", HEIGHT),
    ]
    return Chart(f"{dataset.attrs['title']}: free decay", panels, columns=3)
