"""All figures of a forced response."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from stickslip.analyses.nodal_diameters import has_disk
from stickslip.analyses.stress import has_fatigue, has_stress
from stickslip.analyses.variability.bounds import detached, has_bounds
from stickslip.analyses.variability.samples import has_percentiles
from stickslip.show.plots.chart import Chart
from stickslip.show.plots.contacts import contact_states, dissipation, hysteresis_loops, loss_factor
from stickslip.show.plots.disk import damper_ring, disk_mode, mean_normal_load, nodal_diameter_diagram
from stickslip.show.plots.paper import Figures
from stickslip.show.plots.response_curves import haigh_diagram, peaks_over_force, response_curves, stress_curves
from stickslip.show.plots.time_response import bound_cycles, contact_forces, force_ratios, loops
from stickslip.show.plots.variability import loss_factors, response_bounds, response_cloud, response_percentiles
from stickslip.support.late import Figure, xr

FIGURES: dict[str, Callable[[Any], Chart | Figure]] = {
    "response": response_curves,
    "response_linear_scale": partial(response_curves, log=False),
    "response_per_force": partial(response_curves, per_force=True),
    "response_acceleration": partial(response_curves, quantity="acceleration"),
    "peaks": peaks_over_force,
    "loops": hysteresis_loops,
    "states": contact_states,
    "dissipation": dissipation,
    "loss_factor": loss_factor,
}
"""Name of the file: function that draws it."""


def figures_of(dataset: xr.Dataset) -> Figures:
    """The figures that a result has."""
    figures = dict(FIGURES)
    if has_bounds(dataset):
        figures |= {
            "bounds": lambda whole: response_bounds(detached(whole)),
            "bounds_loss_factor": lambda whole: loss_factors(detached(whole)),
            "bounds_contact_forces": lambda whole: contact_forces(detached(whole)),
        }
        # The ratio of friction to normal force needs a normal force that is known.
        if bound_cycles(detached(dataset)).contacts:
            figures["bounds_force_ratios"] = lambda whole: force_ratios(detached(whole))
        figures["bounds_loops"] = lambda whole: loops(detached(whole))
    if has_disk(dataset) and dataset.sizes["contact"]:
        figures |= {"dampers": damper_ring, "mean_normal_load": mean_normal_load}
    figures |= {"nodal_diameters": nodal_diameter_diagram} if "disk_frequency" in dataset.variables else {}
    figures |= {"disk_mode": disk_mode} if "disk_shape" in dataset.variables else {}
    figures |= {"stress": stress_curves} if has_stress(dataset) else {}
    figures |= {"haigh": haigh_diagram} if has_fatigue(dataset) else {}
    figures |= {"samples": response_cloud} if "start_variable" in dataset.variables else {}
    return figures | ({"percentiles": response_percentiles} if has_percentiles(dataset) else {})
