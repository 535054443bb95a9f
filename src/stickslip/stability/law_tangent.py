"""How the friction of a contact whose law has kernels of its own answers a perturbation in one step.

δy after the step by the motion, velocity and normal motion after it, and by δy, the motion and the normal motion before it.
Closed forms where a law gives them; of any other law, derivatives by what was before are differences of its `step`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.checks import Array
from stickslip.contact import dahl, friction_disc
from stickslip.contact.dahl import dahl_step
from stickslip.contact.dispatch import law_step
from stickslip.contact.friction_disc import disc_step
from stickslip.contact.protocol import ContactData, StepForces, StepMotion, contact_data
from stickslip.contact.table import ContactTable
from stickslip.kernels import inner
from stickslip.time.contact_law import slip_limit

DIFFERENCE = 1e-6
"""Change, relative to the forces, by which the step of a law without closed form is differentiated by what was before it."""


SOON = 1e-3
"""Share of a step over which the rate of friction after a landing is taken."""


class Tangent(NamedTuple):
    """δy of each row after a step: own, normal, cross by the motion after it (of the row, of its normal load, of its partner),
    own_rate, cross_rate by the velocity; y, y_cross, u, u_cross, u_normal by what was before. All (rows,)."""

    own: Array
    normal: Array
    cross: Array
    own_rate: Array
    cross_rate: Array
    y: Array
    y_cross: Array
    u: Array
    u_cross: Array
    u_normal: Array


class Before(NamedTuple):
    """Derivatives of y after a step (d, d) by y and u and (d,) by the limit before it."""

    y: Array
    u: Array
    limit: Array


@inner
def no_tangent(rows: int) -> Tangent:
    """Zeros to be filled."""
    n = rows
    first = (np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n))
    return Tangent(*first, np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n))


@inner
def law_tangent(table: ContactTable, c: int, u: Array, v: Array, inside: float, y: Array, tangent: Tangent) -> None:
    """Fill the rows of contact c for a step with motion u and velocity v (rows, 2) before and after it, and move y (rows,).

    inside: normal motion within the step, at whose ends the contact may land or lift off.
    """
    a, data = table.first_row[c], contact_data(table, c)
    size, row, e = data.kt.size, table.normal_row[c], table.friction_first[a]
    L0, L1, slope = 0.0, 0.0, 0.0
    if table.friction_first[a + size] > e:
        L0 = slip_limit(table, e, u[row, 0] if row >= 0 else 0.0)[0]
        L1 = slip_limit(table, e, u[row, 1] if row >= 0 else 0.0)[0]
        slope = slip_limit(table, e, inside)[1]
    motion = StepMotion(
        y[a : a + size].copy(), u[a : a + size, 0].copy(), u[a : a + size, 1].copy(), v[a : a + size, 1].copy(), L0, L1
    )
    found = StepForces(np.zeros(size), np.zeros((size, size)), np.zeros((size, size)), np.zeros(size))
    law_step(table.kind[c], data, motion, found)
    before = Before(np.zeros((size, size)), np.zeros((size, size)), np.zeros(size))
    if table.kind[c] == friction_disc.KIND:
        _disc_before(data.kt[0], motion, before)
    elif table.kind[c] == dahl.KIND:
        _dahl_before(data, motion, before)
    elif table.friction_first[a + size] > e and data.kt[0] > 0.0:
        _differences(table.kind[c], data, motion, before)
    for d in range(size):
        r, o = a + d, size - 1 - d
        tangent.own[r], tangent.own_rate[r], tangent.normal[r] = (
            found.by_u[d, d],
            found.by_velocity[d, d],
            found.by_limit[d] * slope,
        )
        tangent.y[r], tangent.u[r], tangent.u_normal[r] = before.y[d, d], before.u[d, d], before.limit[d] * slope
        if table.partner_row[r] >= 0:
            tangent.cross[r], tangent.cross_rate[r] = found.by_u[d, o], found.by_velocity[d, o]
            tangent.y_cross[r], tangent.u_cross[r] = before.y[d, o], before.u[d, o]
        y[r] = found.y[d]


@inner
def landing_rates(table: ContactTable, c: int, u: Array, v: Array, h: float, rates: Array) -> None:
    """dT/dt of the rows of contact c just after it lands with motion u and velocity v (rows,); h: a short time [s]."""
    a, data, row = table.first_row[c], contact_data(table, c), table.normal_row[c]
    size, e, now = data.kt.size, table.friction_first[a], h * SOON
    limit, moved = slip_limit(table, e, u[row] + now * v[row])[0], np.empty(size)
    y, u0, speed = np.empty(size), u[a : a + size].copy(), v[a : a + size].copy()
    for d in range(size):
        y[d], moved[d] = -data.kt[d] * u0[d], u0[d] + now * speed[d]
    found = StepForces(np.zeros(size), np.zeros((size, size)), np.zeros((size, size)), np.zeros(size))
    law_step(table.kind[c], data, StepMotion(y, u0, moved, speed, 0.0, limit), found)
    for d in range(size):
        rates[a + d] = (found.y[d] + data.kt[d] * moved[d]) / now


@inner
def _disc_before(kt: float, motion: StepMotion, before: Before) -> None:
    """Of a friction disc: T1 = L1 (c, s), its angle by T0 = y0 + kt u0, by kt Δu and by L0."""
    y, u0, u, turn = motion.intercept, motion.u0, motion.u, np.empty(6)
    slips, c, s = disc_step(
        y[0] + kt * u0[0], y[1] + kt * u0[1], kt * (u[0] - u0[0]), kt * (u[1] - u0[1]), motion.limit0, motion.limit, turn
    )
    if not slips:
        before.y[0, 0], before.y[1, 1] = 1.0, 1.0
        return
    for d in range(2):
        before.y[0, d], before.y[1, d] = -s * motion.limit * turn[d], c * motion.limit * turn[d]
        along = motion.limit * kt * (turn[d] - turn[2 + d])
        before.u[0, d], before.u[1, d] = -s * along, c * along
    before.limit[0], before.limit[1] = -s * motion.limit * turn[4], c * motion.limit * turn[4]


@inner
def _dahl_before(data: ContactData, motion: StepMotion, before: Before) -> None:
    """Of Dahl's law: T1 by T0 = y0 + kt u0, by Δu and by L0."""
    for d in range(data.kt.size):
        kt, u0 = data.kt[d], motion.u0[d]
        moved = dahl_step(kt, motion.intercept[d] + kt * u0, motion.u[d] - u0, motion.limit0, motion.limit)
        before.y[d, d], before.u[d, d], before.limit[d] = moved[1], kt * moved[1] - moved[2], moved[3]


