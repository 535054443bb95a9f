"""[[contact]] and [[force]] tables with a `surface`: contacts at the nodes of a set, and forces spread over it."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import linalg

from stickslip.model.contact.law import Law
from stickslip.model.contact.point import GROUND, Contact
from stickslip.model.interfaces.node_surface import NodeSurface, Opposite, line_as_surface, mean_motion, surface_contacts
from stickslip.model.loads import Force
from stickslip.model.structure.cyclic import NEXT, CyclicStructure
from stickslip.results.schema import in_system
from stickslip.study.build import force_along
from stickslip.study.contacts import ContactTable, FrictionTable, SurfaceTable, start_rules
from stickslip.study.fields import Units, in_si
from stickslip.study.structure import Parts
from stickslip.study.tables import ForceTable
from stickslip.support.checks import Array, InputError, counted, fault, first_of, nearest
from stickslip.support.units import UnitSystem

AXES = ("x", "y", "z")


FAR, SMALLEST = 10.0, 1e-4
"""Distance of what lies opposite from where on it is likely a slip, over the size of the surface or this length [m]."""
APART, INCLINED = 0.25, 10.0
"""Distance of the face of a body from a surface, over the size of the surface, and angle between them, degrees, from where on it
is likely not the face that was meant."""
LOST = 0.01
"""Share of a surface without a counterpart from which on its loss is warned of, as that of a peak on patches is."""
SKEW = 15.0
"""Angle between the normal of a node and `facing`, degrees, from where on one of them is likely not what was meant."""
STIFF, SOFT, HELD = 0.98, 0.85, 1e-9
"""Share of the stiffness against a motion of a body that patches keep, up to which it is noted and up to which it is warned of;
stiffness, relative to the largest, below which contacts do not hold a motion at all."""
CHECK_FIT = "Contacts do not follow the shape of a body. Check its position, axes, dimensions and angles."
"""How a warning of these ends."""
CHECK_UNITS = "check units"
"""How a note on such a distance ends."""


def surfaces_in(contacts: Iterable[ContactTable | None], forces: Iterable[ForceTable | None]) -> list[str]:
    """Names of the sets of nodes that contacts and forces may speak of."""
    given = [name for table in contacts if isinstance(table, SurfaceTable) for name in (table.surface, table.against)]
    given += [table.surface for table in forces if table is not None]
    return [name for name in dict.fromkeys(given) if name is not None and name != GROUND]


def meshed_surfaces(contacts: Iterable[ContactTable | None]) -> list[str]:
    """Names of the sets of nodes that have a contact at each node."""
    return surfaces_in([table for table in contacts if isinstance(table, SurfaceTable) and table.points is None], ())


def contacts_on(table: SurfaceTable, number: int, parts: Parts, units: Units) -> tuple[tuple[Contact, ...], list[str]]:
    """The contacts of a surface in SI, and notes on what was found."""
    name = table.name or f"contact {number}"
    against = _opposite(table, parts)
    surface = _surface(table, against, parts)
    law = _pressed(table.make_law(units), in_si(table, units)["mean_pressure"], surface)
    start: Any = None
    if isinstance(table, FrictionTable):
        start = start_rules(table.start, units, 2, law.elements(2, law.has_normal).friction[0].stiffness.size)
    more: dict[str, Any] = {"start": start, "balanced": getattr(table, "balanced", False), "mesh_gap": table.mesh_gap}
    contacts = surface_contacts(name, law, surface, against, tangent=table.tangent, points=table.points, **more)
    note = _note(name, surface, contacts, table, _middle(table, against, parts), units.system)
    unmet = _unmet(name, law, surface, contacts, table, units.system)
    misfit = _misfit(name, surface, str(table.against), parts, units.system)
    return contacts, [note, *unmet, *misfit, *_skew(name, table, surface)]


def force_on(table: ForceTable, parts: Parts, units: Units) -> Force:
    """A force spread over a surface, in SI."""
    given = {table.direction: 1.0} if isinstance(table.direction, str) else table.direction
    unknown = [axis for axis in given if axis not in AXES]
    if unknown:
        raise fault("direction with surface", "must be x, y or z, or a table of these", unknown[0])
    along = [given.get(axis, 0.0) for axis in AXES]
    _existing_set(parts, str(table.surface))
    name = str(table.surface)
    return force_along(mean_motion(parts.structure, name, along, _is_line(parts, name, table.line)), table, units)


def _existing_set(parts: Parts, name: str, what: str = "Set of nodes", others: Sequence[str] = ()) -> None:
    """Refuse the name of a set that no model has, and name one that it has, kept or not."""
    following = NEXT if name.startswith(NEXT) else ""
    own, known = name.removeprefix(NEXT), [*(f"{following}{each}" for each in parts.sets), *others]
    if own not in parts.structure.sets and known:
        raise InputError(f"{what} {name!r} does not exist. {nearest(name, known)}")


def _opposite(table: SurfaceTable, parts: Parts) -> Opposite:
    name = str(table.against)
    if name == GROUND:
        return None
    body = parts.bodies.get(name)
    if body is not None:
        return lambda point: body.at(point, name)
    _existing_set(parts, name, "against: a body or set of nodes", [*parts.bodies, GROUND])
    return _nodes(parts, name, None, table.facing)


def _surface(table: SurfaceTable, against: Opposite, parts: Parts) -> NodeSurface:
    """The surface with its normals to the outside."""
    name = str(table.surface)
    if table.facing is not None:
        return _nodes(parts, name, table.line, table.facing)
    if against is None:
        raise InputError("facing must be given where a surface lies against the ground, but is missing.")
    return _nodes(parts, name, table.line, opposite=_middle(table, against, parts))


def _is_line(parts: Parts, name: str, stated: bool | None) -> bool | None:
    """Whether a set is a line, as stated; else not where the mesh has faces there, and None where coordinates are to say it."""
    covers = parts.sets.get(name.removeprefix(NEXT))
    if stated is None and covers is False:
        raise line_as_surface(name, len(parts.structure.sets[name.removeprefix(NEXT)]))
    return False if stated is None and covers else stated


def _nodes(
    parts: Parts, name: str, line: bool | None, towards: list[float] | None = None, opposite: Array | None = None
) -> NodeSurface:
    """The surface of a set of nodes, of this sector or of the following one; directions and points as this sector has them."""
    _existing_set(parts, name)
    line = _is_line(parts, name, line)
    if not name.startswith(NEXT):
        return NodeSurface.of(parts.structure, name, towards, opposite, line)
    disk, own = parts.structure, name.removeprefix(NEXT)
    if not isinstance(disk, CyclicStructure):
        raise fault(f"The surface {name!r}", "must belong to a sector", "a structure without [structure.sector]")
    back = None if towards is None else disk.axis.turn(disk.sectors, -1) @ np.asarray(towards)
    away = None if opposite is None else disk.axis.turned(opposite, disk.sectors, -1)
    return NodeSurface.of(disk, own, back, away, line).following(disk)


def _middle(table: SurfaceTable, against: Opposite, parts: Parts) -> Array | None:
    """Where what lies opposite has its middle; None for the ground."""
    if against is None:
        return None
    if isinstance(against, NodeSurface):
        return np.asarray(against.weights @ against.points)
    return np.asarray(parts.bodies[str(table.against)].centre)


def _pressed(law: Law, pressure: float, surface: NodeSurface) -> Law:
    """The law with the force of a mean pressure beside its preload."""
    if not pressure:
        return law
    if not surface.area or not law.has_normal:
        raise fault("mean_pressure", "must go with kn and a surface that has an area", pressure)
    whole: Any = law
    share = pressure * surface.area / np.size(whole.preload)
    preload = tuple(share + each for each in whole.preload) if np.ndim(whole.preload) else share + whole.preload
    pressed: Law = replace(whole, preload=preload)
    return pressed


def _misfit(name: str, surface: NodeSurface, against: str, parts: Parts, system: UnitSystem) -> list[str]:
    """A warning where the nearest face of a body with a section does not lie on the surface."""
    body = parts.bodies.get(against)
    normal = surface.mean_normal
    face = None if body is None else body.nearest_face(surface.weights @ surface.points)
    if face is None or normal is None:
        return []
    away, outwards = face
    inclined = float(np.degrees(np.arccos(np.clip(-outwards @ normal, -1.0, 1.0))))
    if away <= APART * max(surface.size, SMALLEST) and inclined <= INCLINED:
        return []
    metre, length = in_system("m", system)
    return [
        f"Warning: {name}: the nearest face of {against} is {metre * away:.3g} {length} away from the middle of the surface and "
        f"inclined to it by {inclined:.0f} degrees. {CHECK_FIT}"
    ]


def _unmet(
    name: str, law: Law, surface: NodeSurface, contacts: Sequence[Contact], table: SurfaceTable, system: UnitSystem
) -> list[str]:
    """What is lost of a surface by nodes that have nothing opposite; a warning where it is more than a little."""
    met = {dof.rpartition(".")[0] for contact in contacts for direction in contact.directions for dof in direction}
    beyond = np.array([node not in met for node in surface.nodes])
    lost = float(surface.weights[beyond].sum())
    if not beyond.any():
        return []
    area, square = (1e6, "mm2") if system.length == "m" else in_system("m2", system)
    newton, unit = in_system("N", system)
    area_lost = f"{100.0 * lost:.2g} % of the {'area' if surface.area else 'length'}"
    area_lost += f" ({area * lost * surface.area:.4g} {square})" if surface.area else ""
    load = sum(float(np.sum(getattr(law, key, None) or 0.0)) for key in ("preload", "normal_load"))
    loads = f", of the stiffness and of the normal load ({newton * lost * load:.4g} {unit})" if load else " and of the stiffness"
    count = f"{int(beyond.sum())} of {counted(len(beyond), 'node')}"
    said = f"{count} of {table.surface} have nothing opposite on {table.against}: {area_lost}{loads} is lost"
    if lost <= LOST:
        return [f"{name}: {said}"]
    remedy = (
        f"Select the nodes that touch, or divide kt, kn and loads by {1.0 - lost:.3g} if they are those of the contact as it is."
    )
    return [f"Warning: {name}: {said}. {remedy}"]


def _written(direction: Array) -> str:
    """A direction as it is written in a study."""
    return ", ".join(f"{axis:.3g}" for axis in np.round(direction, 6) + 0.0)


def _skew(name: str, table: SurfaceTable, surface: NodeSurface) -> list[str]:
    """A warning where normals of the mesh, along which contacts act, are far from the direction that was stated."""
    middle = surface.mean_normal
    if table.facing is None or middle is None:
        return []
    normals, stated = np.vstack([middle, surface.normals]), np.array(table.facing) / np.abs(table.facing).max()
    angles = np.degrees(np.arccos(np.clip(normals @ stated / np.linalg.norm(stated), -1.0, 1.0)))
    far, most = int(np.sum(angles[1:] > SKEW)), int(np.argmax(angles[1:]))
    if not far and angles[0] <= SKEW:
        return []
    at = f"{angles[most + 1]:.0f} at node {surface.nodes[most].rpartition('/')[2]}"
    if angles[0] > SKEW:
        what = f"the mean normal of {table.surface} differs by {angles[0]:.0f} degrees from `facing`, up to {at}"
        remedy = f"Write `facing = [{_written(middle)}]` if the mesh is right, else check the set."
    else:
        count = f"{far} of the {len(surface.nodes)} normals"
        what = f"{count} of {table.surface} differ by more than {SKEW:g} degrees from `facing`, up to {at}"
        remedy = "Take out nodes of other faces, and divide a curved surface into sets with a `facing` each."
    return [f"Warning: {name}: {what}. Contacts act along the normals of the mesh. {remedy}"]


def turning_notes(contacts: Sequence[Contact], bodies: Iterable[str]) -> list[str]:
    """For each body that turns more easily on patches than on all nodes how much so: a patch moves as the mean of its nodes and
    does not resist rotation about itself."""
    notes = []
    for body in bodies:
        own = [contact for contact in contacts if any(dof.startswith(f"{body}/") for each in contact.directions for dof in each)]
        share = turning_share(own, body) if any(contact.nodes for contact in own) else 1.0
        if share > STIFF:
            continue
        note = f"The contact points hold {body} in the softest direction with {100.0 * share:.0f} % of the stiffness of all nodes"
        remedy = ". Where the body turns, peaks may be far off: take more `points`, or leave `points` out."
        notes.append(f"Warning: {note}{remedy}" if share < SOFT else note)
    return notes


def turning_share(contacts: Sequence[Contact], body: str) -> float:
    """The least ratio of the stiffness of contacts on patches to that at all their nodes, over all motions of a rigid body, when
    all contacts stick and what they touch is still: the lowest λ of K_patches v = λ K_nodes v."""
    dofs = sorted({dof for contact in contacts for each in contact.directions for dof in each if dof.startswith(f"{body}/")})

    def stiffness(given: Iterable[Contact]) -> Array:
        total = np.zeros((len(dofs), len(dofs)))
        for contact in given:
            elements = contact.elements
            sizes = [float(friction.stiffness.sum()) for friction in elements.friction]
            sizes += [] if elements.normal is None else [float(elements.normal.stiffness.sum())]
            for direction, size in zip(contact.directions, sizes, strict=True):
                row = np.array([direction.get(dof, 0.0) for dof in dofs])
                total += size * np.outer(row, row)
        return total

    patches, nodes = stiffness(contacts), stiffness(each for contact in contacts for each in contact.at_nodes)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(nodes), np.finfo(float).tiny))
    squares, axes = linalg.eigh(scale[:, None] * nodes * scale)
    held = axes[:, squares > HELD] / np.sqrt(squares[squares > HELD])
    return float(linalg.eigvalsh(held.T @ (scale[:, None] * patches * scale) @ held)[0]) if held.size else 1.0


def _note(
    name: str,
    surface: NodeSurface,
    contacts: tuple[Contact, ...],
    table: SurfaceTable,
    opposite: Array | None,
    system: UnitSystem,
) -> str:
    """What was found, and what is likely a slip, in the units of the study; areas of a study in m in mm²."""
    middle = surface.mean_normal
    normal = "none" if middle is None else _written(middle)
    factor, unit = (1e6, "mm2") if system.length == "m" else in_system("m2", system)
    area = f", {factor * surface.area:.4g} {unit}" if surface.area else f", {surface.kind}"
    touching = sum(len(contact.at_nodes) for contact in contacts)
    what = counted(len(contacts), "contact")
    if len(contacts) < touching:
        what = f"{counted(len(contacts), 'point')} of {counted(touching, 'node')}"
    found = [f"{name}: {what} on {table.surface} against {table.against}{area}; mean normal {normal}"]
    if len(contacts) < touching and surface.area:
        areas = [f"{contact.name} {factor * contact.area:.4g}" for contact in contacts]
        found.append(f"Areas in {unit}: {first_of(areas)}")
    if table.points is not None and table.points > touching:
        found.append(f"points = {table.points} are more than its nodes, so there is a contact at each")
    if not surface.area and table.facing is None:
        found.append(f"The normals of {surface.kind} point to the middle of {table.against}: give `facing` for another direction")
    if surface.has_holes:
        found.append("The nodes leave out a hole or a recess, whose area does not count")
    if opposite is not None:
        metre, length = in_system("m", system)
        away = float(np.linalg.norm(opposite - surface.weights @ surface.points))
        if away > FAR * max(surface.size, SMALLEST):
            times = f"{away / max(surface.size, SMALLEST):.0f} times the size"
            found.append(f"{table.against} is {metre * away:.3g} {length} away, {times}: {CHECK_UNITS}")
    return ". ".join(found)
