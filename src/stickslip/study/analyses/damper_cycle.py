"""Damper cycle in a study: the tables [damper], [motion] and [cycle]."""

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from stickslip.analyses.damper_alone.cycle import CycleWork
from stickslip.laboratory.measurement.cycles import read_motion
from stickslip.model.dampers import BetweenPlatforms, ElasticPlatform, PlatformMotion, elliptic
from stickslip.model.dampers.between_platforms import LAWS, suitable_gaps
from stickslip.solve.time.period import GeneralisedAlpha, Newmark
from stickslip.study.analysis import Asked, Kind, Works
from stickslip.study.build import shape_of
from stickslip.study.contacts import Frictions, friction_in_si
from stickslip.study.fields import (
    FORCE,
    FREQUENCY,
    LENGTH,
    STIFFNESS,
    NotNegative,
    Number,
    Positive,
    Positives,
    Table,
    Units,
    in_si,
)
from stickslip.study.tables import ShapeKey
from stickslip.support.checks import MOST, counted, fault

Steps = Annotated[int, Field(ge=8, le=1000000)]


class DamperTable(Table):
    """The damper between its platforms. A list has one entry per line of contact: L1, L2, ... upwards, then the right ones."""

    shape: Annotated[ShapeKey, Field(description="of the damper")]
    dimensions: dict[str, Any] = Field(default_factory=dict)
    """arguments of the shape; lengths in units of the study, angles in degrees; defaults by shape"""
    left_angle: Annotated[NotNegative, Field(lt=90, description="slope of the left platform in degrees")] = 45.0
    right_angle: Annotated[NotNegative, Field(lt=90, description="slope of the right platform in degrees")] = 45.0
    pull: Annotated[Positive, FORCE, Field(description="centrifugal force")]
    kt: Annotated[Positives, STIFFNESS, Field(description="tangential stiffness, of each line or by line")]
    kn: Annotated[Positives, STIFFNESS, Field(description="normal stiffness, of each line or by line")]
    mu: Frictions
    """friction coefficient of all lines, or by line; a table gives it over the load of one line"""
    law: Annotated[Literal[LAWS], Field(description="of all contact lines")] = "macroslip"  # type: ignore[valid-type]
    gaps: NotNegative = 0.0
    """of microslip: g; the gaps of five elements reach 2 g N/kn, N the pull over the lines"""
    platform_stiffness: Annotated[Positive | None, STIFFNESS] = None
    """stiffness of the rig under the right platform, in x and y; default: rigid"""

    def check(self) -> None:
        """Gaps of a law that has some."""
        suitable_gaps(self.law, self.gaps)

    def rig(self, units: Units) -> BetweenPlatforms:
        """The damper between its platforms, in SI."""
        values = in_si(self, units)
        shape = shape_of(self.shape, self.dimensions, units, left_angle=self.left_angle, right_angle=self.right_angle)
        k = values["platform_stiffness"]
        right = None if k is None else ElasticPlatform([[k, 0.0], [0.0, k]])
        damper = shape.damper(pull=values["pull"])
        title = f"{self.shape.replace('_', ' ').capitalize()} damper, {values['pull']:g} N"
        columns = (values["kt"], values["kn"], friction_in_si(values["mu"], units))
        return BetweenPlatforms.of_law(self.law, damper, *columns, self.gaps, right, title)


class MotionTable(Table):
    """Motion of the left platform: x = horizontal sin ωt, y = vertical sin(ωt + phase), or as measured."""

    horizontal: Annotated[Number, LENGTH, Field(description="amplitude out of phase: the gap opens and closes")] = 0.0
    vertical: Annotated[Number, LENGTH, Field(description="amplitude in phase: the platforms pass each other")] = 0.0
    phase: Annotated[Number, Field(description="of the vertical motion before the horizontal one, in degrees")] = 0.0
    file: str | None = None
    """table (CSV) of one period instead: time, platform_x, platform_y, with units in the header"""
    harmonics: Annotated[int, Field(ge=1, le=200, description="to which a measured motion is smoothed")] = 30
    frequency: Annotated[Positive | None, FREQUENCY] = None
    """of a table that holds several periods, of which the mean is taken"""

    def motion(self, units: Units, folder: Path) -> PlatformMotion:
        """The motion in SI; `file` counts from `folder`."""
        values = in_si(self, units)
        given, of_file = self.model_fields_set, {"file", "harmonics", "frequency"}
        if self.file is None:
            if given & of_file:
                keys = sorted(given & of_file)
                remedy = f"{' and '.join(keys)} {'needs' if len(keys) == 1 else 'need'} it."
                raise fault("[motion] file", "must be given", "missing", remedy)
            return elliptic(values["horizontal"], values["vertical"], self.phase)
        if given - of_file:
            raise fault("[motion] file", "must stand alone", sorted(given - of_file), "A measured motion has its own directions.")
        return read_motion(folder / self.file, self.harmonics, values["frequency"])


class CycleTable(Table):
    """How to compute the cycle."""

    together: ClassVar[tuple[tuple[str, str], ...]] = (("method", "frequency"),)

    steps: Annotated[Steps, Field(description="steps per cycle")] = 1000
    tolerance: Annotated[Positive, Field(description="change of the forces from cycle to cycle, relative to the largest")] = 1e-9
    cycles: Annotated[int, Field(ge=1, le=MOST, description="the most")] = 100
    method: Literal["generalised_alpha", "newmark"] | None = None
    """time integration with inertia; default: quasi-static"""
    frequency: Annotated[Positive | None, FREQUENCY, Field(description="of the motion in time")] = None


def rig_and_motion(asked: Asked) -> tuple[BetweenPlatforms, PlatformMotion]:
    """The damper and what drives it."""
    damper, motion = asked.tables["damper"], asked.tables["motion"]
    assert isinstance(damper, DamperTable)
    assert isinstance(motion, MotionTable)
    return damper.rig(asked.units), motion.motion(asked.units, asked.folder)


def plan(asked: Asked) -> Works:
    """One steady cycle."""
    cycle = CycleTable.model_validate(asked.tables.get("cycle") or CycleTable())
    rig, motion = rig_and_motion(asked)
    motion.samples(cycle.steps)
    work = CycleWork(
        rig,
        motion,
        steps=cycle.steps,
        method={"generalised_alpha": GeneralisedAlpha(), "newmark": Newmark(), None: None}[cycle.method],
        frequency=in_si(cycle, asked.units)["frequency"],
        tolerance=cycle.tolerance,
        cycles=cycle.cycles,
    )
    summary = f"{rig.title}, {counted(len(rig.points), 'line')} of contact, {cycle.steps} steps a cycle"
    return Works(work, summary, lambda work, arrays: work.gathered(arrays[0]).dataset, motion.digest)


KIND = Kind(plan, {"damper": DamperTable, "motion": MotionTable, "cycle": CycleTable}, optional=("cycle",), on_problem=False)
