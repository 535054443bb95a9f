"""Damper performance curves: resonance amplitude and frequency against F_C/F_E, with the states of the contacts marked; and the
space of designs: worst-case resonance of every computed design, the constraints, the optimum and its ranges."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from stickslip.results.view import Length, measure_in, shown_unit, spread
from stickslip.show.plots import look
from stickslip.show.plots.chart import Axis, Bars, Cells, Chart, Key, Layer, Line, Panel, Rule, Shades, band, edges_between
from stickslip.show.plots.response_curves import HERTZ, LINEAR
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.support.checks import Array
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES

REGIONS = ("stick", "microslip", "slip", "lift-off")
"""Regions of a performance curve, by their number in results; each has a colour of its name."""
SWAPPED, ISOLA = "another peak is the highest", "on an isola"
FORCE_RATIO = Axis("force ratio F_C/F_E", log=True)


@FIGURES.of("PerformanceCurve")
def performance_curves(dataset: xr.Dataset, quantity: str = "normalised_amplitude", collapsed: bool = False) -> Chart:
    """Two panels over F_C/F_E; quantity: normalised_amplitude, normalised_inertance, amplitude_per_force or inertance.

    collapsed: over μ F_C/F_E, on which curves of one mass fall together. Dots mark the optima, bars the states.
    """
    cases = range(dataset.sizes["case"])
    across = replace(FORCE_RATIO, quantity="μ F_C/F_E") if collapsed else FORCE_RATIO
    sizes, scale = _sizes(dataset, quantity)
    top: list[Layer] = []
    bottom: list[Layer] = []
    regions: list[Layer] = []
    for case, line in enumerate(look.level_lines([_name(dataset, case) for case in cases])):
        friction = float(dataset["friction"].values[case])
        x = dataset["force_ratio"].values * (friction if collapsed and not np.isnan(friction) else 1.0)
        top += _curve(dataset, case, quantity, x, scale, line)
        bottom.append(Line(x, dataset["frequency"].values[case], **line))
        regions.append(_regions(dataset, case, x))
    limits = [Rule(float(dataset[f"{key}_frequency"].values[0]), style, words, "y") for key, (words, style) in LINEAR.items()]
    height = min(0.35 + 0.2 * len(cases), 2.0)
    names = Axis(
        "", names={float(case): _name(dataset, case) for case in spread(len(cases), look.MOST_ENTRIES)}, upside_down=True
    )
    keys = [Key(region, look.Style(region)) for region in REGIONS]
    panels = [
        Panel(across, sizes, top, height=2.9),
        Panel(across, HERTZ, [*bottom, *limits], height=1.9),
        Panel(across, names, [*regions, *keys], height=height),
    ]
    return Chart(str(dataset.attrs["title"]), panels, shared_x=True)


def dissipation(dataset: xr.Dataset) -> Chart:
    """The share of each contact in the energy that the contacts dissipate per cycle, a panel for each curve."""
    cases = spread(dataset.sizes["case"], look.MOST_PANELS)
    energy = np.nan_to_num(dataset["dissipated"].values)
    order = np.asarray(np.argsort(-energy.sum(axis=(0, 1)), kind="stable"), dtype=np.int64)
    shown, rest = order[: len(look.CONTACTS) - 1], order[len(look.CONTACTS) - 1 :]  # contacts that have no colour left are one
    names = [str(dataset["contact"].values[c]) for c in shown] + (["others"] if rest.size else [])
    axis, x, panels = Axis("share of the dissipation", "%", limits=(0.0, 100.0)), dataset["force_ratio"].values, []
    for case in cases:
        total = energy[case].sum(axis=1, keepdims=True)
        known = total > 1e-9 * total.max(initial=0.0)
        shares = 100.0 * np.divide(energy[case], total, out=np.zeros_like(energy[case]), where=known)
        parts = [*shares[:, shown].T, *([shares[:, rest].sum(axis=1)] if rest.size else [])]
        layers: list[Layer] = []
        below = np.zeros(len(shares))
        for k, (name, part) in enumerate(zip(names, parts, strict=True)):
            above, edge = below + part, look.contact(k, width=0.5)
            layers += [
                band(x, below, above, look.contact(k), name),
                Line(x, above, edge, name, {"share in %": part}, listed=False),
            ]
            below = above
        panels.append(Panel(FORCE_RATIO, axis, layers, _name(dataset, case)))
    return Chart("Which contact dissipates", panels, shared_x=True)


@FIGURES.of("PerformanceBand")
def performance_band(dataset: xr.Dataset) -> Chart:
    """Lowest and highest peak per force over the start states, with that of virgin contacts; below, where those two peaks are."""
    x, heights, hertz = (dataset[name].values for name in ("force_ratio", "amplitude_per_force", "frequency"))
    sizes, scale = _sizes(dataset, "amplitude_per_force")
    low, high = scale * heights.T
    loss = dataset["loss_factor"].values
    top: list[Layer] = [band(x, low, high, look.BETWEEN, "all start states")]
    top += [
        Line(x, low, look.LOWER, "lowest", {"frequency in Hz": hertz[:, 0], "loss factor": loss[:, 0]}),
        Line(x, high, look.UPPER, "highest", {"frequency in Hz": hertz[:, 1], "loss factor": loss[:, 1]}),
        Line(x, scale * dataset["virgin_amplitude_per_force"].values, replace(look.EMPHASIS, dash="dot"), "virgin contacts"),
    ]
    bottom = [Line(x, hertz[:, 0], look.LOWER, "lowest"), Line(x, hertz[:, 1], look.UPPER, "highest")]
    panels = [Panel(FORCE_RATIO, sizes, top, height=2.9), Panel(FORCE_RATIO, HERTZ, bottom, height=1.9)]
    return Chart(str(dataset.attrs["title"]), panels, shared_x=True)


def _sizes(dataset: xr.Dataset, quantity: str) -> tuple[Axis, float]:
    """The axis of the peaks, and the factor from SI to its unit."""
    attributes, values = dataset[quantity].attrs, dataset[quantity].values
    unit, scale = "", 1.0
    if attributes["units"] != "1":
        shown = shown_unit(attributes["units"], float(np.nanmax(values, initial=0.0)))
        unit, scale = shown.name, 1.0 / shown.metres
    quantity_text = str(attributes["long_name"])
    if quantity == "amplitude_per_force" and "force_ratio" in dataset.dims:
        measure = measure_in(dataset)
        quantity_text = f"peak {'amplitude' if measure == DISPLACEMENT_AMPLITUDE else measure.symbol} per force"
    return Axis(quantity_text, unit, log=bool(np.isfinite(values).any())), scale


def _name(dataset: xr.Dataset, case: int) -> str:
    """What a curve is called."""
    mu = float(dataset["friction"].values[case])
    return "as built" if np.isnan(mu) else f"μ = {mu:g}"


def _curve(dataset: xr.Dataset, case: int, quantity: str, x: Array, scale: float, line: dict[str, Any]) -> list[Layer]:
    """The peaks of one case, those on isolas, where another peak becomes the highest, and the optimum."""
    curve = dataset.isel(case=case)
    height, style = scale * curve[quantity].values, line["style"]
    hover = {"frequency in Hz": curve["frequency"].values, "loss factor": curve["loss_factor"].values}
    layers: list[Layer] = [
        Line(x, height, **line, hover={**hover, "contacts": [region_of(value) for value in curve["region"].values]})
    ]
    share = curve["detached_amplitude_per_force"].values / curve["amplitude_per_force"].values
    if np.isfinite(share).any() and "amplitude" in quantity:
        layers.append(Line(x, height * share, replace(style, dash="none", marker="diamond"), ISOLA))
    swapped = np.sqrt(curve["event_low"].values * curve["event_high"].values)[curve["event_kind"].values == "swapped"]
    layers += [
        Rule(place, replace(style, dash="dot", width=0.9), SWAPPED)
        for place in swapped * (x[0] / dataset["force_ratio"].values[0])
    ]
    if np.isfinite(height).any():
        best = int(np.nanargmin(height))
        dot = replace(style, dash="none", marker="circle", size=5.0)
        layers.append(Line(x[[best]], height[[best]], dot, line["label"], {"": ["optimum"]}, listed=False))
    return layers


def region_of(number: float) -> str:
    """The name of a region, empty where there is none."""
    return REGIONS[int(number)] if np.isfinite(number) else ""


def _regions(dataset: xr.Dataset, case: int, x: Array) -> Cells:
    """The region of every point as a coloured bar."""
    regions = dataset["region"].values[case]
    edges = np.concatenate([x[:1], edges_between(x, log=True)[1:-1], x[-1:]])
    colours = np.array(
        [look.rgb(look.colour(region_of(value))) if np.isfinite(value) else np.full(3, np.nan) for value in regions]
    )
    texts = [f"{_name(dataset, case)}, F_C/F_E {ratio:.4g}: {region_of(value)}" for ratio, value in zip(x, regions, strict=True)]
    return Cells(edges, colours[None], [texts], float(case))


ALONE = look.Style("grey", width=1.6)


@FIGURES.of("DamperDesign")
def design_space(dataset: xr.Dataset) -> Chart:
    """A panel for every pair of variables, designs coloured by their worst-case peak, and the sensitivities."""
    names = [str(name) for name in dataset["variable"].values]
    pairs = most_sensitive(dataset, list(combinations(range(len(names)), 2)) or [(0, 0)])
    below = 0.4 * len(names) + 0.6
    height = min(3.2, (look.PAGE - below - 0.7) / len(pairs))
    panels = [_panel(dataset, i, j, names, height) for i, j in pairs]
    if np.any(dataset["allowed"].values == 1):
        slopes, rows = dataset["sensitivity"].values, np.arange(len(names), dtype=float)
        layers: list[Layer] = [
            Bars(rows + beside, slopes[:, side], look.Style(shade), label, width=0.36, horizontal=True)
            for side, shade, beside, label in ((0, "slip", 0.2, "1 % less"), (1, "stick", -0.2, "1 % more"))
        ]
        layers.append(Rule(0.0, look.Style("grey", width=0.8)))
        variables = Axis("", names={float(row): look.spoken(name) for row, name in enumerate(names)})
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
    return [pairs[k] for k in sorted(order[: look.MOST_PANELS])]


def _panel(dataset: xr.Dataset, i: int, j: int, names: list[str], height: float) -> Panel:
    """The designs over two variables, or over one against the worst-case peak."""
    value, size = dataset["value"].values, dataset["worst_peak"].values / _unit(dataset).metres
    allowed, peak = dataset["allowed"].values == 1, Axis("worst-case peak", _unit(dataset).name)
    other = value[:, j] if i != j else size
    layers: list[Layer] = []
    if not allowed.all():
        layers.append(Line(value[~allowed, i], other[~allowed], look.CROSS, "breaks a constraint"))
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
        layers.append(Line([best[i]], [level], look.Style("ink", "none", marker="star", size=10.0), "best"))
    if given := int(dataset.attrs.get("known", 0)):
        layers.append(Line(value[:given, i], other[:given], look.Style("ink", "none", marker="square", size=8.0), "known design"))
    return Panel(Axis(look.spoken(names[i])), Axis(look.spoken(names[j])) if i != j else peak, layers, height=height)
