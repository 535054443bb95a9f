"""The referee: a solved point of a forced response integrated in time from its own state, and how far the two are apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.solved_points import SolvedPoints
from stickslip.analyses.time_response import TimeResponse, time_response
from stickslip.checks import Array
from stickslip.problem import Problem
from stickslip.solve.time_start import from_harmonics
from stickslip.time.methods import DEFAULT_METHOD, Method

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class TimeCheck:
    """Harmonic balance against time integration at one point. Arrays (outputs,).

    harmonic_amplitude, time_amplitude: |X_1| [m]; amplitude_difference: their relative difference; period_difference: rms of
    x_harmonic − x_time over the period, mean included, relative to the rms of the vibration about its mean; time: the whole
    result of the integration; harmonics H of the point.
    """

    harmonics: int
    harmonic_amplitude: Array
    time_amplitude: Array
    period_difference: Array
    time: TimeResponse

    @property
    def amplitude_difference(self) -> Array:
        """(|X_1| of the harmonic balance − |X_1| in time)/|X_1| in time."""
        return _relative(self.harmonic_amplitude - self.time_amplitude, self.time_amplitude)

    @property
    def periodic(self) -> bool:
        """Whether the time integration became periodic; without that nothing is verified."""
        return self.time.periodic

    @property
    def periods(self) -> int:
        """Periods marched."""
        return self.time.cycle.periods

    def agrees(self, tolerance: float = 1e-3) -> bool:
        """Whether the integration became periodic and every output agrees in first harmonic and over the period."""
        largest = max(float(np.max(np.abs(self.amplitude_difference))), float(np.max(self.period_difference)))
        return self.periodic and largest <= tolerance

    @property
    def sentence(self) -> str:
        """The comparison in words."""
        worst = int(np.argmax(self.period_difference))
        attrs = self.time.dataset.attrs
        harmonics = f"{self.harmonics} harmonic{'s' if self.harmonics > 1 else ''}"
        return (
            f"{attrs['frequency']:.6g} Hz, force level {attrs['force_level']:.6g}: harmonic balance with {harmonics} "
            f"and time integration with {attrs['steps_per_period']} steps a period differ by "
            f"{abs(float(self.amplitude_difference[worst])):.1e} in the first harmonic and by "
            f"{float(self.period_difference[worst]):.1e} over the period "
            f"({self.time.problem.output_names[worst]}, the worst output). {self.time.sentence}"
        )

    def __str__(self) -> str:
        return self.sentence


def verify_in_time(
    dataset: xr.Dataset,
    problem: Problem,
    case: int,
    point: int,
    steps_per_period: int = 2000,
    method: Method = DEFAULT_METHOD,
    tolerance: float = 1e-6,
    periods: int = 1000,
) -> TimeCheck:
    """Integrate a point of a forced response in time, from its own motion, velocity and sliders, and compare."""
    points = SolvedPoints(dataset, problem)
    solved, place = points.point(case, point), dataset.isel(case=case, point=point)
    harmonics = int(dataset.attrs["harmonics"])
    time = time_response(
        problem,
        float(place["frequency"]),
        float(place["force_level"]),
        steps_per_period=steps_per_period,
        method=method,
        tolerance=tolerance,
        periods=periods,
        start=from_harmonics(points.balance, solved.forces, solved.omega, solved.level),
    )
    response = place["response"].to_numpy()
    harmonic = response[..., 0] + 1j * response[..., 1]
    marched = time.cycle.outputs
    turns = np.outer(np.arange(harmonics + 1), np.arange(marched.shape[1])) / marched.shape[1]
    balanced = np.real(harmonic @ np.exp(2j * np.pi * turns))
    vibration = marched - marched.mean(axis=1, keepdims=True)
    return TimeCheck(
        harmonics=harmonics,
        harmonic_amplitude=np.abs(harmonic[:, 1]),
        time_amplitude=time.dataset["amplitude"].to_numpy(),
        period_difference=_relative(_rms(balanced - marched), _rms(vibration)),
        time=time,
    )


def _rms(signals: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(signals**2, axis=1)))


def _relative(difference: Array, size: Array) -> Array:
    """difference/size; where an output does not move at all, 0 or infinity."""
    still = np.where(difference == 0.0, 0.0, np.inf)
    return np.where(size > 0.0, difference / np.where(size > 0.0, size, 1.0), still)
