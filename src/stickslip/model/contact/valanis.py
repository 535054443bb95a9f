"""Valanis' law: friction that yields smoothly, from Dahl's law to a spring and slider by one number.

Along a straight step at one limit the law has a closed form, an equation in one unknown. The step is all there is to it: the
steady period, its derivatives and the stability of a motion follow from it (`stickslip.model.contact.march`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stickslip.model.contact.dahl import beyond_limit
from stickslip.model.contact.law import Elements, Friction, Yielding, own
from stickslip.model.contact.protocol import ContactData, StepForces, StepMotion, step_signature
from stickslip.support.checks import Array
from stickslip.support.kernels import inner, separate, uncompiled

HALVINGS = 100
"""In which the search for the largest traction of a loop ends at the last digit."""


@dataclass(frozen=True)
class Valanis(Yielding):
    """dT/du = kt (1 − s T/L)/(1 − κ s T/L), s = sgn(u̇), |T| ≤ L = μN, in each of one or two tangential directions.

    kt [N/m] is the slope at T = 0, and for κ = 0 also at each reversal; mu [-]; kappa κ [-], 0 ≤ κ < 1: how late friction yields.
    κ = 0 is `Dahl`, κ towards 1 `Macroslip`. kn, preload, gap, normal_load: the load N, as for `Macroslip`. Every motion, however
    small, dissipates energy, and the contact forgets its start state. For a stiffness Et that remains after slip, add a spring Et
    in parallel, with kt = E0 − Et and κ (E0 − Et)/(E0 − κ Et) in place of E0 and κ.
    Accuracy: exact where the motion goes straight from one sample to the next under a constant limit, otherwise of second order,
    as for `Dahl`.
    Source: Valanis, Archives of Mechanics 23 (1971) 517-551; Gaul and Nitsche, Applied Mechanics Reviews 54 (2001) 93-106.
    """

    kt: float
    mu: Friction
    kappa: float = own("how late friction yields: 0 gives `dahl`, values near 1 `macroslip`", least=0.0, below=1.0)
    kn: float | None = None
    preload: float = 0.0
    gap: float = 0.0
    normal_load: float | None = None

    name: ClassVar[str] = "valanis"
    about: ClassVar[str] = (
        "Friction that yields gradually, between `dahl` and `macroslip`. It never sticks and has no start state; kt is the slope "
        "at T = 0."
    )

    @classmethod
    def kernels(cls) -> tuple[Callable[..., Any], ...]:
        return (step,)

    def elements(self, tangential: int, normal: bool) -> Elements:
        return self.under_load((self.kt,) * tangential, normal, (self.kappa,))

    def parameter_scales(self, force: float, width: float) -> Array:
        return np.ones(1)

    def loop_energy(self, amplitude: float, z: float = 0.0) -> float:
        """Energy per cycle of u = A cos ωt at constant z, 4 L (A − τ L/kt) with κ τ + (1 − κ) artanh τ = kt A/L, J."""
        limit = self._limit(z)
        if limit <= 0.0 or amplitude == 0.0:
            return 0.0
        reach = self.kt * amplitude / limit

        def left(angle: float) -> float:
            return self.kappa * float(np.tanh(angle)) + (1.0 - self.kappa) * angle - reach

        low, high = 0.0, reach / (1.0 - self.kappa)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if left(middle) < 0.0 else (low, middle)
        share = float(np.tanh(high))
        return 4.0 * limit * (amplitude - share * limit / self.kt)

    def virgin_curve(self, u: float, z: float = 0.0) -> float:
        """Traction on first loading at constant z, L (1 − w) along u with κ (w − 1) + (1 − κ) ln w = −kt |u|/L, N."""
        limit = self._limit(z)
        if limit <= 0.0:
            return 0.0
        return float(np.sign(u) * limit * (1.0 - uncompiled(share_left)(1.0, self.kt * abs(u) / limit, self.kappa)))


@inner
def share_left(w0: float, x: float, kappa: float) -> float:
    """w > 0 with κ w + (1 − κ) ln w = κ w0 + (1 − κ) ln w0 − x, for w0 > 0: what is left of 1 − s T/L after a travel x L/kt.

    With y = κ w/(1 − κ): y + ln y = C. A start by the size of C, then the iteration of Fritsch, Shafer and Crowley (1973), of
    fourth order.
    """
    ratio = kappa / (1.0 - kappa)
    if ratio * w0 <= 0.0:
        return w0 * np.exp(-x)  # type: ignore[no-any-return]
    C = np.log(ratio * w0) + ratio * w0 - x / (1.0 - kappa)
    if C < -36.0:
        return np.exp(C) / ratio  # type: ignore[no-any-return]
    y = C - np.log(C) if C > 1.0 else np.exp(2.0 / 3.0 * (C - 1.0)) if C > -2.0 else np.exp(C)
    for _ in range(4):
        off, more = C - y - np.log(y), 1.0 + y
        q = more * (more + 2.0 / 3.0 * off)
        y *= 1.0 + off / more * (q - 0.5 * off) / (q - off)
    return y / ratio  # type: ignore[no-any-return]


@inner
def valanis_step(
    kt: float, kappa: float, T0: float, du: float, L0: float, L1: float
) -> tuple[float, float, float, float, float, float]:
    """One step from traction T0, the limit going from L0 to L1: T1, its derivatives by T0, du, L0, L1, and the friction work.

    With the mean limit L, x = kt |du|/L and w = 1 − s T/L: `share_left`, so that dw = m(w) (dw0/m(w0) − dx) with
    m(w) = w/(κ w + 1 − κ), and the work ∫ T (1 − T'/kt) du = L²/kt (x + (2 − κ) Δw − (1 − κ) Δw²/2).
    """
    if L1 <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.5 * T0 * T0 / kt
    L, s = 0.5 * (L0 + L1), np.sign(du)
    if s == 0.0:
        T1, w, work, by_T0, by_du, by_limit = T0, 1.0, 0.0, 1.0, kt, 0.0
    else:
        x, w0 = kt * abs(du) / L, 1.0 - s * T0 / L
        if w0 > 0.0:
            w = share_left(w0, x, kappa)
            if w > 0.5 * w0:  # a small travel in full digits: what w0 itself has lost to rounding does not matter
                grown = w - w0
                off = kappa * grown + (1.0 - kappa) * np.log1p(grown / w0) + x
                grown -= off / (kappa + (1.0 - kappa) / (w0 + grown))
            else:
                grown = w - w0
            w, kept = w0 + grown, (w0 + grown) / w0
        else:  # beyond the mean limit, where the limit at the end is what counts
            kept = np.exp(-x / (1.0 - kappa))
            w, grown = w0 * kept, w0 * (kept - 1.0)
        slope = w / (kappa * w + 1.0 - kappa)
        by_T0, by_du = kept * (kappa * w0 + 1.0 - kappa) / (kappa * w + 1.0 - kappa), kt * slope
        by_limit = 0.5 * (s * (1.0 - w) - by_T0 * T0 / L - s * slope * x)
        T1 = T0 - s * L * grown
        work = L * L / kt * (x + (2.0 - kappa) * grown - 0.5 * (1.0 - kappa) * (w * w - w0 * w0))
    if abs(T1) > L1:
        side, work = beyond_limit(kt, T0, T1, du, L, L1, work)
        return side * L1, 0.0, 0.0, 0.0, side, work
    return T1, by_T0, by_du, by_limit, by_limit, work


@separate(step_signature)
def step(data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """Tractions after a step from the earlier ones."""
    work = 0.0
    for d in range(data.kt.size):
        found = valanis_step(data.kt[d], data.parameter[0], motion.state[d], motion.travel[d], motion.limit0, motion.limit)
        forces.state[d], forces.by_state[d, d], forces.by_travel[d, d] = found[0], found[1], found[2]
        forces.by_limit0[d], forces.by_limit[d] = found[3], found[4]
        work += found[5]
    return work
