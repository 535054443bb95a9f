"""Solutions with the transpose of a bordered Newton matrix, for its singular values; compiled when first called."""

from __future__ import annotations

import numpy as np

from stickslip.solve.balance.lapack import lu_solve_transposed
from stickslip.solve.balance.modal_matrix import from_line, in_line, places, weights_on
from stickslip.solve.balance.on_states import three_blocks
from stickslip.solve.balance.receptance import driven_states, frequency_gains, pulled_by_states
from stickslip.solve.balance.system import Bordered, System
from stickslip.support.checks import Array
from stickslip.support.kernels import inner, kernel
from stickslip.support.kernels.arrays import empty_table, zero_table
from stickslip.support.kernels.views import view


@kernel
def solve_transposed(given: System, bordered: Bordered, right: Array) -> None:
    """Overwrite right-hand sides (k, rows) with the solutions of Jᵀ x = r, J with its borders.

    On coordinates of the structure, J = I + A B with A = E Φ and B = g Ψᵀ: x = r + Bᵀz, (I + B A)ᵀ z = −Aᵀ r.
    """
    system = view(given)
    if not bordered.columns.shape[0]:
        lu_solve_transposed(bordered.lu, bordered.pivots, right)
        return
    modes, kept, offsets = system.modes, system.kept, bordered.offsets
    starts, size, columns = places(modes, kept), offsets[-1], bordered.mask.shape[1]
    states, borders = starts[-1], bordered.columns.shape[0]
    active = np.flatnonzero(offsets[1:] > offsets[:-1])
    gains = frequency_gains(modes, bordered.omega, (columns - 1) // 2)
    driven = driven_states(modes, gains, bordered.omega, active)
    line = empty_table(1, states + borders)
    for each in right:
        in_line(modes, kept, starts, weights_on(modes, _pushed_back(system, bordered, each)), -1.0, line[0])
        for n in range(borders):
            line[0, states + n] = each[size + n]
            for k in range(size):
                line[0, states + n] -= bordered.columns[n, k] * each[k]
        lu_solve_transposed(bordered.lu, bordered.pivots, line)
        found = from_line(modes, kept, starts, line[0], columns)
        pull = pulled_by_states(modes, driven, np.dot(modes.output.T, found) if modes.basis.shape[1] else found)
        for a in range(active.size):
            for k in range(offsets[active[a] + 1] - offsets[active[a]]):
                each[offsets[active[a]] + k] -= pull[a, kept[k]]
        for n in range(borders):
            each[size + n] = line[0, states + n]


@inner
def _pushed_back(system: System, bordered: Bordered, values: Array) -> Array:
    """Eᵀ x (motion rows, 2H+1) of the unknowns x that stand first in values."""
    kept, offsets = system.kept, bordered.offsets
    normal, partner = system.table.loading_row, system.table.partner_row
    own, coupling, cross = three_blocks(bordered)
    found = zero_table(system.modes.shape.shape[0], bordered.mask.shape[1])
    for r in range(normal.size):
        for k in range(offsets[r + 1] - offsets[r]):
            i, value = kept[k], values[offsets[r] + k]
            for j in range(found.shape[1]):
                found[r, j] += own[r, i, j] * value
                if normal[r] >= 0:
                    found[normal[r], j] += coupling[r, i, j] * value
                if partner[r] >= 0:
                    found[partner[r], j] += cross[r, i, j] * value
    return found
