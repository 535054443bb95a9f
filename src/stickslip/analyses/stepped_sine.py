"""Stepped sine in time: the excitation dwells at one frequency after the other, and the motion goes on from each to the next.

What a laboratory records is then not the steady motion, but what is left after the dwell, with the contacts as they were before.
"""

import time
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from typing import Annotated, Any

import numpy as np

from stickslip.analyses.forced_response import ForcedResponse
from stickslip.analyses.settings import OfKind, OfProblem, Setting, Settings, Whole, takes
from stickslip.analyses.time_response import harmonics_of
from stickslip.model.problem import Problem
from stickslip.results.files import SavedResult
from stickslip.results.schema import described, tabulated
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.time.march import March, MarchOutcome, TimeStart, checked_start, from_rest, march
from stickslip.solve.time.period import DEFAULT_METHOD, Method, refuse_waves
from stickslip.support.checks import InputError, fault, of_kind, positive
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band, followed

NEVER = 1e-30
"""Tolerance of periodicity that no motion reaches: each dwell has all of its periods."""


@dataclass(frozen=True, eq=False, repr=False)
class SteppedSine(SavedResult):
    """`dataset`, along `step`: frequency [Hz]; of the last period of each dwell, amplitude [m] of the first harmonic and max_abs
    [m] (step, output), and distance (step,), the estimated relative distance from the steady motion; with a harmonic balance
    (`with_response`), its balance_amplitude [m] (step, output). `end`: the state after the last dwell, from which another test
    or a free decay can start."""

    dataset: "xr.Dataset"
    problem: Problem
    end: TimeStart

    def with_response(self, response: ForcedResponse) -> "SteppedSine":
        """A copy that also holds the steady response by harmonic balance, for comparison in the figure. The response must have
        the same problem, force level and frequencies, in the same order. NaN where the balance has no solution."""
        of_kind("response", response, ForcedResponse)
        if response.problem.fingerprint != self.problem.fingerprint:
            raise InputError("The response must be that of the problem of the stepped sine, but is that of another problem.")
        return replace(self, dataset=beside_balance(self.dataset, response.dataset))


def _in_order(name: str, frequencies: Any) -> list[float]:
    if isinstance(frequencies, Band):
        remedy = f"Such as numpy.linspace({frequencies.start:g}, {frequencies.stop:g}, 20)."
        raise fault("frequencies", "must be a list of frequencies in Hz, in the order of the test", frequencies, remedy)
    return followed(frequencies)


@dataclass(frozen=True, eq=False)
class SteppedSineWork(Settings):
    """A stepped sine as one case."""

    problem: OfProblem
    frequencies: Annotated[Sequence[float], Setting(_in_order)]
    force: Annotated[float, Setting(positive, "force level, a factor on every harmonic force")] = 1.0
    dwell: Annotated[
        int, Setting(Whole(2), "periods at each frequency; after 1/ζ periods, ζ the damping ratio, 2e-3 of the transient is left")
    ] = 20
    _: KW_ONLY
    start: Annotated[TimeStart | None, Setting(OfKind(TimeStart))] = None
    steps_per_period: Annotated[int, Setting(Whole(8), "time steps per period")] = 1000
    method: Method = DEFAULT_METHOD

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_waves(self.problem)
        _ = self._march
        if self.start is not None:
            checked_start(self.problem, self.start)

    @property
    def _march(self) -> March:
        return March(self.steps_per_period, self.method, NEVER, self.dwell)

    @property
    def words(self) -> tuple[str, ...]:
        return ("stepped sine",)

    def solve(self, case: int, report: Report) -> Arrays:
        """Along the frequencies what is left of each dwell, and the state at the end."""
        started, state = time.process_time(), from_rest(self.problem) if self.start is None else self.start
        first, largest, distance = [], [], []
        for k, frequency in enumerate(self.frequencies):
            report(k / len(self.frequencies))
            cycle = march(self.problem, 2.0 * np.pi * frequency, self.force, state, self._march)
            if cycle.outcome in (MarchOutcome.STEP_FAILED, MarchOutcome.UNBOUNDED):
                raise InputError(f"The dwell at {frequency:g} Hz could not be computed. {cycle.sentence}")
            first.append(np.abs(harmonics_of(cycle.outputs, 1)[:, 1]))
            largest.append(np.max(np.abs(cycle.outputs), axis=1))
            distance.append(cycle.distance)
            state = cycle.end
        marched = {"amplitude": first, "max_abs": largest, "distance": distance, "cpu_seconds": time.process_time() - started}
        return {name: np.array(values) for name, values in marched.items()} | vars(state)

    def gathered(self, results: Sequence[Arrays]) -> "SteppedSine":
        """The stepped sine of the only case."""
        end = TimeStart(**{each.name: results[0][each.name] for each in fields(TimeStart)})
        return SteppedSine(_dataset(self, results[0]), self.problem, end)


@takes(SteppedSineWork)
def stepped_sine(work: SteppedSineWork) -> "SteppedSine":
    """Integrate M q̈ + C q̇ + K q + Bᵀ f(B q) = p(t) over `dwell` periods at each of the frequencies, Hz, in their order,
    which may go up and down.

    The force has the same phase at the beginning of each dwell as at the end of the one before; motion, velocity and sliders go
    on. start: the state at t = 0, from rest with the sliders at their start rules unless given, for example the `end` of another
    test: the contacts of a second sweep are then as the first one left them. A dwell of about 1/ζ periods, ζ the damping ratio,
    leaves 2e-3 of a transient. Raises `InputError` where a step has no solution or the motion grows without bound.
    """
    return work.gathered(all_cases(work))


def beside_balance(dataset: "xr.Dataset", response: "xr.Dataset") -> "xr.Dataset":
    """The dataset of a stepped sine with the amplitudes of a forced response at its frequencies and force level."""
    order, level = dataset["frequency"].values, float(dataset.attrs["force_level"])
    solved = response.isel(case=0)
    converged = solved["outcome"].values == Outcome.CONVERGED
    steady = np.full((order.size, response.sizes["output"]), np.nan)
    if response.sizes["case"] != 1 or float(solved["force_level"]) != level:
        raise InputError(f"The response must be at the force level {level:g} of the stepped sine alone, but is at others.")
    if converged.any():
        if not np.array_equal(solved["frequency"].values, order):
            raise InputError("The response must be at the frequencies of the stepped sine, in the same order, but is not.")
        steady[converged] = solved["amplitude"].values[converged]
    beside = {"balance_amplitude": steady, "balance_message": str(solved["case_message"].values)}
    return dataset.assign(described("stepped_sine", beside))


def _dataset(work: SteppedSineWork, arrays: Arrays) -> "xr.Dataset":
    data = {name: arrays[name] for name in ("amplitude", "max_abs", "distance")}
    coords = {"frequency": work.frequencies, "output": list(work.problem.output_names)}
    attrs = {"title": work.problem.heading, "force_level": work.force, "dwell": work.dwell}
    about = {"steps_per_period": work.steps_per_period, "method": repr(work.method), "cpu_seconds": float(arrays["cpu_seconds"])}
    return tabulated("stepped_sine", data, coords, attrs | about)
