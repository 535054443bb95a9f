"""The design space: worst-case resonance of every computed design, the constraints, the optimum and its ranges."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import Length, shown_unit
from stickslip.show.plots.chart import Axis, Bars, Chart, Layer, Line, Panel, Rule, Shades
from stickslip.show.plots.look import CROSS, MOST_PANELS, PAGE, Style, spoken
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

ALONE = Style("grey", width=1.6)


@FIGURES.of("DamperDesign")
def design_space(dataset: xr.Dataset) -> Chart:
    """A panel for every pair of variables, designs coloured by their worst-case peak, and the sensitivities."""
    names = [str(name) for name in dataset["variable"].values]
    pairs = most_sensitive(dataset, list(combinations(range(len(names)), 2)) or [(0, 0)])
    below = 0.4 * len(names) + 0.6
    height = min(3.2, (PAGE - below - 0.7) / len(pairs))
    panels = [_panel(dataset, i, j, names, height) for i, j in pairs]
    if np.any(dataset["allowed"].values == 1):
        slopes, rows = dataset["sensitivity"].values, np.arange(len(names), dtype=float)
        layers: list[Layer] = [
            Bars(rows + beside, slopes[:, side], Style(shade), label, width=0.36, horizontal=True)
            for side, shade, beside, label in ((0, "slip", 0.2, "1 % less"), (1, "stick", -0.2, "1 % more"))
        ]
        layers.append(Rule(0.0, Style("grey", width=0.8)))
        variables = Axis("", names={float(row): spoken(name) for row, name in enumerate(names)})
        panels.append(Panel(Axis("change of the worst-case peak", "%"), variables, layers, height=below))
    return Chart(str(dataset.attrs["title"]), panels)


def _unit(dataset: xr.Dataset) -> Length:
    """The unit of the lowest worst-case peak."""
    sizes = dataset["worst_peak"].values
    return shown_unit(dataset["worst_peak"].attrs["units"], float(np.min(sizes[np.isfinite(sizes)], initial=np.inf)))


def most_sensitive(dataset: xr.Dataset, pairs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The pairs of variables that the worst-case peak depends on most, in their old order."""
    sensitivity = np.abs(np.nan_to_num(dataset["sensitivity"].values)).max(axis=1)
    order = sorted(range(len(pairs)), key=lambda k: -float(sensitivity[list(pairs[k])].sum()))
    return [pairs[k] for k in sorted(order[:MOST_PANELS])]


def _panel(dataset: xr.Dataset, i: int, j: int, names: list[str], height: float) -> Panel:
    """The designs over two variables, or over one against the worst-case peak."""
    value, size = dataset["value"].values, dataset["worst_peak"].values / _unit(dataset).metres
    allowed, peak = dataset["allowed"].values == 1, Axis("worst-case peak", _unit(dataset).name)
    other = value[:, j] if i != j else size
    layers: list[Layer] = []
    if not allowed.all():
        layers.append(Line(value[~allowed, i], other[~allowed], CROSS, "breaks a constraint"))
    if allowed.any():
        bright = float(np.quantile(size[allowed], 0.9))
        layers.append(Shades(value[allowed, i], other[allowed], size[allowed], peak, bright, "meets the constraints"))
        # The best design, and the ranges of one variable alone in which its peak stays within 5 %.
        best, low, high = (dataset[name].values for name in ("optimum", "near_low", "near_high"))
        level = float(best[j] if i != j else size[int(dataset["optimum_design"])])
        within = "one alone within 5 %" if i != j else "within 5 %"
        layers.append(Line([low[i], high[i]], [level, level], ALONE, within))
        if i != j:
            layers.append(Line([best[i], best[i]], [low[j], high[j]], ALONE, within))
        layers.append(Line([best[i]], [level], Style("ink", "none", marker="star", size=10.0), "best"))
    if given := int(dataset.attrs.get("known", 0)):
        layers.append(Line(value[:given, i], other[:given], Style("ink", "none", marker="square", size=8.0), "known design"))
    return Panel(Axis(spoken(names[i])), Axis(spoken(names[j])) if i != j else peak, layers, height=height)
