"""Several damper cycles in a study: the tables [steady_cycles] and [damper_evolution]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from stickslip.analyses.damper_alone.cycles import EvolutionWork, SteadyCyclesWork
from stickslip.model.dampers import BetweenPlatforms, PlatformMotion
from stickslip.runs.work import Arrays
from stickslip.study.analyses.damper_cycle import DamperTable, MotionTable, suitable
from stickslip.study.analysis import Asked, Kind, Plan
from stickslip.study.fields import NotNegatives, Positive
from stickslip.study.settings_table import table_of
from stickslip.study.units import LENGTH, in_si
from stickslip.support.checks import counted

if TYPE_CHECKING:
    import xarray as xr


Steps = Annotated[int, Field(ge=8, le=1000000)]
SliderStartsTable = table_of(
    SteadyCyclesWork,
    "Initial states: the virgin sliders and random offsets.",
    spread=Annotated[Positive | None, LENGTH],
    same=Positive,
    steps=Steps,
)
EvolutionTable = table_of(
    EvolutionWork,
    "Friction as it changes from one set of cycles to the next.",
    friction=Annotated[list[NotNegatives], Field(min_length=1)],
    steps=Steps,
)


@dataclass(frozen=True, eq=False)
class SteadyCyclesPlan(Plan):
    """Every steady cycle that the initial states lead to."""

    work: SteadyCyclesWork

    @classmethod
    def of(cls, asked: Asked) -> SteadyCyclesPlan:
        """The plan of a study."""
        settings = in_si(asked.tables.get("steady_cycles") or SliderStartsTable(), asked.units)
        return cls(SteadyCyclesWork(*rig_and_motion(asked), starts=settings.pop("count"), **settings))

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
        return cls(EvolutionWork(*rig_and_motion(asked), **in_si(asked.tables["damper_evolution"], asked.units)))

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
