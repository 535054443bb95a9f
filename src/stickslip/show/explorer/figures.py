"""What the explorer shows of an answer: the curve beside its reference, the peak in two numbers, and one point in detail."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from stickslip.analyses.performance.curve import PerformanceCurve
from stickslip.analyses.solved_points import has_surface
from stickslip.results import view
from stickslip.results.schema import system_of
from stickslip.show.explorer.solving import Answer
from stickslip.show.plots.chart import Axis, Bars, Chart, Layer, Line, Panel, Rule, shown_chart
from stickslip.show.plots.interactive import plotly_figure
from stickslip.show.plots.look import Style, contact
from stickslip.show.plots.performance_curve import performance_curves
from stickslip.show.plots.response_curves import HERTZ, LINEAR, parted, response_axis
from stickslip.support.late import xr

THIS, PINNED = "this study", "reference"


def curve_figure(answer: Answer, pinned: Answer | None, output: str, log: bool, dark: bool) -> dict[str, Any]:
    """The response, the reference, and the linear responses without contacts and with stuck ones."""
    dataset = answer.response.dataset
    shown = [(answer, THIS, Style("contact 5", width=2.4))]
    if pinned is not None:
        shown.insert(0, (pinned, PINNED, Style("contact 0", "dash", 1.6)))
    unit, measure, hertz = _unit(answer, pinned), view.measure_in(dataset), dataset.linear_frequency.values
    linear: list[Layer] = []
    for state, (label, style) in LINEAR.items():
        amplitudes = dataset[f"{state}_amplitude"].values[0, :, answer.place(output)]
        linear.append(Line(hertz, measure.of_harmonic(amplitudes, 2.0 * np.pi * hertz) / unit.metres, style, label))
    layers: list[Layer] = []
    for each, label, style in shown:
        own = each.response.dataset
        place = each.place(output)
        sizes = view.along_curve_as(own, measure, 0, place) / unit.metres
        layers += parted(Line(view.frequencies(own, 0), sizes, style, label), view.outside_steps(own, 0))
        peak = view.highest_peak(own, 0, place)
        if peak is not None:
            dot = Style(style.colour, "none", marker="circle", size=7.0)
            layers.append(Line([peak.frequency], [peak.amplitude / unit.metres], dot))
    axis = response_axis(dataset, False, measure, unit)
    heights = np.concatenate([np.asarray(layer.y, dtype=float) for layer in layers if isinstance(layer, Line)])
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    limits = (0.5 * low, 2.0 * high) if log else (0.0, 1.3 * high)
    axis = Axis(axis.quantity, axis.unit, log=log, limits=limits)
    panel = Panel(HERTZ, axis, [*linear, *layers], height=4.4)
    return _figure(Chart(output, [panel]), dataset, dark)


def peak_words(answer: Answer, output: str) -> tuple[str, str]:
    """Frequency and amplitude of the highest peak, the two large numbers."""
    dataset = answer.response.dataset
    peak = view.highest_peak(dataset, 0, answer.place(output))
    if peak is None:
        return "–", "–"
    measure, units = view.measure_in(dataset), str(dataset["peak_amplitude"].attrs["units"])
    per = measure.per(float(dataset.force_level[0]))
    return f"{peak.frequency:.6g} Hz", view.size_text(peak.amplitude / per, units, dataset)


def change_words(answer: Answer, pinned: Answer | None, output: str) -> tuple[str, str]:
    """How far frequency and amplitude are from those of the reference."""
    own = view.highest_peak(answer.response.dataset, 0, answer.place(output))
    other = None if pinned is None else view.highest_peak(pinned.response.dataset, 0, pinned.place(output))
    if own is None or other is None:
        return "", ""
    frequency, amplitude = own.frequency / other.frequency - 1.0, own.amplitude / other.amplitude - 1.0
    return f"{frequency:+.3%} from the reference", f"{amplitude:+.3%} from the reference"


def clicked_point(answer: Answer, pinned: Answer | None, output: str, x: float, y: float) -> int:
    """The converged point nearest to a place of the drawn curve, x in Hz and y in the unit of the axis."""
    return view.nearest_point(answer.response.dataset, 0, answer.place(output), x, y * _unit(answer, pinned).metres)


def _unit(answer: Answer, pinned: Answer | None) -> view.Length:
    """The unit of the curves."""
    return view.peak_unit(*(each.response.dataset for each in (answer, pinned) if each is not None))


def peak_place(answer: Answer, output: str) -> int | None:
    """The point of the highest peak."""
    peak = view.highest_peak(answer.response.dataset, 0, answer.place(output))
    return None if peak is None else peak.point


def detail_figures(answer: Answer, point: int, output: str, dark: bool, narrow: bool) -> list[dict[str, Any]]:
    """Motion with loops and contact states, deformed shape, energy by contact and harmonics at a point."""
    response = answer.response
    dataset = response.dataset
    figures = []
    if dataset.sizes["contact"]:
        figures.append(response.animate(0, point).to_plotly(dark=dark, narrow=narrow).to_dict())
    if has_surface(response.problem):
        figures.append(response.deformed_shape(0, point).to_plotly(dark=dark, narrow=narrow).to_dict())
    energy = np.nan_to_num(view.dissipated(dataset, 0)[int(np.searchsorted(view.points(dataset, 0), point))])
    joules, unit = view.energy_unit(float(energy.max(initial=0.0)))
    names = {float(k): str(name) for k, name in enumerate(dataset.contact.values)}
    contacts = Axis("", names=names if len(names) <= 16 else {}, upside_down=True)
    by_contact = Bars(np.arange(energy.size), energy / joules, contact(2), horizontal=True)
    parts, length = dataset["response"].values[0, point, answer.place(output)], view.peak_unit(dataset)
    sizes = np.hypot(parts[:, 0], parts[:, 1]) / length.metres
    harmonics, amplitude = Bars(np.arange(sizes.size), sizes, contact(0)), Axis("amplitude", length.name, log=True)
    panels = [
        Panel(Axis("energy per period", unit), contacts, [by_contact], "Energy by contact", 2.8),
        Panel(Axis("harmonic"), amplitude, [harmonics], "Harmonics of the displacement", 2.8),
    ]
    chart = Chart("Energy and harmonics", panels, columns=2, legend=False)
    return [*figures, _figure(chart, dataset, dark)]


def performance_figure(curve: PerformanceCurve, ratio: float, dark: bool) -> dict[str, Any]:
    """The performance curve with the present ratio of pull and excitation."""
    chart = performance_curves(curve.dataset)
    rule = Rule(ratio, Style("contact 5", "dash", 2.0), THIS)
    marked = replace(chart, panels=[replace(panel, layers=[*panel.layers, rule]) for panel in chart.panels])
    return _figure(marked, curve.dataset, dark)


def _figure(chart: Chart, dataset: xr.Dataset, dark: bool) -> dict[str, Any]:
    """A chart in the units of the study."""
    shown = shown_chart(chart, system_of(dataset))
    found: dict[str, Any] = plotly_figure(shown, dark).update_layout(uirevision="kept", autosize=True).to_dict()
    return found
