"""Limit cycles in a study: [limit_cycles]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field, Tag

from stickslip.analyses.modes.limit_cycles import LimitCyclesWork
from stickslip.runs.work import Arrays, Work
from stickslip.study.analyses.nonlinear_modes import FORMS, modes_settings, modes_summary
from stickslip.study.analysis import Asked, Kind, Plan
from stickslip.study.fields import by_form
from stickslip.study.settings_table import check_of, table_of
from stickslip.support.checks import counted

if TYPE_CHECKING:
    import xarray as xr

DampingRatio = Annotated[float, Field(gt=-1.0, lt=1.0, allow_inf_nan=False)]


TABLE = "limit_cycles"
LimitCyclesTable = table_of(
    LimitCyclesWork,
    "Vibration that aerodynamic forces excite and friction limits; the forces of [[force]] do not act.",
    aerodynamic_damping=Annotated[
        Annotated[DampingRatio, Tag("<single>")] | Annotated[list[DampingRatio], Field(min_length=1), Tag("<list>")], by_form()
    ],
    **FORMS,
)


@dataclass(frozen=True, eq=False)
class LimitCyclesPlan(Plan):
    """The limit cycles of the modes of a problem."""

    work: LimitCyclesWork

    @classmethod
    def of(cls, asked: Asked) -> LimitCyclesPlan:
        """The plan of a study."""
        work = LimitCyclesWork(**modes_settings(asked, asked.tables.get(TABLE, LimitCyclesTable())))
        work.refuse_amplitudes()
        return cls(work)

    @property
    def summary(self) -> str:
        ratios = counted(len(self.work.ratios), "aerodynamic damping", "values of the aerodynamic damping")
        return f"{modes_summary(self.work)}; limit cycles at {ratios}"

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return self.work.gathered(results[""]).dataset


KIND = Kind(
    LimitCyclesPlan.of,
    {TABLE: LimitCyclesTable},
    checks={TABLE: check_of(LimitCyclesWork)},
    without=("force_levels", "tolerance", "peak_tolerance", "quantity", "measure"),
)
