"""Steady response by time integration at one frequency: histories, harmonics and energies of the last period, labelled.

Verification of a solved point by time integration from its own state, with the difference of the two.
"""

from dataclasses import dataclass, replace

import numpy as np

from stickslip.analyses.response_dataset import ContactRows, labels_of, of_parts, parts
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.problem import Problem
from stickslip.results.schema import Result, tabulated
from stickslip.solve.balance.fourier import Harmonics, in_words, of_attribute
from stickslip.solve.time.march import (
    LOAD_STEPS,
    NEAR,
    March,
    MarchOutcome,
    TimeCycle,
    TimeStart,
    from_harmonics,
    from_rest,
    march,
    shoot,
)
from stickslip.solve.time.period import DEFAULT_METHOD, Method
from stickslip.support.checks import Array, fault, finite, of_kind, positive
from stickslip.support.late import xr


@dataclass(frozen=True, eq=False, repr=False)
class TimeResponse(Result):
    """The last period of a time integration: `dataset` (labelled, with units), the problem and the cycle that made them."""

    dataset: "xr.Dataset"
    problem: Problem
    cycle: TimeCycle

    @property
    def periodic(self) -> bool:
        """Whether the motion repeats itself after each period of the excitation."""
        return self.cycle.outcome == MarchOutcome.PERIODIC

    @property
    def sentence(self) -> str:
        """How the integration ended."""
        return self.cycle.sentence


def time_response(
    problem: Problem,
    frequency: float,
    force: float = 1.0,
    harmonics: int = 21,
    *,
    steps_per_period: int = 2000,
    method: Method = DEFAULT_METHOD,
    tolerance: float = 1e-6,
    periods: int = 1000,
    start: TimeStart | None = None,
) -> TimeResponse:
    """Integrate M q̈ + C q̇ + K q + Bᵀ f(B q) = p(t) at one frequency [Hz] and force level until the motion is periodic.

    harmonics: how many of the last period are kept. steps_per_period, method: see `GeneralisedAlpha`, `Newmark`. tolerance:
    estimated relative distance from the periodic motion; periods: the limit, beyond which `periodic` is false and `sentence`
    says so. start: the state at t = 0, from rest with the sliders at their start rules unless given.
    """
    of_kind("problem", problem, Problem)
    settings = March(steps_per_period, method, tolerance, periods)
    steps = settings.steps_per_period
    if int(harmonics) != harmonics or not 1 <= harmonics < steps / 2:
        remedy = f"Half of steps_per_period, {steps}, is the most: take more steps, or fewer harmonics."
        raise fault("The number of harmonics kept", f"must be a whole number from 1 to {(steps - 1) // 2}", harmonics, remedy)
    omega = 2.0 * np.pi * positive("frequency", frequency)
    cycle = march(problem, omega, finite("force", force), start or from_rest(problem), settings)
    return TimeResponse(_dataset(problem, cycle, harmonics, settings), problem, cycle)


def harmonics_of(signals: Array, harmonics: int) -> np.ndarray:
    """X_h, h = 0..H, of signals (..., N) sampled over one period: (..., H+1) complex, x = Re Σ X_h exp(i h ω t)."""
    spectrum = np.fft.rfft(signals, axis=-1)[..., : harmonics + 1] / signals.shape[-1]
    spectrum[..., 1:] *= 2.0
    return np.asarray(spectrum)


def _dataset(problem: Problem, cycle: TimeCycle, harmonics: int, settings: March) -> "xr.Dataset":
    outputs = cycle.outputs
    samples = outputs.shape[1]
    motion, force = ContactRows(problem).spread(cycle.contact_motion), ContactRows(problem).spread(cycle.contact_force)
    response, moved, carried = (parts(harmonics_of(signals, harmonics)) for signals in (outputs, motion, force))
    work = ContactRows(problem).spread(cycle.friction_work[:, None])[..., 0]
    variables = {
        "time": 2.0 * np.pi / cycle.omega * np.arange(samples) / samples,
        "displacement": outputs,
        "motion_history": motion,
        "force_history": force,
        "response": response,
        "contact_motion": moved,
        "contact_force": carried,
        "amplitude": np.abs(harmonics_of(outputs, 1)[:, 1]),
        "rms": np.sqrt(np.mean(outputs**2, axis=1)),
        "max_abs": np.max(np.abs(outputs), axis=1),
        "dissipated": np.nansum(work, axis=1),
        "input_work": cycle.given,
        "viscous_work": cycle.viscous,
        "energy_residual": cycle.energy_residual,
        "periods": cycle.periods,
    }
    coords = labels_of(problem) | {"part": ["re", "im"], "harmonic": np.arange(harmonics + 1)}
    attrs = {
        "title": problem.heading,
        "frequency": cycle.omega / (2.0 * np.pi),
        "force_level": cycle.level,
        "method": repr(settings.method),
        "steps_per_period": settings.steps_per_period,
        "outcome": cycle.outcome.name.lower(),
        "message": cycle.sentence,
    }
    return tabulated("time_response", variables, coords, attrs)


LEFT = 10.0
"""A last period so many times as far from the harmonic balance as the first one has left it."""

