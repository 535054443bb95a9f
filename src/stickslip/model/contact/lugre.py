"""The LuGre law: bristles that bend as the contact begins to slip, with a limit that falls with the speed, and viscous parts.

The bristles are Dahl's law under a limit that depends on the speed of a step; the rest follows from the velocity after it. The
step is all there is to it, as of Valanis' law.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stickslip.model.contact.dahl import beyond_limit, dahl_travel
from stickslip.model.contact.law import Elements, Friction, LoadDependentFriction, Yielding, line_of, own
from stickslip.model.contact.protocol import ContactData, StepForces, StepMotion, step_signature
from stickslip.support.checks import Array, fault, positive
from stickslip.support.kernels import inner, separate


@dataclass(frozen=True)
class LuGre(Yielding):
    """T = kt z + N (σ1 ż + σ2 v) with ż = v − kt |v| z/(N g(v)) and g(v) = μ + (μs − μ) exp(−(v/vs)²), in each of one or two
    tangential directions.

    v = du/dt [m/s]; z [m]: deflection of the bristles; kt [N/m]: their stiffness; mu μ and mu_static μs [-]: coefficients of
    friction at high and at zero speed; stribeck vs [m/s]: the speed at which friction falls from μs towards μ; damping σ1 and
    viscosity σ2 [s/m]: of the bristles and of the film, per normal load. kn, preload, gap, normal_load: the load N, as for
    `Macroslip`. Every motion dissipates energy, and the contact forgets its start state. The force depends on the velocity, so a
    quasi-static damper cycle, which has none, is refused.
    Where N falls, kt z is limited to μs N, which it never exceeds under a constant N. Accuracy: second order in the samples.
    Source: Canudas de Wit, Olsson, Åström and Lischinsky, IEEE Transactions on Automatic Control 40 (1995) 419-425.
    """

    kt: float
    mu: Friction
    mu_static: float = own("friction coefficient at zero speed, at least `mu`", least=0.0)
    stribeck: float = own("speed at which friction falls from mu_static towards mu", "m/s", above=0.0)
    damping: float = own("damping of the bristles, per normal load", "s/m", least=0.0, default=0.0)
    viscosity: float = own("viscous friction, per normal load", "s/m", least=0.0, default=0.0)
    kn: float | None = None
    preload: float = 0.0
    gap: float = 0.0
    normal_load: float | None = None

    name: ClassVar[str] = "lugre"
    about: ClassVar[str] = (
        "The LuGre law: friction that yields gradually and falls with the sliding speed, with damping. It never sticks and has "
        "no start state; kt is the slope at a reversal."
    )
    rate_independent: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive("kt", self.kt)
        if isinstance(self.mu, LoadDependentFriction):
            raise fault(
                "mu of a lugre contact", "must be a number", self.mu, "Its friction depends on the speed, not on the load."
            )
        positive("mu", self.mu)
        self.check_load()
        if self.mu_static < self.mu:
            raise fault("mu_static", f"must be at least mu = {self.mu:g}", self.mu_static)

    @classmethod
    def kernels(cls) -> tuple[Callable[..., Any], ...]:
        return (step,)

    def elements(self, tangential: int, normal: bool) -> Elements:
        numbers = (line_of(self.mu).slope, self.mu_static, self.stribeck, self.damping, self.viscosity)
        return self.under_load((self.kt,) * tangential, normal, numbers)

    def parameter_scales(self, force: float, width: float) -> Array:
        return np.array([1.0, 1.0, self.stribeck, 1.0 / self.stribeck, 1.0 / self.stribeck])

    def loop_energy(self, amplitude: float, z: float = 0.0) -> float:
        raise fault("The loop energy of a lugre contact", "must be asked for at a frequency", "a displacement alone")

    def virgin_curve(self, u: float, z: float = 0.0) -> float:
        raise fault("The force of a lugre contact", "must be asked for at a velocity", "a displacement alone")


@inner
def limit_at(parameter: Array, velocity: float) -> tuple[float, float]:
    """g(v)/μ and its derivative by v."""
    rise, share = parameter[1] / parameter[0] - 1.0, velocity / parameter[2]
    extra = rise * np.exp(-share * share)
    return 1.0 + extra, -2.0 * extra * share / parameter[2]


@separate(step_signature)
def step(data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """The bristles by the mean speed and the mean load of the step, and the viscous parts by the velocity after it."""
    mu, damping, viscosity, static = (
        data.parameter[0],
        data.parameter[3],
        data.parameter[4],
        data.parameter[1] / data.parameter[0],
    )
    work, L, L1 = 0.0, 0.5 * (motion.limit0 + motion.limit), motion.limit
    for d in range(data.kt.size):
        kt, T0, travel, v = data.kt[d], motion.state[d], motion.travel[d], motion.velocity[d]
        if L1 <= 0.0:
            work += 0.5 * T0 * T0 / kt
            continue
        speed = travel / motion.time if motion.time > 0.0 else 0.0
        high, slope = limit_at(data.parameter, speed)
        T1, by_T0, by_travel, by_limit, more = dahl_travel(kt, T0, travel, L * high)
        if abs(T1) > L1 * static:
            side, more = beyond_limit(kt, T0, T1, travel, L * static, L1 * static, more)
            T1 = forces.state[d] = side * L1 * static
            forces.by_limit[d] = side * static
        else:
            forces.state[d], forces.by_state[d, d], forces.by_travel[d, d] = T1, by_T0, by_travel
            forces.by_limit0[d] = forces.by_limit[d] = 0.5 * by_limit * high
            if motion.time > 0.0:
                by_speed = by_limit * L * slope
                forces.by_travel[d, d] += by_speed / motion.time
                forces.by_time[d] = -by_speed * speed / motion.time
        work += more
        now, falls = limit_at(data.parameter, v)
        forces.direct[d] = (damping * (L1 * v - abs(v) * T1 / now) + viscosity * L1 * v) / mu
        forces.direct_by_state[d, d] = -damping * abs(v) / (now * mu)
        by_v = damping * (L1 - np.sign(v) * T1 / now + abs(v) * T1 * falls / now**2) + viscosity * L1
        forces.direct_by_velocity[d, d] = by_v / mu
        forces.direct_by_limit[d] = (damping + viscosity) * v / mu
    return work
