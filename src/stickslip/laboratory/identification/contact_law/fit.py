"""Least squares of a law along measured loops, judged by loops held out; the lag of a force that explains them better.

Errors of the parameters of a law: scatter and misfit of the loops, noise of their motion, gains and zeros of the rig.

The coefficient of friction over the normal load from loops of one contact at several loads, or under a load that varies.

A law is fitted once more with a coefficient at each of some loads, between which the slip limit is straight, as the contacts of a
model have it (`stickslip.model.contact.law`).

Loops of a single contact and the force of each law along them.

Every law is a set of parallel sliders of equal stiffness kt/n with limits μ N(t) w_i/n, mean w = 1:
    jenkins   w = 1, n = 1: all slips at once
    array     limits that fall evenly from one element to the next, by `spread`: five elements with gaps
    iwan      w ~ √(1 − ξ²): the half ellipse of a cylinder on a flat (Li, Xu, Gola and Botto 2020, equation 1)
and beside them
    dahl      the smooth law of `stickslip.model.contact.dahl`, with the same kt and μ as jenkins
    valanis   that of `stickslip.model.contact.valanis`, whose shape κ goes from dahl to jenkins
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from stickslip.laboratory.identification.least_squares import CERTAINTY, LeastSquares, Solution
from stickslip.laboratory.measurement.contact_record import check_ratio, clipped
from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.law import SingleLoad
from stickslip.model.contact.march import steady_period
from stickslip.model.contact.protocol import OFFSET, ContactData, PeriodMotion, friction_period, kind_of, no_forces
from stickslip.model.contact.valanis import Valanis
from stickslip.support.checks import Array, fault, not_negative
from stickslip.support.kernels import uncompiled

IWAN_ELEMENTS = 24
ARRAY_ELEMENTS = 5
SMOOTHED = 30
"""Harmonics of the displacement that smooth laws are led along: they yield to every reversal, and noise would make many."""

TURNED = "Is a sign reversed, or are the columns of displacement and force swapped?"


@dataclass(frozen=True, eq=False)
class ContactLoop:
    """One steady cycle of a contact: tangential displacement [m], force [N], normal load [N] (a number or (n,)), equal times.

    harmonics: to which the cycle was smoothed, if it was; the computed force is then compared after the same smoothing.
    displacement_error (H,) [m]: standard errors of the cosines and sines of the displacement, for the intervals.
    """

    displacement: ArrayLike
    force: ArrayLike
    normal: ArrayLike
    name: str = "loop"
    harmonics: int | None = None
    displacement_error: Array | None = None

    def __post_init__(self) -> None:
        u, f = np.asarray(self.displacement, float), np.asarray(self.force, float)
        if u.ndim != 1 or u.size < 40 or u.shape != f.shape:
            raise fault(f"{self.name}", "must be one cycle of at least 40 samples of both", (u.shape, f.shape))
        if not (np.all(np.isfinite(u)) and np.all(np.isfinite(f)) and np.all(np.isfinite(self.normal))):
            raise fault(f"{self.name}", "must be finite", "not so")
        if np.ptp(u) == 0.0 or np.ptp(f) == 0.0:
            raise fault(f"{self.name}", "must vary", "a constant signal")
        if not 1e-8 < np.ptp(u) < 1e-2:
            raise fault(f"Displacement of {self.name}", "must vary by 10 nm to 10 mm", float(np.ptp(u)), "Is its unit right?")
        area = work_along(u, f)
        if area < 0.0 and -area > 0.02 * np.ptp(u) * np.ptp(f):
            raise fault(f"The area of {self.name}", "must be positive", float(f"{area:.3g}"), TURNED)
        if np.corrcoef(u, f)[0, 1] < -0.02:
            raise fault(f"Force of {self.name}", "must rise with displacement", "falling", TURNED)
        normal = np.broadcast_to(np.asarray(self.normal, float), u.shape)
        if np.mean(normal) <= 0.0:
            raise fault(f"Normal load of {self.name}", "must be positive in the mean", float(np.mean(normal)))
        check_ratio(self.name, f, float(np.max(normal)))
        clipped(f"Force of {self.name}", f)
        for key, value in (("displacement", u), ("force", f), ("normal", np.maximum(normal, 0.0))):
            object.__setattr__(self, key, np.ascontiguousarray(value))

    @property
    def amplitude(self) -> float:
        """Half the range of the displacement [m]."""
        return 0.5 * float(np.ptp(np.asarray(self.displacement)))

    @property
    def friction(self) -> float:
        """Half the range of the force [N]."""
        return 0.5 * float(np.ptp(np.asarray(self.force)))

    @property
    def load(self) -> float:
        """Mean normal load [N]."""
        return float(np.mean(np.asarray(self.normal)))

    @property
    def energy(self) -> float:
        """Energy dissipated in the cycle [J]."""
        return work_along(np.asarray(self.displacement), np.asarray(self.force))


def work_along(u: Array, force: Array) -> float:
    """∮ F du of one cycle [J]."""
    return float(np.sum(force * (np.roll(u, -1) - np.roll(u, 1)))) / 2.0


def array_weights(shape: Array) -> Array:
    """Five elements, the last one with (1 − spread) of the first one's limit."""
    found = 1.0 - shape[0] * np.arange(ARRAY_ELEMENTS) / (ARRAY_ELEMENTS - 1)
    return np.asarray(found / found.mean())


