"""[structure] tables with a model file or small matrices, converted to a `Structure` in SI."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.model.readers.content import Content
from stickslip.model.readers.describe import implausible
from stickslip.model.readers.model import Model, model_of
from stickslip.model.readers.named_rows import with_names
from stickslip.model.readers.places import places_of
from stickslip.model.readers.read import read_content
from stickslip.model.readers.reduction import Progress, structure_of
from stickslip.model.readers.sector import Faces, disks_of
from stickslip.model.readers.stress_places import StrainGauge, StressRows, stress_rows_of
from stickslip.model.structure.cyclic import CyclicStructure, HeldDiameters
from stickslip.model.structure.damping import Damping
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.rotation_axis import RotationAxis
from stickslip.study.tables import AxisTable, FilesTable, GaugeTable, MatricesTable, SectorTable, StructureTable
from stickslip.study.units import SYSTEMS, Units
from stickslip.support.checks import Array, InputError, fault

OF_A_COPY = ("name", "keep", "modes", "shift", "stress", "speed", "axis")
"""What structures of one and the same model may differ in."""
ONLY_WITH_MODEL = ("names", "variables", "units", "keep", "modes", "shift", "sector", "stress", "speed", "axis")


@dataclass(frozen=True, eq=False)
class Built:
    """The structure of a [structure] table; notes on where places were found and what is implausible; disks: of a sector
    whose speed is given, by rotor speed in rev/min, the disk itself and those of its models at other speeds, in one basis;
    sets: names of all sets of nodes of the model, of which the structure keeps some."""

    structure: Structure
    notes: tuple[str, ...]
    disks: Mapping[float, CyclicStructure]
    sets: tuple[str, ...]


def structure(
    table: StructureTable,
    damping: Damping | None,
    folder: Path,
    units: Units,
    progress: Progress,
    surfaces: Sequence[str],
    models: dict[str, Model],
    engine_order: int | None,
) -> Built:
    """The structure of a model; of a sector for the nodal diameters that an engine order can excite, for all where it is None.

    surfaces: sets of nodes that contacts speak of; those that the model has are kept too. models: those of the study that were
    read already, to which this one is added: equal blades are read once.
    """
    own = SYSTEMS[table.units] if table.units is not None else units
    key = repr([(name, value) for name, value in table if name not in OF_A_COPY])
    model = models[key] = models.get(key) or _model(table, folder, own)
    keep = {} if table.keep is None else table.keep
    stress = None if table.stress is None else stress_rows_of(model, _stress_places(table.stress), own.system.metres)
    if table.sector is not None:
        return _disk(table, table.sector, model, surfaces, folder, own, progress, stress, engine_order)
    besides = [name for name in surfaces if name in model.sets and name not in keep]
    reduced = table.keep is not None or (table.modes is not None and besides)
    places = places_of(model, keep, own.system.metres, besides) if reduced else None
    notes = (*map(str, places or ()), *(stress.notes if stress else ()), *model.notes, *implausible(model))
    rotation = None if table.speed is None else (table.speed, _axis(table.axis or AxisTable(), own))
    if rotation is None and table.axis is not None:
        raise fault("axis", "must go with speed", "without one")
    made, found = structure_of(model, places, table.modes, damping, progress, stress, rotation)
    made = made if table.shift is None else made.shifted([own.system.metres * each for each in table.shift])
    return Built(made, (*notes, *found), {}, tuple(model.sets))


def _axis(table: AxisTable, units: Units) -> RotationAxis:
    """The axis of a table, whose point is in the unit of length of the model."""
    return RotationAxis.of((table.point, table.direction)).scaled(units.system.metres)


def _stress_places(asked: Mapping[str, Any]) -> dict[str, Any]:
    """The places of stress as the models take them."""
    return {
        name: StrainGauge(where.at, where.direction) if isinstance(where, GaugeTable) else where for name, where in asked.items()
    }


def _disk(
    table: StructureTable,
    sector: SectorTable,
    model: Model,
    surfaces: Sequence[str],
    folder: Path,
    units: Units,
    progress: Progress,
    stress: StressRows | None,
    engine_order: int | None,
) -> Built:
    """The disk of which a model is one sector; its damping follows, with the bodies."""
    if table.shift is not None:
        raise fault("shift", "must go with a whole structure", "beside [structure.sector]", "Leave it out.")
    given = [key for key in ("speed", "axis") if getattr(table, key) is not None]
    if given:
        raise fault(" and ".join(given), "must be given in [structure.sector] for a sector", "in [structure]")
    keep = {} if table.keep is None else table.keep
    places = places_of(model, keep, units.system.metres, [name for name in surfaces if name in model.sets and name not in keep])
    if not places:
        raise InputError("keep must name the places of outputs and loads of the sector, but is missing.")
    speeds = [] if sector.speed is None else [sector.speed]
    if sector.at_speeds and not speeds:
        raise InputError("sector: speed, of the model itself, must be given beside at_speeds, but is missing.")
    speeds += [each.speed for each in sector.at_speeds]
    if len(set(speeds)) < len(speeds):
        raise fault("sector: at_speeds", "must be of different speeds, and not of that of the model itself", speeds)
    others = [_model(table.model_copy(update={"model": each.model}), folder, units) for each in sector.at_speeds]
    faces = Faces(sector.sectors, sector.low, sector.high, _axis(sector.axis, units), sector.faces == "interpolated")
    chosen = None if engine_order is None else HeldDiameters.excited(sector.sectors, engine_order)
    disks, notes = disks_of([model, *others], faces, places, table.modes, None, progress, speeds, stress, chosen)
    by_speed = dict(zip(speeds, disks, strict=bool(speeds)))
    return Built(disks[0], (*notes, *model.notes, *implausible(model)), by_speed, tuple(model.sets))


def _model(table: StructureTable, folder: Path, units: Units) -> Model:
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
