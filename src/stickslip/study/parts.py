"""The structures and rigid bodies of a study, put together as one structure."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.model.loads import Force
from stickslip.model.readers.model import Model
from stickslip.model.readers.reduction import Progress
from stickslip.model.structure.assembly import assemble
from stickslip.model.structure.cyclic import NEXT, CyclicStructure, with_bodies
from stickslip.model.structure.damping import Damping
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.rigid_body import RigidBody
from stickslip.results.shown_units import in_system
from stickslip.study import build
from stickslip.study.faults import Found
from stickslip.study.structure import Built
from stickslip.study.structure import structure as structure_of_table
from stickslip.study.tables import BodyTable, StructureTable
from stickslip.study.units import Units
from stickslip.support.checks import InputError, fault
from stickslip.support.units import UnitSystem

MOST_CORNERS = 8
"""Corners of a section that a note lists; a round one has more."""
Messages = tuple[Progress, list[str]]
"""The progress callback for long work, and the list that collects notes on the model."""


@dataclass(frozen=True, eq=False)
class Parts:
    """What contacts can join: the assembled structure, and the rigid bodies in it by name."""

    structure: Structure
    bodies: Mapping[str, RigidBody]
    disks: Mapping[float, CyclicStructure] = field(default_factory=dict)
    """Of a sector whose speed is given, the disks with these bodies by rotor speed in rev/min."""
    sets: tuple[str, ...] = ()
    """Names of all sets of nodes of the models, which a wrong name may have meant."""


def structures_of(
    tables: Sequence[StructureTable | None],
    several: bool,
    surfaces: Sequence[str],
    damping: Damping | None,
    folder: Path,
    units: Units,
    found: Found,
    messages: Messages,
    engine_order: int | None,
) -> dict[str, Built]:
    """The structures that could be made, by name, "" for one alone; each keeps those `surfaces` that are its own, a sector the
    nodal diameters that an engine order can excite."""
    made: dict[str, Built] = {}
    models: dict[str, Model] = {}
    progress, notes = messages
    for number, table in enumerate(tables, start=1):
        place = f"[[structure]] {number}" if several else "[structure]"
        name = None if table is None else found.attempt(place, _name, table, several, made)
        if name is None:
            continue
        own = [surface.removeprefix(f"{name}/") for surface in surfaces if not name or surface.startswith(f"{name}/")]
        if table is not None and table.sector is not None:
            own = list(dict.fromkeys(surface.removeprefix(NEXT) for surface in own))
        built = found.attempt(place, structure_of_table, table, damping, folder, units, progress, own, models, engine_order)
        if built:
            made[name] = built
            notes += [f"{name}: {note}" if name else note for note in built.notes]
    return made


def _name(table: StructureTable, several: bool, taken: Mapping[str, Any]) -> str:
    """The name of one structure of a study, "" where there is one only."""
    if table.rig is not None:
        raise fault("rig", "must stand in a [structure] of its own", table.rig, "A ready rig brings its contacts.")
    if several and table.sector is not None:
        raise fault(
            "sector", "must stand in a [structure] of its own", "[[structure]]", "Blades of other disks are no neighbours."
        )
    if not several and table.name is not None:
        raise fault("name", "must go with several, [[structure]]", table.name, "Leave it out.")
    if several and table.name is None:
        raise InputError("name must be given where there are several structures, but is missing.")
    if table.name in taken:
        raise fault("name", "must be another one for each", table.name)
    return table.name or ""


def bodies_of(
    tables: Sequence[BodyTable | None], units: Units, taken: Collection[str], found: Found
) -> tuple[dict[str, RigidBody], tuple[Force, ...]]:
    """The rigid bodies by name, and the static forces that pull them."""
    bodies: dict[str, RigidBody] = {}
    pulls: tuple[Force, ...] = ()
    for number, table in enumerate(tables, start=1):
        made = None if table is None else found.attempt(f"[[body]] {number}", build.body, table, units)
        if table is None or made is None:
            continue
        if table.name in (*bodies, *taken):
            found.messages.append(f"[[body]] {number}: {fault('name', 'must be another one for each', table.name)}")
            continue
        bodies[table.name], pulls = made[0], (*pulls, *made[1])
    return bodies, pulls


def body_note(name: str, body: RigidBody, system: UnitSystem) -> str:
    """Mass, mass centre and section of a body, in the units of the study."""
    metre, length = in_system("m", system)
    kilogram, unit = in_system("kg", system)

    def place(point: Any) -> str:
        return f"({', '.join(f'{axis + 0.0:.4g}' for axis in np.round(metre * np.asarray(point), 9))})"

    corners = body.centre + np.reshape(body.outline, (-1, 3))
    section = f", corners of its section {', '.join(map(place, corners))}" if 0 < len(corners) <= MOST_CORNERS else ""
    return f"{name}: {kilogram * body.mass:.4g} {unit}, mass centre {place(body.centre)} {length}{section}"


def together(built: Mapping[str, Built], bodies: Mapping[str, RigidBody], damping: Damping | None) -> Parts:
    """One structure of all, with a damping rule for the whole; a model alone stays as it is."""
    structures = {name: each.structure for name, each in built.items()}
    sets = tuple(f"{name}/{own}" if name else own for name, each in built.items() for own in each.sets)
    disk = structures.get("")
    if isinstance(disk, CyclicStructure):
        free = {name: body.structure() for name, body in bodies.items()}

        def whole_disk(sector: CyclicStructure) -> CyclicStructure:
            return (with_bodies(sector, free) if free else sector).with_damping(damping)

        return Parts(whole_disk(disk), bodies, {speed: whole_disk(each) for speed, each in built[""].disks.items()}, sets)
    if not bodies and list(structures) == [""]:
        return Parts(structures[""], {}, sets=sets)
    bare = {name: part if part.damping is None else part.with_damping(None) for name, part in structures.items()}
    whole = assemble(bare | {name: body.structure() for name, body in bodies.items()})
    return Parts(whole if damping is None else whole.with_damping(damping), bodies, sets=sets)
