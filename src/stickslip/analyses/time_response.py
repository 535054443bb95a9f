"""Steady response by time integration at one frequency: histories, harmonics and energies of the last period, labelled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stickslip.analyses.contact_rows import ContactRows
from stickslip.model.contact.point import DIRECTION_NAMES
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.solve.time.march import March, MarchOutcome, TimeCycle, march
from stickslip.solve.time.methods import DEFAULT_METHOD, Method
from stickslip.solve.time.start import TimeStart, from_rest
from stickslip.support.checks import Array, fault, finite, of_kind, positive
from stickslip.support.late import xr


@dataclass(frozen=True, eq=False, repr=False)
class TimeResponse(Result):
    """The last period of a time integration: `dataset` (labelled, with units), the problem and the cycle that made them."""

    dataset: xr.Dataset
    problem: Problem
    cycle: TimeCycle

    @property
    def periodic(self) -> bool:
        """Whether the motion repeats itself."""
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


def _dataset(problem: Problem, cycle: TimeCycle, harmonics: int, settings: March) -> xr.Dataset:
    outputs = cycle.outputs
    samples = outputs.shape[1]
    motion, force = ContactRows(problem).spread(cycle.contact_motion), ContactRows(problem).spread(cycle.contact_force)
    place = ("contact", "direction")
    first = np.abs(harmonics_of(outputs, 1)[:, 1])
    work = ContactRows(problem).spread(cycle.friction_work[:, None])[..., 0]
    variables: dict[str, tuple[tuple[str, ...], Any, str, str]] = {
        "time": (("sample",), 2.0 * np.pi / cycle.omega * np.arange(samples) / samples, "s", "time since a zero of the phase"),
        "displacement": (("output", "sample"), outputs, "m", "outputs over the last period"),
        "motion_history": ((*place, "sample"), motion, "m", "contact displacements over the last period"),
        "force_history": ((*place, "sample"), force, "N", "contact forces over the last period"),
        "response": (("output", "harmonic", "part"), _parts(outputs, harmonics), "m", "harmonics of the outputs"),
        "contact_motion": ((*place, "harmonic", "part"), _parts(motion, harmonics), "m", "harmonics of contact displacements"),
        "contact_force": ((*place, "harmonic", "part"), _parts(force, harmonics), "N", "harmonics of contact forces"),
        "amplitude": (("output",), first, "m", "first harmonic of the outputs"),
        "rms": (("output",), np.sqrt(np.mean(outputs**2, axis=1)), "m", "root mean square of the outputs"),
        "max_abs": (("output",), np.max(np.abs(outputs), axis=1), "m", "largest absolute value of the outputs"),
        "dissipated": (("contact",), np.nansum(work, axis=1), "J", "energy dissipated per period"),
        "input_work": ((), cycle.given, "J", "work of the harmonic forces per period"),
        "viscous_work": ((), cycle.viscous, "J", "viscous work per period"),
        "energy_residual": ((), cycle.energy_residual, "1", "input less contact and viscous work, relative to the input"),
        "periods": ((), cycle.periods, "1", "periods marched"),
    }
    return xr.Dataset(
        {
            name: (dims, values, {"units": units, "long_name": long_name})
            for name, (dims, values, units, long_name) in variables.items()
        },
        coords={
            "output": list(problem.output_names),
            "contact": [contact.name for contact in problem.contacts],
            "direction": list(DIRECTION_NAMES),
            "part": ["re", "im"],
            "harmonic": np.arange(harmonics + 1),
        },
        attrs={
            "title": problem.heading,
            "frequency": cycle.omega / (2.0 * np.pi),
            "force_level": cycle.level,
            "method": repr(settings.method),
            "steps_per_period": settings.steps_per_period,
            "outcome": cycle.outcome.name.lower(),
            "message": cycle.sentence,
        },
    )


def _parts(signals: Array, harmonics: int) -> Array:
    """Complex harmonics as (..., H+1, 2): real and imaginary part."""
    values = harmonics_of(signals, harmonics)
    return np.stack([values.real, values.imag], axis=-1)
