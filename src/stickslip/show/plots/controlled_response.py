"""Controlled response: the force that holds an amplitude, and its phase, over frequency; phase resonances over the amplitude."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stickslip.results.view import shown_unit, size_text
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, spans
from stickslip.show.plots.look import EMPHASIS, Style, level_lines
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.checks import Array
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome
from stickslip.support.renderers import FIGURES

AT_90 = "force and displacement at 90°"


@FIGURES.of("ControlledResponse")
def controlled_response(dataset: xr.Dataset) -> Chart:
    """Force level and phase against frequency, one curve a held amplitude; rings mark where force and displacement are at 90°."""
    force, phase = _force_axis(dataset, "force_level"), Axis("phase", "°")
    units = dataset["held_amplitude"].attrs["units"]
    labels = [size_text(float(value), units, dataset) for value in dataset["held_amplitude"].values]
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
    shown = shown_unit(units, float(np.max(amplitude, initial=0.0)))
    across = Axis(f"amplitude of the {dataset.attrs['quantity']}", shown.name, log=spans(amplitude, 8.0))
    axes = HERTZ, replace(_force_axis(dataset, force), log=spans(values[1], 8.0)), Axis("loss factor")
    style: Style = replace(EMPHASIS, marker="circle")
    panels = [
        Panel(across, axis, [Line(amplitude / shown.metres, value, style)], height=1.9)
        for axis, value in zip(axes, values, strict=True)
    ]
    return Chart(f"{_title(dataset).removesuffix(' held')}: {AT_90}", panels, shared_x=True, legend=False)
