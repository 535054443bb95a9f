"""Draws the dry and oiled dampers of docs/performance.md: `python docs/figures/semi_cylinders.py`, some minutes."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import stickslip as ss
from stickslip.model.rigs.single_blade import DRY, OILED
from stickslip.show.plots.look import CONTACTS, GREY, house_style
from stickslip.show.plots.paper import write_figure
from stickslip.show.plots.performance_curve import performance_curves

HERE = Path(__file__).parent
FORCE = 5.0
"""Excitation of the response curves, N."""


def responses():
    """Inertance at 26 and 56 N, dry and oiled, over the highest one without dampers."""
    with house_style():
        figure = Figure(figsize=(7.6, 3.6), layout="constrained")
        for axes, pull in zip(figure.subplots(1, 2, sharey=True), (26.0, 56.0), strict=True):
            for mu, colour, words in ((DRY, CONTACTS[0], "dry"), (OILED, CONTACTS[1], "oiled")):
                rig = ss.rigs.two_semi_cylinders(pull, mu)
                data = ss.forced_response(rig, ss.hertz(335, 520), FORCE, harmonics=3).dataset
                linear, without = data["linear_frequency"], data["free_amplitude"][0, :, 0]
                whole = float(np.nanmax(without * linear**2)) / FORCE
                frequency = data["frequency"][0]
                axes.plot(frequency, data["amplitude"][0, :, 0] * frequency**2 / FORCE / whole, color=colour, label=words)
            axes.plot(linear, without * linear**2 / FORCE / whole, color=GREY, lw=1.0, label="without dampers")
            axes.set(title=f"F_C = {pull:g} N, F_E = {FORCE:g} N", xlabel="frequency in Hz", yscale="log", ylim=(3e-3, 1.3))
        figure.axes[0].set_ylabel("inertance relative to the highest\nwithout dampers")
        figure.axes[0].legend(loc="upper right")
    return figure


def curves(pull):
    """Performance curves of the inertance at one load."""
    rig = ss.rigs.two_semi_cylinders(pull)
    curve = ss.performance_curve(rig, ss.logspace(0.3, 300.0, 36), friction=[OILED, DRY], harmonics=3, quantity="inertance")
    titled = curve.dataset.assign_attrs(title=f"Blade with two semi-cylinders, {pull:g} N")
    return performance_curves(titled).plot()


if __name__ == "__main__":
    write_figure(responses(), HERE / "dry_and_oiled_responses.svg", "svg")
    write_figure(curves(56.0), HERE / "dry_and_oiled.svg", "svg")
    write_figure(curves(206.0), HERE / "dry_and_oiled_206.svg", "svg")
