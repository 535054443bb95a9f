"""Newton matrix on the unknown rows, bordered by one row and column for the path parameter: dense, or on states of the structure.

J = I + E G' with E = dλ̂/dw; a held row of J is a row of the identity, so it drops out exactly. Columns: unknown harmonics of λ,
then the parameter (ω or force level); last row: the path condition.

LU factorisation and added products by SciPy's LAPACK and BLAS, called from compiled code.

Matrices lie by rows, LAPACK reads them by columns: it factorises the transpose, and solves with the transpose of that.

The form on coordinates of the structure is the smaller one where contacts have more unknowns than the structure has states: with
G' = Φ g Ψᵀ and z = g Ψᵀ x, the coordinates that a change x of λ drives, J x = r is x = r − E Φ z, (I + g Ψᵀ E Φ) z = g Ψᵀ r
(M. A. Woodbury, 1950). det(I + A B) = det(I + B A): the small matrix has the determinant of J, and bordered that of J bordered. E
is block-diagonal by contact, so the work grows with the number of contacts, not with its cube.

The coordinates are the states, g = Γ; where these are more than the degrees of freedom, as of complex modes, the latter.
"""

from typing import Any

import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]
from numba import boolean, float64, int64, typeof, types, void
from numba.extending import get_cython_function_address
from numpy.typing import NDArray

from stickslip.model.contact.point import ContactTable
from stickslip.model.contact.protocol import HELD, SLIPPING
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
from stickslip.support.kernels import compiled, inlined, inner, kernel, separate
from stickslip.support.kernels.arrays import empty_blocks, empty_line, empty_table, fill, zero_numbers, zero_table
from stickslip.support.kernels.views import view_of


@inlined
def unknown_entries(unknown: Index, kept: Index, columns: int) -> tuple[Index, NDArray[np.bool_]]:
    """Where the unknowns of each row start in the system (rows + 1), and which entries of λ (rows, 2H+1) they are.

    None of a held row, harmonic 0 of a static one, all of a slipping one, as far as the columns `kept` hold them.
    """
    mean = 1 if kept[0] == 0 else 0
    offsets = zero_numbers(unknown.size + 1)
    mask = np.zeros((unknown.size, columns), dtype=np.bool_)
    for r in range(unknown.size):
        size = 0 if unknown[r] == HELD else (kept.size if unknown[r] == SLIPPING else mean)
        offsets[r + 1] = offsets[r] + size
        for i in range(size):
            mask[r, kept[i]] = True
    return offsets, mask


@inlined
def moved_rows(normal: Index, partner: Index, unknown: Index) -> tuple[Index, Index, Index]:
    """Unknown rows; the rows whose motion they depend on (own, normal, partner); where each row stands in these, or −1."""
    rows = unknown.size
    needed = np.zeros(rows, dtype=np.bool_)
    for r in range(rows):
        if unknown[r] != HELD:
            needed[r] = True
            if normal[r] >= 0:
                needed[normal[r]] = True
            if partner[r] >= 0:
                needed[partner[r]] = True
    place, moved, active = zero_numbers(rows), zero_numbers(rows), zero_numbers(rows)
    moving, acting = 0, 0
    for r in range(rows):
        place[r] = moving if needed[r] else -1
        if needed[r]:
            moved[moving] = r
            moving += 1
        if unknown[r] != HELD:
            active[acting] = r
            acting += 1
    return active[:acting], moved[:moving], place


@inner
def _add_block(block: Array, kept: Index, E: Array, G: Array, column: int) -> None:
    """block += E times the real form of the receptance G[:, :, column] of each harmonic kept; G (2, H+1, columns)."""
    size, width = block.shape
    first = 1 if kept[0] == 0 else 0
    for k in range(size):
        i = kept[k]
        if first:
            block[k, 0] += E[i, 0] * G[0, 0, column]
        for j in range(first, width, 2):
            a = kept[j]
            h = (a + 1) // 2
            cosine, sine = E[i, a], E[i, a + 1]
            real, imaginary = G[0, h, column], G[1, h, column]
            block[k, j] += cosine * real - sine * imaginary
            block[k, j + 1] += cosine * imaginary + sine * real


@inlined
def newton_matrix(
    offsets: Index,
    kept: Index,
    normal: Index,
    partner: Index,
    active: Index,
    place: Index,
    own: Array,
    coupling: Array,
    cross: Array,
    G: Array,
    matrix: Array,
) -> None:
    """Add J on the unknown rows to matrix[:N, :N], zeros before; G = G'[moved rows, unknown rows] as (rows, 2, H+1, columns)."""
    for i in range(active.size):
        r = active[i]
        for j in range(active.size):
            a = active[j]
            block = matrix[offsets[r] : offsets[r + 1], offsets[a] : offsets[a + 1]]
            _add_block(block, kept, own[r], G[place[r]], j)
            if normal[r] >= 0:
                _add_block(block, kept, coupling[r], G[place[normal[r]]], j)
            if partner[r] >= 0:
                _add_block(block, kept, cross[r], G[place[partner[r]]], j)
        for k in range(offsets[r], offsets[r + 1]):
            matrix[k, k] += 1.0


