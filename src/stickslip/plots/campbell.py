"""Campbell diagram: frequencies over the rotor speed with engine-order lines and their crossings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.plots.chart import Axis, Chart, Layer, Line, Panel, Rule
from stickslip.plots.look import Style, contact, level

if TYPE_CHECKING:
    import xarray as xr

LOOKS = {"free": {"dash": "dot"}, "stuck": {}, "nonlinear": {"dash": "dash"}}


def over_speed(dataset: xr.Dataset) -> Chart:
    """Free (dotted), stuck (solid) and nonlinear resonance (dashed) over the speed, engine-order lines, dots where they cross."""
    speeds, orders = dataset["speed"].values, dataset["engine_order"].values
    layers: list[Layer] = []
    for s, (state, dash) in enumerate(LOOKS.items()):
        curves = dataset["frequency"].sel(state=state).values
        shown = np.unique(curves, axis=0) if np.isfinite(curves).all() else curves[np.isfinite(curves).any(axis=1)]
        layers += [Line(speeds, curve, contact(s, **dash), state, listed=k == 0) for k, curve in enumerate(shown)]
    for o, order in enumerate(orders.tolist()):
        style = level(o, orders.size, width=1.0)
        layers.append(Line(speeds, order * speeds / 60.0, style, f"engine order {order}"))
        one = dataset.isel(engine_order=o)
        met = np.isfinite(one["crossing_speed"].values)
        if met.any():
            dots = level(o, orders.size, marker="circle", dash="none")
            x, y = one["crossing_speed"].values[met], one["crossing_frequency"].values[met]
            layers.append(Line(x, y, dots, f"engine order {order}", listed=False))
    if "operating_speed" in dataset.attrs:
        layers.append(Rule(float(dataset.attrs["operating_speed"]), Style("grey", "dash", 1.0), "operating speed"))
    highest = 1.3 * float(np.nanmax(dataset["frequency"].values))
    axes = Axis("speed", "rev/min"), Axis("frequency", "Hz", limits=(0.0, highest))
    return Chart(str(dataset.attrs["title"]), [Panel(*axes, layers, height=3.9)], note=f"mode {dataset.attrs['mode']}")
