"""One steady period of every contact, sample by sample: motion, force, state and slip work, for results only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stickslip.model.contact.dispatch import law_period
from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.period import OPEN, SLIP, STICK, friction_period
from stickslip.model.contact.protocol import PeriodMotion, no_forces
from stickslip.model.contact.table import ContactTable, contact_data
from stickslip.solve.balance.contact_forces import element_limits
from stickslip.solve.balance.fourier import Fourier
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inlined, inner, kernel


@dataclass(frozen=True, eq=False)
class ContactCycle:
    """Samples over one period of every row: displacement [m], force [N], state (STICK, SLIP or OPEN), each (rows, Nt).

    slip_work (rows,): work of friction over the period, of sliders Σ μN |Δs|, J; a friction disc has it on its first row.
    slider (elements,): where the slider of each friction element stands at the last sample, s = u − T/kt, m; mean_slider: its
    mean over the period. Zero without a spring kt. intercept (elements,): T − kt u there, N, or a further state.
    """

    displacement: Array
    force: Array
    state: Index
    slip_work: Array
    slider: Array
    mean_slider: Array
    intercept: Array

    def shares(self) -> Array:
        """Shares of the period in stick, slip and without contact, (3, rows). A closed normal direction counts as stick."""
        return np.asarray(np.mean(self.state == np.array([STICK, SLIP, OPEN])[:, None, None], axis=2))


def contact_cycle(table: ContactTable, tables: Fourier, w: Array, omega: float) -> ContactCycle:
    """The period of every contact for motion w (rows, 2H+1) [m] at omega [rad/s]."""
    rows, samples = table.rows, tables.E.shape[0]
    displacement = np.ascontiguousarray(w[:rows] @ tables.E.T)
    velocity = np.ascontiguousarray(omega * (w[:rows] @ tables.D.T))
    force, state = np.zeros((rows, samples)), np.zeros((rows, samples), dtype=np.int64)
    slip_work, intercept = np.zeros(rows), np.zeros((2, table.stiffness.size))
    _fill_cycle(table, displacement, velocity, omega, np.ascontiguousarray(w[:rows, 0]), force, state, slip_work, intercept)
    slider = np.divide(-intercept, table.stiffness, out=np.zeros_like(intercept), where=table.stiffness > 0.0)
    return ContactCycle(displacement, force, state, slip_work, slider[0], slider[1], intercept[0])


def forces_of_motion(table: ContactTable, displacement: Array, omega: float) -> Array:
    """Steady forces (rows, Nt) [N] under a prescribed period of motion (rows, Nt) [m] at omega [rad/s]; velocities by central
    differences."""
    displacement = np.ascontiguousarray(displacement)
    step = 2.0 * np.pi / (omega * displacement.shape[1])
    velocity = (np.roll(displacement, -1, axis=1) - np.roll(displacement, 1, axis=1)) / (2.0 * step)
    force, state = np.zeros(displacement.shape), np.zeros(displacement.shape, dtype=np.int64)
    slip_work, intercept = np.zeros(table.rows), np.zeros((2, table.stiffness.size))
    _fill_cycle(table, displacement, velocity, omega, displacement.mean(axis=1), force, state, slip_work, intercept)
    return force


@kernel
def _fill_cycle(
    table: ContactTable,
    displacement: Array,
    velocity: Array,
    omega: float,
    mean: Array,
    force: Array,
    state: Index,
    slip_work: Array,
    intercept: Array,
) -> None:
    """intercept (2, elements): at the last sample, and the mean."""
    samples = displacement.shape[1]
    limit, slope, landing, y = np.empty(samples), np.empty(samples), np.empty(samples), np.empty(samples)
    event, none = np.empty(samples, dtype=np.int64), np.zeros(samples)
    for c in range(table.normal_row.size):
        first, last = table.normal_first[c], table.normal_first[c + 1]
        loads, slopes = np.zeros((max(last - first, 1), samples)), np.zeros((max(last - first, 1), samples))
        row = table.normal_row[c]
        for e in range(first, last):
            for n in range(samples):
                loads[e - first, n] = max(table.normal_stiffness[e] * displacement[row, n] + table.normal_constant[e], 0.0)
                slopes[e - first, n] = table.normal_stiffness[e] if loads[e - first, n] > 0.0 else 0.0
                force[row, n] += loads[e - first, n]
        if row >= 0:
            for n in range(samples):
                state[row, n] = STICK if force[row, n] > 0.0 else OPEN
        z = displacement[row] if row >= 0 else none
        if table.kind[c] != SLIDERS:
            _fill_law(table, c, displacement, velocity, z, omega, loads, slopes, force, state, slip_work, intercept)
            continue
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if r == row:
                continue
            state[r, :] = OPEN
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                kt = table.stiffness[e]
                element_limits(table, e, first, z, loads, slopes, limit, slope, landing)
                ku = kt * displacement[r]
                kind, value = table.start_kind[e], table.start_value[e]
                friction_period(kind, value, kt, ku, limit, landing, kt * mean[r], y, event)
                force[r] += y + ku
                slip_work[r] += _slip_work(kt, y, limit)
                intercept[0, e], intercept[1, e] = y[-1], np.mean(y)
                for n in range(samples):
                    if event[n] != OPEN and state[r, n] != SLIP:
                        state[r, n] = STICK if event[n] == STICK else SLIP


@inlined
def _fill_law(
    table: ContactTable,
    c: int,
    displacement: Array,
    velocity: Array,
    z: Array,
    omega: float,
    loads: Array,
    slopes: Array,
    force: Array,
    state: Index,
    slip_work: Array,
    intercept: Array,
) -> None:
    """The tangential rows of contact c by the kernel of its law."""
    first, samples, data = table.first_row[c], displacement.shape[1], contact_data(table, c)
    last = first + data.kt.size
    limit, slope, landing, none = np.zeros(samples), np.zeros(samples), np.zeros(samples), np.empty((samples, 0))
    e = table.friction_first[first]
    if table.friction_first[first + 1] > e:
        element_limits(table, e, table.normal_first[c], z, loads, slopes, limit, slope, landing)
    found = no_forces(data, samples, 0)
    motion = PeriodMotion(displacement[first:last], velocity[first:last], z, limit, slope, landing, omega, none, none)
    law_period(table.kind[c], data, motion, found)
    for d in range(data.kt.size):
        kt, y = data.kt[d], found.y[d]
        for n in range(samples):
            force[first + d, n] = y[n] + kt * displacement[first + d, n]
            state[first + d, n] = found.event[n]
        slip_work[first + d] = found.work[d]
    for i in range(data.spring.size):
        intercept[0, e + i], intercept[1, e + i] = found.intercept[i, -1], np.mean(found.intercept[i])


@inner
def _slip_work(kt: float, y: Array, limit: Array) -> float:
    """Σ L |Δs| of one element, s = −y/kt the slider; L taken at the middle of each step."""
    work = 0.0
    for n in range(y.size):
        work += 0.5 * (limit[n] + limit[n - 1]) * abs(y[n] - y[n - 1]) / kt
    return work


def friction_limits(table: ContactTable, tables: Fourier, w: Array) -> Iterator[tuple[int, int, Array, Array, Array]]:
    """For motion w, element by element: friction element, its row, displacement u, limit L and `landing_shares`, each (Nt,)."""
    samples = tables.E.shape[0]
    z = np.zeros(samples)
    for c in range(table.normal_row.size):
        first, last = table.normal_first[c], table.normal_first[c + 1]
        loads, slopes = np.zeros((max(last - first, 1), samples)), np.zeros((max(last - first, 1), samples))
        if last > first:
            z = tables.E @ w[table.normal_row[c]]
            loads = np.maximum(table.normal_stiffness[first:last, None] * z + table.normal_constant[first:last, None], 0.0)
            slopes = np.where(loads > 0.0, table.normal_stiffness[first:last, None], 0.0)
        for r in range(table.first_row[c], table.first_row[c + 1]):
            u = tables.E @ w[r]
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                limit, slope, landing = np.empty(samples), np.empty(samples), np.empty(samples)
                element_limits(table, e, first, z, loads, slopes, limit, slope, landing)
                yield e, r, u, limit, landing


def friction_reach(table: ContactTable, tables: Fourier, w: Array) -> tuple[Array, Array]:
    """For each friction element, over the period of motion w: max|u| + max L/kt [m], 0 without a spring kt, and max L [N]."""
    reach, largest = np.zeros(table.stiffness.size), np.zeros(table.stiffness.size)
    for e, _, u, limit, _ in friction_limits(table, tables, w):
        largest[e] = limit.max()
        if table.stiffness[e] > 0.0:
            reach[e] = np.abs(u).max() + limit.max() / table.stiffness[e]
    return reach, largest
