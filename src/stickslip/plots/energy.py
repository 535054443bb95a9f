"""Dissipated energy along the curve and per contact at the peak, and the loss factor."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from stickslip.plots.case_lines import case_lines
from stickslip.plots.look import CONTACTS, beside, headed, house_style, legend, plain
from stickslip.results.representative import representatives
from stickslip.results.view import along_curve, dissipated, frequencies, level_text, shares_at_peak

if TYPE_CHECKING:
    import xarray as xr

MOST_BARS = 9
"""Cases whose shares are drawn."""


def dissipation(dataset: xr.Dataset) -> Figure:
    """Energy per cycle of all contacts against frequency, and the share of each contact at the highest peak."""
    with house_style():
        figure = Figure(figsize=(9.4, 4.0), layout="constrained")
        left, right = figure.subplots(1, 2)
        for case, line in enumerate(case_lines(dataset)):
            energy = np.sum(dissipated(dataset, case), axis=1)
            energy[energy <= 0.0] = np.nan
            left.plot(frequencies(dataset, case), energy, **line)
        if np.nansum(dataset.dissipated.values) > 0.0:
            left.set_yscale("log")
        left.set(title="Dissipated by friction, all contacts", xlabel="frequency in Hz", ylabel="energy per cycle in J")
        legend(left, loc="best")
        chosen = representatives(dataset, MOST_BARS)
        _shares(right, chosen.dataset)
        if chosen.words:
            headed(figure, "Energy", f"shares: {chosen.words}")
    return figure


def loss_factor(dataset: xr.Dataset) -> Figure:
    """Loss factor against frequency, one curve a force level."""
    with house_style():
        figure = Figure(figsize=(7.6, 4.0), layout="constrained")
        axes = figure.add_subplot()
        for case, line in enumerate(case_lines(dataset)):
            values = along_curve(dataset, "loss_factor", case)
            axes.plot(frequencies(dataset, case), values, **line)
        axes.set(title="Loss factor", xlabel="frequency in Hz", ylabel="loss factor", ylim=(0.0, None))
        beside(axes)
    return figure


def _shares(axes: Axes, dataset: xr.Dataset) -> None:
    names, energy, total = shares_at_peak(dataset, len(CONTACTS))
    percent = 100.0 * energy / np.where(total > 0.0, total, np.nan)[:, None]
    left = np.zeros(total.size)
    for index, name in enumerate(names):
        colour = CONTACTS[-1] if name.endswith(" others") else CONTACTS[index % len(CONTACTS)]
        axes.barh(np.arange(total.size), np.nan_to_num(percent[:, index]), left=left, color=colour, label=plain(name))
        left += np.nan_to_num(percent[:, index])
    joules = EngFormatter("J", places=2)
    sizes = [joules(value) if np.isfinite(value) else "not converged" for value in total]
    words = [f"{level_text(dataset, case)}\n{size}" for case, size in enumerate(sizes)]
    axes.set_yticks(np.arange(total.size), words, fontsize=8)
    axes.set(title="At the highest peak", xlabel="share of the contacts in %", xlim=(0.0, 100.0))
    axes.grid(axis="y", visible=False)
    axes.invert_yaxis()
    if names:
        beside(axes)
