"""Steady cycles of a damper from many initial states in a study: the table [steady_cycles]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from stickslip.analyses.damper_alone.cycles import SteadyCyclesWork
from stickslip.runs.work import Arrays
from stickslip.study.analyses.damper_cycle import DamperTable, MotionTable, Steps, rig_and_motion, suitable
from stickslip.study.analysis import Asked, Kind, Plan
from stickslip.study.fields import Positive
from stickslip.study.settings_table import table_of
from stickslip.study.units import LENGTH, in_si
from stickslip.support.checks import counted

if TYPE_CHECKING:
    import xarray as xr


SliderStartsTable = table_of(
    SteadyCyclesWork,
    "Initial states: the virgin sliders and random offsets.",
    spread=Annotated[Positive | None, LENGTH],
    same=Positive,
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


KIND = Kind(
    SteadyCyclesPlan.of,
    {"damper": DamperTable, "motion": MotionTable, "steady_cycles": SliderStartsTable},
    required=("damper", "motion"),
    checks={"damper": suitable},
    on_problem=False,
)