REST = 1e-9
"""An output that vibrates by less than this share of the largest motion is at rest."""

FEWEST_PERIODS = 20
"""Periods that half the steps are allowed at least."""

ELSEWHERE = 0.1
"""A periodic motion in time that differs by more from the harmonic balance, relative to the vibration, is another one."""

UNDECIDED = 1e-4
"""Excess of a multiplier over 1 that differences of marched periods cannot resolve."""


@dataclass(frozen=True, eq=False)
class TimeCheck:
    """Harmonic balance against time integration at one point. Arrays (outputs,).

    harmonic_amplitude, time_amplitude: |X_1| [m]; period_difference: rms of x_harmonic − x_time over the last period, mean
    included, relative to the rms of the vibration about its mean; first_period_difference: the same over the first period, where
    the integration still is what the harmonic balance says if that is a periodic motion; step_error: |X_1(N/2) − X_1(N)|/|X_1(N)|
    with half the N steps per period, NaN where the integration has not settled; time: the whole result of the integration;
    harmonics of the point: H, or a list; excitation_periods: those of the excitation after which the motion repeats itself, which
    here are one period. multiplier: the largest Floquet multiplier of the periodic motion of the time steps, found by shooting
    from the point, and motion_difference (outputs,): how far that motion, stable or not, is from the harmonic balance, rms as
    above; both NaN where no periodic motion was found beside it.
    """

    harmonics: Harmonics
    harmonic_amplitude: Array
    time_amplitude: Array
    period_difference: Array
    first_period_difference: Array
    step_error: Array
    time: TimeResponse
    multiplier: complex
    motion_difference: Array
    excitation_periods: int = 1

    @property
    def amplitude_difference(self) -> Array:
        """(|X_1| of the harmonic balance − |X_1| in time)/|X_1| in time."""
        return _relative(self.harmonic_amplitude - self.time_amplitude, _moving(self.time_amplitude))

    @property
    def periodic(self) -> bool:
        """Whether the time integration became periodic to the `tolerance` asked for."""
        return self.time.periodic

    @property
    def periods(self) -> int:
        """Periods marched."""
        return self.time.cycle.periods

    @property
    def distance(self) -> float:
        """Estimated distance of the last period from a periodic motion, relative; infinite where the motion does not settle."""
        return self.time.cycle.distance

    @property
    def unstable(self) -> bool:
        """Whether the periodic motion is not stable in time: |multiplier| > 1.0001.

        Where it has no multiplier, whether the march left it: the last period of an output is ten times as far from the harmonic
        balance as the first, and either the changes from period to period rose, or the march has settled elsewhere.
        """
        if np.isfinite(self.multiplier):
            return self._bounded and abs(self.multiplier) > 1.0 + UNDECIDED
        far = self.period_difference > LEFT * np.maximum(self.first_period_difference, REST)
        elsewhere = self.time.cycle.repeats > 0 and bool(np.max(self.period_difference, initial=0.0) > ELSEWHERE)
        return self._bounded and bool(np.any(far)) and (elsewhere or self.time.cycle.growth > 1.0)

    def agrees(self, tolerance: float = 1e-3) -> bool:
        """Whether every output agrees in first harmonic and over the period with the periodic motion the integration tends to.

        What the last period is still away from it, `distance`, counts as difference, so that an integration that has not settled
        verifies nothing.
        """
        largest = max(float(np.max(np.abs(self.amplitude_difference))), float(np.max(self.period_difference)))
        return self._bounded and not self.unstable and largest + self.distance <= tolerance

    @property
    def sentence(self) -> str:
        """The comparison in words."""
        attrs, worst = self.time.dataset.attrs, int(np.argmax(self.period_difference))
        place = f"{self.excitation_periods * attrs['frequency']:.6g} Hz, force level {attrs['force_level']:.6g}"
        return f"{place}: {self._departure(worst) if self.unstable else self._difference(worst)} {self.time.sentence}"

    def _difference(self, worst: int) -> str:
        steps = self.time.dataset.attrs["steps_per_period"] // self.excitation_periods
        error = float(self.step_error[worst])
        halved = "" if np.isnan(error) else f" Half the steps change the first harmonic by {error:.1e}."
        if np.isinf(error):
            halved = " With half the steps the motion does not settle: take more."
        return (
            f"harmonic balance with {in_words(self.harmonics)} and time integration with {steps} steps a period differ by "
            f"{abs(float(self.amplitude_difference[worst])):.1e} in the first harmonic and by "
            f"{float(self.period_difference[worst]):.1e} over the period ({self.time.problem.output_names[worst]}, the worst "
            f"output).{halved}"
        )

    def _departure(self, worst: int) -> str:
        growth = abs(self.multiplier) if np.isfinite(self.multiplier) else self.time.cycle.growth
        return (
            f"harmonic balance with {in_words(self.harmonics)} gives a periodic motion, which the first period in time repeats "
            f"within {float(self.first_period_difference[worst]):.1e}, but not a stable one: departures grow by a factor of "
            f"{growth:.3g} a period, and the motion ends {float(self.period_difference[worst]):.1e} away "
            f"({self.time.problem.output_names[worst]}, the worst output)."
        )

    @property
    def _bounded(self) -> bool:
        """Whether the march took all its steps; steps that fail or gain energy say nothing about the harmonic balance."""
        return self.time.cycle.outcome not in (MarchOutcome.STEP_FAILED, MarchOutcome.UNBOUNDED)

    def __str__(self) -> str:
        return self.sentence


