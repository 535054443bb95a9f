"""Contact forces and peaks of runs at one force level before and after a passage through other levels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.checks import Index, fault
from stickslip.plots.bound_cycles import panels
from stickslip.plots.cycles import run_cycles
from stickslip.plots.look import house_style, legend, level_colours, plain

if TYPE_CHECKING:
    import xarray as xr

MOST_ROWS = 8


def before_and_after(dataset: xr.Dataset, level: float | None = None, summed: bool = False) -> Figure:
    """Contact forces over a cycle at the largest point of every run at a level: of the rows that change most.

    level: the one repeated level at which the mean forces change most, unless given; summed: over the points of a surface.
    """
    runs = repeated_runs(dataset, level)
    found = run_cycles(dataset, runs, summed)
    change = np.ptp(found.force.mean(axis=-1), axis=0)
    rows = sorted(np.argsort(-change, kind="stable")[:MOST_ROWS].tolist())
    with house_style():
        figure = panels(len(rows), "share of the period", "contact force in N")
        for axes, row in zip(figure.axes, rows, strict=False):
            for k, (run, colour) in enumerate(zip(runs, level_colours(runs.size), strict=True)):
                hertz = float(dataset["largest_frequency"].values[run, 0])
                axes.plot(found.phase, found.force[k, row], color=colour, label=f"run {run + 1}, {hertz:.1f} Hz")
            axes.set_title(plain(found.rows[row]), fontsize=9)
        legend(figure.axes[0], fontsize=7)
        level = float(dataset["force_level"].values[runs[0]])
        title = f"One force, {level:g}, before and after others: {dataset.attrs['title']}"
        figure.suptitle(plain(title), x=0.01, ha="left", fontweight="bold", fontsize=10.5)
    return figure


def repeated_runs(dataset: xr.Dataset, level: float | None = None) -> Index:
    """The runs at a level; of the repeated level at which the mean forces change most, unless given."""
    levels, forces = dataset["force_level"].values, dataset["largest_contact_force"].values
    repeated = [float(value) for value in np.unique(levels) if np.count_nonzero(levels == value) > 1]
    if level is None and repeated:
        level = max(repeated, key=lambda value: float(np.ptp(forces[levels == value].mean(axis=-1), axis=0).max()))
    runs = np.flatnonzero(np.isclose(levels, np.nan if level is None else level))
    if runs.size < 2:
        raise fault("level", f"must be run more than once, as {repeated} are", level)
    return np.asarray(runs, dtype=np.int64)
