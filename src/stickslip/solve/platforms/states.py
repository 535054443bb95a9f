"""Equilibrium of a few macroslip contacts by enumeration of all contact states, a safe fallback for Newton's method.

With each contact stuck, slipping either way or open, the step is a linear system; of the solutions that agree with their own
states the one nearest to the last motion counts. 4 to the power of the contacts combinations, so for a few contacts only.
"""

from __future__ import annotations

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.table import ContactTable
from stickslip.solve.platforms.step import UNIT, Bodies
from stickslip.solve.time.contact_step import solve_in_place
from stickslip.support.checks import Array
from stickslip.support.kernels import inner

MOST_CONTACTS = 6
"""Of which every combination of states is tried."""

SLACK = 1e-9
"""How far a force may lie beyond its limit, relative to the load: rounding."""


def enumerable(table: ContactTable) -> bool:
    """Whether every contact is one Jenkins element over one normal spring, with a constant coefficient, and there are few."""
    contacts = table.normal_row.size
    plain = np.all(np.diff(table.first_row) == 2) and np.all(table.normal_row == table.first_row[:-1] + 1)
    single = table.stiffness.size == contacts and table.normal_stiffness.size == contacts
    return bool(
        contacts <= MOST_CONTACTS
        and plain
        and single
        and not np.any(table.constant_limit)
        and not table.bend.size
        and np.all(table.kind == SLIDERS)
    )


@inner
def find_states(bodies: Bodies, table: ContactTable, drive: Array, right: Array, before: Array, near: Array, q: Array) -> bool:
    """The equilibrium nearest to the motion `near` goes into q; False where no combination of states has one."""
    contacts, size = table.normal_row.size, q.size
    rows = np.zeros((2 * contacts, size + 1))
    matrix, trial = np.empty((size, size)), np.empty(size)
    unit, best = UNIT * np.diag(bodies.stuck).max(), np.inf
    slack = SLACK * np.sqrt(np.sum(right * right))
    for code in range(4**contacts):
        _force_rows(bodies, table, drive, before, code, rows)
        for i in range(size):
            trial[i] = right[i] / unit
            for j in range(size):
                matrix[i, j] = bodies.A[i, j] / unit
            for r in range(2 * contacts):
                part = bodies.share * bodies.B[r, i] / unit
                trial[i] -= part * rows[r, size]
                for j in range(size):
                    matrix[i, j] += part * rows[r, j]
        if not solve_in_place(matrix, trial):
            continue
        distance = np.sum((trial - near) ** 2)
        if distance < best and _agrees(bodies, table, drive, before, code, trial, slack):
            best = distance
            q[:] = trial
    return best < np.inf


@inner
def _force_rows(bodies: Bodies, table: ContactTable, drive: Array, before: Array, code: int, rows: Array) -> None:
    """Forces as rows · (q, 1), in the states of the code: digits to base 4 are stick, slip up, slip down, open."""
    size = rows.shape[1] - 1
    for c in range(table.normal_row.size):
        state, code = code % 4, code // 4
        t, n = 2 * c, 2 * c + 1
        kn, kt = table.normal_stiffness[c], table.stiffness[c]
        closed = 0.0 if state == 3 else 1.0
        sense = 1.0 if state == 1 else (-1.0 if state == 2 else 0.0)
        for j in range(size):
            rows[n, j] = closed * kn * bodies.B[n, j]
            rows[t, j] = kt * bodies.B[t, j] if state == 0 else sense * table.friction[c] * rows[n, j]
        rows[n, size] = closed * (kn * drive[n] + table.normal_constant[c])
        rows[t, size] = kt * drive[t] + before[c] if state == 0 else sense * table.friction[c] * rows[n, size]


@inner
def _agrees(bodies: Bodies, table: ContactTable, drive: Array, before: Array, code: int, q: Array, slack: float) -> bool:
    """Whether the motion q leads to the states of the code."""
    for c in range(table.normal_row.size):
        state, code = code % 4, code // 4
        u, z = drive[2 * c] + np.sum(bodies.B[2 * c] * q), drive[2 * c + 1] + np.sum(bodies.B[2 * c + 1] * q)
        force = table.normal_stiffness[c] * z + table.normal_constant[c]
        trial, limit = before[c] + table.stiffness[c] * u, table.friction[c] * force
        if state == 3:
            if force > slack:
                return False
            continue
        if force < -slack:
            return False
        if (
            (state == 0 and abs(trial) > limit + slack)
            or (state == 1 and trial < limit - slack)
            or (state == 2 and trial > slack - limit)
        ):
            return False
    return True
