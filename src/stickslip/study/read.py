"""The way in: `read` turns a study file into a `Job`, or raises all the faults of the file at once."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

from threadpoolctl import threadpool_limits

from stickslip.analyses.forced_response import force_levels
from stickslip.checks import InputError, fault, nearest, storable
from stickslip.contact.point import Contact
from stickslip.loads import Force
from stickslip.models.reduction import Progress, quiet
from stickslip.problem import Problem
from stickslip.study import build
from stickslip.study.contacts import ContactTable, table_of
from stickslip.study.faults import Found, Model, parsed
from stickslip.study.names import Names, dofs_in
from stickslip.study.structure import structure as structure_of_table
from stickslip.study.tables import DampingTable, ForceTable, StructureTable, StudyTable, SweepTable
from stickslip.study.units import SYSTEMS, Units
from stickslip.study.variability import BoundsTable, SamplesTable, law_of
from stickslip.units import Band

REQUIRED = ("study", "structure", "sweep")
Tell = tuple[Progress, list[str]]
"""Whom to tell of long work, and the notes that gather what is to be said of the model."""
KEYS = ("units", "study", "structure", "damping", "contact", "force", "sweep", "bounds", "samples")


@dataclass(frozen=True, eq=False)
class Job:
    """What a study asks for: a problem, and where and how finely to compute it.

    `text` is the file as it stands; `matrices` tells apart what the file that it names holds, "" for a rig; `notes`: what
    is to be said of the model, as where its places were found.
    """

    title: str
    analysis: str
    problem: Problem
    frequencies: Band | tuple[float, ...]
    force_levels: tuple[float, ...]
    harmonics: int | Literal["auto"]
    samples: int
    tolerance: float
    text: str
    matrices: str = ""
    variability: BoundsTable | SamplesTable | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Tables:
    """The tables of a file; None where one is absent or faulty."""

    study: StudyTable | None
    structure: StructureTable | None
    damping: DampingTable | None
    sweep: SweepTable | None
    contact: tuple[ContactTable | None, ...]
    force: tuple[ForceTable | None, ...]
    units: Units
    bounds: BoundsTable | None = None
    samples: SamplesTable | None = None


def read(path: Path, progress: Progress = quiet) -> Job:
    """The study at `path`, checked as a whole. Raises `Faults` with every fault of the file."""
    return job(text_of(path), path.parent, path.stem, progress)


def job(text: str, folder: Path, name: str, progress: Progress = quiet) -> Job:
    """What a study asks for; paths in it count from `folder`, and `name` stands in for a missing title.

    progress(share, text) is told of the reading and reduction of a large model.
    """
    document = toml(text)
    found = Found()
    tables = tables_of(document, found)
    notes: list[str] = []
    if tables.study:
        found.attempt("[study]", storable, "title", tables.study.title)
    with threadpool_limits(1, user_api="blas"):
        problem = problem_of(tables, document, folder, found, (progress, notes))
    frequencies = found.attempt("[sweep]", build.frequencies, tables.sweep) if tables.sweep else None
    if tables.sweep:
        found.attempt("[sweep]", build.enough_samples, tables.sweep)
        found.attempt("[sweep]", force_levels, tables.sweep.force_levels)
    if tables.samples:
        found.attempt("[samples]", law_of, tables.samples)
    if tables.sweep and problem and tables.sweep.wanted_harmonics != "auto":
        found.attempt("[sweep]", problem.load, tables.sweep.wanted_harmonics)
    misplaced(tables, document, found)
    found.stop()
    if not (tables.study and tables.sweep and problem and frequencies):
        raise AssertionError("a study without faults has all its parts")
    title = tables.study.title or problem.title or name
    levels, sweep = tuple(tables.sweep.force_levels), tables.sweep
    settings = (frequencies, levels, sweep.wanted_harmonics, sweep.samples, sweep.tolerance)
    matrices = content(tables.structure, problem)
    return Job(title, tables.study.analysis, problem, *settings, text, matrices, variability_of(tables), tuple(notes))


def variability_of(tables: Tables) -> BoundsTable | SamplesTable | None:
    """What the analysis asks for beyond the forced response; all of it has defaults."""
    match tables.study.analysis if tables.study else "":
        case "response_bounds":
            return tables.bounds or BoundsTable()
        case "response_samples":
            return tables.samples or SamplesTable()
    return None


def misplaced(tables: Tables, document: Mapping[str, Any], found: Found) -> None:
    """A table of another analysis than the one asked for is refused: it would have no effect."""
    analysis = tables.study.analysis if tables.study else None
    for key, owner in (("bounds", "response_bounds"), ("samples", "response_samples")):
        if key in document and analysis is not None and analysis != owner:
            found.messages.append(f'[{key}] must go with analysis = "{owner}", but the analysis is {analysis!r}.')
    if tables.samples and tables.samples.points and tables.sweep and tables.sweep.at:
        found.messages.append("[samples]: points must go with a band, but [sweep] at lists the frequencies. Leave one out.")


def content(table: StructureTable | None, problem: Problem) -> str:
    """Tells apart the matrices that a study brings; a rig makes its own."""
    if table is None or table.rig is not None:
        return ""
    structure, digest = problem.structure, sha256()
    for matrix in (structure.M, structure.K, structure.C):
        digest.update(b"" if matrix is None else matrix.tobytes())
    return digest.hexdigest()


def problem_of(tables: Tables, document: Mapping[str, Any], folder: Path, found: Found, tell: Tell) -> Problem | None:
    """The problem of the [structure] table: a rig, or a model."""
    dofs = dofs_in(document)
    found.messages += Names(dofs, Units()).faults(document) if dofs else []
    if tables.structure is None:
        return None
    if tables.structure.rig is not None:
        return from_rig(tables.structure, tables, document, found)
    return from_model(tables.structure, tables, document, folder, found, tell)


def text_of(path: Path) -> str:
    """The text of a study file."""
    if path.is_dir():
        raise fault("The study", "must be a file", str(path), "It is a folder.")
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise fault("The study file", "must exist", str(path), "`stickslip new forced_response` writes one.") from None
    except UnicodeDecodeError:
        raise fault("The study file", "must be a text in UTF-8", str(path)) from None
    except OSError as error:
        raise fault("The study file", "must be readable", str(path), f"({error.strerror})") from None


def toml(text: str) -> dict[str, Any]:
    """The document."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"The study file must be valid TOML, but is not: {error}.") from None
    except RecursionError:
        raise InputError("The study file must be valid TOML, but nests its values too deeply.") from None


