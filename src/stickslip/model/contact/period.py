"""Exact evaluation of one friction element over a period by composition of clamp functions.

The Jenkins step T_n = clamp(T_{n−1} + kt(u_n − u_{n−1}), −L_n, +L_n) in the intercept y = T − kt u (y = −kt × slider
position) is a pure clamp, y_n = clamp(y_{n−1}, −L_n − kt u_n, L_n − kt u_n). Clamps compose to a clamp, so the period map is a
projection onto an interval [LO, HI]: LO = HI means a unique force; LO < HI that the element never slips in the steady
period and that any y in [LO, HI] is a solution, the non-uniqueness of friction forces.

An element that is open at one sample and closed at the next lands between them. Its slider begins where it lands; from the sample
itself the force would be of first order in the samples.
"""

from __future__ import annotations

import numpy as np

from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inlined, kernel

OFFSET, RATIO, MEAN = 0, 1, 2
"""Codes of the start rules, as `stickslip.model.contact.point` gives them."""

STICK, SLIP_UP, SLIP_DOWN, OPEN = 0, 1, -1, 2
"""What an element does at a sample; the sign of a slip is that of the traction."""

SLIP = SLIP_UP
"""Slip in any direction, where the traction has no sign or none is asked for."""

HELD, STATIC, SLIPPING = 0, 1, 2
"""How much of a row is unknown: nothing (λ known in advance), its harmonic 0, or all harmonics."""


@kernel
def landing_shares(z: Array, limit: Array, slope: Array, landing: Array) -> None:
    """Fill, for each sample where an element is open, the share of the step to the next at which it lands, 0 where it does not:
    z moves straight between samples [m], and the limit L [N] grows from 0 with dL/dz = slope [N/m] of the next; all (Nt,)."""
    for n in range(limit.size):
        m = n + 1 if n + 1 < limit.size else 0
        landing[n] = 0.0
        if limit[n] <= 0.0 < limit[m] and slope[m] > 0.0 and z[m] > z[n]:
            landing[n] = max(1.0 - limit[m] / (slope[m] * (z[m] - z[n])), 0.0)


@inlined
def carried(ku: Array, landing: Array, n: int) -> float:
    """kt u at a sample, or where an element that is open there lands before the next."""
    m = n + 1 if n + 1 < ku.size else 0
    return ku[n] + landing[n] * (ku[m] - ku[n])  # type: ignore[no-any-return]


@kernel
def stick_interval(ku: Array, limit: Array, landing: Array) -> tuple[float, float]:
    """[LO, HI] of the intercept y over samples 0..Nt−1 in this order. ku = kt u [N], limit L [N], `landing_shares`, (Nt,)."""
    low, high = -np.inf, np.inf
    for n in range(ku.size):
        place = carried(ku, landing, n)
        bottom, top = -limit[n] - place, limit[n] - place
        low = min(max(low, bottom), top)
        high = min(max(high, bottom), top)
    return low, high


@kernel
def start_intercept(kind: int, value: float, kt: float, ku: Array, limit: Array, mean: float) -> float:
    """y of the start rule, before it is clipped to [LO, HI]: offset −kt s, ratio m L_last − kt u_last, mean T̄ − kt ū."""
    if kind == OFFSET:
        return -kt * value
    if kind == RATIO:
        return float(value * limit[-1] - ku[-1])
    return value - mean


@kernel
def friction_period(
    kind: int, value: float, kt: float, ku: Array, limit: Array, landing: Array, mean: float, y: Array, event: Index
) -> tuple[int, int, float]:
    """Fill the steady period of intercepts y and events (Nt,), and say what it depends on: (state, sample, factor).

    state HELD: y is the start offset, a constant. STATIC: y = factor L_sample − kt u_sample, constant in time (sample = −1:
    y = value − kt ū). SLIPPING: y follows the last event. landing: `landing_shares`; mean: kt times that of u.
    """
    samples = ku.size
    low, high = stick_interval(ku, limit, landing)
    wanted = start_intercept(kind, value, kt, ku, limit, mean)
    y0 = min(max(wanted, low), high)
    events = 0
    previous = y0
    for n in range(samples):
        bottom, top = -limit[n] - ku[n], limit[n] - ku[n]
        event[n] = STICK
        if limit[n] <= 0.0:
            event[n] = OPEN
        elif previous > top:
            event[n] = SLIP_UP
        elif previous < bottom:
            event[n] = SLIP_DOWN
        if event[n] == OPEN:
            events += 1
            y[n], previous = -ku[n], -carried(ku, landing, n)
            continue
        if event[n] != STICK:
            events += 1
            previous = min(max(previous, bottom), top)
        y[n] = previous
    if events > 0:
        return SLIPPING, 0, 0.0
    if low < high and low <= wanted <= high:
        if kind == OFFSET:
            return HELD, 0, 0.0
        if kind == RATIO:
            return STATIC, samples - 1, value
        return STATIC, -1, 0.0
    sign = 1.0 if wanted > y0 else -1.0
    nearest = 0
    for n in range(samples):
        if limit[n] - sign * ku[n] < limit[nearest] - sign * ku[nearest]:
            nearest = n
    return STATIC, nearest, sign
