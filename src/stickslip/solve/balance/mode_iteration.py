"""Compiled parts of a Newton iteration for nonlinear modes, as `iteration` has them for forced motions.

Unknowns beside λ are ω and ζ. They stand in one more row of `forces`, (contact rows + 1, 2H+1): ω over the stuck natural
frequency in column 1, ζ in column 2; the modal residual stands in the same places of `residual`. The path parameter is ln a, in
place of the force level; the frequency of a point is the stuck natural frequency.

The linear part is the structure with C − 2ζωM in place of C, and the followed mode's coordinate kept. With η the coordinates of
the stuck modes, φᴴK'φ = 1 and φᴴMφ = q, harmonic h obeys D η = φᴴ(p − Bᴴλ), D = 1 + s (c − 2ζω q) + s² q, s = i h ω. At harmonic
1 the row of the followed mode is left out of D and its coordinate is the given amplitude a: what remains is regular at a stuck
mode, where λ and the followed mode's own D vanish together. The row left out, divided by a, is the modal residual: two real
equations for ω and ζ.

On the coordinates of real modes, Newton's matrix is as in `newton_matrix`, J = I + E Φ g Φᵀ with g = D⁻¹. The followed
coordinate of harmonic 1 moves no contact; in its place stands the force φᵀx that a change x of λ puts on it, which is what the
modal residual needs.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import boolean, float64, int64, typeof, void
from numpy.typing import NDArray

from stickslip.model.contact.point import ContactTable, contact_table
from stickslip.solve.balance.contact_forces import contact_forces
from stickslip.solve.balance.fourier import Fourier, fourier
from stickslip.solve.balance.iteration import (
    evaluate_signature,
    factorise_signature,
    factorised,
    newton_step_signature,
    tangent_signature,
)
from stickslip.solve.balance.newton_matrix import (
    FEWEST_UNKNOWNS,
    fewer,
    lu_factor,
    lu_solve,
    moved_rows,
    newton_matrix,
    orientation,
    pushed,
    received_by_pushed,
    spread,
    unknown_entries,
)
from stickslip.solve.balance.receptance import Complex
from stickslip.solve.balance.system import (
    BORDER,
    BORDERED,
    FREE,
    ON_STATES,
    SMALLER,
    STATE,
    Border,
    Bordered,
    Control,
    Direction,
    State,
)
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import boxed, compiled, inner, kernel, separate
from stickslip.support.kernels.arrays import rows_of
from stickslip.support.kernels.views import placed_as, view_of


class ExtendedStructure(NamedTuple):
    """Stuck modes of each structure that a harmonic sees, k = key[h]; m of them, as many in each.

    real, imaginary (keys, motion rows, m): shapes at contact rows, then outputs; imaginary (0, 0, 0) where all are real;
    squares (keys, m): q = 1/ω²; damping (keys, m, m): φᴴCφ, or (keys, 1, m), its diagonal, where it couples no modes;
    static (m,): φᴴp of the constant loads at harmonic 0; key (H+1,), −1 of a harmonic that is not balanced; followed: the mode;
    extended: the highest harmonic that has the term −2ζωM.
    """

    real: Array
    imaginary: Array
    squares: Array
    damping: Complex
    static: Complex
    key: Index
    followed: int
    extended: int


@inner
def extended_gains(structure: ExtendedStructure, omega: float, zeta: float) -> Complex:
    """D⁻¹ of every harmonic, (H+1, m, m), or its diagonal (H+1, 1, m); at harmonic 1 with the row and column of the followed mode
    replaced by those of the identity."""
    followed, width = structure.followed, structure.damping.shape[1]
    size = structure.squares.shape[1]
    gains = np.zeros((structure.key.size, width, size), dtype=np.complex128)
    own = np.empty(size, dtype=np.complex128)
    for h in range(structure.key.size):
        k = structure.key[h]
        if k < 0:
            continue
        for j in range(size):
            own[j] = own_dynamics(structure, h, j, omega, zeta)
        if h == 1:
            own[followed] = 1.0
        if width == 1:
            for j in range(size):
                gains[h, 0, j] = 1.0 / own[j] if own[j] != 0.0 else complex(np.nan, np.nan)
            continue
        matrix = 1j * h * omega * structure.damping[k]
        for j in range(size):
            matrix[j, j] = own[j]
            if h == 1 and j != followed:
                matrix[j, followed] = matrix[followed, j] = 0.0
        gains[h] = _inverse(matrix)
    return gains


@kernel
def extended_gains_called(structure: ExtendedStructure, omega: float, zeta: float) -> Complex:
    """`extended_gains` for calls from Python."""
    return boxed(extended_gains(structure, omega, zeta))


@inner
def _inverse(matrix: Complex) -> Complex:
    """The inverse; NaN where there is none, to which nothing converges."""
    if np.all(np.isfinite(matrix)):
        try:
            return np.linalg.inv(matrix)  # type: ignore[return-value]
        except Exception:  # numba knows no narrower class; inv raises for an exact zero pivot alone
            pass
    return np.full_like(matrix, complex(np.nan, np.nan))


@inner
def own_dynamics(structure: ExtendedStructure, h: int, j: int, omega: float, zeta: float) -> complex:
    """Diagonal entry 1 + s (c − 2ζω q) + s² q of mode j at s = i h ω."""
    k = structure.key[h]
    s, q = 1j * h * omega, structure.squares[k, j]
    c = structure.damping[k, j if structure.damping.shape[1] > 1 else 0, j]
    shift = 2.0 * zeta * omega if h <= structure.extended else 0.0
    return complex(1.0 + s * (c - shift * q) + s * s * q)


@inner
def _respond(gains: Complex, load: Complex) -> Complex:
    """D⁻¹ of one harmonic times loads (m, columns)."""
    if gains.shape[0] > 1:
        return np.dot(gains, load)  # type: ignore[no-any-return]
    found = np.empty_like(load)
    for j in range(load.shape[0]):
        for c in range(load.shape[1]):
            found[j, c] = gains[0, j] * load[j, c]
    return found


@inner
def _by_harmonic(gains: Complex, load: Complex) -> Complex:
    """D⁻¹ of every harmonic times its load, both (m, H+1)."""
    found = np.empty_like(load)
    for h in range(load.shape[1]):
        found[:, h] = _respond(gains[h], np.ascontiguousarray(load[:, h : h + 1]))[:, 0]
    return found


@inner
def received(structure: ExtendedStructure, forces: Array) -> Complex:
    """φᴴBᴴλ of every harmonic, (m, H+1), for forces λ (contact rows, 2H+1)."""
    found = np.zeros((structure.squares.shape[1], structure.key.size), dtype=np.complex128)
    for h in range(structure.key.size):
        k = structure.key[h]
        if k < 0:
            continue
        for r in range(forces.shape[0]):
            value = complex(forces[r, 2 * h - 1], -forces[r, 2 * h]) if h else complex(forces[r, 0], 0.0)
            if value == 0.0:
                continue
            for j in range(found.shape[0]):
                found[j, h] += shape_at(structure, k, r, j).conjugate() * value
    return found


@inner
def shape_at(structure: ExtendedStructure, k: int, row: int, j: int) -> complex:
    """φ of mode j at a motion row, of structure k."""
    imaginary = structure.imaginary[k, row, j] if structure.imaginary.size else 0.0
    return complex(structure.real[k, row, j], imaginary)


@inner
def seen(structure: ExtendedStructure, state: Complex) -> Array:
    """Motion (motion rows, 2H+1) in real storage of coordinates (m, H+1)."""
    rows = structure.real.shape[1]
    motion = np.zeros((rows, 2 * state.shape[1] - 1))
    for h in range(state.shape[1]):
        k = structure.key[h]
        if k < 0:
            continue
        for r in range(rows):
            total = 0.0j
            for j in range(state.shape[0]):
                total += shape_at(structure, k, r, j) * state[j, h]
            motion[r, max(2 * h - 1, 0)] = total.real
            if h:
                motion[r, 2 * h] = -total.imag
    return motion


@inner
def coordinates(structure: ExtendedStructure, gains: Complex, forces: Array, omega: float, amplitude: float) -> Complex:
    """Coordinates η (m, H+1) under the constant loads and λ, with the followed mode at its amplitude."""
    load = -received(structure, forces)
    if structure.key[0] >= 0:
        load[:, 0] += structure.static
    _follow(structure, omega, amplitude, load)
    return _by_harmonic(gains, load)


@kernel
def coordinates_called(structure: ExtendedStructure, gains: Complex, forces: Array, omega: float, amplitude: float) -> Complex:
    """`coordinates` for calls from Python."""
    return boxed(coordinates(structure, gains, forces, omega, amplitude))


@inner
def _follow(structure: ExtendedStructure, omega: float, amplitude: float, load: Complex) -> None:
    """Prescribe the coordinate of the followed mode at harmonic 1, which drives the other modes through damping."""
    followed, k = structure.followed, structure.key[1]
    if structure.damping.shape[1] > 1:
        for j in range(load.shape[0]):
            load[j, 1] -= 1j * omega * structure.damping[k, j, followed] * amplitude
    load[followed, 1] = amplitude


@inner
def changes(structure: ExtendedStructure, gains: Complex, forces: Array) -> Complex:
    """Change of coordinates (m, H+1) for a change of forces δλ."""
    load = -received(structure, forces)
    load[structure.followed, 1] = 0.0
    return _by_harmonic(gains, load)


@inner
def slopes(structure: ExtendedStructure, gains: Complex, state: Complex, omega: float, zeta: float, amplitude: float) -> Complex:
    """Derivatives of coordinates η (m, H+1) by ω, ζ and ln a at fixed λ, (3, m, H+1)."""
    found = np.zeros((3, state.shape[0], state.shape[1]), dtype=np.complex128)
    for h in range(1, state.shape[1]):
        if structure.key[h] < 0:
            continue
        for j in range(state.shape[0]):
            if h == 1 and j == structure.followed:
                continue
            found[0, j, h] = -_dynamics_slope(structure, h, j, omega, zeta, state)
            if h <= structure.extended:
                found[1, j, h] = 2.0j * h * omega * omega * structure.squares[structure.key[h], j] * state[j, h]
    _follow(structure, omega, amplitude, found[2])
    for part in range(3):
        found[part] = _by_harmonic(gains, np.ascontiguousarray(found[part]))
    return found


@kernel
def coordinates_slope(
    structure: ExtendedStructure,
    gains: Complex,
    state: Complex,
    forces: Array,
    amounts: Array,
    omega: float,
    zeta: float,
    amplitude: float,
) -> Complex:
    """Derivative of coordinates η (m, H+1) along the curve, by those of λ (contact rows, 2H+1) and of ω, ζ and ln a (3,)."""
    found = changes(structure, gains, forces)
    by = slopes(structure, gains, state, omega, zeta, amplitude)
    for part in range(3):
        found += amounts[part] * by[part]
    return boxed(found)


@inner
def _dynamics_slope(structure: ExtendedStructure, h: int, j: int, omega: float, zeta: float, state: Complex) -> complex:
    """Row j of ∂D/∂ω η at harmonic h."""
    k, width = structure.key[h], structure.damping.shape[1]
    shift = 4.0j * h * zeta * omega if h <= structure.extended else 0.0j
    total = -(shift + 2.0 * h * h * omega) * structure.squares[k, j] * state[j, h]
    if width == 1:
        return complex(total + 1j * h * structure.damping[k, 0, j] * state[j, h])
    for i in range(width):
        total += 1j * h * structure.damping[k, j, i] * state[i, h]
    return complex(total)


@inner
def coupled(structure: ExtendedStructure, omega: float, state: Complex) -> complex:
    """Force of the other modes' coordinates (m, H+1) on the followed one through damping, at harmonic 1."""
    total = 0.0j
    if structure.damping.shape[1] > 1:
        k, followed = structure.key[1], structure.followed
        for j in range(state.shape[0]):
            if j != followed:
                total += 1j * omega * structure.damping[k, followed, j] * state[j, 1]
    return complex(total)


