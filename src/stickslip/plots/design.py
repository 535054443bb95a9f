"""The design space: worst-case resonance of every computed design, the constraints, the optimum and its ranges."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from stickslip.checks import Array
from stickslip.plots.look import FAILED, GREY, MOST_PANELS, PAGE, SLIP, STICK, house_style, plain
from stickslip.results.view import Length, shown_unit

if TYPE_CHECKING:
    import xarray as xr


def design_space(dataset: xr.Dataset) -> Figure:
    """A panel for every pair of variables, designs coloured by their worst-case peak, and the sensitivities."""
    names = [str(name) for name in dataset["variable"].values]
    pairs = most_sensitive(dataset, list(combinations(range(len(names)), 2)) or [(0, 0)])
    below = 0.5 * len(names) + 0.9
    panel = min(3.6, (PAGE - below) / len(pairs))
    with house_style():
        figure = Figure(figsize=(7.6, panel * len(pairs) + below), layout="constrained")
        panels = figure.subplots(len(pairs) + 1, 1, height_ratios=[*[panel] * len(pairs), below - 0.3])
        for axes, (i, j) in zip(panels[:-1], pairs, strict=True):
            points = _panel(axes, dataset, i, j, names)
        if points is not None:
            figure.colorbar(points, ax=list(panels[:-1]), label=f"worst-case peak in {_unit(dataset).name}", extend="max")
            _bars(panels[-1], dataset, names)
        else:
            panels[-1].remove()
    return figure


def _unit(dataset: xr.Dataset) -> Length:
    """The unit of the lowest worst-case peak."""
    sizes = dataset["worst_peak"].values
    return shown_unit(dataset["worst_peak"].attrs["units"], float(np.min(sizes[np.isfinite(sizes)], initial=np.inf)))


def most_sensitive(dataset: xr.Dataset, pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The pairs of variables that the worst-case peak depends on most, in their old order."""
    sensitivity = np.abs(np.nan_to_num(dataset["sensitivity"].values)).max(axis=1)
    order = sorted(range(len(pairs)), key=lambda k: -float(sensitivity[list(pairs[k])].sum()))
    return [pairs[k] for k in sorted(order[:MOST_PANELS])]


def _panel(axes: Axes, dataset: xr.Dataset, i: int, j: int, names: list[str]) -> PathCollection | None:
    """The designs over two variables; None, and no best one, where all break a constraint."""
    unit = _unit(dataset).metres
    value, size = dataset["value"].values, dataset["worst_peak"].values / unit
    allowed = dataset["allowed"].values == 1
    other = value[:, j] if i != j else size
    axes.scatter(value[~allowed, i], other[~allowed], marker="x", color=FAILED, s=26, label="breaks a constraint")
    points = _allowed(axes, dataset, i, j, value[allowed], size[allowed]) if allowed.any() else None
    if given := int(dataset.attrs.get("known", 0)):
        axes.plot(value[:given, i], other[:given], "s", color="black", markerfacecolor="none", markersize=9, label="known")
    axes.set(xlabel=plain(names[i]), ylabel=plain(names[j]) if i != j else "worst-case peak")
    axes.set_title(plain(dataset.attrs["title"]))
    axes.legend(loc="best", frameon=True, framealpha=0.8, edgecolor="none")
    return points


def _allowed(axes: Axes, dataset: xr.Dataset, i: int, j: int, value: Array, size: Array) -> PathCollection:
    """Designs that meet all constraints, coloured by their worst-case peak, with the best one and its neighbourhood."""
    norm = Normalize(float(size.min()), float(np.quantile(size, 0.9)))
    other = value[:, j] if i != j else size
    points = axes.scatter(value[:, i], other, c=size, s=34, edgecolor="white", linewidth=0.4, norm=norm)
    best = dataset["optimum"].values
    height = best[j] if i != j else float(dataset["worst_peak"][int(dataset["optimum_design"])]) / _unit(dataset).metres
    axes.plot(best[i], height, "*", color="black", markersize=13, markeredgecolor="white", label="best")
    low, high = dataset["near_low"].values, dataset["near_high"].values
    if i != j:
        axes.plot([low[i], high[i]], [best[j], best[j]], color=GREY, linewidth=1.5, label="one alone within 5 %")
        axes.plot([best[i], best[i]], [low[j], high[j]], color=GREY, linewidth=1.5)
    else:
        axes.plot([low[i], high[i]], [height, height], color=GREY, linewidth=1.5, label="within 5 %")
    return points


def _bars(axes: Axes, dataset: xr.Dataset, names: list[str]) -> None:
    slopes = dataset["sensitivity"].values
    for side, color, place in ((0, SLIP, 0.2), (1, STICK, -0.2)):
        axes.barh(np.arange(len(names)) + place, slopes[:, side], color=color, height=0.36, label=("less", "more")[side])
    axes.axvline(0.0, color=GREY, linewidth=0.8)
    axes.set_yticks(range(len(names)), [plain(name) for name in names])
    axes.set(xlabel="change of the worst-case peak in %, for 1 % less and 1 % more")
    axes.legend(loc="best", frameon=True, framealpha=0.8, edgecolor="none")
