"""How the friction of a contact whose law has a step of its own answers a perturbation in one step.

States x = f(x before, travel, limits, time) and tractions by what is there after the step: the chain rule, by the derivatives
that the step of the law gives. What is remembered is the intercept of each state, x − kt u.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.model.contact.dispatch import take_step
from stickslip.model.contact.protocol import StepMotion, no_step, traction, traction_by_state
from stickslip.model.contact.table import ContactTable, contact_data
from stickslip.solve.time.contact_law import slip_limit
from stickslip.support.checks import Array
from stickslip.support.kernels import inner

SOON = 1e-3
"""Share of a step over which the rate of friction after a landing is taken."""


class Tangent(NamedTuple):
    """δy of each row after a step by the motion after it: own, normal, cross (of the row, of its normal load, of its partner);
    own_rate, cross_rate by the velocity, all (rows,). state_own, state_normal, state_cross: δ of the intercept of each friction
    element of a law with a step of its own, by the same, (elements,)."""

    own: Array
    normal: Array
    cross: Array
    own_rate: Array
    cross_rate: Array
    state_own: Array
    state_normal: Array
    state_cross: Array


@inner
def no_tangent(rows: int, elements: int) -> Tangent:
    """Zeros to be filled."""
    n = rows
    first = (np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n))
    return Tangent(*first, np.zeros(elements), np.zeros(elements), np.zeros(elements))


@inner
def law_tangent(
    table: ContactTable,
    c: int,
    u: Array,
    v: Array,
    time: float,
    inside: float,
    intercept: Array,
    w: Array,
    memory: Array,
    kept: Array,
    tangent: Tangent,
) -> None:
    """Fill the tangent of the rows and elements of contact c for a step with motion u and velocity v (rows, 2) before and after
    it, and move intercept (elements,).

    time: of the step [s]; inside: normal motion within it, at whose ends the contact may land or lift off. w (rows, columns):
    perturbations of the motion before it; memory (elements, columns): of the intercepts, before it and, but for what the motion
    after the step adds, after it; kept (rows, columns): what these leave of δy.
    """
    a, data, row, e = table.first_row[c], contact_data(table, c), table.normal_row[c], table.friction_first[table.first_row[c]]
    size, states, columns = data.kt.size, data.spring.size, w.shape[1]
    L0, L1, slope = 0.0, 0.0, 0.0
    if states:
        L0 = slip_limit(table, e, u[row, 0] if row >= 0 else 0.0)[0]
        L1 = slip_limit(table, e, u[row, 1] if row >= 0 else 0.0)[0]
        slope = slip_limit(table, e, inside)[1]
    b, state, before = a + size, np.empty(states), np.empty((states, columns))
    for i in range(states):
        r = a + data.direction[i]
        state[i] = intercept[e + i] + data.spring[i] * u[r, 0]
        before[i] = memory[e + i] + data.spring[i] * w[r]
    found = no_step(states, size)
    motion = StepMotion(state, u[a:b, 1] - u[a:b, 0], u[a:b, 1].copy(), v[a:b, 1].copy(), L0, L1, time)
    take_step(data, motion, found)
    for i in range(states):
        r, after = a + data.direction[i], memory[e + i]
        intercept[e + i] = found.state[i] - data.spring[i] * u[r, 1]
        after[:] = 0.0
        for j in range(states):
            after += found.by_state[i, j] * before[j]
        for d in range(size):
            after -= found.by_travel[i, d] * w[a + d]
        if row >= 0:
            after += found.by_limit0[i] * slope * w[row]
        tangent.state_own[e + i] = found.by_travel[i, data.direction[i]] - data.spring[i]
        tangent.state_cross[e + i] = found.by_travel[i, size - 1 - data.direction[i]]
        tangent.state_normal[e + i] = found.by_limit[i] * slope
    for d in range(size):
        r, o = a + d, size - 1 - d
        own, cross, by_limit = found.direct_by_u[d, d] - data.kt[d], found.direct_by_u[d, o], found.direct_by_limit[d]
        kept[r] = 0.0
        for i in range(states):
            weight = traction_by_state(data, found, d, i)
            own += weight * found.by_travel[i, d]
            cross += weight * found.by_travel[i, o]
            by_limit += weight * found.by_limit[i]
            kept[r] += weight * memory[e + i]
        tangent.own[r], tangent.own_rate[r], tangent.normal[r] = own, found.direct_by_velocity[d, d], by_limit * slope
        if table.partner_row[r] >= 0:
            tangent.cross[r], tangent.cross_rate[r] = cross, found.direct_by_velocity[d, o]


@inner
def remember_states(table: ContactTable, c: int, w: Array, memory: Array, tangent: Tangent) -> None:
    """Add to the intercepts (elements, columns) of contact c what the motion after a step (rows, columns) does."""
    for r in range(table.first_row[c], table.first_row[c + 1]):
        for e in range(table.friction_first[r], table.friction_first[r + 1]):
            memory[e] += tangent.state_own[e] * w[r]
            if table.partner_row[r] >= 0:
                memory[e] += tangent.state_cross[e] * w[table.partner_row[r]]
            if table.loading_row[r] >= 0:
                memory[e] += tangent.state_normal[e] * w[table.loading_row[r]]


@inner
def landing_rates(table: ContactTable, c: int, u: Array, v: Array, h: float, rates: Array, state_rates: Array) -> None:
    """dT/dt (rows,) and the rates of the states (elements,) of contact c just after it lands with motion u and velocity v
    (rows,); h: a short time [s]."""
    a, data, row = table.first_row[c], contact_data(table, c), table.normal_row[c]
    size, states, e, now = data.kt.size, data.spring.size, table.friction_first[a], h * SOON
    limit, found, b = slip_limit(table, e, u[row] + now * v[row])[0], no_step(states, size), a + size
    motion = StepMotion(np.zeros(states), now * v[a:b], u[a:b] + now * v[a:b], v[a:b].copy(), 0.0, limit, now)
    take_step(data, motion, found)
    for d in range(size):
        rates[a + d] = traction(data, found, d) / now
    for i in range(states):
        state_rates[e + i] = found.state[i] / now
