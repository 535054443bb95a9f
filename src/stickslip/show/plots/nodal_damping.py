"""Damping of travelling waves over the nodal diameter, the S curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, Rule
from stickslip.show.plots.look import Style, contact
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr


def wave_damping(dataset: xr.Dataset) -> Chart:
    """The same of the disk of a forced response: the first family of modes, contacts stuck."""
    names = {f"wave_{name}": name for name in ("damping_ratio", "aerodynamic_damping", "frequency", "frequency_shift")}
    found = dataset[list(names)].rename({"wave": "nodal_diameter", **names})
    return over_nodal_diameter(found.assign_attrs(title="Damping of travelling waves", mode=1, contacts="stuck"))


@FIGURES.of("DampingByNodalDiameter")
def over_nodal_diameter(dataset: xr.Dataset) -> Chart:
    """Aerodynamic damping ratio, and dotted that with the damping of the structure, over the nodal diameter."""
    x = dataset["nodal_diameter"].values
    hover = {"frequency in Hz": dataset["frequency"].values, "frequency shift in %": 100.0 * dataset["frequency_shift"].values}
    aerodynamic = contact(0, marker="circle", size=4.0)
    whole = contact(1, dash="dot", marker="circle", size=3.0)
    layers: list[Layer] = [
        Line(x, 100.0 * dataset["aerodynamic_damping"].values, aerodynamic, "aerodynamic", hover),
        Line(x, 100.0 * dataset["damping_ratio"].values, whole, "with that of the structure", hover),
        Rule(0.0, Style("grey", width=0.9), along="y"),
    ]
    panel = Panel(Axis("nodal diameter"), Axis("damping ratio", "%"), layers)
    return Chart(str(dataset.attrs["title"]), [panel], note=f"mode {dataset.attrs['mode']}, contacts {dataset.attrs['contacts']}")