@kernel
def pushed(
    offsets: Index,
    kept: Index,
    normal: Index,
    partner: Index,
    own: Array,
    coupling: Array,
    cross: Array,
    dw: Array,
    result: Array,
) -> None:
    """result (N,) = E dw on the unknown rows, for a change of motion dw (rows, 2H+1)."""
    for r in range(normal.size):
        for k in range(offsets[r + 1] - offsets[r]):
            i, total = kept[k], 0.0
            for j in range(dw.shape[1]):
                total += own[r, i, j] * dw[r, j]
            if normal[r] >= 0:
                for j in range(dw.shape[1]):
                    total += coupling[r, i, j] * dw[normal[r], j]
            if partner[r] >= 0:
                for j in range(dw.shape[1]):
                    total += cross[r, i, j] * dw[partner[r], j]
            result[offsets[r] + k] = total


@kernel
def pushed_back(
    offsets: Index,
    kept: Index,
    normal: Index,
    partner: Index,
    blocks: tuple[Array, Array, Array],
    values: Array,
    result: Array,
) -> None:
    """Add Eᵀ x of the unknowns x, which stand first in values, to result (motion rows, 2H+1), zeros before; blocks: own, coupling
    and cross of E."""
    own, coupling, cross = blocks
    for r in range(normal.size):
        for k in range(offsets[r + 1] - offsets[r]):
            i, value = kept[k], values[offsets[r] + k]
            for j in range(result.shape[1]):
                result[r, j] += own[r, i, j] * value
                if normal[r] >= 0:
                    result[normal[r], j] += coupling[r, i, j] * value
                if partner[r] >= 0:
                    result[partner[r], j] += cross[r, i, j] * value


@inner
def spread(mask: NDArray[np.bool_], solution: Array, forces: Array) -> None:
    """Put the unknowns of a solution into the entries of `forces` (rows, 2H+1) that the mask says are unknown."""
    k = 0
    for r in range(forces.shape[0]):
        for i in range(forces.shape[1]):
            if mask[r, i]:
                forces[r, i] = solution[k]
                k += 1


@inner
def pull(kept: Index, offsets: Index, active: Index, pulls: Array, row: Array) -> None:
    """Put the derivatives of a condition by the unknowns of the active rows into a row of the matrix."""
    for i in range(active.size):
        first, last = offsets[active[i]], offsets[active[i] + 1]
        for k in range(last - first):
            row[first + k] = pulls[i, kept[k]]


@inner
def pushed_by(system: System, state: State, offsets: Index, dw: Array) -> Array:
    """E dw (N,) on the unknowns, for a change of motion dw (rows, 2H+1)."""
    result = empty_line(offsets[-1])
    normal, partner = system.table.loading_row, system.table.partner_row
    pushed(offsets, system.kept, normal, partner, state.own, state.coupling, state.cross, dw, result)
    return result


@inner
def push(system: System, state: State, offsets: Index, dw: Array, column: Array) -> None:
    """column (N,) = −E dw on the unknowns."""
    values = pushed_by(system, state, offsets, dw)
    for k in range(values.size):
        column[k] = -values[k]


@inlined
def subtract(kept: Index, offsets: Index, values: Array, column: Array) -> None:
    """column (N,) −= the unknown entries of values (rows, 2H+1)."""
    for r in range(values.shape[0]):
        for k in range(offsets[r + 1] - offsets[r]):
            column[offsets[r] + k] -= values[r, kept[k]]


for _name in ("dgetrf", "dgetrs"):
    # A symbol by name, not an address: kernels that call it can be cached.
    binding.add_symbol(f"stickslip_{_name}", get_cython_function_address("scipy.linalg.cython_lapack", _name))
binding.add_symbol("stickslip_dgemm", get_cython_function_address("scipy.linalg.cython_blas", "dgemm"))

_pointer: Any = types.CPointer
_integers, _doubles, _letters = _pointer(types.int32), _pointer(types.float64), _pointer(types.uint8)
_dgetrf: Any = types.ExternalFunction("stickslip_dgetrf", types.void(*[_integers] * 2, _doubles, *[_integers] * 3))
_dgetrs: Any = types.ExternalFunction(
    "stickslip_dgetrs", types.void(_letters, *[_integers] * 2, _doubles, *[_integers] * 2, _doubles, *[_integers] * 2)
)
_dgemm: Any = types.ExternalFunction(
    "stickslip_dgemm",
    types.void(
        *[_letters] * 2, *[_integers] * 3, _doubles, _doubles, _integers, _doubles, _integers, _doubles, _doubles, _integers
    ),
)

_TRANSPOSED, _AS_IT_IS = ord("T"), ord("N")


