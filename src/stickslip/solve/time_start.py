"""Where time integration starts: from rest, or inside a solution of the harmonic balance with its motion and its sliders.

Friction remembers: an element that never slips in the steady period keeps its slider where it starts, in time as in the
harmonic balance. Starting with the sliders of a harmonic solution is what makes the two comparable where forces are not unique.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.checks import Array, Index
from stickslip.contact.period import friction_period, start_intercept
from stickslip.contact.table import ContactTable, contact_table
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.contact_forces import element_limits
from stickslip.kernels import njit
from stickslip.problem import Problem


@dataclass(frozen=True, eq=False)
class TimeStart:
    """State at t = 0: motion q (n,) [m], velocity (n,) [m/s], intercepts y = T − kt u (elements,) [N]."""

    motion: Array
    velocity: Array
    intercepts: Array


def from_rest(problem: Problem) -> TimeStart:
    """No motion, and every slider where its start rule puts it: offset y = −kt s, ratio y = m L, mean traction y = T̄."""
    table = contact_table(problem.contacts)
    rest = np.zeros((table.rows, 1))
    intercepts = _intercepts(table, rest, np.zeros(table.rows))
    return TimeStart(np.zeros(problem.structure.size), np.zeros(problem.structure.size), intercepts)


def from_harmonics(balance: HarmonicBalance, forces: Array, omega: float, level: float) -> TimeStart:
    """The state at t = 0 of a solution with λ = `forces` (rows, 2H+1) [N], at omega [rad/s] and a force level."""
    q = balance.linear.whole_motion(forces, omega, level)
    order = np.arange(1, balance.harmonics + 1)
    w = q.T @ balance.problem.B.T
    displacement = np.ascontiguousarray((balance.tables.E @ w).T)
    intercepts = _intercepts(balance.table, displacement, np.ascontiguousarray(w[0]))
    return TimeStart(q[:, 0] + q[:, 1::2].sum(axis=1), omega * (q[:, 2::2] @ order), intercepts)


@njit(cache=True)
def _intercepts(table: ContactTable, displacement: Array, mean: Array) -> Array:
    """y at sample 0 of the steady period of every friction element, for motion (rows, Nt) with mean (rows,).

    One sample stands for rest: there the start rule holds as it is, clipped to the limits.
    """
    samples = displacement.shape[1]
    found = np.zeros(table.stiffness.size)
    limit, slope, y = np.empty(samples), np.empty(samples), np.empty(samples)
    event: Index = np.empty(samples, dtype=np.int64)
    for c in range(table.normal_row.size):
        first, last = table.normal_first[c], table.normal_first[c + 1]
        loads, slopes = np.zeros((max(last - first, 1), samples)), np.zeros((max(last - first, 1), samples))
        row = table.normal_row[c]
        for e in range(first, last):
            for n in range(samples):
                loads[e - first, n] = max(table.normal_stiffness[e] * displacement[row, n] + table.normal_constant[e], 0.0)
        for r in range(table.first_row[c], table.first_row[c + 1]):
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                kt, kind, value = table.stiffness[e], table.start_kind[e], table.start_value[e]
                element_limits(table, e, first, loads, slopes, limit, slope)
                ku = kt * displacement[r]
                if samples > 1:
                    friction_period(kind, value, kt, ku, limit, kt * mean[r], y, event)
                    found[e] = y[0]
                else:
                    wanted = start_intercept(kind, value, kt, ku, limit, kt * mean[r])
                    found[e] = min(max(wanted, -limit[0] - ku[0]), limit[0] - ku[0])
    return found
