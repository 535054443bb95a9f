"""What a check says of a study: natural frequencies, what holds its structure, the loads of its contacts at rest; and how long it
will take, by some points that are traced where contacts slip, and counted up."""

from contextlib import suppress
from dataclasses import replace
from time import process_time
from typing import NamedTuple

import numpy as np

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.mistuning.work import PopulationWork
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.analyses.static_load import as_lines, by_surface, opened, rest_of
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.problem.systems import on_few_coordinates, soft_springs
from stickslip.results.schema import in_system
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.fourier import orders
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.curves.curve import HELD_BY_FRICTION, held_by_friction_alone
from stickslip.study.analysis import Plan
from stickslip.study.reading import Job
from stickslip.support import machine
from stickslip.support.checks import Array, counted, fault, first_of
from stickslip.support.kernels.cache import nothing_is_kept
from stickslip.support.units import Band, UnitSystem

SHOWN = 6
"""Nodal diameters whose frequencies a sentence lists."""


def model_summary(sweep: ForcedResponseSettings, condition: str = "", system: UnitSystem | None = None) -> list[str]:
    """Natural frequencies without contacts and with all stuck, whether friction alone holds a body, and normal loads at rest.
    condition: when all that holds, "at 6000 rev/min".
    """
    free, stuck = (sweep.problem.frequencies(stuck=stuck) for stuck in (False, True))
    when = f" {condition}" if condition else ""
    words, mesh = [_listed(free), _listed(stuck)], sweep.problem.mesh
    if mesh is not None:
        limits = mesh.stuck.free_to, mesh.stuck.modes_to
        words = [f"{listed or 'none'} up to {limit:.5g} Hz" for listed, limit in zip(words, limits, strict=True)]
    listed = f"without contacts: {words[0]}; all contacts stuck: {words[1]}"
    lines = [f"Natural frequencies in Hz{when}, {listed}."]
    lines += _waves(sweep.problem)
    if held_by_friction_alone(sweep.problem):
        lines.append(f"{HELD_BY_FRICTION} {_proposed(sweep.problem, system)}")
    lines += _loads(sweep.problem, when, system)
    return lines + list(filter(None, [opened(sweep.problem, min(sweep.frequencies), max(sweep.frequencies))]))


