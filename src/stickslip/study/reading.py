"""Entry point: `read` turns a study file into a `Job`, or raises all its faults at once."""

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from hashlib import sha256
from pathlib import Path
from typing import Any

from stickslip.analyses.forced_response import AUTOMATIC
from stickslip.analyses.settings import ForcedResponseSettings, Frequencies
from stickslip.analyses.static_load import as_lines, by_surface
from stickslip.model.contact.point import Contact
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.problem.at_rest import rest_variables
from stickslip.model.problem.load_steps import load_history
from stickslip.model.problem.meshed import meshed_problem
from stickslip.model.problem.systems import REACH
from stickslip.model.readers.reduction import Progress, quiet
from stickslip.model.structure.cyclic import NEXT, CyclicStructure
from stickslip.model.structure.matrices import ModalDamping, SparseStructure
from stickslip.results.schema import sentence_in
from stickslip.solve.balance.fourier import harmonics_for, highest
from stickslip.study import build
from stickslip.study.analyses.speed_sweep import straight_notes
from stickslip.study.analysis import KINDS, Asked, Kind, Plan, StudyTable, all_keys, keys_of, owners
from stickslip.study.build import Names, dofs_in
from stickslip.study.contacts import ContactTable, SurfaceTable, table_of
from stickslip.study.faults import Found, Made, Model, parsed
from stickslip.study.fields import SYSTEMS, Table, Units, check_of, values_of
from stickslip.study.further_curves import NO_STRESS, resting_fatigue
from stickslip.study.plausibility import check_static_loads, other_speed, plausibility_warnings
from stickslip.study.structure import (
    AerodynamicsTable,
    Messages,
    Parts,
    Whole,
    bodies_of,
    rotation_note,
    structures_of,
    together,
    with_aerodynamics,
)
from stickslip.study.surfaces import contacts_on, force_on, meshed_surfaces, surfaces_in, turning_notes
from stickslip.study.tables import (
    BaseTable,
    BodyTable,
    DampingTable,
    DashpotTable,
    ExcitationTable,
    FinenessTable,
    ForceTable,
    LoadStepTable,
    MeanSpringTable,
    OverSpeedTable,
    RotationTable,
    StructureTable,
    SweepTable,
)
from stickslip.study.toml_text import with_line
from stickslip.support.checks import Faults, InputError, fault, nearest, similar_file, storable
from stickslip.support.machine import one_blas_thread
from stickslip.support.units import UNIT_SYSTEMS, Band, UnitSystem

Stated = tuple[Problem, Mapping[float, CyclicStructure]]
"""A problem, and its disks by rotor speed where it is a sector whose speed is given."""

LARGEST = 1 << 24
"""Bytes of the largest study file."""

WITH_STRESS = ("forced_response", "mistuned_population")
"""Analyses that compute the stress at places of models."""
WITH_LOAD_STEPS = ("forced_response", "stepped_sine", "controlled_response")
"""Analyses that begin with the sliders where steps of the static load have left them."""
DEFAULT = "forced_response"
"""By what a file is checked when its analysis is unknown."""


@dataclass(frozen=True, eq=False)
class Job:
    """What a study asks for, made ready.

    `text` is the file as it stands; `content` identifies what the files that it names hold, "" where it names none.
    `sweep` holds the problem of an analysis of one; `remarks` on the model, such as where its places were found;
    `units` those of the file, in which results are shown.
    """

    title: str
    analysis: str
    plan: Plan
    text: str
    content: str = ""
    sweep: ForcedResponseSettings | None = None
    remarks: tuple[str, ...] = ()
    units: UnitSystem = UNIT_SYSTEMS["SI"]

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """The remarks, and warnings of what is implausible, which solve linear responses."""
        if self.sweep is None:
            return self.remarks
        forced = "force_levels" not in KINDS[self.analysis].without
        with one_blas_thread():
            own = (sentence_in(warning, self.units) for warning in self.sweep.problem.warnings)
            return (*self.remarks, *own, *plausibility_warnings(self.sweep, self.units, forced))


