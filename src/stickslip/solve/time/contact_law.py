"""All contacts at one instant of a time march: λ̂(w) = f − K_c w from the motion and the previous slider positions.

A Jenkins step in the intercept y = T − kt u is a clamp, y_n = clamp(y_{n−1}, −L_n − kt u_n, L_n − kt u_n), as in
`stickslip.model.contact.protocol`; laws that are no table of sliders have a step of their own (also there).

Contact solution of one time step by Newton's method on the rows that slip or open.

With w = w_free − Gλ, G the compliance of the step, the unknowns are λ = f − K_c w alone: R(λ) = λ − λ̂(w) = 0. Rows that stick
have constant λ̂, so the dense system is as small as the number of rows that do not. Where there are more contact rows than modes,
it is solved on the modes: with G = R Pᵀ and E = ∂λ̂/∂w, (I + E R Pᵀ) δ = −R(λ) is δ = −R(λ) + E R (I + Pᵀ E R)⁻¹ Pᵀ R(λ).

Contact forces along a motion that is given, instant by instant, as a time march would find them.
"""

from typing import NamedTuple

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import ContactTable, bent, contact_data
from stickslip.model.contact.protocol import StepMotion, no_step, take_step, traction, traction_by_state
from stickslip.support.checks import Array
from stickslip.support.kernels import inlined, inner, kernel
from stickslip.support.kernels.views import view


class ContactState(NamedTuple):
    """Contacts at one instant, changed in place. w, λ (rows,): motion and forces beyond the stuck springs; y, limit (elements,)
    of the friction elements: intercept T − kt u, of laws with a step of their own state − kt u, and slip limit L, N."""

    w: Array
    forces: Array
    intercept: Array
    limit: Array


class Earlier(NamedTuple):
    """What contacts remember of the instant before, intercepts (elements,), motion w (rows,) and limits (elements,), and how the
    velocity follows from the motion of the new instant: drift + rate w, drift (rows,) [m/s], rate [1/s]. lands: whether a slider
    that lands begins where it lands, within the step; dampers alone land at the end of a step, by either of their methods.
    time: of the step [s], 0 without inertia."""

    intercept: Array
    w: Array
    limit: Array
    drift: Array
    rate: float
    lands: bool
    time: float


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
def contact_law(given: ContactTable, w: Array, earlier: Earlier, intercept: Array, limit: Array, found: Slopes) -> None:
    """λ̂ and its derivatives at motion w (rows,), from the instant before; fills the new intercepts and the limits."""
    table, before, slopes = view(given), view(earlier), view(found)
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
def limit_line(table: ContactTable, e: int, z: float) -> tuple[float, float]:
    """ℓ = μ Σ N + L0 of friction element e, its limit without bends, and dℓ/dz."""
    load, slope = 0.0, 0.0
    for k in range(table.load_first[e], table.load_last[e]):
        force = table.normal_stiffness[k] * z + table.normal_constant[k]
        if force > 0.0:
            load += force
            slope += table.normal_stiffness[k]
    return table.friction[e] * load + table.constant_limit[e], table.friction[e] * slope


@inner
def slip_limit(table: ContactTable, e: int, z: float) -> tuple[float, float]:
    """Limit L of friction element e, and dL/dz."""
    line, slope = limit_line(table, e, z)
    limit, factor = bent(table, e, line)
    return limit, factor * slope


@inner
def _landing(table: ContactTable, e: int, z0: float, z: float) -> float:
    """Share of a step at which friction element e lands, its normal motion taken as straight; 0 where it does not."""
    bound, slope = limit_line(table, e, z)
    if z <= z0 or bound <= 0.0 or slope <= 0.0 or limit_line(table, e, z0)[0] > 0.0:
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


