"""Laws of a single contact and their fit to hysteresis loops, judged by loops held out. `contact_law.py` is the front door.

Every law is a set of parallel sliders of equal stiffness kt/n with limits μ N(t) w_i/n, mean w = 1:
    jenkins   w = 1, n = 1: all slips at once
    array     limits that fall evenly from one element to the next, by `spread`: five elements with gaps
    iwan      w ~ √(1 − ξ²): the half ellipse of a cylinder on a flat (Li, Xu, Gola and Botto 2020, equation 1)
and beside them
    dahl      the smooth law of `stickslip.model.contact.dahl`, with the same kt and μ as jenkins
    valanis   that of `stickslip.model.contact.valanis`, whose shape κ goes from dahl to jenkins
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from stickslip.laboratory.measurement.contact_record import check_ratio, clipped
from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.dispatch import kind_of
from stickslip.model.contact.march import steady_period
from stickslip.model.contact.period import OFFSET, friction_period
from stickslip.model.contact.protocol import ContactData, PeriodMotion, no_forces
from stickslip.model.contact.single_load import SingleLoad
from stickslip.model.contact.valanis import Valanis
from stickslip.support.checks import Array, fault, not_negative
from stickslip.support.kernels import uncompiled

IWAN_ELEMENTS = 24
ARRAY_ELEMENTS = 5
SMOOTHED = 30
"""Harmonics of the displacement that smooth laws are led along: they yield to every reversal, and noise would make many."""

UNKNOWN = 300.0
"""Logarithm of the factor from which on an interval says nothing more."""

CLOSE = 1.1
"""A law with fewer parameters is kept while its held-out error is below this times the smallest."""

EXACT = 3e-3
"""Held-out errors below this are those of smoothing and sampling, and do not distinguish laws."""

DRAWS, SEED = 12, 0
"""Draws of the noise of the displacement for standard errors, which they give to a fifth, and their seed."""

TURNED = "Is a sign reversed, or are the columns of displacement and force swapped?"

SEGMENTS = 8
"""Parts of a loop whose residuals count as independent: within a part a law that does not quite fit errs the same way."""


def jenkins_weights(shape: Array) -> Array:
    """One element."""
    return np.ones(1)


def array_weights(shape: Array) -> Array:
    """Five elements, the last one with (1 − spread) of the first one's limit."""
    found = 1.0 - shape[0] * np.arange(ARRAY_ELEMENTS) / (ARRAY_ELEMENTS - 1)
    return np.asarray(found / found.mean())


def iwan_weights(shape: Array) -> Array:
    """The half ellipse at the middles of equal parts, scaled to mean 1."""
    return half_ellipse(IWAN_ELEMENTS)


def half_ellipse(count: int) -> Array:
    """√(1 − ξ²) at the middles of so many equal parts, over its mean."""
    place = (np.arange(count) + 0.5) / count
    found = np.sqrt(1.0 - place**2)
    return np.asarray(found / found.mean())


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
        area = float(np.sum(f * (np.roll(u, -1) - np.roll(u, 1)))) / 2.0
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
    spectrum = np.fft.rfft(np.asarray(loop.displacement))
    spectrum[SMOOTHED + 1 :] = 0.0
    u, limit = np.fft.irfft(spectrum, np.size(loop.displacement))[None], law.mu * np.asarray(loop.normal)
    zero, none, first = np.zeros(u.size), np.zeros((u.size, 0)), np.zeros(1, dtype=np.int64)
    elements = law.elements(1, False)
    kt = elements.friction[0].stiffness
    data = ContactData(kind_of(type(law)), np.array(elements.parameters, dtype=float), kt, first, np.zeros(1), kt, first)
    found = uncompiled(no_forces)(data, u.size, 0)
    steady_period(law, data, PeriodMotion(u, 0.0 * u, zero, limit, zero, zero, 0.0, none, none), found)
    return np.asarray(found.y[0] + kt[0] * u[0])


