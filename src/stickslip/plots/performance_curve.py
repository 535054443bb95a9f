"""Damper performance curves: resonance amplitude and frequency against F_C/F_E, with the states of the contacts marked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from stickslip.harmonic.measure import DISPLACEMENT_AMPLITUDE
from stickslip.plots.look import (
    CONTACTS,
    GREY,
    MOST_ENTRIES,
    MOST_PANELS,
    SLIP,
    STICK,
    beside,
    house_style,
    level_colours,
    plain,
)
from stickslip.results.representative import spread
from stickslip.results.view import measure_in, shown_unit

if TYPE_CHECKING:
    import xarray as xr

REGION_COLOURS = (STICK, "#8fa6a0", SLIP, CONTACTS[3])
LIMITS: dict[str, Literal[":", "--"]] = {"free": ":", "stuck": "--"}
LIMIT_WORDS = {"free": "no contacts", "stuck": "contacts stuck"}
REGION_WORDS = ("stick", "microslip", "slip", "lift-off")


def performance_curves(dataset: xr.Dataset, quantity: str = "normalised_amplitude", collapsed: bool = False) -> Figure:
    """Two panels over F_C/F_E; quantity: normalised_amplitude, normalised_inertance, amplitude_per_force or inertance.

    collapsed: over μ F_C/F_E, on which curves of one mass fall together. Dots mark the optima, bars the states.
    """
    with house_style():
        figure = Figure(figsize=(7.6, 6.4), layout="constrained")
        height = min(0.25 + 0.22 * dataset.sizes["case"], 2.0)
        top, bottom, strips = figure.subplots(3, 1, sharex=True, height_ratios=(3.0, 2.0, height))
        for case, colour in enumerate(level_colours(dataset.sizes["case"])):
            _curve(top, bottom, dataset, case, quantity, colour, collapsed)
            _strip(strips, dataset, case, _abscissa(dataset, case, collapsed))
        _finish(top, bottom, strips, dataset, quantity, collapsed)
    return figure


def dissipation(dataset: xr.Dataset) -> Figure:
    """The share of each contact in the energy that the contacts dissipate per cycle, a panel for each curve."""
    cases = spread(dataset.sizes["case"], MOST_PANELS)
    energy = np.nan_to_num(dataset["dissipated"].values)
    order = np.argsort(-energy.sum(axis=(0, 1)), kind="stable")
    with house_style():
        figure = Figure(figsize=(7.6, 0.8 + 2.5 * len(cases)), layout="constrained")
        panels = figure.subplots(len(cases), 1, sharex=True, squeeze=False)[:, 0]
        for axes, case in zip(panels, cases, strict=True):
            _shares(axes, dataset, energy[case], order)
            axes.set(ylabel="share of the dissipation", ylim=(0.0, 1.0))
            axes.set_title(f"Which contact dissipates, {_name(dataset, case)}")
        panels[-1].set(xscale="log", xlabel="F_C/F_E")
        _numbered(panels[-1].xaxis)
        beside(panels[0])
    return figure


def _shares(axes: Axes, dataset: xr.Dataset, energy: np.ndarray, order: np.ndarray) -> None:
    """Contacts in the given order, those that have no colour left as one."""
    total = energy.sum(axis=1, keepdims=True)
    shares = np.divide(energy, total, out=np.zeros_like(energy), where=total > 1e-9 * total.max(initial=0.0))
    shown, rest = order[: len(CONTACTS) - 1], order[len(CONTACTS) - 1 :]
    parts = [*shares[:, shown].T, *([shares[:, rest].sum(axis=1)] if rest.size else [])]
    names = [str(dataset["contact"].values[c]) for c in shown] + (["others"] if rest.size else [])
    axes.stackplot(dataset["force_ratio"].values, parts, colors=CONTACTS[: len(parts)], labels=[plain(n) for n in names])


def performance_band(dataset: xr.Dataset) -> Figure:
    """Lowest and highest peak per force over the start states, with that of virgin contacts; below, where those two peaks are."""
    x, heights = dataset["force_ratio"].values, dataset["amplitude_per_force"].values
    measure = measure_in(dataset)
    peak = "peak" if measure == DISPLACEMENT_AMPLITUDE else f"peak {measure.symbol}"
    unit = shown_unit(dataset["amplitude_per_force"].attrs["units"], float(np.nanmax(heights, initial=0.0)))
    with house_style():
        figure = Figure(figsize=(7.6, 5.4), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3.0, 2.0))
        top.fill_between(x, *heights.T / unit.metres, color=CONTACTS[4], alpha=0.25, label="all start states")
        for bound, (colour, words) in enumerate(((CONTACTS[0], "lowest"), (CONTACTS[5], "highest"))):
            top.plot(x, heights[:, bound] / unit.metres, ".-", color=colour, label=words)
            bottom.plot(x, dataset["frequency"].values[:, bound], ".-", color=colour)
        virgin = dataset["virgin_amplitude_per_force"].values / unit.metres
        top.plot(x, virgin, ":", color="black", label="virgin contacts")
        top.set(xscale="log", yscale=_scale(heights), ylabel=f"{peak} per force in {unit.name}")
        bottom.set(xlabel="F_C/F_E", ylabel="frequency in Hz")
        for axis in (bottom.xaxis, *([top.yaxis] if top.get_yscale() == "log" else [])):
            _numbered(axis)
        top.set_title(plain(dataset.attrs["title"]))
        top.legend()
    return figure


def _name(dataset: xr.Dataset, case: int) -> str:
    """What a curve is called."""
    mu = float(dataset["friction"].values[case])
    return "as built" if np.isnan(mu) else f"μ = {mu:g}"


def _numbered(axis: Axis) -> None:
    """A logarithmic axis with plain numbers at 1, 2 and 5, where these have room: over not more than three decades."""
    low, high = axis.get_view_interval()
    if high > 1e3 * low:
        return
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def _scale(heights: np.ndarray) -> Literal["log", "linear"]:
    """A logarithmic axis needs a value."""
    return "log" if np.isfinite(heights).any() else "linear"


def _abscissa(dataset: xr.Dataset, case: int, collapsed: bool) -> np.ndarray:
    factor = float(dataset["friction"].values[case]) if collapsed else 1.0
    return np.asarray(dataset["force_ratio"].values * (1.0 if np.isnan(factor) else factor))


def _curve(top: Axes, bottom: Axes, dataset: xr.Dataset, case: int, quantity: str, colour: str, collapsed: bool) -> None:
    x = _abscissa(dataset, case, collapsed)
    height, frequency = dataset[quantity].values[case], dataset["frequency"].values[case]
    top.plot(x, height, color=colour, label=_name(dataset, case))
    bottom.plot(x, frequency, color=colour)
    share = dataset["detached_amplitude_per_force"].values[case] / dataset["amplitude_per_force"].values[case]
    if np.isfinite(share).any() and "amplitude" in quantity:
        top.plot(x, height * share, "D", color=colour, markersize=4, markerfacecolor="none", label="on an isola")
    events = dataset.isel(case=case)
    swapped = np.sqrt(events["event_low"].values * events["event_high"].values)[events["event_kind"].values == "swapped"]
    for place in swapped * (x[0] / dataset["force_ratio"].values[0]):
        top.axvline(place, color=colour, linewidth=0.9, linestyle=":", label="another peak is the highest")
    if np.isfinite(height).any():
        best = int(np.nanargmin(height))
        top.plot(x[best], height[best], "o", color=colour, markersize=5, markeredgecolor="white", zorder=4)


def _strip(axes: Axes, dataset: xr.Dataset, case: int, x: np.ndarray) -> None:
    """The region of every point as a coloured bar."""
    edges = np.concatenate([[x[0]], np.sqrt(x[:-1] * x[1:]), [x[-1]]])
    for k, region in enumerate(dataset["region"].values[case]):
        if np.isfinite(region):
            place, colour = (edges[k], edges[k + 1] - edges[k]), REGION_COLOURS[int(region)]
            axes.broken_barh([place], (-case - 0.4, 0.8), facecolor=colour, edgecolor="none")


def _finish(top: Axes, bottom: Axes, strips: Axes, dataset: xr.Dataset, quantity: str, collapsed: bool) -> None:
    attributes = dataset[quantity].attrs
    units = "" if attributes["units"] == "1" else f" in {attributes['units'].replace('s2', 's²')}"
    scale = _scale(dataset[quantity].values)
    top.set(xscale="log", yscale=scale, ylabel=f"{attributes['long_name']}{units}".replace("relative", "\nrelative"))
    top.set_title(plain(dataset.attrs["title"]))
    _numbered(strips.xaxis)
    if scale == "log":
        _numbered(top.yaxis)
    for key, style in LIMITS.items():
        bottom.axhline(float(dataset[f"{key}_frequency"].values[0]), color=GREY, linestyle=style, linewidth=0.9)
    bottom.set(ylabel="frequency in Hz")
    strips.set(xlabel="μ F_C/F_E" if collapsed else "F_C/F_E")
    rows = spread(dataset.sizes["case"], MOST_ENTRIES)
    strips.set_yticks([-case for case in rows], [_name(dataset, case) for case in rows], fontsize=8)
    strips.grid(visible=False)
    lines = [Line2D([], [], color=GREY, linestyle=LIMITS[key], label=words) for key, words in LIMIT_WORDS.items()]
    patches = [
        Patch(facecolor=colour, edgecolor=GREY, linewidth=0.5, label=words)
        for words, colour in zip(REGION_WORDS, REGION_COLOURS, strict=True)
    ]
    beside(top)
    bottom.legend(handles=lines, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    strips.legend(handles=patches, loc="lower left", bbox_to_anchor=(1.0, 0.0), borderaxespad=0.0)
