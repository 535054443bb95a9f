"""Run-up and run-down in a study: the table [run_up], the motion in time while the rotor speed changes."""

from typing import Any

from stickslip.analyses.speed.speed_sweep import RunUpWork
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analyses.speed_sweep import band, problem_over_speed
from stickslip.study.analysis import PEAKS, Asked, Kind, Works
from stickslip.study.fields import Positive, table_of
from stickslip.study.tables import OverSpeedTable
from stickslip.support.checks import counted

TABLE = "run_up"


class RunTable(OverSpeedTable):
    """Engine orders EO excite with ω = EO Ω; stiffness and static forces go with the square of the rotor speed Ω."""

    key = TABLE


RunUpTable = table_of(
    RunUpWork, "The motion in time while the rotor speed changes at a constant rate, up or down.", RunTable, duration=Positive
)


def plan(asked: Asked) -> Works:
    """A run for each engine order and force level."""
    table: Any = asked.tables[TABLE]
    problem, reference = problem_over_speed(asked, table)
    first, last = table.speed
    how = {name: getattr(table, name) for name in ("duration", "steps_per_period", "start_periods")}
    work = RunUpWork(problem, (first, last), engine_orders=table.engine_orders, force=sweep_of(asked).levels, **how)
    size = counted(problem.freedoms, "degree of freedom", "degrees of freedom")
    runs = counted(len(work.places), "run")
    summary = (
        f"{size}, {counted(len(problem.contacts), 'contact')}; {runs} from {first:g} to {last:g} rev/min in {work.duration:g} s"
    )
    return Works(work, summary, content=problem.fingerprint, condition=f"at {reference:g} rev/min")


KIND = Kind(plan, {TABLE: RunUpTable}, band=band, without=("harmonics", "samples", *PEAKS))
