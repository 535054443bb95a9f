"""Sampled responses over start states, with bounds and percentiles where available."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.plots.look import CONTACTS, GREY, headed, house_style, shown_levels
from stickslip.plots.response_curves import words_on_axis
from stickslip.results.view import along_curve_as, frequencies, measure_in, peak_unit

if TYPE_CHECKING:
    import xarray as xr


def response_cloud(dataset: xr.Dataset, bounds: xr.Dataset | None = None, output: int = 0) -> Figure:
    """Every curve, a panel per force level, the first (virgin unless a law was given) drawn out; bounds: of the same levels."""
    measure, unit = measure_in(dataset), peak_unit(dataset)
    levels, note = shown_levels(np.unique(dataset["force_level"].values))
    with house_style():
        figure = Figure(figsize=(7.6, 0.8 + 2.4 * levels.size), layout="constrained")
        for level, axes in zip(levels, figure.subplots(levels.size, 1, squeeze=False, sharex=True).ravel(), strict=True):
            cases = np.flatnonzero(dataset["force_level"].values == level)
            for case in cases[::-1]:
                first = case == cases[0]
                style = {"color": "black", "linewidth": 1.4} if first else {"color": GREY, "linewidth": 0.6, "alpha": 0.7}
                axes.plot(frequencies(dataset, case), along_curve_as(dataset, measure, case, output) / unit.metres, **style)
            if bounds is not None:
                _bounds(axes, bounds, float(level), unit.metres)
            axes.set(title=f"force {level:g}, {cases.size} start states", ylabel=f"{words_on_axis(measure)} in {unit.name}")
            axes.set_ylim(bottom=0.0)
        axes.set_xlabel("frequency in Hz")
        headed(figure, f"Responses of one problem: {dataset.attrs['title']}", note)
    return figure


def _bounds(axes: object, bounds: xr.Dataset, level: float, unit: float) -> None:
    scale = measure_in(bounds).per(level) / unit
    for case in np.flatnonzero(np.isclose(bounds["force_level"].values, level)):
        for bound, colour in ((0, CONTACTS[0]), (1, CONTACTS[5])):
            x = bounds["resonance"].values[case, bound]
            axes.plot(x, scale * bounds["amplitude"].values[case, bound], ".-", color=colour)  # type: ignore[attr-defined]