@inlined
def _law_rows(
    table: ContactTable, c: int, w: Array, z: float, before: Earlier, intercept: Array, limit: Array, slopes: Slopes
) -> None:
    """T − K_c u of the tangential rows of contact c by the step of its law, and the intercepts of its states. A contact that
    lands within the step begins there, at a share of it, which moves with the motion after the step."""
    a, data, e = table.first_row[c], contact_data(table, c), table.friction_first[table.first_row[c]]
    size, states, normal = data.kt.size, data.spring.size, table.normal_row[c]
    L0, L, slope, share = 0.0, 0.0, 0.0, 0.0
    if states:
        L0, (L, slope) = before.limit[e], slip_limit(table, e, z)
    if before.lands and states and normal >= 0 and L0 <= 0.0:
        share = _landing(table, e, before.w[normal], z)
    state, moved, travel, velocity = np.zeros(states), np.empty(size), np.empty(size), np.empty(size)
    for d in range(size):
        moved[d] = w[a + d] - before.w[a + d]
        travel[d] = (1.0 - share) * moved[d]
        velocity[d] = before.drift[a + d] + before.rate * w[a + d]
    for i in range(states if share == 0.0 else 0):
        state[i] = before.intercept[e + i] + data.spring[i] * before.w[a + data.direction[i]]
    found, time = no_step(states, size), (1.0 - share) * before.time
    motion = StepMotion(state, travel, w[a : a + size], velocity, L0 if share == 0.0 else 0.0, L, time)
    slopes.work[a] = take_step(data, motion, found)
    for i in range(states):
        intercept[e + i], limit[e + i] = found.state[i] - data.spring[i] * w[a + data.direction[i]], L
    for d in range(size):
        r, o = a + d, size - 1 - d
        slopes.target[r] = traction(data, found, d) - data.kt[d] * w[r]
        slopes.own[r] = found.direct_by_u[d, d] - data.kt[d] + before.rate * found.direct_by_velocity[d, d]
        slopes.cross[r] = found.direct_by_u[d, o] + before.rate * found.direct_by_velocity[d, o]
        slopes.coupling[r] = found.direct_by_limit[d] * slope
        for i in range(states):
            weight, passed = traction_by_state(data, found, d, i), found.by_time[i] * before.time
            slopes.own[r] += weight * (1.0 - share) * found.by_travel[i, d]
            slopes.cross[r] += weight * (1.0 - share) * found.by_travel[i, o]
            slopes.coupling[r] += weight * found.by_limit[i] * slope
            for k in range(size if share > 0.0 else 0):
                passed += found.by_travel[i, k] * moved[k]
            if share > 0.0:
                slopes.coupling[r] += weight * passed * share / (z - before.w[normal])


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
    """−∂λ̂_r/∂λ_s, with w = w_free − Gλ; with the shapes R in place of G, ∂λ̂_r by a mode."""
    value = slopes.own[r] * G[r, s]
    if table.loading_row[r] >= 0:
        value += slopes.coupling[r] * G[table.loading_row[r], s]
    if table.partner_row[r] >= 0:
        value += slopes.cross[r] * G[table.partner_row[r], s]
    return float(value)


Compliance = tuple[Array, Array, Array]
"""G of a step (rows, rows), or (0, 0) and its factors R and P, (rows, modes)."""


@inner
def _change(residual: Array, found: Slopes, given: ContactTable, compliance: Compliance, change: Array) -> bool:
    """Newton's change of λ (rows,); False where the system of the rows that slip or open is singular."""
    slopes, table = view(found), view(given)
    change[:] = -residual
    active = np.flatnonzero((slopes.own != 0.0) | (slopes.coupling != 0.0) | (slopes.cross != 0.0))
    (G, shape, driven), size = compliance, active.size
    if G.size < residual.size:
        moved = np.empty((size, shape.shape[1]))
        for i in range(size):
            for j in range(shape.shape[1]):
                moved[i, j] = _slope(slopes, table, shape, active[i], j)
        right = driven.T @ residual
        if not solve_in_place(np.eye(right.size) + driven[active].T @ moved, right):
            return False
        change[active] += moved @ right
        return True
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
    table: ContactTable,
    compliance: Compliance,
    free: Array,
    before: Earlier,
    trial: ContactState,
    slopes: Slopes,
    residual: Array,
) -> float:
    """Fill w, intercepts, limits and R = λ − λ̂(w) of a trial λ; returns ‖R‖."""
    G, shape, driven = compliance
    trial.w[:] = free - (shape @ (driven.T @ trial.forces) if G.size < free.size else G @ trial.forces)
    contact_law(table, trial.w, before, trial.intercept, trial.limit, slopes)
    residual[:] = trial.forces - slopes.target
    return float(np.sqrt(np.sum(residual * residual)))


@inner
def solve_contacts(
    table: ContactTable,
    stiffness: Array,
    compliance: Compliance,
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
    size = _residual(table, compliance, free, before, state, slopes, residual)
    patience = PATIENCE
    for iteration in range(ITERATIONS):
        scale = np.sqrt(np.sum(state.forces**2)) + np.sqrt(np.sum((stiffness * state.w) ** 2))
        if size <= TOLERANCE * scale:
            return iteration
        if not _change(residual, slopes, table, compliance, change):
            change[:] = -0.5 * residual
        start[:] = state.forces
        length, trial = 1.0, size
        for _ in range(10):
            state.forces[:] = start + length * change
            trial = _residual(table, compliance, free, before, state, slopes, residual)
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
            trial = _residual(table, compliance, free, before, state, slopes, residual)
        size = trial
    return -1


@kernel
def contact_work(
    table: ContactTable, stiffness: Array, intercept: Array, path: Array, velocity: Array, step: float, first: int
) -> float:
    """Work that the contacts take from the instant `first` of a path to its end, J, by the trapezoidal rule.

    path, velocity (instants, rows) [m, m/s]; step: between instants, s; stiffness K_c (rows,); intercept (elements,): of the
    friction elements at the first instant, T − kt u, as in `ContactCycle`.
    """
    rows = path.shape[1]
    before, after, limit = intercept.copy(), intercept.copy(), np.zeros(intercept.size)
    slopes, forces, work = no_slopes(rows), np.zeros(rows), 0.0
    for n in range(path.shape[0]):
        last = max(n - 1, 0)
        earlier = Earlier(before.copy(), path[last], limit.copy(), velocity[n], 0.0, n > 0, step if n > 0 else 0.0)
        contact_law(table, path[n], earlier, after, limit, slopes)
        before[:] = after
        for r in range(rows):
            force = slopes.target[r] + stiffness[r] * path[n, r]
            if n > first:
                work += 0.5 * (force + forces[r]) * (path[n, r] - path[last, r])
            forces[r] = force
    return work
