"""Least squares of a law along measured loops, judged by loops held out; the lag of a force that explains them better.

Errors of the parameters of a law: scatter and misfit of the loops, noise of their motion, gains and zeros of the rig.

The coefficient of friction over the normal load from loops of one contact at several loads, or under a load that varies.

A law is fitted once more with a coefficient at each of some loads, between which the slip limit is straight, as the contacts of a
model have it (`stickslip.model.contact.law`).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from stickslip.laboratory.identification.contact_law.model import LAWS, ContactLoop, advanced, force_of
from stickslip.laboratory.identification.least_squares import LeastSquares, Solution
from stickslip.support.checks import Array, fault, not_negative

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


LONGEST = 0.05
"""Share of a period up to which a lag is looked for."""


@dataclass(frozen=True, eq=False)
class LoopFit(LeastSquares):
    """A law along measured loops. Variables: ln kt, ln mu, shape; and the lag of the force over the longest where it is `late`.

    about: variables about which the bounds lie.
    """

    loops: Sequence[ContactLoop]
    law: str
    about: Array
    late: bool = False

    @property
    def bounds(self) -> tuple[Array, Array]:
        count, lag = LAWS[self.law][1], [1.0] * self.late
        low = [self.about[0] - 4.0, self.about[1] - 3.0, *[0.0] * count, *(-1.0 * one for one in lag)]
        return np.array(low), np.array([self.about[0] + 5.0, self.about[1] + 3.0, *[0.999] * count, *lag])

    def residuals(self, x: Array) -> Array:
        """Measured less computed force of all loops, one after the other, without the unknown zero of each."""
        theta = x[: 2 + LAWS[self.law][1]]
        forces = [np.asarray(loop.force) for loop in self.loops]
        if self.late:
            forces = [advanced(force, LONGEST * x[-1]) for force in forces]
        left = [force - force_of(loop, self.law, theta) for force, loop in zip(forces, self.loops, strict=True)]
        return np.concatenate([one - one.mean() for one in left])


def first_guess(loops: Sequence[ContactLoop], law: str, factor: float = 1.0) -> Array:
    """Where the search begins: μ by the range of the force; kt by the elastic travel F/kt = X − W/(4F) of one slider, with F
    and X half the ranges of force and displacement and W the energy per cycle."""
    travel = [max(one.amplitude - one.energy / (4.0 * one.friction), 0.01 * one.amplitude) for one in loops]
    kt = max(loop.friction / one for loop, one in zip(loops, travel, strict=True))
    return np.array([np.log(factor * kt), np.log(max(one.friction / one.load for one in loops)), *[0.5] * LAWS[law][1]])


def fitted(loops: Sequence[ContactLoop], law: str, start: Array | None = None) -> Solution:
    """The least squares in (ln kt, ln mu, shape), from a start or from two that range, amplitude and energy give."""
    starts = [start] if start is not None else [first_guess(loops, law, factor) for factor in (1.0, 1.5)]
    return LoopFit(loops, law, starts[0]).solutions(starts, lambda found: False)[0]


def judged(loops: Sequence[ContactLoop], law: str, compared: Sequence[ContactLoop]) -> tuple[Array, Array, float, float]:
    """Parameters of a law, their standard errors, its misfit and its error on loops held out one at a time (NaN for one loop).

    compared: what is held out, the loops themselves or those with a load that makes up for wear.
    """
    found, errors = fitted(loops, law), []
    rms = np.sqrt(np.mean(np.concatenate([np.asarray(loop.force) - np.mean(np.asarray(loop.force)) for loop in loops]) ** 2))
    for i, loop in enumerate(compared if len(loops) > 1 else ()):
        others = fitted((*compared[:i], *compared[i + 1 :]), law, found.x)
        errors.append(LoopFit((loop,), law, found.x).residuals(others.x))
    held_out = np.sqrt(np.mean(np.concatenate(errors) ** 2)) / rms if errors else np.nan
    misfit = np.sqrt(np.mean(found.residuals**2)) / rms
    return found.x, standard_errors(found, loops, law), float(misfit), float(held_out)


class ForceLag(NamedTuple):
    """lag: share of a period by which the force comes late (below zero: early); kt [N/m] with it taken away; left: sum of squares
    of the residuals over that without a lag."""

    lag: float
    kt: float
    left: float


def force_lag(loops: Sequence[ContactLoop], law: str, theta: Array) -> ForceLag:
    """The lag that explains loops best, fitted with the parameters (ln kt, ln mu, shape) of a law from where it fits without.

    At a reversal a contact sticks: its force turns with the displacement, however stiff it is. A force that turns later does so
    by its sensor or filter, unless the law lacks what makes it.
    """
    fit, start = LoopFit(loops, law, theta, late=True), np.append(theta, 0.0)
    found, before = fit.solved(start), fit.cost(start)
    return ForceLag(LONGEST * float(found.x[-1]), float(np.exp(found.x[0])), found.cost / before if before > 0.0 else 1.0)


BESIDE = 0.1
"""How far a load may lie beyond those of the loops, relative to it."""

BLIND = 1e-3
"""Share of what the best known coefficient moves the forces by below which loops do not show one."""


class FrictionOverLoad(NamedTuple):
    """Coefficients (loads,) at the loads (loads,) [N] and their relative standard errors, those of gains and zeros included;
    exponent: of the power of the load that they follow best, and its standard error."""

    load: Array
    friction: Array
    errors: Array
    exponent: float
    exponent_error: float


@dataclass(frozen=True, eq=False)
class FrictionFit(LeastSquares):
    """A law along loops with a coefficient at each of the loads `over` (k,) [N]. Variables: ln kt, ln μ (k,), shape.

    about: variables about which the bounds lie.
    """

    loops: Sequence[ContactLoop]
    law: str
    over: Array
    about: Array

    @property
    def bounds(self) -> tuple[Array, Array]:
        shape, wide = LAWS[self.law][1], np.full(self.over.size, 3.0)
        first = self.about[: 1 + self.over.size]
        low, high = first - np.append(4.0, wide), first + np.append(5.0, wide)
        return np.append(low, [0.0] * shape), np.append(high, [0.999] * shape)

    def residuals(self, x: Array) -> Array:
        """Measured less computed force of all loops, one after the other, without the unknown zero of each."""
        values, reference = np.exp(x[1 : 1 + self.over.size]), float(np.max(x[1 : 1 + self.over.size]))
        theta = np.concatenate([x[:1], [reference], x[1 + self.over.size :]])
        left = []
        for loop in self.loops:
            scaled = under_friction(loop, self.over, values / np.exp(reference))
            force = np.asarray(loop.force)
            left.append(force - force.mean() - force_of(scaled, self.law, theta))
        return np.concatenate(left)


def under_friction(loop: ContactLoop, over: Array, values: Array) -> ContactLoop:
    """The loop with μ(N) N of coefficients at some loads as its load: then one coefficient of 1 stands for all."""
    load = np.asarray(loop.normal)
    inside = np.interp(load, np.append(0.0, over), np.append(0.0, over * values))
    return replace(loop, normal=np.where(load > over[-1], values[-1] * load, inside))


def friction_over_load(loops: Sequence[ContactLoop], law: str, over: Array, errors: LoopErrors) -> FrictionOverLoad:
    """The coefficients at some loads that fit loops best with a law; see `contact_law`."""
    lowest, highest = (end(np.concatenate([np.asarray(loop.normal) for loop in loops])) for end in (np.min, np.max))
    if over[0] < (1.0 - BESIDE) * lowest or over[-1] > (1.0 + BESIDE) * highest:
        raise fault("friction_over", f"must lie within the loads of the loops, {lowest:.4g} to {highest:.4g} N", over.tolist())
    order = np.argsort([loop.load for loop in loops])
    loads, ratios = np.array([(loops[k].load, loops[k].friction / loops[k].load) for k in order]).T
    guess = first_guess(loops, law)
    start = np.concatenate([guess[:1], np.log(np.interp(over, loads, ratios)), guess[2:]])
    found = FrictionFit(loops, law, over, start).solved(start)
    mu = slice(1, 1 + over.size)
    seen = np.linalg.norm(found.jacobian[:, mu], axis=0)
    if seen.min() < BLIND * seen.max():
        blind = float(over[int(np.argmin(seen))])
        raise fault("friction_over", "must be loads at which loops slip", f"{blind:g} N", "Leave that load out.")
    friction, scatter = np.exp(found.x[mu]), errors_of_scatter(found, loops)[mu]
    limits = over * friction
    if np.any(np.diff(limits) < 0.0):
        k = int(np.argmin(np.diff(limits)))
        raise fault(
            "The friction force mu N",
            "must not fall as the load grows",
            f"{limits[k]:.4g} N at {over[k]:g} N and {limits[k + 1]:.4g} N at {over[k + 1]:g} N",
            "Give fewer loads in friction_over, further apart.",
        )
    exponent = _power(np.log(over), found.x[mu], scatter)
    zero = errors.normal_zero / over
    whole = np.sqrt(scatter**2 + errors.force_gain**2 + errors.normal_gain**2 + zero**2)
    return FrictionOverLoad(over, friction, whole, *exponent)


def _power(x: Array, y: Array, scatter: Array) -> tuple[float, float]:
    """Slope of y over x (k,) and its standard error, by the scatter of y, by what the line misses where it is more."""
    weights = scatter**-2.0
    about = x - np.average(x, weights=weights)
    slope = float(np.sum(weights * about * y) / np.sum(weights * about**2))
    missed = np.sum(weights * (y - np.average(y, weights=weights) - slope * about) ** 2) / max(x.size - 2, 1)
    return slope, float(np.sqrt(max(missed, 1.0) / np.sum(weights * about**2)))
