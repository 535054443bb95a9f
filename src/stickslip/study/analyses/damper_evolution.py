"""Cycles of a damper while its friction changes, in a study: the table [damper_evolution]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from stickslip.analyses.damper_alone.cycles import EvolutionWork
from stickslip.runs.work import Arrays
from stickslip.study.analyses.damper_cycle import DamperTable, MotionTable, Steps, rig_and_motion, suitable
from stickslip.study.analysis import Asked, Kind, Plan
from stickslip.study.fields import NotNegatives
from stickslip.study.settings_table import table_of
from stickslip.study.units import in_si
from stickslip.support.checks import counted

if TYPE_CHECKING:
    import xarray as xr


EvolutionTable = table_of(
    EvolutionWork,
    "Friction as it changes from one set of cycles to the next.",
    friction=Annotated[list[NotNegatives], Field(min_length=1)],
    steps=Steps,
)


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


KIND = Kind(
    EvolutionPlan.of,
    {"damper": DamperTable, "motion": MotionTable, "damper_evolution": EvolutionTable},
    required=("damper", "motion", "damper_evolution"),
    checks={"damper": suitable},
    on_problem=False,
)
