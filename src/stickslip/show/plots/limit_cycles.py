"""Limit cycles: amplitude and frequency over the aerodynamic damping, up to where stable and unstable ones meet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import unit_for
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel
from stickslip.show.plots.look import level_lines
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.checks import Array
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


@FIGURES.of("LimitCycles")
def over_damping(dataset: xr.Dataset, output: int = 0) -> Chart:
    """Amplitude of the limit cycles of an output over the aerodynamic damping; dashed: unstable; dots: those asked for."""
    heights = dataset["curve_amplitude"].values[..., output]
    unit = unit_for(float(np.max(np.nan_to_num(heights), initial=0.0)))
    across = Axis(f"amplitude of {dataset['output'].values[output]}", unit.name, log=bool(np.any(np.nan_to_num(heights) > 0.0)))
    return _over(dataset, heights / unit.metres, dataset["amplitude"].values[..., output] / unit.metres, across)


@FIGURES.of("LimitCycles", "frequency")
def frequency_over_damping(dataset: xr.Dataset) -> Chart:
    """Frequency of the limit cycles over the aerodynamic damping; dashed: unstable; dots: those asked for."""
    return _over(dataset, dataset["curve_frequency"].values, dataset["frequency"].values, HERTZ)


def _over(dataset: xr.Dataset, curve: Array, roots: Array, axis: Axis) -> Chart:
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