def verify_in_time(
    dataset: "xr.Dataset",
    problem: Problem,
    case: int,
    point: int,
    steps_per_period: int = 2000,
    method: Method = DEFAULT_METHOD,
    tolerance: float = 1e-6,
    periods: int = 1000,
) -> TimeCheck:
    """Integrate a point of a forced response in time, from its own motion, velocity and sliders, and compare.

    Beside it the periodic motion of the steps is found by shooting from the same state, for its multiplier.
    """
    points = SolvedPoints(dataset, problem)
    solved, place = points.point(case, point), dataset.isel(case=case, point=point)
    excitation_periods, whole = points.balance.periods, points.balance.problem.at_frequency(solved.omega)
    settings = March(excitation_periods * steps_per_period, method, tolerance, periods)
    start = from_harmonics(points.balance, solved.forces, solved.omega, solved.level)
    time = time_response(
        whole,
        float(place["frequency"]) / excitation_periods,
        float(place["force_level"]),
        steps_per_period=excitation_periods * steps_per_period,
        method=method,
        tolerance=tolerance,
        periods=periods,
        start=start,
    )
    motion = points.balance.linear.whole_motion(solved.forces, solved.omega, solved.level)
    shot = shoot(whole, solved.omega, solved.level, start, motion, settings)
    harmonic = of_parts(place["response"].to_numpy())
    apart = _period_difference(harmonic, shot.outputs)
    near = shot.closed and float(np.max(apart, initial=0.0)) <= ELSEWHERE
    return TimeCheck(
        harmonics=of_attribute(dataset.attrs["harmonics"]),
        harmonic_amplitude=np.abs(harmonic[:, excitation_periods]),
        time_amplitude=np.abs(harmonics_of(time.cycle.outputs, excitation_periods)[:, excitation_periods]),
        period_difference=_period_difference(harmonic, time.cycle.outputs),
        first_period_difference=_period_difference(harmonic, time.cycle.first_outputs),
        step_error=_step_error(time, settings, excitation_periods),
        time=time,
        multiplier=shot.leading if near else complex(np.nan),
        motion_difference=apart if near else np.full(apart.shape, np.nan),
        excitation_periods=excitation_periods,
    )


def _period_difference(harmonic: np.ndarray, marched: Array) -> Array:
    """rms of Re Σ X_h exp(i h ω t) − x over a period relative to that of the vibration of x (outputs, N); X (outputs, H+1).

    Of an output at rest, relative to what moves most or to its own displacement, whichever is larger.
    """
    turns = np.outer(np.arange(harmonic.shape[1]), np.arange(marched.shape[1])) / marched.shape[1]
    balanced = np.real(harmonic @ np.exp(2j * np.pi * turns))
    means = marched.mean(axis=1, keepdims=True)
    return _relative(_rms(balanced - marched), _moving(_rms(marched - means), np.abs(means[:, 0])))


def _step_error(time: TimeResponse, settings: March, first: int) -> Array:
    """|X_1(N/2) − X_1(N)|/|X_1(N)| (outputs,): half the steps, from the state where N steps ended, so with the same sliders.

    At most as many periods as with N steps, half the work. What the coarser motion has not yet settled is added; infinite where
    it does not settle, NaN where the one with N steps did not or N/2 are too few to march with.
    """
    cycle, steps = time.cycle, settings.steps_per_period // 2
    fine = harmonics_of(cycle.outputs, first)[:, first]
    highest = max(harmonic for force in time.problem.forces for harmonic in force.amplitudes)
    if cycle.growth > 1.0 or not cycle.distance < NEAR or steps < LOAD_STEPS * highest:
        return np.full(fine.size, np.nan)
    coarser = replace(settings, steps_per_period=steps, periods=max(cycle.periods, FEWEST_PERIODS))
    halved = march(time.problem, cycle.omega, cycle.level, cycle.end, coarser)
    return _relative(np.abs(harmonics_of(halved.outputs, first)[:, first] - fine), _moving(np.abs(fine))) + halved.distance


def _rms(signals: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(signals**2, axis=1)))


def _moving(sizes: Array, means: Array | float = 0.0) -> Array:
    """The sizes of the outputs' vibration; of outputs at rest but for rounding, the largest size or the own mean instead."""
    largest = np.maximum(np.max(sizes, initial=0.0), means)
    return np.asarray(np.where(sizes > REST * largest, sizes, largest))


def _relative(difference: Array, size: Array) -> Array:
    """difference/size; where an output does not move at all, 0 or infinity."""
    still = np.where(difference == 0.0, 0.0, np.inf)
    return np.where(size > 0.0, difference / np.where(size > 0.0, size, 1.0), still)
