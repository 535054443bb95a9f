"""Friction disc: the two tangential directions coupled, |T| ≤ μN as a disc, along straight steps of motion and limit.

The spring sticks until T meets the edge; from there T turns towards the motion on it. With the angle ψ from T to a motion of
speed v, ψ' = −(kt v/L) sin ψ, so that tan(ψ/2) falls by exp(−kt ∫ ds/L) over a step: closed form, where the usual projection of
the spring's force onto the disc is of first order in the samples. Along one line, and at rest, both are the same.

In the intercept y = T − kt u (2-vector) a step never takes two states apart from each other. Unlike the clamps of one direction,
steps do not compose to a closed form: the period is marched until it repeats, and the derivative is
carried along from the start, since a contact can come to rest on the edge of its disc, where the transient stays in it. Forward,
not in reverse: the derivative changes only at slipping samples, and no harmonic need be carried through the transient. It has
to repeat as well: along a line the state does so after a period, a small motion across the line after many.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stickslip.model.contact.law import Elements, Friction, Law
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.protocol import (
    HELD,
    NOT_PERIODIC,
    OPEN,
    RATIO,
    SLIP,
    SLIPPING,
    STATIC,
    STICK,
    ContactData,
    PeriodForces,
    PeriodMotion,
    StepForces,
    StepMotion,
    period_signature,
    step_signature,
)
from stickslip.support.checks import Array, Index, fault
from stickslip.support.kernels import inner, kernel, separate

PERIODS = 200
"""Periods after which a contact that has not become periodic is given up."""

JUMP = 4
"""After so many periods each time, the limit of the creep is taken at once, by Newton's method on the period map."""

TOLERANCE = 1e-14
"""Change of the intercepts over a period, relative to the forces, at which a period counts as repeating."""

SETTLED = 1e-10
"""Error of the derivative, relative to the stiffness, at which it counts as that of the steady period."""


@dataclass(frozen=True)
class FrictionDisc(Law):
    """Macroslip with two coupled tangential directions: a spring kt in each, |(T1, T2)| ≤ μN.

    The parameters are those of `Macroslip`. Starts: a slider position (s1, s2) or a ratio with |(m1, m2)| ≤ 1, one value per
    direction; the traction it gives at the last sample is clipped onto the disc.
    Accuracy: second order in the samples, exact where motion and limit go straight from one to the next.
    Source: the law is that of Menq and Yang (1998); the closed form of a step is ours.
    """

    kt: float
    mu: Friction
    kn: float | None = None
    preload: float = 0.0
    gap: float = 0.0
    normal_load: float | None = None

    couples_directions: ClassVar[bool] = True
    incrementally_passive: ClassVar[bool] = True

    def __post_init__(self) -> None:
        _ = self._one_direction

    @property
    def _one_direction(self) -> Macroslip:
        return Macroslip(self.kt, self.mu, self.kn, self.preload, self.gap, self.normal_load)

    @classmethod
    def kernels(cls) -> tuple[Callable[..., Any], ...]:
        return step, period

    def elements(self, tangential: int, normal: bool) -> Elements:
        if tangential != 2:
            raise fault("A friction disc", "must have two tangential directions", tangential, "Use macroslip for one.")
        return self._one_direction.elements(2, normal)


