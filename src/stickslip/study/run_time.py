"""How long a study of responses over a band will take: some points are traced where contacts slip, and counted up."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from time import process_time
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.response_settings import ForcedResponseSettings
from stickslip.model.problem.truncation import on_few_coordinates
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.study.analysis import Plan
from stickslip.support.checks import counted
from stickslip.support.kernels.cache import nothing_is_kept
from stickslip.support.units import Band

if TYPE_CHECKING:
    from stickslip.study.read import Job

POINTS = 300
"""Solutions of a curve and of its peaks as dear as those that are tried; the templates take 100 to 1900."""

FEWEST, TRIED, LONGEST = 4, 15, 1.0
"""Points that are traced to see how long one takes, at least and at most, and CPU seconds after which it is enough."""

AUTOMATIC = 7
"""Harmonics that stand for those which an analysis other than the forced response chooses during the run."""

STEPS = ((10.0, "seconds"), (90.0, "about a minute"), (1200.0, "minutes"), (5400.0, "about an hour"), (40000.0, "hours"))
"""CPU seconds up to which computing takes so long: what is estimated is right to a factor of five."""

LARGEST = 4000
"""Coordinates, and harmonic coefficients of these or of the contact rows, up to which a check solves a point."""

CURVES = ("forced_response", "response_samples", "speed_sweep")
"""Analyses whose cases are curves."""


BRIEF = 5.0
"""CPU seconds up to which further processes take longer to start than they save."""

WORTH_SAYING = 30.0
"""CPU seconds from which on a run says beforehand how long it takes."""


def run_time(job: Job, seconds: float | None) -> str:
    """A sentence on the time of all curves over a band, of estimated CPU seconds; empty where these are not known."""
    if _has_curves(job) and nothing_is_kept():
        return "The first run on this machine compiles for about a minute; a check after it estimates the time of a run."
    if seconds is None:
        return ""
    words = next((words for limit, words in STEPS if seconds < limit), "days")
    return f"Computing {counted(_curves(job), 'curve')} takes {words} of one core, by a rough estimate from a few points."


def _has_curves(job: Job) -> bool:
    return job.sweep is not None and job.analysis in CURVES and not job.sweep.listed


def _curves(job: Job) -> int:
    return sum(len(work.names) for work in job.plan.works.values())


def estimated_seconds(job: Job) -> float | None:
    """CPU seconds of all curves over a band; None for other analyses, where no point could be solved, and where the kernels are
    still to be compiled."""
    if job.sweep is None or not _has_curves(job) or not isinstance(job.sweep.band, Band) or nothing_is_kept():
        return None
    a_point = _seconds_a_point(_with_harmonics(job.sweep, job.plan), job.sweep.band)
    return None if a_point is None else POINTS * _curves(job) * a_point


def _with_harmonics(sweep: ForcedResponseSettings, plan: Plan) -> ForcedResponseSettings:
    """The sweep with the harmonics and samples that were chosen for it, which is done where its work is made."""
    work = plan.works.get("") if sweep.harmonics == "auto" else None
    return replace(sweep, harmonics=work.harmonics, samples=work.samples) if isinstance(work, ForcedResponseWork) else sweep


def _seconds_a_point(sweep: ForcedResponseSettings, band: Band) -> float | None:
    """CPU seconds of a point on the way to the highest linear resonance, at the largest force level."""
    harmonics = AUTOMATIC if sweep.harmonics == "auto" else sweep.harmonics
    orders = harmonics if isinstance(harmonics, int) else len(harmonics)
    problem = on_few_coordinates(sweep.problem, orders * band.high)
    states = problem.structure.M.shape[0]
    if max(states, (2 * orders + 1) * min(len(problem.B), states)) > LARGEST:
        return None
    balance = HarmonicBalance(problem, harmonics, sweep.samples)
    stuck = sweep.problem.systems.met(stuck=True)
    inside = stuck[(stuck > band.low) & (stuck < band.high)]
    middle = float(inside[0]) if inside.size else 0.5 * (band.low + band.high)
    with np.errstate(all="ignore"):
        first = first_point(balance, 2.0 * np.pi * middle, max(sweep.levels))
    if not first.converged:
        return None
    times: list[float] = []
    with suppress(LostCurveError):
        for _ in trace(balance, first, "omega", 2.0 * np.pi * band.low):
            times.append(process_time())
            if len(times) >= TRIED or (len(times) >= FEWEST and times[-1] - times[0] > LONGEST):
                break
    return float(np.median(np.diff(times))) if len(times) > 1 else None  # the first ones load the kernels