@inner
def modal_residual(
    structure: ExtendedStructure, state: Complex, force: complex, omega: float, zeta: float, amplitude: float
) -> complex:
    """The followed mode's own equation at harmonic 1, divided by its amplitude; force: φᴴBᴴλ on it."""
    own = own_dynamics(structure, 1, structure.followed, omega, zeta)
    return complex(own + (coupled(structure, omega, state) + force) / amplitude)


@inner
def modal_slopes(
    structure: ExtendedStructure, state: Complex, by: Complex, force: complex, omega: float, zeta: float, amplitude: float
) -> Complex:
    """Derivatives of the modal residual by ω, ζ and ln a at fixed λ, (3,); by: those of the coordinates."""
    k, followed = structure.key[1], structure.followed
    found = np.empty(3, dtype=np.complex128)
    for part in range(3):
        found[part] = coupled(structure, omega, by[part]) / amplitude
    found[0] += _dynamics_slope(structure, 1, followed, omega, zeta, state) / amplitude
    found[1] -= 2.0j * omega * omega * structure.squares[k, followed]
    found[2] -= (coupled(structure, omega, state) + force) / amplitude
    return found


@inner
def extended_driven(structure: ExtendedStructure, gains: Complex, columns: Index) -> Complex:
    """Coordinates under unit λ of contact rows `columns`, the followed one held at harmonic 1: (H+1, m, columns)."""
    size = structure.squares.shape[1]
    found = np.zeros((structure.key.size, size, columns.size), dtype=np.complex128)
    for h in range(structure.key.size):
        k = structure.key[h]
        if k < 0:
            continue
        load = np.empty((size, columns.size), dtype=np.complex128)
        for j in range(size):
            for c in range(columns.size):
                load[j, c] = shape_at(structure, k, columns[c], j).conjugate()
        if h == 1:
            load[structure.followed] = 0.0
        found[h] = _respond(gains[h], load)
    return found


