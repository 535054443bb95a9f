"""Draws the beam of docs/response_identification.md: `python docs/figures/brake_reuss.py`, minutes, with its curves at hand."""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import stickslip as ss
from stickslip.show.plots.look import house_style, level_colours
from stickslip.show.plots.paper import write_figure

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / "tests"))
from identification.brake_reuss import FREE, beam, constant_force, curves, one_mode, per_force  # noqa: E402

FORCES = (0.2, 0.5, 1.0, 1.5)
"""Constant forces of the prediction, N."""


def found():
    """The identification of the eight curves."""
    return ss.identify_response(beam, FREE, curves(), tries=4, harmonics=1, evaluations=60)


def drawn(result):
    """Measured and computed curves, damping ratios, and predicted responses at constant forces."""
    data, count = result.dataset, result.dataset.sizes["test"]
    colours = level_colours(count)
    with house_style():
        figure = Figure(figsize=(9.4, 3.6), layout="constrained")
        left, middle, right = figure.subplots(1, 3)
        ratios = []
        for k, colour in enumerate(colours):
            f = data["frequency"].values[k]
            left.plot(f, data["measured"].values[k], ".", color=colour, markersize=3)
            left.plot(f, data["computed"].values[k], color=colour, linewidth=1.0)
            ratios.append([100.0 * one_mode(f, per_force(data, which)[k])[2] for which in ("measured", "computed")])
        held = np.nanmedian(data["response"].values, axis=1)
        middle.plot(held, [one[0] for one in ratios], "o", color="black", markersize=4, label="measured")
        middle.plot(held, [one[1] for one in ratios], color=colours[3], label="computed")
        middle.legend(loc="upper left", fontsize=7)
        for force, colour in zip(FORCES, level_colours(len(FORCES)), strict=True):
            right.plot(*constant_force(result, force), color=colour, label=f"{force:g} N")
        right.legend(loc="upper right", fontsize=7)
        left.set(xlabel="frequency in Hz", ylabel="acceleration per force in m/(s² N)", yscale="log", title="Acceleration held")
        middle.set(xlabel="acceleration in m/s²", ylabel="damping ratio in %", title="Damping")
        right.set(xlabel="frequency in Hz", ylabel="acceleration in m/s²", title="Predicted at constant force", xlim=(78.5, 82.5))
    return figure


if __name__ == "__main__":
    write_figure(drawn(found()), HERE / "brake_reuss.svg", "svg")