@dataclass(frozen=True)
class Tables:
    """The tables of a file; None where one is absent or faulty."""

    study: StudyTable | None
    structures: tuple[StructureTable | None, ...]
    bodies: tuple[BodyTable | None, ...]
    damping: DampingTable | None
    sweep: Any
    contact: tuple[ContactTable | None, ...]
    force: tuple[ForceTable | None, ...]
    dashpot: tuple[DashpotTable | None, ...]
    mean_spring: tuple[MeanSpringTable | None, ...]
    excitation: ExcitationTable | None
    base: BaseTable | None
    aerodynamics: AerodynamicsTable | None
    units: Units
    own: Mapping[str, Table]
    rotation: RotationTable | None = None
    load_steps: tuple[LoadStepTable | None, ...] = ()

    @property
    def over_speed(self) -> OverSpeedTable | None:
        """The table of an analysis over the rotor speed."""
        return next((table for table in self.own.values() if isinstance(table, OverSpeedTable)), None)

    @property
    def rig(self) -> StructureTable | None:
        """The table that asks for a ready problem."""
        (only,) = self.structures if len(self.structures) == 1 else (None,)
        return only if only is not None and only.rig is not None else None


def read(path: Path, progress: Progress = quiet, whole_disk: bool = False) -> Job:
    """The study at `path`, checked as a whole; whole_disk: as of `job`. Raises `Faults` with every fault of the file."""
    text = text_of(path)
    try:
        return job(text, path.parent, path.stem, progress, whole_disk)
    except Faults as error:
        document = toml(text)
        raise Faults([with_line(message, text, document) for message in error.faults]) from None


def read_problem(path: str | Path, *, whole_disk: bool = False) -> Problem:
    """The problem of a study file, to go on with in Python.

    With the results of a run it makes a response again, to check in time, to interpolate, to recover stress from:
    `ss.ForcedResponse(ss.open_results("results/wedge/results.nc"), ss.read_problem("wedge.toml"))`.

    whole_disk: reduce a sector of [structure.sector] for all nodal diameters, which `TunedDisk.full` and mistuning need, not only
    for those that the engine orders of the study can excite.

    Raises `InputError` with every fault of the file, and for a study that is not of a problem (a damper alone, measured loops).
    """
    found = read(Path(path), whole_disk=whole_disk)
    if found.sweep is None:
        raise fault("The analysis of the study", "must be of a problem, with a [sweep]", found.analysis)
    return found.sweep.problem


def job(text: str, folder: Path, name: str, progress: Progress = quiet, whole_disk: bool = False) -> Job:
    """What a study asks for; paths in it count from `folder`, and `name` stands in for a missing title.

    progress(share, text) is called while a large model is read and reduced. whole_disk: reduce a sector for all nodal diameters,
    not only those that the engine orders of the study can excite.
    """
    document, notes = toml(text), list[str]()
    kind = kind_of(document)
    found = Found()
    tables = tables_of(document, kind, found)
    if tables.study:
        found.attempt("[study]", storable, "title", tables.study.title)
    misplaced(tables, document, kind, found)
    for key, table in tables.own.items():
        found.attempt(f"[{key}]", table.check)
    sweep, stated = None, None
    if kind.on_problem:
        where = frequencies_of(tables, kind, found)
        with one_blas_thread():
            modes_to = reached(tables, where) if kind.from_mesh else None
            stated = problem_of(tables, document, folder, found, (progress, notes), whole_disk or kind.whole_disk, modes_to)
            sweep = sweep_of(tables, where, stated[0] if stated else None, found)
    if sweep and stated and stated[1] and tables.excitation is not None:
        notes += other_speed(sweep, next(iter(stated[1])), build.lowest_order(tables.excitation))
    if sweep and tables.over_speed is None:  # over the speed, static loads are those of each speed
        found.attempt("", check_static_loads, sweep.problem, notes)
    found.stop()
    disks = stated[1] if stated else {}
    asked = Asked(tables.own, sweep, tables.units, folder, rig_of(tables.rig), disks, document)
    plan = found.attempt("", kind.plan, asked)
    found.stop()
    notes += [*resting_fatigue(asked), *straight_notes(asked)]
    if tables.study is None or plan is None:
        raise AssertionError("a study without faults has all its parts")
    title = tables.study.title or (sweep.problem.heading if sweep else "") or name
    named = content(tables, sweep) or plan.content
    return Job(title, tables.study.analysis, plan, text, named, sweep, tuple(notes), tables.units.system)