def _waves(problem: Problem) -> list[str]:
    """Natural frequencies of a disk at the nodal diameters that are excited, and at 0 and N/2, which an analysis of the sector
    alone gives too."""
    if not isinstance(problem, TunedDisk):
        return []
    waves = [order % problem.sectors for order in problem.excited_orders or (problem.engine_order,)]
    diameters = dict.fromkeys((0, *(min(wave, problem.sectors - wave) for wave in waves[:SHOWN]), problem.sectors // 2))
    return [f"At nodal diameter {n}, without contacts: {_listed(problem.modes(n, stuck=False).frequencies)}." for n in diameters]


def _proposed(problem: Problem, system: UnitSystem | None) -> str:
    """Soft springs for the mean of each loose motion, as a study holds them, in its units."""
    tables, (factor, unit) = [], in_system("N/m", system)
    for spring in soft_springs(problem):
        (dof,) = spring.direction
        tables.append(f'direction = {{ "{dof}" = 1 }}, k of about {factor * spring.stiffness:.1g} {unit}')
    return f"A soft spring on the mean, [[mean_spring]], restrains it and does not affect the vibration: {'; '.join(tables)}."


def _listed(frequencies: Array) -> str:
    """The lowest frequencies, and how many rigid motions there are below."""
    moving = frequencies[frequencies > 0.0]
    rigid = [counted(frequencies.size - moving.size, "rigid motion")] if moving.size < frequencies.size else []
    return first_of([*rigid, *(f"{f:.5g}" for f in moving)])


def _loads(problem: Problem, when: str, system: UnitSystem | None) -> list[str]:
    """A table of the contacts at rest, or that no state of rest was found."""
    found = rest_of(problem)
    if not found and any(contact.normal is not None for contact in problem.contacts):
        return [f"No static equilibrium was found{when}: check that the static loads close contacts and friction holds them."]
    lines = as_lines(by_surface(found, system) if found else [])
    return [f"Contacts at rest{when}; the values after the normal load are those of single contacts:", *lines] if lines else []


POINTS = 300
"""Solutions of a curve and of its peaks as dear as those that are tried; the templates take 100 to 1900."""

LOWEST, TRIED, LONGEST = 1e-3, 4, 1.0
"""Share of the largest force level from which it is raised; points that are timed, the last after so many CPU seconds."""

AUTOMATIC = 7
"""Harmonics that stand for those which an analysis other than the forced response chooses during the run."""

STEPS = ((10.0, "seconds"), (90.0, "about a minute"))
"""CPU seconds up to which computing takes so long."""
LONGER = ((5400.0, 60.0, "minutes"), (36.0 * 3600.0, 3600.0, "hours"), (float("inf"), 24.0 * 3600.0, "days"))
"""CPU seconds up to which a time is given in this unit, s, with one digit: what is estimated is right to a factor of five."""

MANY_SECONDS = 1200.0
"""CPU seconds from which on a remedy is given beside the estimate."""

LARGEST = 4000
"""Coordinates, and harmonic coefficients of these or of the contact rows, up to which a check solves a point."""

CURVES = ("forced_response", "response_samples", "speed_sweep")
"""Analyses whose cases are curves."""


MATRIX, PRODUCTS = 500, 6
"""Rows of the matrix whose product with itself says how fast the machine is, and how often it is made."""

CURVE_POINTS, BLADE_POINTS, NEWTON_STEPS, MODE_ANALYSES = 40, 3, 1.5, 60.0
"""Of a mistuned disk: points of its curve and of the search for the maximum of each blade; steps of Newton's method for a point
and operations for all modes per cube of the coordinates, counted in operations of a product of matrices."""

BY_SECTOR = 3000.0
"""Operations of a point of a disk that is solved sector by sector, per sector and square of its unknowns: with 24 sectors of nine
shapes and three harmonics 27 ms, with fourteen 31 ms."""

BRIEF = 5.0
"""CPU seconds up to which further processes take longer to start than they save."""

WORTH_SAYING = 30.0
"""CPU seconds from which on a run says beforehand how long it takes."""


def run_time(job: Job, seconds: float | None) -> str:
    """A sentence on the time of all curves over a band, of estimated CPU seconds; empty where these are not known."""
    population = _population(job)
    if (_has_curves(job) or population) and nothing_is_kept():
        return "The first run on this machine compiles for about a minute; a check after it estimates the time of a run."
    if seconds is None:
        return ""
    words = _in_words(seconds)
    if population is None:
        said = f"Computing {counted(_curves(job), 'curve')} takes {words} of one core, as roughly estimated from a few points."
        integrated = " The time integration of [reached] comes in addition and may take ten times as long."
        return said + (integrated if getattr(job.plan, "reached", None) is not None else "")
    whole = population.disk.sectors * population.disk.structure.size
    few = f" on about {population.coordinates} coordinates of {whole}" if population.coordinates < whole else ""
    cure = " Fewer contact points (`points`) and harmonics shorten it most." if seconds > MANY_SECONDS else ""
    what = f"{counted(population.count, 'mistuned disk')}{few}"
    return f"Computing {what} takes {words} of one core, as roughly estimated from a few points of the tuned disk.{cure}"


KEPT, RESULTING = 6, 3
"""Arrays (contact rows, 2H+1) that a point keeps while its curve is computed: contact forces, motion, residual, tangent of both,
scales; and that results hold of a point of each curve: forces, motion and shares of half of them, twice while they are joined."""


def run_memory(job: Job, processes: int = 1) -> str:
    """A sentence on the memory of all curves on a finite-element model whose contacts are many, refused where the machine has
    less: of each process what this one has with the model, and the points of a curve; all results. Empty for other studies."""
    if job.sweep is None or not _has_curves(job) or job.sweep.problem.mesh is None:
        return ""
    harmonics = _with_harmonics(job.sweep, job.plan).harmonics
    columns = 2 * (AUTOMATIC if isinstance(harmonics, str) else harmonics if isinstance(harmonics, int) else len(harmonics)) + 1
    rows, curves = len(job.sweep.problem.contact_stiffness), _curves(job)
    processes, a_curve = min(processes, curves), POINTS * 8.0 * rows * columns
    whole = processes * (machine.taken() + KEPT * a_curve) + curves * RESULTING * a_curve
    needed, there = (f"{size / 2**30:.2g} GiB" for size in (whole, machine.memory()))
    if whole > machine.memory():
        what = f"The memory of {rows} contact rows with their model in {counted(processes, 'process', 'processes')}"
        raise fault(what, f"must fit into {there}", needed, "Take fewer contacts (`points`), harmonics or --workers.")
    return f"It takes about {needed} of memory in {counted(processes, 'process', 'processes')}."


def _in_words(seconds: float) -> str:
    """A CPU time as a person would say it."""
    for limit, words in STEPS:
        if seconds < limit:
            return words
    size, unit = next((size, unit) for limit, size, unit in LONGER if seconds < limit)
    return f"about {float(f'{seconds / size:.1g}'):g} {unit}"


def _population(job: Job) -> PopulationWork | None:
    """The mistuned disks of a study over a band; None of another analysis."""
    work = None if job.sweep is None or job.sweep.listed else job.plan.works.get("")
    return work if isinstance(work, PopulationWork) else None


def stays_long(job: Job) -> bool:
    """Whether a study stays in one call of a library for long, during which its process hears no Ctrl-C."""
    population = _population(job)
    return population is not None and population.large and not population.by_sector


def _has_curves(job: Job) -> bool:
    return job.sweep is not None and job.analysis in CURVES and not job.sweep.listed


def _curves(job: Job) -> int:
    return sum(len(work.names) for work in job.plan.works.values())


def estimated_seconds(job: Job) -> float | None:
    """CPU seconds of all curves over a band; None for other analyses, where no point could be solved, and where the kernels are
    still to be compiled."""
    if job.sweep is None or not isinstance(job.sweep.band, Band) or nothing_is_kept():
        return None
    population = _population(job)
    if population is None and not _has_curves(job):
        return None
    tried = _tried_points(_with_harmonics(job.sweep, job.plan), job.sweep.band)
    if tried is None:
        return None
    return POINTS * _curves(job) * tried.seconds if population is None else _seconds_of_disks(population, tried)


def _seconds_of_disks(work: PopulationWork, tried: "_Tried") -> float:
    """CPU seconds of the tuned disk and of all mistuned ones, of which every sector has as many unknowns as a sector of the tuned
    one: an analysis of the modes, and for each point Newton's method with dense matrices."""
    N, columns = work.disk.sectors, len(orders(work.sweep.harmonics)) * 2 + 1
    if work.by_sector:
        a_point = BY_SECTOR * N * (work.coordinates / N * columns) ** 2
        return POINTS * tried.seconds + work.count * _seconds_an_operation() * (CURVE_POINTS + BLADE_POINTS * N) * a_point
    states, unknowns, rows = work.coordinates, N * np.array(tried.unknowns, dtype=float), N * len(work.disk.contact_stiffness)
    matrices = unknowns**3 + 2.0 * unknowns**2 * states / columns
    a_point = NEWTON_STEPS * float(np.mean(matrices)) + 4.0 * rows * states * columns
    points = CURVE_POINTS + BLADE_POINTS * N
    return POINTS * tried.seconds + work.count * _seconds_an_operation() * (MODE_ANALYSES * states**3 + points * a_point)


def _seconds_an_operation() -> float:
    """CPU seconds of an operation in a product of matrices: the least of several, since others may use the machine too."""
    factor, seconds = np.ones((MATRIX, MATRIX)), []
    for _ in range(PRODUCTS):
        began = process_time()
        _ = factor @ factor
        seconds.append(process_time() - began)
    return min(seconds) / (2.0 * MATRIX**3)


def _with_harmonics(sweep: ForcedResponseSettings, plan: Plan) -> ForcedResponseSettings:
    """The sweep with the harmonics and samples that were chosen for it, which is done where its work is made."""
    work = plan.works.get("") if sweep.harmonics == "auto" else None
    return replace(sweep, harmonics=work.harmonics, samples=work.samples) if isinstance(work, ForcedResponseWork) else sweep


class _Tried(NamedTuple):
    """CPU seconds of a point, and the unknowns of Newton's method of each."""

    seconds: float
    unknowns: list[int]


def _tried_points(sweep: ForcedResponseSettings, band: Band) -> "_Tried | None":
    """The last points at the highest linear resonance on the way to the largest force level, as far as a second leads."""
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
    level = max(sweep.levels)
    with np.errstate(all="ignore"):
        first = first_point(balance, 2.0 * np.pi * middle, LOWEST * level)
    if not first.converged:
        return None
    times: list[float] = []
    unknowns: list[int] = []
    with suppress(LostCurveError):
        for point in trace(balance, first, "level", level):
            times.append(process_time())
            unknowns.append(point.active)
            if len(times) > TRIED and times[-1] - times[0] > LONGEST:
                break
    times, unknowns = times[-TRIED:], unknowns[-TRIED:]
    return _Tried(float(np.median(np.diff(times))), unknowns) if len(times) > 1 else None  # the first ones load the kernels