@separate(period_signature)
def period(data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """The steady period of both directions: slip at any sample, a start that the disc clips or gives, or neither."""
    periods, acted = _until_periodic(data, motion, forces)
    y, limit = forces.y, motion.limit
    forces.intercept[:] = y
    for n in range(limit.size):
        slipped = np.hypot(y[0, n] - y[0, n - 1], y[1, n] - y[1, n - 1]) / data.kt[0]
        forces.work[0] += 0.5 * (limit[n] + limit[n - 1]) * slipped
    if periods < 0:
        return NOT_PERIODIC
    if np.any(forces.event != STICK):
        return SLIPPING
    return STATIC if acted else HELD


@separate(step_signature)
def step(data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """Tractions after a step of both directions; the work L |Δs| of the slider, L at the middle of the step."""
    kt, L, turn, T, travel = data.kt[0], motion.limit, np.empty(6), motion.state, motion.travel
    slips, c, s = disc_step(T[0], T[1], kt * travel[0], kt * travel[1], motion.limit0, L, turn)
    if not slips:
        for d in range(2):
            forces.state[d], forces.by_state[d, d], forces.by_travel[d, d] = T[d] + kt * travel[d], 1.0, kt
        return 0.0
    forces.state[0], forces.state[1] = L * c, L * s
    for d in range(2):
        forces.by_state[0, d], forces.by_state[1, d] = -s * L * turn[d], c * L * turn[d]
        forces.by_travel[0, d], forces.by_travel[1, d] = -kt * s * L * turn[2 + d], kt * c * L * turn[2 + d]
    forces.by_limit0[0], forces.by_limit0[1] = -s * L * turn[4], c * L * turn[4]
    forces.by_limit[0], forces.by_limit[1] = c - s * L * turn[5], s + c * L * turn[5]
    slid = np.hypot(forces.state[0] - T[0] - kt * travel[0], forces.state[1] - T[1] - kt * travel[1]) / kt
    return float(0.5 * (L + motion.limit0) * slid)


@inner
def _until_periodic(data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> tuple[int, bool]:
    """March the period until it repeats: fill the intercepts, events and, if asked for, derivatives of the steady one.

    Returns the periods marched (−1: not periodic) and whether anything, the clipping of the start included, ever acted. Along a
    line the state repeats at once, long before the derivative across it, which is then brought to its own limit.
    """
    kinds, values, kt = data.start_kind, data.start_value, data.kt[0]
    u, limit, slope, E, last = motion.u, motion.limit, motion.slope, motion.E, motion.limit.size - 1
    y, event, tangents = forces.y, forces.event, forces.tangents
    columns = E.shape[1]
    derive = tangents.size > 0
    state = np.zeros(2)
    change = np.zeros((2, 3, columns))
    map_ = np.zeros((2, 2))
    for d in range(2):
        state[d] = -kt * values[d]
        if kinds[d] == RATIO:
            state[d] = values[d] * limit[last] - kt * u[d, last]
            for j in range(columns):
                change[d, 2, j] = values[d] * slope[last] * E[last, j]
                change[d, d, j] = -kt * E[last, j]
    turn = np.zeros(6)
    acted = kinds[0] == RATIO or kinds[1] == RATIO
    acted = _step(kt, motion, 0.0, last, last, state, change, map_, derive, turn) or acted
    size, steepness = max(np.max(limit), kt * np.max(np.abs(u))), kt + np.max(np.abs(slope))
    for period in range(PERIODS):
        before, before_change = state.copy(), change.copy()
        slipped = _march(kt, motion, state, change, map_, turn, y, event, tangents)
        acted = acted or slipped
        settled = abs(state[0] - before[0]) <= TOLERANCE * size and abs(state[1] - before[1]) <= TOLERANCE * size
        if not slipped or settled:
            unsettled = slipped and derive and not _repeats(map_, before_change, change, steepness)
            if unsettled and _jump(map_, state.copy(), before_change, state, change):
                _march(kt, motion, state, change, map_, turn, y, event, tangents)
            return period + 1, acted
        if period % JUMP == JUMP - 1:
            _jump(map_, before, before_change, state, change)
    return -1, acted


@inner
def _march(
    kt: float,
    motion: PeriodMotion,
    state: Array,
    change: Array,
    map_: Array,
    turn: Array,
    y: Array,
    event: Index,
    tangents: Array,
) -> bool:
    """One period: intercepts, events and derivatives of every sample, and the map of the period; whether anything slips."""
    samples, derive = motion.limit.size, tangents.size > 0
    map_[0, 0], map_[0, 1], map_[1, 0], map_[1, 1] = 1.0, 0.0, 0.0, 1.0
    slipped = False
    for n in range(samples):
        before = (n - 1) % samples
        share = motion.landing[before]
        if share > 0.0:
            _land(kt, motion, share, before, n, state, change, derive)
        hit = _step(kt, motion, share, before, n, state, change, map_, derive, turn)
        event[n] = OPEN if motion.limit[n] <= 0.0 else (SLIP if hit else STICK)
        slipped = slipped or hit
        y[0, n], y[1, n] = state[0], state[1]
        if derive:
            tangents[n] = change
    return slipped


@inner
def _decay(map_: Array) -> float:
    """det(I − A) of the map of a period: one slip makes A rank one, of eigenvalues 0 and λ, and 1 − λ of a deviation dies out."""
    return float((1.0 - map_[0, 0]) * (1.0 - map_[1, 1]) - map_[0, 1] * map_[1, 0])


@inner
def _repeats(map_: Array, before: Array, change: Array, steepness: float) -> bool:
    """Whether the derivative repeats: all that later periods would still change, |Δ|/(1 − λ), is nothing."""
    largest = 0.0
    for d in range(2):
        for part in range(3):
            for j in range(change.shape[2]):
                largest = max(largest, abs(change[d, part, j] - before[d, part, j]))
    return largest <= SETTLED * steepness * _decay(map_)


@inner
def _jump(map_: Array, before: Array, before_change: Array, state: Array, change: Array) -> bool:
    """From y to y + (I − A)⁻¹ (Φ(y) − y), A = dΦ/dy of the last period, and the derivative likewise; slow creep ends at once.

    Nothing happens where A has an eigenvalue near one: there the contact may rest anywhere along a direction. Returns whether
    anything does.
    """
    a, b, c, d = 1.0 - map_[0, 0], -map_[0, 1], -map_[1, 0], 1.0 - map_[1, 1]
    determinant = _decay(map_)
    if abs(determinant) < 1e-7:
        return False
    x, y = state[0] - before[0], state[1] - before[1]
    state[0] = before[0] + (d * x - b * y) / determinant
    state[1] = before[1] + (a * y - c * x) / determinant
    for part in range(3):
        for j in range(change.shape[2]):
            x, y = change[0, part, j] - before_change[0, part, j], change[1, part, j] - before_change[1, part, j]
            change[0, part, j] = before_change[0, part, j] + (d * x - b * y) / determinant
            change[1, part, j] = before_change[1, part, j] + (a * y - c * x) / determinant
    return True


@inner
def _land(kt: float, motion: PeriodMotion, share: float, before: int, n: int, state: Array, change: Array, derive: bool) -> None:
    """The intercept where the contact lands, at a share of the step to sample n, and its derivative: the share moves with z."""
    u, E = motion.u, motion.E
    for d in range(2):
        moved = u[d, n] - u[d, before]
        state[d] = -kt * (u[d, before] + share * moved)
        for j in range(E.shape[1] if derive else 0):
            row = E[before, j] + share * (E[n, j] - E[before, j])
            change[d, 0, j] = change[d, 1, j] = 0.0
            change[d, d, j] = -kt * row
            change[d, 2, j] = kt * moved / (motion.z[n] - motion.z[before]) * row


@inner
def _step(
    kt: float,
    motion: PeriodMotion,
    share: float,
    before: int,
    n: int,
    state: Array,
    change: Array,
    map_: Array,
    derive: bool,
    turn: Array,
) -> bool:
    """From sample `before` to n (the same: clip): intercept, its derivative and the map of the period; whether it slips.

    share: of the step, which begins there; beyond 0 where the contact lands.
    """
    u, limit, slope, E = motion.u, motion.limit, motion.slope, motion.E
    x, y = kt * (1.0 - share) * (u[0, n] - u[0, before]), kt * (1.0 - share) * (u[1, n] - u[1, before])
    first, second = state[0] + kt * u[0, n] - x, state[1] + kt * u[1, n] - y
    slips, c, s = disc_step(first, second, x, y, limit[before], limit[n], turn)
    if not slips:
        return False
    L = limit[n]
    state[0], state[1] = L * c - kt * u[0, n], L * s - kt * u[1, n]
    for d in range(2):
        along = L * (turn[0] * map_[0, d] + turn[1] * map_[1, d])
        map_[0, d], map_[1, d] = -s * along, c * along
    if derive:
        for part in range(3):
            for j in range(E.shape[1]):
                step = (1.0 - share) * (E[n, j] - E[before, j])
                along = turn[0] * change[0, part, j] + turn[1] * change[1, part, j]
                if part < 2:
                    along += kt * (turn[part] * (E[n, j] - step) + turn[2 + part] * step)
                else:
                    if share > 0.0:  # where it lands moves with z, the traction there does not
                        along += (turn[2] - turn[0]) * change[0, 2, j] + (turn[3] - turn[1]) * change[1, 2, j]
                    along += turn[4] * slope[before] * E[before, j] + turn[5] * slope[n] * E[n, j]
                change[0, part, j], change[1, part, j] = -s * L * along, c * L * along
        for j in range(E.shape[1]):
            change[0, 2, j] += c * slope[n] * E[n, j]
            change[1, 2, j] += s * slope[n] * E[n, j]
            change[0, 0, j] -= kt * E[n, j]
            change[1, 1, j] -= kt * E[n, j]
    return True


@kernel
def disc_step(tx: float, ty: float, x: float, y: float, L0: float, L1: float, turn: Array) -> tuple[bool, float, float]:
    """One step from the traction T0 = (tx, ty) with the spring's change (x, y) = kt Δu, while the limit goes from L0 to L1 [N].

    Returns whether it slips, and then the direction (c, s) of T1 = L1 (c, s); without slip T1 = T0 + kt Δu. Fills `turn` (6,):
    the derivative of the angle of T1 by tx, ty, x, y, L0, L1. The share τ of the step sticks: |T0 + τ kt Δu| = L0 + τ (L1 − L0).
    """
    turn[:] = 0.0
    if np.hypot(tx + x, ty + y) <= L1:
        return False, 0.0, 0.0
    if L1 <= 0.0:
        return True, 0.0, 0.0
    grows, v = L1 - L0, np.hypot(x, y)
    stuck = _stuck_share(tx, ty, x, y, L0, grows)
    rest, L = 1.0 - stuck, L0 + stuck * grows
    if L <= _NOTHING * L1:  # no traction before: it points where the spring does
        stuck, rest, v, L = 1.0, 0.0, 0.0, L1
    sx, sy = tx + stuck * x, ty + stuck * y
    size = np.hypot(sx, sy)
    c, s = sx / size, sy / size
    dx, dy = (x / v, y / v) if v > 0.0 else (c, s)
    cosine, sine = c * dx + s * dy, c * dy - s * dx
    mean, mean_by_L, mean_by_L1 = _inverse_mean(L, L1)
    q = v * rest * mean
    t, half = np.tanh(q), np.tanh(0.5 * q)
    whole = max(1.0 + cosine * t, _NOTHING)
    kept = 1.0 / (np.cosh(q) * whole)
    cosine1, sine1 = (cosine + t) / whole, sine * kept
    # angle of T1 = angle of the motion − ψ1: its change by the motion, by the angle at the edge (kept), and by q
    by_motion = (t / q if q > 0.0 else 1.0) * rest * mean * (half + cosine) / whole
    # τ itself does not count: the angle turns as fast just before slip as just after
    for i in range(6):
        angle, edge, after, along, aside = 0.0, 0.0, 0.0, 0.0, 0.0
        if i == 0 or i == 2:
            angle = -s / size * (1.0 if i == 0 else stuck)
        elif i == 1 or i == 3:
            angle = c / size * (1.0 if i == 1 else stuck)
        if i == 2:
            along, aside = dx, -dy
        elif i == 3:
            along, aside = dy, dx
        elif i == 4:
            edge = rest
        elif i == 5:
            edge, after = stuck, 1.0
        change = v * rest * (mean_by_L * edge + mean_by_L1 * after) + mean * rest * along
        turn[i] = by_motion * aside + kept * angle + sine1 * change
    return True, dx * cosine1 + dy * sine1, dy * cosine1 - dx * sine1


_NOTHING = 1e-12
"""Share of the limit below which there is none, as just after an open contact lands."""


@inner
def _stuck_share(tx: float, ty: float, x: float, y: float, L0: float, grows: float) -> float:
    """The share of a step before slip, which ends outside its disc: the last root of |T0 + τ kt Δu| = L0 + τ (L1 − L0)."""
    a, b = x * x + y * y - grows * grows, tx * x + ty * y - L0 * grows
    inside = min(tx * tx + ty * ty - L0 * L0, 0.0)
    root = np.sqrt(max(b * b - a * inside, 0.0))
    if b > 0.0:
        return float(min(-inside / (b + root), 1.0))
    return float(min((root - b) / a, 1.0)) if a > 0.0 else 0.0


@inner
def _inverse_mean(L: float, L1: float) -> tuple[float, float, float]:
    """Mean of 1/L while the limit goes from L to L1, ln(L1/L)/(L1 − L), and its derivatives by L and L1."""
    middle = 0.5 * (L + L1)
    r = 0.5 * (L1 - L) / middle
    if abs(r) < 1e-3:
        mean, slope = (1.0 + r * r / 3.0) / middle, 2.0 * r / (3.0 * middle)
        common = -0.5 * mean / middle
        return mean, common - 0.5 * slope * L1 / middle**2, common + 0.5 * slope * L / middle**2
    mean = np.log(L1 / L) / (L1 - L)
    return mean, (mean - 1.0 / L) / (L1 - L), (1.0 / L1 - mean) / (L1 - L)
