"""Several cycles of one damper side by side: hysteresis loops, energy and rotation by cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.representative import spread
from stickslip.show.plots.chart import Axis, Bars, Chart, Line, Panel
from stickslip.show.plots.damper_cycle import closed
from stickslip.show.plots.look import Style, entries, level
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
    energy = _bars(dataset, 1e6 * dataset.loop_energy.values, Axis("energy of a cycle", "µJ"))
    rotation = _bars(dataset, 1e3 * dataset.rotation.values, Axis("rotation, peak to peak", "mrad"))
    return Chart(str(dataset.attrs["title"]), [_loops(dataset), energy, rotation], columns=3)


def cycle_names(dataset: xr.Dataset) -> list[str]:
    """What distinguishes the cycles: how many starts lead to each, or its friction."""
    if "starts" in dataset:
        return [counted(int(count), "start") for count in dataset.starts.values]
    return [f"µ = {', '.join(f'{mu:g}' for mu in dict.fromkeys(row))}" for row in dataset.friction.values]


def _numbered(dataset: xr.Dataset) -> list[str]:
    """The number of each cycle, which stands below its bars, and what distinguishes it."""
    return [f"{number}: {name}" for number, name in zip(dataset.cycle.values, cycle_names(dataset), strict=True)]


def _loops(dataset: xr.Dataset) -> Panel:
    motion, force, names = dataset.platform_motion.values, dataset.force_on_right.values, _numbered(dataset)
    axis = int(np.argmax(np.ptp(motion[0], axis=0)))
    listed = entries(names)
    layers = [
        Line(closed(x) / um, closed(f), level(k, len(names), width=1.3), name, listed=name in listed)
        for k, (x, f, name) in enumerate(zip(motion[..., axis], force[..., axis], names, strict=True))
    ]
    direction = ("horizontal", "vertical")[axis]
    return Panel(Axis(f"{direction} motion", "µm"), Axis(f"{direction} force", "N"), layers, "Platform to platform", HEIGHT)


def _bars(dataset: xr.Dataset, values: Array, axis: Axis) -> Panel:
    numbers = dataset.cycle.values
    across = Axis("cycle", names={float(place): str(numbers[place]) for place in spread(numbers.size, MOST_NAMES)})
    return Panel(across, axis, [Bars(np.arange(numbers.size), values, Style("stick"))], height=HEIGHT)