def half_ellipse(count: int) -> Array:
    """√(1 − ξ²) at the middles of so many equal parts, over its mean."""
    place = (np.arange(count) + 0.5) / count
    found = np.sqrt(1.0 - place**2)
    return np.asarray(found / found.mean())


def steady_force(loop: ContactLoop, kt: float, mu: float, weights: Array) -> Array:
    """The steady force (n,) of parallel sliders by the exact map of one period, from virgin sliders where one never slips."""
    u, normal = np.asarray(loop.displacement), np.asarray(loop.normal)
    ku, total = kt / weights.size * u, np.zeros(u.size)
    y, event, landing = np.empty(u.size), np.empty(u.size, dtype=np.int64), np.zeros(u.size)
    for weight in weights:
        friction_period(OFFSET, 0.0, kt, ku, mu * weight / weights.size * normal, landing, 0.0, y, event)
        total += y + ku
    return total


def law_force(loop: ContactLoop, law: SingleLoad) -> Array:
    """The steady force (n,) of a law with a step of its own under the load of the loop, along the displacement smoothed to its
    first harmonics."""
    u, limit = smoothed(np.asarray(loop.displacement), SMOOTHED)[None], law.mu * np.asarray(loop.normal)
    zero, none, first = np.zeros(u.size), np.zeros((u.size, 0)), np.zeros(1, dtype=np.int64)
    elements = law.elements(1, False)
    kt = elements.friction[0].stiffness
    data = ContactData(kind_of(type(law)), np.array(elements.parameters, dtype=float), kt, first, np.zeros(1), kt, first)
    found = uncompiled(no_forces)(data, u.size, 0)
    steady_period(law, data, PeriodMotion(u, 0.0 * u, zero, limit, zero, zero, 0.0, none, none), found)
    return np.asarray(found.y[0] + kt[0] * u[0])


def _sliders(weights: Callable[[Array], Array]) -> "LoopForce":
    return lambda loop, kt, mu, shape: steady_force(loop, kt, mu, weights(shape))


LoopForce = Callable[[ContactLoop, float, float, Array], Array]
"""The steady force of a loop for kt, μ and the shape parameters."""

LAWS: dict[str, tuple[LoopForce, int]] = {
    "jenkins": (_sliders(lambda shape: np.ones(1)), 0),
    "iwan": (_sliders(lambda shape: half_ellipse(IWAN_ELEMENTS)), 0),
    "dahl": (lambda loop, kt, mu, shape: law_force(loop, Dahl(kt, mu, normal_load=1.0)), 0),
    "array": (_sliders(array_weights), 1),
    "valanis": (lambda loop, kt, mu, shape: law_force(loop, Valanis(kt, mu, shape[0], normal_load=1.0)), 1),
}
"""Of each law, the simplest first: its force, and how many shape parameters it has."""

FITTED = ("jenkins", "iwan", "dahl", "array")
"""The laws that are compared unless others are named."""


def force_of(loop: ContactLoop, law: str, theta: Array) -> Array:
    """The force (n,) of a law with parameters (ln kt, ln mu, shape), smoothed as the loop is, without its mean."""
    kt, mu = np.exp(theta[:2])
    found = smoothed(LAWS[law][0](loop, kt, mu, theta[2:]), loop.harmonics)
    return np.asarray(found - found.mean())


def smoothed(values: Array, harmonics: int | None) -> Array:
    """One cycle (n,) without what lies above its first harmonics."""
    if harmonics is None:
        return values
    spectrum = np.fft.rfft(values)
    spectrum[harmonics + 1 :] = 0.0
    return np.fft.irfft(spectrum, values.size)


def advanced(values: Array, share: float) -> Array:
    """One cycle (n,), earlier by a share of its period."""
    spectrum = np.fft.rfft(values)
    turned = spectrum * np.exp(2j * np.pi * share * np.arange(spectrum.size))
    return np.asarray(np.fft.irfft(turned, values.size))


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
    factor = float(np.exp(min(CERTAINTY * error, UNKNOWN)))
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

    over: loads (k,) [N], at each of which the coefficient has a value of its own: ln mu (k,); None: it is one.
    about: variables about which the bounds lie.
    """

    loops: Sequence[ContactLoop]
    law: str
    about: Array
    late: bool = False
    over: Array | None = None

    @property
    def bounds(self) -> tuple[Array, Array]:
        count, lag, mu = LAWS[self.law][1], np.ones(int(self.late)), self.about[self.coefficients]
        low = self.about[:1] - 4.0, mu - 3.0, np.zeros(count), -lag
        return np.concatenate(low), np.concatenate([self.about[:1] + 5.0, mu + 3.0, np.full(count, 0.999), lag])

    @property
    def coefficients(self) -> slice:
        """The variables ln mu."""
        return slice(1, 2 if self.over is None else 1 + self.over.size)

    def residuals(self, x: Array) -> Array:
        """Measured less computed force of all loops, one after the other, without the unknown zero of each."""
        mu, left = x[self.coefficients], []
        theta = np.concatenate([x[:1], mu.max(keepdims=True), x[1 + mu.size :][: LAWS[self.law][1]]])
        for loop in self.loops:
            force = advanced(np.asarray(loop.force), LONGEST * x[-1]) if self.late else np.asarray(loop.force)
            own = loop if self.over is None else under_friction(loop, self.over, np.exp(mu - mu.max()))
            left.append(force - force.mean() - force_of(own, self.law, theta))
        return np.concatenate(left)


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
    fit = LoopFit(loops, law, start, over=over)
    found, mu = fit.solved(start), fit.coefficients
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
