"""Several cycles of one damper side by side: hysteresis loops, energy and rotation by cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.representative import spread
from stickslip.show.plots.chart import Axis, Bars, Chart, Line, Panel
from stickslip.show.plots.damper_cycle import closed
from stickslip.show.plots.look import Style, level_lines
from stickslip.support.checks import Array, counted
from stickslip.support.renderers import FIGURES
from stickslip.support.units import um

if TYPE_CHECKING:
    import xarray as xr

MOST_NAMES = 16
"""Cycles named below the bars; of more, evenly spread ones."""
HEIGHT = 3.0


@FIGURES.of("SteadyCycles")
@FIGURES.of("DamperEvolution")
def damper_cycles(dataset: xr.Dataset) -> Chart:
    """Loops in the direction that moves most, dark to light in the order of the cycles; then energy and rotation of each."""
    axis = int(np.argmax(np.ptp(dataset.platform_motion.values[0], axis=0)))
    motion, force = dataset.platform_motion.values[..., axis], dataset.force_on_right.values[..., axis]
    # The number of each cycle stands below its bars too.
    names = [f"{number}: {name}" for number, name in zip(dataset.cycle.values, cycle_names(dataset), strict=True)]
    loops = [
        Line(closed(x) / um, closed(f), **look) for x, f, look in zip(motion, force, level_lines(names, width=1.3), strict=True)
    ]
    direction = ("horizontal", "vertical")[axis]
    axes = Axis(f"{direction} motion", "µm"), Axis(f"{direction} force", "N")
    energy = _bars(dataset, 1e6 * dataset.loop_energy.values, Axis("energy of a cycle", "µJ"))
    rotation = _bars(dataset, 1e3 * dataset.rotation.values, Axis("rotation, peak to peak", "mrad"))
    panels = [Panel(*axes, loops, "Platform to platform", HEIGHT), energy, rotation]
    return Chart(str(dataset.attrs["title"]), panels, columns=3)


def cycle_names(dataset: xr.Dataset) -> list[str]:
    """What distinguishes the cycles: how many starts lead to each, or its friction."""
    if "starts" in dataset:
        return [counted(int(count), "start") for count in dataset.starts.values]
    return [f"µ = {', '.join(f'{mu:g}' for mu in dict.fromkeys(row))}" for row in dataset.friction.values]


def _bars(dataset: xr.Dataset, values: Array, axis: Axis) -> Panel:
    numbers = dataset.cycle.values
    across = Axis("cycle", names={float(place): str(numbers[place]) for place in spread(numbers.size, MOST_NAMES)})
    return Panel(across, axis, [Bars(np.arange(numbers.size), values, Style("stick"))], height=HEIGHT)
