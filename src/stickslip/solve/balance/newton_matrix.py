"""Dense Newton matrix on the unknown rows, bordered by one row and column for the path parameter.

J = I + E G' with E = dλ̂/dw; a held row of J is a row of the identity, so it drops out exactly. Columns: unknown harmonics of λ,
then the parameter (ω or force level); last row: the path condition.

LU factorisation and added products by SciPy's LAPACK and BLAS, called from compiled code.

Matrices lie by rows, LAPACK reads them by columns: it factorises the transpose, and solves with the transpose of that.
"""

from typing import Any

import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]
from numba import types
from numba.extending import get_cython_function_address
from numpy.typing import NDArray

from stickslip.model.contact.protocol import HELD, SLIPPING
from stickslip.solve.balance.system import State, System
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inlined, inner, kernel
from stickslip.support.kernels.arrays import empty_line, zero_numbers


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
