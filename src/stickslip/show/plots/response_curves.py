"""Response curves of all force levels between the free and stuck linear responses, with the peaks.

Controlled response: the force that holds an amplitude, and its phase, over frequency; phase resonances over the amplitude.

Von Mises stress along the curves, a panel for each place and a line for each force level; and the Haigh diagram: amplitude
over mean of the stress where each curve has its smallest fatigue margin, and the limit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.stress import has_fatigue, margins
from stickslip.analyses.truncation import ALLOWED
from stickslip.results import view
from stickslip.results.quantities import has_stability, unstable_steps
from stickslip.results.schema import CurveKind, kinds_in
from stickslip.results.view import frequencies, is_cloud, levels_of, representative_starts
from stickslip.show.plots.chart import Area, Axis, Chart, Layer, Line, Panel, band, from_zero, spans
from stickslip.show.plots.look import (
    CROSS,
    EMPHASIS,
    FREE,
    MOST_PANELS,
    OUTSIDE,
    STUCK,
    Style,
    contact,
    entries,
    level,
    level_lines,
)
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure, Quantity, quantity_named
from stickslip.support.checks import Array, InputError, fault, nearest
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome
from stickslip.support.renderers import FIGURES

THIN = 0.6
"""Width of the line of a start state."""


def case_lines(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Style, label and whether a legend lists it, of the line of each case. Lines of one level have one label."""
    groups = levels_of(dataset)
    styles: dict[int, Style] = {}
    labels: dict[int, str] = {}
    for place, cases in enumerate(groups):
        starts = representative_starts(dataset, cases)
        middle = starts[len(starts) // 2]  # the start state whose highest peak is the median one
        for case in cases:
            thin = is_cloud(dataset) and case != middle
            styles[case] = level(place, len(groups), **({"width": THIN, "opacity": 0.45} if thin else {}))
            if not is_cloud(dataset):
                labels[case] = view.level_text(dataset, case)
            else:
                labels[case] = f"{view.force_text(dataset, case)}, {f'{len(cases)} start states' if thin else 'median'}"
    listed = entries([labels[case] for case in range(len(labels))])
    return [{"style": styles[case], "label": labels[case], "listed": labels[case] in listed} for case in range(len(labels))]


LINEAR = {"free": ("no contacts", FREE), "stuck": ("contacts stuck", STUCK)}
"""Words and line of the linear responses."""
HERTZ = Axis("frequency", "Hz")


@FIGURES.of("ForcedResponse")
def response_curves(
    dataset: xr.Dataset, output: str | None = None, log: bool = True, per_force: bool = False, quantity: str | None = None
) -> Chart:
    """Size of a response against Hz, one curve a force level; per_force divides by the level.

    Of start states every curve is a thin line, and the one whose peak is the median is drawn out.

    quantity: displacement in µm (or m), velocity or acceleration, or per force receptance, mobility or inertance; that of the
    result's peaks unless given. It is measured as these are: amplitude of the first harmonic, rms, or largest value in time.

    Unstable parts are dashed in a response `with_stability`; parts outside the band, which do not count, are grey. An area is
    where a curve with more harmonics may lie.

    Dots mark the highest peak of what is drawn: solved where the result has peaks of it, else the highest point of the curve that
    stands above its neighbours. Crosses at the bottom mark points that did not converge.
    """
    index, own = output_index(dataset, output), view.measure_in(dataset)
    derived, per_force = quantity_named(quantity or own.name, per_force)
    measure, lines = Measure(derived, own.kind), case_lines(dataset)
    scales = [_scale(dataset, case, per_force, derived) for case in range(len(lines))]
    curves = [part for case, line in enumerate(lines) for part in _curve(dataset, case, index, scales[case], measure, line)]
    firsts = [cases[0] for cases in levels_of(dataset)][: 1 if per_force else None]
    known = view.has_linear_curves(dataset)
    linear = [Line([np.nan], [np.nan], style, words) for words, style in LINEAR.values()] if known else []
    for case in firsts if known else ():
        linear += _linear(dataset, case, index, scales[case], measure, "grey" if per_force else lines[case]["style"].colour)
    axis = response_axis(dataset, per_force, measure)
    limits = height_limits(curves, log)
    axis = replace(axis, log=log and limits[0] is not None, limits=limits)
    bands = [area for case, line in enumerate(lines) for area in _error_band(dataset, case, index, scales[case], measure, line)]
    left = any(view.outside_steps(dataset, case).any() for case in range(len(lines)))
    linear += [Line([np.nan], [np.nan], OUTSIDE, "outside the band")] if left else []
    layers = [*linear, *bands, *curves, *_peaks(dataset, index, scales, measure, lines), *_failed(dataset, axis)]
    title, name = str(dataset.attrs.get("title", "")), str(dataset.output.values[index])
    computed = dataset.frequency.values[dataset.outcome.values != Outcome.EMPTY]
    hertz = replace(HERTZ, limits=(float(computed.min()), float(computed.max())) if computed.size else (None, None))
    return Chart(f"{title}: {name}" if title else name, [Panel(hertz, axis, layers, height=4.1)])


@FIGURES.of("ForcedResponse", "peaks")
def peaks_over_force(dataset: xr.Dataset, output: str | None = None) -> Chart:
    """The highest peak of every force level: amplitude per force and frequency, against the level."""
    return compared_peaks({"highest peak": dataset}, str(dataset.output.values[output_index(dataset, output)]))


def compared_peaks(datasets: Mapping[str, xr.Dataset], output: str) -> Chart:
    """The same of several results by name, of those whose peaks are of one quantity and that have the output."""
    first = next(iter(datasets.values()))
    measure, unit = view.measure_in(first), view.length_unit(*datasets.values())
    alike = {
        label: dataset
        for label, dataset in datasets.items()
        if view.measure_in(dataset) == measure and output in dataset.output.values
    }
    force = force_axis(first, np.concatenate([dataset.force_level.values for dataset in datasets.values()]))
    sizes, hertz = [], []
    for k, (label, dataset) in enumerate(alike.items()):
        index = output_index(dataset, output)
        peaks = {case: view.highest_peak(dataset, case, index) for case in range(dataset.sizes["case"])}
        solved = [(case, peak) for case, peak in peaks.items() if peak is not None]
        kinds = kinds_in(dataset)
        swept = [pair for pair in solved if kinds[pair[0]] == CurveKind.SWEEP] or solved
        others = [pair for pair in solved if pair not in swept]
        style = replace(contact(k) if len(datasets) > 1 else Style("stick"), marker="circle", size=5.0)
        style = replace(style, dash="none", opacity=0.45) if is_cloud(dataset) else style
        levels, frequencies = dataset.force_level.values[[case for case, _ in swept]], [peak.frequency for _, peak in swept]
        per_force = [_scale(dataset, case, True, measure.quantity, unit) * peak.amplitude for case, peak in swept]
        names = {"case": [view.level_text(dataset, case) for case, _ in swept]} if is_cloud(dataset) else {}
        sizes.append(Line(levels, per_force, style, label, {"frequency in Hz": frequencies, **names}))
        hertz.append(Line(levels, frequencies, style, label, names))
        if others:
            alone, label_of_others = replace(style, dash="none", marker="diamond"), "other curves"
            sized = [_scale(dataset, case, True, measure.quantity, unit) * peak.amplitude for case, peak in others]
            levels = dataset.force_level.values[[case for case, _ in others]]
            curves = [view.level_text(dataset, case) for case, _ in others]
            sizes.append(Line(levels, sized, alone, label_of_others, {"curve": curves}))
            hertz.append(Line(levels, [peak.frequency for _, peak in others], alone, label_of_others, {"curve": curves}))
    left = Panel(force, from_zero(response_axis(first, True, measure, unit)), sizes, "Highest peak", 2.8)
    return Chart(
        f"Highest peak of each force level: {output}",
        [left, Panel(force, HERTZ, hertz, "Its frequency", 2.8)],
        columns=2,
        legend=len(alike) > 1,
    )


def force_axis(dataset: xr.Dataset, levels: Array) -> Axis:
    """Force levels, on a logarithmic axis where they span much."""
    return Axis("force level", "N" if view.levels_in_newtons(dataset) else "", log=spans(levels, 8.0))


def output_index(dataset: xr.Dataset, output: str | None) -> int:
    """Index of the named output; the first without a name."""
    names = [str(name) for name in dataset.output.values]
    if output is not None and output not in names:
        raise fault("output", f"must be an output of the result. {nearest(output, names)} It", output)
    return 0 if output is None else names.index(output)


def response_axis(
    dataset: xr.Dataset, per_force: bool, measure: Measure = DISPLACEMENT_AMPLITUDE, length: view.Length | None = None
) -> Axis:
    """The axis of sizes of a response; length: the unit of displacements, that of the result unless given."""
    unit = view.quantity_unit(length or view.length_unit(dataset), measure.quantity).name
    if not per_force:
        return Axis(words_on_axis(measure), unit)
    unit += "/N" if view.levels_in_newtons(dataset) else " per unit level"
    return Axis(f"amplitude per force {measure.symbol}/F" if measure.kind == "amplitude" else f"{measure.symbol} per force", unit)


def words_on_axis(measure: Measure) -> str:
    """What a size is, without its unit: "amplitude |X₁|"."""
    return f"amplitude {measure.symbol}" if measure.kind == "amplitude" else measure.symbol


def size_label(dataset: xr.Dataset) -> str:
    """What sizes of a result are, as its peaks are measured, without their unit: "amplitude |X₁|", "amplitude ω²|X₁|/F"."""
    measure = view.measure_in(dataset)
    return words_on_axis(measure) + ("/F" if measure.per_force else "")


def phase(dataset: xr.Dataset, case: int, output: int, order: int = 0) -> Array:
    """Phase of the first harmonic of a time derivative against cos ωt at `points`, degrees above −180 and up to 180."""
    parts = view.along_curve(dataset, "response", case)[:, output, view.periods_of(dataset)]
    degrees = np.degrees(np.angle((parts[:, 0] + 1j * parts[:, 1]) * 1j**order))
    return np.asarray(np.where(degrees <= -180.0, 180.0, degrees))


def _scale(dataset: xr.Dataset, case: int, per_force: bool, quantity: Quantity, length: view.Length | None = None) -> float:
    """Factor from SI to what is drawn."""
    level = abs(float(dataset.force_level[case])) or np.nan
    return 1.0 / view.quantity_unit(length or view.length_unit(dataset), quantity).metres / (level if per_force else 1.0)


def _curve(dataset: xr.Dataset, case: int, output: int, scale: float, measure: Measure, line: dict[str, Any]) -> Iterator[Line]:
    """One curve, its unstable parts dashed where their stability is known."""
    size = scale * view.along_curve_as(dataset, measure, case, output)
    few = {"marker": "circle", "size": 3.0} if np.count_nonzero(np.isfinite(size)) < 12 else {}
    hover = {
        "phase in °": phase(dataset, case, output, measure.order),
        "loss factor": view.along_curve(dataset, "loss_factor", case),
    }
    hover |= {"dissipated per period in J": np.sum(view.along_curve(dataset, "dissipated", case), axis=1)}
    curve = Line(frequencies(dataset, case), size, **{**line, "style": replace(line["style"], **few)}, hover=hover)
    parts, unstable = [curve], unstable_steps(dataset, case) if has_stability(dataset) else np.zeros(0, dtype=bool)
    if unstable.any():
        stable_part, unstable_part = view.split(size, unstable)
        dashed = replace(curve, y=unstable_part, style=replace(curve.style, dash="dash"), listed=False)
        parts = [replace(curve, y=stable_part), dashed]
    for part in parts:
        yield from parted(part, view.outside_steps(dataset, case))


def parted(curve: Line, outside: np.ndarray) -> Iterator[Line]:
    """A curve, grey along the steps that lie outside the band."""
    if not outside.any():
        yield curve
        return
    within, beyond = view.split(np.asarray(curve.y, dtype=float), outside)
    yield replace(curve, y=within)
    yield replace(curve, y=beyond, style=replace(curve.style, colour=OUTSIDE.colour), listed=False)


def _error_band(
    dataset: xr.Dataset, case: int, output: int, scale: float, measure: Measure, line: dict[str, Any]
) -> Iterator[Area]:
    """The area that a curve with more harmonics may lie in, X/(1 + e) to X(1 + e), where the error e is not small."""
    if "point_truncation_error" not in dataset or is_cloud(dataset):
        return
    error = view.along_curve(dataset, "point_truncation_error", case)[:, output]
    error[~(error > ALLOWED)] = np.nan
    if np.isfinite(error).any():
        size = scale * view.along_curve_as(dataset, measure, case, output)
        style = replace(line["style"], opacity=0.25)
        yield band(frequencies(dataset, case), size / (1.0 + error), size * (1.0 + error), style, "estimated error of harmonics")


def _peaks(
    dataset: xr.Dataset, output: int, scales: list[float], measure: Measure, lines: list[dict[str, Any]]
) -> Iterator[Layer]:
    """A dot at the highest peak of each curve, a small one on a thin line."""
    for case, line in enumerate(lines):
        peak = view.highest_maximum(dataset, case, output, measure)
        if peak is not None:
            style = replace(line["style"], dash="none", marker="circle", size=2.5 if line["style"].width == THIN else 5.0)
            yield Line([peak[0]], [scales[case] * peak[1]], style, line["label"], {"": ["highest peak"]}, listed=False)


def _failed(dataset: xr.Dataset, axis: Axis) -> Iterator[Layer]:
    """Points that did not converge, at the foot of the panel, each with its cause."""
    failed = [(case, point) for case in range(dataset.sizes["case"]) for point in view.failed_points(dataset, case)]
    if failed:
        low, high = axis.limits if axis.limits[0] is not None else (0.0, 1.0)
        foot = low * (high / low) ** 0.015 if axis.log and low and high else 0.015 * (high or 1.0)
        frequency = [float(dataset.frequency.values[point]) for point in failed]
        causes = [Outcome(int(dataset.outcome.values[point])).name.lower().replace("_", " ") for point in failed]
        yield Line(frequency, [foot] * len(failed), CROSS, "not converged", {"cause": causes})


def _linear(dataset: xr.Dataset, case: int, output: int, scale: float, measure: Measure, colour: str) -> Iterator[Line]:
    """The curves without contacts and with all of them stuck at the force level of one case."""
    omegas = 2.0 * np.pi * dataset.linear_frequency.values
    for which, (words, style) in LINEAR.items():
        values: Array = dataset[f"{which}_amplitude"].values[case, :, output]
        size = scale * measure.of_harmonic(values, omegas)
        style = replace(style, colour=colour, opacity=0.6)
        yield Line(dataset.linear_frequency.values, size, style, words, listed=False)


def height_limits(curves: Sequence[Line], log: bool) -> tuple[float | None, float | None]:
    """From zero on a linear axis, from a little below the lowest curve on a logarithmic one; linear curves may go out of it."""
    heights = np.concatenate([np.asarray(curve.y, dtype=float) for curve in curves])
    heights = heights[np.isfinite(heights) & (heights > 0.0)]
    if not heights.size:
        return (None, None)
    return (0.7 * float(heights.min()), 1.6 * float(heights.max())) if log else (0.0, 1.06 * float(heights.max()))


AT_90 = "force and displacement at 90°"


@FIGURES.of("ControlledResponse")
def controlled_response(dataset: xr.Dataset) -> Chart:
    """Force level and phase against frequency, one curve a held amplitude; rings mark where force and displacement are at 90°."""
    force, phase = _force_axis(dataset, "force_level"), Axis("phase", "°")
    units = dataset["held_amplitude"].attrs["units"]
    labels = [view.size_text(float(value), units, dataset) for value in dataset["held_amplitude"].values]
    top: list[Layer] = []
    bottom: list[Layer] = []
    for case, look in enumerate(level_lines(labels)):
        hertz, degrees = _along(dataset, "phase", case)
        hover = {"phase in °": degrees, "loss factor": _along(dataset, "loss_factor", case)[1]}
        top.append(Line(*_along(dataset, "force_level", case), **look, hover=hover))
        if dataset.sizes["resonance"]:
            ring = replace(look["style"], dash="none", marker="ring", size=5.0)
            at, lowest = (dataset[f"resonance_{name}"].values[case] for name in ("frequency", "force_level"))
            top.append(Line(at, lowest, ring, look["label"], {"": [AT_90] * at.size}, listed=False))
        bottom.append(Line(hertz, degrees, **look))
    panels = [Panel(HERTZ, force, top, height=3.2), Panel(HERTZ, phase, bottom, height=1.9)]
    return Chart(_title(dataset), panels, shared_x=True)


@FIGURES.of("ControlledResponse", "resonances")
def resonances(dataset: xr.Dataset) -> Chart:
    """Frequency, force and loss factor of the phase resonance with the lowest force against the held amplitude."""
    order = np.argsort(dataset["held_amplitude"].values)
    amplitude = dataset["held_amplitude"].values[order]
    names = ("resonance_frequency", "resonance_force_level", "resonance_loss_factor")
    none = np.full((order.size, 0), np.nan)
    columns = [dataset[name].values[order] if dataset.sizes["resonance"] else none for name in names]
    values = [column[:, 0] if column.shape[1] else np.full(order.size, np.nan) for column in columns]
    return _over_amplitude(dataset, "held_amplitude", names[1], amplitude, values)


@FIGURES.of("PhaseResonance")
def phase_resonance(dataset: xr.Dataset) -> Chart:
    """Frequency, force and loss factor of the followed phase resonance against the amplitude."""
    values = [dataset[name].values for name in ("frequency", "force_level", "loss_factor")]
    return _over_amplitude(dataset, "amplitude", "force_level", dataset["amplitude"].values, values)


def _title(dataset: xr.Dataset) -> str:
    return f"{dataset.attrs.get('title', '')}: {dataset.attrs['quantity']} of {dataset.attrs['output_held']} held".removeprefix(
        ": "
    )


def _force_axis(dataset: xr.Dataset, name: str) -> Axis:
    """Force in N, or force level."""
    values, newtons = dataset[name].values, dataset[name].attrs["units"] == "N"
    known = values[np.isfinite(values)]
    return Axis("force" if newtons else "force level", "N" if newtons else "", log=spans(known, 8.0))


def _along(dataset: xr.Dataset, name: str, case: int) -> tuple[Array, Array]:
    """Frequency and a variable along the points of a case that were solved."""
    at = dataset["outcome"].values[case] == Outcome.CONVERGED
    return dataset["frequency"].values[case][at], dataset[name].values[case][at]


def _over_amplitude(dataset: xr.Dataset, name: str, force: str, amplitude: Array, values: list[Array]) -> Chart:
    """Three panels over the amplitude: frequency, force, loss factor."""
    units = dataset[name].attrs["units"]
    shown = view.shown_unit(units, float(np.max(amplitude, initial=0.0)))
    across = Axis(f"amplitude of the {dataset.attrs['quantity']}", shown.name, log=spans(amplitude, 8.0))
    axes = HERTZ, replace(_force_axis(dataset, force), log=spans(values[1], 8.0)), Axis("loss factor")
    style: Style = replace(EMPHASIS, marker="circle")
    panels = [
        Panel(across, axis, [Line(amplitude / shown.metres, value, style)], height=1.9)
        for axis, value in zip(axes, values, strict=True)
    ]
    return Chart(f"{_title(dataset).removesuffix(' held')}: {AT_90}", panels, shared_x=True, legend=False)


MPa = 1e6


@FIGURES.of("ForcedResponse", "stress")
def stress_curves(dataset: xr.Dataset) -> Chart:
    """Largest von Mises stress over the period against Hz at each place; dots mark the largest of each curve."""
    if "stress_von_mises" not in dataset:
        raise InputError("The figure of stress must have stress along the curves. Draw `response.with_stress(recovery)`.")
    names = [str(name) for name in dataset["place"].values]
    counted = view.inside_band(dataset, "stress_von_mises")
    largest = np.nan_to_num(counted).max(axis=(0, 1), initial=0.0)
    places = sorted(np.argsort(-largest, kind="stable")[:MOST_PANELS].tolist())  # the most stressed, in their old order
    note = f"{len(places)} of {len(names)} places, the most stressed" if len(places) < len(names) else ""
    panels = []
    for place in places:
        layers: list[Layer] = []
        for case, line in enumerate(case_lines(dataset)):
            hertz, stress = frequencies(dataset, case), view.along_curve(dataset, "stress_von_mises", case)[:, place] / MPa
            layers.append(Line(hertz, stress, **line))
            inside = counted[case, view.points(dataset, case), place]
            if np.any(np.isfinite(inside)):
                top, dot = int(np.nanargmax(inside)), replace(line["style"], dash="none", marker="circle")
                layers.append(Line(hertz[[top]], stress[[top]], dot, line["label"], {"": ["largest"]}, listed=False))
        panels.append(Panel(HERTZ, Axis("von Mises stress", "MPa", log=True), layers, names[place], 2.3))
    return Chart(f"Stress: {dataset.attrs['title']}", panels, note=note, shared_x=True)


FAR = 10.0
"""Margin above which all stresses would lie on the axis of a linear scale."""


@FIGURES.of("ForcedResponse", "haigh")
def haigh_diagram(dataset: xr.Dataset) -> Chart:
    """A dot for each place of stress and force level; below the line the material stands the stress for ever."""
    if not has_fatigue(dataset):
        raise InputError("A Haigh diagram must have a fatigue limit. Draw `response.with_stress().with_fatigue(limit)`.")
    limit = f"fatigue limit, {dataset.attrs['fatigue_criterion']}"
    drawn, sizes = dataset["haigh_mean"].values / MPa, dataset["haigh_limit"].values / MPa
    layers: list[Layer] = [Line(drawn, np.where(sizes > 0.0, sizes, np.nan), Style("grey", "dash", 1.4), limit)]
    every_margin = list(margins(dataset))
    for case, line in enumerate(case_lines(dataset)):
        here = [margin for margin in every_margin if margin.case == case]
        if here:
            hover: dict[str, ArrayLike] = {
                "": [margin.place for margin in here],
                "frequency in Hz": np.array([margin.frequency for margin in here]),
                "margin": np.array([margin.size for margin in here]),
            }
            means, sizes = (np.array([getattr(margin, name) for margin in here]) / MPa for name in ("mean", "alternating"))
            dots = replace(line["style"], dash="none", marker="circle", size=5.0)
            layers.append(Line(means, sizes, dots, line["label"], hover, line["listed"]))
    far = all(margin.size > FAR for margin in every_margin)
    axes = Axis("mean stress", "MPa"), Axis("stress amplitude", "MPa", log=far, limits=(None if far else 0.0, None))
    return Chart(f"Haigh diagram: {dataset.attrs['title']}", [Panel(*axes, layers, height=3.2)])
