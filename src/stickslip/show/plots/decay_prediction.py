"""Figure of a predicted decay: frequency and damping over the amplitude with their bands, and measured decays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.laboratory.identification.response.prediction_result import held_share
from stickslip.results.view import shown_unit
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, band
from stickslip.show.plots.free_decay import HEIGHT
from stickslip.show.plots.look import level
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


@FIGURES.of("DecayPrediction")
def predicted_decay(dataset: xr.Dataset) -> Chart:
    """The median of the draws (line) and the 95 % band (area) of frequency and damping ratio over the amplitude, and the
    windows of measured decays (dots)."""
    size = dataset["amplitude"].values
    unit, share = shown_unit("m", float(size.max()), dataset), f"{held_share(dataset):.0f} % interval"
    count = dataset.sizes.get("decay", 0)

    def along(key: str, factor: float) -> list[Layer]:
        low, middle, high = (factor * dataset[f"{key}{end}"].values for end in ("_low", "", "_high"))
        x = size / unit.metres
        layers: list[Layer] = [band(x, low, high, level(0, count + 1, opacity=0.25), share)]
        layers.append(Line(x, middle, level(0, count + 1), "predicted"))
        for t in range(count):
            one = dataset.isel(decay=t)
            dots = level(t + 1, count + 1, dash="none", marker="circle", size=2.5)
            at, values = one["measured_amplitude"].values / unit.metres, factor * one[f"measured_{key}"].values
            layers.append(Line(at[np.isfinite(at)], values[np.isfinite(at)], dots, str(one["decay"].values)))
        return layers

    across = Axis("amplitude", unit.name, log=True)
    panels = [
        Panel(across, Axis("frequency", "Hz"), along("frequency", 1.0), "Frequency", HEIGHT),
        Panel(across, Axis("damping ratio", "%"), along("damping_ratio", 100.0), "Damping", HEIGHT),
    ]
    return Chart(str(dataset.attrs["title"]), panels, columns=2)
