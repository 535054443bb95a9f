"""Compiled parts of a Newton iteration: evaluation, factorisation of the bordered matrix, search directions."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import boolean, float64, int64, typeof, types, void
from numpy.typing import NDArray

from stickslip.checks import Array, Index
from stickslip.contact.table import ContactTable, contact_table
from stickslip.harmonic.contact_forces import contact_forces
from stickslip.harmonic.fourier import Fourier, fourier
from stickslip.harmonic.lapack import lu_factor, lu_solve, orientation
from stickslip.harmonic.modal_matrix import (
    coordinates,
    driven_by,
    from_line,
    in_line,
    modal_matrix,
    motion_of,
    places,
    weights_on,
)
from stickslip.harmonic.newton_matrix import moved_rows, newton_matrix, pushed, spread, unknown_entries
from stickslip.harmonic.receptance import (
    NO_MODES,
    Complex,
    Modes,
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
from stickslip.kernels import compiled, inner, separate
from stickslip.kernels.arrays import empty_blocks, empty_line, empty_table, zero_numbers, zero_table
from stickslip.kernels.views import view_of


class Control(NamedTuple):
    """ω^order |X_1| of a row of motion, held at an amplitude by the force level, an unknown then; row −1: nothing is held."""

    row: int
    order: int
    amplitude: float


FREE = Control(-1, 0, 1.0)
"""No amplitude is held: the force level is given."""

SMALLER, ON_FORCES, ON_STATES = range(3)
"""What Newton's linear system is solved for: the unknowns of λ, the states of the structure, or whichever takes less work."""

FEWEST_UNKNOWNS = 300
"""Unknowns of λ below which Newton's linear system is solved for them whatever the states: there it is a small part of a step."""


class System(NamedTuple):
    """A harmonic balance as the kernels read it.

    stiffness (rows,): springs of the stuck contacts; kept, dropped: the columns of balanced and of left-out harmonics; load_size
    (powers of ω,), least_scale: of residuals; effort (3,): evaluations, factorisations and their multiplications, counted on;
    control: the amplitude that the force level holds, if any; form: SMALLER, ON_FORCES or ON_STATES.
    """

    table: ContactTable
    tables: Fourier
    modes: Modes
    stiffness: Array
    kept: Index
    dropped: Index
    load_size: Array
    least_scale: float
    effort: Index
    control: Control
    form: int


class State(NamedTuple):
    """Everything at a point: forces λ (rows, 2H+1); gains of the modes; motion w (rows and outputs, 2H+1); residual λ − λ̂;
    unknown (rows,) and the derivatives own, coupling, cross, by_omega of λ̂, as `contact_forces` fills them; error: ‖residual‖
    relative to the contact forces or the harmonic load, whichever is larger."""

    forces: Array
    gains: Complex
    w: Array
    residual: Array
    unknown: Index
    own: Array
    coupling: Array
    cross: Array
    by_omega: Array
    error: float


class Bordered(NamedTuple):
    """The factorised bordered matrix: factors and pivots; where the unknowns of each row start; which entries of λ they are;
    sign of the determinant, 0 when singular. Behind the unknowns of λ stand the path parameter, and a level that is unknown.

    Where columns is not empty, the factors are those of the smaller matrix on the states of the structure (`modal_matrix`), with
    what leads from there to the unknowns of λ: columns (1 or 2, N) of the parameter and the unknown level; blocks (3 rows, 2H+1,
    2H+1), the derivatives own, coupling and cross of λ̂, and omega [rad/s] of the point.
    """

    lu: Array
    pivots: NDArray[np.int32]
    offsets: Index
    mask: NDArray[np.bool_]
    sign: float
    columns: Array
    blocks: Array
    omega: float


class Border(NamedTuple):
    """A path condition, weight · w + slope p = target; weight (rows, 2H+1), or (0, 0) for none; p: the level, or ω."""

    weight: Array
    slope: float
    target: float
    by_level: bool


