"""Report section on a bladed disk: mode shape, dampers, mean normal loads, nodal diameters, Campbell diagram."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from stickslip.analyses.nodal_diameters import has_disk
from stickslip.show.plots.disk import campbell, damper_ring, disk_mode, mean_normal_load, nodal_diameter_diagram, wave_damping
from stickslip.show.report.charts import Charts
from stickslip.show.report.markup import picture, section, text

if TYPE_CHECKING:
    import xarray as xr

NOTE = (
    '<p class="note">Dampers are shown at the largest amplitude. In a tuned disk all of them behave alike, each later than the '
    "one before. The mean normal load under vibration differs from the static one where slip reduces the part of the centrifugal "
    "load that friction carries.</p>"
)


def disk(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """All figures of every disk."""
    disks = {label: dataset for label, dataset in datasets.items() if has_disk(dataset)}
    parts = []
    for k, (label, dataset) in enumerate(disks.items()):
        parts += [f"<h3>{text(label)}</h3>"] if len(disks) > 1 else []
        if "disk_shape" in dataset.variables:
            parts.append(picture(disk_mode(dataset), "The disk in its first mode", "png"))
        if dataset.sizes["contact"]:
            parts.append(picture(damper_ring(dataset), "States of the dampers around the disk"))
            parts.append(charts.drawn(f"chart-load-{k}", mean_normal_load(dataset), "Mean normal load over the force level"))
        if "disk_frequency" in dataset.variables:
            description = "Natural frequencies over the nodal diameter"
            parts.append(charts.drawn(f"chart-diameters-{k}", nodal_diameter_diagram(dataset), description))
            if "wave_damping_ratio" in dataset.variables:
                description = "Damping of the waves of the first stuck mode over the nodal diameter"
                parts.append(charts.drawn(f"chart-wave-damping-{k}", wave_damping(dataset), description))
            parts.append(charts.drawn(f"chart-campbell-{k}", campbell(dataset), "Campbell diagram"))
    return section("disk", "Disk", NOTE, *parts)
