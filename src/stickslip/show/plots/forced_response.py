"""All figures of a forced response, and `save_figures`, which writes them as PNG and SVG."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.analyses.fatigue import has_fatigue
from stickslip.analyses.nodal_diameters import has_disk
from stickslip.analyses.stress import has_stress
from stickslip.analyses.variability.bounds_dataset import detached, has_bounds
from stickslip.analyses.variability.percentiles import has_percentiles
from stickslip.show.plots.bound_cycles import contact_forces, force_ratios, loops
from stickslip.show.plots.chart import Chart
from stickslip.show.plots.contacts import contact_states, hysteresis_loops
from stickslip.show.plots.cycles import bound_cycles
from stickslip.show.plots.disk import campbell, damper_ring, disk_mode, mean_normal_load, nodal_diameter_diagram
from stickslip.show.plots.energy import dissipation, loss_factor
from stickslip.show.plots.files import Figures, write_figures
from stickslip.show.plots.haigh import haigh_diagram
from stickslip.show.plots.response_bounds import loss_factors, response_bounds
from stickslip.show.plots.response_curves import peaks_over_force, response_curves
from stickslip.show.plots.response_percentiles import response_percentiles
from stickslip.show.plots.response_samples import response_cloud
from stickslip.show.plots.stress import stress_curves

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = [
    "FIGURES",
    "contact_states",
    "dissipation",
    "hysteresis_loops",
    "loss_factor",
    "peaks_over_force",
    "response_curves",
    "save_figures",
]

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

BOUNDS_FIGURES: dict[str, Callable[[Any], Chart | Figure]] = {
    "bounds": lambda dataset: response_bounds(detached(dataset)),
    "bounds_loss_factor": lambda dataset: loss_factors(detached(dataset)),
    "bounds_contact_forces": lambda dataset: contact_forces(detached(dataset)),
    "bounds_force_ratios": lambda dataset: force_ratios(detached(dataset)),
    "bounds_loops": lambda dataset: loops(detached(dataset)),
}
"""The same for results that hold bounds."""

DISK_FIGURES: dict[str, Callable[[Any], Chart | Figure]] = {"dampers": damper_ring, "mean_normal_load": mean_normal_load}
TUNED_DISK_FIGURES: dict[str, Callable[[Any], Chart | Figure]] = {"nodal_diameters": nodal_diameter_diagram, "campbell": campbell}
"""The same for disks, and for disks with one sector for all."""

SAMPLES_FIGURES: dict[str, Callable[[Any], Chart | Figure]] = {"samples": response_cloud}
PERCENTILES_FIGURES: dict[str, Callable[[Any], Chart | Figure]] = {"percentiles": response_percentiles}
"""The same for samples, and for samples at common frequencies."""


def figures_of(dataset: xr.Dataset) -> Figures:
    """The figures that a result has."""
    figures = FIGURES | (_bounds_figures(dataset) if has_bounds(dataset) else {})
    figures |= DISK_FIGURES if has_disk(dataset) and dataset.sizes["contact"] else {}
    figures |= TUNED_DISK_FIGURES if "disk_frequency" in dataset.variables else {}
    figures |= {"disk_mode": disk_mode} if "disk_shape" in dataset.variables else {}
    figures |= {"stress": stress_curves} if has_stress(dataset) else {}
    figures |= {"haigh": haigh_diagram} if has_fatigue(dataset) else {}
    figures |= SAMPLES_FIGURES if "start_variable" in dataset.variables else {}
    return figures | (PERCENTILES_FIGURES if has_percentiles(dataset) else {})


def _bounds_figures(dataset: xr.Dataset) -> dict[str, Callable[[Any], Chart | Figure]]:
    """Those of bounds; the ratio of friction to normal force only where a normal force is known."""
    without = () if bound_cycles(detached(dataset)).contacts else ("bounds_force_ratios",)
    return {name: draw for name, draw in BOUNDS_FIGURES.items() if name not in without}


def save_figures(dataset: xr.Dataset, directory: str | Path, formats: tuple[str, ...] = ("png", "svg")) -> list[Path]:
    """Write every figure in every format; returns the paths."""
    return write_figures(figures_of(dataset), dataset, directory, formats)
