"""Newton matrix on coordinates of the structure: the smaller form where contacts have more unknowns than the structure.

J = I + E G' with G' = Φ g Ψᵀ. With z = g Ψᵀ x, the coordinates that a change x of λ drives, J x = r is x = r − E Φ z,
(I + g Ψᵀ E Φ) z = g Ψᵀ r (M. A. Woodbury, 1950). det(I + A B) = det(I + B A): the small matrix has the determinant of J, and
bordered that of J bordered. E is block-diagonal by contact, so the work grows with the number of contacts, not with its cube.

The coordinates are the states, g = Γ; where these are more than the degrees of freedom, as of complex modes, the latter.

Newton's linear system factorised and solved on the states of the structure, where these are fewer than the unknowns of λ.

`modal_matrix` has the matrix; here are its borders, the way from a solution back to the unknowns, and the choice between the two.
"""

from typing import Any

import numpy as np
from numba import boolean, float64, int64, typeof, void
from numpy.typing import NDArray

from stickslip.solve.balance.newton_matrix import add_product, lu_factor, lu_solve, orientation, push, pushed, spread, subtract
from stickslip.solve.balance.receptance import (
    Complex,
    Modes,
    frequency_gains,
    modal_states,
    respond_in_basis,
    respond_to_each,
    seen,
)
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
from stickslip.support.kernels.arrays import empty_blocks, empty_line, empty_table, fill, zero_numbers, zero_table
from stickslip.support.kernels.views import view_of

ROWS = 64
"""Contact rows that are taken together: as many as keep BLAS busy in little memory."""


@inner
def coordinates(modes: Modes, h: int) -> tuple[int, int]:
    """The first and the last + 1 of the coordinates of a harmonic: those of the basis, or the states."""
    return (0, modes.basis.shape[1]) if modes.basis.shape[1] else (modes.first[h], modes.last[h])


@inner
def places(modes: Modes, kept: Index) -> Index:
    """Where the coordinates of each kept column start in the small matrix, (kept + 1,)."""
    starts = zero_numbers(kept.size + 1)
    for k in range(kept.size):
        first, last = coordinates(modes, (kept[k] + 1) // 2)
        starts[k + 1] = starts[k] + last - first
    return starts


@inner
def in_line(modes: Modes, kept: Index, starts: Index, values: Array, factor: float, line: Array) -> None:
    """line (M,) = factor times values of the coordinates (m, 2H+1), in the order of the small matrix."""
    for k in range(kept.size):
        first, last = coordinates(modes, (kept[k] + 1) // 2)
        for j in range(last - first):
            line[starts[k] + j] = factor * values[first + j, kept[k]]


@inner
def from_line(modes: Modes, kept: Index, starts: Index, line: Array, columns: int) -> Array:
    """Coordinates (m, 2H+1) of a solution (M,) of the small system."""
    found = zero_table(modes.basis.shape[1] or modes.kind.size, columns)
    for k in range(kept.size):
        first, last = coordinates(modes, (kept[k] + 1) // 2)
        for j in range(last - first):
            found[first + j, kept[k]] = line[starts[k] + j]
    return found


@inner
def driven_by(modes: Modes, gains: Complex, omega: float, forces: Array) -> Array:
    """Coordinates (m, 2H+1) that forces x (rows, 2H+1) drive."""
    states = modal_states(modes, omega, gains, np.dot(modes.receiver.T, forces), False)
    found: Array = np.dot(modes.output, states) if modes.basis.shape[1] else states
    return found


@inner
def motion_of(modes: Modes, values: Array) -> Array:
    """Motion (rows, 2H+1) of coordinates (m, 2H+1)."""
    found: Array = np.dot(modes.basis, values) if modes.basis.shape[1] else seen(modes, values)
    return found


@inner
def weights_on(modes: Modes, weighted: Array) -> Array:
    """Weights of the coordinates (m, 2H+1) in a weighted sum of motions, weighted (rows, 2H+1)."""
    found: Array = np.dot(modes.basis.T, weighted) if modes.basis.shape[1] else np.dot(modes.shape.T, weighted)
    return found


@inner
def _add_rows(
    shape: Array, kept: Index, starts: Index, firsts: Index, own: Array, row: int, other: Array, beside: int, line: Array
) -> None:
    """line (M,) += a row of E, (2H+1,), times the motion of contact row `row` for each coordinate, and another times that of row
    `beside`, if that is not −1; shape (rows, m): motion by coordinate, firsts (kept,): the first coordinate of each column."""
    for k in range(kept.size):
        first, last = firsts[k], firsts[k] + starts[k + 1] - starts[k]
        a, b = own[kept[k]], other[kept[k]] if beside >= 0 else 0.0
        x, y, part = shape[row, first:last], shape[max(beside, 0), first:last], line[starts[k] : starts[k + 1]]
        for j in range(part.size):
            part[j] += a * x[j] + b * y[j]


@inner
def modal_matrix(
    modes: Modes,
    gains: Complex,
    omega: float,
    kept: Index,
    offsets: Index,
    normal: Index,
    partner: Index,
    own: Array,
    coupling: Array,
    cross: Array,
    matrix: Array,
) -> int:
    """Add I + g Ψᵀ E Φ to matrix[:M, :M], zeros before; the number of multiplications of contact rows."""
    starts, own_basis = places(modes, kept), modes.basis.shape[1] > 0
    received, shape = (modes.basis, modes.basis) if own_basis else (modes.receiver, modes.shape)
    firsts = zero_numbers(kept.size)
    for k in range(kept.size):
        firsts[k] = coordinates(modes, (kept[k] + 1) // 2)[0]
    size, rows, multiplications = starts[-1], normal.size, 0
    turned = empty_table(ROWS, size)
    for begin in range(0, rows, ROWS):
        for k in range(kept.size):
            i, width = kept[k], starts[k + 1] - starts[k]
            first, taken = firsts[k], empty_table(ROWS, width)
            count = 0
            for r in range(begin, min(begin + ROWS, rows)):
                if k >= offsets[r + 1] - offsets[r]:
                    continue
                for j in range(width):
                    taken[count, j] = received[r, first + j]
                fill(turned[count : count + 1], 0.0)
                _add_rows(shape, kept, starts, firsts, own[r, i], r, coupling[r, i], normal[r], turned[count])
                if partner[r] >= 0:
                    _add_rows(shape, kept, starts, firsts, cross[r, i], partner[r], cross[r, i], -1, turned[count])
                count += 1
            if count and width:
                multiplications += count * width * size
                add_product(taken[:count], turned[:count], matrix[starts[k] :])
    k = 0
    while k < kept.size:
        h = (kept[k] + 1) // 2
        sine = k + 1 if h > 0 else k
        s, parts = (
            1j * modes.order[h] * omega,
            (matrix[starts[k] : starts[k + 1], :size], matrix[starts[sine] : starts[sine + 1], :size]),
        )
        if own_basis:
            respond_in_basis(modes, h, s, gains[h], parts[0], parts[1])
        else:
            respond_to_each(modes, h, s, gains[h], parts[0], parts[1])
        k = sine + 1
    for k in range(size):
        matrix[k, k] += 1.0
    return multiplications


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


@separate(lambda: void(view_of(empty_system()), typeof(BORDERED), float64[:, ::1]))
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
