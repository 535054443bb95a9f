"""Free decay in time: the motion after a release or an impact, and its frequency and damping from one half cycle to the next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analyses.contact_rows import ContactRows
from stickslip.model.contact.point import DIRECTION_NAMES
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.solve.time.march import no_history, state_at
from stickslip.solve.time.methods import DEFAULT_METHOD, Method
from stickslip.solve.time.model import time_model
from stickslip.solve.time.period import Loads, march_period, settle
from stickslip.solve.time.start import TimeStart, from_rest
from stickslip.support.checks import Array, InputError, between, fault, finite, of_kind, positive
from stickslip.support.machine import one_blas_thread

if TYPE_CHECKING:
    import xarray as xr

MOST_STEPS = 10_000_000
"""More would fill the memory with histories."""

FEWEST = 6
"""Steps of a half cycle, below which its amplitude and frequency would be those of the steps."""

SMALLEST = 1e-3
"""Share of the largest swing of an output below which its turning points are no longer listed."""


@dataclass(frozen=True, eq=False, repr=False)
class FreeDecay(Result):
    """`dataset`, with time [s], the motion of the outputs (output, time) [m], motions and forces of the contacts (contact,
    direction, time) [m, N], friction work (contact,) and viscous work [J].

    For each output and each half cycle from one turning point to the next (output, half_cycle), NaN after the last:
    turning_time [s] and turning_point [m] at its beginning; amplitude [m], half the distance to the next; frequency [Hz],
    1/(2 Δt); damping_ratio ζ from the logarithmic decrement of two successive amplitudes, δ = ln(a_k/a_{k+1}) = πζ/√(1 − ζ²).
    """

    dataset: xr.Dataset
    problem: Problem


def free_decay(
    problem: Problem,
    duration: float,
    displacement: Mapping[str, float] | None = None,
    velocity: Mapping[str, float] | None = None,
    *,
    start: TimeStart | None = None,
    steps: int = 20_000,
    method: Method = DEFAULT_METHOD,
) -> FreeDecay:
    """Integrate M q̈ + C q̇ + K q + Bᵀ f(B q) = p_static for `duration`, s, without excitation.

    displacement [m] and velocity [m/s] at t = 0 are given by degree of freedom, as {"tip.y": 1e-3}; all others are 0. The sliders
    begin where their start rules put them, and contacts slip while the structure is displaced to the position of its release.
    start: the state at t = 0 instead, for example `time_response(...).cycle.end`, from which the motion continues after the
    excitation has stopped. steps: number of steps of the whole duration; take hundreds for each cycle of the fastest motion of
    interest. With thousands per cycle the motion agrees with an integration from event to event within 1e-4.
    """
    of_kind("problem", problem, Problem)
    if start is not None and (displacement is not None or velocity is not None):
        raise InputError("start must not be given together with displacement or velocity, since it contains both. Leave out one.")
    step = positive("duration", duration) / between("steps", steps, 8, MOST_STEPS)
    if not isinstance(method, Method):
        raise fault("method", "must be a GeneralisedAlpha or a Newmark", method)
    begin = _at(problem, displacement or {}, velocity or {}) if start is None else _checked(problem, start)
    model = time_model(problem)
    with one_blas_thread():
        matrices = model.step_matrices(method.coefficients, step)
        loads = Loads(model.shapes.T @ problem.static_load, np.zeros((model.mass.size, 1)), np.zeros((steps, 1)))
        state, history = state_at(model, begin), no_history(model, steps)
        settle(model.table, matrices, loads, state)
        first = matrices.outputs @ state.motion, state.contacts.w.copy(), state.contacts.forces.copy()
        work = march_period(model.table, matrices, loads, state, history)
    if work.failed >= 0:
        raise InputError(f"Newton's method did not find a solution for step {work.failed} of {steps}. Take more steps.")
    first = first[0], first[1], first[2] + matrices.stiffness * first[1]
    outputs, motion, force = (
        np.column_stack([begun, signals[:, 1:], signals[:, 0]])
        for begun, signals in zip(first, (history.outputs, history.contact_motion, history.contact_force), strict=True)
    )
    if not np.all(np.isfinite(outputs)):
        raise InputError("The motion grows without bound: the structure is unstable, or the steps are too long. Take more steps.")
    return FreeDecay(_dataset(problem, step, outputs, motion, force, history.friction_work, work.viscous, method), problem)


def _checked(problem: Problem, start: TimeStart) -> TimeStart:
    """A given state, refused where it is one of another problem."""
    sizes = [np.shape(values) for values in vars(of_kind("start", start, TimeStart)).values()]
    wanted = [np.shape(values) for values in vars(from_rest(problem)).values()]
    if sizes != wanted:
        raise fault("start", f"must have motion, velocity and intercepts of shapes {wanted}", sizes, "Take that of this problem.")
    return start


def _at(problem: Problem, displacement: Mapping[str, float], velocity: Mapping[str, float]) -> TimeStart:
    """The state with given motions of some degrees of freedom."""
    begin = from_rest(problem)
    for what, given, values in (("displacement", displacement, begin.motion), ("velocity", velocity, begin.velocity)):
        for dof, value in of_kind(what, given, dict).items():
            if dof not in problem.structure.dofs:
                known = ", ".join(problem.structure.dofs[:8])
                raise fault(what, "must name degrees of freedom of the structure", dof, f"The first are {known}.")
            values[problem.structure.dofs.index(dof)] = finite(what, value)
    if not (np.any(begin.motion) or np.any(begin.velocity)):
        raise InputError('displacement or velocity must move something, but all are 0. For example displacement={"tip.y": 1e-3}.')
    return begin


def turning_points(time: Array, signal: Array) -> tuple[Array, Array]:
    """Times and values of the extremes of a signal, by a parabola through the three samples around each.

    A released motion has one at its beginning: the parabola through the first three samples turns half a step before them at
    most, so that the first difference is at most half of the second. They end where a swing is below `SMALLEST` of the largest.
    """
    rising = np.sign(np.diff(signal))
    for k in np.flatnonzero(rising == 0.0):  # equal neighbours: as before
        rising[k] = rising[k - 1] if k else 0.0
    inner = np.flatnonzero(rising[1:] * rising[:-1] < 0.0) + 1
    left, middle, right = signal[inner - 1], signal[inner], signal[inner + 1]
    bend = left - 2.0 * middle + right
    shift = np.where(bend != 0.0, 0.5 * (left - right) / np.where(bend != 0.0, bend, 1.0), 0.0)
    begun = int(abs(signal[1] - signal[0]) <= 0.5 * abs(signal[2] - signal[1]))
    times = np.concatenate([time[:begun], time[inner] + shift * (time[1] - time[0])])
    values = np.concatenate([signal[:begun], middle - 0.25 * (left - right) * shift])
    swings = np.abs(np.diff(values))
    small = np.flatnonzero(swings < SMALLEST * swings.max(initial=0.0))
    count = (small[0] if small.size else swings.size) + 1
    return times[:count], values[:count]


def half_cycles(times: Array, values: Array) -> tuple[Array, Array, Array]:
    """Amplitude, frequency [Hz] and damping ratio of the half cycles between turning points; the last has no damping ratio."""
    amplitude = 0.5 * np.abs(np.diff(values))
    decrement = np.append(np.log(amplitude[:-1] / amplitude[1:]), np.nan)[: amplitude.size]
    return amplitude, 0.5 / np.diff(times), decrement / np.sqrt(np.pi**2 + decrement**2)


def _dataset(
    problem: Problem,
    step: float,
    outputs: Array,
    motion: Array,
    force: Array,
    friction_work: Array,
    viscous: float,
    method: Method,
) -> xr.Dataset:
    import xarray as xr

    time = np.asarray(step * np.arange(outputs.shape[1]), dtype=float)
    found = [turning_points(time, signal) for signal in outputs]
    if any(np.any(np.diff(times) < FEWEST * step) for times, _ in found):
        raise InputError(
            f"A half cycle must have {FEWEST} steps at least, but some have fewer: the motion is faster than the steps. Take "
            "more steps, or a shorter duration."
        )
    width = max(len(times) for times, _ in found)
    table = np.full((5, len(found), width), np.nan)
    for k, (times, values) in enumerate(found):
        table[:2, k, : len(times)] = times, values
        table[2:, k, : len(times) - 1] = half_cycles(times, values)
    rows, contact, half = ContactRows(problem), ("contact", "direction", "time"), ("output", "half_cycle")
    work = np.nansum(rows.spread(friction_work[:, None])[..., 0], axis=1)
    variables: dict[str, tuple[tuple[str, ...], Any, str, str]] = {
        "displacement": (("output", "time"), outputs, "m", "outputs"),
        "contact_motion": (contact, rows.spread(motion), "m", "contact displacements"),
        "contact_force": (contact, rows.spread(force), "N", "contact forces"),
        "friction_work": (("contact",), work, "J", "energy that friction has dissipated"),
        "viscous_work": ((), viscous, "J", "energy that viscous damping has dissipated"),
        "turning_time": (half, table[0], "s", "time of the turning point"),
        "turning_point": (half, table[1], "m", "displacement at the turning point"),
        "amplitude": (half, table[2], "m", "half the distance to the next turning point"),
        "frequency": (half, table[3], "Hz", "frequency of the half cycle"),
        "damping_ratio": (half, table[4], "1", "damping ratio by the logarithmic decrement to the next half cycle"),
    }
    return xr.Dataset(
        {
            name: (dims, values, {"units": units, "long_name": long_name})
            for name, (dims, values, units, long_name) in variables.items()
        },
        coords={
            "time": ("time", time, {"units": "s"}),
            "output": list(problem.output_names),
            "contact": [contact.name for contact in problem.contacts],
            "direction": list(DIRECTION_NAMES),
        },
        attrs={"title": problem.heading, "method": repr(method), "steps": outputs.shape[1] - 1},
    )
