"""What the kernels of a contact law read and fill: one contact over a period, or over one step of a march.

A law that is a table of springs and sliders needs none. Any other law has two kernels in its own file,

    period(data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int    HELD, STATIC, SLIPPING or NOT_PERIODIC
    step(data: ContactData, motion: StepMotion, forces: StepForces) -> float        friction work of the step, J

and a branch for each in `stickslip.contact.dispatch`. Structures, harmonics and time integration know neither law nor kernel.
A law may have one friction element in each direction: its limit L = μ Σ N + L0 comes with the motion, its kt is the stuck spring.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import float64, int64, typeof

from stickslip.checks import Array, Index
from stickslip.contact.table import ContactTable
from stickslip.kernels import inner

NOT_PERIODIC = -1
"""In place of a state: the law found no periodic force."""


class ContactData(NamedTuple):
    """What a contact is. parameter: the law's own numbers; by tangential direction (d,): kt of its stuck spring [N/m], 0 without
    one, and rule and value of its start."""

    parameter: Array
    kt: Array
    start_kind: Index
    start_value: Array


class PeriodMotion(NamedTuple):
    """Motion of a contact over a period of Nt samples.

    u [m] and velocity [m/s] (d, Nt); normal motion z [m], limit L [N], slope dL/dz [N/m] and `landing_shares` (Nt,); omega
    [rad/s]; E, D (Nt, 2H+1) with u = E U, velocity = omega D U and z = E Z. Without columns of E no derivatives are asked for.
    """

    u: Array
    velocity: Array
    z: Array
    limit: Array
    slope: Array
    landing: Array
    omega: float
    E: Array
    D: Array


class PeriodForces(NamedTuple):
    """The answer over a period, zeros before: y = T − kt u [N] (d, Nt); event (Nt,) STICK, OPEN or another number for slip;
    tangents (Nt, d, 3, 2H+1) = dy/d(U1, U2, Z); by_omega (d, Nt) = ∂y/∂ω at fixed harmonics; work (d,): of friction [J]."""

    y: Array
    event: Index
    tangents: Array
    by_omega: Array
    work: Array


class StepMotion(NamedTuple):
    """Motion of a contact in a step. (d,): y = T − kt u [N] and u [m] before; u and velocity [m/s] after; L before, after."""

    intercept: Array
    u0: Array
    u: Array
    velocity: Array
    limit0: float
    limit: float


class StepForces(NamedTuple):
    """The answer after a step, zeros before: y = T − kt u [N] (d,); its derivatives by u, by velocity (d, d), by L (d,)."""

    y: Array
    by_u: Array
    by_velocity: Array
    by_limit: Array


@inner
def contact_data(table: ContactTable, c: int) -> ContactData:
    """Contact c of a table whose law has kernels of its own."""
    first, last = table.first_row[c], table.first_row[c + 1]
    if table.normal_row[c] >= 0:
        last -= 1
    kt, value, kind = np.zeros(last - first), np.zeros(last - first), np.zeros(last - first, dtype=np.int64)
    for r in range(first, last):
        for e in range(table.friction_first[r], table.friction_first[r + 1]):
            kt[r - first], kind[r - first], value[r - first] = table.stiffness[e], table.start_kind[e], table.start_value[e]
    return ContactData(table.parameter[table.parameter_first[c] : table.parameter_first[c + 1]], kt, kind, value)


@inner
def no_forces(directions: int, samples: int, columns: int) -> PeriodForces:
    """Zeros to be filled for so many samples; columns = 0: without derivatives."""
    return PeriodForces(
        np.zeros((directions, samples)),
        np.zeros(samples, dtype=np.int64),
        np.zeros((samples if columns else 0, directions, 3, columns)),
        np.zeros((directions, samples)),
        np.zeros(directions),
    )


def period_signature() -> Any:
    """Types of what the `period` of a law takes and returns."""
    line, table, table3, index = np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0, 0, 0)), np.zeros(0, dtype=np.int64)
    data, forces = ContactData(line, line, index, line), PeriodForces(table, index, table3, table, line)
    return int64(typeof(data), typeof(PeriodMotion(table, table, line, line, line, line, 0.0, table, table)), typeof(forces))


def step_signature() -> Any:
    """Types of what the `step` of a law takes and returns."""
    line, table, index = np.zeros(0), np.zeros((0, 0)), np.zeros(0, dtype=np.int64)
    data, forces = ContactData(line, line, index, line), StepForces(line, table, table, line)
    return float64(typeof(data), typeof(StepMotion(line, line, line, line, 0.0, 0.0)), typeof(forces))
