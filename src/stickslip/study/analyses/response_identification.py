"""Identification from frequency responses in a study: the table [response_identification], files of curves and what is free."""

import inspect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.performance.work import with_factors, with_preload_factor
from stickslip.analyses.response_dataset import levels_are_newtons, newtons_a_level
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.laboratory.identification.least_squares import FreeParameter
from stickslip.laboratory.identification.response.work import ResponseIdentificationWork
from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.laboratory.measurement.response_table import read_measured_response, read_measured_responses
from stickslip.model.problem import Problem
from stickslip.model.rigs import RIGS
from stickslip.runs.cases import Arrays, Checkpoint, Progress, Work, Workers
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import LEVELS_AND_PEAKS, Asked, Kind, Plan, content_of
from stickslip.study.contacts import RuleOrRules
from stickslip.study.fields import Column, Number, Positive, Table, table_of, values_of
from stickslip.study.tables import Ends
from stickslip.support.checks import MOST, Index, counted, fault, nearest
from stickslip.support.late import xr

FACTORS = ("kt", "kn", "mu", "preload", "damping", "mass", "stiffness")
WITHOUT = {"kn": "A contact has kn where it has a normal direction and its law a stiffness kn; else leave it out."}
"""Remedies for factors on what no contact has."""

ColumnName = Literal["frequency", "amplitude", "real", "imaginary", "phase", "force"]
Three = Annotated[list[Number], Field(min_length=3, max_length=3)]


class CurvesTable(Table):
    """Measured curves, how they are read, and what is free."""

    files: Annotated[list[str], Field(min_length=1)]
    """curves (text, .mat, .unv): frequency, amplitude, force, phase if known"""
    by: Column | None = None
    """title or number of the column that distinguishes the curves of a file, such as "curve"; "function" for universal files"""
    quantity: Literal["displacement", "velocity", "acceleration"] | None = None
    """measured quantity; default: from the column titles of the files"""
    force: list[Positive] = Field(default_factory=list)
    """force of each curve, N, or one for all, if the files have no force column"""
    phase_of: Literal["displacement", "quantity"] | None = None
    """quantity whose phase the files contain; default: the displacement; for responses per force the measured one"""
    columns: Annotated[
        dict[ColumnName, Column],
        Field(
            description="titles or numbers (from 1) of columns that are not recognised; for universal files, amplitude and force "
            'by the name of the function, "12:+Z / 1:+X"'
        ),
    ] = Field(default_factory=dict)
    column_units: dict[ColumnName, str] = Field(default_factory=dict)
    """units of columns, such as mm/N or deg, where the files state none"""
    most_points: Annotated[int, Field(ge=3, le=MOST)] = 1000
    """largest number of points used of a curve, evenly thinned; each is solved many times"""
    output: Annotated[str | None, Field(description="name of the measured output; default: the first")] = None
    held: Literal["force", "response"] = "force"
    """which measured value is prescribed at each point; the other is computed"""
    rig: dict[str, Three] = Field(default_factory=dict)
    """[start, low, high] of arguments of the rig, SI; replaces the factors if the problem is a rig"""
    kt: Ends | None = None
    """[low, high] of a factor on kt of every contact; the fit starts at 1 if this lies between, otherwise midway"""
    kn: Annotated[Ends | None, Field(description="[low, high] of a factor on the normal stiffness")] = None
    mu: Annotated[Ends | None, Field(description="[low, high] of a factor on the friction coefficient")] = None
    preload: Annotated[Ends | None, Field(description="[low, high] of a factor on every static force and preload")] = None
    damping: Annotated[Ends | None, Field(description="[low, high] of a factor on the damping of the structure")] = None
    mass: Annotated[Ends | None, Field(description="[low, high] of a factor on the mass of the structure")] = None
    stiffness: Annotated[Ends | None, Field(description="[low, high] of a factor on the stiffness of the structure")] = None
    settings: list[dict[str, Number]] = Field(default_factory=list)
    """{ name = value } for each curve: arguments of the rig, or factors, that differ between the tests"""
    joints: list[str] = Field(default_factory=list)
    """joint of each curve, by a name: its curves are left out together; intervals include differences of joints"""
    each_test: list[str] = Field(default_factory=list)
    """parameters with a separate value in every test"""
    error: Annotated[Positive, Field(description="standard error of a measured response per force, relative")] = 0.01
    of_largest: bool = False
    """the error is relative to the largest response of a curve, not to the point"""
    free_gain: Annotated[bool, Field(description="a constant factor of each measured curve is identified too")] = False
    free_phase: Annotated[bool, Field(description="a constant phase of each measured curve is identified too")] = False

    def check(self) -> None:
        """Free parameters between bounds that hold them."""
        free_parameters(self)


