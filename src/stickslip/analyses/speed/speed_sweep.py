"""Speed sweep: forced response over the rotor speed, excited by engine orders, stiffness and pulls going with the speed.

Run-up and run-down in time: the motion integrated while the rotor speed changes at a finite rate.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from math import lcm
from typing import Annotated, Any

import numpy as np

from stickslip.analyses.forced_response import ForcedResponse, ForcedResponseWork
from stickslip.analyses.response_dataset import levels_are_newtons
from stickslip.analyses.settings import (
    Execution,
    Fineness,
    ForcedResponseSettings,
    ForceLevels,
    Setting,
    Settings,
    StateOfFields,
    Whole,
    force_levels,
    takes,
)
from stickslip.analyses.speed.campbell import engine_orders_of
from stickslip.analyses.speed.models import synchronous
from stickslip.analyses.time_response import harmonics_of
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.results.quantities import ERRORS
from stickslip.results.schema import Result, named, stacked, tabulated
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.balance.fourier import MOST_SAMPLES
from stickslip.solve.time.march import March, MarchOutcome, TimeStart, from_rest, loads_of_steps, march, no_history, state_at
from stickslip.solve.time.period import DEFAULT_METHOD, Method, march_period, refuse_waves, settle, time_model
from stickslip.support.checks import MOST, Array, InputError, between, fault, of_kind, positive, vector
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band

GRID = 1001
"""Speeds of the envelope."""

PEAK = ("peak_speed", "peak_frequency", "peak_amplitude", "peak_max_abs", "peak_loss_factor")


@dataclass(frozen=True, eq=False, repr=False)
class SpeedSweep(Result):
    """Curves over the rotor speed, one for each engine order and force level.

    dataset, axes (engine_order, case, ...): speed [rev/min], frequency [Hz], outcome (…, point), amplitude (…, point, output) [m]
    of the first harmonic, loss_factor; peak_speed, peak_frequency, peak_amplitude and others (…, peak, output), highest first;
    free_amplitude, stuck_amplitude (…, linear_point, output) over linear_speed; envelope (case, envelope_speed, output): the
    largest of all engine orders. responses: the `ForcedResponse` of each engine order, whose frequencies stand for speeds.
    """

    dataset: xr.Dataset
    responses: Mapping[int, ForcedResponse]

    def peaks(self) -> pd.DataFrame:
        """All peaks: engine order, force level, output, speed [rev/min], frequency [Hz], amplitude and largest value in time
        [m], loss factor."""
        return peak_table(self.dataset)

    def with_stability(self, highest: float | None = None) -> SpeedSweep:
        """A copy whose dataset says which points are stable, as `ForcedResponse.with_stability` does; at constant speed each."""
        return _joined({order: response.with_stability(highest) for order, response in self.responses.items()})


def _ends(name: str, speed: Any) -> tuple[float, float]:
    first, last = (float(value) for value in vector(name, speed, 2))
    if min(first, last) <= 0.0 or first == last:
        raise fault(name, "must be (first, last) in rev/min, positive and different", (first, last))
    return first, last


def _with_speed(name: str, models: Any) -> Problem:
    problem = models if isinstance(models, Problem) else synchronous(models)
    if problem.speed is None:
        raise InputError("The problem must have `speed`, or be given as {speed in rev/min: problem} at two speeds.")
    return problem


@dataclass(frozen=True, eq=False)
class OverSpeed(Settings):
    """A problem that depends on the rotor speed, the range of that in rev/min, and engine orders."""

    models: Annotated[Problem | Mapping[float, Problem], Setting(_with_speed)]
    speed: Annotated[tuple[float, float], Setting(_ends)]
    engine_orders: Annotated[int | Sequence[int] | None, Setting(engine_orders_of)] = None


@dataclass(frozen=True, eq=False)
class SpeedSweepSettings(Fineness, OverSpeed, Execution):
    """The arguments of `speed_sweep`."""


@takes(SpeedSweepSettings)
def speed_sweep(settings: SpeedSweepSettings) -> SpeedSweep:
    """Steady response to engine orders EO over the rotor speed Ω, ω = EO Ω, by harmonic balance.

    M q̈ + C q̇ + (K₀ + Ω² K₁) q + Bᵀ f(B q) = p₀ + Ω² p₁ + p(EO Ω t), with exact derivatives by Ω, followed through folds.
    models: {speed in rev/min: problem} at two speeds, which differ in stiffness and static loads; K₁ and p₁ follow from them. Or
    a problem with `speed` (`SpeedDependence`). speed: (first, last), rev/min, swept in this order. engine_orders: several have
    one curve each; a tuned disk meets the nodal diameter of each. force: levels that multiply every harmonic force.
    harmonics, samples, tolerance, peak_tolerance, workers, checkpoint, progress: as for `forced_response`. Damping is that of the
    model of the lowest speed, M and contacts are the same at all speeds. Coriolis terms are neglected.
    """
    settings.progress(0.0, "preparing")
    work = SpeedSweepWork.of(settings)
    return work.gathered(all_cases(work, settings.checkpoint, settings.workers, settings.progress))


@dataclass(frozen=True, eq=False)
class SpeedSweepWork(StateOfFields):
    """The force levels of all engine orders as independent cases, one engine order after the other."""

    parts: tuple[ForcedResponseWork, ...]

    @classmethod
    def of(cls, settings: SpeedSweepSettings) -> SpeedSweepWork:
        """The work of settings."""
        problem = of_kind("models", settings.models, Problem)
        assert problem.speed is not None
        orders = engine_orders_of("engine_orders", settings.engine_orders or problem.speed.engine_order)
        fineness = settings.fineness | {"samples": samples_for(problem, orders, settings.samples)}
        bands = [Band(*(order * end / 60.0 for end in settings.speed)) for order in orders]
        parts = [
            ForcedResponseWork.of(ForcedResponseSettings(excited(problem, order), band, **fineness, isolated=False))
            for order, band in zip(orders, bands, strict=True)
        ]
        return cls(tuple(parts))

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"engine order {_order(part.problem)}, {name}" for part in self.parts for name in part.names)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"engine order {_order(part.problem)}, {words}" for part in self.parts for words in part.words)

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk."""
        self.parts[0].prepare()

    def solve(self, case: int, report: Report) -> Arrays:
        """The curve of one engine order and force level."""
        part, own = divmod(case, len(self.parts[0].levels))
        return self.parts[part].solve(own, report)

    def gathered(self, results: Sequence[Arrays]) -> SpeedSweep:
        """The sweep of all curves."""
        count = len(self.parts[0].levels)
        return _joined(
            {_order(part.problem): part.gathered(results[k * count : (k + 1) * count]) for k, part in enumerate(self.parts)}
        )


