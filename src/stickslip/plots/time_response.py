"""Last period of a time integration: outputs over time, and loops of the contacts that move most."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.plots.look import CONTACTS, house_style, level_colours, plain

if TYPE_CHECKING:
    import xarray as xr

MOST_LOOPS = 7
"""Contact directions whose loops are drawn: those of the largest area, then of the largest motion."""


def last_period(dataset: xr.Dataset) -> Figure:
    """Displacement of the outputs against time, and contact force against displacement."""
    rows = widest_loops(dataset)
    with house_style():
        figure = Figure(figsize=(9.0 if rows else 5.0, 3.6), layout="constrained")
        panels = figure.subplots(1, 2 if rows else 1, squeeze=False)[0]
        _outputs(panels[0], dataset)
        if rows:
            _loops(panels[1], dataset, rows)
        frequency, level = dataset.attrs["frequency"], dataset.attrs["force_level"]
        where = f"{frequency:.5g} Hz, force level {level:g}"
        title = f"{dataset.attrs['title']} at {where}: last of {int(dataset['periods'])} periods"
        title += "" if dataset.attrs["outcome"] == "periodic" else f", {dataset.attrs['outcome'].replace('_', ' ')}"
        figure.suptitle(plain(title), x=0.01, ha="left", fontweight="bold", fontsize=10.5)
    return figure


def widest_loops(dataset: xr.Dataset) -> list[tuple[int, int]]:
    """(contact, direction) of the loops to draw, in the order of the contacts."""
    motion, force = dataset["motion_history"].values, dataset["force_history"].values
    size = np.nan_to_num(np.ptp(motion, axis=-1)) * np.nan_to_num(np.ptp(force, axis=-1))
    area = np.abs(np.nan_to_num(np.sum(force * np.roll(motion, -1, axis=-1) - np.roll(force, -1, axis=-1) * motion, axis=-1)))
    ranked = sorted(np.ndindex(size.shape), key=lambda place: (-area[place], -size[place]))
    return sorted(place for place in ranked[:MOST_LOOPS] if size[place] > 0.0)


def _outputs(axes: Axes, dataset: xr.Dataset) -> None:
    names = dataset["output"].values
    for k, (name, colour) in enumerate(zip(names, level_colours(len(names)), strict=True)):
        axes.plot(1e3 * dataset["time"].values, 1e6 * dataset["displacement"].values[k], color=colour, label=plain(name))
    axes.set(xlabel="time in ms", ylabel="displacement in µm", title="Outputs")
    axes.legend()


def _loops(axes: Axes, dataset: xr.Dataset, rows: list[tuple[int, int]]) -> None:
    for (contact, direction), colour in zip(rows, CONTACTS, strict=False):
        motion, force = (dataset[f"{name}_history"].values[contact, direction] for name in ("motion", "force"))
        label = f"{dataset['contact'].values[contact]}, {dataset['direction'].values[direction]}"
        axes.plot(1e6 * np.append(motion, motion[0]), np.append(force, force[0]), color=colour, label=plain(label))
    axes.set(xlabel="contact displacement in µm", ylabel="contact force in N", title="Contacts")
    axes.legend()