ResponseIdentificationTable = table_of(
    ResponseIdentificationWork,
    "Measured curves, and the parameters that are fitted to them; points outside the band of [sweep] are not used.",
    CurvesTable,
    rule=RuleOrRules,
    start_deviation=Positive,
)


def free_parameters(table: CurvesTable) -> dict[str, FreeParameter]:
    """The free parameters by name, arguments of a rig or factors."""
    factors = {name: ends for name in FACTORS if (ends := getattr(table, name)) is not None}
    if not factors and not table.rig:
        raise fault("response_identification", f"must give bounds of {', '.join(FACTORS)}, or arguments of the rig", "none")
    if both := sorted({*factors} & {*table.rig}):
        raise fault(", ".join(both), "must be a factor or an argument of the rig", "both")
    for name in table.each_test:
        if name not in {**factors, **table.rig}:
            raise fault("each_test", f"must name some of {', '.join({**factors, **table.rig})}", name)
    if {*table.each_test} == {*factors, *table.rig}:
        raise fault("each_test", "must leave out one that all tests have in common", table.each_test)
    for name, (low, high) in factors.items():
        if low >= high:
            raise fault(name, "must be [low, high], the lower end first", [low, high])
    for name, (start, low, high) in table.rig.items():
        if not low <= start <= high or low == high:
            raise fault(name, "must be [start, low, high] with the start between the others", [start, low, high])
    if table.settings and table.by is None and len(table.settings) != len(table.files):
        raise fault("settings", f"must be one for each of {counted(len(table.files), 'file')}", len(table.settings))
    found = {name: (start_between(1.0, low, high), low, high) for name, (low, high) in factors.items()}
    found |= {name: (start, low, high) for name, (start, low, high) in table.rig.items()}
    own = table.each_test
    return {name: FreeParameter(start, low, high, name in own) for name, (start, low, high) in found.items()}


def start_between(present: float, low: float, high: float) -> float:
    """Where a search between bounds starts: at the present value, or in the middle where the bounds do not hold that."""
    if low < present < high:
        return present
    return float(np.sqrt(low * high)) if low > 0.0 else 0.5 * (low + high)


def own_values(problem: Problem, name: str) -> tuple[tuple[float, ...], str]:
    """Least and largest value that a factor multiplies, over the contacts of the problem, and its unit; none of what is no
    parameter of a contact."""
    if name not in FACTORS[:3]:
        return (), ""
    contacts = [one for one in problem.contacts if name != "kn" or one.normal is not None]
    found = [np.ravel(value) for one in contacts if (value := getattr(one.law, name, None)) is not None]
    ends = (float(min(map(np.min, found))), float(max(map(np.max, found)))) if found else ()
    return ends, "" if name == "mu" else "N/m"


def measured_curves(table: CurvesTable, folder: Path, **about: Any) -> list[MeasuredResponse]:
    """The curves of all files, one each, or those that the column `by` distinguishes; about: other arguments of them all."""
    how = about_columns(table)
    if table.by is None:
        each = zip(table.files, names_of(table.files), how, strict=True)
        return [read_measured_response(folder / file, name=name, **about, **own) for file, name, own in each]
    named = list(zip(table.files, names_of(table.files), strict=True))
    by = table.by

    def read(**level: Any) -> list[MeasuredResponse]:
        each = [read_measured_responses(folder / file, by, name=name, **about, **how[0], **level) for file, name in named]
        return [curve for curves in each for curve in curves]

    sets = [read(force=level) for level in table.force] or [read()]
    count = len(sets[0])
    for key, given in (("force", len(sets) if len(sets) > 1 else count), ("settings", len(table.settings) or count)):
        if given != count:
            raise fault(f"[{TABLE}]: {key}", f"must be one for each of {counted(count, 'curve')}", given)
    return sets[0] if len(sets) == 1 else [own[k] for k, own in enumerate(sets)]


def about_columns(table: CurvesTable) -> list[dict[str, Any]]:
    """How each file is read: arguments of `read_measured_response`; force levels of the curves of one file aside."""
    about: dict[str, Any] = {"quantity": table.quantity, "phase_of": table.phase_of}
    about |= {"columns": {str(key): which for key, which in table.columns.items()}}
    about |= {"units": {str(key): unit for key, unit in table.column_units.items()}}
    if table.by is not None:
        return [about]
    if table.force and len(table.force) not in (1, len(table.files)):
        raise fault(f"[{TABLE}]: force", f"must be one, or one for each of {counted(len(table.files), 'file')}", table.force)
    levels = table.force if len(table.force) == len(table.files) else table.force * len(table.files)
    return [about | {"force": level} for level in levels] if levels else [dict(about) for _ in table.files]


