"""Figures of contact laws: measured loops and fit, parameters over the cycles, errors of the laws; stiffness over the load."""

from __future__ import annotations

import numpy as np

from stickslip.results.representative import spread
from stickslip.show.plots.chart import Axis, Bars, Chart, Layer, Line, Panel, Rule, band, closed, from_zero
from stickslip.show.plots.look import Style, contact
from stickslip.support.checks import Array
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES

MOST_LOOPS = 6
"""Loops in one figure."""

MANY_DECADES = 50.0
"""Ratio of cycle numbers from which their axis is logarithmic."""


@FIGURES.of("ContactLaw")
def loops_and_fit(dataset: xr.Dataset) -> Chart:
    """Measured loops, dark, and those of the chosen law, orange."""
    names = dataset["loop"].values
    shown = names[spread(len(names), MOST_LOOPS)]
    axes, panels = (Axis("displacement", "µm"), Axis("friction force", "N")), []
    for name in shown:
        loop = dataset.sel(loop=name)
        u = 1e6 * loop["displacement"].values
        there = np.isfinite(u)
        layers = [
            Line(closed(u[there]), closed(loop[variable].values[there]), style, label)
            for variable, label, style in (
                ("force_measured", "measured", contact(0, width=2.4)),
                ("force_fitted", str(dataset.attrs["best"]), contact(1, width=1.2)),
            )
        ]
        panels.append(Panel(*axes, layers, str(name), 2.5))
    note = f"{len(shown)} of {len(names)}" if len(shown) < len(names) else ""
    return Chart("Measured and fitted loops", panels, columns=min(len(shown), 3), note=note)


@FIGURES.of("ContactLaw", "cycles")
def over_cycles(dataset: xr.Dataset) -> Chart:
    """kt, μ and energy against the cycle number, with bands of one standard deviation."""
    number = dataset["cycle_number"].values
    wide = number.min() > 0 and number.max() > MANY_DECADES * max(number.min(), 1) and len(number) < number.max() // 2
    cycle = Axis("cycle", log=bool(wide))
    stiffness = _with_band(number, 1e-6 * dataset["cycle_kt"].values, 1e-6 * dataset["cycle_kt_error"].values)
    known = "least_mu" not in dataset.attrs
    friction = _with_band(number, dataset["cycle_mu"].values, dataset["cycle_mu_error"].values) if known else []
    plateau = Style("grey", "none", marker="circle", size=2.5)
    friction.append(Line(number, dataset["plateau"].values, plateau, "plateau of the force over the load"))
    energy = [
        Line(number, 1e3 * dataset[name].values, contact(k, width=1.0, marker="circle", size=2.5), words)
        for k, (name, words) in enumerate((("energy_measured", "measured"), ("energy_fitted", "fitted energy")))
    ]
    panels = [
        Panel(cycle, Axis("tangential stiffness kt", "N/µm"), stiffness, height=2.0),
        Panel(cycle, Axis("friction coefficient μ"), friction, height=2.0),
        Panel(cycle, Axis("energy per cycle", "mJ"), energy, height=2.0),
    ]
    return Chart("Parameters over the cycles", panels, shared_x=True)


@FIGURES.of("ContactLaw", "laws")
def held_out(dataset: xr.Dataset) -> Chart:
    """Misfit of every law, and its error on loops held out."""
    laws = [str(law) for law in dataset["law"].values]
    places = np.arange(len(laws), dtype=float)
    layers = [
        Bars(places + shift, 100.0 * dataset[name].values, Style(shade), words, width=0.38)
        for shift, name, words, shade in ((-0.2, "misfit", "fit", "pale"), (0.2, "held_out", "loops held out", "contact 0"))
    ]
    across = Axis("contact law", names={float(place): law for place, law in enumerate(laws)})
    panel = Panel(across, Axis("error, relative to the rms force", "%"), layers, height=2.4)
    return Chart(f"Law of the contact: {dataset.attrs['best']}", [panel])


def _with_band(number: Array, value: Array, error: Array) -> list[Layer]:
    line = Line(number, value, contact(0, width=1.0, marker="circle", size=2.5), "fitted", {"standard deviation": error})
    return [band(number, value - error, value + error, contact(0, opacity=0.2), "one standard deviation"), line]


@FIGURES.of("ContactStiffness")
def stiffness_over_load(dataset: xr.Dataset) -> Chart:
    """Normal stiffness by every formula, the initial tangential ones dotted (across) and dashed (along), the load of interest."""
    load, at = dataset["load"].values, float(dataset.attrs["load_of_interest"])
    layers: list[Layer] = [
        Line(load, dataset["normal_stiffness"].sel(formula=formula).values / 1e6, contact(k), f"normal, {formula}")
        for k, formula in enumerate(dataset["formula"].values)
    ]
    across, along = (dataset[f"tangential_{direction}"].values / 1e6 for direction in ("across", "along"))
    layers.append(Line(load, across, Style("ink", "dot"), "tangential, across the line (initial)"))
    layers.append(Line(load, along, Style("grey", "dash"), "tangential, along the line (initial)"))
    layers += [Rule(at, Style("grey", width=0.9), f"{at:.4g} N")] if np.isfinite(at) else []
    panel = Panel(from_zero(Axis("normal load", "N")), Axis("stiffness", "N/µm"), layers, height=3.5)
    return Chart("Stiffness of the line contact", [panel])
