"""Identification of the law and parameters of a single contact from hysteresis loops, judged by held-out loops.

Every law is a set of parallel sliders of equal stiffness kt/n with limits μ N(t) w_i/n, mean w = 1:
    jenkins   w = 1, n = 1: all slips at once
    array     limits that fall evenly from one element to the next, by `spread`: five elements with gaps
    iwan      w ~ √(1 − ξ²): the half ellipse of a cylinder on a flat (Li, Xu, Gola and Botto 2020, equation 1)
and beside them
    dahl      the smooth law of `stickslip.contact.dahl`, with the same kt and μ as jenkins
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from stickslip.checks import Array, fault, nearest
from stickslip.contact import dahl
from stickslip.contact.period import OFFSET, friction_period
from stickslip.contact.protocol import ContactData, PeriodMotion, no_forces
from stickslip.results.result import Result

if TYPE_CHECKING:
    import xarray as xr

IWAN_ELEMENTS = 24
ARRAY_ELEMENTS = 5
SMOOTHED = 30
"""Harmonics of the displacement that Dahl's law is led along: it yields to every reversal, and noise would make many."""

CLOSE = 1.1
"""A law with fewer parameters is kept while its held-out error is below this times the smallest."""


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
    """One steady cycle of a contact: tangential displacement [m], force [N], normal load [N] (a number or (n,)), equal times."""

    displacement: ArrayLike
    force: ArrayLike
    normal: ArrayLike
    name: str = "loop"

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
            raise fault(f"The area of {self.name}", "must be positive", float(f"{area:.3g}"), "Is a sign reversed?")
        if np.corrcoef(u, f)[0, 1] < 0.0:
            raise fault(f"Force of {self.name}", "must rise with displacement", "falling", "Is a sign reversed?")
        normal = np.broadcast_to(np.asarray(self.normal, float), u.shape)
        if np.mean(normal) <= 0.0:
            raise fault(f"Normal load of {self.name}", "must be positive in the mean", float(np.mean(normal)))
        if np.max(np.abs(f)) > 2.0 * np.max(normal):
            rule = "must not exceed twice the normal load"
            raise fault(f"Force of {self.name}", rule, float(np.max(np.abs(f))), "Is a unit wrong, or the zero missing?")
        for key, value in (("displacement", u), ("force", f), ("normal", np.maximum(normal, 0.0))):
            object.__setattr__(self, key, np.ascontiguousarray(value))


def steady_force(loop: ContactLoop, kt: float, mu: float, weights: Array) -> Array:
    """The steady force (n,) of parallel sliders by the exact map of one period, from virgin sliders where one never slips."""
    u, normal = np.asarray(loop.displacement), np.asarray(loop.normal)
    ku, total = kt / weights.size * u, np.zeros(u.size)
    y, event = np.empty(u.size), np.empty(u.size, dtype=np.int64)
    for weight in weights:
        friction_period(OFFSET, 0.0, kt, ku, mu * weight / weights.size * normal, 0.0, y, event)
        total += y + ku
    return total


def dahl_force(loop: ContactLoop, kt: float, mu: float) -> Array:
    """The steady force (n,) of Dahl's law, along the displacement smoothed to its first harmonics."""
    spectrum = np.fft.rfft(np.asarray(loop.displacement))
    spectrum[SMOOTHED + 1 :] = 0.0
    u, limit = np.fft.irfft(spectrum, np.size(loop.displacement))[None], mu * np.asarray(loop.normal)
    zero, none = np.zeros(u.size), np.zeros((u.size, 0))
    data = ContactData(np.zeros(0), np.array([kt]), np.zeros(1, dtype=np.int64), np.zeros(1))
    found = no_forces(1, u.size, 0)
    dahl.period(data, PeriodMotion(u, 0.0 * u, limit, zero, 0.0, none, none), found)
    return np.asarray(found.y[0] + kt * u[0])


def _sliders(weights: Callable[[Array], Array]) -> LoopForce:
    return lambda loop, kt, mu, shape: steady_force(loop, kt, mu, weights(shape))


LoopForce = Callable[[ContactLoop, float, float, Array], Array]
"""The steady force of a loop for kt, μ and the shape parameters."""

LAWS: dict[str, tuple[LoopForce, int]] = {
    "jenkins": (_sliders(jenkins_weights), 0),
    "iwan": (_sliders(iwan_weights), 0),
    "dahl": (lambda loop, kt, mu, shape: dahl_force(loop, kt, mu), 0),
    "array": (_sliders(array_weights), 1),
}
"""Of each law, the simplest first: its force, and how many shape parameters it has."""


@dataclass(frozen=True)
class LawFit:
    """One law fitted to all loops: kt [N/m], mu, shape parameters, their standard errors, error of the fit and of loops held
    out, both relative to the rms of the forces."""

    law: str
    kt: float
    mu: float
    shape: tuple[float, ...]
    errors: tuple[float, ...]
    misfit: float
    held_out: float

    def __str__(self) -> str:
        kt, mu = (
            f"{value:.4g} ± {1.96 * error * value:.2g}" for value, error in zip((self.kt, self.mu), self.errors, strict=False)
        )
        held_out = "" if np.isnan(self.held_out) else f", held out {self.held_out:.1%}"
        return f"{self.law}: kt = {kt} N/m, mu = {mu}; misfit {self.misfit:.1%}{held_out}"