def rig_of(table: StructureTable | None) -> tuple[str, Mapping[str, Any]]:
    """The name of the ready problem that a file asks for, and its parameters."""
    return (table.rig or "", table.parameters) if table else ("", {})


def kind_of(document: Mapping[str, Any]) -> Kind:
    """The analysis that a file asks for."""
    study = document.get("study")
    name = study.get("analysis") if isinstance(study, dict) else None
    return KINDS[name if isinstance(name, str) and name in KINDS else DEFAULT]


def frequencies_of(tables: Tables, kind: Kind, found: Found) -> Frequencies | None:
    """Where to compute, with what the table [sweep] says wrongly whatever the problem is."""
    table = tables.sweep
    if table is None:
        return None
    where = None
    if kind.band is None:
        where = found.attempt("[sweep]", build.frequencies, table, tables.units, kind.repeats)
    elif not found.messages:
        where = kind.band(tables.own)
    settings = values_of(ForcedResponseSettings, table)
    found.attempt("[sweep]", check_of(ForcedResponseSettings), table)
    found.attempt("[sweep]", build.enough_samples, settings["harmonics"], settings["samples"])
    found.attempt("[sweep]", without_effect, table, kind)
    if kind.check_of_sweep is not None:
        found.attempt("[sweep]", kind.check_of_sweep, table)
    return where


def sweep_of(tables: Tables, where: Frequencies | None, problem: Problem | None, found: Found) -> ForcedResponseSettings | None:
    """The problem, and where and how finely to compute it."""
    if tables.sweep is None or problem is None or where is None:
        return None
    settings = values_of(ForcedResponseSettings, tables.sweep)
    if settings["harmonics"] != "auto":
        found.attempt("[sweep]", harmonics_for, problem, settings["harmonics"])
    return None if found.messages else ForcedResponseSettings(problem, where, **settings)


def without_effect(table: Table, kind: Kind) -> None:
    """A setting that an analysis does not use is refused, unless it says what holds anyway."""
    usual = {key: field.get_default(call_default_factory=True) for key, field in type(table).model_fields.items()}
    faults = [
        str(fault(key, "must be left out, since it has no effect on this analysis", value))
        for key in kind.without
        if (value := getattr(table, key)) != usual[key]
    ]
    if faults:
        raise Faults(faults)


def misplaced(tables: Tables, document: Mapping[str, Any], kind: Kind, found: Found) -> None:
    """A table of another analysis than the one asked for is refused: it would have no effect."""
    if tables.study is None:
        return
    for key in document:
        names = () if key in keys_of(kind) else owners(key)
        if names and tables.study.analysis not in names:
            rule = f"needs analysis = {' or '.join(map(repr, names))}".replace("'", '"')
            found.messages.append(f"[{key}] {rule}, but the analysis is {tables.study.analysis!r}.")


def content(tables: Tables, sweep: ForcedResponseSettings | None) -> str:
    """Identifies the matrices that a study brings; a rig makes its own."""
    if sweep is None or tables.rig is not None:
        return ""
    structure, digest = sweep.problem.structure, sha256()
    for matrix in (structure.M, structure.K, structure.C):
        digest.update(b"" if matrix is None else matrix.tobytes())
    return digest.hexdigest()


