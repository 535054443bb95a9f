"""Von Mises stress along the curves, one panel per place and one line per force level."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import along_curve, frequencies
from stickslip.show.plots.case_lines import case_lines
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel
from stickslip.show.plots.look import MOST_PANELS
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.checks import InputError
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

MPa = 1e6


@FIGURES.of("ForcedResponse", "stress")
def stress_curves(dataset: xr.Dataset) -> Chart:
    """Largest von Mises stress over the period against Hz at each place; dots mark the largest of each curve."""
    if "stress_von_mises" not in dataset:
        raise InputError("The figure of stress must have stress along the curves. Draw `response.with_stress(recovery)`.")
    names = [str(name) for name in dataset["place"].values]
    largest = np.nan_to_num(dataset["stress_von_mises"].values).max(axis=(0, 1), initial=0.0)
    places = sorted(np.argsort(-largest, kind="stable")[:MOST_PANELS].tolist())  # the most stressed, in their old order
    note = f"{len(places)} of {len(names)} places, the most stressed" if len(places) < len(names) else ""
    panels = []
    for place in places:
        layers: list[Layer] = []
        for case, line in enumerate(case_lines(dataset)):
            hertz, stress = frequencies(dataset, case), along_curve(dataset, "stress_von_mises", case)[:, place] / MPa
            layers.append(Line(hertz, stress, **line))
            if np.any(np.isfinite(stress)):
                top, dot = int(np.nanargmax(stress)), replace(line["style"], dash="none", marker="circle")
                layers.append(Line(hertz[[top]], stress[[top]], dot, line["label"], {"": ["largest"]}, listed=False))
        panels.append(Panel(HERTZ, Axis("von Mises stress", "MPa", log=True), layers, names[place], 2.3))
    return Chart(f"Stress: {dataset.attrs['title']}", panels, note=note, shared_x=True)
