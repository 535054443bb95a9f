"""Performance curves in a study: the table [performance_curve]."""

from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.performance.curve import gathered
from stickslip.analyses.performance.work import PerformanceWork, centrifugal_pull, excitation, with_friction
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.model.problem import Problem
from stickslip.model.problem.meshed import promised
from stickslip.runs.cases import Progress
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Works, summary_of, taken_over
from stickslip.study.fields import FORCE, Positive, Table, Units, in_si, table_of
from stickslip.study.tables import Ends
from stickslip.support.checks import MOST, InputError, counted, fault

Points = Annotated[int, Field(ge=2, le=MOST, description="number of values of F_C/F_E, in equal ratios")]


class RatiosTable(Table):
    """Force ratios from a lowest to a highest one."""

    def check(self: Any) -> None:
        """The lower ratio first."""
        if self.force_ratio[0] >= self.force_ratio[1]:
            raise fault("force_ratio", "must be [low, high] with low below high", self.force_ratio)


PerformanceTable = table_of(
    PerformanceWork,
    "The resonance against F_C/F_E, for one or several friction coefficients; sought in the band of [sweep].",
    RatiosTable,
    checked=True,
    friction=Annotated[list[Positive] | None, Field(min_length=1)],
    pull=Annotated[Positive | None, FORCE],
    points=(Points, 40),
    force_ratio=Ends,
)


def plan(asked: Asked) -> Works:
    """A performance curve for each friction coefficient."""
    sweep = sweep_over_a_band(asked)
    settings = at_ratios(asked.tables["performance_curve"], asked.units) | {"band": sweep.band}

    def work(problem: Problem) -> PerformanceWork:
        return PerformanceWork(**taken_over(ForcedResponseWork.of(sweep)) | {"problem": problem}, **settings)

    def on_mesh(progress: Progress) -> PerformanceWork:
        """On the shapes of the contact forces at the peaks of the ends and the middle of the curve, for each friction."""
        problem = sweep.problem
        levels = [pull / (ratio * excitation(problem)) for ratio in (low, np.sqrt(low * high), high)]
        for mu in settings["friction"] or [None]:
            rubbing = problem if mu is None else with_friction(problem, mu)
            solved = ForcedResponseWork.of(replace(sweep, problem=rubbing, force=levels)).with_shapes(progress).problem
            problem = replace(solved, contacts=problem.contacts)
        return work(problem)

    low, *_, high = ratios = settings["force_ratio"]
    pull = settings["pull"] or centrifugal_pull(sweep.problem)
    words = f"{counted(len(settings['friction'] or [0]), 'performance curve')} of {counted(len(ratios), 'point')}"
    summary = f"{summary_of(sweep)}; {words}, F_C/F_E {low:g} to {high:g}, F_C = {pull:g} N"
    summary += "" if settings["pull"] else ", the largest static force or preload: `pull` states another"
    of_mesh, known = None if sweep.problem.mesh is None else on_mesh, promised(sweep.problem)
    return Works(lambda: work(known), summary, lambda work, arrays: gathered(work, arrays).dataset, on_mesh=of_mesh)


def sweep_over_a_band(asked: Asked) -> ForcedResponseSettings:
    """The sweep, whose band says where resonances are sought."""
    sweep = sweep_of(asked)
    if sweep.listed:
        raise InputError("[sweep]: a performance curve must have a band, frequency = [start, stop], but has a list.")
    return sweep


def at_ratios(table: Table, units: Units) -> dict[str, Any]:
    """The settings of a table, with F_C/F_E in equal ratios between its ends."""
    settings = in_si(table, units)
    low, high = settings["force_ratio"]
    settings["force_ratio"] = np.geomspace(low, high, settings.pop("points")).tolist()
    return settings


KIND = Kind(plan, {"performance_curve": PerformanceTable}, without=("force_levels", "peak_tolerance"), from_mesh=True)