@inner
def extended_receptance(structure: ExtendedStructure, driven: Complex, rows: Index) -> Array:
    """G' to motion rows `rows` from the driven contact rows: (rows, 2, H+1, columns)."""
    result = np.zeros((rows.size, 2, driven.shape[0], driven.shape[2]))
    for h in range(driven.shape[0]):
        k = structure.key[h]
        if k < 0:
            continue
        real, imaginary = np.ascontiguousarray(driven[h].real), np.ascontiguousarray(driven[h].imag)
        shape = rows_of(structure.real[k], rows)
        result[:, 0, h], result[:, 1, h] = np.dot(shape, real), np.dot(shape, imaginary)
        if structure.imaginary.size:
            shape = rows_of(structure.imaginary[k], rows)
            result[:, 0, h] -= np.dot(shape, imaginary)
            result[:, 1, h] += np.dot(shape, real)
    return result


@inner
def extended_pulled(structure: ExtendedStructure, driven: Complex, weighted: Array) -> Array:
    """−weightedᵀ G' as (columns, 2H+1): how a weighted sum of motions, weighted (rows, 2H+1), depends on λ of driven rows."""
    result = np.zeros((driven.shape[2], weighted.shape[1]))
    for h in range(driven.shape[0]):
        k, a = structure.key[h], max(2 * h - 1, 0)
        if k < 0:
            continue
        for j in range(driven.shape[1]):
            total = 0.0j
            for r in range(weighted.shape[0]):
                total += complex(weighted[r, a], weighted[r, a + 1] if h else 0.0) * shape_at(structure, k, r, j)
            for c in range(driven.shape[2]):
                value = total * driven[h, j, c]
                result[c, a] -= value.real
                if h:
                    result[c, a + 1] -= value.imag
    return result


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
    form: int


