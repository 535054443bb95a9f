"""One period of a solved point as it is drawn: sections of dampers, faces of platforms, contact points with states and forces.

Directions, places and motions are read from the coefficients of the contacts, so that the picture moves as the problem does.
Displacements are those about their means, which a static pull makes large.

Periods of motion kept in a dataset, so that a report shows them without the problem: the highest peak of every case.

The period of motion of one point of a forced response, for its animation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stickslip.analyses.solved_points import SolvedPoints, on_its_coordinates
from stickslip.model.contact.point import Contact
from stickslip.model.contact.protocol import OPEN, STICK
from stickslip.model.disks.tuned import FullDisk, TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.structure.assembly import arm_of
from stickslip.results.schema import described, stacked, system_of
from stickslip.results.view import highest_peak, level_text, periods_of
from stickslip.solve.balance.energy import ContactCycle, contact_cycle
from stickslip.support.checks import SMALLEST, Array, Index, fault
from stickslip.support.late import xr
from stickslip.support.units import UnitSystem

FRAMES = 48
"""Pictures of a period."""
STATES = ("stick", "slip", "partly slipping", "lift-off")
STUCK, SLIPPING, PARTLY, LIFTED = range(4)
OVERLAP = 0.2
"""By what share of the extent of the section a face reaches beyond its contact points."""
SAME_LOOP = 0.02
"""Difference of two loops, relative to their extent, below which they cover each other in a drawing."""
IN_PLANE = 0.5
"""Component in the plane of drawing from which a direction is drawn."""


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """A rigid section: corners at rest (k, 2), mass centre (2,) [m], motion x, y [m] and rotation [rad], (frames, 3)."""

    name: str
    corners: Array
    centre: Array
    motion: Array


@dataclass(frozen=True, eq=False)
class FaceMotion:
    """The face of a platform: its two ends at rest (2, 2) [m], the normal into it (2,), motion of the ends (frames, 2, 2) [m]."""

    ends: Array
    into: Array
    motion: Array


@dataclass(frozen=True, eq=False)
class PointMotion:
    """What touches at one place of a section: place on the body at rest (2,) [m], its motion (frames, 2) [m], state (frames,),
    an index into `STATES`, and the force on the body (frames, 2) [N]."""

    name: str
    place: Array
    motion: Array
    state: Index
    force: Array


@dataclass(frozen=True, eq=False)
class LoopMotion:
    """One direction of a contact over the period: displacement [m], force [N], state, each (samples,)."""

    label: str
    displacement: Array
    force: Array
    state: Index


@dataclass(frozen=True, eq=False)
class Wheel:
    """Blades round a disk: displacement of each (frames, blades) [m] and its amplitude (blades,) [m]."""

    displacement: Array
    amplitude: Array


@dataclass(frozen=True, eq=False)
class PeriodOfMotion:
    """Everything that moves in one period; without sections of bodies only its loops and states. system: the units to show."""

    title: str
    loops: tuple[LoopMotion, ...]
    bodies: tuple[BodyMotion, ...] = ()
    faces: tuple[FaceMotion, ...] = ()
    points: tuple[PointMotion, ...] = ()
    wheel: Wheel | None = None
    note: str = field(default="", kw_only=True)
    system: UnitSystem | None = field(default=None, kw_only=True)


def frames_of(samples: int) -> Index:
    """The samples that are drawn."""
    count = min(FRAMES, samples)
    return np.arange(count) * samples // count


def point_states(states: Index) -> Index:
    """State of contacts (contacts, frames) at one place: lift-off where all are open, stick or slip where all closed ones do."""
    opened, stuck = states == OPEN, states == STICK
    slips = ~opened & ~stuck
    found = np.where(slips.any(axis=0), np.where(stuck.any(axis=0), PARTLY, SLIPPING), STUCK)
    return np.asarray(np.where(opened.all(axis=0), LIFTED, found))


def contact_loops(problem: Problem, cycle: ContactCycle) -> tuple[LoopMotion, ...]:
    """The loop of every direction that moves: tangential ones, the normal one of a contact that has no other."""
    loops, row = [], 0
    for contact in problem.contacts:
        count, states = len(contact.directions), cycle.state[row : row + len(contact.directions)]
        shown = range(len(contact.tangential)) if contact.tangential else range(count)
        for k in shown:
            label = contact.name if len(shown) == 1 else f"{contact.name}, {contact.direction_names[k]}"
            displacement, force = cycle.displacement[row + k], cycle.force[row + k]
            loops.append(LoopMotion(label, displacement, force, point_states(states[k : k + 1])))
        row += count
    largest = max((float(np.ptp(loop.displacement)) for loop in loops), default=0.0)
    return tuple(loop for loop in loops if np.ptp(loop.displacement) > 1e-9 * largest) or tuple(loops)


def sections(
    problem: Problem, motion: Array, cycle: ContactCycle
) -> tuple[tuple[BodyMotion, ...], tuple[FaceMotion, ...], tuple[PointMotion, ...]]:
    """Bodies with outlines, the faces beside them, and their contact points; motion: of every degree of freedom (n, samples)."""
    frames = frames_of(motion.shape[1])
    moving = motion - motion.mean(axis=1, keepdims=True)
    structure = problem.structure
    bodies, faces, points = [], [], []
    for node, corners in structure.outlines.items():
        rows = [
            structure.dofs.index(f"{node}.{axis}") if f"{node}.{axis}" in structure.dofs else None for axis in ("x", "y", "rz")
        ]
        own = np.stack([np.zeros(frames.size) if row is None else moving[row, frames] for row in rows], axis=1)
        centre = np.asarray(structure.nodes.get(node, corners.mean(axis=0)))[:2]
        body = BodyMotion(node.partition("/")[0], corners[:, :2], centre, own)
        touching = _touching(problem, body, node, cycle, frames)
        bodies.append(body)
        points += _points(body, touching)
        faces += _faces(body, touching)
    return tuple(bodies), tuple(faces), tuple(points)


@dataclass(frozen=True, eq=False)
class _Touch:
    """A contact of a body: place (2,), the normal out of the body (2,), motion of what it touches (frames, 2), states of its
    directions (1, frames), force on the body (frames, 2)."""

    name: str
    place: Array
    outward: Array
    opposite: Array
    state: Index
    force: Array


def _touching(problem: Problem, body: BodyMotion, node: str, cycle: ContactCycle, frames: Index) -> list[_Touch]:
    found, row = [], 0
    relative = cycle.displacement - cycle.displacement.mean(axis=1, keepdims=True)
    for contact in problem.contacts:
        rows = slice(row, row + len(contact.directions))
        row = rows.stop
        along = np.array([[d.get(f"{node}.{axis}", 0.0) for axis in ("x", "y")] for d in contact.directions])
        drawn = np.linalg.norm(along, axis=1) > IN_PLANE
        if contact.normal is None or not drawn[len(contact.tangential)]:
            continue
        outward = along[len(contact.tangential)]
        outward = outward / np.linalg.norm(outward)
        place = _place(contact, body, node, outward)
        own = _point_motion(body, place)
        # w = b u_body + what the other side adds, along each b; u of the other side along b is minus that.
        beyond = relative[rows][:, frames] - along @ own.T
        unit = along[drawn] / np.linalg.norm(along[drawn], axis=1, keepdims=True) ** 2
        opposite = -(beyond[drawn].T @ unit)
        # Open in the tangential directions too where the normal one is.
        states = cycle.state[rows][:, frames]
        tangential = states[: len(contact.tangential)] if contact.tangential else states
        state = np.asarray(np.where(states[-1] == OPEN, OPEN, tangential))
        found.append(_Touch(contact.name, place, outward, opposite, state, -(cycle.force[rows][:, frames].T @ along)))
    return found


def _place(contact: Contact, body: BodyMotion, node: str, outward: Array) -> Array:
    """Where a contact stands, (2,): by its coefficients of rotations; of a body that cannot turn the middle of the side there."""
    if any(dof.startswith(f"{node}.r") for direction in contact.directions for dof in direction):
        return np.asarray(body.centre + arm_of(contact.directions, node)[:2])
    height = body.corners @ outward
    side = body.corners[height > height.max() - 1e-6 * max(float(np.ptp(height)), SMALLEST)]
    return np.asarray(side.mean(axis=0))


def _point_motion(body: BodyMotion, place: Array) -> Array:
    """Displacement of a point of a body, (frames, 2), for small rotations."""
    x, y = place - body.centre
    return np.asarray(body.motion[:, :2] + body.motion[:, 2:] * np.array([-y, x]))


def _points(body: BodyMotion, touching: Sequence[_Touch]) -> list[PointMotion]:
    """Contacts that stand behind each other in the drawing as one: forces summed."""
    groups: dict[tuple[float, float], list[_Touch]] = {}
    for touch in touching:
        x, y = np.round(touch.place, 9)
        groups.setdefault((float(x), float(y)), []).append(touch)
    points = []
    for same in groups.values():
        force = np.sum([touch.force for touch in same], axis=0)
        name = ", ".join(touch.name for touch in same)
        states = point_states(np.concatenate([touch.state for touch in same]))
        points.append(PointMotion(name, same[0].place, _point_motion(body, same[0].place), states, force))
    return points


def _faces(body: BodyMotion, touching: Sequence[_Touch]) -> list[FaceMotion]:
    """A straight face for each direction in which a body is touched; it moves and turns as what it touches with does."""
    groups: dict[tuple[float, float], list[_Touch]] = {}
    for touch in touching:
        x, y = np.round(touch.outward, 6)
        groups.setdefault((float(x), float(y)), []).append(touch)
    extent = float(np.ptp(body.corners, axis=0).max())
    faces = []
    for same in groups.values():
        outward = same[0].outward
        tangent, origin = np.array([-outward[1], outward[0]]), np.mean([touch.place for touch in same], axis=0)
        s = np.array([(touch.place - origin) @ tangent for touch in same])
        reach = np.array([s.min() - OVERLAP * extent, s.max() + OVERLAP * extent])
        moved = np.stack([touch.opposite for touch in same])
        spread = float(s @ s)
        slope = np.tensordot(s, moved, axes=1) / spread if spread > SMALLEST else np.zeros(moved.shape[1:])
        motion = moved.mean(axis=0)[:, None] + reach[:, None] * slope[:, None]
        faces.append(FaceMotion(origin + reach[:, None] * tangent, outward, motion))
    return faces


def largest_loops(motion: PeriodOfMotion, count: int) -> list[int]:
    """The loops that enclose most, at most `count`, by their places in `loops`; one of those that cover each other."""
    loops = motion.loops

    def covers(one: LoopMotion, other: LoopMotion) -> bool:
        pairs = ((one.displacement, other.displacement), (one.force, other.force))
        return all(float(np.abs(a - b).max()) <= SAME_LOOP * float(np.ptp(a)) for a, b in pairs)

    areas = [abs(float(loop.force @ (np.roll(loop.displacement, -1) - np.roll(loop.displacement, 1)))) for loop in loops]
    chosen: list[int] = []
    for k in sorted(range(len(areas)), key=lambda k: -areas[k]):
        if len(chosen) < count and not any(covers(loops[other], loops[k]) for other in chosen):
            chosen.append(k)
    return sorted(chosen)


def response_motion(dataset: "xr.Dataset", problem: Problem, case: int, point: int) -> PeriodOfMotion:
    """Sections, loops and, of a disk, its blades over the period of a solved point."""
    problem = on_its_coordinates(problem, dataset)
    points = SolvedPoints(dataset, problem)
    balance = points.balance
    evaluation = points.evaluation(case, point)
    cycle = contact_cycle(balance.table, balance.tables, evaluation.w[: balance.rows], evaluation.point.omega)
    whole = points.whole_motion(case, point) @ balance.tables.E.T if problem.structure.outlines else None
    outputs = evaluation.w[balance.rows :] @ balance.tables.E.T
    loops = contact_loops(problem, cycle)
    if not loops:
        raise fault("The problem of an animation", "must have contacts", "none", "plot() shows its curves.")
    parts = ((), (), ()) if whole is None else sections(problem, whole, cycle)
    hertz, periods = float(dataset["frequency"].values[case, point]), periods_of(dataset)
    title = f"{problem.heading}, {level_text(dataset, case)}, {hertz:.6g} Hz"
    note = f"one period of the motion is {periods} of the excitation" if periods > 1 else ""
    return PeriodOfMotion(title, loops, *parts, wheel_of(problem, outputs), note=note, system=system_of(dataset))


def wheel_of(problem: Problem, outputs: Array) -> Wheel | None:
    """The first output of every blade over the period, outputs (outputs, samples) [m]; None for what is no disk, or where a full
    disk does not report all its sectors.

    Blades of a tuned disk move alike, sector j later by j EO/N of a period of the excitation.
    """
    samples = outputs.shape[1]
    if isinstance(problem, TunedDisk):
        lag = np.arange(problem.sectors) * (problem.engine_order % problem.sectors) * samples // problem.sectors
        blades = outputs[0, (np.arange(samples)[:, None] - lag) % samples]
    elif isinstance(problem, FullDisk):
        first = {name.partition("/")[0]: k for k, name in reversed(list(enumerate(problem.output_names)))}
        rows = [first.get(str(j)) for j in range(1, problem.sectors + 1)]
        if None in rows:
            return None
        blades = outputs[[row for row in rows if row is not None]].T
    else:
        return None
    moving = blades - blades.mean(axis=0)
    return Wheel(moving[frames_of(samples)], 0.5 * np.ptp(moving, axis=0))


MOST_LOOPS = 16
"""Loops that are kept of a peak: those that enclose most."""


def has_motion(dataset: "xr.Dataset") -> bool:
    """Whether a response keeps the motion of its sections."""
    return "section_motion" in dataset


def with_motion(dataset: "xr.Dataset", problem: Problem) -> "xr.Dataset":
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
    variables = {
        "section_corner": stacked([body.corners for body in known.bodies]),  # filled up with NaN to the longest outline
        "section_centre": np.array([b.centre for b in known.bodies]),
        "face_end": np.array([face.ends for face in known.faces]),
        "face_normal": np.array([face.into for face in known.faces]),
        "touch_place": np.array([point.place for point in known.points]),
        **_motions(known, found),
        **_loops(labels, found),
        "section_motion_point": np.array([-1 if peak is None else peak.point for peak in peaks]),
    }
    return dataset.assign(described("motion_of_sections", variables)).assign_attrs(
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

    return {
        "section_motion": each("bodies", "motion"),
        "face_motion": each("faces", "motion"),
        "touch_motion": each("points", "motion"),
        "touch_state": each("points", "state"),
        "touch_force": each("points", "force"),
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

    return {f"motion_loop_{field}": each(field) for field in ("displacement", "force", "state")}


def kept_cases(dataset: "xr.Dataset") -> list[int]:
    """The cases whose motion is kept."""
    return [int(case) for case in np.flatnonzero(dataset["section_motion_point"].values >= 0)]


def kept_motion(dataset: "xr.Dataset", case: int) -> PeriodOfMotion:
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
