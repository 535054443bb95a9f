"""Free decay: the motion over time, and frequency and damping over the amplitude of the half cycles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import shown_unit, unit_for
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, band
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
        found += _modes(dataset, name, unit.metres, factor)
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


def _modes(dataset: xr.Dataset, name: str, metres: float, factor: float) -> list[Line]:
    """Frequency or damping ratio of the nonlinear modes beside a decay, over the amplitude of the first output, and the frequency
    of a phase resonance test."""
    lines = []
    for mode in range(dataset.sizes.get("mode", 0)):
        x, y = dataset["mode_amplitude"].values[mode, :, 0] / metres, factor * dataset[f"mode_{name}"].values[mode]
        look = Style("ink", MODE_DASHES[mode % len(MODE_DASHES)], 1.1)
        lines.append(Line(x, y, look, f"nonlinear mode {int(dataset['mode'].values[mode])}"))
    if name == "frequency" and "resonance_amplitude" in dataset:
        x, y = dataset["resonance_amplitude"].values / metres, factor * dataset["resonance_frequency"].values
        known = np.isfinite(x) & np.isfinite(y)
        lines.append(
            Line(x[known], y[known], Style("ink", "none", 1.1, marker="circle", size=3.0), "force and displacement at 90°")
        )
    return lines


@FIGURES.of("MeasuredDecay")
def measured(dataset: xr.Dataset) -> Chart:
    """The measured signal against time; frequency and damping ratio of its windows against the amplitude, with areas of two
    standard errors to either side."""
    unit = unit_for(float(dataset["amplitude"].values.max(initial=0.0)))
    quantity = str(dataset.attrs["quantity"])
    own = unit if quantity == "displacement" else shown_unit(dataset["signal"].attrs["units"], 1.0)
    amplitude, style = dataset["amplitude"].values / unit.metres, level(0, 1)

    def along(name: str, factor: float) -> list[Layer]:
        values, error = factor * dataset[name].values, 2.0 * factor * dataset[f"{name}_error"].values
        area = band(amplitude, values - error, values + error, level(0, 1, opacity=0.25), "two standard errors")
        return [area, Line(amplitude, values, style, "measured"), *_modes(dataset, name, unit.metres, factor)]

    signal = Line(1e3 * dataset["time"].values, dataset["signal"].values / own.metres, style, "measured")
    across = Axis("amplitude", unit.name)
    panels = [
        Panel(Axis("time", "ms"), Axis(quantity, own.name), [signal], "Signal", HEIGHT),
        Panel(across, Axis("frequency", "Hz"), along("frequency", 1.0), "Windows", HEIGHT),
        Panel(across, Axis("damping ratio", "%"), along("damping_ratio", 100.0), "Windows", HEIGHT),
    ]
    return Chart(str(dataset.attrs["title"]), panels, columns=3)
