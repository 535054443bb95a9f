"""Newton's linear system factorised and solved on the states of the structure, where these are fewer than the unknowns of λ.

`modal_matrix` has the matrix; here are its borders, the way from a solution back to the unknowns, and the choice between the two.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import boolean, float64, int64, typeof, void
from numpy.typing import NDArray

from stickslip.solve.balance.lapack import lu_factor, lu_solve, orientation
from stickslip.solve.balance.modal_matrix import (
    coordinates,
    driven_by,
    from_line,
    in_line,
    modal_matrix,
    motion_of,
    places,
    weights_on,
)
from stickslip.solve.balance.newton_matrix import push, pushed, spread, subtract
from stickslip.solve.balance.receptance import frequency_gains
from stickslip.solve.balance.system import (
    BORDER,
    BORDERED,
    ON_STATES,
    SMALLER,
    STATE,
    Border,
    Bordered,
    State,
    System,
    empty_system,
)
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import compiled, inlined, inner, separate
from stickslip.support.kernels.arrays import empty_blocks, empty_line, empty_table, zero_table
from stickslip.support.kernels.views import view_of

FEWEST_UNKNOWNS = 300
"""Unknowns of λ below which Newton's linear system is solved for them whatever the states: there it is a small part of a step."""


@inlined
def takes_states(system: System, offsets: Index) -> bool:
    """Whether the matrix on M coordinates takes fewer multiplications than that on N unknowns of λ: M³/3 + N M²/(2H+1) against
    N³/3."""
    unknowns, states = float(offsets[-1]), 0.0
    for i in system.kept:
        first, last = coordinates(system.modes, (i + 1) // 2)
        states += last - first
    if system.form != SMALLER:
        return system.form == ON_STATES and unknowns > 0.0
    if unknowns < FEWEST_UNKNOWNS:
        return False
    return states * states * (states / 3.0 + unknowns / system.kept.size) < unknowns**3 / 3.0


def factorised_on_states_signature() -> Any:
    """Types of `factorised_on_states`."""
    given = typeof(STATE), float64, typeof(BORDER), int64[::1], boolean[:, ::1]
    return typeof(BORDERED)(view_of(empty_system()), *given, *(float64[:, ::1],) * 4)


@separate(factorised_on_states_signature)
def factorised_on_states(
    system: System,
    state: State,
    omega: float,
    border: Border,
    offsets: Index,
    mask: NDArray[np.bool_],
    by: Array,
    weight: Array,
    raised: Array,
    matrix: Array,
) -> Bordered:
    """The matrix on the states with its borders put beside it, factorised; by: dw by the parameter; weight (rows, 2H+1) and
    raised: those of a held amplitude and of its level."""
    modes, kept = system.modes, system.kept
    starts, held = places(modes, kept), system.control.row >= 0
    size = starts[-1]
    columns = zero_table(1 + held, offsets[-1])
    push(system, state, offsets, by, columns[0])
    if not border.by_level:
        subtract(kept, offsets, state.by_omega, columns[0])
    if held:
        push(system, state, offsets, raised, columns[1])
    normal, partner = system.table.loading_row, system.table.partner_row
    blocks = (state.own, state.coupling, state.cross)
    system.effort[2] += modal_matrix(modes, state.gains, omega, kept, offsets, normal, partner, *blocks, matrix)
    for n in range(1 + held):
        forces = zero_table(mask.shape[0], mask.shape[1])
        spread(mask, columns[n], forces)
        in_line(modes, kept, starts, driven_by(modes, state.gains, omega, forces), 1.0, matrix[:size, size + n])
    if border.weight.shape[0]:
        in_line(modes, kept, starts, weights_on(modes, border.weight), -1.0, matrix[size, :size])
    if held:
        in_line(modes, kept, starts, weights_on(modes, weight), -1.0, matrix[size + 1, :size])
    pivots = lu_factor(matrix)
    system.effort[2] += matrix.shape[0] ** 3 // 3
    return Bordered(matrix, pivots, offsets, mask, orientation(matrix, pivots), columns, _kept_blocks(state), omega)


@inner
def _kept_blocks(state: State) -> Array:
    """own, coupling and cross of a state in one array (3 rows, 2H+1, 2H+1)."""
    rows, columns = state.own.shape[0], state.own.shape[1]
    found = empty_blocks(3 * rows, columns, columns)
    found[:rows], found[rows : 2 * rows] = state.own, state.coupling
    if state.cross.shape[0]:
        found[2 * rows :] = state.cross
    return found


@inner
def three_blocks(bordered: Bordered) -> tuple[Array, Array, Array]:
    """own, coupling and cross again, each (rows, 2H+1, 2H+1)."""
    rows = bordered.mask.shape[0]
    return bordered.blocks[:rows], bordered.blocks[rows : 2 * rows], bordered.blocks[2 * rows :]


def solve_on_states_signature() -> Any:
    """Types of `solve_on_states`."""
    return void(view_of(empty_system()), typeof(BORDERED), float64[:, ::1])


@separate(solve_on_states_signature)
def solve_on_states(system: System, bordered: Bordered, right: Array) -> None:
    modes, kept, borders = system.modes, system.kept, bordered.columns.shape[0]
    starts, size = places(modes, kept), bordered.offsets[-1]
    states, columns = starts[-1], bordered.mask.shape[1]
    normal, partner = system.table.loading_row, system.table.partner_row
    line, pushed_by = empty_table(1, states + borders), empty_line(size)
    gains, blocks = frequency_gains(modes, bordered.omega, (columns - 1) // 2), three_blocks(bordered)
    for each in right:
        forces = zero_table(bordered.mask.shape[0], columns)
        spread(bordered.mask, each, forces)
        in_line(modes, kept, starts, driven_by(modes, gains, bordered.omega, forces), 1.0, line[0])
        for n in range(borders):
            line[0, states + n] = each[size + n]
        lu_solve(bordered.lu, bordered.pivots, line)
        moved = motion_of(modes, from_line(modes, kept, starts, line[0], columns))
        pushed(bordered.offsets, kept, normal, partner, *blocks, moved, pushed_by)
        for n in range(borders):
            amount = each[size + n] = line[0, states + n]
            for k in range(size):
                each[k] -= amount * bordered.columns[n, k]
        for k in range(size):
            each[k] -= pushed_by[k]


def compile_on_states(system: System) -> None:
    """Compile what solves Newton's linear system on the states, or take it from disk; nothing where these are never the fewer."""
    modes, balanced = system.modes, (system.kept + 1) // 2
    fewest = modes.basis.shape[1] or int(np.min(modes.last[balanced] - modes.first[balanced]))
    many = system.table.rows > fewest and system.table.rows * system.kept.size >= FEWEST_UNKNOWNS
    if system.form == ON_STATES or many:
        compiled(factorised_on_states, solve_on_states)
