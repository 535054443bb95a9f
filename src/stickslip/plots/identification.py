"""Figures of an identification: measured and fitted loops, residuals, posterior, contact laws."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from stickslip.plots.look import CONTACTS, GREY, MOST_PANELS, headed, house_style
from stickslip.results.representative import spread

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

SHOWN = {"force_x": ("N", 1.0), "force_y": ("N", 1.0), "rotation": ("mrad", 1e3), "damper_y": ("µm", 1e6)}
"""Unit of each channel in figures, and the factor to it."""


def loops_and_fit(dataset: xr.Dataset) -> Figure:
    """Each channel of each case against the platform's larger motion: measured dark, fitted orange."""
    all_cases, channels = dataset["case"].values, dataset["channel"].values
    cases = all_cases[spread(len(all_cases), MOST_PANELS)]
    with house_style():
        size = (2.7 * len(channels), 2.7 * len(cases))
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(len(cases), len(channels), squeeze=False)
        for place, (row, case) in enumerate(zip(grid, cases, strict=True)):
            motion = _motion(dataset.sel(case=case))
            for axes, channel in zip(row, channels, strict=True):
                unit, factor = SHOWN[channel]
                for name, colour, width in (("measured", CONTACTS[0], 2.6), ("fitted", CONTACTS[1], 1.2)):
                    values = dataset[name].sel(case=case, channel=channel).values
                    shift = 0.0 if name == "measured" else float(dataset["zero"].sel(case=case, channel=channel))
                    axes.plot(
                        _closed(1e6 * motion), _closed(factor * (values + shift)), color=colour, linewidth=width, label=name
                    )
                axes.set(title=channel if place == 0 else "", xlabel="platform in µm" if case == cases[-1] else "")
                axes.set(ylabel=f"{case}\n{unit}" if channel == channels[0] else unit)
        grid[0][0].legend(loc="best")
        if len(cases) < len(all_cases):
            headed(figure, "Loops", f"{len(cases)} of {len(all_cases)} cases")
    return figure


def residuals(dataset: xr.Dataset) -> Figure:
    """Measured less fitted over the cycle, every case, without the mean."""
    channels, all_cases = dataset["channel"].values, dataset["case"].values
    cases = all_cases[spread(len(all_cases), len(CONTACTS))]
    phase = np.arange(dataset.sizes["sample"]) / dataset.sizes["sample"]
    with house_style():
        figure = Figure(figsize=(7.6, 1.7 * len(channels)), layout="constrained")
        for axes, channel in zip(figure.subplots(len(channels), 1, sharex=True, squeeze=False)[:, 0], channels, strict=True):
            unit, factor = SHOWN[channel]
            for case, colour in zip(cases, CONTACTS, strict=False):
                one = dataset.sel(case=case, channel=channel)
                left = one["measured"].values - one["fitted"].values
                axes.plot(phase, factor * (left - left.mean()), color=colour, linewidth=1.0, label=str(case))
            axes.set(ylabel=f"{channel}\nin {unit}")
        axes.set(xlabel="share of the cycle")
        if len(cases) < len(all_cases):
            headed(figure, "Residuals", f"{len(cases)} of {len(all_cases)} cases")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    return figure


def posterior(dataset: xr.Dataset) -> Figure:
    """Refits of every pair of unknowns, with the identified values and 95 % intervals."""
    names = list(dataset["parameter"].values)
    with house_style():
        figure = Figure(figsize=(1.8 * len(names) + 0.6,) * 2, layout="constrained")
        grid = figure.subplots(len(names), len(names), squeeze=False)
        for i, row in enumerate(grid):
            for j, axes in enumerate(row):
                if j > i:
                    axes.set_axis_off()
                    continue
                _pair(axes, dataset, names[j], names[i])
                axes.set(xlabel=_label(dataset, names[j]) if i == len(names) - 1 else "")
                axes.set(ylabel=_label(dataset, names[i]) if j == 0 and i else "")
    return figure


def _pair(axes: Axes, dataset: xr.Dataset, across: str, up: str) -> None:
    """Refits of two unknowns, or their distribution where they are the same."""
    x = _scaled(dataset, across, dataset["replicates"].sel(parameter=across).values)
    low, high = _scaled(dataset, across, dataset["interval"].sel(parameter=across).values)
    if np.isfinite(low):
        axes.axvspan(low, high, color=CONTACTS[0], alpha=0.12, linewidth=0)
    if across == up:
        axes.hist(x, bins=10, color=GREY)
        return
    axes.plot(x, _scaled(dataset, up, dataset["replicates"].sel(parameter=up).values), ".", color=GREY, markersize=4)
    best = [_scaled(dataset, name, np.asarray(dataset["value"].sel(parameter=name))) for name in (across, up)]
    axes.plot(*best, "o", color=CONTACTS[1])


def _motion(one: xr.Dataset) -> np.ndarray[Any, Any]:
    moves = one["platform_motion"].values
    return np.asarray(moves[int(np.argmax(np.ptp(moves, axis=1)))])


def _closed(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return np.append(values, values[0])


def _scaled(dataset: xr.Dataset, name: str, values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return np.asarray(values * (1.0 if str(dataset["parameter_units"].sel(parameter=name).values) == "1" else 1e-6))


def _label(dataset: xr.Dataset, name: str) -> str:
    return name if str(dataset["parameter_units"].sel(parameter=name).values) == "1" else f"{name} in N/µm"
