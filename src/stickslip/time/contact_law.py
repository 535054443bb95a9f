"""All contacts at one instant of a time march: λ̂(w) = f − K_c w from the motion and the previous slider positions.

A Jenkins step in the intercept y = T − kt u is a clamp, y_n = clamp(y_{n−1}, −L_n − kt u_n, L_n − kt u_n), as in
`stickslip.contact.period`; on a friction disc it is the step of `stickslip.contact.friction_disc`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.checks import Array, Index
from stickslip.contact.friction_disc import disc_step
from stickslip.contact.table import ContactTable
from stickslip.kernels import kernel


class ContactState(NamedTuple):
    """Contacts at one instant, changed in place. w, λ (rows,): motion and forces beyond the stuck springs; y, limit (elements,)
    of the friction elements: intercept T − kt u and slip limit L, N."""

    w: Array
    forces: Array
    intercept: Array
    limit: Array


class Earlier(NamedTuple):
    """What contacts remember of the instant before: intercepts (elements,), motion w (rows,) and limits (elements,); the last two
    matter to friction discs alone."""

    intercept: Array
    w: Array
    limit: Array


class Slopes(NamedTuple):
    """λ̂(w) of every row and its derivatives, each (rows,): by the own motion, by the normal motion of the same contact, and by
    the other tangential motion on a friction disc."""

    target: Array
    own: Array
    coupling: Array
    cross: Array


class Neighbours(NamedTuple):
    """For each friction row (rows,): the normal row of its contact and the other row of its friction disc, −1 where none is."""

    normal: Index
    partner: Index


def neighbours(table: ContactTable) -> Neighbours:
    """The neighbours of all rows of a table."""
    normal, partner = np.full(table.rows, -1), np.full(table.rows, -1)
    for c, row in enumerate(table.normal_row):
        friction = [r for r in range(table.first_row[c], table.first_row[c + 1]) if r != row]
        normal[friction] = row
        if table.coupled[c]:
            partner[friction] = friction[::-1]
    return Neighbours(normal, partner)


def no_slopes(rows: int) -> Slopes:
    """Slopes to be filled."""
    return Slopes(*(np.zeros(rows) for _ in range(4)))


@kernel
def contact_law(table: ContactTable, w: Array, before: Earlier, intercept: Array, limit: Array, slopes: Slopes) -> None:
    """λ̂ and its derivatives at motion w (rows,), from the instant before; fills the new intercepts and the limits."""
    for c in range(table.normal_row.size):
        row = table.normal_row[c]
        z = w[row] if row >= 0 else 0.0
        if row >= 0:
            _normal_row(table, c, row, z, slopes)
        if table.coupled[c]:
            _disc_rows(table, table.first_row[c], w, z, before, intercept, limit, slopes)
            continue
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if table.cubic[r] != 0.0:
                slopes.target[r], slopes.own[r] = table.cubic[r] * w[r] ** 3, 3.0 * table.cubic[r] * w[r] ** 2
            elif r != row:
                _friction_row(table, r, w[r], z, before.intercept, intercept, limit, slopes)


@kernel
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


@kernel
def _limit(table: ContactTable, e: int, z: float) -> tuple[float, float]:
    """L = μ Σ N + L0 of friction element e, and dL/dz."""
    load, slope = 0.0, 0.0
    for k in range(table.load_first[e], table.load_last[e]):
        force = table.normal_stiffness[k] * z + table.normal_constant[k]
        if force > 0.0:
            load += force
            slope += table.normal_stiffness[k]
    return table.friction[e] * load + table.constant_limit[e], table.friction[e] * slope


@kernel
def _friction_row(
    table: ContactTable, r: int, u: float, z: float, before: Array, intercept: Array, limit: Array, slopes: Slopes
) -> None:
    """T − K_c u = Σ y_e, every y_e clamped; the derivative follows from the same decision."""
    total, own, coupling = 0.0, 0.0, 0.0
    for e in range(table.friction_first[r], table.friction_first[r + 1]):
        bound, slope = _limit(table, e, z)
        kt, y, side = table.stiffness[e], before[e], 0.0
        if bound <= 0.0 or y > bound - kt * u:
            side = 1.0
        elif y < -bound - kt * u:
            side = -1.0
        if side != 0.0:
            y = side * bound - kt * u
            own -= kt
            coupling += side * slope
        total += y
        intercept[e], limit[e] = y, bound
    slopes.target[r], slopes.own[r], slopes.coupling[r] = total, own, coupling


@kernel
def _disc_rows(
    table: ContactTable, r: int, w: Array, z: float, before: Earlier, intercept: Array, limit: Array, slopes: Slopes
) -> None:
    """T − K_c u of the two rows r, r + 1 of a friction disc."""
    e = table.friction_first[r]
    L, slope = _limit(table, e, z)
    kt, turn = table.stiffness[e], np.empty(6)
    tx, ty = before.intercept[e] + kt * before.w[r], before.intercept[e + 1] + kt * before.w[r + 1]
    x, y = kt * (w[r] - before.w[r]), kt * (w[r + 1] - before.w[r + 1])
    slips, c, s = disc_step(tx, ty, x, y, before.limit[e], L, turn)
    limit[e] = limit[e + 1] = L
    intercept[e] = L * c - kt * w[r] if slips else before.intercept[e]
    intercept[e + 1] = L * s - kt * w[r + 1] if slips else before.intercept[e + 1]
    stuck = 0.0 if slips else kt
    slopes.own[r], slopes.own[r + 1] = stuck - kt * (1.0 + s * L * turn[2]), stuck - kt * (1.0 - c * L * turn[3])
    slopes.cross[r], slopes.cross[r + 1] = -kt * s * L * turn[3], kt * c * L * turn[2]
    slopes.coupling[r], slopes.coupling[r + 1] = (c - s * L * turn[5]) * slope, (s + c * L * turn[5]) * slope
    for d in range(2):
        slopes.target[r + d] = intercept[e + d]