@dataclass(frozen=True, eq=False, repr=False)
class LawChoice(Result, figure="identification:law_loops"):
    """The fits of all laws, the chosen one, and why; warnings."""

    best: str
    fits: Mapping[str, LawFit]
    loops: tuple[ContactLoop, ...]
    warnings: tuple[str, ...]
    dataset: xr.Dataset

    def __repr__(self) -> str:
        others = [f"  {fit}" for law, fit in self.fits.items() if law != self.best]
        return "\n".join([f"{self.fits[self.best]} (95 % intervals of noise alone)", *others, *self.warnings])


def identify_law(loops: Sequence[ContactLoop], laws: Sequence[str] = tuple(LAWS)) -> LawChoice:
    """Fit each law to loops of one contact, at different amplitudes, and choose by loops held out one at a time.

    The simplest law whose held-out error is within 10 % of the smallest is chosen. Two loops are needed to hold one out; a single
    law is fitted to one loop, with a held-out error of NaN.
    """
    loops = tuple(loops)
    for law in laws:
        if law not in LAWS:
            raise fault("law", "must be a known one", law, nearest(law, LAWS))
    if not loops or (len(loops) < 2 and len(laws) > 1):
        raise fault(
            "loops",
            "must be at least two, to hold one out",
            len(loops),
            "Measure several amplitudes, or name one law: laws=['iwan'].",
        )
    fits = {law: _fit_and_judge(loops, law) for law in laws}
    smallest = min(fit.held_out for fit in fits.values())
    best = next(law for law in LAWS if law in fits and not fits[law].held_out > CLOSE * smallest)
    warnings = _remarks(loops, fits[best])
    return LawChoice(best, fits, loops, warnings, _dataset(loops, fits, best, warnings))


def _fit_and_judge(loops: tuple[ContactLoop, ...], law: str) -> LawFit:
    theta, errors = _fitted(loops, law)
    rms = np.sqrt(np.mean(np.concatenate([np.asarray(loop.force) ** 2 for loop in loops])))
    misfit = float(np.sqrt(np.mean(_residuals(theta, loops, law) ** 2)) / rms)
    held_out = np.nan
    if len(loops) > 1:
        left = [_residuals(_fitted(_without(loops, i), law)[0], (loop,), law) for i, loop in enumerate(loops)]
        held_out = float(np.sqrt(np.mean(np.concatenate(left) ** 2)) / rms)
    kt, mu = np.exp(theta[:2])
    return LawFit(law, float(kt), float(mu), tuple(map(float, theta[2:])), tuple(errors), misfit, held_out)


def _without(loops: tuple[ContactLoop, ...], index: int) -> tuple[ContactLoop, ...]:
    return loops[:index] + loops[index + 1 :]


def _residuals(theta: Array, loops: tuple[ContactLoop, ...], law: str) -> Array:
    """Measured less computed force of all loops, without the unknown zero of each."""
    kt, mu = np.exp(theta[:2])
    left = [np.asarray(loop.force) - LAWS[law][0](loop, kt, mu, theta[2:]) for loop in loops]
    return np.concatenate([one - one.mean() for one in left])


def _fitted(loops: tuple[ContactLoop, ...], law: str) -> tuple[Array, Array]:
    """Parameters (ln kt, ln mu, shape) by least squares from a few starts, and standard errors of kt, mu (relative), shape."""
    count = LAWS[law][1]
    kt = max(float(np.ptp(np.asarray(loop.force)) / np.ptp(np.asarray(loop.displacement))) for loop in loops)
    mu = max(float(np.ptp(np.asarray(loop.force)) / 2.0 / np.mean(np.asarray(loop.normal))) for loop in loops)
    best = None
    for factor in (1.0, 2.0):
        start = np.array([np.log(factor * kt), np.log(mu), *[0.5] * count])
        low, high = [start[0] - 4, start[1] - 3, *[0.0] * count], [start[0] + 5, start[1] + 3, *[0.999] * count]
        found = least_squares(_residuals, start, args=(loops, law), bounds=(low, high), x_scale=0.1)
        best = found if best is None or found.cost < best.cost else best
    assert best is not None
    jacobian = np.asarray(best.jac)
    freedom = max(best.fun.size - best.x.size, 1)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * 2.0 * best.cost / freedom
    return best.x, np.sqrt(np.diag(covariance))


def _remarks(loops: tuple[ContactLoop, ...], fit: LawFit) -> tuple[str, ...]:
    """What the loops do not determine."""
    warnings = []
    reach = max(float(np.max(np.abs(loop.force)) / (fit.mu * np.max(np.asarray(loop.normal)))) for loop in loops)
    if reach < 0.95:
        warnings.append(f"No loop reaches gross slip ({reach:.0%} of mu N): mu is extrapolated.")
    if fit.misfit > 0.1:
        warnings.append(f"The {fit.law} law misses the loops by {fit.misfit:.0%} of their rms force.")
    return tuple(warnings)


def _dataset(loops: tuple[ContactLoop, ...], fits: Mapping[str, LawFit], best: str, warnings: tuple[str, ...]) -> xr.Dataset:
    import xarray as xr

    def of(key: str) -> list[float]:
        return [getattr(fit, key) for fit in fits.values()]

    variables = {
        "kt": ("law", of("kt"), {"units": "N/m", "long_name": "tangential stiffness"}),
        "mu": ("law", of("mu"), {"units": "1", "long_name": "friction coefficient"}),
        "misfit": ("law", of("misfit"), {"units": "1", "long_name": "error of the fit, relative to the rms force"}),
        "held_out": ("law", of("held_out"), {"units": "1", "long_name": "error on loops held out, relative to the rms force"}),
    }
    return xr.Dataset(variables, {"law": list(fits)}, {"title": "Law of a contact", "best": best, "warnings": list(warnings)})
