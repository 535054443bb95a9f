"""Nonlinear modes: natural frequency and damping ratio over amplitude or energy, peaks over the force, and what contacts do;
limit cycles over the aerodynamic damping."""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.results.view import energy_unit, length_unit, spread, unit_for
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, Rule, from_zero
from stickslip.show.plots.look import CONTACTS, MOST_ENTRIES, MOST_PANELS, STUCK, contact, level_lines
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.checks import Array
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES


@FIGURES.of("NonlinearModes")
def over_amplitude(dataset: xr.Dataset, output: int = 0) -> Chart:
    """Natural frequency and damping ratio over the amplitude of an output, a curve a mode; dashed: stuck contacts."""
    unit = length_unit(dataset)
    name = str(dataset["output"].values[output])
    across = Axis(f"amplitude of {name}", unit.name, log=_any(dataset, "amplitude"))
    return _over(dataset, dataset["amplitude"].values[..., output] / unit.metres, across)


@FIGURES.of("NonlinearModes", "energy")
def over_energy(dataset: xr.Dataset) -> Chart:
    """Natural frequency and damping ratio over the mechanical energy, a curve a mode; dashed: stuck contacts."""
    joules, unit = energy_unit(float(np.max(np.nan_to_num(dataset["energy"].values), initial=0.0)))
    across = Axis("mechanical energy", unit, log=_any(dataset, "energy"))
    return _over(dataset, dataset["energy"].values / joules, across)


@FIGURES.of("NonlinearModes", "peaks")
def peaks_over_force(dataset: xr.Dataset, output: int = 0) -> Chart:
    """Amplitude and frequency of the resonance peak over the force level, from each mode; dots: the force levels asked for."""
    unit = length_unit(dataset)
    levels = dataset["peak_force_level"].values
    heights = dataset["peak_amplitude"].values[..., output] / unit.metres
    top, bottom = [], []
    for case, look in enumerate(_looks(dataset)):
        top.append(Line(levels[case], heights[case], **look))
        bottom.append(Line(levels[case], dataset["peak_frequency"].values[case], **look))
    if "force_level" in dataset.dims and output == 0:
        asked = dataset["force_level"].values
        for case, look in enumerate(_looks(dataset, marker="circle", dash="none")):
            look |= {"listed": False}
            top.append(Line(asked, dataset["level_amplitude"].values[case] / unit.metres, **look))
            bottom.append(Line(asked, dataset["level_frequency"].values[case], **look))
    force = Axis("force level", log=_any(dataset, "peak_force_level"))
    name = str(dataset["output"].values[output])
    sizes = Axis(f"peak amplitude of {name}", unit.name, log=_any(dataset, "peak_amplitude"))
    panels = [Panel(force, sizes, top, height=2.9), Panel(force, HERTZ, bottom, height=2.1)]
    return Chart("Resonance peaks from the mode", panels, shared_x=True)


@FIGURES.of("NonlinearModes", "shape")
def shape(dataset: xr.Dataset) -> Chart:
    """How far a mode leaves the shape of the stuck one: energy in other stuck modes at the first harmonic, and above it."""
    unit = length_unit(dataset)
    across = Axis(f"amplitude of {dataset['output'].values[0]}", unit.name, log=_any(dataset, "amplitude"))
    words = {"other_modes": "in other stuck modes", "higher_harmonics": "in higher harmonics"}
    panels = []
    for name, title in words.items():
        lines = [
            Line(dataset["amplitude"].values[case, :, 0] / unit.metres, 100.0 * dataset[name].values[case], **look)
            for case, look in enumerate(_looks(dataset))
        ]
        panels.append(Panel(across, from_zero(Axis("share of the energy", "%")), lines, f"Energy {title}", 2.3))
    return Chart("Shape of the mode", panels, shared_x=True)


@FIGURES.of("NonlinearModes", "states")
def contact_states(dataset: xr.Dataset) -> Chart:
    """Share of the period in which contacts slip and, dashed, are open, over the amplitude of the first output; of more contacts
    than colours those that dissipate most."""
    unit = length_unit(dataset)
    across = Axis(f"amplitude of {dataset['output'].values[0]}", unit.name, log=_any(dataset, "amplitude"))
    energy = np.nansum(dataset["dissipated"].values, axis=(0, 1))
    chosen = np.sort(np.argsort(-energy, kind="stable")[: len(CONTACTS) - 1])
    panels = []
    for case in spread(dataset.sizes["case"], MOST_PANELS):
        x = dataset["amplitude"].values[case, :, 0] / unit.metres
        layers: list[Layer] = []
        for k, c in enumerate(chosen):
            name = str(dataset["contact"].values[c])
            slip, opened = (_largest(dataset[f"share_{state}"].values[case, :, c]) for state in ("slip", "open"))
            layers.append(Line(x, 100.0 * slip, contact(k), name))
            if np.nanmax(opened, initial=0.0) > 0.0:
                layers.append(Line(x, 100.0 * opened, contact(k, dash="dash"), f"{name}, open"))
        title = f"mode {int(dataset['mode_number'].values[case])}" if dataset.sizes["case"] > 1 else ""
        panels.append(Panel(across, Axis("share of the period", "%", limits=(0.0, 100.0)), layers, title))
    note = f"{chosen.size} of {energy.size} contacts, those that dissipate most" if chosen.size < energy.size else ""
    return Chart("What contacts do", panels, note=note)


