"""Stepped sine in time: the excitation dwells at one frequency after the other, and the motion goes on from each to the next.

What a laboratory records is then not the steady motion, but what is left after the dwell, with the contacts as they were before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analyses.arguments import force_levels
from stickslip.analyses.time_response import harmonics_of
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.solve.time.march import March, MarchOutcome, TimeCycle, march
from stickslip.solve.time.methods import DEFAULT_METHOD, Method
from stickslip.solve.time.start import TimeStart, from_rest
from stickslip.support.checks import Array, InputError, between, fault, of_kind, positive
from stickslip.support.units import Band, followed

if TYPE_CHECKING:
    import xarray as xr

NEVER = 1e-30
"""Tolerance of periodicity that no motion reaches: each dwell has all of its periods."""


@dataclass(frozen=True, eq=False, repr=False)
class SteppedSine(Result):
    """`dataset`, along `step`: frequency [Hz]; of the last period of each dwell amplitude [m] of the first harmonic and max_abs
    [m] (step, output), and distance (step,), the estimated relative distance from the steady motion. `end`: the state after the
    last dwell, from which another test or a free decay may go on."""

    dataset: xr.Dataset
    problem: Problem
    end: TimeStart


def stepped_sine(
    problem: Problem,
    frequencies: Sequence[float],
    force: float = 1.0,
    dwell: int = 20,
    *,
    start: TimeStart | None = None,
    steps_per_period: int = 1000,
    method: Method = DEFAULT_METHOD,
) -> SteppedSine:
    """Integrate M q̈ + C q̇ + K q + Bᵀ f(B q) = p(t) over `dwell` periods at each of the frequencies, Hz, in their order,
    which may go up and down.

    The force has the same phase at the beginning of each dwell as at the end of the one before; motion, velocity and sliders go
    on. start: the state at t = 0, from rest with the sliders at their start rules unless given, for example the `end` of another
    test: the contacts of a second sweep are then as the first one left them. A dwell of about 1/ζ periods, ζ the damping ratio,
    leaves 2e-3 of a transient. Raises `InputError` where a step has no solution or the motion grows without bound.
    """
    of_kind("problem", problem, Problem)
    if isinstance(frequencies, Band):
        remedy = f"Such as numpy.linspace({frequencies.start:g}, {frequencies.stop:g}, 20)."
        raise fault("frequencies", "must be a list of frequencies in Hz, in the order of the test", frequencies, remedy)
    wanted, (level,) = followed(frequencies), force_levels([force])
    settings = March(steps_per_period, method, NEVER, between("dwell", dwell, 2))
    state = from_rest(problem) if start is None else of_kind("start", start, TimeStart)
    sizes = [values.shape for values in vars(from_rest(problem)).values()]
    if [np.shape(values) for values in vars(state).values()] != sizes:
        raise fault(
            "start", f"must have motion, velocity and intercepts of shapes {sizes}", "others", "Take that of this problem."
        )
    cycles: list[TimeCycle] = []
    for frequency in wanted:
        cycle = march(problem, 2.0 * np.pi * positive("A frequency", frequency), level, state, settings)
        if cycle.outcome in (MarchOutcome.STEP_FAILED, MarchOutcome.UNBOUNDED):
            raise InputError(f"The dwell at {frequency:g} Hz must have a motion. {cycle.sentence}")
        cycles.append(cycle)
        state = cycle.end
    return SteppedSine(_dataset(problem, wanted, cycles, level, dwell), problem, state)


def _dataset(problem: Problem, frequencies: Sequence[float], cycles: Sequence[TimeCycle], level: float, dwell: int) -> xr.Dataset:
    import xarray as xr

    def named(dims: tuple[str, ...], values: Any, units: str, words: str) -> tuple[Any, ...]:
        return dims, values, {"units": units, "long_name": words}

    first: Array = np.array([np.abs(harmonics_of(cycle.outputs, 1)[:, 1]) for cycle in cycles])
    largest = np.array([np.max(np.abs(cycle.outputs), axis=1) for cycle in cycles])
    data = {
        "amplitude": named(("step", "output"), first, "m", "first harmonic of the last period of the dwell"),
        "max_abs": named(("step", "output"), largest, "m", "largest absolute value in the last period of the dwell"),
        "distance": named(("step",), [cycle.distance for cycle in cycles], "1", "estimated distance from the steady motion"),
    }
    coords = {
        "frequency": named(("step",), list(frequencies), "Hz", "frequency of the dwell"),
        "output": named(("output",), list(problem.output_names), "1", "output"),
    }
    return xr.Dataset(data, coords, {"title": problem.heading, "force_level": level, "dwell": dwell})
