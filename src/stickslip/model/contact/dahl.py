"""Dahl's law: friction that yields smoothly from the first motion on, a spring kt at every reversal and gross slip far from it.

Along a straight step at one limit the law is linear, so that a step is closed form: T decays exponentially towards ±L. Steps are
clamped affine maps of T, and these compose: the steady period is found without iteration. Derivatives are carried along.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stickslip.model.contact.law import Elements, Friction, Yielding
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
from stickslip.support.checks import Array
from stickslip.support.kernels import inner, separate

STILL = 1e-12
"""Travel over a period, relative to the displacement, below which it is rounding: the contact then rests without traction."""


@dataclass(frozen=True)
class Dahl(Yielding):
    """dT/du = kt (1 − sgn(u̇) T/L), |T| ≤ L = μN, in each of one or two tangential directions.

    The parameters are those of `Macroslip`: kt [N/m] is the slope at each reversal. Every motion, however small, dissipates, and
    forgets the start state: at constant load a fraction exp(−kt s/L) of it is left after a travel s, whatever it was.
    Accuracy: exact where the motion goes straight from one sample to the next under a constant limit, else of second order; a
    step takes the mean of its two limits. Where the limit falls below the traction, the traction follows the limit.
    Source: Dahl, AIAA Journal 14 (1976) 1675-1682, with exponent 1; the closed form of the period is ours.
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
        return step, period

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


@inner
def _steady(kt: float, u: Array, limit: Array, landing: Array) -> tuple[float, float]:
    """The traction at the last sample of the steady period, and 1 − dT/dT of the period map where no limit clamps it.

    A step is T → clamp(α + a T, ±L_n), and so is the whole period: clamp(A + B T, low, high). Its fixed point is
    A/(1 − B), clamped.
    """
    A, exponent, travel = 0.0, 0.0, 0.0
    low, high = -limit[-1], limit[-1]
    for n in range(u.size):
        L = 0.5 * (limit[n - 1] + limit[n])
        du = (1.0 - landing[n - 1]) * (u[n] - u[n - 1])
        travel += abs(du)
        if limit[n] <= 0.0:
            A, low, high, exponent = 0.0, 0.0, 0.0, np.inf
            continue
        x = kt * abs(du) / L
        kept, gained = np.exp(-x), -np.sign(du) * L * np.expm1(-x)
        A = gained + kept * A
        low = min(max(gained + kept * low, -limit[n]), limit[n])
        high = min(max(gained + kept * high, -limit[n]), limit[n])
        exponent += x
    if travel <= STILL * np.max(np.abs(u)):
        return 0.0, np.inf
    lost = -np.expm1(-exponent)
    return min(max(A / lost if lost > 0.0 else 0.0, low), high), lost


@separate(period_signature)
def period(data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """The steady period, whatever the start; every harmonic is unknown at all times."""
    for n in range(motion.limit.size):
        forces.event[n] = SLIP if motion.limit[n] > 0.0 else OPEN
    for d in range(data.kt.size):
        _direction(data.kt[d], d, motion, forces)
    return SLIPPING


@inner
def _direction(kt: float, d: int, motion: PeriodMotion, forces: PeriodForces) -> None:
    """One direction. The derivative is carried from a fixed start, then what the start's own change adds is put on top."""
    u, limit, slope, E = motion.u[d], motion.limit, motion.slope, motion.E
    samples, columns = u.size, E.shape[1]
    traction, lost = _steady(kt, u, limit, motion.landing)
    kept, by_start = np.empty(samples), 1.0
    by_u, by_z = np.zeros(columns), np.zeros(columns)
    for n in range(samples):
        before = n - 1 if n else samples - 1
        share = motion.landing[before]
        du = (1.0 - share) * (u[n] - u[before])
        traction, by_before, by_du, by_L0, by_L1, work = dahl_step(kt, traction, du, limit[before], limit[n])
        by_start *= by_before
        kept[n] = by_start
        forces.y[d, n] = forces.intercept[d, n] = traction - kt * u[n]
        forces.work[d] += work
        for j in range(columns):
            step = E[n, j] - E[before, j]
            by_u[j] = by_before * by_u[j] + by_du * (1.0 - share) * step
            by_z[j] = by_before * by_z[j] + by_L0 * slope[before] * E[before, j] + by_L1 * slope[n] * E[n, j]
            if share > 0.0:
                by_z[j] += by_du * (u[n] - u[before]) / (motion.z[n] - motion.z[before]) * (E[before, j] + share * step)
            forces.tangents[n, d, d, j], forces.tangents[n, d, 2, j] = by_u[j] - kt * E[n, j], by_z[j]
    if by_start == 0.0:
        lost = 1.0
    for n in range(samples if columns else 0):
        for j in range(columns):
            forces.tangents[n, d, d, j] += kept[n] * by_u[j] / lost
            forces.tangents[n, d, 2, j] += kept[n] * by_z[j] / lost


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