@cache
def empty_mode_system() -> ModeSystem:
    """A system without anything, whose types are those of all."""
    line, blocks, places = np.empty(0), np.empty((0, 0, 0)), np.empty(0, dtype=np.int64)
    damping, static = np.empty((0, 0, 0), dtype=np.complex128), np.empty(0, dtype=np.complex128)
    structure = ExtendedStructure(blocks, blocks, np.empty((0, 0)), damping, static, places, 0, 0)
    return ModeSystem(contact_table(()), fourier(1, 6), structure, line, places, places, 0.0, places, FREE, SMALLER)


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
    by = _slopes(system, state, omega, level)
    if _takes_coordinates(system, contact):
        return factorised_on_coordinates(system, state, omega, level, border, offsets, mask, by)
    matrix = np.zeros((size + 1, size + 1))
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
def _takes_coordinates(system: ModeSystem, unknowns: int) -> bool:
    """Whether Newton's matrix stands on coordinates: of one structure of real modes, fewer than the unknowns of λ."""
    structure, kept = system.structure, system.kept.size
    one = structure.real.shape[0] == 1 and structure.imaginary.size == 0
    return one and fewer(system.form, kept * structure.squares.shape[1], unknowns, kept)


@inner
def _in_line(kept: Index, state: Complex, line: Array) -> None:
    """line (m · kept,) = coordinates (m, H+1) in real storage, one column after another."""
    size = state.shape[0]
    for k in range(kept.size):
        h, sine = (kept[k] + 1) // 2, kept[k] > 0 and kept[k] % 2 == 0
        for j in range(size):
            line[k * size + j] = -state[j, h].imag if sine else state[j, h].real


