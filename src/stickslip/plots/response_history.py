"""Contact forces of runs at one force level before and after a passage through others, and what the runs' peaks do."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.checks import fault
from stickslip.plots.look import house_style, level_colours, plain

if TYPE_CHECKING:
    import xarray as xr

MOST_ROWS = 8


def before_and_after(dataset: xr.Dataset, level: float | None = None) -> Figure:
    """Contact forces over a cycle at the largest point of every run at a level: of the rows that change most.

    level: the one repeated level at which the mean forces change most, unless given.
    """
    levels = dataset["force_level"].values
    forces = dataset["largest_contact_force"].values
    repeated = [float(value) for value in np.unique(levels) if np.count_nonzero(levels == value) > 1]
    if level is None and repeated:
        level = max(repeated, key=lambda value: float(np.ptp(forces[levels == value].mean(axis=-1), axis=0).max()))
    runs = np.flatnonzero(np.isclose(levels, np.nan if level is None else level))
    if runs.size < 2:
        raise fault("level", f"must be run more than once, as {repeated} are", level)
    change = np.ptp(forces[runs].mean(axis=-1), axis=0)
    rows = sorted(np.argsort(-change, kind="stable")[:MOST_ROWS].tolist())
    phase = np.arange(forces.shape[-1]) / forces.shape[-1]
    with house_style():
        figure = Figure(figsize=(7.6, 0.8 + 1.6 * ((len(rows) + 1) // 2)), layout="constrained")
        panels = figure.subplots((len(rows) + 1) // 2, 2, squeeze=False).ravel()
        for axes, row in zip(panels, rows, strict=False):
            for run, colour in zip(runs, level_colours(runs.size), strict=True):
                hertz = float(dataset["largest_frequency"].values[run, 0])
                axes.plot(phase, forces[run, row], color=colour, label=f"run {run + 1}, {hertz:.1f} Hz")
            axes.set_title(plain(str(dataset["row"].values[row])), fontsize=9)
        panels[0].legend(fontsize=7)
        figure.supxlabel("share of the period", fontsize=9.5)
        figure.supylabel("contact force in N", fontsize=9.5)
        title = f"One force, {level:g}, before and after others: {dataset.attrs['title']}"
        figure.suptitle(plain(title), x=0.01, ha="left", fontweight="bold", fontsize=10.5)
    return figure