def excited(problem: Problem, order: int) -> Problem:
    """The problem under an engine order; of a tuned disk its pattern too."""
    assert problem.speed is not None
    under = replace(problem, speed=replace(problem.speed, engine_order=order))
    if not isinstance(under, TunedDisk):
        return under
    return under.with_engine_order(order % under.sectors)


def samples_for(problem: Problem, orders: Sequence[int], samples: int) -> int:
    """The number of samples that all engine orders share: the next one with which the delays between sectors are whole."""
    given = between("samples", samples, 1, MOST_SAMPLES)
    return given + -given % lcm(*(excited(problem, order).systems.sample_multiple for order in orders))


def _order(problem: Problem) -> int:
    assert problem.speed is not None
    return problem.speed.engine_order


def _joined(responses: Mapping[int, ForcedResponse]) -> SpeedSweep:
    """The curves of all engine orders over the speed."""
    orders = list(responses)
    parts = [_over_speed(response.dataset, order) for order, response in responses.items()]
    longest = {dim: max(part.sizes[dim] for part in parts) for dim in ("point", "peak", "linear_point")}
    padded = [part.pad({dim: (0, size - part.sizes[dim]) for dim, size in longest.items()}) for part in parts]
    about = {"units": "1", "long_name": "engine order of the excitation"}
    axis = xr.DataArray(orders, dims="engine_order", name="engine_order", attrs=about)
    joined = xr.concat(padded, axis, combine_attrs="drop_conflicts")
    joined["outcome"] = joined["outcome"].fillna(0).astype(np.int8)
    if "stability" in joined:
        joined["stability"] = joined["stability"].fillna(0).astype(np.int8)
    first, problem = next((response.dataset, response.problem) for response in responses.values())
    kept = ("study", "harmonics", "samples", "stickslip_version", "file_format")
    attrs = {"title": problem.title} | {name: first.attrs[name] for name in kept}
    attrs |= {"cpu_seconds": sum(response.dataset.attrs["cpu_seconds"] for response in responses.values())}
    speeds, values = _envelope(joined)
    joined = joined.assign_coords(envelope_speed=named("envelope_speed", speeds, "rotor speed", "rev/min"))
    joined["envelope"] = named(("case", "envelope_speed", "output"), values, "largest amplitude of all engine orders", "m")
    return SpeedSweep(joined.assign_attrs(attrs | {"analysis": "speed_sweep"}), responses)


