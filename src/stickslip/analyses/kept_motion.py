"""Periods of motion kept in a dataset, so that a report shows them without the problem: the highest peak of every case."""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.analyses.motion import BodyMotion, FaceMotion, LoopMotion, PeriodOfMotion, PointMotion, largest_loops
from stickslip.analyses.response_motion import response_motion
from stickslip.model.problem import Problem
from stickslip.results.shown_units import system_of
from stickslip.results.view import highest_peak, level_text
from stickslip.support.checks import Array
from stickslip.support.late import xr

MOST_LOOPS = 16
"""Loops that are kept of a peak: those that enclose most."""


def has_motion(dataset: xr.Dataset) -> bool:
    """Whether a response keeps the motion of its sections."""
    return "section_motion" in dataset


def with_motion(dataset: xr.Dataset, problem: Problem) -> xr.Dataset:
    """A response with the motion of the sections of its dampers at the highest peaks; as it is where there are no sections.

    Gains section_corner, face_end, touch_place at rest [m], their motion over the frames of the period, states and forces of
    the contact points, `section_motion_point` (case), the point that it is of, −1 where a case has none.
    """
    if not problem.structure.outlines:
        return dataset
    peaks = [highest_peak(dataset, case) for case in range(dataset.sizes["case"])]
    found = [None if peak is None else response_motion(dataset, problem, case, peak.point) for case, peak in enumerate(peaks)]
    known = next((motion for motion in found if motion is not None), None)
    if known is None or not known.points:
        return dataset
    # The directions with the largest loops, of those that move in every case.
    moving = [{loop.label for loop in motion.loops} for motion in found if motion is not None]
    labels = [known.loops[k].label for k in largest_loops(known, MOST_LOOPS) if known.loops[k].label in set.intersection(*moving)]
    # Corners are filled up with NaN to the longest outline.
    longest = max(len(body.corners) for body in known.bodies)
    corners = [np.pad(body.corners, ((0, longest - len(body.corners)), (0, 0)), constant_values=np.nan) for body in known.bodies]
    variables: dict[str, Any] = {
        "section_corner": (("section", "corner_of_section", "plane"), np.array(corners), "m", "outline of a damper at rest"),
        "section_centre": (("section", "plane"), np.array([b.centre for b in known.bodies]), "m", "mass centre at rest"),
        "face_end": (("face", "end", "plane"), np.array([face.ends for face in known.faces]), "m", "face of a platform at rest"),
        "face_normal": (("face", "plane"), np.array([face.into for face in known.faces]), "1", "normal into the platform"),
        "touch_place": (("touch", "plane"), np.array([point.place for point in known.points]), "m", "contact point at rest"),
    }
    variables |= _motions(known, found) | _loops(labels, found)
    points = [-1 if peak is None else peak.point for peak in peaks]
    variables["section_motion_point"] = ("case",), np.array(points), "1", "point whose motion is kept"
    return dataset.assign(
        {name: (dims, values, {"units": units, "long_name": words}) for name, (dims, values, units, words) in variables.items()}
    ).assign_attrs(
        sections=[body.name for body in known.bodies], touching=[point.name for point in known.points], loops_in_motion=labels
    )


def _motions(known: PeriodOfMotion, found: list[PeriodOfMotion | None]) -> dict[str, Any]:
    """What moves, NaN in cases without a point."""

    def each(name: str, field: str) -> Array:
        sample = np.array([getattr(part, field) for part in getattr(known, name)], dtype=float)
        rows = [
            np.full_like(sample, np.nan) if motion is None else [getattr(part, field) for part in getattr(motion, name)]
            for motion in found
        ]
        return np.array(rows, dtype=float)

    states = "0 stick, 1 slip, 2 partly slipping, 3 lift-off"
    return {
        "section_motion": (("case", "section", "frame", "turning"), each("bodies", "motion"), "m, m, rad", "x, y, rotation"),
        "face_motion": (("case", "face", "frame", "end", "plane"), each("faces", "motion"), "m", "motion of the ends of a face"),
        "touch_motion": (("case", "touch", "frame", "plane"), each("points", "motion"), "m", "motion of a contact point"),
        "touch_state": (("case", "touch", "frame"), each("points", "state"), "1", states),
        "touch_force": (("case", "touch", "frame", "plane"), each("points", "force"), "N", "force on the damper"),
    }


def _loops(labels: list[str], found: list[PeriodOfMotion | None]) -> dict[str, Any]:
    samples = next(len(motion.loops[0].force) for motion in found if motion is not None)

    def each(field: str) -> Array:
        values = np.full((len(found), len(labels), samples), np.nan)
        for case, motion in enumerate(found):
            loops = {} if motion is None else {loop.label: loop for loop in motion.loops}
            for k, label in enumerate(labels):
                if label in loops:
                    values[case, k] = getattr(loops[label], field)
        return values

    dims = ("case", "motion_loop", "motion_sample")
    return {
        "motion_loop_displacement": (dims, each("displacement"), "m", "relative displacement of a contact over the period"),
        "motion_loop_force": (dims, each("force"), "N", "its force"),
        "motion_loop_state": (dims, each("state"), "1", "its state, as of contact points"),
    }


def kept_cases(dataset: xr.Dataset) -> list[int]:
    """The cases whose motion is kept."""
    return [int(case) for case in np.flatnonzero(dataset["section_motion_point"].values >= 0)]


def kept_motion(dataset: xr.Dataset, case: int) -> PeriodOfMotion:
    """The motion of a case, with the loops of its highest peak."""
    here = dataset.isel(case=case)
    bodies = []
    for k, name in enumerate(np.atleast_1d(dataset.attrs["sections"])):
        corners = here["section_corner"].values[k]
        known = corners[np.isfinite(corners).all(axis=1)]
        bodies.append(BodyMotion(str(name), known, here["section_centre"].values[k], here["section_motion"].values[k]))
    values = [here[f"face_{name}"].values for name in ("end", "normal", "motion")]
    faces = tuple(FaceMotion(*parts) for parts in zip(*values, strict=True))
    values = [here[f"touch_{name}"].values for name in ("place", "motion", "state", "force")]
    names = map(str, np.atleast_1d(dataset.attrs["touching"]))
    points = tuple(
        PointMotion(name, place, motion, state.astype(int), force)
        for name, place, motion, state, force in zip(names, *values, strict=True)
    )
    hertz = float(here["frequency"].values[int(here["section_motion_point"])])
    title = f"{level_text(dataset, case)}, {hertz:.6g} Hz"
    values = [here[f"motion_loop_{name}"].values for name in ("displacement", "force", "state")]
    names = map(str, np.atleast_1d(dataset.attrs["loops_in_motion"]))
    loops = tuple(LoopMotion(name, u, force, state.astype(int)) for name, u, force, state in zip(names, *values, strict=True))
    return PeriodOfMotion(title, loops, tuple(bodies), faces, points, system=system_of(dataset))
