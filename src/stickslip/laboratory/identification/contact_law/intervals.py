"""Errors of the parameters of a law: scatter and misfit of the loops, noise of their motion, gains and zeros of the rig."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from stickslip.laboratory.identification.contact_law.model import ContactLoop, force_of
from stickslip.laboratory.identification.least_squares import Solution
from stickslip.support.checks import Array, not_negative

UNKNOWN = 300.0
"""Logarithm of the factor from which on an interval says nothing more."""

DRAWS, SEED = 12, 0
"""Draws of the noise of the displacement for standard errors, which they give to a fifth, and their seed."""

SEGMENTS = 8
"""Parts of a loop whose residuals count as independent: within a part a law that does not quite fit errs the same way."""


@dataclass(frozen=True)
class LoopErrors:
    """Standard deviations of what the loops themselves cannot show, for the intervals: gains of friction cell, displacement
    sensor and normal load (relative), zero of the normal load [N], and of the rig's stiffness where it is given (relative).

    Zeros of friction force and displacement are fitted in each loop and need none.
    """

    force_gain: float = 0.01
    displacement_gain: float = 0.01
    normal_gain: float = 0.01
    normal_zero: float = 0.0
    rig_stiffness: float = 0.05

    def __post_init__(self) -> None:
        for field in fields(self):
            not_negative(field.name, getattr(self, field.name))

    def added_to(self, errors: Array, kt: float, load: float, rig_stiffness: float | None) -> Array:
        """Standard errors of (ln kt, ln mu, shape) by the loops, with those of gains and zeros; load: mean normal load [N].

        Gains move the stiffness of rig and contact together; what is left for kt moves 1 + kt/k_rig times as much.
        """
        found, share = errors.copy(), 0.0 if rig_stiffness is None else kt / rig_stiffness
        gains = np.hypot(self.force_gain, self.displacement_gain) * (1.0 + share)
        found[0] = np.sqrt(errors[0] ** 2 + gains**2 + (share * self.rig_stiffness) ** 2)
        found[1] = np.sqrt(errors[1] ** 2 + self.force_gain**2 + self.normal_gain**2 + (self.normal_zero / load) ** 2)
        return found


def interval(value: float, error: float) -> tuple[float, float]:
    """95 % of a logarithmic normal distribution; from 0 on without end where nothing is known."""
    factor = float(np.exp(min(1.96 * error, UNKNOWN)))
    return value / factor, value * factor


def standard_errors(found: Solution, loops: Sequence[ContactLoop], law: str) -> Array:
    """Standard errors of the parameters (ln kt, ln mu, shape), by what is left of the forces and by noise of the motion."""
    return np.asarray(np.hypot(errors_of_scatter(found, loops), errors_of_motion(found, loops, law)))


def errors_of_scatter(found: Solution, loops: Sequence[ContactLoop]) -> Array:
    """Standard errors with residuals that are alike within each `SEGMENTS`th of a loop,
    (JᵀJ)⁻¹ Σ_s (J_sᵀr_s)(J_sᵀr_s)ᵀ (JᵀJ)⁻¹, but no less than with white noise of as many values as the smoothing leaves."""
    jacobian, left = found.jacobian, found.residuals
    inverse = np.linalg.pinv(jacobian.T @ jacobian)
    sizes = [np.size(loop.displacement) for loop in loops]
    ends = np.cumsum([0, *sizes])
    parts = [part for a, b in itertools.pairwise(ends) for part in np.array_split(np.arange(a, b), SEGMENTS)]
    scores = np.array([jacobian[part].T @ left[part] for part in parts])
    correction = len(parts) / max(len(parts) - jacobian.shape[1], 1)
    alike = correction * inverse @ (scores.T @ scores) @ inverse
    independent = sum(size if loop.harmonics is None else 2 * loop.harmonics for size, loop in zip(sizes, loops, strict=True))
    freedom = max(independent - jacobian.shape[1], 1)
    white = inverse * float(left @ left) / freedom
    return np.sqrt(np.maximum(np.diag(alike), np.diag(white)))


def errors_of_motion(found: Solution, loops: Sequence[ContactLoop], law: str) -> Array:
    """Standard errors by the noise that is left in the displacements, which residuals do not show: root mean square of what a few
    draws of it move the parameters by."""
    errors = [np.zeros(0) if loop.displacement_error is None else loop.displacement_error for loop in loops]
    if not any(np.any(error) for error in errors):
        return np.zeros(found.x.size)
    generator = np.random.default_rng(SEED)
    projection, moved = np.linalg.pinv(found.jacobian), np.empty((DRAWS, found.x.size))
    for draw in moved:
        changes = []
        for loop, error in zip(loops, errors, strict=True):
            u = np.asarray(loop.displacement)
            spectrum = np.zeros(u.size // 2 + 1, dtype=complex)
            both = generator.standard_normal((2, error.size))
            spectrum[1 : error.size + 1] = 0.5 * u.size * error * (both[0] + 1j * both[1])
            there = replace(loop, displacement=u + np.fft.irfft(spectrum, u.size))
            changes.append(force_of(there, law, found.x) - force_of(loop, law, found.x))
        draw[:] = projection @ np.concatenate(changes)
    return np.asarray(np.sqrt(np.mean(moved**2, axis=0)))