def _over_speed(dataset: xr.Dataset, order: int) -> xr.Dataset:
    """What a sweep keeps of a response, with speeds beside its frequencies."""
    kept = ["frequency", "outcome", "amplitude", "loss_factor", "peak_frequency", "peak_amplitude", "peak_max_abs"]
    kept += ["peak_loss_factor", "linear_frequency", "free_amplitude", "stuck_amplitude", "case_outcome", "case_message"]
    kept += [name for name in ("stability", "multiplier", "peak_stability", *ERRORS) if name in dataset]
    part = dataset[kept]
    part = part.rename({dataset["linear_frequency"].dims[0]: "linear_point"}) if "linear_point" not in part.dims else part
    part = part.reset_coords([name for name in ("frequency", "linear_frequency") if name in part.coords])
    for name, frequency in (("speed", "frequency"), ("peak_speed", "peak_frequency"), ("linear_speed", "linear_frequency")):
        part[name] = named(part[frequency].dims, 60.0 / order * part[frequency].values, "rotor speed", "rev/min")
    return part


def _envelope(joined: xr.Dataset) -> tuple[Array, Array]:
    """The largest amplitude of all engine orders at speeds of a grid that holds all peaks, (case, speed, output)."""
    speed, amplitude = joined["speed"].values, joined["amplitude"].values
    tops = joined["peak_speed"].values
    ends = np.nanmin(joined["linear_speed"].values), np.nanmax(joined["linear_speed"].values)
    grid = np.unique(np.concatenate([np.linspace(*ends, GRID), tops[np.isfinite(tops)]]))
    found = np.full((speed.shape[1], grid.size, amplitude.shape[-1]), np.nan)
    for e, case in np.ndindex(speed.shape[:2]):
        solved = joined["outcome"].values[e, case] == Outcome.CONVERGED
        at, sizes = speed[e, case, solved], amplitude[e, case, solved]
        for k in range(at.size - 1):
            low, high = sorted((at[k], at[k + 1]))
            inside = np.flatnonzero((grid >= low) & (grid <= high))
            share = (grid[inside] - at[k]) / (at[k + 1] - at[k]) if high > low else np.ones(inside.size)
            values = sizes[k] + share[:, None] * (sizes[k + 1] - sizes[k])
            found[case, inside] = np.fmax(found[case, inside], values)
    return grid, found


def peak_table(dataset: xr.Dataset) -> pd.DataFrame:
    """The peaks of a sweep, highest first."""
    table = dataset[list(PEAK)].to_dataframe().reset_index().dropna(subset=["peak_frequency"])
    table = table.rename(columns={name: name.removeprefix("peak_") for name in PEAK})
    table["force_level"] = dataset["force_level"].values[table["case"]]
    columns = ["engine_order", "force_level", "output", "speed", "frequency", "amplitude", "max_abs", "loss_factor"]
    return table.sort_values(["force_level", "output", "amplitude"], ascending=[True, True, False], ignore_index=True)[columns]


FEWEST = 4
"""Cycles of the excitation that a run must hold."""
STEADY = 1e-4
"""Relative distance from the steady motion at which a run begins."""


RUN = ("time", "speed", "frequency", "amplitude", "max_abs")
"""What a run has of each cycle."""


@dataclass(frozen=True, eq=False, repr=False)
class RunUp(Result):
    """`dataset`, axes case, a run for each engine order and force level (`engine_order`, `force_level`), and cycle, the cycles of
    the excitation one by one: time [s], speed [rev/min] and frequency [Hz] at the middle of the cycle; amplitude (case, cycle,
    output) of the first harmonic of a cycle [m], max_abs (case, cycle, output) [m]; NaN behind the last cycle of a run. outcome
    and message (case,) say how the integration ended."""

    dataset: xr.Dataset
    problem: Problem


