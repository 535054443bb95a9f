"""Plane of tangential forces of a damper: static limit lines, and the paths of the forces at both bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.analyses.damper_alone.force_plane import ForcePlane
from stickslip.checks import Array
from stickslip.plots.bound_cycles import BOUNDS
from stickslip.plots.cycles import Cycles, bound_cycles
from stickslip.plots.look import GREY, house_style, plain

if TYPE_CHECKING:
    import xarray as xr

SLIPPING = 1.0 - 1e-6
"""Share of its own limit μN at which a side slips."""


def force_plane(
    dataset: xr.Dataset, plane: ForcePlane, case: int = 0, frequency: float | None = None, summed: bool = False
) -> Figure:
    """T of one side of a damper against T of the other at both bounds; dots: where a side slips; grey: the limit lines.

    Slip off the lines and forces beyond them are what the static picture leaves out: inertia, other springs, rotation, lift-off.
    """
    found = bound_cycles(dataset, case, frequency, summed)
    paths = paths_in(found, plane)
    reach = 1.15 * max(float(np.abs(paths).max()), float(np.abs(plane.corners()).max()))
    with house_style():
        figure = Figure(figsize=(5.2, 4.6), layout="constrained")
        axes = figure.subplots()
        for side in (0, 1):
            for sense in (-1, 1):
                axes.plot(*plane.limit(side, sense, np.array([-reach, reach])).T, color=GREY, linewidth=0.9)
        axes.fill(*plane.corners().T, color=GREY, alpha=0.12, linewidth=0, label="both stick, statically")
        for k, (word, colour) in enumerate(BOUNDS):
            path = paths[k]
            axes.plot(*np.vstack([path, path[:1]]).T, color=colour, label=f"{word} bound")
            axes.plot(*path[slips(found, plane, k)].T, ".", color=colour, markersize=4)
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
        axes.set(xlabel=plain(f"T of {plane.sides[0]} in N"), ylabel=plain(f"T of {plane.sides[1]} in N"))
        axes.legend(fontsize=7)
        title = f"Tangential forces of both sides, force {float(dataset['force_level'][case]):g}"
        figure.suptitle(plain(title), x=0.01, ha="left", fontweight="bold", fontsize=10.5)
    return figure


def paths_in(found: Cycles, plane: ForcePlane) -> Array:
    """Tangential forces of both sides over the period, (curve, sample, 2)."""
    return np.stack([found.force[:, found.row(f"{side} t1")] for side in plane.sides], axis=-1)


def slips(found: Cycles, plane: ForcePlane, curve: int) -> Array:
    """Where a side of a curve has reached its own limit μN, (sample,)."""
    loads = np.stack([found.force[curve, found.row(f"{side} n")] for side in plane.sides], axis=-1)
    reached = np.abs(paths_in(found, plane)[curve]) >= SLIPPING * plane.friction * loads
    return np.asarray(np.any(reached, axis=-1))