def problem_of(
    tables: Tables,
    document: Mapping[str, Any],
    folder: Path,
    found: Found,
    messages: Messages,
    whole_disk: bool,
    modes_to: float | None = None,
) -> Stated | None:
    """The problem of the [structure] table: a rig, or a model. modes_to: as of `from_model`."""
    dofs = dofs_in(document)
    found.messages += Names(dofs, Units()).faults(document) if dofs else []
    if not tables.structures or None in tables.structures or None in tables.bodies:
        return None
    if tables.rig is not None:
        problem = from_rig(tables.rig, tables, document, found, messages[1])
        return None if problem is None else (problem, {})
    return from_model(tables, document, folder, found, messages, whole_disk, modes_to)


def text_of(path: Path) -> str:
    """The text of a study file."""
    if path.is_dir():
        raise fault("The study", "must be a file", str(path), "It is a folder.")
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
        if len(content) > LARGEST:
            raise fault("The study file", f"must have at most {LARGEST // 2**20} MiB", str(path), "Is it a study?")
        return content.decode("utf-8-sig")
    except FileNotFoundError:
        remedy = similar_file(path) or "`stickslip new forced_response` writes one."
        raise fault("The study file", "must exist", str(path), remedy) from None
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
    except ValueError:  # of int, which takes 4300 digits
        raise InputError(
            "The study file must hold numbers of a usual size, but has a whole number of thousands of digits."
        ) from None
    except RecursionError:
        raise InputError("The study file must be valid TOML, but nests its values too deeply.") from None


def tables_of(document: Mapping[str, Any], kind: Kind, found: Found) -> Tables:
    """Every table on its own, so that the faults of one do not hide those of another."""
    for key in document:
        if key not in keys_of(kind) and key not in (known := all_keys()):
            found.messages.append(str(fault("The study file, table", "must be a known one", key, nearest(key, known))))
    for key in (
        "study",
        *(("structure", "sweep") if kind.on_problem else ()),
        *(key for key in kind.tables if key not in kind.optional),
    ):
        if key not in document:
            found.messages.append(f"[{key}] must be given, but is missing.")

    def single(key: str, model: type[Model]) -> Model | None:
        if isinstance(document.get(key), list):
            found.messages.append(f"[[{key}]] must be written with single brackets, [{key}], since there is one only.")
            return None
        return found.attempt(f"[{key}]", parsed, model, document[key]) if key in document else None

    study = single("study", StudyTable)
    several = isinstance(document.get("structure"), list)
    places = repeated("structure", document, found) if several else []
    structures = tuple(found.attempt(place, parsed, StructureTable, values) for place, values in places)
    if not several and "structure" in document:
        structures = (single("structure", StructureTable),)
    bodies = tuple(found.attempt(place, parsed, BodyTable, values) for place, values in repeated("body", document, found))
    damping, sweep = single("damping", DampingTable), single("sweep", SweepTable if kind.band is None else FinenessTable)
    contacts = tuple(found.attempt(place, contact_table, values) for place, values in repeated("contact", document, found))
    forces = tuple(found.attempt(place, parsed, ForceTable, values) for place, values in repeated("force", document, found))
    dashpots = tuple(found.attempt(place, parsed, DashpotTable, values) for place, values in repeated("dashpot", document, found))
    springs = repeated("mean_spring", document, found)
    mean_springs = tuple(found.attempt(place, parsed, MeanSpringTable, values) for place, values in springs)
    units = found.attempt("units", units_of, document.get("units", "SI")) or Units()
    own = {key: table for key, model in kind.tables.items() if (table := single(key, model)) is not None}
    base, aerodynamics = single("base", BaseTable), single("aerodynamics", AerodynamicsTable)
    actions = contacts, forces, dashpots, mean_springs, single("excitation", ExcitationTable)
    rotation = single("rotation", RotationTable)
    steps = tuple(found.attempt(place, parsed, LoadStepTable, values) for place, values in repeated("load_step", document, found))
    return Tables(study, structures, bodies, damping, sweep, *actions, base, aerodynamics, units, own, rotation, steps)


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