def tables_of(document: Mapping[str, Any], found: Found) -> Tables:
    """Every table on its own, so that the faults of one do not hide those of another."""
    for key in document:
        if key not in KEYS:
            found.messages.append(str(fault("The study file, table", "must be a known one", key, nearest(key, KEYS))))
    for key in REQUIRED:
        if key not in document:
            found.messages.append(f"[{key}] must be given, but is missing.")

    def single(key: str, model: type[Model]) -> Model | None:
        return found.attempt(f"[{key}]", parsed, model, document[key]) if key in document else None

    study, structure = single("study", StudyTable), single("structure", StructureTable)
    damping, sweep = single("damping", DampingTable), single("sweep", SweepTable)
    contacts = tuple(found.attempt(place, contact_table, values) for place, values in repeated("contact", document, found))
    forces = tuple(found.attempt(place, parsed, ForceTable, values) for place, values in repeated("force", document, found))
    units = found.attempt("units", units_of, document.get("units", "SI")) or Units()
    bounds, samples = single("bounds", BoundsTable), single("samples", SamplesTable)
    return Tables(study, structure, damping, sweep, contacts, forces, units, bounds, samples)


def repeated(key: str, document: Mapping[str, Any], found: Found) -> list[tuple[str, Any]]:
    """The tables [[key]] with their places, numbered from 1."""
    values = document.get(key, [])
    if not isinstance(values, list):
        found.messages.append(f"[{key}] must be written with double brackets, [[{key}]], since there may be several.")
        return []
    return [(f"[[{key}]] {number}", value) for number, value in enumerate(values, start=1)]


def contact_table(values: Any) -> ContactTable:
    return parsed(table_of(values), values)


def units_of(value: Any) -> Units:
    """Units by the name of a system, or unit by unit."""
    if isinstance(value, str):
        if value not in SYSTEMS:
            raise fault("The system", "must be a known one", value, nearest(value, SYSTEMS))
        return SYSTEMS[value]
    return parsed(Units, value)


def from_rig(table: StructureTable, tables: Tables, document: Mapping[str, Any], found: Found) -> Problem | None:
    """A ready rig; it brings contacts, forces and damping itself."""
    for key in ("contact", "force", "damping", "units"):
        if key in document:
            found.messages.append(
                f"{key} must go with matrices, but stands beside a rig, which brings its own (in SI). Leave it out."
            )
    problem = found.attempt("[structure]", build.rig_named, table)
    if problem is None or tables.sweep is None or tables.sweep.outputs is None:
        return problem
    names = Names(problem.structure.dofs, Units())
    found.messages += names.faults({"sweep": document["sweep"]})
    return None if found.messages else replace(problem, outputs=build.outputs(tables.sweep, names))


def from_model(
    table: StructureTable, tables: Tables, document: Mapping[str, Any], folder: Path, found: Found, tell: Tell
) -> Problem | None:
    """A problem from a model, contacts and forces."""
    units, (progress, notes) = tables.units, tell
    damping = found.attempt("[damping]", build.damping_rule, tables.damping, units)
    made = found.attempt("[structure]", structure_of_table, table, damping, folder, units, progress)
    structure, said = made if made else (None, ())
    notes += said
    names = Names(table.dofs or (structure.dofs if structure else ()), units)
    found.messages += names.faults(document) if structure and not table.dofs else []
    contacts, forces = contacts_of(tables, names, found), forces_of(tables, names, found)
    if tables.sweep and tables.sweep.outputs is None:
        found.messages.append("[sweep]: outputs must be given, but is missing. Name degrees of freedom to report.")
    outputs = build.outputs(tables.sweep, names) if tables.sweep else ()
    if structure is None or found.messages:
        return None
    title = tables.study.title if tables.study else ""
    return found.attempt("The study", Problem, structure, contacts, forces, outputs, title)


def contacts_of(tables: Tables, names: Names, found: Found) -> tuple[Contact, ...]:
    numbered = [(number, table) for number, table in enumerate(tables.contact, start=1) if table is not None]
    made = [
        found.attempt(f"[[contact]] {number}", build.contact, table, number, names, tables.units) for number, table in numbered
    ]
    return tuple(contact for contact in made if contact is not None)


def forces_of(tables: Tables, names: Names, found: Found) -> tuple[Force, ...]:
    numbered = [(number, table) for number, table in enumerate(tables.force, start=1) if table is not None]
    made = [found.attempt(f"[[force]] {number}", build.force, table, names, tables.units) for number, table in numbered]
    return tuple(force for force in made if force is not None)
