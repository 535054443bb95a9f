"""Von Mises stress along the curves, one panel per place and one line per force level."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from stickslip.plots.case_lines import case_lines
from stickslip.plots.look import MOST_PANELS, headed, house_style, legend, plain
from stickslip.results.view import along_curve, frequencies

if TYPE_CHECKING:
    import xarray as xr

MPa = 1e6


def stress_curves(dataset: xr.Dataset) -> Figure:
    """Largest von Mises stress over the period against Hz at each place; dots mark the largest of each curve."""
    names = [str(place) for place in dataset["place"].values]
    places = most_stressed(dataset)
    note = f"{len(places)} of {len(names)} places, the most stressed" if len(places) < len(names) else ""
    with house_style():
        figure = Figure(figsize=(7.6, 0.9 + 2.3 * len(places)), layout="constrained")
        for k, axes in zip(places, figure.subplots(len(places), 1, squeeze=False, sharex=True).ravel(), strict=True):
            for case, line in enumerate(case_lines(dataset)):
                hertz, stress = frequencies(dataset, case), along_curve(dataset, "stress_von_mises", case)[:, k] / MPa
                axes.plot(hertz, stress, **line)
                if np.any(np.isfinite(stress)):
                    top = int(np.nanargmax(stress))
                    axes.plot(hertz[top], stress[top], "o", color=line["color"], markersize=4)
            axes.set(title=plain(names[k]), ylabel="von Mises stress in MPa", yscale="log")
        axes.set_xlabel("frequency in Hz")
        legend(figure.axes[0], loc="best", ncols=2)
        headed(figure, f"Stress: {dataset.attrs['title']}", note)
    return figure


def most_stressed(dataset: xr.Dataset) -> list[int]:
    """Places with the largest stress, in their old order."""
    largest = np.nan_to_num(dataset["stress_von_mises"].values).max(axis=(0, 1), initial=0.0)
    return sorted(np.argsort(-largest, kind="stable")[:MOST_PANELS].tolist())