class Direction(NamedTuple):
    """Along the curve, the path condition growing at rate one: dλ (rows, 2H+1), dw (rows and outputs, 2H+1), dp of the path
    parameter; level: that of the force level where it holds an amplitude, else 0."""

    forces: Array
    motion: Array
    rate: float
    level: float


_LINE, _SQUARE, _BLOCKS, _PLACES = np.empty(0), np.empty((0, 0)), np.empty((0, 0, 0)), np.empty(0, dtype=np.int64)
_GAINS, _PIVOTS, _MASK = np.empty((0, 0, 0), dtype=np.complex128), np.empty(0, dtype=np.int32), np.empty((0, 0), dtype=np.bool_)

STATE = State(_SQUARE, _GAINS, _SQUARE, _SQUARE, _PLACES, _BLOCKS, _BLOCKS, _BLOCKS, _SQUARE, 0.0)
BORDER = Border(_SQUARE, 0.0, 0.0, False)
BORDERED = Bordered(_SQUARE, _PIVOTS, _PLACES, _MASK, 0.0, _SQUARE, _BLOCKS, 0.0)
DIRECTION = Direction(_SQUARE, _SQUARE, 0.0, 0.0)
"""Empty ones, whose types are those of all."""


@cache
def _empty_system() -> System:
    """A system without anything, whose types are those of all."""
    numbers = _LINE, 0.0, _PLACES, FREE, SMALLER
    return System(contact_table(()), fourier(1, 6), NO_MODES, _LINE, _PLACES, _PLACES, *numbers)


def evaluate_signature(system: NamedTuple | None = None) -> Any:
    """Types of `evaluate` for a kind of system."""
    return typeof(STATE)(view_of(system or _empty_system()), float64[:, ::1], float64, float64)


def factorise_signature(system: NamedTuple | None = None) -> Any:
    """Types of `factorise` for a kind of system."""
    return typeof(BORDERED)(view_of(system or _empty_system()), typeof(STATE), float64, float64, typeof(BORDER))


def factorised_on_states_signature() -> Any:
    """Types of `factorised_on_states`."""
    given = typeof(STATE), float64, typeof(BORDER), int64[::1], boolean[:, ::1]
    return typeof(BORDERED)(view_of(_empty_system()), *given, *(float64[:, ::1],) * 4)


def solve_on_states_signature() -> Any:
    """Types of `_solve_on_states`."""
    return void(view_of(_empty_system()), typeof(BORDERED), float64[:, ::1])


def newton_step_signature(system: NamedTuple | None = None) -> Any:
    """Types of `newton_step` for a kind of system."""
    point = typeof(STATE), float64, float64, typeof(BORDER), float64, typeof(BORDERED)
    return types.Tuple((float64[:, ::1], float64, float64))(view_of(system or _empty_system()), *point)


def tangent_signature(system: NamedTuple | None = None) -> Any:
    """Types of `tangent` for a kind of system."""
    return typeof(DIRECTION)(view_of(system or _empty_system()), typeof(STATE), float64, float64, boolean, typeof(BORDERED))


@inner
def _size(values: Array) -> float:
    total = 0.0
    for r in range(values.shape[0]):
        for i in range(values.shape[1]):
            total += values[r, i] * values[r, i]
    return float(np.sqrt(total))


@inner
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


@inner
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
    on_states = _on_states(system, offsets)
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
        raised = motion_slope(system.modes, state.gains, state.forces, omega, level, True)
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
        blocks = (state.own, state.coupling, state.cross)
        newton_matrix(offsets, system.kept, normal, partner, active, place, *blocks, G, matrix)
        _push(system, state, offsets, by, matrix[:size, size])
        if not border.by_level:
            _subtract(system.kept, offsets, state.by_omega, matrix[:size, size])
        if border.weight.shape[0]:
            _pull(system.kept, offsets, active, pulled(system.modes, driven, border.weight), matrix[size])
        if held:
            _push(system, state, offsets, raised, matrix[:size, size + 1])
            _pull(system.kept, offsets, active, pulled(system.modes, driven, weight), matrix[size + 1])
    system.effort[2] += matrix.shape[0] ** 3 // 3
    return factorised(state, matrix, offsets, mask)


