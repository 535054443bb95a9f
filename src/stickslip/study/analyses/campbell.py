"""Campbell diagram in a study: the table [campbell], and the interference diagram of a disk at its operating speed."""

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from stickslip.analyses.speed.campbell import CampbellWork
from stickslip.analyses.speed.models import Models, with_waves
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analyses.nonlinear_modes import FORMS
from stickslip.study.analyses.speed_sweep import band_of, problem_over_speed, reference_of, stiffness_at_rest
from stickslip.study.analysis import LEVELS_AND_PEAKS, Asked, Kind, Works
from stickslip.study.fields import NotNegative, Positive, Table, in_si, table_of
from stickslip.study.tables import OverSpeedTable
from stickslip.support.checks import counted, fault, unique
from stickslip.support.units import Band

TABLE = "campbell"


class RangeTable(OverSpeedTable):
    """Engine orders EO excite with ω = EO Ω; stiffness and static forces go with the square of the rotor speed Ω."""

    key = TABLE

    speed: Annotated[list[NotNegative], Field(min_length=2, max_length=2, description="[lowest, highest] rotor speed, rev/min")]

    def check(self) -> None:
        """The lowest speed first, and each engine order once."""
        if not self.speed[0] < self.speed[1]:
            raise fault("speed", "must be [lowest, highest] in rev/min, the lowest first", self.speed)
        unique("engine_orders", self.engine_orders)


CampbellTable = table_of(
    CampbellWork,
    "Natural frequencies over the rotor speed, crossings with engine orders, and margins to the operating speed.",
    RangeTable,
    **FORMS,
    force_level=Positive | None,
    operating_speed=Positive | None,
)


def band(tables: Mapping[str, Table]) -> Band | None:
    """The frequencies of the excitation; from rest on those from the second speed of the curves."""
    table: Any = tables.get(TABLE)
    if table is None:
        return None
    low, high = table.speed
    return band_of(table.engine_orders, low if low > np.finfo(float).eps * high else high / (table.points - 1), high)


def plan(asked: Asked) -> Works:
    """The curves over the speed."""
    table: Any = asked.tables[TABLE]
    sweep, values = sweep_of(asked), in_si(table, asked.units)
    if sweep.harmonics == "auto":
        raise fault("[sweep]: harmonics", "must be a number or a list for a Campbell diagram", "auto")
    models, condition = _models(asked, table)
    names = ("engine_orders", "mode", "force_level", "operating_speed", "points", "amplitude")
    how: dict[str, Any] = {"harmonics": sweep.harmonics, "samples": sweep.problem.systems.enough_samples(sweep.samples)}
    work = CampbellWork(models, tuple(table.speed), **{name: values[name] for name in names}, **how)
    work.prepare()
    size = counted(sweep.problem.freedoms, "degree of freedom", "degrees of freedom")
    modes, orders = counted(len(work.modes), "mode"), counted(len(table.engine_orders), "engine order")
    summary = f"{size}; {modes} and {orders} from {work.speed[0]:g} to {work.speed[1]:g} rev/min"
    summary += "" if table.force_level is None else f", with friction at force level {table.force_level:g}"
    return Works(work, summary, content=sweep.problem.fingerprint, condition=condition)


def _models(asked: Asked, table: Any) -> tuple[Models, str]:
    """The problem by rotor speed, and when the structure is as it is given."""
    sweep, reference = sweep_of(asked), reference_of(asked, table)
    coriolis = sweep.problem.structure.coriolis
    problem = sweep.problem.with_structure(replace(sweep.problem.structure, coriolis=None))
    loaded = any(force.static for force in problem.forces)
    if reference is None and table.stiffness_at_rest is None and not (loaded and table.force_level is not None):
        return {0.0: problem, table.speed[1]: problem}, ""
    slow = fast = problem
    if reference is None or loaded or stiffness_at_rest(asked, table, problem, reference) is not None:
        along, reference = problem_over_speed(replace(asked, sweep=replace(sweep, problem=problem)), table)
        if len(asked.disks) > 1:
            at = {speed: along.at_speed(2.0 * pi * speed / 60.0) for speed in asked.disks}
            own = {speed: with_waves(problem, np.asarray(asked.disks[speed].stiffnesses)) for speed, problem in at.items()}
            return own, f"at {reference:g} rev/min"
        slow, fast = along.at_speed(0.0), along.at_speed(2.0 * pi * reference / 60.0)
    if coriolis is not None:
        fast = fast.with_structure(replace(fast.structure, coriolis=coriolis))
    return {0.0: slow, reference: fast}, f"at {reference:g} rev/min"


KIND = Kind(plan, {TABLE: CampbellTable}, band=band, without=LEVELS_AND_PEAKS)
