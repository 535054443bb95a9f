"""Figures of an identification: measured and fitted loops, residuals, posterior, contact laws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.representative import spread
from stickslip.show.plots.chart import Area, Axis, Bars, Chart, Layer, Line, Panel, closed
from stickslip.show.plots.look import CONTACTS, MOST_PANELS, Style, contact
from stickslip.support.checks import Array
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

CHANNELS = {
    "force_x": ("horizontal force", "N", 1.0),
    "force_y": ("vertical force", "N", 1.0),
    "rotation": ("rotation", "mrad", 1e3),
    "damper_y": ("vertical motion of the damper", "µm", 1e6),
}
"""Each channel in words, its unit in figures, and the factor to it."""
MEASURED, FITTED = contact(0, width=2.6), contact(1, width=1.3)


@FIGURES.of("Identification")
def loops_and_fit(dataset: xr.Dataset) -> Chart:
    """Each channel of each case against the platform's larger motion: measured dark, fitted orange."""
    all_cases, channels = dataset["case"].values, [str(channel) for channel in dataset["channel"].values]
    cases, panels = all_cases[spread(len(all_cases), MOST_PANELS)], []
    for case in cases:
        moves = dataset.sel(case=case)["platform_motion"].values
        motion = closed(1e6 * moves[int(np.argmax(np.ptp(moves, axis=1)))])
        for channel in channels:
            loop = dataset.sel(case=case, channel=channel)
            quantity, unit, factor = CHANNELS[channel]
            measured = closed(factor * loop["measured"].values)
            fitted = closed(factor * (loop["fitted"].values + float(loop["zero"])))
            layers = [Line(motion, measured, MEASURED, "measured"), Line(motion, fitted, FITTED, "fitted")]
            panels.append(Panel(Axis("motion of the platform", "µm"), Axis(quantity, unit), layers, str(case), 2.3))
    note = f"{len(cases)} of {len(all_cases)} cases" if len(cases) < len(all_cases) else ""
    return Chart("Measured and fitted loops", panels, columns=len(channels), note=note)


@FIGURES.of("Identification", "residuals")
def residuals(dataset: xr.Dataset) -> Chart:
    """Measured less fitted over the cycle, every case, without the mean."""
    channels, all_cases = [str(channel) for channel in dataset["channel"].values], dataset["case"].values
    cases = all_cases[spread(len(all_cases), len(CONTACTS))]
    phase, panels = np.arange(dataset.sizes["sample"]) / dataset.sizes["sample"], []
    for channel in channels:
        quantity, unit, factor = CHANNELS[channel]
        layers = []
        for k, case in enumerate(cases):
            loop = dataset.sel(case=case, channel=channel)
            left = factor * (loop["measured"].values - loop["fitted"].values)
            layers.append(Line(phase, left - left.mean(), contact(k, width=1.2), str(case)))
        panels.append(Panel(Axis("share of the cycle"), Axis(quantity, unit), layers, height=1.7))
    note = f"{len(cases)} of {len(all_cases)} cases" if len(cases) < len(all_cases) else ""
    return Chart("Residuals: measured less fitted", panels, note=note, shared_x=True)


@FIGURES.of("Identification", "posterior")
def posterior(dataset: xr.Dataset) -> Chart:
    """Refits of every pair of unknowns, with the identified values and 95 % intervals."""
    names = [str(name) for name in dataset["parameter"].values]
    empty = Panel(Axis(""), Axis(""), [], height=1.6)
    panels = [_pair(dataset, across, up) if j <= i else empty for i, up in enumerate(names) for j, across in enumerate(names)]
    return Chart("Refits of every pair of unknowns", panels, columns=len(names))


def _pair(dataset: xr.Dataset, across: str, up: str) -> Panel:
    """Refits of two unknowns, or their distribution where they are the same."""
    x = _scaled(dataset, across, dataset["replicates"].sel(parameter=across).values)
    low, high = _scaled(dataset, across, dataset["interval"].sel(parameter=across).values)
    if across == up:
        counts, edges = np.histogram(x, bins=10)
        layers: list[Layer] = [
            Bars(0.5 * (edges[1:] + edges[:-1]), counts, Style("grey"), "refits", width=float(edges[1] - edges[0]))
        ]
        ends, axis = (0.0, float(counts.max())), Axis("number of refits")
    else:
        y = _scaled(dataset, up, dataset["replicates"].sel(parameter=up).values)
        best_x, best_y = ([float(_scaled(dataset, name, dataset["value"].sel(parameter=name).values))] for name in (across, up))
        layers = [Line(x, y, Style("grey", "none", marker="circle", size=2.5), "refits")]
        layers.append(Line(best_x, best_y, contact(1, dash="none", marker="circle", size=5.0), "identified"))
        ends, axis = (float(np.nanmin(y)), float(np.nanmax(y))), _axis(dataset, up)
    if np.isfinite(low):
        corners = [low, high, high, low], [ends[0], ends[0], ends[1], ends[1]]
        layers.insert(0, Area(*corners, contact(0, opacity=0.14), "95 % interval"))
    return Panel(_axis(dataset, across), axis, layers, height=1.6)


def _scaled(dataset: xr.Dataset, name: str, values: Array) -> Array:
    return np.asarray(values * (1.0 if str(dataset["parameter_units"].sel(parameter=name).values) == "1" else 1e-6))


def _axis(dataset: xr.Dataset, name: str) -> Axis:
    """kt, kn, or μ with the contact lines that it is of."""
    symbol, _, lines = name.replace("mu", "μ", 1).partition("_")
    return Axis(
        f"{symbol} of {lines}" if lines else symbol,
        "" if str(dataset["parameter_units"].sel(parameter=name).values) == "1" else "N/µm",
    )
