"""Response curves of all force levels between the free and stuck linear responses, with the peaks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from stickslip.checks import Array, fault, nearest
from stickslip.harmonic.measure import DISPLACEMENT_AMPLITUDE, Measure, Quantity, quantity_named
from stickslip.plots.case_lines import Line, case_lines
from stickslip.plots.look import FAILED, GREY, beside, house_style, plain
from stickslip.results.representative import is_cloud, levels_of
from stickslip.results.view import (
    along_curve_as,
    failed_points,
    frequencies,
    highest_maximum,
    highest_peak,
    length_unit,
    levels_in_newtons,
    measure_in,
    quantity_unit,
)

if TYPE_CHECKING:
    import xarray as xr

LINEAR_STYLES = {"free": (0, (1.2, 1.6)), "stuck": (0, (5, 2))}
LINEAR_WORDS = {"free": "no contacts", "stuck": "contacts stuck"}


def response_curves(
    dataset: xr.Dataset,
    output: str | None = None,
    log: bool = True,
    per_force: bool = False,
    quantity: str | None = None,
) -> Figure:
    """Size of a response against Hz, one curve a force level; per_force divides by the level.

    Of start states every curve is a thin line, and the one whose peak is the median is drawn out.

    quantity: displacement in µm (or m), velocity or acceleration, or per force receptance, mobility or inertance; that of the
    result's peaks unless given. It is measured as these are: amplitude of the first harmonic, rms, or largest value in time.

    Dots mark the highest peak of what is drawn: solved where the result has peaks of it, else the highest point of the curve that
    stands above its neighbours. Points without convergence are crosses on the frequency axis.
    """
    index, own = output_index(dataset, output), measure_in(dataset)
    derived, per_force = quantity_named(quantity or own.name, per_force)
    measure = Measure(derived, own.kind)
    with house_style():
        figure = Figure(figsize=(7.6, 4.8), layout="constrained")
        axes = figure.add_subplot()
        lines, firsts = case_lines(dataset), [cases[0] for cases in levels_of(dataset)]
        for case, line in enumerate(lines):
            scale = _scale(dataset, case, per_force, derived)
            if case in firsts:
                _linear_curves(axes, dataset, case, index, scale, measure, line["color"] if not per_force else GREY)
            _curve(axes, dataset, case, index, scale, measure, line)
        _finish(axes, dataset, index, log, amplitude_label(dataset, per_force, measure))
    return figure


def peaks_over_force(dataset: xr.Dataset, output: str | None = None) -> Figure:
    """The highest peak of every force level: amplitude per force and frequency, against the level."""
    index, measure = output_index(dataset, output), measure_in(dataset)
    peaks = [highest_peak(dataset, case, index) for case in range(dataset.sizes["case"])]
    found = [(float(dataset.force_level[case]), peak) for case, peak in enumerate(peaks) if peak is not None]
    levels = np.array([level for level, _ in found])
    scales = [_scale(dataset, case, True, measure.quantity) for case in range(len(peaks))]
    per_force = np.array([scale * peak.amplitude for scale, peak in zip(scales, peaks, strict=True) if peak is not None])
    with house_style():
        figure = Figure(figsize=(7.6, 3.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        style: Line = {"color": "#2b6ca3", "marker": "o", "markersize": 5}
        style |= {"linestyle": "", "alpha": 0.45} if is_cloud(dataset) else {}
        left.plot(levels, per_force, **style)
        right.plot(levels, [peak.frequency for _, peak in found], **style)
        left.set(title=f"Highest peak, {plain(dataset.output.values[index])}", ylim=(0.0, None))
        left.set_ylabel(amplitude_label(dataset, True, measure))
        right.set(title="Its frequency", ylabel="frequency in Hz")
        for axes in (left, right):
            axes.set_xlabel("force level in N" if levels_in_newtons(dataset) else "force level")
            if levels.size > 1 and levels.min() > 0.0 and levels.max() > 8.0 * levels.min():
                axes.set_xscale("log")
    return figure


def output_index(dataset: xr.Dataset, output: str | None) -> int:
    """Index of the named output; the first without a name."""
    names = [str(name) for name in dataset.output.values]
    if output is not None and output not in names:
        raise fault("output", f"must be an output of the result. {nearest(output, names)} It", output)
    return 0 if output is None else names.index(output)


def amplitude_label(dataset: xr.Dataset, per_force: bool, measure: Measure = DISPLACEMENT_AMPLITUDE) -> str:
    """What the amplitude axis says."""
    unit = quantity_unit(length_unit(dataset), measure.quantity).name
    if not per_force:
        return f"{words_on_axis(measure)} in {unit}"
    per = "/N" if levels_in_newtons(dataset) else " per unit level"
    if measure.kind == "amplitude":
        return f"amplitude per force {measure.symbol}/F in {unit}{per}"
    return f"{measure.symbol} per force in {unit}{per}"


def words_on_axis(measure: Measure) -> str:
    """What a size is, without its unit: "amplitude |X₁|"."""
    return f"amplitude {measure.symbol}" if measure.kind == "amplitude" else measure.symbol


def size_label(dataset: xr.Dataset) -> str:
    """What sizes of a result are, as its peaks are measured, without their unit: "amplitude |X₁|", "amplitude ω²|X₁|/F"."""
    measure = measure_in(dataset)
    return words_on_axis(measure) + ("/F" if measure.per_force else "")


def _scale(dataset: xr.Dataset, case: int, per_force: bool, quantity: Quantity) -> float:
    """Factor from SI to what is drawn."""
    level = abs(float(dataset.force_level[case])) or np.nan
    return 1.0 / quantity_unit(length_unit(dataset), quantity).metres / (level if per_force else 1.0)


def _curve(axes: Axes, dataset: xr.Dataset, case: int, output: int, scale: float, measure: Measure, line: Line) -> None:
    amplitude = along_curve_as(dataset, measure, case, output)
    few = np.count_nonzero(np.isfinite(amplitude)) < 3
    axes.plot(frequencies(dataset, case), scale * amplitude, ".-" if few else "-", **line)
    peak = highest_maximum(dataset, case, output, measure)
    if peak is not None:
        edge = {"markersize": 2.5} if "alpha" in line else {"markersize": 5, "markeredgecolor": "white"}
        axes.plot(peak[0], scale * peak[1], "o", color=line["color"], zorder=4, **edge)
    failed = dataset.frequency.values[case, failed_points(dataset, case)]
    foot = axes.get_xaxis_transform()
    axes.plot(failed, np.full(failed.size, 0.015), "x", color=FAILED, markersize=5, transform=foot, clip_on=False, zorder=5)


def _linear_curves(axes: Axes, dataset: xr.Dataset, case: int, output: int, scale: float, measure: Measure, colour: str) -> None:
    omegas = 2.0 * np.pi * dataset.linear_frequency.values
    for which, style in LINEAR_STYLES.items():
        values: Array = dataset[f"{which}_amplitude"].values[case, :, output]
        axes.plot(
            dataset.linear_frequency.values,
            scale * measure.of_harmonic(values, omegas),
            color=colour,
            linestyle=style,
            linewidth=0.9,
            alpha=0.55,
        )


def _finish(axes: Axes, dataset: xr.Dataset, output: int, log: bool, label: str) -> None:
    title, name = plain(dataset.attrs.get("title", "")), plain(dataset.output.values[output])
    axes.set_title(f"{title}: {name}" if title else name)
    axes.set(xlabel="frequency in Hz", ylabel=label)
    _limits(axes, dataset, log)
    handles, _ = axes.get_legend_handles_labels()
    for which, style in LINEAR_STYLES.items():
        handles.append(Line2D([], [], color=GREY, linestyle=style, linewidth=1.1, label=LINEAR_WORDS[which]))
    if np.any(np.isin(dataset.outcome.values, (0, 1), invert=True)):
        handles.append(Line2D([], [], color=FAILED, marker="x", linestyle="", markersize=5, label="not converged"))
    beside(axes, handles)


def _limits(axes: Axes, dataset: xr.Dataset, log: bool) -> None:
    """The band that was computed; from zero on a linear axis, from a little below the lowest curve on a logarithmic one."""
    computed = dataset.frequency.values[dataset.outcome.values != 0]
    if computed.size and computed.min() < computed.max():
        axes.set_xlim(float(computed.min()), float(computed.max()))
    heights = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in _curve_lines(axes)])
    heights = heights[np.isfinite(heights) & (heights > 0.0)]
    if log and heights.size:
        axes.set_yscale("log")
        axes.set_ylim(0.7 * float(heights.min()), 1.6 * float(heights.max()))
    elif heights.size:
        axes.set_ylim(0.0, 1.06 * float(heights.max()))


def _curve_lines(axes: Axes) -> list[Line2D]:
    """The curves of the force levels: the linear ones may go out of the picture."""
    return [line for line in axes.lines if not str(line.get_label()).startswith("_")] or list(axes.lines)
