"""Damper performance curves: resonance amplitude and frequency against F_C/F_E, with the states of the contacts marked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from stickslip.plots.look import CONTACTS, GREY, OPEN, SLIP, STICK, beside, house_style, level_colours, plain

if TYPE_CHECKING:
    import xarray as xr

REGION_COLOURS = (STICK, "#8fa6a0", SLIP, OPEN)
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


def dissipation(dataset: xr.Dataset, case: int = 0) -> Figure:
    """The share of each contact in the energy that the contacts dissipate per cycle, along one curve."""
    energy = np.nan_to_num(dataset["dissipated"].values[case])
    total = energy.sum(axis=1, keepdims=True)
    shares = np.divide(energy, total, out=np.zeros_like(energy), where=total > 1e-9 * total.max(initial=0.0))
    order = np.argsort(-energy.sum(axis=0))
    shown, rest = order[: len(CONTACTS) - 1], order[len(CONTACTS) - 1 :]
    parts = [*shares[:, shown].T, *([shares[:, rest].sum(axis=1)] if rest.size else [])]
    names = [str(dataset["contact"].values[c]) for c in shown] + (["others"] if rest.size else [])
    with house_style():
        figure = Figure(figsize=(7.6, 3.6), layout="constrained")
        axes = figure.add_subplot()
        axes.stackplot(dataset["force_ratio"].values, parts, colors=CONTACTS[: len(parts)], labels=[plain(n) for n in names])
        axes.set(xscale="log", xlabel="F_C/F_E", ylabel="share of the dissipation", ylim=(0.0, 1.0))
        axes.set_title("Which contact dissipates")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    return figure


def performance_band(dataset: xr.Dataset) -> Figure:
    """Lowest and highest peak per force over the start states, with that of virgin contacts; below, where those two peaks are."""
    x, virgin = dataset["force_ratio"].values, dataset["virgin_amplitude_per_force"].values
    with house_style():
        figure = Figure(figsize=(7.6, 5.4), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3.0, 2.0))
        top.fill_between(x, *dataset["amplitude_per_force"].values.T, color=CONTACTS[4], alpha=0.25, label="all start states")
        top.plot(x, virgin, ":", color="black", label="virgin contacts")
        for bound, (colour, words) in enumerate(((CONTACTS[0], "lowest"), (CONTACTS[5], "highest"))):
            top.plot(x, dataset["amplitude_per_force"].values[:, bound], ".-", color=colour, label=words)
            bottom.plot(x, dataset["frequency"].values[:, bound], ".-", color=colour)
        top.set(xscale="log", yscale=_scale(dataset["amplitude_per_force"].values), ylabel="peak per force in m/N")
        bottom.set(xlabel="F_C/F_E", ylabel="frequency in Hz")
        top.set_title(f"Band of the performance curve: {plain(dataset.attrs['title'])}")
        top.legend()
    return figure


def _scale(heights: np.ndarray) -> Literal["log", "linear"]:
    """A logarithmic axis needs a value."""
    return "log" if np.isfinite(heights).any() else "linear"


def _abscissa(dataset: xr.Dataset, case: int, collapsed: bool) -> np.ndarray:
    factor = float(dataset["friction"].values[case]) if collapsed else 1.0
    return np.asarray(dataset["force_ratio"].values * (1.0 if np.isnan(factor) else factor))


def _curve(top: Axes, bottom: Axes, dataset: xr.Dataset, case: int, quantity: str, colour: str, collapsed: bool) -> None:
    x, mu = _abscissa(dataset, case, collapsed), float(dataset["friction"].values[case])
    height, frequency = dataset[quantity].values[case], dataset["frequency"].values[case]
    top.plot(x, height, color=colour, label="as built" if np.isnan(mu) else f"μ = {mu:g}")
    bottom.plot(x, frequency, color=colour)
    share = dataset["detached_amplitude_per_force"].values[case] / dataset["amplitude_per_force"].values[case]
    if np.isfinite(share).any() and "amplitude" in quantity:
        words = None if any(line.get_marker() == "D" for line in top.lines) else "apart from the curve"
        top.plot(x, height * share, "D", color=colour, markersize=4, markerfacecolor="none", label=words)
    swapped = np.flatnonzero(np.diff(dataset["branch"].values[case]) != 0)
    for k in swapped:
        top.axvline(np.sqrt(x[k] * x[k + 1]), color=colour, linewidth=0.6, linestyle=":")
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
    top.set_title(f"Performance curve: {plain(dataset.attrs['title'])}")
    for key, style in LIMITS.items():
        bottom.axhline(float(dataset[f"{key}_frequency"].values[0]), color=GREY, linestyle=style, linewidth=0.9)
    bottom.set(ylabel="frequency in Hz")
    strips.set(xlabel="μ F_C/F_E" if collapsed else "F_C/F_E", yticks=[])
    strips.grid(visible=False)
    handles, _ = top.get_legend_handles_labels()
    lines = [Line2D([], [], color=GREY, linestyle=LIMITS[key], label=words) for key, words in LIMIT_WORDS.items()]
    patches = [
        Patch(facecolor=colour, edgecolor=GREY, linewidth=0.5, label=words)
        for words, colour in zip(REGION_WORDS, REGION_COLOURS, strict=True)
    ]
    beside(top, handles)
    bottom.legend(handles=lines, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    strips.legend(handles=patches, loc="lower left", bbox_to_anchor=(1.0, 0.0), borderaxespad=0.0)
