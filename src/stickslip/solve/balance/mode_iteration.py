"""Compiled parts of a Newton iteration for nonlinear modes, as `iteration` has them for forced motions.

Unknowns beside λ are ω and ζ. They stand in one more row of `forces`, (contact rows + 1, 2H+1): ω over the stuck natural
frequency in column 1, ζ in column 2; the modal residual stands in the same places of `residual`. The path parameter is ln a, in
place of the force level; the frequency of a point is the stuck natural frequency.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.point import ContactTable, contact_table
from stickslip.solve.balance.contact_forces import contact_forces
from stickslip.solve.balance.extended_structure import (
    ExtendedStructure,
    changes,
    coordinates,
    coupled,
    extended_driven,
    extended_gains,
    extended_pulled,
    extended_receptance,
    modal_residual,
    modal_slopes,
    received,
    seen,
    shape_at,
    slopes,
)
from stickslip.solve.balance.fourier import Fourier, fourier
from stickslip.solve.balance.iteration import (
    evaluate_signature,
    factorise_signature,
    factorised,
    newton_step_signature,
    tangent_signature,
)
from stickslip.solve.balance.newton_matrix import lu_solve, moved_rows, newton_matrix, pushed, spread, unknown_entries
from stickslip.solve.balance.receptance import Complex
from stickslip.solve.balance.system import FREE, Border, Bordered, Control, Direction, State
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inner, separate
from stickslip.support.kernels.views import placed_as

SPRINGS = 1e-3
"""Share of the forces of springs K_c w below which contact forces are not the scale of the residual: λ beyond these springs has
their rounding, also where contacts carry nothing, without friction or without load."""


class ModeSystem(NamedTuple):
    """The balance of a nonlinear mode as the kernels read it; fields as in `system.System`."""

    table: ContactTable
    tables: Fourier
    structure: ExtendedStructure
    stiffness: Array
    kept: Index
    dropped: Index
    least_scale: float
    effort: Index
    control: Control


@cache
def empty_mode_system() -> ModeSystem:
    """A system without anything, whose types are those of all."""
    line, blocks, places = np.empty(0), np.empty((0, 0, 0)), np.empty(0, dtype=np.int64)
    damping, static = np.empty((0, 0, 0), dtype=np.complex128), np.empty(0, dtype=np.complex128)
    structure = ExtendedStructure(blocks, blocks, np.empty((0, 0)), damping, static, places, 0, 0)
    return ModeSystem(contact_table(()), fourier(1, 6), structure, line, places, places, 0.0, places, FREE)


@placed_as(empty_mode_system)
class ModeSystemAddress(NamedTuple):
    """Where a `ModeSystem` lies in memory, for kernels that are called often."""

    address: int


class ModeSlopes(NamedTuple):
    """Derivatives by ω/ω_m, ζ and ln a at fixed λ: of the motion (3, motion rows, 2H+1), of the modal residual (3,)."""

    motion: Array
    modal: Complex


@inner
def _size(values: Array) -> float:
    return float(np.sqrt(np.sum(values * values)))


@inner
def modal_amplitude(level: float) -> float:
    """a of ln a; a step of Newton's method that leaves the range of numbers is one that no residual accepts."""
    return np.exp(min(max(level, -300.0), 300.0))  # type: ignore[no-any-return]