@inner
def _from_line(structure: ExtendedStructure, kept: Index, line: Array) -> Complex:
    """Coordinates (m, H+1) that move contacts, of a solution (m · kept,)."""
    size = structure.squares.shape[1]
    state = np.zeros((size, structure.key.size), dtype=np.complex128)
    for k in range(kept.size):
        h, sine = (kept[k] + 1) // 2, kept[k] > 0 and kept[k] % 2 == 0
        for j in range(size):
            state[j, h] += complex(0.0, -line[k * size + j]) if sine else complex(line[k * size + j], 0.0)
    state[structure.followed, 1] = 0.0
    return state


@inner
def _respond_in_line(structure: ExtendedStructure, gains: Complex, kept: Index, values: Array) -> None:
    """Loads (m · kept, k) on the coordinates become D⁻¹ times these."""
    size, k = structure.squares.shape[1], 0
    while k < kept.size:
        h = (kept[k] + 1) // 2
        sine = k + 1 if h else k
        cosines, sines = values[k * size : (k + 1) * size], values[sine * size : (sine + 1) * size]
        load = np.empty(cosines.shape, dtype=np.complex128)
        load[:] = cosines - 1j * sines if h else cosines + 0j
        found = _respond(gains[h], load)
        sines[:] = -found.imag
        cosines[:] = found.real
        k = sine + 1


def factorised_on_coordinates_signature() -> Any:
    """Types of `factorised_on_coordinates`."""
    slopes_of = typeof(ModeSlopes(np.empty((0, 0, 0)), np.empty(0, dtype=np.complex128)))
    given = typeof(STATE), float64, float64, typeof(BORDER), int64[::1], boolean[:, ::1], slopes_of
    return typeof(BORDERED)(view_of(empty_mode_system()), *given)


@separate(factorised_on_coordinates_signature)
def factorised_on_coordinates(
    system: ModeSystem,
    state: State,
    omega: float,
    level: float,
    border: Border,
    offsets: Index,
    mask: NDArray[np.bool_],
    by: ModeSlopes,
) -> Bordered:
    """The same on the coordinates of the structure, with ω, ζ and ln a behind them."""
    structure, kept, rows = system.structure, system.kept, state.forces.shape[0] - 1
    modes, followed = structure.squares.shape[1], structure.followed
    frequency, amplitude, contact = omega * state.forces[rows, 1], modal_amplitude(level), offsets[rows]
    size = kept.size * modes
    matrix, shape, columns = np.zeros((size + 3, size + 3)), structure.real[0], np.empty((3, contact))
    starts, blocks = modes * np.arange(kept.size + 1), (state.own, state.coupling, state.cross)
    firsts = np.zeros(kept.size, dtype=np.int64)
    system.effort[2] += received_by_pushed(shape, shape, kept, starts, firsts, offsets, system.table, blocks, matrix)
    share = np.empty(modes, dtype=np.complex128)
    for j in range(modes):
        other = 1j * frequency * structure.damping[0, followed, j] if structure.damping.shape[1] > 1 else 0.0j
        share[j] = (1.0 if j == followed else -other) / amplitude
    weights = np.dot(border.weight.T, shape) if border.weight.shape[0] else np.zeros((state.w.shape[1], modes))
    for k in range(kept.size):
        if kept[k] in (1, 2):
            matrix[:size, starts[k] + followed] = 0.0
            weights[kept[k], followed] = 0.0
        for j in range(modes):
            column = starts[k] + j
            if kept[k] == 1:
                matrix[size, column], matrix[size + 1, column] = share[j].real, share[j].imag
            elif kept[k] == 2:
                matrix[size, column], matrix[size + 1, column] = share[j].imag, -share[j].real
            matrix[size + 2, column] = -weights[kept[k], j]
    _respond_in_line(structure, state.gains, kept, matrix[:size, :size])
    for k in range(size):
        matrix[k, k] += 1.0
    for part in range(3):
        columns[part] = -_pushed(system, state, offsets, by.motion[part])
        if part == 0:
            for r in range(rows):
                for k in range(offsets[r + 1] - offsets[r]):
                    columns[part, offsets[r] + k] -= omega * state.by_omega[r, kept[k]]
        forces = np.zeros((rows, state.w.shape[1]))
        spread(mask[:rows], columns[part], forces)
        _in_line(kept, _by_harmonic(state.gains, received(structure, forces)), matrix[:size, size + part])
        matrix[size, size + part], matrix[size + 1, size + part] = by.modal[part].real, by.modal[part].imag
        if border.weight.shape[0]:
            matrix[size + 2, size + part] = np.sum(border.weight * by.motion[part])
    matrix[size + 2, size + 2] += border.slope
    system.effort[2] += matrix.shape[0] ** 3 // 3
    pivots = lu_factor(matrix)
    return Bordered(matrix, pivots, offsets, mask, orientation(matrix, pivots), columns, state.own, 0.0)