@inner
def lu_factor(matrix: Array) -> NDArray[np.int32]:
    """Overwrite a matrix (N, N) with its factors; the pivots (N,)."""
    size, info = np.array([matrix.shape[0]], dtype=np.int32), np.zeros(1, dtype=np.int32)
    pivots = np.empty(matrix.shape[0], dtype=np.int32)
    _dgetrf(size.ctypes, size.ctypes, matrix.ctypes, size.ctypes, pivots.ctypes, info.ctypes)
    return pivots


@inner
def lu_solve(lu: Array, pivots: NDArray[np.int32], right: Array) -> None:
    """Overwrite right-hand sides (k, N) with the solutions of A x = b."""
    _solve(lu, pivots, right, _TRANSPOSED)


@inner
def lu_solve_transposed(lu: Array, pivots: NDArray[np.int32], right: Array) -> None:
    """Overwrite right-hand sides (k, N) with the solutions of Aᵀ x = b."""
    _solve(lu, pivots, right, _AS_IT_IS)


@inner
def _solve(lu: Array, pivots: NDArray[np.int32], right: Array, flag: int) -> None:
    form = np.array([flag], dtype=np.uint8)
    size, count = np.array([lu.shape[0]], dtype=np.int32), np.array([right.shape[0]], dtype=np.int32)
    info = np.zeros(1, dtype=np.int32)
    _dgetrs(form.ctypes, size.ctypes, count.ctypes, lu.ctypes, size.ctypes, pivots.ctypes, right.ctypes, size.ctypes, info.ctypes)


@inner
def add_product(left: Array, right: Array, result: Array) -> None:
    """result[:m, :n] += leftᵀ right for left (k, m) and right (k, n); result has m rows or more, and n columns or more."""
    flags = np.array([_AS_IT_IS, _TRANSPOSED], dtype=np.uint8)
    sizes = np.array([right.shape[1], left.shape[1], left.shape[0], result.shape[1]], dtype=np.int32)
    one = np.ones(1)
    _dgemm(
        flags.ctypes,
        flags[1:].ctypes,
        sizes.ctypes,
        sizes[1:].ctypes,
        sizes[2:].ctypes,
        one.ctypes,
        right.ctypes,
        sizes.ctypes,
        left.ctypes,
        sizes[1:].ctypes,
        one.ctypes,
        result.ctypes,
        sizes[3:].ctypes,
    )


@inner
def orientation(lu: Array, pivots: NDArray[np.int32]) -> float:
    """Sign of the determinant of a factorised matrix; 0 when it is singular."""
    sign = 1.0
    for i in range(pivots.size):
        sign *= np.sign(lu[i, i])
        if pivots[i] != i + 1:
            sign = -sign
    return sign


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
def received_by_pushed(
    received: Array,
    shape: Array,
    kept: Index,
    starts: Index,
    firsts: Index,
    offsets: Index,
    table: ContactTable,
    blocks: tuple[Array, Array, Array],
    matrix: Array,
) -> int:
    """Add Ψᵀ E Φ to matrix[:M, :M], zeros before; the multiplications of contact rows. received Ψ, shape Φ (rows, m);
    firsts (kept,): the first coordinate of each column; blocks: own, coupling and cross of E."""
    own, coupling, cross = blocks
    normal, partner = table.loading_row, table.partner_row
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
    return multiplications


@inner
def modal_matrix(
    modes: Modes,
    gains: Complex,
    omega: float,
    kept: Index,
    offsets: Index,
    table: ContactTable,
    blocks: tuple[Array, Array, Array],
    matrix: Array,
) -> int:
    """Add I + g Ψᵀ E Φ to matrix[:M, :M], zeros before; the number of multiplications of contact rows."""
    starts, own_basis = places(modes, kept), modes.basis.shape[1] > 0
    received, shape = (modes.basis, modes.basis) if own_basis else (modes.receiver, modes.shape)
    firsts = zero_numbers(kept.size)
    for k in range(kept.size):
        firsts[k] = coordinates(modes, (kept[k] + 1) // 2)[0]
    size = starts[-1]
    multiplications = received_by_pushed(received, shape, kept, starts, firsts, offsets, table, blocks, matrix)
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
    states = 0
    for i in system.kept:
        first, last = coordinates(system.modes, (i + 1) // 2)
        states += last - first
    return fewer(system.form, states, offsets[-1], system.kept.size)


@inlined
def fewer(form: int, coordinates: int, unknowns: int, kept: int) -> bool:
    """Whether a form of Newton's matrix is that on coordinates, of those of all `kept` columns; as `takes_states` has it."""
    states, forces = float(coordinates), float(unknowns)
    if form != SMALLER:
        return form == ON_STATES and unknowns > 0
    if unknowns < FEWEST_UNKNOWNS:
        return False
    return states * states * (states / 3.0 + forces / kept) < forces**3 / 3.0


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
    blocks = (state.own, state.coupling, state.cross)
    system.effort[2] += modal_matrix(modes, state.gains, omega, kept, offsets, system.table, blocks, matrix)
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
