"""Several damper cycles in a study: the tables [steady_cycles] and [damper_evolution]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from stickslip.analyses.damper_alone.cycles import EvolutionWork, SteadyCyclesWork
from stickslip.checks import MOST, counted
from stickslip.dampers import BetweenPlatforms, PlatformMotion
from stickslip.runs.work import Arrays
from stickslip.study.analyses.damper_cycle import DamperTable, MotionTable, suitable
from stickslip.study.analysis import Asked, Kind, Plan
from stickslip.study.fields import NotNegatives, Positive, Seed, Table
from stickslip.study.units import LENGTH, in_si

if TYPE_CHECKING:
    import xarray as xr


class SliderStartsTable(Table):
    """Initial states: the virgin sliders and random offsets."""

    count: Annotated[int, Field(ge=1, le=MOST, description="of initial states")] = 20
    spread: Annotated[
        Positive | None, LENGTH, Field(description="largest slider offset; twice the pull over the softest kt unless given")
    ] = None
    seed: Annotated[Seed, Field(description="of the random draws")] = 0
    same: Annotated[Positive, Field(description="difference of forces, relative to the largest, below which cycles are one")] = (
        1e-6
    )
    steps: Annotated[int, Field(ge=8, le=1000000, description="of a cycle")] = 1000


class EvolutionTable(Table):
    """Friction as it changes from one set of cycles to the next."""

    friction: Annotated[
        list[NotNegatives],
        Field(min_length=1, description="sets of coefficients: a number each, or one for each line of contact"),
    ]
    cycles: Annotated[int, Field(ge=1, le=MOST, description="with each set; the last is kept")] = 1
    steps: Annotated[int, Field(ge=8, le=1000000, description="of a cycle")] = 1000


@dataclass(frozen=True, eq=False)
class SteadyCyclesPlan(Plan):
    """Every steady cycle that the initial states lead to."""

    work: SteadyCyclesWork

    @classmethod
    def of(cls, asked: Asked) -> SteadyCyclesPlan:
        """The plan of a study."""
        table = asked.tables.get("steady_cycles") or SliderStartsTable()
        assert isinstance(table, SliderStartsTable)
        spread = in_si(table, asked.units)["spread"]
        rig, motion = rig_and_motion(asked)
        return cls(
            SteadyCyclesWork(rig, motion, starts=table.count, spread=spread, seed=table.seed, same=table.same, steps=table.steps)
        )

    @property
    def content(self) -> str:
        """Identifies a measured motion."""
        return self.work.motion.digest

    @property
    def summary(self) -> str:
        return f"{self.work.rig.title}, {counted(self.work.starts, 'initial state')}, {self.work.steps} steps a cycle"

    @property
    def works(self) -> Mapping[str, SteadyCyclesWork]:
        return {"": self.work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return self.work.gathered(results[""]).dataset


@dataclass(frozen=True, eq=False)
class EvolutionPlan(Plan):
    """A sequence of cycles while friction changes."""

    work: EvolutionWork

    @classmethod
    def of(cls, asked: Asked) -> EvolutionPlan:
        """The plan of a study."""
        table = asked.tables["damper_evolution"]
        assert isinstance(table, EvolutionTable)
        rig, motion = rig_and_motion(asked)
        return cls(EvolutionWork(rig, motion, friction=tuple(table.friction), steps=table.steps, cycles=table.cycles))

    @property
    def content(self) -> str:
        """Identifies a measured motion."""
        return self.work.motion.digest

    @property
    def summary(self) -> str:
        sets = counted(len(self.work.friction), "set")
        return f"{self.work.rig.title}, {sets} of friction coefficients, {counted(self.work.cycles, 'cycle')} each"

    @property
    def works(self) -> Mapping[str, EvolutionWork]:
        return {"": self.work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return self.work.gathered(results[""][0]).dataset


def rig_and_motion(asked: Asked) -> tuple[BetweenPlatforms, PlatformMotion]:
    """The damper and what drives it."""
    damper, motion = asked.tables["damper"], asked.tables["motion"]
    assert isinstance(damper, DamperTable)
    assert isinstance(motion, MotionTable)
    return damper.rig(asked.units), motion.motion(asked.units, asked.folder)


KINDS = {
    "steady_cycles": Kind(
        SteadyCyclesPlan.of,
        {"damper": DamperTable, "motion": MotionTable, "steady_cycles": SliderStartsTable},
        required=("damper", "motion"),
        checks={"damper": suitable},
        on_problem=False,
    ),
    "damper_evolution": Kind(
        EvolutionPlan.of,
        {"damper": DamperTable, "motion": MotionTable, "damper_evolution": EvolutionTable},
        required=("damper", "motion", "damper_evolution"),
        checks={"damper": suitable},
        on_problem=False,
    ),
}
