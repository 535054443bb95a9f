"""Stepped sine in time: the amplitude at the end of each dwell, and how far it is from the steady motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import unit_for
from stickslip.show.plots.chart import Axis, Chart, Line, Panel
from stickslip.show.plots.look import entries, level
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


@FIGURES.of("SteppedSine")
def stepped_sine(dataset: xr.Dataset) -> Chart:
    """Amplitude of the outputs over the frequency of the dwells, in their order, beside that of the harmonic balance (dashed)
    where there is one; and the distance from the steady motion."""
    names = [str(name) for name in dataset["output"].values]
    unit, f, listed = unit_for(float(dataset["amplitude"].values.max())), dataset["frequency"].values, entries(names)
    shown = [(k, name) for k, name in enumerate(names) if name in listed]

    def lines(key: str, **more: str | float) -> list[Line]:
        after = "" if key == "amplitude" else ", harmonic balance"
        values = dataset[key].values / unit.metres
        return [Line(f, values[:, k], level(k, len(names), **more), name + after) for k, name in shown]

    sizes = lines("balance_amplitude", dash="dash", width=1.1) if "balance_amplitude" in dataset else []
    distance = np.where(np.isfinite(dataset["distance"].values), dataset["distance"].values, np.nan)
    apart = Line(f, distance, level(0, 1, marker="circle", size=2.5))
    amplitude = Axis("amplitude at the end of the dwell", unit.name)
    panels = [
        Panel(HERTZ, amplitude, [*sizes, *lines("amplitude", marker="circle", size=2.5)], height=2.9),
        Panel(HERTZ, Axis("distance from the steady motion", log=True), [apart], height=1.9),
    ]
    return Chart(f"{dataset.attrs['title']}: stepped sine, {int(dataset.attrs['dwell'])} periods a step", panels, shared_x=True)
