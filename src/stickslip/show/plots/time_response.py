"""Last period of a time integration: outputs over time, and loops of the contacts that move most."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.show.plots.chart import Axis, Chart, Line, Panel, closed
from stickslip.show.plots.look import contact, level
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

MOST_LOOPS = 7
"""Contact directions whose loops are drawn: those of the largest area, then of the largest motion."""
HEIGHT = 2.9


@FIGURES.of("TimeResponse")
def last_period(dataset: xr.Dataset) -> Chart:
    """Displacement of the outputs against time, and contact force against displacement."""
    names, milliseconds = [str(name) for name in dataset["output"].values], 1e3 * dataset["time"].values
    motions = [
        Line(milliseconds, 1e6 * dataset["displacement"].values[k], level(k, len(names)), name) for k, name in enumerate(names)
    ]
    panels = [Panel(Axis("time", "ms"), Axis("displacement", "µm"), motions, "Outputs", HEIGHT)]
    loops = []
    for k, (at, direction) in enumerate(widest_loops(dataset)):
        motion, force = (dataset[f"{name}_history"].values[at, direction] for name in ("motion", "force"))
        label = f"{dataset['contact'].values[at]}, {dataset['direction'].values[direction]}"
        loops.append(Line(1e6 * closed(motion), closed(force), contact(k), label))
    if loops:
        panels.append(Panel(Axis("contact displacement", "µm"), Axis("contact force", "N"), loops, "Contacts", HEIGHT))
    where = f"{dataset.attrs['frequency']:.5g} Hz, force level {dataset.attrs['force_level']:g}"
    title = f"{dataset.attrs['title']} at {where}: last of {int(dataset['periods'])} periods"
    title += "" if dataset.attrs["outcome"] == "periodic" else f", {dataset.attrs['outcome'].replace('_', ' ')}"
    return Chart(title, panels, columns=len(panels))


def widest_loops(dataset: xr.Dataset) -> list[tuple[int, int]]:
    """(contact, direction) of the loops to draw, in the order of the contacts."""
    motion, force = dataset["motion_history"].values, dataset["force_history"].values
    size = np.nan_to_num(np.ptp(motion, axis=-1)) * np.nan_to_num(np.ptp(force, axis=-1))
    area = np.abs(np.nan_to_num(np.sum(force * np.roll(motion, -1, axis=-1) - np.roll(force, -1, axis=-1) * motion, axis=-1)))
    ranked = sorted(np.ndindex(size.shape), key=lambda place: (-area[place], -size[place]))
    return sorted(place for place in ranked[:MOST_LOOPS] if size[place] > 0.0)