@separate(lambda: evaluate_signature(empty_mode_system()))
def evaluate_mode(system: ModeSystem, forces: Array, omega: float, level: float) -> State:
    """Motion, residual and derivatives at a point."""
    system.effort[0] += 1
    rows, columns = forces.shape[0] - 1, forces.shape[1]
    frequency, zeta, amplitude = omega * forces[rows, 1], forces[rows, 2], modal_amplitude(level)
    coupling = rows if np.any(system.table.partner_row >= 0) else 0
    gains = extended_gains(system.structure, frequency, zeta)
    state = coordinates(system.structure, gains, forces[:rows], frequency, amplitude)
    w = seen(system.structure, state)
    target, unknown = np.empty((rows, columns)), np.zeros(rows, dtype=np.int64)
    own, by_normal = np.empty((rows, columns, columns)), np.empty((rows, columns, columns))
    cross, by_omega = np.empty((coupling, columns, columns)), np.zeros((rows, columns))
    contact_forces(system.table, system.tables, w, frequency, target, unknown, own, by_normal, cross, by_omega)
    for i in system.dropped:
        target[:, i] = 0.0
    residual = np.zeros((rows + 1, columns))
    residual[:rows] = forces[:rows] - target
    springs = np.empty((rows, columns))
    for r in range(rows):
        for i in range(columns):
            springs[r, i] = system.stiffness[r] * w[r, i]
            target[r, i] += springs[r, i]
    error = _size(residual) / max(_size(target), SPRINGS * _size(springs), system.least_scale)
    force = received(system.structure, forces[:rows])[system.structure.followed, 1]
    modal = modal_residual(system.structure, state, force, frequency, zeta, amplitude)
    residual[rows, 1], residual[rows, 2] = modal.real, modal.imag
    error = np.hypot(error, abs(modal)) if frequency > 0.0 else np.inf
    return State(forces, gains, w, residual, unknown, own, by_normal, cross, by_omega, error)


@inner
def _slopes(system: ModeSystem, state: State, omega: float, level: float) -> ModeSlopes:
    rows, amplitude = state.forces.shape[0] - 1, modal_amplitude(level)
    structure, forces = system.structure, state.forces[:rows]
    frequency, zeta = omega * state.forces[rows, 1], state.forces[rows, 2]
    found = coordinates(structure, state.gains, forces, frequency, amplitude)
    by = slopes(structure, state.gains, found, frequency, zeta, amplitude)
    force = received(structure, forces)[structure.followed, 1]
    modal = modal_slopes(structure, found, by, force, frequency, zeta, amplitude)
    motion = np.empty((3, state.w.shape[0], state.w.shape[1]))
    for part in range(3):
        motion[part] = seen(structure, np.ascontiguousarray(by[part]))
    motion[0] *= omega
    modal[0] *= omega
    return ModeSlopes(motion, modal)


@separate(lambda: factorise_signature(empty_mode_system()))
def factorise_mode(system: ModeSystem, state: State, omega: float, level: float, border: Border) -> Bordered:
    """J on the unknowns of λ, ω and ζ, bordered by the derivative by ln a and the path condition."""
    system.effort[1] += 1
    rows = state.forces.shape[0] - 1
    offsets, mask = _unknowns(state, system.kept)
    contact, size = offsets[rows], offsets[rows + 1]
    matrix = np.zeros((size + 1, size + 1))
    by = _slopes(system, state, omega, level)
    for part in range(3):
        column = contact + part
        matrix[:contact, column] = -_pushed(system, state, offsets, by.motion[part])
        matrix[contact, column], matrix[contact + 1, column] = by.modal[part].real, by.modal[part].imag
        if border.weight.shape[0]:
            matrix[size, column] = np.sum(border.weight * by.motion[part])
    for r in range(rows):
        for k in range(offsets[r + 1] - offsets[r]):
            matrix[offsets[r] + k, contact] -= omega * state.by_omega[r, system.kept[k]]
    matrix[size, size] += border.slope
    if contact:
        _fill_contacts(system, state, omega, level, border, offsets, matrix)
    system.effort[2] += matrix.shape[0] ** 3 // 3
    return factorised(state, matrix, offsets, mask)


@inner
def _unknowns(state: State, kept: Index) -> tuple[Index, NDArray[np.bool_]]:
    """Where the unknowns of each row start, and which entries of `forces` they are; those of the last row are ω and ζ."""
    rows, columns = state.forces.shape[0] - 1, state.forces.shape[1]
    starts, entries = unknown_entries(state.unknown, kept, columns)
    offsets, mask = np.empty(rows + 2, dtype=np.int64), np.zeros((rows + 1, columns), dtype=np.bool_)
    offsets[: rows + 1], mask[:rows] = starts, entries
    offsets[rows + 1] = offsets[rows] + 2
    mask[rows, 1] = mask[rows, 2] = True
    return offsets, mask