def from_rig(
    table: StructureTable, tables: Tables, document: Mapping[str, Any], found: Found, notes: list[str]
) -> Problem | None:
    """A ready rig; it brings contacts, forces and damping itself."""
    own_units = isinstance(document.get("units"), dict) and set(document["units"]) == {"frequency"}
    for key in ("body", "rotation", "contact", "force", "dashpot", "mean_spring", "base", "damping", "units"):
        if key in document and not (key == "units" and own_units):
            found.messages.append(
                f"{key} must go with matrices, but stands beside a rig, which brings its own (in SI). Leave it out."
            )
    problem = found.attempt("[structure]", build.rig_named, table)
    problem = acted_upon(problem, tables, found, notes)
    if problem is None or tables.sweep is None or tables.sweep.outputs is None:
        return problem
    names = Names(problem.structure.dofs, Units())
    found.messages += names.faults({"sweep": document["sweep"]})
    return None if found.messages else replace(problem, outputs=build.outputs(tables.sweep, names))


def acted_upon(problem: Problem | None, tables: Tables, found: Found, notes: list[str]) -> Problem | None:
    """A disk under its engine orders and gas forces, over the speed under the first of its orders; sliders where the loads before
    have left them."""
    if tables.over_speed is not None and isinstance(problem, TunedDisk):
        problem = problem.with_engine_order(tables.over_speed.engine_orders[0] % problem.sectors)
    if problem is not None and tables.excitation is not None:
        problem = found.attempt("[excitation]", build.excited, problem, tables.excitation)
    if problem is not None and tables.aerodynamics is not None:
        problem = found.attempt("[aerodynamics]", with_aerodynamics, problem, tables.aerodynamics, tables.units)
    if problem is not None and tables.load_steps and not found.messages:
        problem = found.attempt("[[load_step]]", _after_steps, problem, tables, notes)
    return problem


def _after_steps(problem: Problem, tables: Tables, notes: list[str]) -> Problem:
    """The problem after its steps of the static load, with notes on its contacts at rest after each."""
    if tables.study is not None and tables.study.analysis not in WITH_LOAD_STEPS:
        rule = f"need analysis = {' or '.join(WITH_LOAD_STEPS)}, but the analysis is {tables.study.analysis}"
        raise InputError(f"Load steps {rule}. Remove [[load_step]].")
    given = [each for each in tables.load_steps if each is not None]
    pulls = [build.pull_on(body, axis) for body in dict.fromkeys(body for each in given for body in each.pull) for axis in "xyz"]
    more = [pull for pull in pulls if pull.name not in [force.name for force in problem.forces]]
    steps = [build.load_step(each, tables.rotation, problem, tables.units) for each in given]
    moved, found = load_history(problem.with_forces([*problem.forces, *more]), steps)
    rests = {f"step {number}": rest_variables(*each) for number, each in enumerate(found[:-1], start=1)}
    records = [{"load": load} | each for load, rest in rests.items() for each in by_surface(rest, tables.units.system)]
    notes += [
        "Contacts at rest after each step; the values after the normal load are those of single contacts:",
        *as_lines(records),
    ]
    return moved.with_forces(problem.forces)


