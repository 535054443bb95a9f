"""One step of bodies with contacts whose other side moves as prescribed, by Newton's method on the motion of the bodies.

A q + φ Bᵀ f(B q + d) = g with w = B q + d, d the prescribed part. Quasi-static: A = K, φ = 1, g = load. In time: A is the
effective matrix of the step and φ = 1 − αf (`solve/time/model.py`). Where a nearly open contact leaves the matrix singular,
the direction comes from the matrix plus a part of the stuck one: still downhill, and of the size of the stuck motion.

Equilibrium of a few macroslip contacts by enumeration of all contact states, a safe fallback for Newton's method.

With each contact stuck, slipping either way or open, the step is a linear system; of the solutions that agree with their own
states the one nearest to the last motion counts. 4 to the power of the contacts combinations, so for a few contacts only.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.table import ContactTable
from stickslip.solve.time.contact_law import Earlier, Slopes, contact_law, no_slopes, solve_in_place
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inner

TOLERANCE = 1e-12
"""Residual of a step relative to load and contact forces."""

FLOOR = 1e-9
"""Residual that is still accepted where rounding lets no step reduce it further."""

ITERATIONS = 40
PATIENCE = 6
"""How many times Newton takes its whole step although no part of it reduces the residual: on the way over a kink."""

UNIT = 1e4
"""The matrix is divided by this times its largest stuck entry: a pivot below 1e-9 of that entry then counts as singular."""


class Bodies(NamedTuple):
    """B (rows, n), stuck stiffness K_c (rows,), the row of the normal direction of each row's contact (rows,), A (n, n), its
    stuck matrix A + φ BᵀK_cB, and φ. Rotations are scaled so that all unknowns are metres of one size."""

    B: Array
    stiffness: Array
    normal: Index
    A: Array
    stuck: Array
    share: float


class Workspace(NamedTuple):
    """Arrays that a step fills: w, f (rows,), intercept, limit (elements,), slopes; residual, change, trial (n,); matrix."""

    w: Array
    force: Array
    intercept: Array
    limit: Array
    slopes: Slopes
    residual: Array
    change: Array
    trial: Array
    matrix: Array


@inner
def workspace(rows: int, elements: int, size: int) -> Workspace:
    """Fresh arrays."""
    return Workspace(
        np.zeros(rows),
        np.zeros(rows),
        np.zeros(elements),
        np.zeros(elements),
        no_slopes(rows),
        np.zeros(size),
        np.zeros(size),
        np.zeros(size),
        np.zeros((size, size)),
    )


@inner
def residual_of(
    bodies: Bodies, table: ContactTable, q: Array, drive: Array, right: Array, before: Earlier, work: Workspace
) -> float:
    """Fill w, forces, intercepts, limits, slopes and A q + φ Bᵀf − g; returns its norm."""
    rows, size = bodies.B.shape
    for r in range(rows):
        total = drive[r]
        for i in range(size):
            total += bodies.B[r, i] * q[i]
        work.w[r] = total
    contact_law(table, work.w, before, work.intercept, work.limit, work.slopes)
    for r in range(rows):
        work.force[r] = work.slopes.target[r] + bodies.stiffness[r] * work.w[r]
    square = 0.0
    for i in range(size):
        total = -right[i]
        for j in range(size):
            total += bodies.A[i, j] * q[j]
        for r in range(rows):
            total += bodies.share * bodies.B[r, i] * work.force[r]
        work.residual[i] = total
        square += total * total
    return float(np.sqrt(square))


@inner
def _scale(bodies: Bodies, right: Array, work: Workspace) -> float:
    total = 0.0
    for i in range(right.size):
        total += right[i] * right[i]
    for r in range(work.force.size):
        total += work.force[r] * work.force[r] + (1e-3 * bodies.stiffness[r] * work.w[r]) ** 2
    return float(np.sqrt(total) + 1e-300)


@inner
def _direction(bodies: Bodies, work: Workspace) -> None:
    """Newton's change of q; with a growing part of the stuck matrix where the tangent one is singular."""
    rows, size = bodies.B.shape
    largest = 0.0
    for i in range(size):
        largest = max(largest, UNIT * bodies.stuck[i, i])
    added = 0.0
    for _ in range(12):
        for i in range(size):
            for j in range(size):
                work.matrix[i, j] = (bodies.A[i, j] + added * bodies.stuck[i, j]) / largest
        for r in range(rows):
            own, coupling, n = bodies.stiffness[r] + work.slopes.own[r], work.slopes.coupling[r], bodies.normal[r]
            for i in range(size):
                left = bodies.share * bodies.B[r, i] / largest
                for j in range(size):
                    value = own * bodies.B[r, j]
                    if n >= 0 and n != r:
                        value += coupling * bodies.B[n, j]
                    work.matrix[i, j] += left * value
        for i in range(size):
            work.change[i] = -work.residual[i] / largest
        if solve_in_place(work.matrix, work.change):
            return
        added = max(1e-6, 8.0 * added)
    for i in range(size):
        work.change[i] = 0.0


@inner
def solve_step(
    bodies: Bodies, table: ContactTable, drive: Array, right: Array, before: Earlier, q: Array, work: Workspace
) -> int:
    """Solve one step from the start in q (n,), which becomes the solution. Returns the iterations, −1 where Newton fails."""
    size = residual_of(bodies, table, q, drive, right, before, work)
    patience = PATIENCE
    for iteration in range(ITERATIONS):
        if size <= TOLERANCE * _scale(bodies, right, work):
            return iteration
        _direction(bodies, work)
        length, found, reduced = 1.0, size, False
        work.trial[:] = q
        for _ in range(12):
            q[:] = work.trial + length * work.change
            found = residual_of(bodies, table, q, drive, right, before, work)
            if found < (1.0 - 1e-4 * length) * size:
                reduced = True
                break
            length *= 0.5
        if not reduced:
            q[:] = work.trial
            found = residual_of(bodies, table, q, drive, right, before, work)
            if size <= FLOOR * _scale(bodies, right, work):
                return iteration
            patience -= 1
            if patience < 0:
                return -1
            _direction(bodies, work)
            q[:] = work.trial + work.change
            found = residual_of(bodies, table, q, drive, right, before, work)
        if not np.isfinite(found):
            return -1
        size = found
    return -1


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
