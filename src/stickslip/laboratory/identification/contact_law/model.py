"""Loops of a single contact and the force of each law along them.

Every law is a set of parallel sliders of equal stiffness kt/n with limits μ N(t) w_i/n, mean w = 1:
    jenkins   w = 1, n = 1: all slips at once
    array     limits that fall evenly from one element to the next, by `spread`: five elements with gaps
    iwan      w ~ √(1 − ξ²): the half ellipse of a cylinder on a flat (Li, Xu, Gola and Botto 2020, equation 1)
and beside them
    dahl      the smooth law of `stickslip.model.contact.dahl`, with the same kt and μ as jenkins
    valanis   that of `stickslip.model.contact.valanis`, whose shape κ goes from dahl to jenkins
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.laboratory.measurement.contact_record import check_ratio, clipped
from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.dispatch import kind_of
from stickslip.model.contact.march import steady_period
from stickslip.model.contact.period import OFFSET, friction_period
from stickslip.model.contact.protocol import ContactData, PeriodMotion, no_forces
from stickslip.model.contact.single_load import SingleLoad
from stickslip.model.contact.valanis import Valanis
from stickslip.support.checks import Array, fault
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
