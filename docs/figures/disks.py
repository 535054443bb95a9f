"""Draws the figures of docs/disks.md: `python docs/figures/disks.py`, some minutes."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import stickslip as ss
from stickslip.show.plots.disk import disk_mode, mean_normal_load, nodal_diameter_diagram
from stickslip.show.plots.look import CONTACTS, GREY, house_style
from stickslip.show.plots.paper import write_figure

HERE = Path(__file__).parent


def mobility(dataset, name, case):
    """Frequency and |X_1| ω/F of a curve."""
    frequency = dataset["frequency"][case] if name == "amplitude" else dataset["linear_frequency"]
    return frequency, dataset[name][case, :, 0] * 2 * np.pi * frequency / float(dataset["force_level"][case])


def responses(sets):
    """Mobility with both sets of contact stiffness, and without dampers."""
    with house_style():
        figure = Figure(figsize=(7.6, 4.4), layout="constrained")
        axes = figure.add_subplot()
        for (name, dataset), colour in zip(sets.items(), CONTACTS, strict=False):
            for case, style in enumerate(("-", "--")):
                label = f"{name} stiffness, {float(dataset['force_level'][case]):g} N"
                axes.plot(*mobility(dataset, "amplitude", case), style, color=colour, label=label)
        axes.plot(*mobility(sets["measured"], "free_amplitude", 0), color=GREY, lw=1.0, label="without dampers")
        axes.set(xlabel="frequency in Hz", ylabel="mobility in m/s/N", yscale="log", xlim=(115.0, 260.0))
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    return figure


if __name__ == "__main__":
    kinds = ("measured", "analytic")
    sets = {
        k: ss.forced_response(ss.rigs.octopus_blisk(k), ss.hertz(115, 260), [0.2, 0.4], harmonics=3, samples=96).dataset
        for k in kinds
    }
    lumped = ss.forced_response(ss.rigs.lumped_blisk("R"), ss.hertz(140, 150), [0.1, 0.2, 0.4, 0.8, 1.6, 3.2], 3, 96).dataset
    figures = {
        "disk_responses": responses(sets),
        "disk_nodal_diameters": nodal_diameter_diagram(sets["measured"]).plot(),
        "disk_mean_load": mean_normal_load(lumped, reference=ss.static_normal_load(147.0, 45.0)).plot(),
    }
    for name, figure in figures.items():
        write_figure(figure, HERE / f"{name}.svg", "svg")
    picture = disk_mode(sets["measured"])
    picture.set_dpi(90)
    write_figure(picture, HERE / "disk_mode.png", "png")
