"""The answer of contacts to a motion, for balances that stand in Python."""

from stickslip.model.contact.point import ContactTable
from stickslip.solve.balance.contact_forces import contact_forces
from stickslip.solve.balance.fourier import Fourier
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import boxed, kernel
from stickslip.support.kernels.arrays import empty_blocks, empty_table, zero_numbers, zero_table
from stickslip.support.kernels.views import view


@kernel
def contact_answer(
    given: ContactTable, tables: Fourier, w: Array, omega: float
) -> tuple[Array, Index, Array, Array, Array, Array]:
    """λ̂ of contacts, their states and derivatives, as `contact_forces` fills them."""
    table, forms, rows, columns = view(given), view(tables), w.shape[0], w.shape[1]
    coupled = 0
    for partner in table.partner_row:
        if partner >= 0:
            coupled = rows
    target, unknown = empty_table(rows, columns), zero_numbers(rows)
    own, coupling = empty_blocks(rows, columns, columns), empty_blocks(rows, columns, columns)
    cross, by_omega = empty_blocks(coupled, columns, columns), zero_table(rows, columns)
    coupling[:], cross[:] = 0.0, 0.0  # of normal rows, and of rows whose law couples nothing, it says nothing
    contact_forces(table, forms, w, omega, target, unknown, own, coupling, cross, by_omega)
    return boxed((target, unknown, own, coupling, cross, by_omega))
