"""Campbell diagram, frequencies over the rotor speed, and interference diagram, over the nodal diameter, with engine orders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, Rule
from stickslip.show.plots.look import Style, contact, level
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

NEAREST = 8
"""Engine orders named in the interference diagram: those with the smallest margins."""


@FIGURES.of("Campbell")
def over_speed(dataset: xr.Dataset) -> Chart:
    """Free (dotted), stuck (solid) and nonlinear resonance (dashed) over the speed, engine-order lines, dots where they cross."""
    speeds, orders = dataset["speed"].values, dataset["engine_order"].values
    layers: list[Layer] = []
    for s, (state, dash) in enumerate({"free": "dot", "stuck": "solid", "nonlinear": "dash"}.items()):
        curves = dataset["frequency"].sel(state=state).values
        shown = np.unique(curves, axis=0) if np.isfinite(curves).all() else curves[np.isfinite(curves).any(axis=1)]
        layers += [Line(speeds, curve, contact(s, dash=dash), state, listed=k == 0) for k, curve in enumerate(shown)]
    for o, order in enumerate(orders.tolist()):
        style = level(o, orders.size, width=1.0)
        layers.append(Line(speeds, order * speeds / 60.0, style, f"engine order {order}"))
        crossings = dataset.isel(engine_order=o)
        met = np.isfinite(crossings["crossing_speed"].values)
        if met.any():
            dots = level(o, orders.size, marker="circle", dash="none")
            x, y = crossings["crossing_speed"].values[met], crossings["crossing_frequency"].values[met]
            layers.append(Line(x, y, dots, f"engine order {order}", listed=False))
    if "operating_speed" in dataset.attrs:
        layers.append(Rule(float(dataset.attrs["operating_speed"]), Style("grey", "dash", 1.0), "operating speed"))
    highest = 1.3 * float(np.nanmax(dataset["frequency"].values))
    axes = Axis("speed", "rev/min"), Axis("frequency", "Hz", limits=(0.0, highest))
    return Chart(str(dataset.attrs["title"]), [Panel(*axes, layers, height=3.9)], note=f"mode {dataset.attrs['mode']}")


@FIGURES.of("InterferenceDiagram")
def interference(dataset: xr.Dataset) -> Chart:
    """Natural frequencies over the nodal diameter and the line of excitation EO Ω/60, folded at 0 and N/2; the engine orders of
    the smallest margins are named."""
    frequencies, sectors = dataset["disk_frequency"].values, int(dataset.attrs["sectors"])
    diameters = dataset["nodal_diameter"].values
    layers: list[Layer] = []
    for state, (label, dash) in enumerate((("without contacts", "dot"), ("contacts stuck", "solid"))):
        style = contact(state, dash=dash, marker="circle", width=1.0, size=3.5)
        layers += [Line(diameters, curve, style, label, listed=k == 0) for k, curve in enumerate(frequencies[state].T)]
    orders = np.arange(int(dataset["engine_order"].max()) + 1)
    turns = orders[(orders % sectors == 0) | (2 * orders % sectors == 0) | (orders == orders[-1])]
    ends = np.unique(np.concatenate([turns, 0.5 * sectors * np.arange(2 * int(orders[-1]) // sectors + 1)]))
    speed = float(dataset.attrs["speed"])
    folded = np.minimum(ends % sectors, -ends % sectors)
    layers.append(Line(folded, ends * speed / 60.0, Style("grey", width=1.0), f"excitation at {speed:g} rev/min"))
    margins = dataset["margin"].sel(state="stuck").values
    for place, o in enumerate(np.argsort(np.abs(margins))[:NEAREST]):
        order, dots = dataset.isel(engine_order=int(o)), level(place, NEAREST, marker="circle", dash="none", size=6.0)
        label = f"engine order {int(order['engine_order'])}: {100.0 * margins[o]:+.1f} %"
        layers.append(Line([int(order["excited_diameter"])], [float(order["excitation_frequency"])], dots, label))
    highest = 1.2 * max(float(dataset["excitation_frequency"].max()), float(np.nanmin(frequencies[1])))
    panel = Panel(Axis("nodal diameter"), Axis("frequency", "Hz", limits=(0.0, highest)), layers, height=4.2)
    return Chart(str(dataset.attrs["title"]), [panel], note="margins of the nearest stuck mode")
