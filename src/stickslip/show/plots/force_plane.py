"""Plane of tangential forces of a damper: static limit lines, and the paths of the forces at both bounds."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.damper_alone.force_plane import ForcePlane
from stickslip.show.plots.bound_cycles import BOUNDS
from stickslip.show.plots.chart import Area, Axis, Chart, Layer, Line, Panel, closed
from stickslip.show.plots.cycles import Cycles, bound_cycles
from stickslip.show.plots.look import Style
from stickslip.support.checks import Array
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

SLIPPING = 1.0 - 1e-6
"""Share of its own limit μN at which a side slips."""


@FIGURES.of("ResponseBounds", "force_plane")
def force_plane(
    dataset: xr.Dataset, plane: ForcePlane, case: int = 0, frequency: float | None = None, summed: bool = False
) -> Chart:
    """T of one side of a damper against T of the other at both bounds; dots: where a side slips; grey: the limit lines.

    Slip off the lines and forces beyond them are what the static picture leaves out: inertia, other springs, rotation, lift-off.
    """
    cycles = bound_cycles(dataset, case, frequency, summed)
    paths = paths_in(cycles, plane)
    reach = 1.15 * max(float(np.abs(paths).max()), float(np.abs(plane.corners()).max()))
    layers: list[Layer] = []
    for side, sense in ((0, -1), (0, 1), (1, -1), (1, 1)):
        x, y = plane.limit(side, sense, np.array([-reach, reach])).T
        layers.append(Line(x, y, Style("grey", width=0.9), "a side slips, statically"))
    x, y = plane.corners().T
    layers.append(Area(x, y, Style("grey", opacity=0.12), "both stick, statically"))
    for k, (word, style) in enumerate(BOUNDS):
        path, label = paths[k], f"{word} bound"
        layers.append(Line(closed(path[:, 0]), closed(path[:, 1]), style, label))
        slipping, dots = path[slips(cycles, plane, k)], replace(style, dash="none", marker="circle")
        layers.append(Line(slipping[:, 0], slipping[:, 1], dots, label, listed=False))
    left, right = (Axis(f"tangential force of {side}", "N", limits=(-reach, reach)) for side in plane.sides)
    title = f"Tangential forces of both sides, force {float(dataset['force_level'][case]):g}"
    return Chart(title, [Panel(left, right, layers, height=4.0, equal=True)])


def paths_in(cycles: Cycles, plane: ForcePlane) -> Array:
    """Tangential forces of both sides over the period, (curve, sample, 2)."""
    return np.stack([cycles.force[:, cycles.row(f"{side} t1")] for side in plane.sides], axis=-1)


def slips(cycles: Cycles, plane: ForcePlane, curve: int) -> Array:
    """Where a side of a curve has reached its own limit μN, (sample,)."""
    loads = np.stack([cycles.force[curve, cycles.row(f"{side} n")] for side in plane.sides], axis=-1)
    reached = np.abs(paths_in(cycles, plane)[curve]) >= SLIPPING * plane.friction * loads
    return np.asarray(np.any(reached, axis=-1))
