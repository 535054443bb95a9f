"""Compiled parts of a Newton iteration: evaluation, factorisation of the bordered matrix, search directions."""

from typing import Any, NamedTuple

import numpy as np
from numba import boolean, float64, typeof, types
from numpy.typing import NDArray

from stickslip.solve.balance.contact_forces import contact_forces
from stickslip.solve.balance.newton_matrix import (
    factorised_on_states,
    lu_factor,
    lu_solve,
    moved_rows,
    newton_matrix,
    orientation,
    places,
    pull,
    push,
    pushed_by,
    solve_on_states,
    spread,
    subtract,
    takes_states,
    unknown_entries,
)
from stickslip.solve.balance.receptance import (
    add,
    change,
    driven_states,
    frequency_gains,
    motion,
    motion_slope,
    pulled,
    receptance,
    scale,
)
from stickslip.solve.balance.system import (
    BORDER,
    BORDERED,
    DIRECTION,
    STATE,
    Border,
    Bordered,
    Control,
    Direction,
    State,
    System,
    empty_system,
)
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inlined, inner, separate
from stickslip.support.kernels.arrays import empty_blocks, empty_table, zero_numbers, zero_table
from stickslip.support.kernels.views import view_of


def evaluate_signature(system: "NamedTuple | None" = None) -> Any:
    """Types of `evaluate` for a kind of system."""
    return typeof(STATE)(view_of(system or empty_system()), float64[:, ::1], float64, float64)


def factorise_signature(system: "NamedTuple | None" = None) -> Any:
    """Types of `factorise` for a kind of system."""
    return typeof(BORDERED)(view_of(system or empty_system()), typeof(STATE), float64, float64, typeof(BORDER))


def newton_step_signature(system: "NamedTuple | None" = None) -> Any:
    """Types of `newton_step` for a kind of system."""
    point = typeof(STATE), float64, float64, typeof(BORDER), float64, typeof(BORDERED)
    return types.Tuple((float64[:, ::1], float64, float64))(view_of(system or empty_system()), *point)


def tangent_signature(system: "NamedTuple | None" = None) -> Any:
    """Types of `tangent` for a kind of system."""
    return typeof(DIRECTION)(view_of(system or empty_system()), typeof(STATE), float64, float64, boolean, typeof(BORDERED))


@inner
def _size(values: Array) -> float:
    total = 0.0
    for r in range(values.shape[0]):
        for i in range(values.shape[1]):
            total += values[r, i] * values[r, i]
    return float(np.sqrt(total))


@inlined
def _load_size(system: System, omega: float) -> float:
    """Size of the harmonic load at force level one, from that of each power of ω in it."""
    size, power = 0.0, 1.0
    for part in system.load_size:
        size += power * part
        power *= omega
    return size


@inner
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            total += a[i, j] * b[i, j]
    return total


