"""Report sections of pictures: a bladed disk with its mode shape, dampers and diagrams; dampers and the deformed shape in
motion at the highest peaks, or the steady cycles of a damper alone."""

from __future__ import annotations

import re
from collections.abc import Mapping

from stickslip.analyses.damper_alone.cycle import cycle_motion
from stickslip.analyses.deformed_shape import has_shapes, kept_shapes
from stickslip.analyses.kept_motion import has_motion, kept_cases, kept_motion
from stickslip.analyses.nodal_diameters import has_disk
from stickslip.results.representative import spread
from stickslip.results.view import level_text
from stickslip.show.plots.animation import Animation
from stickslip.show.plots.deformed_shape import DeformedShape
from stickslip.show.plots.disk import campbell, damper_ring, disk_mode, mean_normal_load, nodal_diameter_diagram, wave_damping
from stickslip.show.plots.moving_picture import MovingPicture
from stickslip.show.report.charts import Charts, Choice
from stickslip.show.report.markup import picture, section, text
from stickslip.support.late import xr

OF_DISK = (
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
    return section("disk", "Disk", OF_DISK, *parts)


MOST = 4
"""Cases that are shown in motion: 150 kB of the page each."""
NOTE = (
    "One period. Circles are contacts, coloured by what they do; arrows are the forces on the damper, light "
    "bands the faces of the platforms."
)

SHAPE_NOTE = (
    "The deformed shape is the first harmonic of the displacement at the highest peak, from the instant of the largest "
    "deflection on. Drag it to turn it. Grey: at rest. Dampers are not part of it."
)


def moves(dataset: xr.Dataset) -> bool:
    """Whether a result has motion to show."""
    return has_motion(dataset) or "damper_motion" in dataset or has_shapes(dataset)


def motions(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Animations with the choice of the force level or the cycle."""
    places, notes = [], []
    for number, (label, dataset) in enumerate(datasets.items()):
        if has_shapes(dataset):
            shapes = {level: DeformedShape(shape) for level, shape in kept_shapes(dataset).items()}
            choice = Choice("Force level", list(shapes))
            places.append(charts.place("chart-shape", shapes.__getitem__, [choice], result=label))
            notes.append(SHAPE_NOTE)
        if not has_motion(dataset) and "damper_motion" not in dataset:
            continue
        notes.append(NOTE)
        shown = _animations(dataset)
        name = "Force level" if has_motion(dataset) else "Cycle"
        several = len(datasets) > 1 and not all(map(has_motion, datasets.values()))
        place = f"chart-motion-{number}" if several else "chart-motion"
        places.append(charts.place(place, shown.__getitem__, [Choice(name, list(shown))], result="" if several else label))
    note = " ".join(dict.fromkeys(notes))
    return section("motion", "Motion", *places, f'<p class="note">{text(note)}</p>')


def moving_pictures(dataset: xr.Dataset) -> dict[str, MovingPicture]:
    """By the name of a file each: motion and deformed_shape, with the force level or the number of the cycle where several are
    kept."""
    found: dict[str, MovingPicture] = {}
    shapes = {level: DeformedShape(shape) for level, shape in kept_shapes(dataset).items()} if has_shapes(dataset) else {}
    animations = _animations(dataset) if has_motion(dataset) or "damper_motion" in dataset else {}
    for name, pictures in (("motion", animations), ("deformed_shape", shapes)):
        for words, moving in pictures.items():
            ending = re.sub(r"[^\w.]+", "_", words).strip("_")
            found[f"{name}_{ending}" if len(pictures) > 1 else name] = moving
    return found


def _animations(dataset: xr.Dataset) -> dict[str, Animation]:
    """By the words of the reader's choice."""
    if has_motion(dataset):
        kept = kept_cases(dataset)
        return {level_text(dataset, kept[k]): Animation(kept_motion(dataset, kept[k])) for k in spread(len(kept), MOST)}
    cycles = [dataset] if "cycle" not in dataset.dims else [dataset.isel(cycle=k) for k in range(dataset.sizes["cycle"])]
    return {str(k + 1): Animation(cycle_motion(cycles[k])) for k in spread(len(cycles), MOST)}