@dataclass(frozen=True, eq=False)
class RunUpWork(Execution):
    """The arguments of `run_up`; a case is a run of one engine order and force level, one engine order after the other."""

    models: Annotated[Problem | Mapping[float, Problem], Setting(_with_speed)]
    speed: Annotated[tuple[float, float], Setting(_ends)]
    duration: Annotated[float, Setting(positive, "time in which the speed changes from the first to the last value, s")]
    engine_orders: Annotated[int | Sequence[int] | None, Setting(engine_orders_of)] = None
    force: ForceLevels = 1.0
    _: KW_ONLY
    steps_per_period: Annotated[int, Setting(Whole(8, MOST_SAMPLES), "time steps per cycle of the excitation")] = 200
    method: Method = DEFAULT_METHOD
    start_periods: Annotated[
        int, Setting(Whole(2, MOST), "most periods from rest to the steady motion at the first speed, which begins a run")
    ] = 1000

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_waves(self.problem.at_speed(2.0 * np.pi / 60.0 * self.speed[0]))
        for order, _ in self.places:
            self._course(order)

    @property
    def problem(self) -> Problem:
        """That whose speed changes."""
        assert isinstance(self.models, Problem)
        return self.models

    @property
    def places(self) -> list[tuple[int, float]]:
        """Engine order and force level of each case."""
        orders = engine_orders_of("engine_orders", self.engine_orders or _order(self.problem))
        return [(order, level) for order in orders for level in force_levels(self.force)]

    @property
    def words(self) -> list[str]:
        return [f"engine order {order}, force level {level:g}" for order, level in self.places]

    def _course(self, order: int) -> tuple[float, float, Array]:
        """Angular frequency of an engine order at the beginning of a run, its rate, rad/s², and the ends of its cycles, s."""
        ends = 2.0 * np.pi / 60.0 * order * np.array(self.speed)
        rate = float(ends[1] - ends[0]) / self.duration
        cycles = int((ends.mean() * self.duration) // (2.0 * np.pi))
        if cycles < FEWEST:
            found = f"{self.duration:g} s, {cycles} cycles"
            raise fault("duration", f"must hold {FEWEST} cycles of the excitation at least", found)
        # ω t + ½ rate t² = 2π k, k = 0..cycles, solved so that it is exact where the rate is small, too.
        angles = 2.0 * np.pi * np.arange(cycles + 1)
        return float(ends[0]), rate, 2.0 * angles / (ends[0] + np.sqrt(ends[0] ** 2 + 2.0 * rate * angles))

    def solve(self, case: int, report: Report) -> Arrays:
        """One run, from the steady motion at its first speed."""
        order, level = self.places[case]
        problem, (first, rate, times) = excited(self.problem, order), self._course(order)
        settings, begin = March(self.steps_per_period, self.method, STEADY, self.start_periods), problem.at_frequency(first)
        steady = march(begin, first, level, from_rest(begin), settings)
        if steady.outcome in (MarchOutcome.STEP_FAILED, MarchOutcome.UNBOUNDED):
            where = f"at {self.speed[0]:g} rev/min, but found none. {steady.sentence}"
            raise InputError(f"The run must begin with a steady motion {where}")
        rows: list[tuple[Array, Array]] = []
        with one_blas_thread():
            for row in _marched(problem, first, rate, times, level, steady.end, settings):
                report(len(rows) / times.size)
                rows.append(row)
        count, outputs = len(rows), len(problem.output_names)
        complete = count == times.size - 1
        message = "Complete." if complete else f"No step was found in cycle {count + 1}: take more steps per period."
        if steady.outcome != MarchOutcome.PERIODIC:
            message += f" The motion that it begins with was not yet steady. {steady.sentence}"
        middle = 0.5 * (times[1 : count + 1] + times[:count])
        hertz = (first + rate * middle) / (2.0 * np.pi)
        sizes = (np.abs(np.reshape([row[k] for row in rows], (count, outputs))) for k in range(2))
        values = dict(zip(RUN, (middle, 60.0 / order * hertz, hertz, *sizes), strict=True))
        return values | {"outcome": np.array("complete" if complete else "step_failed"), "message": np.array(message)}

    def gathered(self, results: Sequence[Arrays]) -> RunUp:
        """All runs side by side."""
        data = {name: stacked([arrays[name] for arrays in results]) for name in RUN}
        data |= {name: np.array([str(arrays[name]) for arrays in results]) for name in ("outcome", "message")}
        orders, levels = zip(*self.places, strict=True)
        cycles, outputs = np.arange(1, data["time"].shape[1] + 1), list(self.problem.output_names)
        coords = {"engine_order": list(orders), "output": outputs, "cycle": cycles, "force_level": list(levels)}
        newtons = "N" if levels_are_newtons(self.problem) else "1"
        attrs = {"title": self.problem.heading, "duration": self.duration, "steps_per_period": self.steps_per_period}
        return RunUp(tabulated("run_up", data, coords, attrs, newtons), self.problem)


@takes(RunUpWork)
def run_up(settings: RunUpWork) -> RunUp:
    """Integrate the motion while the rotor speed changes evenly from `speed[0]` to `speed[1]`, rev/min, within `duration`, s.

    The phase of the excitation is EO ∫Ω dt. models: as of `speed_sweep`. engine_orders: default that of the problem's `speed`;
    one run for each of these and each force level. A first speed above the last one gives a run-down. A run begins with the
    steady motion of the first speed, marched from rest for `start_periods` at most. steps_per_period: steps of each cycle of the
    excitation; stiffness and constant loads are those of the speed at its middle. Vibration that grows without bound, or a step
    without solution, ends the run (`message`). One sector of a tuned disk has no equation of motion in time: take `disk.full()`.
    workers, checkpoint, progress: as for `forced_response`.
    """
    return settings.gathered(all_cases(settings, settings.checkpoint, settings.workers, settings.progress))


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
