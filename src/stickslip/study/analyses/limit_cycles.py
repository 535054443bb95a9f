"""Limit cycles in a study: [limit_cycles]."""

from typing import Annotated

from pydantic import Field, Tag

from stickslip.analyses.modes.nonlinear_modes import LimitCyclesWork
from stickslip.study.analyses.nonlinear_modes import FORMS, modes_settings, modes_summary
from stickslip.study.analysis import LEVELS_AND_PEAKS, Asked, Kind, Works
from stickslip.study.fields import by_form, table_of
from stickslip.support.checks import counted

DampingRatio = Annotated[float, Field(gt=-1.0, lt=1.0, allow_inf_nan=False)]


TABLE = "limit_cycles"
LimitCyclesTable = table_of(
    LimitCyclesWork,
    "Vibration that aerodynamic forces excite and friction limits; the forces of [[force]] do not act.",
    checked=True,
    aerodynamic_damping=Annotated[
        Annotated[DampingRatio, Tag("<single>")] | Annotated[list[DampingRatio], Field(min_length=1), Tag("<list>")], by_form()
    ],
    **FORMS,
)


def plan(asked: Asked) -> Works:
    """The limit cycles of the modes of a problem."""
    work = LimitCyclesWork(**modes_settings(asked, asked.tables.get(TABLE, LimitCyclesTable())))
    work.refuse_amplitudes()
    ratios = counted(len(work.ratios), "aerodynamic damping", "values of the aerodynamic damping")
    return Works(work, f"{modes_summary(work)}; limit cycles at {ratios}", on_mesh=work.with_shapes)


KIND = Kind(plan, {TABLE: LimitCyclesTable}, optional=(TABLE,), without=LEVELS_AND_PEAKS, from_mesh=True)
