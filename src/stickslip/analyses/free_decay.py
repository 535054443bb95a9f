"""Free decay in time: the motion after a release or an impact, and its frequency and damping from one half cycle to the next."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Annotated, Any

import numpy as np

from stickslip.analyses.controlled_response import PhaseResonance
from stickslip.analyses.modes.nonlinear_modes import NonlinearModes
from stickslip.analyses.response_dataset import ContactRows, labels_of
from stickslip.analyses.settings import OfProblem, Setting, Settings, Whole, takes
from stickslip.analyses.time_response import time_response
from stickslip.model.problem import Problem
from stickslip.results.files import SavedResult
from stickslip.results.schema import named, tabulated
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import quantity_named
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.time.march import TimeStart, checked_start, from_harmonics, from_rest, no_history, state_at
from stickslip.solve.time.period import DEFAULT_METHOD, Loads, Method, march_period, refuse_waves, settle, time_model
from stickslip.support.checks import Array, InputError, fault, finite, of_kind, positive
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread

MOST_STEPS = 10_000_000
"""More would fill the memory with histories."""

STEADY = 21
"""Harmonics of the steady motion from which its time integration starts."""

SETTLING, CLOSE = 10, 1e-5
"""Periods of it, and the relative change in the last one up to which it is steady; from rest a lightly damped motion would take
thousands."""

FEWEST = 6
"""Steps of a half cycle, below which its amplitude and frequency would be those of the steps."""

SMALLEST = 1e-3
"""Share of the largest swing of an output below which a swing is not listed."""


@dataclass(frozen=True, eq=False, repr=False)
class FreeDecay(SavedResult):
    """`dataset`, with time [s], the motion of the outputs (output, time) [m], motions and forces of the contacts (contact,
    direction, time) [m, N], friction work (contact,) and viscous work [J].

    For each output and each half cycle from one turning point to the next (output, half_cycle), NaN after the last:
    turning_time [s] and turning_point [m] at its beginning; amplitude [m], half the distance to the next; frequency [Hz],
    1/(2 Δt); damping_ratio ζ from the logarithmic decrement δ = ln(A_k/A_{k+1}) = πζ/√(1 − ζ²) of the amplitudes at its two ends,
    A_k = (a_{k−1} + a_k)/2, exact for viscous damping and for rigid friction; NaN for the first and the last half cycle, which
    have only one neighbour.
    Of nonlinear modes beside it (`with_modes`): mode_amplitude [m] and mode_damping_ratio (mode, mode_point, output), that of a
    free decay along the mode, mode_frequency [Hz] (mode, mode_point), and mode_message (mode,). Of a phase resonance test
    (`with_phase_resonance`): resonance_amplitude [m] and resonance_frequency [Hz].
    """

    dataset: xr.Dataset
    problem: Problem

    def with_modes(self, modes: NonlinearModes) -> FreeDecay:
        """A copy that holds nonlinear modes of the problem too, for its figure."""
        of_kind("modes", modes, NonlinearModes)
        if modes.problem.fingerprint != self.problem.fingerprint:
            raise InputError("The modes must be those of the problem that decays, but are of another one.")
        return replace(self, dataset=beside_modes(self.dataset, modes.with_decays().dataset))

    def with_phase_resonance(self, test: PhaseResonance) -> FreeDecay:
        """A copy that holds the frequencies of a phase resonance test too, for its figure."""
        of_kind("test", test, PhaseResonance)
        held, first = str(test.dataset.attrs["output_held"]), self.problem.output_names[0]
        if test.problem.fingerprint != self.problem.fingerprint or held != first:
            raise InputError(f"The test must hold the first output, {first}, of the problem that decays, but is another one.")
        return replace(self, dataset=beside_phase_resonance(self.dataset, test.dataset))


Motions = Mapping[str, float]


def _motions(name: str, given: Any) -> dict[str, float]:
    return {dof: finite(name, value) for dof, value in of_kind(name, given, dict).items()}


@dataclass(frozen=True, eq=False)
class FreeDecayWork(Settings):
    """A free decay as one case."""

    problem: OfProblem
    duration: Annotated[float, Setting(positive)]
    displacement: Annotated[Motions | None, Setting(_motions)] = None
    velocity: Annotated[Motions | None, Setting(_motions)] = None
    _: KW_ONLY
    start: TimeStart | None = None
    frequency: Annotated[float | None, Setting(positive)] = None
    force: Annotated[float, Setting(positive)] = 1.0
    steps: Annotated[int, Setting(Whole(8, MOST_STEPS))] = 20_000
    method: Method = DEFAULT_METHOD

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_waves(self.problem)
        given = (self.start is not None, self.frequency is not None, self.displacement is not None or self.velocity is not None)
        if sum(given) > 1:
            both = [name for name, one in zip(("start", "frequency", "displacement or velocity"), given, strict=True) if one]
            raise InputError(
                f"{' and '.join(both)} must not be given together, but are: a decay has only one start state. Give one of them."
            )
        if self.frequency is None and self.force != 1.0:
            remedy = "A released motion has no force level: scale displacement and velocity."
            raise fault("force", "needs frequency, the steady motion before the decay", self.force, remedy)
        if not isinstance(self.method, Method):
            raise fault("method", "must be a GeneralisedAlpha or a Newmark", self.method)
        if self.start is not None:
            checked_start(self.problem, self.start)
        elif self.frequency is None:
            _at(self.problem, self.displacement or {}, self.velocity or {})

    @property
    def words(self) -> tuple[str, ...]:
        return ("free decay",)

    def _begin(self) -> TimeStart:
        """The state at t = 0."""
        if self.start is not None:
            return self.start
        if self.frequency is None:
            return _at(self.problem, self.displacement or {}, self.velocity or {})
        if (begin := self._near_steady(self.frequency)) is not None:
            steady = time_response(self.problem, self.frequency, self.force, periods=SETTLING, start=begin)
            if steady.cycle.change <= CLOSE:
                return steady.cycle.end
        steady = time_response(self.problem, self.frequency, self.force)
        if not steady.periodic:
            raise InputError(f"The motion at {self.frequency:g} Hz must be steady before it decays. {steady.sentence}")
        return steady.cycle.end

    def _near_steady(self, frequency: float) -> TimeStart | None:
        """The steady motion by harmonic balance, from which few periods are left to march; None where it finds none."""
        balance = HarmonicBalance(self.problem, STEADY, 16 * STEADY)
        omega = 2.0 * np.pi * frequency
        found = first_point(balance, omega, self.force)
        return from_harmonics(balance, found.evaluation.point.forces, omega, self.force) if found.converged else None

    def solve(self, case: int, report: Report) -> Arrays:
        """Outputs, motions and forces of the contacts over the time, and the energies."""
        started = time.process_time()
        begin, model, step = self._begin(), time_model(self.problem), self.duration / self.steps
        with one_blas_thread():
            matrices = model.step_matrices(self.method.coefficients, step)
            static = model.shapes.T @ self.problem.static_load
            loads = Loads(static, np.zeros((model.mass.size, 1)), np.zeros((self.steps, 1)))
            state, history = state_at(model, begin), no_history(model, self.steps)
            settle(model.table, matrices, loads, state)
            first = matrices.outputs @ state.motion, state.contacts.w.copy(), state.contacts.forces.copy()
            work = march_period(model.table, matrices, loads, state, history)
        if work.failed >= 0:
            raise InputError(f"Newton's method did not find a solution for step {work.failed} of {self.steps}. Take more steps.")
        first = first[0], first[1], first[2] + matrices.stiffness * first[1]
        outputs, motion, force = (
            np.column_stack([begun, signals[:, 1:], signals[:, 0]])
            for begun, signals in zip(first, (history.outputs, history.contact_motion, history.contact_force), strict=True)
        )
        if not np.all(np.isfinite(outputs)):
            raise InputError(
                "The motion grows without bound: the structure is unstable, or the steps are too long. Take more steps."
            )
        found = {"outputs": outputs, "motion": motion, "force": force, "friction_work": history.friction_work}
        found |= {"viscous_work": np.array(work.viscous), "cpu_seconds": np.array(time.process_time() - started)}
        return found

    def gathered(self, results: Sequence[Arrays]) -> FreeDecay:
        """The decay of the only case."""
        return FreeDecay(_dataset(self, results[0]), self.problem)


@takes(FreeDecayWork)
def free_decay(work: FreeDecayWork) -> FreeDecay:
    """Integrate M q̈ + C q̇ + K q + Bᵀ f(B q) = p_static for `duration`, s, without excitation.

    displacement [m] and velocity [m/s] at t = 0 are given by degree of freedom, as {"tip.y": 1e-3}; all others are 0. The sliders
    begin where their start rules put them, and contacts slip while the structure is displaced to the position of its release.
    frequency [Hz], force: the steady motion at this frequency and force level instead, after which the excitation stops.
    start: any state at t = 0 instead, for example `time_response(...).cycle.end`, with the sliders
    where they are there. steps: number of steps of the whole duration; take hundreds for each cycle of the fastest motion of
    interest. With thousands per cycle the motion agrees with an integration from event to event within 1e-4.
    """
    return work.gathered(all_cases(work))


def beside_modes(dataset: xr.Dataset, modes: xr.Dataset) -> xr.Dataset:
    """The dataset of a decay with the curves of nonlinear modes `with_decays` (case, point), their swing and damping as a decay
    shows them."""
    axes = ("mode", "mode_point")
    found = {
        "mode_amplitude": named((*axes, "output"), modes["swing"].values, "amplitude of the nonlinear mode", "m"),
        "mode_frequency": named(axes, modes["frequency"].values, "frequency of the nonlinear mode", "Hz"),
        "mode_damping_ratio": named((*axes, "output"), modes["decay_damping_ratio"].values, "damping ratio of a decay along it"),
        "mode_message": named(("mode",), modes["decay_message"].values, "where a decay is not one of the mode"),
    }
    numbers = named(("mode",), modes["mode_number"].values, "number of the stuck mode")
    return dataset.assign(found).assign_coords(mode=numbers)


def beside_phase_resonance(dataset: xr.Dataset, test: xr.Dataset) -> xr.Dataset:
    """The dataset of a decay with the frequencies of a phase resonance test over the amplitude of the displacement."""
    frequency = test["frequency"].values
    size = test["amplitude"].values / (2.0 * np.pi * frequency) ** quantity_named(str(test.attrs["quantity"]))[0].order
    return dataset.assign(
        resonance_amplitude=named("resonance", size, "displacement where force and displacement are at 90°", "m"),
        resonance_frequency=named("resonance", frequency, "frequency where force and displacement are at 90°", "Hz"),
    )


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
    most, so that the first difference is at most half of the second. Ripples of less than `SMALLEST` of the largest swing, such
    as a motion has at its end, are left out.
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
    smallest = SMALLEST * np.abs(np.diff(values)).max(initial=0.0)
    listed: list[int] = []
    for number, value in enumerate(values.tolist()):
        if len(listed) > 1 and (value - values[listed[-1]]) * (values[listed[-1]] - values[listed[-2]]) > 0.0:
            listed[-1] = number
        elif not listed or abs(value - values[listed[-1]]) >= smallest:
            listed.append(number)
    return times[listed], values[listed]


def half_cycles(times: Array, values: Array) -> tuple[Array, Array, Array]:
    """Amplitude, frequency [Hz] and damping ratio of the half cycles between turning points; the first and the last have no
    damping ratio."""
    amplitude = 0.5 * np.abs(np.diff(values))
    decrement = np.full(amplitude.size, np.nan)
    if amplitude.size > 2:
        ends = 0.5 * (amplitude[:-1] + amplitude[1:])
        decrement[1:-1] = np.log(ends[:-1] / ends[1:])
    return amplitude, 0.5 / np.diff(times), decrement / np.sqrt(np.pi**2 + decrement**2)


def _dataset(work: FreeDecayWork, arrays: Arrays) -> xr.Dataset:
    problem, outputs, step = work.problem, arrays["outputs"], work.duration / work.steps
    times = np.asarray(step * np.arange(outputs.shape[1]), dtype=float)
    found = [turning_points(times, signal) for signal in outputs]
    if any(np.any(np.diff(turning) < FEWEST * step) for turning, _ in found):
        raise InputError(
            f"A half cycle must have {FEWEST} steps at least, but some have fewer: the motion is faster than the steps. Take "
            "more steps, or a shorter duration."
        )
    width = max(len(turning) for turning, _ in found)
    table = np.full((5, len(found), width), np.nan)
    for k, (turning, values) in enumerate(found):
        table[:2, k, : len(turning)] = turning, values
        table[2:, k, : len(turning) - 1] = half_cycles(turning, values)
    rows = ContactRows(problem)
    variables = {
        "displacement": outputs,
        "contact_motion": rows.spread(arrays["motion"]),
        "contact_force": rows.spread(arrays["force"]),
        "friction_work": np.nansum(rows.spread(arrays["friction_work"][:, None])[..., 0], axis=1),
        "viscous_work": arrays["viscous_work"],
        **dict(zip(("turning_time", "turning_point", "amplitude", "frequency", "damping_ratio"), table, strict=True)),
    }
    coords = {"time": times} | labels_of(problem)
    attrs = {"title": problem.heading, "method": repr(work.method), "steps": work.steps}
    return tabulated("free_decay", variables, coords, attrs)
