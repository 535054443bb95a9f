"""Compiled linear part at one frequency: motion under loads and λ, receptance, and derivatives.

All are sums over the states that `decoupling` found, G'(s) = shape Γ(s) receiverᵀ, s = i h ω; the gains that Γ is made of are
computed once for each frequency.
"""

from typing import NamedTuple

import numpy as np
from numba import boolean, complex128, float64
from numpy.typing import NDArray

from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inlined, inner, separate
from stickslip.support.kernels.arrays import empty_table, zero_complex, zero_table
from stickslip.support.kernels.views import view_of

REAL_MODE, PAIR_FIRST, PAIR_SECOND, REAL_POLE, BLOCK_FIRST, BLOCK_SECOND, WAVE_FIRST, WAVE_SECOND = range(8)

Complex = NDArray[np.complex128]

BLOCK = 64
"""Columns of loads that are taken together."""


class Modes(NamedTuple):
    """States with gains: motion = shape · Γ(s) · (receiverᵀ forces).

    shape (rows, m): motion of contact rows, then outputs; receiver (contact rows, m): how λ drives the states;
    static (powers, m, 2H+1): how the constant loads drive them, Σ_k ω^k static[k]; dynamic (powers, m, 2H+1): the harmonic ones
    at force level one, likewise.
    kind (m,): REAL_MODE with gain 1/(1 + s p + s² q); PAIR_FIRST and PAIR_SECOND for a pole p + i q and its conjugate;
    REAL_POLE with gain 1/(1 − s p); BLOCK_FIRST and BLOCK_SECOND with (I − s [[p, q1], [q2, p]])⁻¹; WAVE_FIRST and WAVE_SECOND
    for a complex state x with gain 1/(1 + s (p + i r) + s² q), kept as x and i x.
    partner (m,): the other state of a pair or block. above (m, m): how a state is driven by those after it, x = Γ(f + s above x),
    or (0, 0) where none is. first, last (H+1,): the states of each harmonic, all of them unless harmonics see structures of
    their own; none of a harmonic that is not balanced, which so has no motion. order (H+1,): k of s = i k ω at which a harmonic
    responds: itself, or 1 for a mean whose stiffness goes with the speed.
    basis (rows, n), output, input (n, m): motion = basis output Γ inputᵀ basisᵀ λ by fewer coordinates n than states; (0, 0)
    where there are not fewer, or harmonics see structures of their own.
    """

    shape: Array
    receiver: Array
    static: Array
    dynamic: Array
    kind: Index
    p: Array
    q: Array
    r: Array
    partner: Index
    above: Array
    first: Index
    last: Index
    order: Index
    basis: Array
    output: Array
    input: Array


_LINE, _SQUARE, _PLACES = np.empty(0), np.empty((0, 0)), np.empty(0, dtype=np.int64)

_POWERS = np.empty((0, 0, 0))

_STATES = _SQUARE, _SQUARE, _POWERS, _POWERS, _PLACES, _LINE, _LINE, _LINE, _PLACES, _SQUARE, _PLACES, _PLACES, _PLACES

NO_MODES = Modes(*_STATES, _SQUARE, _SQUARE, _SQUARE)
"""None at all, whose types are those of all."""


@inner
def _not_zero(value: complex) -> complex:
    """An undamped resonance met exactly has no finite motion: NaN, to which nothing converges."""
    return value if value != 0.0 else complex(np.nan, np.nan)