def _sliders(weights: Callable[[Array], Array]) -> LoopForce:
    return lambda loop, kt, mu, shape: steady_force(loop, kt, mu, weights(shape))


LoopForce = Callable[[ContactLoop, float, float, Array], Array]
"""The steady force of a loop for kt, μ and the shape parameters."""

LAWS: dict[str, tuple[LoopForce, int]] = {
    "jenkins": (_sliders(jenkins_weights), 0),
    "iwan": (_sliders(iwan_weights), 0),
    "dahl": (lambda loop, kt, mu, shape: law_force(loop, Dahl(kt, mu, normal_load=1.0)), 0),
    "array": (_sliders(array_weights), 1),
    "valanis": (lambda loop, kt, mu, shape: law_force(loop, Valanis(kt, mu, shape[0], normal_load=1.0)), 1),
}
"""Of each law, the simplest first: its force, and how many shape parameters it has."""

FITTED = ("jenkins", "iwan", "dahl", "array")
"""The laws that are compared unless others are named."""


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


@dataclass(frozen=True)
class LawFit:
    """One law fitted to all loops: kt [N/m], mu, shape parameters; standard errors of kt and mu (relative) and of the shape;
    misfit and error on loops held out, both relative to the rms of the forces.

    The errors hold the scatter and misfit of the loops and the gains and zeros of `LoopErrors`.
    """

    law: str
    kt: float
    mu: float
    shape: tuple[float, ...]
    errors: tuple[float, ...]
    misfit: float
    held_out: float

    @property
    def kt_interval(self) -> tuple[float, float]:
        """95 % interval of kt [N/m]."""
        return _interval(self.kt, self.errors[0])

    @property
    def mu_interval(self) -> tuple[float, float]:
        """95 % interval of mu."""
        return _interval(self.mu, self.errors[1])

    def __str__(self) -> str:
        low, high = (1e-6 * value for value in self.kt_interval)
        kt = f"kt = {1e-6 * self.kt:.4g} N/um ({low:.4g} to {high:.4g})"
        mu = f"mu = {self.mu:.4g} ({self.mu_interval[0]:.4g} to {self.mu_interval[1]:.4g})"
        held_out = "" if np.isnan(self.held_out) else f", held out {self.held_out:.1%}"
        return f"{self.law}: {kt}, {mu}; misfit {self.misfit:.1%}{held_out}"


def _interval(value: float, error: float) -> tuple[float, float]:
    """95 % of a logarithmic normal distribution; from 0 on without end where nothing is known."""
    factor = float(np.exp(min(1.96 * error, UNKNOWN)))
    return value / factor, value * factor


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


def residuals(theta: Array, loops: Sequence[ContactLoop], law: str) -> Array:
    """Measured less computed force of all loops, one after the other, without the unknown zero of each."""
    left = [np.asarray(loop.force) - force_of(loop, law, theta) for loop in loops]
    return np.concatenate([one - one.mean() for one in left])


def fitted(loops: Sequence[ContactLoop], law: str, start: Array | None = None) -> tuple[Array, Array]:
    """Parameters (ln kt, ln mu, shape) by least squares and their standard errors.

    The start follows from range, amplitude and energy of the loops unless given. The errors are those of least squares with
    residuals that are alike within each `SEGMENTS`th of a loop: (JᵀJ)⁻¹ Σ_s (J_sᵀr_s)(J_sᵀr_s)ᵀ (JᵀJ)⁻¹, but no less than with
    white noise of as many values as the smoothing leaves; and those of the displacement, which residuals do not show.
    """
    count = LAWS[law][1]
    starts = [start] if start is not None else [_start(loops, count, factor) for factor in (1.0, 1.5)]
    best = None
    for one in starts:
        low = [one[0] - 4, one[1] - 3, *[0.0] * count]
        high = [one[0] + 5, one[1] + 3, *[0.999] * count]
        found = least_squares(residuals, one, args=(loops, law), bounds=(low, high), x_scale=0.1)
        best = found if best is None or found.cost < best.cost else best
    assert best is not None
    jacobian = np.asarray(best.jac)
    return best.x, np.hypot(_errors(jacobian, best.fun, loops), _errors_of_motion(jacobian, best.x, loops, law))