@separate(lambda: void(view_of(empty_mode_system()), typeof(STATE), typeof(BORDERED), float64[:, ::1]))
def solve_on_coordinates(system: ModeSystem, state: State, bordered: Bordered, right: Array) -> None:
    """Overwrite right-hand sides (k, N + 3) with the solutions, with the factors on the coordinates."""
    structure, kept, rows = system.structure, system.kept, state.forces.shape[0] - 1
    contact, size = bordered.offsets[rows], bordered.lu.shape[0] - 3
    line = np.empty((1, size + 3))
    for each in right:
        forces = np.zeros((rows, state.w.shape[1]))
        spread(bordered.mask[:rows], each[:contact], forces)
        _in_line(kept, _by_harmonic(state.gains, received(structure, forces)), line[0, :size])
        line[0, size:] = each[contact:]
        lu_solve(bordered.lu, bordered.pivots, line)
        moved = seen(structure, _from_line(structure, kept, line[0]))
        each[:contact] -= _pushed(system, state, bordered.offsets, moved)
        for part in range(3):
            each[contact + part] = line[0, size + part]
            each[:contact] -= each[contact + part] * bordered.columns[part]


@inner
def _solve(system: ModeSystem, state: State, bordered: Bordered, right: Array) -> None:
    if bordered.columns.shape[0]:
        solve_on_coordinates(system, state, bordered, right)
    else:
        lu_solve(bordered.lu, bordered.pivots, right)


def compile_on_coordinates(system: ModeSystem) -> None:
    """Compile what solves Newton's linear system on the coordinates, or take it from disk; nothing where these are never the
    fewer."""
    rows, modes = system.table.rows, system.structure.squares.shape[1]
    many = rows > modes and rows * system.kept.size >= FEWEST_UNKNOWNS
    if system.form == ON_STATES or many:
        compiled(factorised_on_coordinates, solve_on_coordinates)


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
    _solve(system, state, bordered, right)
    spread(bordered.mask, right[0], step)
    amount = right[0, size] if border.weight.shape[0] else -short / border.slope
    return step, amount, 0.0


@separate(lambda: tangent_signature(empty_mode_system()))
def tangent_mode(system: ModeSystem, state: State, omega: float, level: float, by_level: bool, bordered: Bordered) -> Direction:
    """The direction of the curve at a point, with the factors there."""
    rows, size = state.forces.shape[0] - 1, bordered.offsets[-1]
    right = np.zeros((1, size + 1))
    right[0, size] = 1.0
    _solve(system, state, bordered, right)
    forces = np.zeros(state.forces.shape)
    spread(bordered.mask, right[0], forces)
    rate, by = right[0, size], _slopes(system, state, omega, level)
    amounts = np.array([forces[rows, 1], forces[rows, 2], rate])
    dw = seen(system.structure, changes(system.structure, state.gains, forces[:rows]))
    for part in range(3):
        dw += amounts[part] * by.motion[part]
    return Direction(forces, dw, rate, 0.0)