@inlined
def state_gains(s: complex, kind: Index, p: Array, q: Array, r: Array) -> Complex:
    """Gains at s, (2, m): of each state, and to it from its partner."""
    gains = zero_complex(2, kind.size)
    for j in range(kind.size):
        if kind[j] == REAL_MODE:
            gains[0, j] = 1.0 / _not_zero(1.0 + s * p[j] + s * s * q[j])
        elif kind[j] == REAL_POLE:
            gains[0, j] = 1.0 / (1.0 - s * p[j])
        elif kind[j] == BLOCK_FIRST:
            alone = 1.0 - s * p[j]
            scale = 1.0 / _not_zero(alone * alone - s * s * q[j] * q[j + 1])
            gains[0, j] = gains[0, j + 1] = alone * scale
            gains[1, j], gains[1, j + 1] = s * q[j] * scale, s * q[j + 1] * scale
        elif kind[j] == WAVE_FIRST:
            gain = 1.0 / _not_zero(1.0 + s * complex(p[j], r[j]) + s * s * q[j])
            gains[0, j], gains[0, j + 1] = gain, -gain
            gains[1, j] = gains[1, j + 1] = 1j * gain
        elif kind[j] == PAIR_FIRST or kind[j] == PAIR_SECOND:
            pole, sign = complex(p[j], q[j]), 1.0 if kind[j] == PAIR_FIRST else -1.0
            one, two = 1.0 / _not_zero(1.0 - s * pole), 1.0 / _not_zero(1.0 - s * pole.conjugate())
            gains[0, j], gains[1, j] = sign * (one + two), 1j * (one - two)
    return gains


@inlined
def _slope_gains(s: complex, gains: Complex, kind: Index, p: Array, q: Array, r: Array) -> Complex:
    """Derivatives by s of the gains of states that are driven by none after them."""
    slopes = zero_complex(2, kind.size)
    for j in range(kind.size):
        gain = gains[0, j]
        if kind[j] == REAL_MODE:
            slopes[0, j] = -gain * gain * (p[j] + 2.0 * s * q[j])
        elif kind[j] == REAL_POLE:
            slopes[0, j] = gain * gain * p[j]
        elif kind[j] == WAVE_FIRST:
            slope = -gain * gain * (complex(p[j], r[j]) + 2.0 * s * q[j])
            slopes[0, j], slopes[0, j + 1] = slope, -slope
            slopes[1, j] = slopes[1, j + 1] = 1j * slope
        elif kind[j] == PAIR_FIRST or kind[j] == PAIR_SECOND:
            pole, sign = complex(p[j], q[j]), 1.0 if kind[j] == PAIR_FIRST else -1.0
            one, two = 0.5 * (sign * gain - 1j * gains[1, j]), 0.5 * (sign * gain + 1j * gains[1, j])
            one, two = one * one * pole, two * two * pole.conjugate()
            slopes[0, j], slopes[1, j] = sign * (one + two), 1j * (one - two)
    return slopes


@inlined
def frequency_gains(modes: Modes, omega: float, harmonics: int) -> Complex:
    """Gains at every harmonic of a frequency, (H+1, 2, m)."""
    gains = np.empty((harmonics + 1, 2, modes.kind.size), dtype=np.complex128)
    for h in range(harmonics + 1):
        a, b = modes.first[h], modes.last[h]
        found = state_gains(1j * modes.order[h] * omega, modes.kind[a:b], modes.p[a:b], modes.q[a:b], modes.r[a:b])
        for i in range(2):
            for j in range(b - a):
                gains[h, i, a + j] = found[i, j]
    return gains


@inner
def _respond(modes: Modes, h: int, s: complex, gains: Complex, load: Complex, state: Complex) -> None:
    """state = Γ(s) load at harmonic h, both (m, k); from the last state to the first, since these may drive those."""
    driven, last = modes.above.shape[0] > 0, modes.last[h]
    j = last - 1
    while j >= modes.first[h]:
        i = modes.partner[j]
        for c in range(load.shape[1]):
            one, two = load[i, c], load[j, c]
            if driven:
                for k in range(j + 1, last):
                    one += s * modes.above[i, k] * state[k, c]
                    two += s * modes.above[j, k] * state[k, c]
            state[j, c] = gains[0, j] * two
            if i != j:
                state[j, c] += gains[1, j] * one
                state[i, c] = gains[0, i] * one + gains[1, i] * two
        j = i - 1