def _start(loops: Sequence[ContactLoop], count: int, factor: float) -> Array:
    """Where the search begins: μ by the range of the force; kt by the elastic travel F/kt = X − W/(4F) of one slider, with F
    and X half the ranges of force and displacement and W the energy per cycle."""
    half = [(0.5 * np.ptp(np.asarray(loop.displacement)), 0.5 * np.ptp(np.asarray(loop.force))) for loop in loops]
    travel = [max(x - energy_of(loop) / (4.0 * f), 0.01 * x) for (x, f), loop in zip(half, loops, strict=True)]
    kt = max(f / one for (_, f), one in zip(half, travel, strict=True))
    mu = max(f / float(np.mean(np.asarray(loop.normal))) for (_, f), loop in zip(half, loops, strict=True))
    return np.array([np.log(factor * kt), np.log(mu), *[0.5] * count])


def energy_of(loop: ContactLoop) -> float:
    """Energy dissipated in the cycle, ∮ F du [J]."""
    u, force = np.asarray(loop.displacement), np.asarray(loop.force)
    return float(np.sum(force * (np.roll(u, -1) - np.roll(u, 1)))) / 2.0


def _errors(jacobian: Array, left: Array, loops: Sequence[ContactLoop]) -> Array:
    """Standard errors of the parameters, (parameters,)."""
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


def _errors_of_motion(jacobian: Array, theta: Array, loops: Sequence[ContactLoop], law: str) -> Array:
    """Standard errors of the parameters, (parameters,), by the noise that is left in the displacements: root mean square of what
    a few draws of it move them by."""
    errors = [np.zeros(0) if loop.displacement_error is None else loop.displacement_error for loop in loops]
    if not any(np.any(error) for error in errors):
        return np.zeros(theta.size)
    generator = np.random.default_rng(SEED)
    projection, moved = np.linalg.pinv(jacobian), np.empty((DRAWS, theta.size))
    for draw in moved:
        changes = []
        for loop, error in zip(loops, errors, strict=True):
            u = np.asarray(loop.displacement)
            spectrum = np.zeros(u.size // 2 + 1, dtype=complex)
            both = generator.standard_normal((2, error.size))
            spectrum[1 : error.size + 1] = 0.5 * u.size * error * (both[0] + 1j * both[1])
            there = replace(loop, displacement=u + np.fft.irfft(spectrum, u.size))
            changes.append(force_of(there, law, theta) - force_of(loop, law, theta))
        draw[:] = projection @ np.concatenate(changes)
    return np.asarray(np.sqrt(np.mean(moved**2, axis=0)))


def judged(loops: Sequence[ContactLoop], law: str, compared: Sequence[ContactLoop]) -> tuple[Array, Array, float, float]:
    """Parameters of a law, their standard errors, its misfit and its error on loops held out one at a time (NaN for one loop).

    compared: what is held out, the loops themselves or those with a load that makes up for wear.
    """
    theta, errors = fitted(loops, law)
    rms = np.sqrt(np.mean(np.concatenate([np.asarray(loop.force) - np.mean(np.asarray(loop.force)) for loop in loops]) ** 2))
    misfit = float(np.sqrt(np.mean(residuals(theta, loops, law) ** 2)) / rms)
    if len(loops) == 1:
        return theta, errors, misfit, float("nan")
    left = [residuals(fitted((*compared[:i], *compared[i + 1 :]), law, theta)[0], (one,), law) for i, one in enumerate(compared)]
    return theta, errors, misfit, float(np.sqrt(np.mean(np.concatenate(left) ** 2)) / rms)
