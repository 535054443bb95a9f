"""Several cycles of one damper side by side: hysteresis loops, energy and rotation by cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from stickslip.checks import counted
from stickslip.plots.damper_cycle import closed
from stickslip.plots.look import STICK, house_style, legend, plain
from stickslip.results.representative import spread
from stickslip.units import um

if TYPE_CHECKING:
    import xarray as xr

MOST_NAMES = 16
"""Cycles named below the bars; of more, evenly spread ones."""


def damper_cycles(dataset: xr.Dataset) -> Figure:
    """Loops in the direction that moves most, dark to light in the order of the cycles; then energy and rotation of each."""
    with house_style():
        figure = Figure(figsize=(10.5, 3.6), layout="constrained")
        loops, energy, rotation = figure.subplots(1, 3)
        _loops(loops, dataset)
        _bars(energy, dataset, 1e6 * dataset.loop_energy.values, "energy of a cycle in µJ")
        _bars(rotation, dataset, 1e3 * dataset.rotation.values, "rotation in mrad, peak to peak")
        figure.suptitle(plain(str(dataset.attrs["title"])), x=0.01, ha="left", fontweight="bold", fontsize=10.5)
    return figure


def cycle_names(dataset: xr.Dataset) -> list[str]:
    """What distinguishes the cycles: how many starts lead to each, or its friction."""
    if "starts" in dataset:
        return [counted(int(count), "start") for count in dataset.starts.values]
    return [", ".join(f"{mu:g}" for mu in dict.fromkeys(row)) for row in dataset.friction.values]


def _numbered(dataset: xr.Dataset) -> list[str]:
    """The number of each cycle and what distinguishes it: the same names as below the bars."""
    return [plain(f"{number}: {name}") for number, name in zip(dataset.cycle.values, cycle_names(dataset), strict=True)]


def _loops(axes: Any, dataset: xr.Dataset) -> None:
    motion, force = dataset.platform_motion.values, dataset.force_on_right.values
    axis = int(np.argmax(np.ptp(motion[0], axis=0)))
    shades = colormaps["viridis"](np.linspace(0.0, 0.85, len(motion)))
    names = _numbered(dataset)
    for x, f, shade, name in zip(motion[..., axis], force[..., axis], shades, names, strict=True):
        axes.plot(closed(x) / um, closed(f), color=shade, linewidth=1.2, label=name)
    legend(axes)
    direction = ("horizontal", "vertical")[axis]
    axes.set(title="Platform to platform", xlabel=f"{direction} motion in µm", ylabel=f"{direction} force in N")


def _bars(axes: Any, dataset: xr.Dataset, values: np.ndarray[Any, Any], words: str) -> None:
    names = _numbered(dataset)
    axes.bar(range(len(names)), values, color=STICK)
    named = spread(len(names), MOST_NAMES)
    axes.set_xticks(named, [names[place] for place in named], rotation=60, ha="right")
    axes.set(title=words)