@inner
def _fill_contacts(
    system: ModeSystem, state: State, omega: float, level: float, border: Border, offsets: Index, matrix: Array
) -> None:
    """The columns of λ: contact rows, modal residual and path condition."""
    rows = state.forces.shape[0] - 1
    structure, frequency = system.structure, omega * state.forces[rows, 1]
    normal, partner = system.table.loading_row, system.table.partner_row
    active, moved, place = moved_rows(normal, partner, state.unknown)
    driven = extended_driven(structure, state.gains, active)
    G = extended_receptance(structure, driven, moved)
    own, coupling, cross = state.own, state.coupling, state.cross
    newton_matrix(offsets, system.kept, normal, partner, active, place, own, coupling, cross, G, matrix)
    amplitude, first, last = modal_amplitude(level), offsets[rows], offsets[rows + 1]
    k, followed = structure.key[1], structure.followed
    pull = extended_pulled(structure, driven, border.weight) if border.weight.shape[0] else np.empty((0, 0))
    for i in range(active.size):
        r, other = active[i], coupled(structure, frequency, np.ascontiguousarray(driven[:, :, i].T))
        share = (shape_at(structure, k, r, followed).conjugate() - other) / amplitude
        for n in range(offsets[r + 1] - offsets[r]):
            column = offsets[r] + n
            if system.kept[n] == 1:
                matrix[first, column], matrix[first + 1, column] = share.real, share.imag
            elif system.kept[n] == 2:
                matrix[first, column], matrix[first + 1, column] = share.imag, -share.real
            if border.weight.shape[0]:
                matrix[last, column] = pull[i, system.kept[n]]


@inner
def _pushed(system: ModeSystem, state: State, offsets: Index, dw: Array) -> Array:
    result = np.empty(offsets[-1])
    normal, partner = system.table.loading_row, system.table.partner_row
    pushed(offsets, system.kept, normal, partner, state.own, state.coupling, state.cross, dw, result)
    return result[: offsets[-2]]


@separate(lambda: newton_step_signature(empty_mode_system()))
def newton_step_mode(
    system: ModeSystem, state: State, omega: float, level: float, border: Border, short: float, bordered: Bordered
) -> tuple[Array, float, float]:
    """Newton's change of λ, ω and ζ, of ln a, and of no force level; short: by how much the path condition is missed."""
    rows, columns = state.forces.shape[0] - 1, state.forces.shape[1]
    step = np.zeros((rows + 1, columns))
    contact, size = bordered.offsets[rows], bordered.offsets[rows + 1]
    right = np.empty((1, size + 1))
    known, k = False, 0
    for r in range(rows + 1):
        for i in range(columns):
            if bordered.mask[r, i]:
                right[0, k] = -state.residual[r, i]
                k += 1
            elif r < rows:
                step[r, i] = -state.residual[r, i]
                known = known or state.residual[r, i] != 0.0
    right[0, size] = -short
    if known:
        structure, frequency = system.structure, omega * state.forces[rows, 1]
        change = changes(structure, state.gains, step[:rows])
        moved = seen(structure, change)
        right[0, :contact] += _pushed(system, state, bordered.offsets, moved)
        modal = coupled(structure, frequency, change) + received(structure, step[:rows])[structure.followed, 1]
        modal /= modal_amplitude(level)
        right[0, contact] -= modal.real
        right[0, contact + 1] -= modal.imag
        if border.weight.shape[0]:
            right[0, size] -= np.sum(border.weight * moved)
    lu_solve(bordered.lu, bordered.pivots, right)
    spread(bordered.mask, right[0], step)
    amount = right[0, size] if border.weight.shape[0] else -short / border.slope
    return step, amount, 0.0


@separate(lambda: tangent_signature(empty_mode_system()))
def tangent_mode(system: ModeSystem, state: State, omega: float, level: float, by_level: bool, bordered: Bordered) -> Direction:
    """The direction of the curve at a point, with the factors there."""
    rows, size = state.forces.shape[0] - 1, bordered.offsets[-1]
    right = np.zeros((1, size + 1))
    right[0, size] = 1.0
    lu_solve(bordered.lu, bordered.pivots, right)
    forces = np.zeros(state.forces.shape)
    spread(bordered.mask, right[0], forces)
    rate, by = right[0, size], _slopes(system, state, omega, level)
    amounts = np.array([forces[rows, 1], forces[rows, 2], rate])
    dw = seen(system.structure, changes(system.structure, state.gains, forces[:rows]))
    for part in range(3):
        dw += amounts[part] * by.motion[part]
    return Direction(forces, dw, rate, 0.0)
