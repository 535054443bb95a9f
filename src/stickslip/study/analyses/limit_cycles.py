"""Limit cycles in a study: [limit_cycles]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated

from pydantic import Field, Tag

from stickslip.analyses.modes.limit_cycles import LimitCyclesWork, checked_ratios
from stickslip.checks import counted
from stickslip.runs.work import Arrays, Work
from stickslip.study.analyses.nonlinear_modes import ModesPlan, ModesTable, checked
from stickslip.study.analysis import Asked, Kind, Plan
from stickslip.study.fields import by_form

if TYPE_CHECKING:
    import xarray as xr

DampingRatio = Annotated[float, Field(gt=-1.0, lt=1.0, allow_inf_nan=False)]


class LimitCyclesTable(ModesTable):
    """Vibration that gas forces feed and friction holds; forces of [[force]] do not act."""

    aerodynamic_damping: Annotated[
        Annotated[DampingRatio, Tag("<single>")] | Annotated[list[DampingRatio], Field(min_length=1), Tag("<list>")],
        by_form(),
        Field(description="damping ratio of the gas forces, negative where they feed the vibration, or a list"),
    ] = 0.0

    @property
    def ratios(self) -> tuple[float, ...]:
        """The aerodynamic damping ratios."""
        return checked_ratios(self.aerodynamic_damping)


def _checked(table: LimitCyclesTable) -> None:
    checked(table)
    _ = table.ratios


@dataclass(frozen=True, eq=False)
class LimitCyclesPlan(Plan):
    """The limit cycles of the modes of a problem."""

    modes: ModesPlan
    table: LimitCyclesTable

    @classmethod
    def of(cls, asked: Asked) -> LimitCyclesPlan:
        """The plan of a study."""
        table = LimitCyclesTable.model_validate(asked.tables.get("limit_cycles", {}))
        return cls(ModesPlan.of_table(asked, table), table)

    @property
    def summary(self) -> str:
        ratios = counted(len(self.table.ratios), "aerodynamic damping", "values of the aerodynamic damping")
        return f"{self.modes.summary}; limit cycles at {ratios}"

    @cached_property
    def work(self) -> LimitCyclesWork:
        return LimitCyclesWork(self.modes.work, self.table.ratios)

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return self.work.gathered(results[""]).dataset


KINDS = {
    "limit_cycles": Kind(LimitCyclesPlan.of, {"limit_cycles": LimitCyclesTable}, checks={"limit_cycles": _checked}, forced=False)
}