def names_of(files: Sequence[str]) -> list[str]:
    """A name for each curve, the file's without ending; where two are the same, with its folder, then numbered."""
    stems = [Path(file).stem for file in files]
    whole = [f"{Path(file).parent.name}/{stem}" for stem, file in zip(stems, files, strict=True)]
    given = [one if stems.count(one) == 1 or whole.count(more) > 1 else more for one, more in zip(stems, whole, strict=True)]
    return [one if given.count(one) == 1 else f"{one} ({given[: k + 1].count(one)})" for k, one in enumerate(given)]


@dataclass(frozen=True, eq=False)
class Adapted:
    """A problem with factors on its contacts, preloads and structure, or the rig of other arguments."""

    problem: Problem
    rig: str
    arguments: Mapping[str, Any]
    of_rig: frozenset[str]

    def __call__(self, **values: float) -> Problem:
        own = {name: value for name, value in values.items() if name in self.of_rig}
        factors = {name: value for name, value in values.items() if name not in own}
        problem = RIGS[self.rig](**{**self.arguments, **own}) if own else self.problem
        on_contacts = {name: factors[name] for name in FACTORS[:3] if name in factors}
        problem = problem.with_contacts(lambda contact: with_factors(contact, on_contacts))
        if "preload" in factors:
            problem = with_preload_factor(problem, factors["preload"])
        return _with_structure(problem, factors)


def _with_structure(problem: Problem, factors: Mapping[str, float]) -> Problem:
    """A copy with mass, stiffness and damping matrices times factors."""
    damping, mass, stiffness = (factors.get(name, 1.0) for name in FACTORS[4:])
    if damping == mass == stiffness == 1.0:
        return problem
    structure = problem.structure
    C = damping * problem.C if not problem.dashpots else damping * replace(problem, dashpots=()).C
    return problem.with_structure(replace(structure, M=mass * structure.M, K=stiffness * structure.K, C=C, damping=None))


def known_settings(key: str, names: Iterable[str], table: CurvesTable, rig: str) -> None:
    """Settings of a key name arguments of the rig or factors, none of which is free."""
    free = free_parameters(table)
    named = (*(inspect.signature(RIGS[rig]).parameters if rig else ()), *FACTORS)
    known = [name for name in dict.fromkeys(named) if name not in free]
    for name in dict.fromkeys(names):
        if name in free:
            raise fault(f"{key}: settings", "must not name what is free", name)
        if name not in known:
            raise fault(f"{key}: settings", f"must name some of {', '.join(known)}", name, nearest(name, known))


def _at_points(test: MeasuredResponse, points: Index) -> MeasuredResponse:
    frequency, amplitude, force = (np.asarray(one)[points] for one in (test.frequency, test.amplitude, test.force))
    phase = None if test.phase is None else np.asarray(test.phase)[points]
    return replace(test, frequency=frequency, amplitude=amplitude, force=force, phase=phase)


def with_levels_in_newtons(problem: Problem) -> tuple[Problem, str]:
    """The problem whose force level is what files state, the amplitude of the force in N, with what to say of it."""
    newtons = newtons_a_level(problem)
    if newtons is None:
        return (
            problem,
            "The excitation is not a single given force along one degree of freedom: measured forces are taken as force levels.",
        )
    if levels_are_newtons(problem):
        return problem, ""
    scaled = [
        force
        if not any(force.amplitudes.values())
        else replace(force, amplitude={h: a / newtons for h, a in force.factors.items()})
        for force in problem.forces
    ]
    said = f"Measured forces are the amplitude of the force in N, whatever its amplitude in the study ({newtons:g} N)."
    return problem.with_forces(scaled), said


