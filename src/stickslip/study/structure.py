"""The structure of a study: [structure] tables with a model file or small matrices, rigid bodies, and the gas forces of
[aerodynamics], put together as one structure in SI."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from stickslip.model.contact.point import GROUND
from stickslip.model.dampers.damper import Shape
from stickslip.model.dampers.seat import BY_HAND, Seat
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.interfaces.node_surface import nodes_of
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import CentrifugalLoad, in_rotation
from stickslip.model.readers import stress_places
from stickslip.model.readers.model import Content, Model, implausible, model_of
from stickslip.model.readers.named_rows import with_names
from stickslip.model.readers.read import read_content
from stickslip.model.readers.reduction import WHOLE_SIZE, Progress, structure_of
from stickslip.model.readers.sector import Faces, disks_of, held_alike
from stickslip.model.structure.aerodynamics import Aerodynamics
from stickslip.model.structure.assembly import RigidBody, assemble
from stickslip.model.structure.centrifugal import RotationAxis, coriolis, softening
from stickslip.model.structure.cyclic import NEXT, CyclicStructure, HeldDiameters, with_bodies
from stickslip.model.structure.matrices import Damping, Structure
from stickslip.model.structure.modes import lowest_modes, rigid_motions
from stickslip.results.schema import in_system
from stickslip.study import build, fields
from stickslip.study.faults import WARNING, Found
from stickslip.study.tables import AxisTable, BodyTable, FilesTable, GaugeTable, MatricesTable, SectorTable, StructureTable
from stickslip.support.checks import MOST, Array, InputError, fault, nearest
from stickslip.support.units import UnitSystem

MANY_KEPT = 800
"""Rows of contact nodes of a model from which on none is kept: two blades with 477 each take 43 CPU s with kept rows and 58 from
the mesh; with 1257 each they take 125 CPU s and 3 GB, and with 1821 each they do not end.
"""

OF_SECTOR = ". A study without [rotation] has the natural frequencies that it lowers"
"""The end of a note: the frequencies of a sector are those of its reduction, which holds one K."""

SOFTENED = 0.1
"""Share of a natural frequency that spin softening alone may take. Of a blade, stress stiffening adds at least 1.19 times as much
stiffness (M. J. Schilhansl, J. Appl. Mech. 25, 1958, 28-30), so that the error of a K without it is larger than what is taken."""

BALANCED = 1e-9
"""Share of its centrifugal load up to which the resultant of a body is rounding."""

Rotation = tuple[float, RotationAxis, bool]
"""Speed in rev/min, axis, and whether Coriolis forces act."""
OF_A_COPY = ("name", "keep", "modes", "shift", "stress", "speed", "axis")
"""What structures of one and the same model may differ in."""
ONLY_WITH_MODEL = ("names", "variables", "units", "keep", "modes", "shift", "sector", "stress", "speed", "axis")


@dataclass(frozen=True, eq=False)
class Built:
    """The structure of a [structure] table; notes on where places were found and what is implausible; disks: of a sector
    whose speed is given, by rotor speed in rev/min, the disk itself and those of its models at other speeds, in one basis;
    sets: all sets of nodes of the model, of which the structure keeps some, and whether those of contacts and forces cover an
    area by the mesh (`Model.covers`)."""

    structure: Structure
    notes: tuple[str, ...]
    disks: Mapping[float, CyclicStructure]
    sets: Mapping[str, bool | None]


class Whole(NamedTuple):
    """What holds for all structures of a study."""

    damping: Damping | None
    engine_order: int | None
    rotation: Rotation | None


def structure(
    table: StructureTable,
    whole: Whole,
    folder: Path,
    units: fields.Units,
    progress: Progress,
    surfaces: Sequence[str],
    models: dict[str, Model],
    meshed: Sequence[str] = (),
) -> Built:
    """The structure of a model; of a sector for the nodal diameters that an engine order can excite, for all where it is None.

    surfaces: sets of nodes that contacts speak of; those that the model has are kept too. models: those of the study that were
    read already, to which this one is added: equal blades are read once. meshed: sets whose contacts may reduce a large
    model; of many such rows none is kept. K shall have the spin softening of the rotation of the whole.
    """
    damping, _, rotation = whole
    own = fields.SYSTEMS[table.units] if table.units is not None else units
    key = repr([(name, value) for name, value in table if name not in OF_A_COPY])
    given = [name for name in ("speed", "axis") if getattr(table, name) is not None]
    if rotation is not None and given:
        raise fault(" and ".join(given), "must be left out with [rotation], which applies to all models", "given")
    if key not in models:
        model = _model(table, folder, own)
        models[key] = model if rotation is None else _rotating(model, rotation, table.sector is not None)
    model, others = models[key], []
    if table.sector is not None:
        model, *others = _at_speeds(model, table, folder, own, rotation)
    keep = {} if table.keep is None else table.keep
    stress = (
        None if table.stress is None else stress_places.stress_rows_of(model, _stress_places(table.stress), own.system.metres)
    )
    if table.sector is not None:
        return _disk(table, table.sector, [model, *others], surfaces, own, progress, stress, whole)
    besides = [name for name in surfaces if name in model.sets and name not in keep]
    rows = [row for name in meshed if name in model.sets for node in model.sets[name] for row in model.directions.get(node, ())]
    sparse = len(rows) >= MANY_KEPT and model.size > WHOLE_SIZE and model.C is None and model.coriolis is None
    reduced = sparse or table.keep is not None or (table.modes is not None and besides)
    places = stress_places.places_of(model, keep, own.system.metres, besides) if reduced else None
    notes = (*map(str, places or ()), *(stress.notes if stress else ()), *model.notes, *implausible(model))
    own_rotation = None if table.speed is None else (table.speed, _axis(table.axis or AxisTable(), own))
    if own_rotation is None and table.axis is not None:
        raise fault("axis", "must be given with a speed", "without one")
    made, found = structure_of(model, places, table.modes, damping, progress, stress, own_rotation, sparse)
    made = made if table.shift is None else made.shifted([own.system.metres * each for each in table.shift])
    return Built(made, (*notes, *found), {}, _sets(model, surfaces, places or ()))


def _sets(model: Model, surfaces: Sequence[str], places: Sequence[stress_places.Place]) -> dict[str, bool | None]:
    """All sets of nodes of a model, and whether those of contacts and forces cover an area by its mesh."""
    nodes = {**model.sets, **{place.name: place.nodes for place in places}}
    return {name: model.covers(members) if name in surfaces else None for name, members in nodes.items()}


def _at_speeds(model: Model, table: StructureTable, folder: Path, units: fields.Units, rotation: Rotation | None) -> list[Model]:
    """The model of a sector, and those at its other speeds, each with its own spin softening beside [rotation]."""
    assert table.sector is not None
    found = [model]
    for each in table.sector.at_speeds:
        other = _model(table.model_copy(update={"model": each.model}), folder, units)
        found.append(_softened(other, each.speed, rotation[1], True) if rotation is not None and each.speed else other)
    return held_alike(found, _faces(table.sector, units))


def _faces(sector: SectorTable, units: fields.Units) -> Faces:
    return Faces(sector.sectors, sector.low, sector.high, _axis(sector.axis, units), sector.faces == "interpolated")


def _rotating(model: Model, rotation: Rotation, sector: bool) -> Model:
    """The model with the spin softening in K, and its Coriolis forces where they act."""
    speed, axis, with_coriolis = rotation
    softened = _softened(model, speed, axis, sector)
    if not with_coriolis:
        return softened
    if sector:
        raise fault("coriolis of [rotation]", "must be left out beside a sector, whose Coriolis forces are neglected", "true")
    return replace(softened, coriolis=2.0 * np.pi * speed / 60.0 * coriolis(model.M, model.dofs, axis))


def _softened(model: Model, speed: float, axis: RotationAxis, sector: bool) -> Model:
    """The model with the spin softening −Ω² M (1 − d dᵀ) in K, and a note on what K held of the rotation.

    The K of a body that contacts alone hold keeps its rigid motions free: by these such a body is recognised. A sector is held by
    its neighbours too, and its reduction says where that is not enough.
    """
    stress_places.centrifugal_loads(model)  # says what is missing for them, before a reduction that takes long
    note = stress_places.prestress_note(model, axis, speed)
    if not stress_places.spin_softening(model, axis):
        turning = [dof for dof in model.dofs if dof.rpartition(".")[2] not in ("x", "y", "z")]
        done = f"none is added to a model with rows such as {turning[0]}" if turning else "it is added, −Ω² M (1 − d dᵀ)"
        if not sector and rigid_motions(model.K, model.dofs, model.nodes).shape[1]:
            done = "none is added to a model that only contacts restrain"
        elif not turning:
            follows = softening(model.M, model.dofs, axis)
            taken = (2.0 * np.pi * speed / 60.0) ** 2 * follows
            lowered, warned = (OF_SECTOR, ()) if sector else _lowered(model, taken, speed, axis)
            done += lowered
            model = replace(model, K=model.K - taken, softening=follows, notes=(*model.notes, *warned))
        note = f"K contains no spin softening of {speed:g} rev/min: {done}. It contains stress stiffening only if the file does"
    return replace(model, notes=(*model.notes, note))


def _lowered(model: Model, taken: Any, speed: float, axis: RotationAxis) -> tuple[str, tuple[str, ...]]:
    """What spin softening takes of a frequency, as the end of a note, and as a warning where it is much.

    It takes at most Ω² of ω²: of the lowest modes those count that are slow enough, whichever way they move. A load that balances
    itself, as that of a shaft about its own axis, stiffens nothing: Coriolis forces, and not K, then lack.
    """
    lowest = [lowest_modes(model.M, K) for K in (model.K, model.K - taken)]
    hertz = [np.zeros(1) if modes is None or modes.negative else modes.frequencies for modes in lowest]
    if not hertz[1][0]:
        remedy = "Use a K with the stress stiffening of this speed, or a lower speed."
        raise fault("speed of [rotation]", "must leave K positive definite after spin softening", speed, remedy)
    before, after = (each[: min(map(len, hertz))] for each in hertz)
    most = int(np.argmax(1.0 - after / before))
    lowered = f"lowers the lowest natural frequency from {before[0]:.4g} to {after[0]:.4g} Hz"
    lowered += f", and mode {most + 1} from {before[most]:.4g} to {after[most]:.4g} Hz" if most else ""
    if after[most] >= (1.0 - SOFTENED) * before[most]:
        return f", and {lowered}", ()
    if not _pulled_outwards(model, axis):
        known = "The load is balanced about the axis, as on a shaft, which needs coriolis = true and hardly stiffens"
        return f", and {lowered}. {known}; the missing stress stiffening of parts far from the axis is not known", ()
    remedy = "blades by more: use the matrices of a step with CENTRIF, or frequencies are too low"
    warned = (
        f"Warning: spin softening of {speed:g} rev/min {lowered}, and K has no stress stiffening, which raises those of {remedy}."
    )
    return f", and {lowered}", (warned,)


def _pulled_outwards(model: Model, axis: RotationAxis) -> bool:
    """Whether the mass lies to one side of the axis, so that its load pulls one way: r_G² at least half of the mean r²."""
    direction, moved = np.array(axis.direction), np.zeros((model.size, 4))
    for row, dof in enumerate(model.dofs):
        node, _, along = dof.rpartition(".")
        if node in model.nodes:
            away = np.array(model.nodes[node]) - axis.point
            moved[row, "xyz".index(along)] = 1.0
            moved[row, 3] = (away - (away @ direction) * direction)["xyz".index(along)]
    products = moved.T @ (model.M @ moved)
    mass = np.trace(products[:3, :3]) / 3.0
    return bool(products[3, :3] @ products[3, :3] >= 0.5 * mass * products[3, 3])


def _axis(table: AxisTable, units: fields.Units) -> RotationAxis:
    """The axis of a table, whose point is in the unit of length of the model."""
    return RotationAxis.of((table.point, table.direction)).scaled(units.system.metres)


def _stress_places(asked: Mapping[str, Any]) -> dict[str, Any]:
    """The places of stress as the models take them."""
    return {
        name: stress_places.StrainGauge(where.at, where.direction) if isinstance(where, GaugeTable) else where
        for name, where in asked.items()
    }


def _disk(
    table: StructureTable,
    sector: SectorTable,
    models: Sequence[Model],
    surfaces: Sequence[str],
    units: fields.Units,
    progress: Progress,
    stress: stress_places.StressRows | None,
    whole: Whole,
) -> Built:
    """The disk of which a model is one sector; its damping follows, with the bodies. models: at its other speeds, too."""
    if table.shift is not None:
        raise fault("shift", "must go with a whole structure", "beside [structure.sector]", "Leave it out.")
    given = [key for key in ("speed", "axis") if getattr(table, key) is not None]
    if given:
        raise fault(" and ".join(given), "must be given in [structure.sector] for a sector", "in [structure]")
    keep, model = {} if table.keep is None else table.keep, models[0]
    places = stress_places.places_of(
        model, keep, units.system.metres, [name for name in surfaces if name in model.sets and name not in keep]
    )
    if not places:
        raise InputError("keep must name the places of outputs and loads of the sector, but is missing.")
    speeds = [] if sector.speed is None else [sector.speed]
    if whole.rotation is not None and speeds:
        raise fault("speed of [structure.sector]", "must be left out with [rotation], which applies to all models", "given")
    if whole.rotation is not None and sector.at_speeds:
        speeds = [whole.rotation[0]]
    if sector.at_speeds and not speeds:
        raise InputError("sector: with at_speeds, speed must be given (that of [structure] model), but is missing.")
    speeds += [each.speed for each in sector.at_speeds]
    if len(set(speeds)) < len(speeds):
        raise fault("sector: at_speeds", "must be of different speeds, and not of that of the model itself", speeds)
    order, faces = whole.engine_order, _faces(sector, units)
    chosen = None if order is None else HeldDiameters.excited(sector.sectors, order)
    disks, notes = disks_of(models, faces, places, table.modes, None, progress, speeds, stress, chosen)
    if whole.rotation is not None:  # the model says what K held before its softening was added
        notes = tuple(note for note in notes if note != stress_places.prestress_note(model, faces.axis, None))
    by_speed = dict(zip(speeds, disks, strict=bool(speeds)))
    own = (*(note for each in models for note in each.notes), *implausible(model))
    return Built(disks[0], (*notes, *own), by_speed, _sets(model, surfaces, places))


def _model(table: StructureTable, folder: Path, units: fields.Units) -> Model:
    if table.model is None:
        given = [key for key in ONLY_WITH_MODEL if getattr(table, key) is not None]
        if given:
            raise fault(" and ".join(given), "must go with model", "without one")
    variables = table.variables or {}
    content, file = _content(table, folder, variables)
    if table.names is not None:
        content = with_names(content, folder / table.names)
    return model_of(content, units.system, variables, table.dofs or (), file, table.own_damping)


def _content(table: StructureTable, folder: Path, variables: Mapping[Any, str]) -> tuple[Content, str]:
    """What the file holds, or the matrices that stand in the study."""
    place = table.matrices if table.model is None else table.model
    if isinstance(place, MatricesTable):
        given = {"M": place.M, "K": place.K, "C": place.C}
        return Content("study", {name: _rectangular(name, rows) for name, rows in given.items() if rows is not None}), ""
    if isinstance(place, FilesTable):
        given_files = {"M": place.M, "K": place.K, "C": place.C}
        return read_content({letter: folder / name for letter, name in given_files.items() if name is not None}, variables)
    return read_content(folder / str(place), variables)


def _rectangular(name: str, rows: Sequence[Sequence[float]]) -> Array:
    """Rows of one length as an array."""
    lengths = {len(row) for row in rows}
    if len(lengths) != 1:
        raise fault(name, "must have rows of one length", [len(row) for row in rows])
    return np.array(rows, dtype=float)


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
    sets: Mapping[str, bool | None] = field(default_factory=dict)
    """All sets of nodes of the models, which a wrong name may have meant, and whether they cover an area by the mesh."""
    loads: tuple[CentrifugalLoad, ...] = ()
    """Of the rotation, one for each model and body."""


def structures_of(
    tables: Sequence[StructureTable | None],
    several: bool,
    surfaces: Sequence[str],
    whole: Whole,
    folder: Path,
    units: fields.Units,
    found: Found,
    messages: Messages,
    meshed: Sequence[str] = (),
) -> dict[str, Built]:
    """The structures that could be made, by name, "" for one alone; each keeps those `surfaces` that are its own, a sector the
    nodal diameters that an engine order can excite. meshed: as of `structure`."""
    made: dict[str, Built] = {}
    models: dict[str, Model] = {}
    progress, notes = messages
    for number, table in enumerate(tables, start=1):
        place = f"[[structure]] {number}" if several else "[structure]"
        name = None if table is None else found.attempt(place, _name, table, several, made)
        if name is None:
            continue
        own = own_of(surfaces, name)
        if table is not None and table.sector is not None:
            own = list(dict.fromkeys(surface.removeprefix(NEXT) for surface in own))
        built = found.attempt(place, structure, table, whole, folder, units, progress, own, models, own_of(meshed, name))
        if built:
            made[name] = built
            notes += [note_of_part(name, note) for note in built.notes]
    return made


def note_of_part(name: str, note: str) -> str:
    """A note on one of several structures, whose warnings begin as all do."""
    warning = WARNING if note.startswith(WARNING) else ""
    return f"{warning}{name}: {note.removeprefix(warning)}" if name else note


def own_of(surfaces: Sequence[str], name: str) -> list[str]:
    """The surfaces of one structure, by their names in it."""
    return [surface.removeprefix(f"{name}/") for surface in surfaces if not name or surface.startswith(f"{name}/")]


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
    tables: Sequence[BodyTable | None],
    built: Mapping[str, Built],
    units: fields.Units,
    found: Found,
    rotation: Rotation | None,
    notes: list[str],
) -> tuple[dict[str, RigidBody], tuple[Force, ...]]:
    """The rigid bodies by name, and the static forces that pull them; with `rotation` their own mass does."""
    bodies: dict[str, RigidBody] = {}
    pulls: tuple[Force, ...] = ()
    taken = (*built, GROUND)
    for number, table in enumerate(tables, start=1):
        place, seat = f"[[body]] {number}", None
        if table is None:
            continue
        if table.between is not None and (seat := found.attempt(place, _seat, table, built, rotation)) is None:
            continue
        if (made := found.attempt(place, build.body, table, units, seat)) is None:
            continue
        if table.name in (*bodies, *taken):
            found.messages.append(f"[[body]] {number}: {fault('name', 'must be another one for each', table.name)}")
            continue
        if rotation and made[1]:
            remedy = "The mass of the body pulls it; leave `pull` out."
            found.messages.append(f"[[body]] {number}: {fault('pull', 'must not stand beside [rotation]', table.pull, remedy)}")
        bodies[table.name], pulls = made[0], (*pulls, *made[1])
        if seat is not None:
            notes.append(seat_note(table.name, *build.fitted(table, seat, units), units.system))
        notes.append(body_note(table.name, made[0], units.system))
    return bodies, pulls


def _seat(table: BodyTable, built: Mapping[str, Built], rotation: Rotation | None) -> Seat:
    """Where a body lies between two sets of nodes, `next/` those of the following sector; it is pulled as stated, or away from
    the axis of rotation."""
    places = []
    for name in table.between or ():
        whole = name.removeprefix(NEXT)
        owner, _, own = whole.rpartition("/") if "" not in built else ("", "", whole)
        if owner not in built:
            raise InputError(f"between: set of nodes {name!r} does not exist. {nearest(owner, list(built))}")
        structure = built[owner].structure
        if own not in structure.sets:
            known = ", ".join(structure.sets) or "none"
            rule = f"must be a surface of a contact or a force, or be kept, keep = [{own!r}], as are: {known}"
            raise fault(f"between: set of nodes {name!r}", rule, "neither")
        points = np.array([structure.nodes[node] for node in nodes_of(structure, own)])
        if name != whole:
            if not isinstance(structure, CyclicStructure):
                raise fault(f"The surface {name!r}", "must belong to a sector", "a structure without [structure.sector]")
            points = structure.axis.turned(points, structure.sectors, 1)
        places.append(points)
    left, right = places
    if any(table.pull):
        return Seat.between(left, right, table.pull)
    if rotation is None:
        raise fault(
            "between", "needs a pull, or [rotation]: it says which way the ridge of the platforms lies", "without", BY_HAND
        )
    _, axis, _ = rotation
    middle = 0.5 * (left.mean(axis=0) + right.mean(axis=0))
    return Seat.between(left, right, axis.across @ (middle - axis.point))


def seat_note(name: str, shape: Shape, table: BodyTable, system: UnitSystem) -> str:
    """The dimensions and axes of a body that was fitted between two platforms, as a study states them."""
    metre, unit = in_system("m", system)
    said = [
        f"{key} {value:.4g} degrees" if key.endswith("_angle") else f"{key} {metre * value:.4g} {unit}"
        for key, value in vars(shape).items()
        if isinstance(value, float) and key not in build.OTHER_DIMENSIONS
    ]
    axes = ", ".join(f"[{', '.join(f'{part + 0.0:.5g}' for part in np.round(axis, 6))}]" for axis in table.axes or ())
    return f"{name}: fitted between {' and '.join(table.between or ())}: {', '.join(said)}; axes = [{axes}]"


def body_note(name: str, body: RigidBody, system: UnitSystem) -> str:
    """Mass, mass centre and section of a body, in the units of the study."""
    metre, length = in_system("m", system)
    kilogram, unit = in_system("kg", system)

    def place(point: Any) -> str:
        return f"({', '.join(f'{axis + 0.0:.4g}' for axis in np.round(metre * np.asarray(point), 9))})"

    corners = body.centre + np.reshape(body.outline, (-1, 3))
    section = f", corners of its section {', '.join(map(place, corners))}" if 0 < len(corners) <= MOST_CORNERS else ""
    return f"{name}: {kilogram * body.mass:.4g} {unit}, mass centre {place(body.centre)} {length}{section}"


def rotation_note(rotation: Rotation, loads: Iterable[CentrifugalLoad], system: UnitSystem) -> str:
    """The centrifugal load of each part, in the units of the study, and what is left out."""
    speed, _, with_coriolis = rotation
    missing = "Spin softening of bodies is" if with_coriolis else "Coriolis forces and the spin softening of bodies are"
    newton, unit = in_system("N", system)
    listed = []
    for load in loads:
        size = float(np.linalg.norm(load.resultant))
        along = ", ".join(f"{part:.3g}" for part in np.round(np.array(load.resultant) / (size or 1.0), 6) + 0.0)
        balanced = size <= BALANCED * load.static
        listed.append(f"{load.name} {'has no resultant' if balanced else f'{newton * size:.6g} {unit} along ({along})'}")
    return f"Rotation at {speed:g} rev/min: {'; '.join(listed)}. {missing} neglected"


def together(
    built: Mapping[str, Built], bodies: Mapping[str, RigidBody], damping: Damping | None, rotation: Rotation | None
) -> Parts:
    """One structure of all, with a damping rule for the whole, and its loads of rotation; a model alone stays as it is."""
    structures = {name: each.structure for name, each in built.items()}
    free = {name: body.structure() for name, body in bodies.items()}
    loads: list[CentrifugalLoad] = []
    if rotation is not None:
        speed, axis, with_coriolis = rotation
        for parts, of_bodies in ((structures, False), (free, True)):
            for name, part in parts.items():
                acts = with_coriolis and of_bodies  # models have theirs since before their reduction
                parts[name], load = in_rotation(part, speed, axis, part=name, with_coriolis=acts)
                loads.append(load)
    sets = {f"{name}/{own}" if name else own: cover for name, each in built.items() for own, cover in each.sets.items()}
    disk = structures.get("")
    if isinstance(disk, CyclicStructure):

        def whole_disk(sector: CyclicStructure) -> CyclicStructure:
            return (with_bodies(sector, free) if free else sector).with_damping(damping)

        disks = {speed: whole_disk(each) for speed, each in built[""].disks.items()}
        return Parts(whole_disk(disk), bodies, disks, sets, tuple(loads))
    if not bodies and list(structures) == [""]:
        return Parts(structures[""], {}, sets=sets, loads=tuple(loads))
    bare = {name: part if part.damping is None else part.with_damping(None) for name, part in structures.items()}
    whole = assemble(bare | free)
    return Parts(whole if damping is None else whole.with_damping(damping), bodies, sets=sets, loads=tuple(loads))


Complex = Annotated[list[fields.Number], Field(min_length=2, max_length=2), fields.Words("pair of numbers")]
Influence = Annotated[list[fields.Number], Field(min_length=3, max_length=3), fields.Words("list of three numbers")]


class AerodynamicsTable(fields.Table):
    """Gas forces on the blades of a tuned disk, or of the mistuned ones made of it, that are proportional to their motion.

    Lists by nodal diameter have one entry for each wave, n = 0, 1, ..., N − 1; n = N − 1 is −1,
    against the numbering of the sectors.
    """

    exactly_one: ClassVar[fields.Groups] = (("influence", "stiffness", "damping_ratio"),)

    influence: Annotated[list[Influence] | None, fields.STIFFNESS, Field(min_length=1)] = None
    """[k, Re L, Im L]: force on a blade per motion of the k-th blade after it; blades left out: 0"""
    stiffness: Annotated[list[Complex] | None, fields.STIFFNESS, Field(min_length=1)] = None
    """[Re A, Im A] of every nodal diameter"""
    damping_ratio: Annotated[list[fields.Number] | None, Field(min_length=1)] = None
    """of the blade alone, for every nodal diameter; negative where gas feeds the vibration"""
    frequency_shift: Annotated[list[fields.Number] | None, Field(min_length=1)] = None
    """of the blade alone, relative, for every nodal diameter; else none"""
    frequency: Annotated[fields.Positive | None, fields.FREQUENCY, Field(description="at which the coefficients hold")] = None
    direction: fields.Place | None = None
    """direction of the sector on which they act; default: the coordinate of the blade-alone mode `mode`"""
    modal_mass: Annotated[fields.Positive | None, fields.MASS, Field(description="of damping ratios along a direction")] = None
    mode: Annotated[int, Field(ge=1, le=MOST, description="number of the blade-alone mode, where no direction is given")] = 1


def with_aerodynamics(problem: Problem, table: AerodynamicsTable, units: fields.Units) -> TunedDisk:
    """A tuned disk with the gas forces of a table."""
    if not isinstance(problem, TunedDisk):
        raise fault("[structure]", 'must be a tuned disk, such as rig = "lumped_blisk"', type(problem).__name__)
    given = fields.in_si(table, units)
    influence = None if table.influence is None else _numbered(table.influence)
    stiffness = None if table.stiffness is None else [complex(*pair) for pair in table.stiffness]
    return problem.with_aerodynamics(
        Aerodynamics(
            influence=influence,
            stiffness=stiffness,
            damping_ratio=table.damping_ratio,
            frequency_shift=table.frequency_shift,
            frequency=given["frequency"],
            direction=table.direction,
            modal_mass=given["modal_mass"],
            mode=table.mode,
        )
    )


def _numbered(rows: list[list[float]]) -> dict[int, complex]:
    """Coefficients by blade."""
    found: dict[int, complex] = {}
    for number, real, imaginary in rows:
        if number != int(number):
            raise fault("influence, k", "must be a whole number", number)
        if int(number) in found:
            raise fault("influence", "must hold every blade once", int(number))
        found[int(number)] = complex(real, imaginary)
    return found
