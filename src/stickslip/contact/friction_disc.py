"""Friction disc: the two tangential directions coupled, |T| ≤ μN as a disc, T following it by return mapping.

In the intercept y = T − kt u (2-vector) a step projects y onto the disc of centre −kt u_n and radius L_n. Unlike the clamp of
one direction, projections do not compose to a closed form: the period is marched until it repeats, and the derivative is
carried along from the start, since a contact can come to rest on the edge of its disc, where the transient stays in it. Forward,
not in reverse: the derivative changes only at slipping samples, and no harmonic need be carried through the transient.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stickslip.checks import Array, Index, fault
from stickslip.contact.law import Elements, Law
from stickslip.contact.macroslip import Macroslip
from stickslip.contact.period import OPEN, RATIO, STICK
from stickslip.kernels import kernel

PERIODS = 200
"""Periods after which a contact that has not become periodic is given up."""

JUMP = 4
"""After so many periods each time, the limit of the creep is taken at once, by Newton's method on the period map."""

TOLERANCE = 1e-14
"""Change of the intercepts over a period, relative to the forces, at which a period counts as repeating."""

SLIP = 1


@dataclass(frozen=True)
class FrictionDisc(Law):
    """Macroslip with two coupled tangential directions: a spring kt in each, |(T1, T2)| ≤ μN.

    The parameters are those of `Macroslip`. Starts: a slider position (s1, s2) or a ratio with |(m1, m2)| ≤ 1, one value per
    direction; the traction it gives at the last sample is clipped onto the disc.
    Accuracy: second order in the samples along a straight line, first order where the slip direction turns (0.4 % of the loop
    energy of a circular motion at 256 samples).
    Source: Menq and Yang (1998), in the implicit form of return mapping.
    """

    kt: float
    mu: float
    kn: float | None = None
    preload: float = 0.0
    gap: float = 0.0
    normal_load: float | None = None

    def __post_init__(self) -> None:
        _ = self._one_direction

    @property
    def _one_direction(self) -> Macroslip:
        return Macroslip(self.kt, self.mu, self.kn, self.preload, self.gap, self.normal_load)

    @property
    def has_normal(self) -> bool:
        return self.kn is not None

    def elements(self, tangential: int, normal: bool) -> Elements:
        if tangential != 2:
            raise fault("A friction disc", "must have two tangential directions", tangential, "Use macroslip for one.")
        return replace(self._one_direction.elements(2, normal), coupled=True)


@kernel
def disc_period(
    kinds: Index,
    values: Array,
    kt: float,
    u: Array,
    limit: Array,
    slope: Array,
    E: Array,
    y: Array,
    event: Index,
    tangents: Array,
) -> tuple[int, bool]:
    """March the period until it repeats: fill the intercepts y (2, Nt) and events (Nt,) of the steady one.

    u (2, Nt) [m]; limit L and slope dL/dz (Nt,); kinds, values (2,): the start of each direction. tangents (Nt, 2, 3, 2H+1), or
    empty: filled with dy/d(U1, U2, Z) after each event. Returns the periods marched (−1: not periodic) and whether anything,
    the clipping of the start included, ever acted.
    """
    samples, columns = u.shape[1], E.shape[1]
    last = samples - 1
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
    acted = kinds[0] == RATIO or kinds[1] == RATIO
    acted = _project(kt, u, limit, slope, E, last, state, change, map_, derive) or acted
    size = max(np.max(limit), kt * np.max(np.abs(u)))
    for period in range(PERIODS):
        before, before_change = state.copy(), change.copy()
        map_[0, 0], map_[0, 1], map_[1, 0], map_[1, 1] = 1.0, 0.0, 0.0, 1.0
        slipped = False
        for n in range(samples):
            hit = _project(kt, u, limit, slope, E, n, state, change, map_, derive)
            event[n] = OPEN if limit[n] <= 0.0 else (SLIP if hit else STICK)
            slipped = slipped or hit
            y[0, n], y[1, n] = state[0], state[1]
            if derive:
                tangents[n] = change
        acted = acted or slipped
        settled = abs(state[0] - before[0]) <= TOLERANCE * size and abs(state[1] - before[1]) <= TOLERANCE * size
        if not slipped or settled:
            return period + 1, acted
        if period % JUMP == JUMP - 1:
            _jump(map_, before, before_change, state, change)
    return -1, acted


@kernel
def _jump(map_: Array, before: Array, before_change: Array, state: Array, change: Array) -> None:
    """From y to y + (I − A)⁻¹ (Φ(y) − y), A = dΦ/dy of the last period, and the derivative likewise; slow creep ends at once.

    Nothing happens where A has an eigenvalue near one: there the contact may rest anywhere along a direction.
    """
    a, b, c, d = 1.0 - map_[0, 0], -map_[0, 1], -map_[1, 0], 1.0 - map_[1, 1]
    determinant = a * d - b * c
    if abs(determinant) < 1e-7:
        return
    x, y = state[0] - before[0], state[1] - before[1]
    state[0] = before[0] + (d * x - b * y) / determinant
    state[1] = before[1] + (a * y - c * x) / determinant
    for part in range(3):
        for j in range(change.shape[2]):
            x, y = change[0, part, j] - before_change[0, part, j], change[1, part, j] - before_change[1, part, j]
            change[0, part, j] = before_change[0, part, j] + (d * x - b * y) / determinant
            change[1, part, j] = before_change[1, part, j] + (a * y - c * x) / determinant


@kernel
def _project(
    kt: float,
    u: Array,
    limit: Array,
    slope: Array,
    E: Array,
    n: int,
    state: Array,
    change: Array,
    map_: Array,
    derive: bool,
) -> bool:
    """Return mapping at sample n: project the intercept, its derivative and the map of the period; whether it was outside."""
    first, second = state[0] + kt * u[0, n], state[1] + kt * u[1, n]
    radius = np.hypot(first, second)
    if radius <= limit[n]:
        return False
    ratio = limit[n] / radius
    c, s = first / radius, second / radius
    state[0], state[1] = ratio * first - kt * u[0, n], ratio * second - kt * u[1, n]
    for d in range(2):
        along = ratio * (c * map_[1, d] - s * map_[0, d])
        map_[0, d], map_[1, d] = -s * along, c * along
    if derive:
        for j in range(E.shape[1]):
            change[0, 0, j] += kt * E[n, j]
            change[1, 1, j] += kt * E[n, j]
        for part in range(3):
            for j in range(E.shape[1]):
                along = ratio * (c * change[1, part, j] - s * change[0, part, j])
                change[0, part, j], change[1, part, j] = -s * along, c * along
        for j in range(E.shape[1]):
            change[0, 2, j] += c * slope[n] * E[n, j]
            change[1, 2, j] += s * slope[n] * E[n, j]
            change[0, 0, j] -= kt * E[n, j]
            change[1, 1, j] -= kt * E[n, j]
    return True
