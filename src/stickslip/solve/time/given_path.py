"""Contact forces along a motion that is given, instant by instant, as a time march would find them."""

from __future__ import annotations

import numpy as np

from stickslip.model.contact.table import ContactTable
from stickslip.solve.time.contact_law import Earlier, contact_law, no_slopes
from stickslip.support.checks import Array
from stickslip.support.kernels import kernel


@kernel
def contact_work(
    table: ContactTable, stiffness: Array, intercept: Array, path: Array, velocity: Array, step: float, first: int
) -> float:
    """Work that the contacts take from the instant `first` of a path to its end, J, by the trapezoidal rule.

    path, velocity (instants, rows) [m, m/s]; step: between instants, s; stiffness K_c (rows,); intercept (elements,): of the
    friction elements at the first instant, T − kt u, as in `ContactCycle`.
    """
    rows = path.shape[1]
    before, after, limit = intercept.copy(), intercept.copy(), np.zeros(intercept.size)
    slopes, forces, work = no_slopes(rows), np.zeros(rows), 0.0
    for n in range(path.shape[0]):
        last = max(n - 1, 0)
        earlier = Earlier(before.copy(), path[last], limit.copy(), velocity[n], 0.0, n > 0, step if n > 0 else 0.0)
        contact_law(table, path[n], earlier, after, limit, slopes)
        before[:] = after
        for r in range(rows):
            force = slopes.target[r] + stiffness[r] * path[n, r]
            if n > first:
                work += 0.5 * (force + forces[r]) * (path[n, r] - path[last, r])
            forces[r] = force
    return work
