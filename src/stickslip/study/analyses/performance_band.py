"""The band of a performance curve over the start states in a study: the table [performance_band]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.performance.curve import BandSettings, band_dataset
from stickslip.analyses.response_settings import ForcedResponseSettings
from stickslip.analyses.variability.bounds import refuse_discs
from stickslip.runs.work import Arrays, Work
from stickslip.study.analyses.performance_curve import Points, at_ratios, ordered, sweep_over_a_band
from stickslip.study.analysis import Asked, Kind, Plan, summary_of, taken_over
from stickslip.study.fields import FORCE, Positive, table_of
from stickslip.study.starts import RuleOrRules
from stickslip.study.tables import Ends
from stickslip.support.late import xr

BandTable = table_of(
    BandSettings,
    "The lowest and the highest resonance over all start states of the contacts, against F_C/F_E.",
    force_ratio=Ends,
    pull=Annotated[Positive | None, FORCE],
    rule=RuleOrRules,
    points=(Points, 6),
)


@dataclass(frozen=True, eq=False)
class BandPlan(Plan):
    """The band of a performance curve over the start states."""

    sweep: ForcedResponseSettings
    settings: Mapping[str, Any]

    @classmethod
    def of(cls, asked: Asked) -> BandPlan:
        """The plan of a study."""
        sweep = sweep_over_a_band(asked)
        refuse_discs(sweep.problem)
        return cls(sweep, at_ratios(asked.tables["performance_band"], asked.units) | {"band": sweep.band})

    @property
    def summary(self) -> str:
        low, *_, high = ratios = self.settings["force_ratio"]
        return f"{summary_of(self.sweep)}; band of the performance curve at {len(ratios)} F_C/F_E, {low:g} to {high:g}"

    @cached_property
    def work(self) -> BandSettings:
        return BandSettings(**taken_over(ForcedResponseWork.of(self.sweep)), **self.settings)

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.work.bounds}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return band_dataset(self.work, results[""])


KIND = Kind(
    BandPlan.of,
    {"performance_band": BandTable},
    required=("performance_band",),
    checks={"performance_band": ordered},
    without=("force_levels", "peak_tolerance"),
)
