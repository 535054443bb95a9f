"""All contacts at one instant of a time march: λ̂(w) = f − K_c w from the motion and the previous slider positions.

A Jenkins step in the intercept y = T − kt u is a clamp, y_n = clamp(y_{n−1}, −L_n − kt u_n, L_n − kt u_n), as in
`stickslip.contact.period`; laws that are no table of sliders have a step of their own (`stickslip.contact.dispatch`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.checks import Array
from stickslip.contact.dispatch import law_step
from stickslip.contact.law import SLIDERS
from stickslip.contact.protocol import StepForces, StepMotion, contact_data
from stickslip.contact.table import ContactTable
from stickslip.kernels import inlined, inner, kernel


class ContactState(NamedTuple):
    """Contacts at one instant, changed in place. w, λ (rows,): motion and forces beyond the stuck springs; y, limit (elements,)
    of the friction elements: intercept T − kt u and slip limit L, N."""

    w: Array
    forces: Array
    intercept: Array
    limit: Array


class Earlier(NamedTuple):
    """What contacts remember of the instant before, intercepts (elements,), motion w (rows,) and limits (elements,), and how the
    velocity follows from the motion of the new instant: drift + rate w, drift (rows,) [m/s], rate [1/s]. lands: whether a slider
    that lands begins where it lands, within the step; dampers alone land at the end of a step, by either of their methods."""

    intercept: Array
    w: Array
    limit: Array
    drift: Array
    rate: float
    lands: bool


class Slopes(NamedTuple):
    """λ̂(w) of every row and its derivatives, each (rows,): by the own motion, by the normal motion of the same contact, and by
    the other tangential motion where a law couples both. work: friction work of the step of laws with kernels of their own, J."""

    target: Array
    own: Array
    coupling: Array
    cross: Array
    work: Array


@inner
def no_slopes(rows: int) -> Slopes:
    """Slopes to be filled."""
    return Slopes(np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows))


@kernel
def contact_law(table: ContactTable, w: Array, before: Earlier, intercept: Array, limit: Array, slopes: Slopes) -> None:
    """λ̂ and its derivatives at motion w (rows,), from the instant before; fills the new intercepts and the limits."""
    for c in range(table.normal_row.size):
        row = table.normal_row[c]
        z = w[row] if row >= 0 else 0.0
        if row >= 0:
            _normal_row(table, c, row, z, slopes)
        if table.kind[c] != SLIDERS:
            _law_rows(table, c, w, z, before, intercept, limit, slopes)
            continue
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if r != row:
                _friction_row(table, r, w[r], z, row, before, intercept, limit, slopes)


@inner
def _normal_row(table: ContactTable, c: int, row: int, z: float, slopes: Slopes) -> None:
    """N − K_c z = Σ c_e over the closed elements − Σ k_e z over the open ones."""
    total, slope = 0.0, 0.0
    for e in range(table.normal_first[c], table.normal_first[c + 1]):
        k, preload = table.normal_stiffness[e], table.normal_constant[e]
        if k * z + preload > 0.0:
            total += preload
        else:
            total -= k * z
            slope -= k
    slopes.target[row], slopes.own[row] = total, slope


@inner
def slip_limit(table: ContactTable, e: int, z: float) -> tuple[float, float]:
    """L = μ Σ N + L0 of friction element e, and dL/dz."""
    load, slope = 0.0, 0.0
    for k in range(table.load_first[e], table.load_last[e]):
        force = table.normal_stiffness[k] * z + table.normal_constant[k]
        if force > 0.0:
            load += force
            slope += table.normal_stiffness[k]
    return table.friction[e] * load + table.constant_limit[e], table.friction[e] * slope


@inner
def _landing(table: ContactTable, e: int, z0: float, z: float) -> float:
    """Share of a step at which friction element e lands, its normal motion taken as straight; 0 where it does not."""
    bound, slope = slip_limit(table, e, z)
    if z <= z0 or bound <= 0.0 or slope <= 0.0 or slip_limit(table, e, z0)[0] > 0.0:
        return 0.0
    return float(max(1.0 - bound / (slope * (z - z0)), 0.0))


@inner
def _friction_row(
    table: ContactTable,
    r: int,
    u: float,
    z: float,
    normal_row: int,
    before: Earlier,
    intercept: Array,
    limit: Array,
    slopes: Slopes,
) -> None:
    """T − K_c u = Σ y_e, every y_e clamped; the derivative follows from the same decision.

    A slider that lands within the step begins where it lands, not where the step began: else the force would be of first order in
    the step, and its derivative would not know that a perturbation moves the landing.
    """
    total, own, coupling = 0.0, 0.0, 0.0
    for e in range(table.friction_first[r], table.friction_first[r + 1]):
        bound, slope = slip_limit(table, e, z)
        kt, y, side, landing = table.stiffness[e], before.intercept[e], 0.0, 0.0
        if before.lands and normal_row >= 0 and before.limit[e] <= 0.0:
            landing = _landing(table, e, before.w[normal_row], z)
            if landing > 0.0:
                y = -kt * (before.w[r] + landing * (u - before.w[r]))
        if bound <= 0.0 or y > bound - kt * u:
            side = 1.0
        elif y < -bound - kt * u:
            side = -1.0
        if side != 0.0:
            y = side * bound - kt * u
            own -= kt
            coupling += side * slope
        elif landing > 0.0:
            own -= kt * landing
            coupling += kt * (u - before.w[r]) * landing / (z - before.w[normal_row])
        total += y
        intercept[e], limit[e] = y, bound
    slopes.target[r], slopes.own[r], slopes.coupling[r] = total, own, coupling


@inner
def _move_start(kt: Array, landing: float, moved: Array, closed: float, slope: float, found: StepForces) -> None:
    """Derivatives of a step that begins at a landing, which moves with the motion u (d,) and the normal motion z after the step.

    moved, closed: what u and z change in the whole step; slope: dL/dz, by which the derivative by L stands for that by z.
    """
    for d in range(moved.size):
        by_z = 0.0
        for o in range(moved.size):
            spring = found.by_u[d, o] + (kt[d] if o == d else 0.0)
            by_z += spring * moved[o]
            found.by_u[d, o] -= landing * spring
        found.by_limit[d] += landing * by_z / (closed * slope)


@inlined
def _law_rows(
    table: ContactTable, c: int, w: Array, z: float, before: Earlier, intercept: Array, limit: Array, slopes: Slopes
) -> None:
    """T − K_c u of the tangential rows of contact c by the kernel of its law."""
    first, data = table.first_row[c], contact_data(table, c)
    size, e = data.kt.size, table.friction_first[first]
    last, elements = first + size, table.friction_first[first + size] - e
    y0, L0, L, slope = np.zeros(size), 0.0, 0.0, 0.0
    if elements:
        L, slope = slip_limit(table, e, z)
        L0 = before.limit[e]
        y0[:] = before.intercept[e : e + size]
    velocity = np.empty(size)
    for d in range(size):
        velocity[d] = before.drift[first + d] + before.rate * w[first + d]
    start, landing, row = before.w[first:last].copy(), 0.0, table.normal_row[c]
    if before.lands and elements and row >= 0 and L0 <= 0.0:
        landing = _landing(table, e, before.w[row], z)
        if landing > 0.0:
            start += landing * (w[first:last] - start)
            y0[:] = -data.kt * start
            L0 = 0.0
    motion = StepMotion(y0, start, w[first:last], velocity, L0, L)
    found = StepForces(np.zeros(size), np.zeros((size, size)), np.zeros((size, size)), np.zeros(size))
    slopes.work[first] = law_step(table.kind[c], data, motion, found)
    if landing > 0.0:
        _move_start(data.kt, landing, w[first:last] - before.w[first:last], z - before.w[table.normal_row[c]], slope, found)
    for d in range(size):
        row, other = first + d, size - 1 - d
        slopes.target[row] = found.y[d]
        slopes.own[row] = found.by_u[d, d] + before.rate * found.by_velocity[d, d]
        slopes.coupling[row] = found.by_limit[d] * slope
        if table.partner_row[row] >= 0:
            slopes.cross[row] = found.by_u[d, other] + before.rate * found.by_velocity[d, other]
        if elements:
            intercept[e + d], limit[e + d] = found.y[d], L