@inlined
def _respond_slope(modes: Modes, h: int, s: complex, gains: Complex, load: Complex, state: Complex, slope: Complex) -> None:
    """slope = dΓ/ds load at harmonic h, all (m, 1); state = Γ load. For driven states Γ = (I − s T)⁻¹, dΓ/ds = Γ T Γ."""
    a, b = modes.first[h], modes.last[h]
    if modes.above.shape[0] == 0:
        slopes = _slope_gains(s, gains[:, a:b], modes.kind[a:b], modes.p[a:b], modes.q[a:b], modes.r[a:b])
        for j in range(a, b):
            slope[j, 0] = slopes[0, j - a] * load[j, 0] + slopes[1, j - a] * load[modes.partner[j], 0]
        return
    turned = zero_complex(state.shape[0], state.shape[1])
    for j in range(a, b):
        total = modes.p[j] * state[j, 0]
        if modes.partner[j] != j:
            total += modes.q[j] * state[modes.partner[j], 0]
        for k in range(j + 1, b):
            total += modes.above[j, k] * state[k, 0]
        turned[j, 0] = total
    _respond(modes, h, s, gains, turned, slope)


@separate(lambda: float64[:, ::1](view_of(NO_MODES), float64, complex128[:, :, ::1], float64[:, ::1], boolean))
def modal_states(modes: Modes, omega: float, gains: Complex, load: Array, by_omega: bool) -> Array:
    """States (m, 2H+1) under loads on them in real storage (m, 2H+1), or their derivative by ω."""
    size = modes.kind.size
    found = zero_table(load.shape[0], load.shape[1])
    load_h, state_h = zero_complex(size, 1), zero_complex(size, 1)
    slope_h = zero_complex(size if by_omega else 0, 1)
    for h in range(gains.shape[0]):
        s, a, b = 1j * modes.order[h] * omega, max(2 * h - 1, 0), 2 * h
        for j in range(modes.first[h], modes.last[h]):
            load_h[j, 0] = complex(load[j, a], -load[j, b] if h > 0 else 0.0)
        _respond(modes, h, s, gains[h], load_h, state_h)
        if by_omega:
            _respond_slope(modes, h, s, gains[h], load_h, state_h, slope_h)
        for j in range(modes.first[h], modes.last[h]):
            value = 1j * modes.order[h] * slope_h[j, 0] if by_omega else state_h[j, 0]
            found[j, a] = value.real
            if h > 0:
                found[j, b] = -value.imag
    return found


@inner
def respond_to_each(modes: Modes, h: int, s: complex, gains: Complex, cosine: Array, sine: Array) -> None:
    """Loads on the states of harmonic h, cosine and sine part (states, k), become Γ(s) times these; for h = 0 only the cosine."""
    size, first, count = modes.kind.size, modes.first[h], modes.last[h] - modes.first[h]
    load, state = zero_complex(size, BLOCK), zero_complex(size, BLOCK)
    for begin in range(0, cosine.shape[1], BLOCK):
        width = min(BLOCK, cosine.shape[1] - begin)
        for j in range(count):
            for c in range(width):
                load[first + j, c] = complex(cosine[j, begin + c], -sine[j, begin + c] if h > 0 else 0.0)
        _respond(modes, h, s, gains, load, state)
        for j in range(count):
            for c in range(width):
                cosine[j, begin + c] = state[first + j, c].real
                if h > 0:
                    sine[j, begin + c] = -state[first + j, c].imag


