"""Figures of a contact law from measured loops: loops and fit, parameters over the cycles, errors of the laws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.plots.look import CONTACTS, GREY, headed, house_style
from stickslip.results.representative import spread

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

MOST_LOOPS = 6
"""Loops in one figure."""

MANY_DECADES = 50.0
"""Ratio of cycle numbers from which their axis is logarithmic."""


def loops_and_fit(dataset: xr.Dataset) -> Figure:
    """Measured loops, dark, and those of the chosen law, orange."""
    names = dataset["loop"].values
    shown = names[spread(len(names), MOST_LOOPS)]
    columns = min(len(shown), 3)
    rows = -(-len(shown) // columns)
    with house_style():
        figure = Figure(figsize=(1.2 + 3.1 * columns, 0.6 + 2.7 * rows), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, name in zip(grid, shown, strict=False):
            one = dataset.sel(loop=name)
            u = 1e6 * one["displacement"].values
            for variable, label, colour, width in (
                ("force_measured", "measured", CONTACTS[0], 2.4),
                ("force_fitted", str(dataset.attrs["best"]), CONTACTS[1], 1.2),
            ):
                there = np.isfinite(u)
                axes.plot(_closed(u[there]), _closed(one[variable].values[there]), color=colour, linewidth=width, label=label)
            axes.set_title(str(name), fontsize=9, fontweight="normal")
            axes.set(xlabel="displacement in µm", ylabel="friction force in N")
        for axes in grid[len(shown) :]:
            axes.set_axis_off()
        grid[0].legend(loc="best")
        if len(shown) < len(names):
            headed(figure, "Loops", f"{len(shown)} of {len(names)}")
    return figure


def over_cycles(dataset: xr.Dataset) -> Figure:
    """kt, μ and energy against the cycle number, with bands of one standard deviation."""
    number = dataset["cycle_number"].values
    with house_style():
        figure = Figure(figsize=(7.2, 6.4), layout="constrained")
        stiffness, friction, energy = figure.subplots(3, 1, sharex=True)
        _with_band(stiffness, number, 1e-6 * dataset["cycle_kt"].values, 1e-6 * dataset["cycle_kt_error"].values, "fitted")
        stiffness.set(ylabel="kt in N/µm")
        _with_band(friction, number, dataset["cycle_mu"].values, dataset["cycle_mu_error"].values, "fitted")
        friction.plot(
            number, dataset["plateau"].values, ".", color=GREY, markersize=4, label="plateau of the force over the load"
        )
        friction.set(ylabel="µ")
        friction.legend(loc="best")
        for name, label, colour in (("energy_measured", "measured", CONTACTS[0]), ("energy_fitted", "fitted", CONTACTS[1])):
            energy.plot(number, 1e3 * dataset[name].values, ".-", color=colour, linewidth=1.0, markersize=4, label=label)
        energy.set(ylabel="energy per cycle in mJ", xlabel="cycle")
        energy.legend(loc="best")
        if number.min() > 0 and number.max() > MANY_DECADES * max(number.min(), 1) and len(number) < number.max() // 2:
            energy.set_xscale("log")
    return figure


def held_out(dataset: xr.Dataset) -> Figure:
    """Misfit of every law, and its error on loops held out; the chosen law is dark."""
    laws = list(dataset["law"].values)
    place = np.arange(len(laws))
    with house_style():
        figure = Figure(figsize=(1.6 + 1.1 * len(laws), 2.8), layout="constrained")
        axes = figure.add_subplot()
        for shift, name, label, colour in ((-0.2, "misfit", "fit", "#c9cdd2"), (0.2, "held_out", "loops held out", CONTACTS[0])):
            axes.bar(place + shift, 100.0 * dataset[name].values, width=0.38, color=colour, label=label)
        axes.set_xticks(place, laws)
        axes.set(title=f"Law of the contact: {dataset.attrs['best']}", ylabel="error in % of the rms force")
        axes.legend(loc="best")
    return figure


def _with_band(axes: Axes, number: np.ndarray, value: np.ndarray, error: np.ndarray, label: str) -> None:
    axes.fill_between(number, value - error, value + error, color=CONTACTS[0], alpha=0.2, linewidth=0)
    axes.plot(number, value, ".-", color=CONTACTS[0], linewidth=1.0, markersize=4, label=label)


def _closed(values: np.ndarray) -> np.ndarray:
    return np.append(values, values[0])
