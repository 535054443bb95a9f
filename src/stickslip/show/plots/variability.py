"""Variability of responses over the start states and parameters: samples and percentiles, bounds, sensitivity indices."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.variability.samples import percentiles
from stickslip.results.view import Length, along_curve_as, force_text, frequencies, measure_in, peak_unit, shown_unit
from stickslip.show.plots import look
from stickslip.show.plots.chart import Axis, Bars, Cells, Chart, Key, Layer, Line, Panel, Rule, band, edges_between, from_zero
from stickslip.show.plots.response_curves import HERTZ, force_axis, phase, size_label, words_on_axis
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES

OUTER, INNER = (5.0, 95.0), (25.0, 75.0)
"""Ends of the two bands, per cent."""
EXTREME = look.Style(look.SAMPLE.colour, "dot", 1.0)


@FIGURES.of("ResponseSamples")
def response_cloud(dataset: "xr.Dataset", bounds: "xr.Dataset | None" = None, output: int = 0) -> Chart:
    """Every curve, a panel per force level, the first (virgin unless a law was given) drawn out; bounds: of the same levels."""
    measure, unit = measure_in(dataset), peak_unit(dataset)
    levels, note = look.shown_levels(np.unique(dataset["force_level"].values))
    sizes, panels = from_zero(Axis(words_on_axis(measure), unit.name)), []
    for force in levels:
        cases = np.flatnonzero(dataset["force_level"].values == force)
        layers: list[Layer] = []
        for case in cases[::-1].tolist():
            style, label = (look.EMPHASIS, "first start state") if case == cases[0] else (look.SAMPLE, "further start states")
            size = along_curve_as(dataset, measure, case, output) / unit.metres
            start = [int(dataset["start"][case]) + 1 if "start" in dataset.coords else case + 1] * size.size
            hover: dict[str, ArrayLike] = {"phase in °": phase(dataset, case, output, measure.order), "start state": start}
            layers.append(Line(frequencies(dataset, case), size, style, label, hover))
        if bounds is not None:
            scale = measure_in(bounds).per(float(force)) / unit.metres
            layers += [
                Line(bounds["resonance"].values[case, k], scale * bounds["amplitude"].values[case, k], style, label)
                for case in np.flatnonzero(np.isclose(bounds["force_level"].values, force))
                for k, (style, label) in enumerate(((look.LOWER, "lower bound"), (look.UPPER, "upper bound")))
            ]
        panels.append(Panel(HERTZ, sizes, layers, f"force {force:g}, {cases.size} start states"))
    return Chart(f"Responses of one problem: {dataset.attrs['title']}", panels, note=note, shared_x=True)


@FIGURES.of("ResponseSamples", "percentiles")
def response_percentiles(dataset: "xr.Dataset", output: int = 0) -> Chart:
    """Median, quartiles and the middle nine tenths of the amplitude at each frequency, within the lowest and highest sample."""
    table, unit = percentiles(dataset, (0.0, *OUTER, *INNER, 50.0, 100.0), output), peak_unit(dataset)
    levels, note = look.shown_levels(table["force_level"].values)
    hertz, sizes = table["frequency"].values, from_zero(Axis(words_on_axis(measure_in(dataset)), unit.name))
    panels = []
    for force in levels:
        at = table.sel(force_level=force)
        of = {float(p): at.sel(percent=p).values / unit.metres for p in table["percent"].values}
        bands: list[Layer] = [
            band(hertz, of[OUTER[0]], of[OUTER[1]], look.contact(0, opacity=0.18), "5 to 95 %"),
            band(hertz, of[INNER[0]], of[INNER[1]], look.contact(0, opacity=0.35), "25 to 75 %"),
            Line(hertz, of[50.0], look.contact(0), "median", {f"{p:g} %": of[p] for p in (*OUTER, *INNER)}),
            Line(hertz, of[0.0], EXTREME, "extremes"),
            Line(hertz, of[100.0], EXTREME, "extremes"),
        ]
        fewest, cases = int(at["solved"].min()), int(np.sum(dataset["force_level"].values == force))
        panels.append(Panel(HERTZ, sizes, bands, f"force {force:g}, at least {fewest} of {cases} start states solved"))
    return Chart(f"Percentiles over start states: {dataset.attrs['title']}", panels, note=note, shared_x=True)


@FIGURES.of("ResponseBounds")
def response_bounds(dataset: "xr.Dataset") -> Chart:
    """Amplitude bounds against frequency, a panel per force level, with the sampled start states; of peaks, their ranges."""
    if dataset.attrs["objective"] == "peak":
        return peak_ranges(dataset)
    cases, note = look.shown_levels(np.arange(dataset.sizes["case"]))
    hertz, unit = dataset["frequency"].values, bound_unit(dataset)
    sampled = replace(look.SAMPLE, dash="none", marker="circle", size=2.0)
    sizes, panels = from_zero(Axis(size_label(dataset), unit.name)), []
    for case in cases.tolist():
        low, high = dataset["amplitude"].values[case] / unit.metres
        cloud, loss = dataset["sampled_amplitude"].values[case] / unit.metres, dataset["loss_factor"].values[case]
        layers: list[Layer] = [
            band(hertz, low, high, look.BETWEEN, "between the bounds"),
            Line(np.broadcast_to(hertz, cloud.shape).ravel(), cloud.ravel(), sampled, "sampled start states"),
            Line(hertz, low, look.LOWER, "lower bound", {"loss factor": loss[0]}),
            Line(hertz, high, look.UPPER, "upper bound", {"loss factor": loss[1]}),
        ]
        panels.append(Panel(HERTZ, sizes, layers, force_text(dataset, case)))
    title = f"Bounds by {dataset.attrs['objective'].replace('_', ' ')}: {dataset.attrs['title']}"
    return Chart(title, panels, note=note, shared_x=True)


def bound_unit(dataset: "xr.Dataset") -> Length:
    """The unit to draw sizes in."""
    return shown_unit(dataset["amplitude"].attrs["units"], float(np.nanmax(dataset["amplitude"].values, initial=0.0)))


def peak_ranges(dataset: "xr.Dataset") -> Chart:
    """Range of the resonance amplitude per force, and of its frequency, against the force level."""
    levels, measure, unit = dataset["force_level"].values, measure_in(dataset), bound_unit(dataset)
    divisor = unit.metres * (np.ones(levels.size) if measure.per_force else levels)
    low, high = (dataset["amplitude"].values[:, :, 0] / divisor[:, None]).T
    hertz, loss = dataset["resonance"].values[:, :, 0].T, dataset["loss_factor"].values[:, :, 0].T
    what = "peak amplitude" if measure.kind == "amplitude" and not measure.order else f"peak {measure.symbol}"
    sizes = Axis(what, unit.name) if measure.per_force else Axis(f"{what} per force", f"{unit.name} per unit level")
    force = force_axis(dataset, levels)
    left: list[Layer] = [
        band(levels, low, high, look.BETWEEN, "between the bounds"),
        Line(levels, low, look.LOWER, "lower bound", {"frequency in Hz": hertz[0], "loss factor": loss[0]}),
        Line(levels, high, look.UPPER, "upper bound", {"frequency in Hz": hertz[1], "loss factor": loss[1]}),
        Line(levels, dataset["sampled_amplitude"].values[:, 0, 0] / divisor, look.STUCK, "virgin contacts"),
    ]
    right = [Line(levels, hertz[0], look.LOWER, "lower bound"), Line(levels, hertz[1], look.UPPER, "upper bound")]
    panels = [Panel(force, sizes, left, "Peak", 2.8), Panel(force, HERTZ, right, "Its frequency", 2.8)]
    return Chart(f"Range of the resonance: {dataset.attrs['title']}", panels, columns=2)


@FIGURES.of("ResponseBounds", "loss_factors")
def loss_factors(dataset: "xr.Dataset") -> Chart:
    """Loss factor along the lower (solid) and the upper bound (dash-dotted), one colour per force level."""
    names = [force_text(dataset, case) for case in range(dataset.sizes["case"])]
    across = dataset["frequency"].values if dataset.attrs["objective"] != "peak" else dataset["resonance"].values
    layers = []
    for case, name in enumerate(names):
        for bound, words in enumerate(("lower", "upper")):
            style = look.level(case, len(names), dash=("solid", "dashdot")[bound], marker="circle", size=3)
            x = across if across.ndim == 1 else across[case, bound]
            shown = bound == 0 and name in look.entries(names)
            values = dataset["loss_factor"].values[case, bound]
            layers.append(Line(x, values, style, name, {"": [f"{words} bound"] * values.size}, listed=shown))
    title = "Loss factor along the bounds: lower solid, upper dash-dotted"
    return Chart(title, [Panel(HERTZ, Axis("loss factor"), layers, height=3.0)])


@FIGURES.of("ResponseBounds", "start_states")
def start_states(dataset: "xr.Dataset", case: int = 0) -> Chart:
    """The start variables that make the bounds, against frequency: blue −1, white 0, red 1."""
    hertz, variables = dataset["frequency"].values, dataset["start_variable"].values[case]
    rows = variables.shape[-1]
    keys = Key("−1", look.Style("contact 0")), Key("1", look.Style("contact 5"))
    ends = [look.rgb(look.colour(key.style.colour)) for key in keys]
    panels = []
    for bound, word in enumerate(("lower", "upper")):
        values = variables[bound].T
        texts = [
            [f"start variable {k + 1}, {f:.2f} Hz: {value:.3g}" for f, value in zip(hertz, along, strict=True)]
            for k, along in enumerate(values)
        ]
        # Mixtures of white, at zero, with the colour of the nearer end.
        mixed = 1.0 + np.abs(values)[..., None] * (np.where(values[..., None] < 0.0, *ends) - 1.0)
        cells = Cells(edges_between(hertz), mixed, texts)
        axis = Axis("start variable", limits=(-0.5, rows - 0.5), upside_down=True)
        panels.append(Panel(HERTZ, axis, [cells, *keys], f"{word} bound", 1.9))
    return Chart(f"Start states of the bounds, {force_text(dataset, case)}", panels, shared_x=True)


@FIGURES.of("SensitivityIndices")
def tornado(dataset: "xr.Dataset") -> Chart:
    """A panel for amplitude and one for frequency: bars to the low and to the high end in per cent, one below the
    other, since both may lie on the same side; total indices beside the names."""
    measure = measure_in(dataset)
    peak = "peak amplitude" if measure == DISPLACEMENT_AMPLITUDE else f"peak {measure.symbol}"
    panels = []
    for q, quantity in enumerate((peak, "peak frequency")):
        middle, total = float(dataset["middle"].values[q]), dataset["total"].values[:, q]
        ends = [100.0 * (dataset[key].values[:, q] / middle - 1.0) for key in ("low_end", "high_end")]
        order = np.argsort(np.max(np.abs(ends), axis=0))
        names = [f"{look.spoken(str(dataset['parameter'].values[k]))}, {total[k]:.2f}" for k in order]
        rows, hover = np.arange(len(names), dtype=float), {"total index": total[order]}
        layers: list[Layer] = [
            Bars(rows + beside, values[order], look.contact(k), label, width=0.32, horizontal=True, hover=hover)
            for k, (values, label, beside) in enumerate(zip(ends, ("low end", "high end"), (0.16, -0.16), strict=True))
        ]
        layers.append(Rule(0.0, look.Style("grey", width=0.8)))
        axes = Axis(f"change of the {quantity}", "%"), Axis("", names={float(row): name for row, name in enumerate(names)})
        panels.append(Panel(*axes, layers, quantity.capitalize(), 0.6 + 0.4 * len(names)))
    return Chart("Effect of each parameter, with its total index", panels, columns=2)
