"""Coulomb friction with the jump at zero velocity smoothed by a hyperbolic tangent, a common regularisation."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stickslip.model.contact.law import Elements, Friction, SingleLoad, own
from stickslip.model.contact.protocol import (
    OPEN,
    SLIP,
    SLIPPING,
    ContactData,
    PeriodForces,
    PeriodMotion,
    StepForces,
    StepMotion,
    period_signature,
    step_signature,
)
from stickslip.support.checks import Array, fault
from stickslip.support.kernels import inner, separate


@dataclass(frozen=True)
class TanhCoulomb(SingleLoad):
    """T = L tanh(v/v0), v = du/dt, L = μN, in each of one or two tangential directions.

    mu [-]; v0 [m/s]: the velocity that reaches 76 % of the limit. kn, preload, gap, normal_load: the load N, as of `Macroslip`.
    It has no stiffness and never sticks: below v0 it is a viscous damper L/v0. What nothing else holds is refused. The force
    depends on the velocity, so a quasi-static damper cycle, which has none, is refused too.
    Steep for a small v0: samples and harmonics must resolve the passage through ±v0.
    Source: Andersson, Söderberg and Björklund, Tribology International 40 (2007) 580-587.
    """

    mu: Friction
    v0: float = own("velocity that reaches 76 % of the limit", "m/s", above=0.0)
    kn: float | None = None
    preload: float = 0.0
    gap: float = 0.0
    normal_load: float | None = None

    name: ClassVar[str] = "tanh_coulomb"
    about: ClassVar[str] = "Friction that depends on the velocity v alone, μN tanh(v/v0); it has no stiffness and no start state."
    rate_independent: ClassVar[bool] = False
    sticks: ClassVar[bool] = False
    remembers_start: ClassVar[bool] = False
    incrementally_passive: ClassVar[bool] = True

    def __post_init__(self) -> None:
        self.check_load()

    @classmethod
    def kernels(cls) -> tuple[Callable[..., Any], ...]:
        return step, period

    def elements(self, tangential: int, normal: bool) -> Elements:
        return self.under_load((0.0,) * tangential, normal, (self.v0,))

    def parameter_scales(self, force: float, width: float) -> Array:
        return np.array([self.v0])

    def passage(self, velocity: float) -> float:
        """From −v0 to v0 at the reversal of a harmonic motion: v0/(πV) of its period."""
        return self.v0 / (np.pi * velocity) if velocity > 0.0 else np.inf

    def loop_energy(self, amplitude: float, z: float = 0.0) -> float:
        raise fault("The loop energy of a tanh_coulomb contact", "must be asked for at a frequency", "a displacement alone")

    def virgin_curve(self, u: float, z: float = 0.0) -> float:
        raise fault("The force of a tanh_coulomb contact", "must be asked for at a velocity", "a displacement alone")


@inner
def _share(velocity: float, v0: float) -> tuple[float, float]:
    """T/L = tanh(v/v0) and its derivative by v."""
    share = np.tanh(velocity / v0)
    return share, (1.0 - share * share) / v0


@separate(period_signature)
def period(data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """The force at every sample by the velocity there; every harmonic is unknown at all times."""
    v0, limit, u, E, D = data.parameter[0], motion.limit, motion.u, motion.E, motion.D
    for n in range(limit.size):
        forces.event[n] = SLIP if limit[n] > 0.0 else OPEN
        for d in range(u.shape[0]):
            share, slope = _share(motion.velocity[d, n], v0)
            forces.y[d, n] = limit[n] * share
            if motion.omega > 0.0:
                forces.by_omega[d, n] = limit[n] * slope * motion.velocity[d, n] / motion.omega
            for j in range(E.shape[1]):
                forces.tangents[n, d, d, j] = limit[n] * slope * motion.omega * D[n, j]
                forces.tangents[n, d, 2, j] = motion.slope[n] * share * E[n, j]
    for n in range(limit.size):
        for d in range(u.shape[0]):
            forces.work[d] += 0.5 * (forces.y[d, n] + forces.y[d, n - 1]) * (u[d, n] - u[d, n - 1])
    return SLIPPING


@separate(step_signature)
def step(data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """The force by the velocity after a step, whatever was before."""
    for d in range(motion.u.size):
        share, slope = _share(motion.velocity[d], data.parameter[0])
        forces.direct[d], forces.direct_by_limit[d] = motion.limit * share, share
        forces.direct_by_velocity[d, d] = motion.limit * slope
    return 0.0
