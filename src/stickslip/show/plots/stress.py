"""Von Mises stress along the curves, a panel for each place and a line for each force level; and the Haigh diagram: amplitude
over mean of the stress where each curve has its smallest fatigue margin, and the limit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.fatigue import has_fatigue, margins
from stickslip.results.view import along_curve, frequencies, inside_band, points
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel
from stickslip.show.plots.look import MOST_PANELS, Style
from stickslip.show.plots.response_curves import HERTZ, case_lines
from stickslip.support.checks import InputError
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES

MPa = 1e6


@FIGURES.of("ForcedResponse", "stress")
def stress_curves(dataset: xr.Dataset) -> Chart:
    """Largest von Mises stress over the period against Hz at each place; dots mark the largest of each curve."""
    if "stress_von_mises" not in dataset:
        raise InputError("The figure of stress must have stress along the curves. Draw `response.with_stress(recovery)`.")
    names = [str(name) for name in dataset["place"].values]
    counted = inside_band(dataset, "stress_von_mises")
    largest = np.nan_to_num(counted).max(axis=(0, 1), initial=0.0)
    places = sorted(np.argsort(-largest, kind="stable")[:MOST_PANELS].tolist())  # the most stressed, in their old order
    note = f"{len(places)} of {len(names)} places, the most stressed" if len(places) < len(names) else ""
    panels = []
    for place in places:
        layers: list[Layer] = []
        for case, line in enumerate(case_lines(dataset)):
            hertz, stress = frequencies(dataset, case), along_curve(dataset, "stress_von_mises", case)[:, place] / MPa
            layers.append(Line(hertz, stress, **line))
            inside = counted[case, points(dataset, case), place]
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