def _largest(shares: Array) -> Array:
    """The largest share over the directions of a contact, (points,); NaN at points that are not there."""
    there = np.isfinite(shares).any(axis=1)
    return np.asarray(np.where(there, np.max(np.nan_to_num(shares), axis=1), np.nan))


def _over(dataset: xr.Dataset, x: Array, across: Axis) -> Chart:
    """Frequency and damping ratio of every mode over x, (case, point)."""
    frequencies, ratios = dataset["frequency"].values, 100.0 * dataset["damping_ratio"].values
    top: list[Layer] = []
    bottom: list[Layer] = []
    for case, look in enumerate(_looks(dataset)):
        top.append(Line(x[case], frequencies[case], hover={"damping ratio in %": ratios[case]}, **look))
        bottom.append(Line(x[case], ratios[case], hover={"frequency in Hz": frequencies[case]}, **look))
    stuck = dataset["stuck_frequency"].values
    top += [Rule(float(value), STUCK, "stuck" if case == 0 else "", "y") for case, value in enumerate(stuck[:MOST_ENTRIES])]
    panels = [Panel(across, HERTZ, top, height=2.6), Panel(across, from_zero(Axis("damping ratio", "%")), bottom, height=2.6)]
    return Chart(str(dataset.attrs["title"]), panels, shared_x=True)


def _looks(dataset: xr.Dataset, **style: Any) -> list[dict[str, Any]]:
    """The lines of all modes."""
    return level_lines([f"mode {int(number)}" for number in dataset["mode_number"].values], **style)


def _any(dataset: xr.Dataset, name: str) -> bool:
    """Whether there is a positive number to draw over a logarithmic axis."""
    return bool(np.any(np.nan_to_num(dataset[name].values) > 0.0))


@FIGURES.of("LimitCycles")
def over_damping(dataset: xr.Dataset, output: int = 0) -> Chart:
    """Amplitude of the limit cycles of an output over the aerodynamic damping; dashed: unstable; dots: those asked for."""
    heights = dataset["curve_amplitude"].values[..., output]
    unit = unit_for(float(np.max(np.nan_to_num(heights), initial=0.0)))
    across = Axis(f"amplitude of {dataset['output'].values[output]}", unit.name, log=bool(np.any(np.nan_to_num(heights) > 0.0)))
    return _over_damping(dataset, heights / unit.metres, dataset["amplitude"].values[..., output] / unit.metres, across)


@FIGURES.of("LimitCycles", "frequency")
def frequency_over_damping(dataset: xr.Dataset) -> Chart:
    """Frequency of the limit cycles over the aerodynamic damping; dashed: unstable; dots: those asked for."""
    return _over_damping(dataset, dataset["curve_frequency"].values, dataset["frequency"].values, HERTZ)


def _over_damping(dataset: xr.Dataset, curve: Array, roots: Array, axis: Axis) -> Chart:
    """A quantity of the curves (case, point) and of the roots (case, aerodynamic_damping, limit_cycle)."""
    layers: list[Layer] = []
    x = -100.0 * dataset["curve_damping"].values
    stable = dataset["curve_stable"].values
    modes = [f"mode {int(number)}" for number in dataset["mode_number"].values]
    hover = {"frequency in Hz": dataset["curve_frequency"].values, "energy in J": dataset["curve_energy"].values}
    for style, other, listed in (({}, 0.0, True), ({"dash": "dash"}, 1.0, False)):
        for case, look in enumerate(level_lines(modes, **style)):
            shown, known = np.where(stable[case] == other, np.nan, curve[case]), {key: hover[key][case] for key in hover}
            layers.append(Line(x[case], shown, hover=known, **look | {"listed": look["listed"] and listed}))
    for case, look in enumerate(level_lines(modes, marker="circle", dash="none")):
        values = roots[case]
        ratios = np.broadcast_to(100.0 * dataset["aerodynamic_damping"].values[:, None], values.shape)
        there = np.isfinite(values)
        if there.any():
            layers.append(Line(ratios[there], values[there], **look | {"listed": False}))
    panel = Panel(Axis("aerodynamic damping ratio", "%"), axis, layers)
    return Chart(str(dataset.attrs["title"]), [panel], note="dashed: unstable")
