"""Dahl's law: friction that yields smoothly from the first motion on, a spring kt at every reversal and gross slip far from it.

Along a straight step at one limit the law is linear, so that a step is closed form: T decays exponentially towards ±L. That step
is all there is to it, as of Valanis' law.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stickslip.model.contact.law import Elements, Friction, Yielding
from stickslip.model.contact.protocol import ContactData, StepForces, StepMotion, step_signature
from stickslip.support.kernels import inner, separate


@dataclass(frozen=True)
class Dahl(Yielding):
    """dT/du = kt (1 − sgn(u̇) T/L), |T| ≤ L = μN, in each of one or two tangential directions.

    The parameters are those of `Macroslip`: kt [N/m] is the slope at each reversal. Every motion, however small, dissipates, and
    forgets the start state: at constant load a fraction exp(−kt s/L) of it is left after a travel s, whatever it was.
    Accuracy: exact where the motion goes straight from one sample to the next under a constant limit, else of second order; a
    step takes the mean of its two limits. Where the limit falls below the traction, the traction follows the limit.
    Source: Dahl, AIAA Journal 14 (1976) 1675-1682, with exponent 1.
    """

    kt: float
    mu: Friction
    kn: float | None = None
    preload: float = 0.0
    gap: float = 0.0
    normal_load: float | None = None

    name: ClassVar[str] = "dahl"
    about: ClassVar[str] = (
        "Friction that yields gradually from the smallest motion on. It never sticks and has no start state; kt is the slope at "
        "a reversal."
    )

    @classmethod
    def kernels(cls) -> tuple[Callable[..., Any], ...]:
        return (step,)

    def elements(self, tangential: int, normal: bool) -> Elements:
        return self.under_load((self.kt,) * tangential, normal)

    def loop_energy(self, amplitude: float, z: float = 0.0) -> float:
        """Energy per cycle of u = A cos ωt at constant z, 4 L (A − L/kt tanh(kt A/L)), J."""
        limit = self._limit(z)
        return 4.0 * limit * (amplitude - limit / self.kt * float(np.tanh(self.kt * amplitude / limit))) if limit > 0.0 else 0.0

    def virgin_curve(self, u: float, z: float = 0.0) -> float:
        """Traction on first loading at constant z, L (1 − exp(−kt |u|/L)) along u, N."""
        limit = self._limit(z)
        return float(-np.sign(u) * limit * np.expm1(-self.kt * abs(u) / limit)) if limit > 0.0 else 0.0


@inner
def beyond_limit(kt: float, T0: float, T1: float, du: float, L: float, L1: float, work: float) -> tuple[float, float]:
    """Of a step whose traction T1 follows a limit L1 that falls below it: on which side, and its friction work, of which `work`
    is that up to T1; L: the mean limit."""
    side = np.sign(T1)
    # The law would count a traction above the mean limit twice, and the sum over the samples be of first order.
    if abs(T0) > L:
        return side, 0.5 * (T0 + side * L1) * (du - (side * L1 - T0) / kt)
    return side, work + 0.5 * (T1 * T1 - L1 * L1) / kt


@inner
def dahl_travel(kt: float, T0: float, du: float, L: float) -> tuple[float, float, float, float, float]:
    """Along a travel from traction T0 at one limit L > 0: T1, its derivatives by T0, du and L, and the friction work.

    With x = kt |du|/L: T1 = s L + (T0 − s L) exp(−x), and the work ∫ T²/L |du|.
    """
    s, x = np.sign(du), kt * abs(du) / L
    kept, lost = np.exp(-x), -np.expm1(-x)
    off = T0 - s * L
    work = (L * L * x + 2.0 * s * L * off * lost + 0.5 * off * off * lost * (1.0 + kept)) / kt if s != 0.0 else 0.0
    return T0 * kept + s * L * lost, kept, kt * kept * (1.0 - s * T0 / L), s * lost + off * kept * x / L, work


@inner
def dahl_step(kt: float, T0: float, du: float, L0: float, L1: float) -> tuple[float, float, float, float, float, float]:
    """One step from traction T0, the limit going from L0 to L1: T1, its derivatives by T0, du, L0, L1, and the friction work.

    A travel at the mean limit. What a falling limit takes from the traction goes from the spring into friction; where it leads
    along the step, the work is T Δ(u − T/kt).
    """
    if L1 <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.5 * T0 * T0 / kt
    L = 0.5 * (L0 + L1)
    T1, by_T0, by_du, by_limit, work = dahl_travel(kt, T0, du, L)
    if abs(T1) > L1:
        side, work = beyond_limit(kt, T0, T1, du, L, L1, work)
        return side * L1, 0.0, 0.0, 0.0, side, work
    return T1, by_T0, by_du, 0.5 * by_limit, 0.5 * by_limit, work


@separate(step_signature)
def step(data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """Tractions after a step from the earlier ones."""
    work = 0.0
    for d in range(data.kt.size):
        found = dahl_step(data.kt[d], motion.state[d], motion.travel[d], motion.limit0, motion.limit)
        forces.state[d], forces.by_state[d, d], forces.by_travel[d, d] = found[0], found[1], found[2]
        forces.by_limit0[d], forces.by_limit[d] = found[3], found[4]
        work += found[5]
    return work