@inner
def respond_in_basis(modes: Modes, h: int, s: complex, gains: Complex, cosine: Array, sine: Array) -> None:
    """The same for loads on the coordinates of the basis, (n, k), which become output Γ(s) inputᵀ times these."""
    size, states = modes.input.shape
    load, state = zero_complex(states, size), zero_complex(states, size)
    for j in range(states):
        for c in range(size):
            load[j, c] = modes.input[c, j]
    _respond(modes, h, s, gains, load, state)
    real, imaginary = empty_table(states, size), empty_table(states, size)
    for j in range(states):
        for c in range(size):
            real[j, c], imaginary[j, c] = state[j, c].real, state[j, c].imag
    real, imaginary = np.dot(modes.output, real), np.dot(modes.output, imaginary)
    a, b = np.ascontiguousarray(cosine), np.ascontiguousarray(sine)
    cosine[:] = np.dot(real, a)
    if h > 0:
        cosine += np.dot(imaginary, b)
        sine[:] = np.dot(real, b)
        sine -= np.dot(imaginary, a)


@inner
def _one_structure(modes: Modes) -> bool:
    """Whether all harmonics that are balanced, as the first is, see the same states."""
    return bool(modes.last[1] - modes.first[1] == modes.kind.size)


@inner
def seen(modes: Modes, state: Array) -> Array:
    """Motion (rows, 2H+1) of states (m, 2H+1)."""
    if _one_structure(modes):
        found = empty_table(modes.shape.shape[0], state.shape[1])
        np.dot(modes.shape, state, found)
        return found
    result = zero_table(modes.shape.shape[0], state.shape[1])
    for r in range(result.shape[0]):
        for h in range(modes.first.size):
            for j in range(modes.first[h], modes.last[h]):
                for i in range(max(2 * h - 1, 0), 2 * h + 1):
                    result[r, i] += modes.shape[r, j] * state[j, i]
    return result


@inner
def _load(modes: Modes, forces: Array, omega: float, level: float) -> Array:
    """What drives the states: loads at a level and forces λ."""
    constant, excited = _polynomial(modes.static, omega), _polynomial(modes.dynamic, omega)
    load: Array = np.dot(modes.receiver.T, forces)
    for j in range(load.shape[0]):
        for i in range(load.shape[1]):
            load[j, i] = constant[j, i] + level * excited[j, i] - load[j, i]
    return load


@inner
def scale(values: Array, factor: float) -> None:
    """values *= factor; as an expression of arrays this would compile to many times the code."""
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            values[i, j] *= factor


@inner
def add(values: Array, factor: float, more: Array) -> None:
    """values += factor more."""
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            values[i, j] += factor * more[i, j]


@inner
def _polynomial(powers: Array, omega: float) -> Array:
    """Σ_k ω^k powers[k], (m, 2H+1): how loads drive the states at a frequency."""
    total: Array = powers[-1].copy()
    for k in range(powers.shape[0] - 2, -1, -1):
        scale(total, omega)
        add(total, 1.0, powers[k])
    return total


@inner
def _polynomial_slope(powers: Array, omega: float) -> Array:
    """Derivative of `_polynomial` by ω."""
    slope = zero_table(powers.shape[1], powers.shape[2])
    for k in range(powers.shape[0] - 1, 0, -1):
        scale(slope, omega)
        add(slope, float(k), powers[k])
    return slope


@inlined
def motion(modes: Modes, gains: Complex, forces: Array, omega: float, level: float) -> Array:
    """Motion w = e' − G'λ of contact rows and outputs (rows, 2H+1); forces: λ (contact rows, 2H+1), N; omega [rad/s]."""
    return seen(modes, modal_states(modes, omega, gains, _load(modes, forces, omega, level), False))


@inner
def motion_slope(modes: Modes, gains: Complex, forces: Array, omega: float, level: float, by_level: bool) -> Array:
    """Derivative of the motion (rows, 2H+1) by the force level, or by ω, at fixed λ."""
    load = _polynomial(modes.dynamic, omega) if by_level else _load(modes, forces, omega, level)
    slope = modal_states(modes, omega, gains, load, not by_level)
    if not by_level and max(modes.dynamic.shape[0], modes.static.shape[0]) > 1:
        grown = _polynomial_slope(modes.static, omega)
        add(grown, level, _polynomial_slope(modes.dynamic, omega))
        add(slope, 1.0, modal_states(modes, omega, gains, grown, False))
    return seen(modes, slope)


