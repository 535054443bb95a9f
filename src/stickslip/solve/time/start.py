"""Initial conditions of a time integration: rest, or a harmonic balance solution with its sliders.

Friction remembers: an element that never slips in the steady period keeps its slider where it starts, in time as in the
harmonic balance. Starting with the sliders of a harmonic solution is what makes the two comparable where forces are not unique.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.model.contact.table import contact_table
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.cycle import contact_cycle
from stickslip.solve.balance.fourier import fourier
from stickslip.support.checks import Array, fault, of_kind


@dataclass(frozen=True, eq=False)
class TimeStart:
    """State at t = 0: motion q (n,) [m], velocity (n,) [m/s], intercepts y = T − kt u (elements,) [N]."""

    motion: Array
    velocity: Array
    intercepts: Array


def from_rest(problem: Problem) -> TimeStart:
    """No motion, and every slider where its start rule puts it: offset s, T = m L, or T = T̄, clipped to the limits."""
    table = contact_table(problem.contacts)
    rest = contact_cycle(table, fourier(1, 6), np.zeros((table.rows, 3)), 0.0)
    nothing = np.zeros(problem.structure.size)
    return TimeStart(nothing, nothing.copy(), rest.intercept)


def checked_start(problem: Problem, start: TimeStart) -> TimeStart:
    """A start, refused unless its motion, velocity and intercepts have the sizes of a problem."""
    states = of_kind("start", start, TimeStart), from_rest(problem)
    sizes, wanted = ([np.shape(values) for values in vars(state).values()] for state in states)
    if sizes != wanted:
        rule = f"must have motion, velocity and intercepts of shapes {wanted}"
        raise fault("start", rule, sizes, "Take a start state of this problem.")
    return start


def from_harmonics(balance: HarmonicBalance, forces: Array, omega: float, level: float) -> TimeStart:
    """The state at t = 0 of a solution with λ = `forces` (rows, 2H+1) [N], at omega [rad/s] and a force level.

    The sliders are those of the last sample, from which the first step at t = 0 moves them to where the solution has them.
    """
    q = balance.linear.whole_motion(forces, omega, level)
    order = np.arange(1, balance.highest + 1)
    cycle = contact_cycle(balance.table, balance.tables, balance.problem.B @ q, omega)
    return TimeStart(q[:, 0] + q[:, 1::2].sum(axis=1), omega * (q[:, 2::2] @ order), cycle.intercept)
