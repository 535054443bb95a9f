"""The period of motion of one point of a forced response, for its animation."""

from __future__ import annotations

import numpy as np

from stickslip.analyses.motion import PeriodOfMotion, Wheel, contact_loops, frames_of, sections
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.disks.full import FullDisk
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.results.shown_units import system_of
from stickslip.results.view import level_text, periods_of
from stickslip.solve.balance.cycle import contact_cycle
from stickslip.support.checks import Array, fault
from stickslip.support.late import xr


def response_motion(dataset: xr.Dataset, problem: Problem, case: int, point: int) -> PeriodOfMotion:
    """Sections, loops and, of a disk, its blades over the period of a solved point."""
    points = SolvedPoints(dataset, problem)
    balance = points.balance
    evaluation = points.evaluation(case, point)
    cycle = contact_cycle(balance.table, balance.tables, evaluation.w[: balance.rows], evaluation.point.omega)
    whole = points.whole_motion(case, point) @ balance.tables.E.T if problem.structure.outlines else None
    outputs = evaluation.w[balance.rows :] @ balance.tables.E.T
    loops = contact_loops(problem, cycle)
    if not loops:
        raise fault("The problem of an animation", "must have contacts", "none", "plot() shows its curves.")
    parts = ((), (), ()) if whole is None else sections(problem, whole, cycle)
    hertz, periods = float(dataset["frequency"].values[case, point]), periods_of(dataset)
    title = f"{problem.heading}, {level_text(dataset, case)}, {hertz:.6g} Hz"
    note = f"one period of the motion is {periods} of the excitation" if periods > 1 else ""
    return PeriodOfMotion(title, loops, *parts, wheel_of(problem, outputs), note=note, system=system_of(dataset))


def wheel_of(problem: Problem, outputs: Array) -> Wheel | None:
    """The first output of every blade over the period, outputs (outputs, samples) [m]; None for what is no disk, or where a full
    disk does not report all its sectors.

    Blades of a tuned disk move alike, sector j later by j EO/N of a period of the excitation.
    """
    samples = outputs.shape[1]
    if isinstance(problem, TunedDisk):
        lag = np.arange(problem.sectors) * (problem.engine_order % problem.sectors) * samples // problem.sectors
        blades = outputs[0, (np.arange(samples)[:, None] - lag) % samples]
    elif isinstance(problem, FullDisk):
        first = {name.partition("/")[0]: k for k, name in reversed(list(enumerate(problem.output_names)))}
        rows = [first.get(str(j)) for j in range(1, problem.sectors + 1)]
        if None in rows:
            return None
        blades = outputs[[row for row in rows if row is not None]].T
    else:
        return None
    moving = blades - blades.mean(axis=0)
    return Wheel(moving[frames_of(samples)], 0.5 * np.ptp(moving, axis=0))
