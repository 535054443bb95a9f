"""Bounds of the response over all start states in a study: the table [response_bounds]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.analyses.variability.bounds import BoundsWork, attached, refuse_discs
from stickslip.runs.work import Arrays, Work
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Plan, summary_of, taken_over
from stickslip.study.contacts import RuleOrRules
from stickslip.study.fields import check_of, in_si, table_of
from stickslip.support.late import xr

BoundsTable = table_of(
    BoundsWork, "Highest and lowest response over the start states of the contacts, beside the response itself.", rule=RuleOrRules
)


@dataclass(frozen=True, eq=False)
class BoundsPlan(Plan):
    """The forced response and its bounds."""

    sweep: ForcedResponseSettings
    settings: Mapping[str, Any]

    @classmethod
    def of(cls, asked: Asked) -> BoundsPlan:
        """The plan of a study; every key of its table has a default."""
        sweep = sweep_of(asked)
        refuse_discs(sweep.problem)
        return cls(sweep, in_si(asked.tables.get("response_bounds", BoundsTable()), asked.units))

    @property
    def summary(self) -> str:
        return summary_of(self.sweep)

    @cached_property
    def base(self) -> ForcedResponseWork:
        return ForcedResponseWork.of(replace(self.sweep, isolated=False))

    @cached_property
    def bounds(self) -> BoundsWork:
        return BoundsWork(**taken_over(self.base), band=self.sweep.band, force=self.base.levels, **self.settings)

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.base, "bounds": self.bounds}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return attached(self.base.gathered(results[""]).dataset, self.bounds.gathered(results["bounds"]))


KIND = Kind(BoundsPlan.of, {"response_bounds": BoundsTable}, checks={"response_bounds": check_of(BoundsWork)})