@inner
def change(modes: Modes, gains: Complex, forces: Array, omega: float) -> Array:
    """Change of motion −G'δλ (rows, 2H+1) for a change of forces δλ (contact rows, 2H+1)."""
    load = np.dot(modes.receiver.T, forces)
    scale(load, -1.0)
    return seen(modes, modal_states(modes, omega, gains, load, False))


@inlined
def driven_states(modes: Modes, gains: Complex, omega: float, columns: Index) -> Array:
    """States under unit λ of contact rows `columns`: (m, 2, H+1, columns), real and imaginary part."""
    size, width = modes.kind.size, columns.size
    found = np.zeros((size, 2, gains.shape[0], width))
    load, state = zero_complex(size, width), zero_complex(size, width)
    for j in range(size):
        for c in range(width):
            load[j, c] = modes.receiver[columns[c], j]
    for h in range(gains.shape[0]):
        _respond(modes, h, 1j * modes.order[h] * omega, gains[h], load, state)
        for j in range(modes.first[h], modes.last[h]):
            for c in range(width):
                found[j, 0, h, c] = state[j, c].real
                found[j, 1, h, c] = state[j, c].imag
    return found


@inlined
def receptance(modes: Modes, driven: Array, rows: Index) -> Array:
    """G' to motion rows `rows` from the driven contact rows: (rows, 2, H+1, columns)."""
    harmonics, width = driven.shape[2], driven.shape[3]
    if _one_structure(modes):
        product = np.dot(_shapes(modes, rows, 0, modes.kind.size), driven.reshape(driven.shape[0], -1))
        return np.asarray(product.reshape(rows.size, 2, harmonics, width))
    result = np.zeros((rows.size, 2, harmonics, width))
    for h in range(harmonics):
        a, b = modes.first[h], modes.last[h]
        if a == b:
            continue
        shape = _shapes(modes, rows, a, b)
        for part in range(1 if h == 0 else 2):
            product = np.dot(shape, np.ascontiguousarray(driven[a:b, part, h]))
            for r in range(rows.size):
                for c in range(width):
                    result[r, part, h, c] = product[r, c]
    return result


@inner
def _shapes(modes: Modes, rows: Index, first: int, last: int) -> Array:
    """Motion of some rows in the states first..last−1."""
    found = empty_table(rows.size, last - first)
    for r in range(rows.size):
        for j in range(last - first):
            found[r, j] = modes.shape[rows[r], first + j]
    return found


@inner
def pulled(modes: Modes, driven: Array, weighted: Array) -> Array:
    """−weightedᵀ G' as (columns, 2H+1): how a weighted sum of motions, weighted (rows, 2H+1), depends on λ of driven rows."""
    return pulled_by_states(modes, driven, np.dot(modes.shape.T, weighted))


@inner
def pulled_by_states(modes: Modes, driven: Array, state: Array) -> Array:
    """−stateᵀ Γ receiverᵀ as (columns, 2H+1): how a sum of states, weighted by state (m, 2H+1), depends on λ of driven rows."""
    result = zero_table(driven.shape[3], state.shape[1])
    for h in range(driven.shape[2]):
        a, b = max(2 * h - 1, 0), 2 * h
        for j in range(modes.first[h], modes.last[h]):
            for c in range(driven.shape[3]):
                real, imaginary = driven[j, 0, h, c], driven[j, 1, h, c]
                if h == 0:
                    result[c, 0] -= state[j, 0] * real
                else:
                    result[c, a] -= state[j, a] * real - state[j, b] * imaginary
                    result[c, b] -= state[j, a] * imaginary + state[j, b] * real
    return result
