"""All contacts over one time step: the element laws, and Newton's method on the rows that slip or open.

The Jenkins step in the intercept y = T − kt u is a clamp, y_n = clamp(y_{n−1}, −L_n − kt u_n, L_n − kt u_n), as in
`stickslip.contact.period`. With w = w_free − Gλ the unknowns of a step are λ = f − K_c w alone, R(λ) = λ − λ̂(w) = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.checks import Array, Index
from stickslip.contact.table import ContactTable
from stickslip.kernels import njit

TOLERANCE = 1e-11
"""Residual of a step relative to the contact forces."""

FLOOR = 1e-8
"""Residual that is still accepted where rounding lets no step reduce it further."""

ITERATIONS = 40
PATIENCE = 5
"""How many times Newton takes its whole step although no part of it reduces the residual: on the way over a kink."""


class ContactState(NamedTuple):
    """Contacts at one instant, changed in place. w, λ (rows,): motion and forces beyond the stuck springs; y, limit (elements,)
    of the friction elements: intercept T − kt u and slip limit L, N."""

    w: Array
    forces: Array
    intercept: Array
    limit: Array


class Slopes(NamedTuple):
    """λ̂(w) and its derivatives by the own motion and by the normal motion of the same contact, each (rows,)."""

    target: Array
    own: Array
    coupling: Array


@njit(cache=True)
def contact_law(table: ContactTable, w: Array, before: Array, intercept: Array, limit: Array, slopes: Slopes) -> None:
    """λ̂ and its derivatives at motion w (rows,), from intercepts `before`; fills the new intercepts and the limits."""
    for c in range(table.normal_row.size):
        row = table.normal_row[c]
        z = w[row] if row >= 0 else 0.0
        if row >= 0:
            _normal_row(table, c, row, z, slopes)
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if r != row:
                _friction_row(table, r, w[r], z, before, intercept, limit, slopes)


@njit(cache=True)
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
    slopes.target[row], slopes.own[row], slopes.coupling[row] = total, slope, 0.0


@njit(cache=True)
def _friction_row(
    table: ContactTable, r: int, u: float, z: float, before: Array, intercept: Array, limit: Array, slopes: Slopes
) -> None:
    """T − K_c u = Σ y_e, every y_e clamped; the derivative follows from the same decision."""
    total, own, coupling = 0.0, 0.0, 0.0
    for e in range(table.friction_first[r], table.friction_first[r + 1]):
        load, slope = 0.0, 0.0
        for k in range(table.load_first[e], table.load_last[e]):
            force = table.normal_stiffness[k] * z + table.normal_constant[k]
            if force > 0.0:
                load += force
                slope += table.normal_stiffness[k]
        kt, mu = table.stiffness[e], table.friction[e]
        bound = mu * load + table.constant_limit[e]
        y, side = before[e], 0.0
        if bound <= 0.0 or y > bound - kt * u:
            side = 1.0
        elif y < -bound - kt * u:
            side = -1.0
        if side != 0.0:
            y = side * bound - kt * u
            own -= kt
            coupling += side * mu * slope
        total += y
        intercept[e], limit[e] = y, bound
    slopes.target[r], slopes.own[r], slopes.coupling[r] = total, own, coupling


@njit(cache=True)
def _change(residual: Array, slopes: Slopes, normal: Index, G: Array, change: Array) -> bool:
    """Newton's change of λ (rows,); False where the system of the rows that slip or open is singular."""
    rows = residual.size
    change[:] = -residual
    active = np.flatnonzero((slopes.own != 0.0) | (slopes.coupling != 0.0))
    size = active.size
    if size == 0:
        return True
    matrix, right = np.empty((size, size)), np.empty(size)
    for i in range(size):
        r = active[i]
        n = normal[r]
        right[i] = -residual[r]
        for s in range(rows):
            pull = slopes.own[r] * G[r, s] + (slopes.coupling[r] * G[n, s] if n >= 0 else 0.0)
            if slopes.own[s] == 0.0 and slopes.coupling[s] == 0.0:
                right[i] += pull * residual[s]
        for j in range(size):
            s = active[j]
            matrix[i, j] = slopes.own[r] * G[r, s] + (slopes.coupling[r] * G[n, s] if n >= 0 else 0.0)
        matrix[i, i] += 1.0
    if not solve_in_place(matrix, right):
        return False
    for i in range(size):
        change[active[i]] = right[i]
    return True


@njit(cache=True)
def solve_in_place(matrix: Array, right: Array) -> bool:
    """Gaussian elimination with row exchange; the solution replaces `right`. False for a singular matrix."""
    size = right.size
    for k in range(size):
        pivot = k + int(np.argmax(np.abs(matrix[k:, k])))
        if abs(matrix[pivot, k]) < 1e-13:
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


@njit(cache=True)
def _residual(
    table: ContactTable, G: Array, free: Array, before: Array, trial: ContactState, slopes: Slopes, residual: Array
) -> float:
    """Fill w, intercepts, limits and R = λ − λ̂(w) of a trial λ; returns ‖R‖."""
    trial.w[:] = free - G @ trial.forces
    contact_law(table, trial.w, before, trial.intercept, trial.limit, slopes)
    residual[:] = trial.forces - slopes.target
    return float(np.sqrt(np.sum(residual * residual)))


@njit(cache=True)
def solve_contacts(
    table: ContactTable, normal: Index, stiffness: Array, G: Array, free: Array, guess: Array, before: Array, state: ContactState
) -> int:
    """Contacts at the end of a step: fills `state` from the motion without λ (`free`, rows), a guess of λ and the intercepts
    `before` the step. Returns the iterations, −1 where Newton's method fails.

    normal (rows,): the normal row of each friction row, else −1.
    """
    rows = free.size
    slopes = Slopes(np.empty(rows), np.empty(rows), np.empty(rows))
    residual, change, start = np.empty(rows), np.empty(rows), np.empty(rows)
    state.forces[:] = guess
    size = _residual(table, G, free, before, state, slopes, residual)
    patience = PATIENCE
    for iteration in range(ITERATIONS):
        scale = np.sqrt(np.sum(state.forces**2)) + np.sqrt(np.sum((stiffness * state.w) ** 2))
        if size <= TOLERANCE * scale:
            return iteration
        if not _change(residual, slopes, normal, G, change):
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