@separate(evaluate_signature)
def evaluate(system: System, forces: Array, omega: float, level: float) -> State:
    """Motion, residual and derivatives at a point."""
    system.effort[0] += 1
    rows, columns = forces.shape
    coupled = 0
    for partner in system.table.partner_row:
        if partner >= 0:
            coupled = rows
    gains = frequency_gains(system.modes, omega, (columns - 1) // 2)
    w = motion(system.modes, gains, forces, omega, level)
    target, unknown = empty_table(rows, columns), zero_numbers(rows)
    own, coupling = empty_blocks(rows, columns, columns), empty_blocks(rows, columns, columns)
    cross, by_omega = empty_blocks(coupled, columns, columns), zero_table(rows, columns)
    contact_forces(system.table, system.tables, w, omega, target, unknown, own, coupling, cross, by_omega)
    for i in system.dropped:
        for r in range(rows):
            target[r, i] = 0.0
    residual = empty_table(rows, columns)
    for r in range(rows):
        for i in range(columns):
            residual[r, i] = forces[r, i] - target[r, i]
            target[r, i] += system.stiffness[r] * w[r, i]
    scale = max(_size(target), abs(level) * _load_size(system, omega), system.least_scale)
    return State(forces, gains, w, residual, unknown, own, coupling, cross, by_omega, _size(residual) / scale)


@inner
def gap(border: Border, state: State, omega: float, level: float) -> float:
    """How far the path condition is from being met."""
    reached = border.slope * (level if border.by_level else omega) - border.target
    return reached + _dot(border.weight, state.w) if border.weight.shape[0] else reached


@inner
def missed_amplitude(control: Control, w: Array, omega: float) -> float:
    """ω^k |X_1|/A − 1 of the controlled row; 0 where nothing is held."""
    if control.row < 0:
        return 0.0
    size = omega**control.order * np.hypot(w[control.row, 1], w[control.row, 2])
    return float(size / control.amplitude - 1.0)


@inlined
def _control_slope(control: Control, w: Array, omega: float) -> tuple[Array, float]:
    """Derivatives of `missed_amplitude` by the motion (rows and outputs, 2H+1), and by ω at fixed motion."""
    weight = zero_table(w.shape[0], w.shape[1])
    size = max(np.hypot(w[control.row, 1], w[control.row, 2]), 1e-300)
    factor = omega**control.order / (size * control.amplitude)
    for i in range(1, 3):
        weight[control.row, i] = factor * w[control.row, i]
    return weight, control.order * omega ** (control.order - 1.0) * size / control.amplitude


@separate(factorise_signature)
def factorise(system: System, state: State, omega: float, level: float, border: Border) -> Bordered:
    """J on the unknowns, bordered by the derivative by the parameter and the path condition; where an amplitude is held, also by
    the derivative by the force level and the linearised condition on that amplitude."""
    system.effort[1] += 1
    columns = state.forces.shape[1]
    offsets, mask = unknown_entries(state.unknown, system.kept, columns)
    on_states = takes_states(system, offsets)
    size = places(system.modes, system.kept)[-1] if on_states else offsets[-1]
    held = system.control.row >= 0
    matrix = zero_table(size + 1 + held, size + 1 + held)
    matrix[size, size] = border.slope
    by = motion_slope(system.modes, state.gains, state.forces, omega, level, border.by_level)
    if border.weight.shape[0]:
        matrix[size, size] += _dot(border.weight, by)
    weight, raised = border.weight, by
    if held:
        weight, by_omega = _control_slope(system.control, state.w, omega)
        raised = motion_slope(system.modes, state.gains, state.forces, omega, level, held)
        matrix[size + 1, size] = _dot(weight, by) + by_omega
        matrix[size + 1, size + 1] = _dot(weight, raised)
        if border.weight.shape[0]:
            matrix[size, size + 1] = _dot(border.weight, raised)
    if on_states:
        return factorised_on_states(system, state, omega, border, offsets, mask, by, weight, raised, matrix)
    if size:
        normal, partner = system.table.loading_row, system.table.partner_row
        active, moved, place = moved_rows(normal, partner, state.unknown)
        driven = driven_states(system.modes, state.gains, omega, active)
        G = receptance(system.modes, driven, moved)
        system.effort[2] += G.size * system.modes.kind.size
        own, coupling, cross = state.own, state.coupling, state.cross
        newton_matrix(offsets, system.kept, normal, partner, active, place, own, coupling, cross, G, matrix)
        push(system, state, offsets, by, matrix[:size, size])
        if not border.by_level:
            subtract(system.kept, offsets, state.by_omega, matrix[:size, size])
        if border.weight.shape[0]:
            pull(system.kept, offsets, active, pulled(system.modes, driven, border.weight), matrix[size])
        if held:
            push(system, state, offsets, raised, matrix[:size, size + 1])
            pull(system.kept, offsets, active, pulled(system.modes, driven, weight), matrix[size + 1])
    system.effort[2] += matrix.shape[0] ** 3 // 3
    return factorised(state, matrix, offsets, mask)


@inlined
def factorised(state: State, matrix: Array, offsets: Index, mask: NDArray[np.bool_]) -> Bordered:
    """The factors of a matrix on the unknowns of λ themselves."""
    pivots = lu_factor(matrix)
    return Bordered(matrix, pivots, offsets, mask, orientation(matrix, pivots), empty_table(0, 0), state.own, 0.0)


@inlined
def no_factors(state: State) -> Bordered:
    """What stands for factors where nothing was factorised."""
    none, mask = empty_table(0, 0), np.empty((0, 0), dtype=np.bool_)
    return Bordered(none, np.empty(0, dtype=np.int32), zero_numbers(0), mask, 0.0, none, state.own, 0.0)


@inner
def solve(system: System, bordered: Bordered, right: Array) -> None:
    """Overwrite right-hand sides (k, N + 1), or (k, N + 2) where an amplitude is held, with the solutions."""
    if bordered.columns.shape[0]:
        solve_on_states(system, bordered, right)
    else:
        lu_solve(bordered.lu, bordered.pivots, right)


@separate(newton_step_signature)
def newton_step(
    system: System, state: State, omega: float, level: float, border: Border, short: float, bordered: Bordered
) -> tuple[Array, float, float]:
    """Newton's change of λ (rows, 2H+1), of the parameter, and of the force level where it holds an amplitude; short: by how much
    the path condition is missed."""
    rows, columns = state.forces.shape
    step = zero_table(rows, columns)
    size = bordered.offsets[-1]
    held = system.control.row >= 0
    right = zero_table(1, size + 1 + held)
    known, k = False, 0
    for r in range(rows):
        for i in range(columns):
            if bordered.mask[r, i]:
                right[0, k] = -state.residual[r, i]
                k += 1
            else:
                step[r, i] = -state.residual[r, i]
                known = known or state.residual[r, i] != 0.0
    right[0, size] = -short
    if held:
        right[0, size + 1] = -missed_amplitude(system.control, state.w, omega)
    if known:
        moved = change(system.modes, state.gains, step, omega)
        driven = pushed_by(system, state, bordered.offsets, moved)
        for k in range(size):
            right[0, k] += driven[k]
        if border.weight.shape[0]:
            right[0, size] -= _dot(border.weight, moved)
        if held:
            right[0, size + 1] -= _dot(_control_slope(system.control, state.w, omega)[0], moved)
    solve(system, bordered, right)
    spread(bordered.mask, right[0], step)
    # A prescribed parameter stays what it is to the last bit: pivoting would leave rounding in it.
    amount = right[0, size] if border.weight.shape[0] else -short / border.slope
    return step, amount, right[0, size + 1] if held else 0.0


@separate(tangent_signature)
def tangent(system: System, state: State, omega: float, level: float, by_level: bool, bordered: Bordered) -> Direction:
    """The direction of the curve at a point, with the factors there."""
    size = bordered.offsets[-1]
    held = system.control.row >= 0
    right = zero_table(1, size + 1 + held)
    right[0, size] = 1.0
    solve(system, bordered, right)
    forces = zero_table(state.forces.shape[0], state.forces.shape[1])
    spread(bordered.mask, right[0], forces)
    rate, raised = right[0, size], right[0, size + 1] if held else 0.0
    dw = motion_slope(system.modes, state.gains, state.forces, omega, level, by_level)
    scale(dw, rate)
    if held:
        add(dw, raised, motion_slope(system.modes, state.gains, state.forces, omega, level, held))
    if size:
        add(dw, 1.0, change(system.modes, state.gains, forces, omega))
    return Direction(forces, dw, rate, raised)
