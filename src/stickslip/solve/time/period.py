"""One compiled period of time integration: N steps of size h, advancing the state in place and recording histories.

The linear part of a step is a product with constant matrices; the contacts are solved by `stickslip.solve.time.contact_law`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.table import ContactTable
from stickslip.solve.time.contact_law import ContactState, Earlier, Slopes, contact_law, no_slopes, solve_contacts
from stickslip.solve.time.model import StepMatrices
from stickslip.support.checks import Array
from stickslip.support.kernels import boxed, inlined, inner, kernel, uncompiled


class State(NamedTuple):
    """Everything that evolves, changed in place: modal motion η, velocity, acceleration (m,), the contacts and their λ of the
    step before (rows,)."""

    motion: Array
    velocity: Array
    acceleration: Array
    contacts: ContactState
    forces_before: Array


class Loads(NamedTuple):
    """Modal loads: static (m,), harmonic (m, 2H+1), and the Fourier rows of the samples (N, 2H+1)."""

    static: Array
    harmonic: Array
    rows: Array


class History(NamedTuple):
    """Samples t_0 .. t_{N−1} of a period: outputs, contact motion, contact force f (rows, N); friction work of rows (rows,), that
    of a law with kernels of its own on its first row."""

    outputs: Array
    contact_motion: Array
    contact_force: Array
    friction_work: Array


class PeriodWork(NamedTuple):
    """Input and viscous work over a period, J; iterations of all steps; the step that failed, or −1."""

    given: float
    viscous: float
    iterations: int
    failed: int


@inner
def _times(matrix: Array, vector: Array) -> Array:
    """matrix · vector, a diagonal matrix being stored as one column."""
    if matrix.shape[1] == 1 and vector.size != 1:
        return matrix[:, 0] * vector
    return matrix @ vector


def settle(table: ContactTable, matrices: StepMatrices, loads: Loads, state: State) -> None:
    """Make a start consistent: λ, sliders and limits from the motion, accelerations from the equation of motion.

    Motions too fast for the step (m < h²) and massless ones start without acceleration.
    """
    contacts = state.contacts
    slopes = uncompiled(no_slopes)(contacts.w.size)
    contacts.w[:] = matrices.shape @ state.motion
    drift = matrices.shape @ state.velocity
    before = Earlier(contacts.intercept.copy(), contacts.w.copy(), contacts.limit.copy(), drift, 0.0, True, 0.0)
    contact_law(table, contacts.w, before, contacts.intercept, contacts.limit, slopes)
    contacts.forces[:] = slopes.target
    state.forces_before[:] = slopes.target
    force = loads.static + loads.harmonic @ loads.rows[0] - matrices.receiver @ contacts.forces - state.motion
    force -= uncompiled(_times)(matrices.damping, state.velocity)
    resolved = matrices.mass >= matrices.step**2
    state.acceleration[:] = np.where(resolved, force / np.where(resolved, matrices.mass, 1.0), 0.0)


@kernel
def march_period(table: ContactTable, matrices: StepMatrices, loads: Loads, state: State, history: History) -> PeriodWork:
    """March N steps from t = 0 of a period. Column n of the histories holds t_n, column 0 the end of the period."""
    contacts, step = state.contacts, matrices.step
    mass_weight, force_weight, beta, gamma = matrices.coefficients
    history.friction_work[:] = 0.0
    given, viscous, iterations = 0.0, 0.0, 0
    rate, slopes = gamma / (beta * step), no_slopes(contacts.w.size)
    resistance = _times(matrices.damping, state.velocity)
    pushed = matrices.receiver @ contacts.forces
    rest = loads.static + loads.harmonic @ loads.rows[0] - pushed - state.motion - resistance
    for n in range(1, loads.rows.shape[0] + 1):
        column = n % loads.rows.shape[0]
        shaken = loads.harmonic @ loads.rows[column]
        predicted = state.motion + step * state.velocity + step**2 * (0.5 - beta) * state.acceleration
        drifted = state.velocity + step * (1.0 - gamma) * state.acceleration
        right = (1.0 - force_weight) * (loads.static + shaken - predicted - _times(matrices.damping, drifted))
        right += force_weight * rest - mass_weight * matrices.mass * state.acceleration
        free = matrices.shape @ (predicted + _times(matrices.inverse, right))
        drift = matrices.shape @ (drifted - rate * predicted)
        before = Earlier(contacts.intercept.copy(), contacts.w.copy(), contacts.limit.copy(), drift, rate, True, step)
        guess = 2.0 * contacts.forces - state.forces_before
        state.forces_before[:] = contacts.forces
        used = -1
        for attempt in range(2):
            if attempt:
                guess[:] = state.forces_before
            used = solve_contacts(table, matrices.stiffness, matrices.compliance, free, guess, before, contacts, slopes)
            if used >= 0:
                break
        if used < 0:
            return boxed(PeriodWork(given, viscous, iterations, n))
        iterations += used
        pushed = matrices.receiver @ contacts.forces
        change = _times(matrices.inverse, right - (1.0 - force_weight) * pushed)
        state.motion[:] = predicted + change
        state.velocity[:] = drifted + rate * change
        state.acceleration[:] = change / (beta * step**2)
        resistance = _times(matrices.damping, state.velocity)
        rest = loads.static + shaken - pushed - state.motion - resistance
        given += step * float(np.sum(shaken * state.velocity))
        viscous += step * float(np.sum(resistance * state.velocity))
        _record(table, matrices, state, before, slopes, column, history)
    return boxed(PeriodWork(given, viscous, iterations, -1))


@inlined
def _record(
    table: ContactTable, matrices: StepMatrices, state: State, before: Earlier, slopes: Slopes, column: int, history: History
) -> None:
    """Fill a column of the histories and add the friction work of the step, of sliders L |Δs|, s = −y/kt, L at its middle; of a
    law of its own that of its states and, by the trapezoidal rule, of what no spring carries."""
    contacts = state.contacts
    history.outputs[:, column] = matrices.outputs @ state.motion
    history.contact_motion[:, column] = contacts.w
    history.contact_force[:, column] = contacts.forces + matrices.stiffness * contacts.w
    for c in range(table.kind.size):
        if table.kind[c] != SLIDERS:
            history.friction_work[table.first_row[c]] += slopes.work[table.first_row[c]]
            for r in range(table.first_row[c], table.first_row[c + 1]):
                if table.friction_first[r + 1] > table.friction_first[r]:
                    direct = state.forces_before[r] + contacts.forces[r]
                    for e in range(table.friction_first[r], table.friction_first[r + 1]):
                        if table.stiffness[e] > 0.0:
                            direct -= before.intercept[e] + contacts.intercept[e]
                    history.friction_work[r] += 0.5 * direct * (contacts.w[r] - before.w[r])
            continue
        for r in range(table.first_row[c], table.first_row[c + 1]):
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                slid = abs(contacts.intercept[e] - before.intercept[e]) / table.stiffness[e]
                history.friction_work[r] += 0.5 * (contacts.limit[e] + before.limit[e]) * slid