@inner
def _differences(kind: int, data: ContactData, motion: StepMotion, before: Before) -> None:
    """Of any other law with a spring kt, by central differences."""
    size, kt = data.kt.size, data.kt[0]
    small = DIFFERENCE * max(np.max(np.abs(motion.intercept)) + kt * np.max(np.abs(motion.u0)), motion.limit0, motion.limit)
    for sign in (-1.0, 1.0):
        for d in range(size):
            moved = np.zeros(size)
            moved[d] = sign * small
            before.y[:, d] += sign * _after(kind, data, motion, moved, 0.0 * moved, 0.0) / (2.0 * small)
            before.u[:, d] += sign * kt * _after(kind, data, motion, 0.0 * moved, moved / kt, 0.0) / (2.0 * small)
        if motion.limit0 > small:
            nothing = np.zeros(size)
            before.limit[:] += sign * _after(kind, data, motion, nothing, nothing, sign * small) / (2.0 * small)


@inner
def _after(kind: int, data: ContactData, motion: StepMotion, y: Array, u: Array, limit: float) -> Array:
    """y after a step from another y, u and limit."""
    size = motion.u.size
    found = StepForces(np.zeros(size), np.zeros((size, size)), np.zeros((size, size)), np.zeros(size))
    other = StepMotion(motion.intercept + y, motion.u0 + u, motion.u, motion.velocity, motion.limit0 + limit, motion.limit)
    law_step(kind, data, other, found)
    return found.y
