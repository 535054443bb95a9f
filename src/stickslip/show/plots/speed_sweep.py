"""Responses over the rotor speed: the curves of each engine order with their peaks, the Campbell diagram, a run-up in time."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from stickslip.results.quantities import UNSTABLE
from stickslip.results.view import Length, level_text, split, unit_for
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, Rule
from stickslip.show.plots.look import Style, contact, level, level_lines
from stickslip.show.plots.response_curves import LINEAR, height_limits
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome
from stickslip.support.renderers import FIGURES

SPEED = Axis("rotor speed", "rev/min")


@FIGURES.of("SpeedSweep")
def over_speed(dataset: "xr.Dataset", output: int = 0, log: bool = True) -> Chart:
    """Amplitude of an output over the speed; grey: linear, without contacts (dotted) and all stuck (dashed), at the first level;
    dots: highest peaks; dashed: unstable; of several engine orders the envelope as a wide pale line."""
    unit = unit_for(float(np.nanmax(dataset["amplitude"].values[..., output], initial=0.0)))
    orders = dataset["engine_order"].values.tolist()
    curves = [(e, case) for e in range(len(orders)) for case in range(dataset.sizes["case"])]
    labels = [f"engine order {orders[e]}, {level_text(dataset, case)}" for e, case in curves]
    looks = dict(zip(curves, level_lines(labels), strict=True))
    layers: list[Layer] = []
    if dataset.sizes["engine_order"] > 1:
        for case in range(dataset.sizes["case"]):
            values = dataset["envelope"].values[case, :, output] / unit.metres
            style = Style("grey", width=5.0, opacity=0.25)
            layers.append(Line(dataset["envelope_speed"].values, values, style, "envelope", listed=case == 0))
    for e in range(dataset.sizes["engine_order"]):
        at = f", {level_text(dataset, 0)}" if dataset.sizes["case"] > 1 else ""
        for name, (words, style) in LINEAR.items():
            values = dataset[f"{name}_amplitude"].values[e, 0, :, output] / unit.metres
            look = replace(style, colour="grey", opacity=0.6)
            layers.append(Line(dataset["linear_speed"].values[e], values, look, f"{words}{at}", listed=e == 0))
        for case in range(dataset.sizes["case"]):
            layers += _curve(dataset, (e, case), output, unit, looks[e, case])
    nonlinear = [layer for layer in layers if isinstance(layer, Line) and layer.style.colour != "grey"]
    limits = height_limits(nonlinear, log) if log else (None, None)
    axis = Axis(f"amplitude of {dataset['output'].values[output]}", unit.name, log=log, limits=limits)
    return Chart(
        str(dataset.attrs["title"]), [Panel(SPEED, axis, layers, height=4.1)], note="frequency = engine order × speed/60"
    )


def _curve(dataset: "xr.Dataset", place: tuple[int, int], output: int, unit: Length, look: dict[str, Any]) -> Iterator[Layer]:
    """One curve, its unstable parts dashed, and a dot at its highest peak."""
    solved = dataset["outcome"].values[place] == Outcome.CONVERGED
    speed, size = dataset["speed"].values[place][solved], dataset["amplitude"].values[place][solved, output] / unit.metres
    hover = {
        name: dataset[key].values[place][solved]
        for name, key in (("frequency in Hz", "frequency"), ("loss factor", "loss_factor"))
    }
    unstable = np.zeros(max(speed.size - 1, 0), dtype=bool)
    if "stability" in dataset:
        flags = dataset["stability"].values[place][solved] == UNSTABLE
        unstable = flags[1:] | flags[:-1]
    steady, other = split(size, unstable) if speed.size else (size, size)
    yield Line(speed, steady, **look, hover=hover)
    if unstable.any():
        yield Line(speed, other, replace(look["style"], dash="dash"), look["label"], hover, listed=False)
    if dataset.sizes["peak"]:
        top = dataset["peak_speed"].values[place][0, output], dataset["peak_amplitude"].values[place][0, output] / unit.metres
        style = replace(look["style"], dash="none", marker="circle", size=5.0)
        yield Line([top[0]], [top[1]], style, look["label"], {"": ["highest peak"]}, listed=False)


NEAREST = 8
"""Engine orders named in the interference diagram: those with the smallest margins."""


@FIGURES.of("Campbell")
def resonances(dataset: "xr.Dataset") -> Chart:
    """Free (dotted), stuck (solid) and nonlinear resonance (dashed) over the speed, engine-order lines, dots where they cross."""
    speeds, orders = dataset["speed"].values, dataset["engine_order"].values
    layers: list[Layer] = []
    for s, (state, dash) in enumerate({"free": "dot", "stuck": "solid", "nonlinear": "dash"}.items()):
        curves = dataset["frequency"].sel(state=state).values.reshape(-1, speeds.size)
        shown = np.unique(curves[np.isfinite(curves).any(axis=1)], axis=0)
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
    met = orders.max() * max(speeds[-1], dataset.attrs.get("operating_speed", 0.0)) / 60.0
    highest = 1.3 * min(float(np.nanmax(dataset["frequency"].values)), max(met, float(np.nanmin(dataset["frequency"].values))))
    axes = Axis("speed", "rev/min"), Axis("frequency", "Hz", limits=(0.0, highest))
    return Chart(str(dataset.attrs["title"]), [Panel(*axes, layers, height=3.9)])


@FIGURES.of("InterferenceDiagram")
def interference(dataset: "xr.Dataset") -> Chart:
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
    speed = float(dataset.attrs["operating_speed" if "operating_speed" in dataset.attrs else "speed"])
    folded = np.minimum(ends % sectors, -ends % sectors)
    layers.append(Line(folded, ends * speed / 60.0, Style("grey", width=1.0), f"excitation at {speed:g} rev/min"))
    margins = dataset["disk_margin"].sel(disk_state="stuck").values
    for place, o in enumerate(np.argsort(np.abs(margins))[:NEAREST]):
        order, dots = dataset.isel(engine_order=int(o)), level(place, NEAREST, marker="circle", dash="none", size=6.0)
        label = f"engine order {int(order['engine_order'])}: {100.0 * margins[o]:+.1f} %"
        layers.append(Line([int(order["excited_diameter"])], [float(order["excitation_frequency"])], dots, label))
    highest = 1.2 * max(float(dataset["excitation_frequency"].max()), float(np.nanmin(frequencies[1])))
    panel = Panel(Axis("nodal diameter"), Axis("frequency", "Hz", limits=(0.0, highest)), layers, height=4.2)
    return Chart(str(dataset.attrs["title"]), [panel], note="margins of the nearest stuck mode")


@FIGURES.of("RunUp")
def run_up(dataset: "xr.Dataset") -> Chart:
    """Amplitude of the first harmonic of every cycle over the speed, a curve for each output, engine order and force level."""
    unit = unit_for(float(np.nanmax(dataset["amplitude"].values, initial=0.0)))
    names, lines = [str(name) for name in dataset["output"].values], []
    for case in range(dataset.sizes["case"]):
        run = dataset.isel(case=case)
        hover = {"time in s": run["time"].values, "frequency in Hz": run["frequency"].values}
        label = f"engine order {int(run['engine_order'])}, {level_text(dataset, case)}"
        for k, name in enumerate(names):
            look, values = level(case * len(names) + k, dataset.sizes["case"] * len(names)), run["amplitude"].values[:, k]
            lines.append(Line(run["speed"].values, values / unit.metres, look, f"{name}, {label}", hover=hover))
    panel = Panel(SPEED, Axis("amplitude", unit.name), lines, height=4.1)
    return Chart(str(dataset.attrs["title"]), [panel], note=f"within {dataset.attrs['duration']:g} s")