def from_model(
    tables: Tables,
    document: Mapping[str, Any],
    folder: Path,
    found: Found,
    messages: Messages,
    whole_disk: bool,
    modes_to: float | None = None,
) -> Stated | None:
    """A problem from models, bodies, contacts and forces; whole_disk: of a sector with all nodal diameters. modes_to: natural
    frequency [Hz] up to which a large model with many contacts has its modes; None where its rows are kept for any frequency."""
    units = tables.units
    _check_disk(tables, document, found)
    asks_for_stress = any(table is not None and table.stress is not None for table in tables.structures)
    if asks_for_stress and tables.study is not None and tables.study.analysis not in WITH_STRESS:
        rule = f"needs analysis = {' or '.join(WITH_STRESS)}, but the analysis is {tables.study.analysis!r}"
        remedy = "Leave it out." if tables.over_speed is None else "Compute a forced response at the speed of a peak for it."
        found.messages.append(f"[structure]: stress {rule}. {remedy}")
    if "fatigue" in tables.own and not asks_for_stress and "stress" not in tables.own:
        found.messages.append(NO_STRESS)
    damping = found.attempt("[damping]", build.damping_rule, tables.damping, units)
    if _is_disk(tables):
        _check_outputs(tables, found)
        found.stop()  # the reduction of a sector may take minutes
    several, surfaces = isinstance(document["structure"], list), surfaces_in(tables.contact, tables.force)
    order = None if whole_disk or tables.aerodynamics or not tables.excitation else build.lowest_order(tables.excitation)
    on_stuck = not (isinstance(damping, ModalDamping) and damping.on == "free")
    meshed = meshed_surfaces(tables.contact) if modes_to is not None and tables.base is None and on_stuck else ()
    rotation = found.attempt("[rotation]", build.rotation, tables.rotation, tables.over_speed, units) if tables.rotation else None
    whole_of = Whole(damping, order, rotation)
    structures = structures_of(tables.structures, several, surfaces, whole_of, folder, units, found, messages, meshed)
    bodies, pulls = bodies_of(tables.bodies, structures, units, found, rotation, messages[1])
    whole = len(structures) == len(tables.structures) and len(bodies) == len(tables.bodies)
    parts = found.attempt("[structure]", together, structures, bodies, damping, rotation) if whole else None
    if parts and rotation:
        messages[1].append(rotation_note(rotation, parts.loads, units.system))
    only = tables.structures[0] if len(tables.structures) == 1 else None
    known = tuple(only.dofs) if only is not None and only.dofs and not tables.bodies else ()  # where the study gives them all
    if parts and not known:
        following = [f"{NEXT}{dof}" for dof in parts.structure.dofs] if isinstance(parts.structure, CyclicStructure) else []
        names = Names((*parts.structure.dofs, *following), units)
    else:
        names = Names(known, units)
    found.messages += names.faults(document) if parts and not known else []
    contacts = contacts_of(tables, names, parts, found, messages[1])
    forces = *forces_of(tables, names, parts, found), *pulls
    dashpots = made_of("dashpot", build.dashpot, tables.dashpot, names, units, found=found)
    forces += parts.loads if parts else ()
    if not _is_disk(tables):
        _check_outputs(tables, found)
    messages[1].extend(turning_notes(contacts, bodies))
    outputs = build.outputs(tables.sweep, names) if tables.sweep else ()
    if parts is None or found.messages:
        return None
    title = tables.study.title if tables.study else ""
    springs = made_of("mean_spring", build.mean_spring, tables.mean_spring, names, units, found=found)
    more: dict[str, Any] = {"mean_springs": springs, "dashpots": dashpots}
    kind: Callable[..., Problem] = TunedDisk if isinstance(parts.structure, CyclicStructure) else Problem
    if isinstance(parts.structure, SparseStructure):
        kind, more = meshed_problem, more | {"modes_to": modes_to, "report": partial(messages[0], 0.5)}
    problem = found.attempt("The study", partial(kind, **more), parts.structure, contacts, forces, outputs, title)
    problem = acted_upon(problem, tables, found, messages[1])
    return None if problem is None else (problem, parts.disks)


