"""Cubic spring: a hardening or softening spring without friction, a common benchmark.

Gap: a unilateral spring without friction.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stickslip.model.contact.law import Elements, FrictionElements, Law, NormalElements
from stickslip.model.contact.protocol import (
    SLIPPING,
    STICK,
    ContactData,
    PeriodForces,
    PeriodMotion,
    StepForces,
    StepMotion,
    period_signature,
    step_signature,
)
from stickslip.support.checks import Array, fault, finite, positive
from stickslip.support.kernels import separate


@dataclass(frozen=True)
class CubicSpring(Law):
    """f = k3 w³ along each direction, k3 [N/m³]; negative softens. A linear part belongs in K.

    Exact at 4H + 2 samples or more, since a cube of H harmonics holds 3H and no more; conservative, so that its loops hold no
    energy. A motion that nothing but a cubic spring holds has no linear stiffness, and is refused.
    """

    extensive: ClassVar[tuple[str, ...]] = ("k3",)

    k3: float

    sticks: ClassVar[bool] = False
    remembers_start: ClassVar[bool] = False
    rubs: ClassVar[bool] = False

    def __post_init__(self) -> None:
        if finite("k3", self.k3) == 0.0:
            raise fault("k3", "must not be zero", self.k3)

    @classmethod
    def kernels(cls) -> tuple[Callable[..., Any], ...]:
        return step, period

    def elements(self, tangential: int, normal: bool) -> Elements:
        if not tangential or normal:
            raise fault("A cubic spring", "must have tangential and no normal directions", f"normal: {normal}")
        none, index = np.zeros(0), np.zeros(0, dtype=np.int64)
        return Elements((FrictionElements(none, none, none, index, index),) * tangential, None, (self.k3,))

    def parameter_scales(self, force: float, width: float) -> Array:
        return np.array([force / width**3])


@separate(period_signature)
def period(data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """k3 u³ and its derivative 3 k3 u² E; every harmonic is unknown at all times."""
    k3 = data.parameter[0]
    forces.event[:] = STICK
    for d in range(motion.u.shape[0]):
        for n in range(motion.u.shape[1]):
            forces.y[d, n] = k3 * motion.u[d, n] ** 3
            for j in range(motion.E.shape[1]):
                forces.tangents[n, d, d, j] = 3.0 * k3 * motion.u[d, n] ** 2 * motion.E[n, j]
    return SLIPPING


@separate(step_signature)
def step(data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """k3 u³ after a step, whatever was before."""
    k3 = data.parameter[0]
    for d in range(motion.u.size):
        forces.direct[d], forces.direct_by_u[d, d] = k3 * motion.u[d] ** 3, 3.0 * k3 * motion.u[d] ** 2
    return 0.0


@dataclass(frozen=True)
class Gap(Law):
    """N = max(kn (z − gap) + preload, 0). kn [N/m], gap [m], preload [N]."""

    kn: float
    gap: float = 0.0
    preload: float = 0.0

    sticks: ClassVar[bool] = False
    remembers_start: ClassVar[bool] = False
    rubs: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive("kn", self.kn)
        finite("gap", self.gap)
        finite("preload", self.preload)

    @property
    def has_friction(self) -> bool:
        return False

    def elements(self, tangential: int, normal: bool) -> Elements:
        if tangential or not normal:
            raise fault("A gap contact", "must have a normal and no tangential direction", f"{tangential} tangential")
        one = np.ones(1)
        return Elements((), NormalElements(self.kn * one, (self.preload - self.kn * self.gap) * one))
