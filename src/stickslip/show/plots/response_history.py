"""Contact forces and peaks of runs at one force level before and after a passage through other levels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.show.plots.bound_cycles import MOST_ROWS, PERIOD
from stickslip.show.plots.chart import Axis, Chart, Line, Panel
from stickslip.show.plots.cycles import run_cycles
from stickslip.show.plots.look import level_lines
from stickslip.support.checks import Index, fault
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


@FIGURES.of("ResponseHistory")
def before_and_after(dataset: xr.Dataset, level: float | None = None, summed: bool = False) -> Chart:
    """Contact forces over a cycle at the largest point of every run at a level: of the rows that change most.

    level: the one repeated level at which the mean forces change most, unless given; summed: over the points of a surface.
    """
    runs = repeated_runs(dataset, level)
    cycles = run_cycles(dataset, runs, summed)
    change = np.ptp(cycles.force.mean(axis=-1), axis=0)
    rows = sorted(np.argsort(-change, kind="stable")[:MOST_ROWS].tolist())
    hertz = dataset["largest_frequency"].values[runs, 0]
    names = [f"run {run + 1}, {at:.1f} Hz" for run, at in zip(runs, hertz, strict=True)]
    panels = []
    for row in rows:
        lines = [Line(cycles.phase, cycles.force[k, row], **look) for k, look in enumerate(level_lines(names))]
        panels.append(Panel(PERIOD, Axis("contact force", "N"), lines, cycles.rows[row], 1.7))
    level = float(dataset["force_level"].values[runs[0]])
    return Chart(f"One force, {level:g}, before and after others: {dataset.attrs['title']}", panels, columns=2)


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