@inner
def factorised(state: State, matrix: Array, offsets: Index, mask: NDArray[np.bool_]) -> Bordered:
    """The factors of a matrix on the unknowns of λ themselves."""
    pivots = lu_factor(matrix)
    return _on_forces(state, matrix, pivots, offsets, mask, orientation(matrix, pivots))


@inner
def _on_forces(
    state: State, matrix: Array, pivots: NDArray[np.int32], offsets: Index, mask: NDArray[np.bool_], sign: float
) -> Bordered:
    return Bordered(matrix, pivots, offsets, mask, sign, empty_table(0, 0), state.own, 0.0)


@inner
def no_factors(state: State) -> Bordered:
    """What stands for factors where nothing was factorised."""
    mask = np.empty((0, 0), dtype=np.bool_)
    return _on_forces(state, empty_table(0, 0), np.empty(0, dtype=np.int32), zero_numbers(0), mask, 0.0)


@inner
def _on_states(system: System, offsets: Index) -> bool:
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
    _push(system, state, offsets, by, columns[0])
    if not border.by_level:
        _subtract(kept, offsets, state.by_omega, columns[0])
    if held:
        _push(system, state, offsets, raised, columns[1])
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


@inner
def solve(system: System, bordered: Bordered, right: Array) -> None:
    """Overwrite right-hand sides (k, N + 1), or (k, N + 2) where an amplitude is held, with the solutions."""
    if bordered.columns.shape[0]:
        _solve_on_states(system, bordered, right)
    else:
        lu_solve(bordered.lu, bordered.pivots, right)


@separate(solve_on_states_signature)
def _solve_on_states(system: System, bordered: Bordered, right: Array) -> None:
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


@inner
def _pull(kept: Index, offsets: Index, active: Index, pull: Array, row: Array) -> None:
    """Put the derivatives of a condition by the unknowns of the active rows into a row of the matrix."""
    for i in range(active.size):
        first, last = offsets[active[i]], offsets[active[i] + 1]
        for k in range(last - first):
            row[first + k] = pull[i, kept[k]]


@inner
def _pushed(system: System, state: State, offsets: Index, dw: Array) -> Array:
    result = empty_line(offsets[-1])
    normal, partner = system.table.loading_row, system.table.partner_row
    pushed(offsets, system.kept, normal, partner, state.own, state.coupling, state.cross, dw, result)
    return result


@inner
def _push(system: System, state: State, offsets: Index, dw: Array, column: Array) -> None:
    """column (N,) = −E dw on the unknowns."""
    values = _pushed(system, state, offsets, dw)
    for k in range(values.size):
        column[k] = -values[k]


@inner
def _subtract(kept: Index, offsets: Index, values: Array, column: Array) -> None:
    """column (N,) −= the unknown entries of values (rows, 2H+1)."""
    for r in range(values.shape[0]):
        for k in range(offsets[r + 1] - offsets[r]):
            column[offsets[r] + k] -= values[r, kept[k]]


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
        pushed_by = _pushed(system, state, bordered.offsets, moved)
        for k in range(size):
            right[0, k] += pushed_by[k]
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
        add(dw, raised, motion_slope(system.modes, state.gains, state.forces, omega, level, True))
    if size:
        add(dw, 1.0, change(system.modes, state.gains, forces, omega))
    return Direction(forces, dw, rate, raised)


def compile_on_states(system: System) -> None:
    """Compile what solves Newton's linear system on the states, or take it from disk; nothing where these are never the fewer."""
    modes, balanced = system.modes, (system.kept + 1) // 2
    fewest = modes.basis.shape[1] or int(np.min(modes.last[balanced] - modes.first[balanced]))
    many = system.table.rows > fewest and system.table.rows * system.kept.size >= FEWEST_UNKNOWNS
    if system.form == ON_STATES or many:
        compiled(factorised_on_states, _solve_on_states)
