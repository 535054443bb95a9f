"""One period of a solved point as it is drawn: sections of dampers, faces of platforms, contact points with states and forces.

Directions, places and motions are read from the coefficients of the contacts, so that the picture moves as the problem does.
Displacements are those about their means, which a static pull makes large.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stickslip.model.contact.period import OPEN, STICK
from stickslip.model.contact.point import Contact
from stickslip.model.problem import Problem
from stickslip.model.structure.rigid_body import arm_of
from stickslip.solve.balance.cycle import ContactCycle
from stickslip.support.checks import SMALLEST, Array, Index
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
    areas = [abs(float(loop.force @ (np.roll(loop.displacement, -1) - np.roll(loop.displacement, 1)))) for loop in loops]
    chosen: list[int] = []
    for k in sorted(range(len(areas)), key=lambda k: -areas[k]):
        if len(chosen) < count and not any(_covers(loops[other], loops[k]) for other in chosen):
            chosen.append(k)
    return sorted(chosen)


def _covers(one: LoopMotion, other: LoopMotion) -> bool:
    pairs = ((one.displacement, other.displacement), (one.force, other.force))
    return all(float(np.abs(a - b).max()) <= SAME_LOOP * float(np.ptp(a)) for a, b in pairs)
