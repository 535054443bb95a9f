"""Newton matrix on the states of the structure: the smaller form where contacts have more unknowns than the structure has states.

J = I + E G' with G' = shape Γ receiverᵀ. With z = Γ receiverᵀ x, the states that a change x of λ drives, J x = r is
x = r − E shape z, (I + Γ receiverᵀ E shape) z = Γ receiverᵀ r (M. A. Woodbury, 1950). det(I + A B) = det(I + B A): the small
matrix has the determinant of J, and bordered that of J bordered. E is block-diagonal by contact, so the work grows with the
number of contacts, not with its square or cube.
"""

from __future__ import annotations

import numpy as np

from stickslip.checks import Array, Index
from stickslip.harmonic.lapack import add_product
from stickslip.harmonic.receptance import Complex, Modes, modal_states, respond_to_each
from stickslip.kernels import inner
from stickslip.kernels.arrays import empty_table, zero_numbers, zero_table

ROWS = 256
"""Contact rows that are taken together: as many as keep BLAS busy in little memory."""


@inner
def state_places(modes: Modes, kept: Index) -> Index:
    """Where the states of each kept column start in the small matrix, (kept + 1,)."""
    starts = zero_numbers(kept.size + 1)
    for k in range(kept.size):
        h = (kept[k] + 1) // 2
        starts[k + 1] = starts[k] + modes.last[h] - modes.first[h]
    return starts


@inner
def in_line(modes: Modes, kept: Index, starts: Index, states: Array, factor: float, line: Array) -> None:
    """line (M,) = factor times the states (m, 2H+1), in the order of the small matrix."""
    for k in range(kept.size):
        first = modes.first[(kept[k] + 1) // 2]
        for j in range(starts[k + 1] - starts[k]):
            line[starts[k] + j] = factor * states[first + j, kept[k]]


@inner
def from_line(modes: Modes, kept: Index, starts: Index, line: Array, columns: int) -> Array:
    """States (m, 2H+1) of a solution (M,) of the small system."""
    states = zero_table(modes.kind.size, columns)
    for k in range(kept.size):
        first = modes.first[(kept[k] + 1) // 2]
        for j in range(starts[k + 1] - starts[k]):
            states[first + j, kept[k]] = line[starts[k] + j]
    return states


@inner
def states_of(modes: Modes, gains: Complex, omega: float, forces: Array) -> Array:
    """States Γ receiverᵀ x (m, 2H+1) that forces x (rows, 2H+1) drive."""
    return modal_states(modes, omega, gains, np.dot(modes.receiver.T, forces), False)


@inner
def _add_row(modes: Modes, kept: Index, starts: Index, factors: Array, row: int, line: Array) -> None:
    """line (M,) += a row of E, factors (2H+1,), times the motion of a contact row for each state."""
    for k in range(kept.size):
        factor, first = factors[kept[k]], modes.first[(kept[k] + 1) // 2]
        if factor != 0.0:
            for j in range(starts[k + 1] - starts[k]):
                line[starts[k] + j] += factor * modes.shape[row, first + j]


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
    """Add I + Γ receiverᵀ E shape to matrix[:M, :M], zeros before; the number of multiplications of contact rows."""
    starts = state_places(modes, kept)
    size, rows, multiplications = starts[-1], normal.size, 0
    for begin in range(0, rows, ROWS):
        for k in range(kept.size):
            i, width = kept[k], starts[k + 1] - starts[k]
            first = modes.first[(i + 1) // 2]
            taken, turned = empty_table(ROWS, width), zero_table(ROWS, size)
            count = 0
            for r in range(begin, min(begin + ROWS, rows)):
                if k >= offsets[r + 1] - offsets[r]:
                    continue
                for j in range(width):
                    taken[count, j] = modes.receiver[r, first + j]
                _add_row(modes, kept, starts, own[r, i], r, turned[count])
                if normal[r] >= 0:
                    _add_row(modes, kept, starts, coupling[r, i], normal[r], turned[count])
                if partner[r] >= 0:
                    _add_row(modes, kept, starts, cross[r, i], partner[r], turned[count])
                count += 1
            if count and width:
                multiplications += count * width * size
                add_product(taken[:count], turned[:count], matrix[starts[k] :])
    k = 0
    while k < kept.size:
        h = (kept[k] + 1) // 2
        sine = k + 1 if h > 0 else k
        parts = matrix[starts[k] : starts[k + 1], :size], matrix[starts[sine] : starts[sine + 1], :size]
        respond_to_each(modes, h, 1j * modes.order[h] * omega, gains[h], parts[0], parts[1])
        k = sine + 1
    for k in range(size):
        matrix[k, k] += 1.0
    return multiplications
