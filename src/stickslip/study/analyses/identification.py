"""Identification in a study: the tables [damper] and [identification], from measured loops to contact parameters."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from stickslip.laboratory.identification.damper.fit import parameters, usual_unknowns
from stickslip.laboratory.identification.damper.work import IdentificationWork
from stickslip.laboratory.measurement.cycles import CycleSet, read_load_removal, whole_cycles, zeroed
from stickslip.laboratory.measurement.reconstruction import RigErrors, damper_motion
from stickslip.laboratory.measurement.records import read_record
from stickslip.solve.platforms.relaxation import elements_of
from stickslip.study.analyses.damper_cycle import DamperTable
from stickslip.study.analysis import Asked, Kind, Works, content_of
from stickslip.study.fields import FORCE, FREQUENCY, LENGTH, Number, Positive, Seed, Table, Units, errors_of, in_si
from stickslip.support.checks import MOST, InputError, counted, fault

LawName = Literal["macroslip", "iwan", "microslip"]
MACROSLIP: LawName = "macroslip"


class IdentificationTable(Table):
    """Which loops, what of the damper is unknown, and what the rig is worth."""

    loops: Annotated[list[str], Field(min_length=1, description="files of the measured loops (CSV), one a case")]
    unknown: Annotated[
        list[str] | None,
        Field(
            min_length=1,
            description="parameters to find: kt, kn, mu of all lines or of some (mu_L1, mu_R); tenfold, the factor of mu at ten "
            "times the load; default: kt, kn and all mu, independent of the load",
        ),
    ] = None
    law: Annotated[list[LawName], Field(min_length=1)] = Field(default_factory=lambda: [MACROSLIP])
    """of the lines; of several the simplest that loops held out confirm"""
    frequency: Annotated[Positive | None, FREQUENCY, Field(description="frequency of motion; default: found in the loops")] = None
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
        return errors_of(RigErrors, self.errors, "identification")

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


def plan(asked: Asked) -> Works:
    """Loops and damper; the loops are read when the work begins."""
    damper, table = asked.tables["damper"], asked.tables["identification"]
    assert isinstance(damper, DamperTable)
    assert isinstance(table, IdentificationTable)
    if damper.law != MACROSLIP:
        remedy = "The laws that are fitted stand in [identification] law."
        raise fault("[damper] law", "must be macroslip in an identification", damper.law, remedy)
    rig, errors, removals = damper.rig(asked.units), table.rig_errors(), table.load_removal or []
    unknown = tuple(table.unknown or usual_unknowns(rig))
    elements_of(rig), parameters(unknown, rig, {})

    def work() -> IdentificationWork:
        cases, resamples = table.cases(asked.folder, asked.units), table.resamples
        return IdentificationWork(cases, rig, unknown, law=table.law, errors=errors, resamples=resamples, seed=table.seed)

    zeroed_by = ", zeros by load removal" if removals else ""
    summary = f"{counted(len(table.loops), 'loop')}{zeroed_by}, unknown {', '.join(unknown)}, {' or '.join(table.law)}"
    content = content_of([asked.folder / name for name in (*table.loops, *removals)])
    return Works(work, summary, lambda work, arrays: work.identification(arrays[0]).dataset, content)


KIND = Kind(plan, {"damper": DamperTable, "identification": IdentificationTable}, on_problem=False)
