"""Identification in a study: the tables [damper] and [identification], from measured loops to contact parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from stickslip.laboratory.identification.damper.model import parameters, usual_unknowns
from stickslip.laboratory.identification.damper.work import IdentificationWork
from stickslip.laboratory.measurement.cycles import CycleSet, read_load_removal, whole_cycles, zeroed
from stickslip.laboratory.measurement.reconstruction import RigErrors, damper_motion
from stickslip.laboratory.measurement.records import read_record
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.runs.work import Arrays
from stickslip.solve.platforms.relaxation import elements_of
from stickslip.study.analyses.damper_cycle import DamperTable, suitable
from stickslip.study.analysis import Asked, Kind, Plan
from stickslip.study.fields import FORCE, FREQUENCY, LENGTH, Number, Positive, Seed, Table, Units, in_si
from stickslip.support.checks import MOST, InputError, counted, fault, nearest
from stickslip.support.late import xr

LawName = Literal["macroslip", "iwan", "microslip"]
MACROSLIP: LawName = "macroslip"


class IdentificationTable(Table):
    """Which loops, what of the damper is unknown, and what the rig is worth."""

    loops: Annotated[list[str], Field(min_length=1, description="files of the measured loops (CSV), one a case")]
    unknown: Annotated[
        list[str] | None,
        Field(
            min_length=1,
            description="kt, kn, mu of all lines or of some (mu_L1, mu_R); tenfold, the factor by which mu changes at ten times "
            "the load; default: kt, kn and all mu, which then do not depend on the load",
        ),
    ] = None
    law: Annotated[list[LawName], Field(min_length=1)] = Field(default_factory=lambda: [MACROSLIP])
    """of the lines; of several the simplest that loops held out confirm"""
    frequency: Annotated[Positive | None, FREQUENCY, Field(description="of the motion; default: found in the loops")] = None
    harmonics: Annotated[int, Field(ge=8, le=200, description="to which every cycle is smoothed")] = 30
    pulls: Annotated[list[Positive] | None, FORCE, Field(description="centrifugal load of each loop, if they differ")] = None
    load_removal: Annotated[list[str] | None, Field(min_length=1)] = None
    """files of load removals (CSV) for the zeros of the cells, one for all loops or one each"""
    laser_distance: Annotated[Positive | None, LENGTH, Field(description="distance from laser 1 to laser 2 along x")] = None
    laser_offset: Annotated[Number, LENGTH, Field(description="offset of the mass centre from laser 1 along x")] = 0.0
    errors: Annotated[dict[str, Number], Field(description="of the rig, by the names of RigErrors")] = Field(default_factory=dict)
    resamples: Annotated[int, Field(ge=8, le=MOST, description="refits for the intervals")] = 24
    seed: Annotated[Seed, Field(description="of search and refits")] = 0

    def rig_errors(self) -> RigErrors:
        """The errors of the rig."""
        known = list(asdict(RigErrors()))
        for name in self.errors:
            if name not in known:
                raise fault("[identification] errors", "must be known ones", name, nearest(name, known))
        return RigErrors(**self.errors)

    def cases(self, folder: Path, units: Units) -> tuple[CycleSet, ...]:
        """The loops as cycles."""
        if self.pulls is not None and len(self.pulls) != len(self.loops):
            remedy = (
                "Write the pulls of these loops, in their order, into the study, or leave them out where [damper] pull holds."
            )
            raise fault("[identification] pulls", f"must have {len(self.loops)} entries, one a loop", len(self.pulls), remedy)
        found, si = [], in_si(self, units)
        for number, name in enumerate(self.loops):
            pull = None if self.pulls is None else si["pulls"][number]
            cycles = whole_cycles(read_record(folder / name), si["frequency"], self.harmonics, pull)
            if cycles.has("laser_1") and cycles.has("laser_2"):
                if self.laser_distance is None:
                    raise InputError("laser_distance must be given, since the loops hold laser_1 and laser_2, but is missing.")
                cycles = damper_motion(cycles, si["laser_distance"], si["laser_offset"])
            found.append(cycles)
        if self.load_removal is None:
            return tuple(found)
        removals = [read_load_removal(folder / name) for name in self.load_removal]
        return zeroed(found, removals, self.rig_errors().calibration)


@dataclass(frozen=True, eq=False)
class IdentificationPlan(Plan):
    """Loops and damper, read."""

    rig: BetweenPlatforms
    table: IdentificationTable
    folder: Path
    units: Units

    @classmethod
    def of(cls, asked: Asked) -> IdentificationPlan:
        """The plan of a study."""
        damper, table = asked.tables["damper"], asked.tables["identification"]
        if not isinstance(damper, DamperTable) or not isinstance(table, IdentificationTable):
            raise AssertionError("the tables of an identification")
        if damper.law != MACROSLIP:
            remedy = "The laws that are fitted stand in [identification] law."
            raise fault("[damper] law", "must be macroslip in an identification", damper.law, remedy)
        rig = damper.rig(asked.units)
        elements_of(rig), table.rig_errors(), parameters(table.unknown or usual_unknowns(rig), rig, {})
        return cls(rig, table, asked.folder, asked.units)

    def with_loops(self, loops: Sequence[Path], laws: Sequence[str] = (), removals: Sequence[Path] = ()) -> IdentificationPlan:
        """A copy for other files, which count from the working folder, and for other laws if named. Load removals belong to their
        loops: those of the study are dropped."""
        changes: dict[str, list[str] | None] = {"loops": [str(path.resolve()) for path in loops]}
        changes["load_removal"] = [str(path.resolve()) for path in removals] or None
        if laws:
            changes["law"] = list(laws)
        return replace(self, table=self.table.model_copy(update=changes))

    @property
    def unknown(self) -> tuple[str, ...]:
        """What is looked for."""
        return tuple(self.table.unknown or usual_unknowns(self.rig))

    @property
    def content(self) -> str:
        """Identifies the loops, as far as they exist."""
        files = [self.folder / name for name in (*self.table.loops, *(self.table.load_removal or ()))]
        return sha256(b"".join(file.read_bytes() for file in files if file.is_file())).hexdigest()

    @property
    def summary(self) -> str:
        laws = " or ".join(self.table.law)
        zeros = ", zeros by load removal" if self.table.load_removal else ""
        return f"{counted(len(self.table.loops), 'loop')}{zeros}, unknown {', '.join(self.unknown)}, {laws}"

    @cached_property
    def works(self) -> Mapping[str, IdentificationWork]:
        cases, errors = self.table.cases(self.folder, self.units), self.table.rig_errors()
        zeros = str([sorted(case.zero_errors.items()) for case in cases]) if self.table.load_removal else ""
        digest = sha256(b"".join(case.harmonics.tobytes() for case in cases) + zeros.encode()).hexdigest()[:12]
        work = IdentificationWork(
            cases,
            self.rig,
            unknown=self.unknown,
            errors=errors,
            resamples=self.table.resamples,
            seed=self.table.seed,
            name=f"identification {digest}",
            laws=tuple(self.table.law),
        )
        return {"": work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        work = self.works[""]
        return work.identification(results[""][0]).dataset


KIND = Kind(
    IdentificationPlan.of,
    {"damper": DamperTable, "identification": IdentificationTable},
    required=("damper", "identification"),
    checks={"damper": suitable},
    on_problem=False,
)
