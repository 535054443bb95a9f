"""Newton matrix on coordinates of the structure: the smaller form where contacts have more unknowns than the structure.

J = I + E G' with G' = Φ g Ψᵀ. With z = g Ψᵀ x, the coordinates that a change x of λ drives, J x = r is x = r − E Φ z,
(I + g Ψᵀ E Φ) z = g Ψᵀ r (M. A. Woodbury, 1950). det(I + A B) = det(I + B A): the small matrix has the determinant of J, and
bordered that of J bordered. E is block-diagonal by contact, so the work grows with the number of contacts, not with its cube.

The coordinates are the states, g = Γ; where these are more than the degrees of freedom, as of complex modes, the latter.
"""

from __future__ import annotations

import numpy as np

from stickslip.solve.balance.lapack import add_product
from stickslip.solve.balance.receptance import Complex, Modes, modal_states, respond_in_basis, respond_to_each, seen
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inner
from stickslip.support.kernels.arrays import empty_table, zero_numbers, zero_table

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
def _add_row(shape: Array, kept: Index, starts: Index, firsts: Index, factors: Array, row: int, line: Array) -> None:
    """line (M,) += a row of E, factors (2H+1,), times the motion of a contact row for each coordinate; shape (rows, m): motion by
    coordinate, firsts (kept,): that of the first coordinate of each kept column."""
    for k in range(kept.size):
        factor, start, first = factors[kept[k]], starts[k], firsts[k]
        if factor != 0.0:
            for j in range(starts[k + 1] - start):
                line[start + j] += factor * shape[row, first + j]


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
    for begin in range(0, rows, ROWS):
        for k in range(kept.size):
            i, width = kept[k], starts[k + 1] - starts[k]
            first = firsts[k]
            taken, turned = empty_table(ROWS, width), zero_table(ROWS, size)
            count = 0
            for r in range(begin, min(begin + ROWS, rows)):
                if k >= offsets[r + 1] - offsets[r]:
                    continue
                for j in range(width):
                    taken[count, j] = received[r, first + j]
                _add_row(shape, kept, starts, firsts, own[r, i], r, turned[count])
                if normal[r] >= 0:
                    _add_row(shape, kept, starts, firsts, coupling[r, i], normal[r], turned[count])
                if partner[r] >= 0:
                    _add_row(shape, kept, starts, firsts, cross[r, i], partner[r], turned[count])
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