def reached(tables: Tables, where: Frequencies | None) -> float | None:
    """Natural frequency up to which modes count where a study is solved, Hz; None where it does not say so."""
    if where is None or tables.sweep is None:
        return None
    harmonics = tables.sweep.harmonics
    return (
        REACH
        * (AUTOMATIC if isinstance(harmonics, str) else highest(harmonics))
        * (where.high if isinstance(where, Band) else max(where))
    )


def _is_disk(tables: Tables) -> bool:
    """Whether a model is a sector of a disk."""
    return any(table is not None and table.sector is not None for table in tables.structures)


def _check_outputs(tables: Tables, found: Found) -> None:
    if tables.sweep and tables.sweep.outputs is None:
        found.messages.append("[sweep]: outputs must be given, but is missing. Name degrees of freedom to report.")


def _check_disk(tables: Tables, document: Mapping[str, Any], found: Found) -> None:
    """What a sector needs, and what needs a sector."""
    sector = next((table.sector for table in tables.structures if table is not None and table.sector is not None), None)
    if sector is None:
        for key in ("aerodynamics", "excitation"):
            if key in document:
                found.messages.append(
                    f'[{key}] needs a bladed disk: a model with [structure.sector] or a rig such as "lumped_blisk". Remove it, '
                    "or describe the sector."
                )
        return
    over = tables.over_speed
    if sector.at_speeds and over is None:
        found.messages.append(
            "[structure]: sector: at_speeds needs an analysis over the speed, such as speed_sweep. Remove it: [structure] model "
            "is the model at the speed of this study."
        )
    if over is None and "excitation" not in document:
        found.messages.append("[excitation] must be given for a bladed disk, but is missing. Write engine_order = EO.")
    if tables.excitation is not None:
        found.attempt("[excitation]", build.check_orders, tables.excitation, sector.sectors)
    if over is not None:
        if "excitation" in document:
            words = "must be left out: an analysis over the speed takes its engine orders from"
            found.messages.append(f"[excitation] {words} [{over.key}].")
        found.attempt("", build.check_speeds, over, sector.speed)
    for key in ("dashpot", "base"):
        if key in document:
            found.messages.append(f"{key} cannot be used with a sector of a bladed disk. Remove it.")


def contacts_of(tables: Tables, names: Names, parts: Parts | None, found: Found, notes: list[str]) -> tuple[Contact, ...]:
    """The contacts; those of surfaces follow once the structure is there."""
    contacts: list[Contact] = []
    for number, table in enumerate(tables.contact, start=1):
        if isinstance(table, SurfaceTable) and table.surface is not None:
            made = found.attempt(f"[[contact]] {number}", contacts_on, table, number, parts, tables.units) if parts else None
            contacts += made[0] if made else ()
            notes += made[1] if made else []
        elif table is not None:
            one = found.attempt(f"[[contact]] {number}", build.contact, table, number, names, tables.units)
            contacts += [one] if one else []
    return tuple(contacts)


def forces_of(tables: Tables, names: Names, parts: Parts | None, found: Found) -> tuple[Force, ...]:
    """The forces; those on surfaces follow once the structure is there."""
    made: list[Force | None] = []
    for number, table in enumerate(tables.force, start=1):
        place = f"[[force]] {number}"
        if table is not None and table.surface is not None:
            made.append(found.attempt(place, force_on, table, parts, tables.units) if parts else None)
        elif table is not None:
            made.append(found.attempt(place, build.force, table, names, tables.units))
    made.append(found.attempt("[base]", build.base, tables.base, names, tables.units) if tables.base else None)
    return tuple(force for force in made if force is not None)


def made_of(key: str, make: Callable[..., Made], entries: Sequence[Any], *known: Any, found: Found) -> tuple[Made, ...]:
    """What the sound ones among the tables [[key]] make."""
    numbered = [(number, table) for number, table in enumerate(entries, start=1) if table is not None]
    made = [found.attempt(f"[[{key}]] {number}", make, table, *known) for number, table in numbered]
    return tuple(each for each in made if each is not None)
