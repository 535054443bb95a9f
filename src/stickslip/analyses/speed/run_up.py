"""Run-up and run-down in time: the motion integrated while the rotor speed changes at a finite rate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from stickslip.analyses.speed.models import synchronous
from stickslip.analyses.speed.speed_sweep import excited
from stickslip.analyses.time_response import harmonics_of
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.solve.time.march import March, MarchOutcome, TimeStart, from_rest, loads_of_steps, march, no_history, state_at
from stickslip.solve.time.model import DEFAULT_METHOD, Method, time_model
from stickslip.solve.time.period import march_period, settle
from stickslip.support.checks import Array, InputError, between, fault, finite, of_kind, positive, vector
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread

FEWEST = 4
"""Cycles of the excitation that a run must hold."""
STEADY = 1e-4
"""Relative distance from the steady motion at which a run begins."""


@dataclass(frozen=True, eq=False, repr=False)
class RunUp(Result):
    """`dataset`, axis cycle, the cycles of the excitation one by one: time [s], speed [rev/min] and frequency [Hz] at the middle
    of the cycle; amplitude (cycle, output) of the first harmonic of a cycle [m], max_abs (cycle, output) [m]. attrs outcome and
    message say how the integration ended."""

    dataset: xr.Dataset
    problem: Problem


def run_up(
    models: Problem | Mapping[float, Problem],
    speed: tuple[float, float],
    duration: float,
    engine_order: int | None = None,
    force: float = 1.0,
    *,
    steps_per_period: int = 200,
    method: Method = DEFAULT_METHOD,
    start_periods: int = 1000,
) -> RunUp:
    """Integrate the motion while the rotor speed goes from `speed[0]` to `speed[1]`, in rev/min, evenly within `duration`, s.

    The phase of the excitation is EO ∫Ω dt. models: as of `speed_sweep`. engine_order: that of the problem's `speed` unless
    given. A first speed above the last one is a run-down. The run begins with the steady motion of the first speed,
    marched from rest for `start_periods` at most. steps_per_period: steps of each cycle of the excitation; stiffness and constant
    loads are those of the speed at its middle. Vibration that grows without bound, or a step without solution, ends the run
    (`dataset.attrs["message"]`). One sector of a tuned disk has no equation of motion in time: take `disk.full()`.
    """
    problem = models if isinstance(models, Problem) else synchronous(models)
    if of_kind("models", problem, Problem).speed is None:
        raise fault("models", "must be a problem with `speed`, or two models by speed", "a problem at one speed")
    if engine_order is not None:
        problem = excited(problem, between("engine_order", engine_order, 1))
    assert problem.speed is not None
    first, last = (float(positive("speed", value)) for value in vector("speed", speed, 2))
    if first == last:
        raise fault("speed", "must be two different speeds", speed, "At one speed, time_response integrates.")
    # rad/s of the excitation, and its rate.
    ends = 2.0 * np.pi / 60.0 * problem.speed.engine_order * np.array([first, last])
    rate = (ends[1] - ends[0]) / positive("duration", duration)
    cycles = int((ends.mean() * duration) // (2.0 * np.pi))
    if cycles < FEWEST:
        raise fault("duration", f"must hold {FEWEST} cycles of the excitation at least", f"{duration:g} s, {cycles} cycles")
    settings = March(steps_per_period, method, STEADY, start_periods)
    level = finite("force", force)
    begin = problem.at_frequency(float(ends[0]))
    steady = march(begin, float(ends[0]), level, from_rest(begin), settings)
    if steady.outcome in (MarchOutcome.STEP_FAILED, MarchOutcome.UNBOUNDED):
        raise InputError(f"The run must begin with a steady motion at {first:g} rev/min, but found none. {steady.sentence}")
    times = _times(float(ends[0]), rate, cycles)
    with one_blas_thread():
        rows = list(_marched(problem, float(ends[0]), rate, times, level, steady.end, settings))
    dataset = _dataset(problem, float(ends[0]), rate, times, rows, level, duration)
    if steady.outcome != MarchOutcome.PERIODIC:
        dataset.attrs["message"] += f" The motion that it begins with was not yet steady. {steady.sentence}"
    return RunUp(dataset, problem)


def _times(omega: float, rate: float, cycles: int) -> Array:
    """The ends of the cycles, s: ω t + ½ rate t² = 2π k, k = 0..cycles; exact where the rate is small, too."""
    angles = 2.0 * np.pi * np.arange(cycles + 1)
    return np.asarray(2.0 * angles / (omega + np.sqrt(omega**2 + 2.0 * rate * angles)))


def _marched(
    problem: Problem, omega: float, rate: float, times: Array, level: float, start: TimeStart, settings: March
) -> Iterator[tuple[Array, Array]]:
    """Complex first harmonic and largest displacement of the outputs in every cycle, until a step fails or the motion explodes.

    Within a cycle of length T the phase at the share s is 2πs + ½ rate T² s (s − 1): the steps are even in time, and the
    excitation runs ahead by that much.
    """
    steps = settings.steps_per_period
    share = np.arange(steps) / steps
    for k, length in enumerate(np.diff(times)):
        middle = omega + rate * (times[k] + 0.5 * length)
        model = time_model(problem.at_frequency(middle))
        matrices = model.step_matrices(settings.method.coefficients, length / steps)
        loads = loads_of_steps(model, middle, level, steps)
        ahead = 0.5 * rate * length**2 * share * (share - 1.0)
        highest = (loads.rows.shape[1] - 1) // 2
        angles = np.outer(2.0 * np.pi * share + ahead, np.arange(1, highest + 1))
        loads.rows[:, 1::2], loads.rows[:, 2::2] = np.cos(angles), np.sin(angles)
        state = state_at(model, start)
        settle(model.table, matrices, loads, state)
        history = no_history(model, steps)
        work = march_period(model.table, matrices, loads, state, history)
        if work.failed >= 0 or not np.all(np.isfinite(history.outputs)):
            return
        start = TimeStart(model.shapes @ state.motion, model.shapes @ state.velocity, state.contacts.intercept.copy())
        yield harmonics_of(history.outputs, 1)[:, 1], np.max(np.abs(history.outputs), axis=1)


def _dataset(
    problem: Problem,
    omega: float,
    rate: float,
    times: Array,
    rows: list[tuple[Array, Array]],
    level: float,
    duration: float,
) -> xr.Dataset:
    assert problem.speed is not None
    count = len(rows)
    middle = 0.5 * (times[1 : count + 1] + times[:count])
    hertz = (omega + rate * middle) / (2.0 * np.pi)
    per_speed = problem.speed.engine_order / 60.0
    complete = count == times.size - 1
    message = "Complete." if complete else f"No step was found in cycle {count + 1}: take more steps per period."
    outputs = len(problem.output_names)
    first = np.reshape([harmonic for harmonic, _ in rows], (count, outputs))
    largest = np.reshape([size for _, size in rows], (count, outputs))
    data = {
        "time": (("cycle",), middle, {"units": "s", "long_name": "time at the middle of the cycle"}),
        "speed": (("cycle",), hertz / per_speed, {"units": "rev/min", "long_name": "rotor speed"}),
        "frequency": (("cycle",), hertz, {"units": "Hz", "long_name": "excitation frequency"}),
        "amplitude": (("cycle", "output"), np.abs(first), {"units": "m", "long_name": "amplitude of the first harmonic"}),
        "max_abs": (("cycle", "output"), largest, {"units": "m", "long_name": "largest displacement in the cycle"}),
    }
    attrs = {
        "title": problem.heading,
        "engine_order": problem.speed.engine_order,
        "force_level": level,
        "duration": duration,
        "outcome": "complete" if complete else "step_failed",
        "message": message,
    }
    return xr.Dataset(data, {"output": list(problem.output_names), "cycle": np.arange(1, count + 1)}, attrs)
