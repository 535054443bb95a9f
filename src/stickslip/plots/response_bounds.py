"""Figures of response bounds: both bounds with the samples, range of the peak, loss factors, start states."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.plots.look import CONTACTS, GREY, beside, headed, house_style, level_colours, shown_levels
from stickslip.plots.response_curves import size_label
from stickslip.results.view import Length, measure_in, shown_unit

if TYPE_CHECKING:
    import xarray as xr

LOWER, UPPER = CONTACTS[0], CONTACTS[5]


def response_bounds(dataset: xr.Dataset) -> Figure:
    """Amplitude bounds against frequency, a panel per force level, with the sampled start states; of peaks, their ranges."""
    if dataset.attrs["objective"] == "peak":
        return peak_ranges(dataset)
    cases, note = shown_levels(np.arange(dataset.sizes["case"]))
    with house_style():
        figure = Figure(figsize=(7.6, 0.8 + 2.4 * len(cases)), layout="constrained")
        for case, axes in zip(cases, figure.subplots(len(cases), 1, squeeze=False, sharex=True).ravel(), strict=True):
            _band(axes, dataset, case)
            axes.set_title(f"force {dataset['force_level'].values[case]:g}")
            axes.set_ylabel(f"{size_label(dataset)} in {bound_unit(dataset).name}")
        axes.set_xlabel("frequency in Hz")
        figure.axes[0].legend(loc="upper left")
        headed(figure, f"Bounds by {dataset.attrs['objective'].replace('_', ' ')}: {dataset.attrs['title']}", note)
    return figure


def bound_unit(dataset: xr.Dataset) -> Length:
    """The unit to draw sizes in."""
    return shown_unit(dataset["amplitude"].attrs["units"], float(np.nanmax(dataset["amplitude"].values, initial=0.0)))


def _band(axes: Axes, dataset: xr.Dataset, case: int) -> None:
    hertz, unit = dataset["frequency"].values, bound_unit(dataset).metres
    low, high = dataset["amplitude"].values[case] / unit
    cloud = dataset["sampled_amplitude"].values[case] / unit
    axes.plot(np.broadcast_to(hertz, cloud.shape).ravel(), cloud.ravel(), ".", color=GREY, markersize=3, label="sampled starts")
    axes.plot(hertz, low, ".-", color=LOWER, label="lower bound")
    axes.plot(hertz, high, ".-", color=UPPER, label="upper bound")
    axes.fill_between(hertz, low, high, color=UPPER, alpha=0.08, linewidth=0)
    axes.set_ylim(bottom=0.0)


def peak_ranges(dataset: xr.Dataset) -> Figure:
    """Range of the resonance amplitude per force, and of its frequency, against the force level."""
    levels, measure, unit = dataset["force_level"].values, measure_in(dataset), bound_unit(dataset)
    divisor = unit.metres * (np.ones(levels.size) if measure.per_force else levels)
    per_force = dataset["amplitude"].values[:, :, 0] / divisor[:, None]
    virgin = dataset["sampled_amplitude"].values[:, 0, 0] / divisor
    what = "peak amplitude" if measure.kind == "amplitude" and not measure.order else f"peak {measure.symbol}"
    words = f"{what}{' per force' if not measure.per_force else ''} in {unit.name}"
    with house_style():
        figure = Figure(figsize=(7.6, 3.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        for axes, values, label in (
            (left, per_force, words),
            (right, dataset["resonance"].values[:, :, 0], "its frequency in Hz"),
        ):
            axes.plot(levels, values[:, 0], ".-", color=LOWER, label="lower bound")
            axes.plot(levels, values[:, 1], ".-", color=UPPER, label="upper bound")
            axes.set(xlabel="force level", ylabel=label)
            if levels.size > 1 and levels.max() > 8.0 * levels.min():
                axes.set_xscale("log")
        left.plot(levels, virgin, "--", color=GREY, label="virgin contacts")
        left.fill_between(levels, per_force[:, 0], per_force[:, 1], color=UPPER, alpha=0.08, linewidth=0)
        left.legend()
        headed(figure, f"Range of the resonance: {dataset.attrs['title']}")
    return figure


def loss_factors(dataset: xr.Dataset) -> Figure:
    """Loss factor along the lower (solid) and the upper bound (dash-dotted), one colour per force level."""
    levels = dataset["force_level"].values
    across = dataset["frequency"].values if dataset.attrs["objective"] != "peak" else dataset["resonance"].values
    with house_style():
        figure = Figure(figsize=(7.6, 3.8), layout="constrained")
        axes = figure.subplots()
        for case, colour in enumerate(level_colours(levels.size)):
            for bound, style in ((0, "-"), (1, "-.")):
                x = across if across.ndim == 1 else across[case, bound]
                label = f"force {levels[case]:g}" if bound == 0 else None
                axes.plot(x, dataset["loss_factor"].values[case, bound], style, marker=".", color=colour, label=label)
        axes.set(xlabel="frequency in Hz", ylabel="loss factor")
        beside(axes)
        headed(figure, "Loss factor along the bounds: lower solid, upper dash-dotted")
    return figure


def start_states(dataset: xr.Dataset, case: int = 0) -> Figure:
    """The start variables that make the bounds, against frequency."""
    variables = dataset["start_variable"].values[case]
    with house_style():
        figure = Figure(figsize=(7.6, 4.4), layout="constrained")
        for bound, axes in enumerate(figure.subplots(2, 1, sharex=True)):
            image = axes.imshow(variables[bound].T, vmin=-1.0, vmax=1.0, cmap="RdBu", aspect="auto", interpolation="nearest")
            axes.set_title(("lower", "upper")[bound] + " bound")
            axes.set_ylabel("start variable")
            axes.grid(visible=False)
        hertz = dataset["frequency"].values
        ticks = np.unique(np.linspace(0, hertz.size - 1, 7).round().astype(int))
        axes.set_xticks(ticks, [f"{hertz[tick]:.4g}" for tick in ticks])
        axes.set_xlabel("frequency in Hz")
        figure.colorbar(image, ax=figure.axes, label="variable in [−1, 1]")
    return figure
