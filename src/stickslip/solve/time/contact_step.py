"""Contact solution of one time step by Newton's method on the rows that slip or open.

With w = w_free − Gλ, G the compliance of the step, the unknowns are λ = f − K_c w alone: R(λ) = λ − λ̂(w) = 0. Rows that stick
have constant λ̂, so the dense system is as small as the number of rows that do not.
"""

from __future__ import annotations

import numpy as np

from stickslip.model.contact.table import ContactTable
from stickslip.solve.time.contact_law import ContactState, Earlier, Slopes, contact_law
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inner

TOLERANCE = 1e-11
"""Residual of a step relative to the contact forces."""

FLOOR = 1e-8
"""Residual that is still accepted where rounding lets no step reduce it further."""

ITERATIONS = 40
PATIENCE = 5
"""How many times Newton takes its whole step although no part of it reduces the residual: on the way over a kink."""

SINGULAR = 1e-13
"""Pivot below which a matrix counts as singular."""


@inner
def _slope(slopes: Slopes, table: ContactTable, G: Array, r: int, s: int) -> float:
    """−∂λ̂_r/∂λ_s, with w = w_free − Gλ."""
    value = slopes.own[r] * G[r, s]
    if table.loading_row[r] >= 0:
        value += slopes.coupling[r] * G[table.loading_row[r], s]
    if table.partner_row[r] >= 0:
        value += slopes.cross[r] * G[table.partner_row[r], s]
    return float(value)


@inner
def _active_rows(slopes: Slopes) -> Index:
    """The rows of which λ̂ is not constant."""
    active = (slopes.own != 0.0) | (slopes.coupling != 0.0) | (slopes.cross != 0.0)
    return np.flatnonzero(active)


@inner
def _change(residual: Array, slopes: Slopes, table: ContactTable, G: Array, change: Array) -> bool:
    """Newton's change of λ (rows,); False where the system of the rows that slip or open is singular."""
    change[:] = -residual
    active = _active_rows(slopes)
    size = active.size
    change[active] = 0.0
    matrix, right = np.empty((size, size)), np.empty(size)
    for i in range(size):
        r = active[i]
        right[i] = -residual[r]
        for s in range(residual.size):
            if change[s] != 0.0:
                right[i] -= _slope(slopes, table, G, r, s) * change[s]
        for j in range(size):
            matrix[i, j] = _slope(slopes, table, G, r, active[j])
        matrix[i, i] += 1.0
    if not solve_in_place(matrix, right):
        return False
    change[active] = right
    return True


@inner
def solve_in_place(matrix: Array, right: Array) -> bool:
    """Gaussian elimination with row exchange; the solution replaces `right`. False for a singular matrix."""
    size = right.size
    for k in range(size):
        pivot = k + int(np.argmax(np.abs(matrix[k:, k])))
        if abs(matrix[pivot, k]) < SINGULAR:
            return False
        if pivot != k:
            for j in range(k, size):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            right[k], right[pivot] = right[pivot], right[k]
        for i in range(k + 1, size):
            factor = matrix[i, k] / matrix[k, k]
            if factor != 0.0:
                for j in range(k + 1, size):
                    matrix[i, j] -= factor * matrix[k, j]
                right[i] -= factor * right[k]
    for k in range(size - 1, -1, -1):
        for j in range(k + 1, size):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]
    return True


@inner
def _residual(
    table: ContactTable, G: Array, free: Array, before: Earlier, trial: ContactState, slopes: Slopes, residual: Array
) -> float:
    """Fill w, intercepts, limits and R = λ − λ̂(w) of a trial λ; returns ‖R‖."""
    trial.w[:] = free - G @ trial.forces
    contact_law(table, trial.w, before, trial.intercept, trial.limit, slopes)
    residual[:] = trial.forces - slopes.target
    return float(np.sqrt(np.sum(residual * residual)))


@inner
def solve_contacts(
    table: ContactTable,
    stiffness: Array,
    G: Array,
    free: Array,
    guess: Array,
    before: Earlier,
    state: ContactState,
    slopes: Slopes,
) -> int:
    """Contacts at the end of a step: fills `state` and `slopes` from the motion without λ (`free`, rows), a guess of λ and what
    was `before` the step. Returns the iterations, −1 where Newton's method fails."""
    rows = free.size
    residual, change, start = np.empty(rows), np.empty(rows), np.empty(rows)
    state.forces[:] = guess
    size = _residual(table, G, free, before, state, slopes, residual)
    patience = PATIENCE
    for iteration in range(ITERATIONS):
        scale = np.sqrt(np.sum(state.forces**2)) + np.sqrt(np.sum((stiffness * state.w) ** 2))
        if size <= TOLERANCE * scale:
            return iteration
        if not _change(residual, slopes, table, G, change):
            change[:] = -0.5 * residual
        start[:] = state.forces
        length, trial = 1.0, size
        for _ in range(10):
            state.forces[:] = start + length * change
            trial = _residual(table, G, free, before, state, slopes, residual)
            if trial < (1.0 - 1e-4 * length) * size:
                break
            length *= 0.5
        else:
            if size <= FLOOR * scale:
                return iteration
            patience -= 1
            if patience < 0:
                return -1
            state.forces[:] = start + change
            trial = _residual(table, G, free, before, state, slopes, residual)
        size = trial
    return -1