@dataclass(frozen=True, eq=False)
class ResponseIdentificationPlan(Plan):
    """Curves, and what is fitted to them."""

    sweep: ForcedResponseSettings
    table: CurvesTable
    folder: Path
    rig: tuple[str, Mapping[str, Any]]
    remark: str = ""

    @classmethod
    def of(cls, asked: Asked) -> "ResponseIdentificationPlan":
        """The plan of a study."""
        sweep, table = sweep_of(asked), asked.tables[TABLE]
        assert isinstance(table, CurvesTable)
        names = list(sweep.problem.output_names)
        known_settings(f"[{TABLE}]", (name for one in table.settings for name in one), table, asked.rig[0])
        about_columns(table)
        for name in FACTORS[:3]:
            if getattr(table, name) is not None and not own_values(sweep.problem, name)[0]:
                laws = ", ".join(dict.fromkeys(type(contact.law).__name__ for contact in sweep.problem.contacts)) or "no contact"
                raise fault(f"[{TABLE}]: {name}", "must be a parameter of a contact of the problem", laws, WITHOUT.get(name, ""))
        if table.output is not None and table.output not in names:
            raise fault(f"[{TABLE}]: output", f"must be one of {', '.join(names)}", table.output)
        if table.rig and not asked.rig[0]:
            raise fault(f"[{TABLE}]: rig", "must go with a ready problem, rig in [structure]", list(table.rig))
        if sweep.harmonics == "auto":
            raise fault("[sweep]: harmonics", "must be a number or a list for an identification", "auto")
        problem, remark = with_levels_in_newtons(sweep.problem)
        return cls(replace(sweep, problem=problem), table, asked.folder, asked.rig, remark)

    @property
    def content(self) -> str:
        """Identifies the curves, as far as they exist."""
        return content_of(self.folder / name for name in self.table.files)

    @property
    def summary(self) -> str:
        what = "measured curve" if self.table.by is None else "file"
        return f"{counted(len(self.table.files), what)}, free: {', '.join(free_parameters(self.table))}"

    def tests(self) -> list[MeasuredResponse]:
        """The curves, each with its settings."""
        table, names = self.table, list(self.sweep.problem.output_names)
        about: dict[str, Any] = {
            name: getattr(table, name) for name in ("held", "error", "of_largest", "free_gain", "free_phase")
        }
        about["output"] = 0 if table.output is None else names.index(table.output)
        tests = measured_curves(table, self.folder, **about)
        own, joints = table.settings or [{} for _ in tests], table.joints or [""] * len(tests)
        if len(joints) != len(tests):
            raise fault(f"[{TABLE}]: joints", f"must be one for each of {counted(len(tests), 'curve')}", len(joints))
        each = zip(tests, own, joints, strict=True)
        return [replace(test, settings=settings, joint=joint) for test, settings, joint in each]

    def _inside(self, test: MeasuredResponse) -> MeasuredResponse:
        """A test at its points in the band."""
        found = self.sweep.frequencies
        frequency = np.asarray(test.frequency)
        inside = np.flatnonzero((frequency >= min(found)) & (frequency <= max(found)))
        if inside.size < 3:
            what = f"Points of {test.name} in the band of [sweep], {min(found):.6g} to {max(found):.6g} Hz,"
            raise fault(what, "must be at least three", inside.size, "Is the unit of the frequency right?")
        return _at_points(test, inside)

    def _thinned(self, test: MeasuredResponse) -> MeasuredResponse:
        """A test at `most_points` points at most, every so many; its notes say so."""
        count = np.size(test.frequency)
        every = -(-count // self.table.most_points)
        if every == 1:
            return test
        thinned = _at_points(test, np.arange(0, count, every))
        words = f"{np.size(thinned.frequency)} of {count} points of {test.name} are used, one in {every}: most_points says other."
        return replace(thinned, notes=(*test.notes, words))

    @cached_property
    def band(self) -> list[MeasuredResponse]:
        """The curves at their points in the band."""
        return [self._inside(test) for test in self.tests()]

    def problem_of(self, *settings: str) -> Adapted:
        """The problem of parameters and of settings, those of the curves and further ones."""
        arguments = set(inspect.signature(RIGS[self.rig[0]]).parameters) if self.rig[0] else set()
        of_rig = {*self.table.rig} | (arguments & {*settings, *(name for one in self.table.settings for name in one)})
        return Adapted(self.sweep.problem, *self.rig, frozenset(of_rig))

    @cached_property
    def work(self) -> ResponseIdentificationWork:
        table, base = self.table, ForcedResponseWork.of(self.sweep)
        return ResponseIdentificationWork(
            self.problem_of(),
            free_parameters(table),
            [self._thinned(test) for test in self.band],
            **values_of(ResponseIdentificationWork, table),
            harmonics=base.harmonics,
            samples=base.samples,
        )

    @property
    def about(self) -> dict[str, Any]:
        """What is to be said of the curves and of the parameters that are factors."""
        count, kept = (sum(np.size(test.frequency) for test in some) for some in (self.tests(), self.band))
        left = [f"{count - kept} of {count} points lie outside the band of [sweep] and are not used."] if kept < count else []
        named = [name for name in free_parameters(self.table) if name in FACTORS and name not in self.table.rig]
        factors = {name: own_values(self.sweep.problem, name) for name in named}
        return {"remarks": [*filter(None, [self.remark]), *left], "factors": factors}

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> "xr.Dataset":
        return self.work.gathered(results[""], **self.about).dataset

    def searched(
        self, results: Mapping[str, Sequence[Arrays]], checkpoint: Checkpoint, workers: Workers, progress: Progress
    ) -> "xr.Dataset":
        """The result, with the tests left out one by one."""
        return self.work.finished(results[""], checkpoint, workers, progress, **self.about).dataset


TABLE = "response_identification"
KIND = Kind(ResponseIdentificationPlan.of, {TABLE: ResponseIdentificationTable}, without=LEVELS_AND_PEAKS)
"""Files are read when the work begins."""
