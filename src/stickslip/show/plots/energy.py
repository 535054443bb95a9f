"""Dissipated energy along the curve and per contact at the peak, and the loss factor."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.representative import representatives
from stickslip.results.view import along_curve, dissipated, energy_text, energy_unit, frequencies, level_text, shares_at_peak
from stickslip.show.plots.case_lines import case_lines
from stickslip.show.plots.chart import Axis, Bars, Chart, Line, Panel, from_zero
from stickslip.show.plots.look import CONTACTS, contact
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

MOST_BARS = 9
"""Cases whose shares are drawn."""


@FIGURES.of("ForcedResponse", "dissipation")
def dissipation(dataset: xr.Dataset) -> Chart:
    """Energy of all contacts per period against frequency, and the share of each contact at the highest peak."""
    energies = [np.sum(dissipated(dataset, case), axis=1) for case in range(dataset.sizes["case"])]
    joules, unit = energy_unit(float(np.max(np.nan_to_num(np.concatenate(energies)), initial=0.0)))
    lines = [
        Line(frequencies(dataset, case), np.where(energy > 0.0, energy / joules, np.nan), **line)
        for case, (energy, line) in enumerate(zip(energies, case_lines(dataset), strict=True))
    ]
    axis = Axis("energy per period", unit, log=bool(np.nansum(dataset.dissipated.values) > 0.0))

    chosen = representatives(dataset, MOST_BARS)
    names, energy, total = shares_at_peak(chosen.dataset, len(CONTACTS))
    percent = np.nan_to_num(100.0 * energy / np.where(total > 0.0, total, np.nan)[:, None])
    rows, before = np.arange(total.size), np.cumsum(percent, axis=1) - percent
    bars = []
    for k, name in enumerate(names):
        style, hover = contact(-1 if name.endswith(" others") else k), {"energy per period in J": energy[:, k]}
        bars.append(Bars(rows, percent[:, k], style, name, base=before[:, k], horizontal=True, hover=hover))
    sizes = [energy_text(value, chosen.dataset) if np.isfinite(value) else "not converged" for value in total]
    cases = {float(case): f"{level_text(chosen.dataset, case)}, {size}" for case, size in enumerate(sizes)}
    axes = Axis("share of the contacts", "%", limits=(0.0, 100.0)), Axis("", names=cases, upside_down=True)

    panels = [Panel(HERTZ, axis, lines, "All contacts", 3.4), Panel(*axes, bars, "At the highest peak", 3.4)]
    note = f"shares: {chosen.words}" if chosen.words else ""
    return Chart("Energy dissipated in contacts", panels, columns=2, note=note)


@FIGURES.of("ForcedResponse", "loss_factor")
def loss_factor(dataset: xr.Dataset) -> Chart:
    """Loss factor against frequency, one curve a force level."""
    lines = [
        Line(frequencies(dataset, case), along_curve(dataset, "loss_factor", case), **line)
        for case, line in enumerate(case_lines(dataset))
    ]
    return Chart("Loss factor", [Panel(HERTZ, from_zero(Axis("loss factor")), lines, height=3.4)])
