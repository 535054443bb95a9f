"""The linear part, cheap at every frequency: motion of contacts and outputs under loads and λ, on the stuck structure.

G'(iΩ) = B (K + BᵀK_cB + iΩC − Ω²M)⁻¹ Bᵀ is a sum over modes, decomposed once:

* C diagonal on the stuck modes: real modes with φᵀ(K + BᵀK_cB)φ = 1 and gain 1/(1 + s c + s² m), s = iΩ. Massless motions
  have m = 0 and need no special case; a rigid body on its contacts neither.
* C general: with f, η on those modes, η = [0 I](I − s S)⁻¹[0; I] f, S = [[0, I], [−m, −c]]; the eigenvectors of S give
  poles σ, gain 1/(1 − s σ), pairs of which are kept real as 2 x 2 blocks. Where the eigenvectors are nearly dependent
  (critical damping), the dynamic stiffness is factorised at every frequency instead (`DirectPart`): slower, never wrong.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.checks import Array
from stickslip.kernels import njit

DIAGONAL = 1e-10
"""Modal damping off the diagonal, relative to the largest, that is rounding."""

REAL_MODE, PAIR_FIRST, PAIR_SECOND, REAL_POLE = 0, 1, 2, 3


class Modes(NamedTuple):
    """States j with gains: motion = shape · Γ(s) · (receiverᵀ forces), Γ block diagonal.

    shape (rows, m): motion of contact rows, then outputs; receiver (contact rows, m): how λ drives the states;
    static, dynamic (m, 2H+1): how the loads drive them, the dynamic part at force level one.
    kind (m,): REAL_MODE with gain 1/(1 + s p + s² q); PAIR_FIRST and PAIR_SECOND for a pole p + i q and its conjugate;
    REAL_POLE with gain 1/(1 − s p).
    """

    shape: Array
    receiver: Array
    static: Array
    dynamic: Array
    kind: NDArray[np.int64]
    p: Array
    q: Array


class StuckModes(NamedTuple):
    """Real modes of the stuck structure, φᵀK'φ = 1: shapes (n, m) and squares of 1/ω (m,), ascending in frequency."""

    shapes: Array
    inverse_squares: Array


def stuck_modes(M: Array, stiffness: Array) -> StuckModes:
    """Modes of (stiffness, M), stiffness positive definite, M positive semi-definite."""
    inverse_squares, shapes = linalg.eigh(M, stiffness)
    order = np.argsort(-inverse_squares)
    return StuckModes(np.ascontiguousarray(shapes[:, order]), np.maximum(inverse_squares[order], 0.0))


class States(NamedTuple):
    """Decoupled states of the whole structure: q = output (n, m) · Γ · (inputᵀ p), input (n, m)."""

    output: Array
    input: Array
    kind: NDArray[np.int64]
    p: Array
    q: Array


def states(M: Array, C: Array, stiffness: Array) -> States:
    """Decouple M q̈ + C q̇ + stiffness q = p. Raises `linalg.LinAlgError` where no accurate decoupling exists."""
    shapes, inverse_squares = stuck_modes(M, stiffness)
    damping = shapes.T @ C @ shapes
    diagonal = np.diag(damping)
    coupling = float(np.max(np.abs(damping - np.diag(diagonal)), initial=0.0))
    if coupling <= DIAGONAL * float(np.max(np.abs(diagonal), initial=1e-300)):
        kind = np.full(inverse_squares.size, REAL_MODE)
        return States(shapes, shapes, kind, diagonal.copy(), inverse_squares)
    return _complex_states(shapes, inverse_squares, damping)


def _complex_states(shapes: Array, inverse_squares: Array, damping: Array) -> States:
    size = inverse_squares.size
    S = np.block([[np.zeros((size, size)), np.eye(size)], [-np.diag(inverse_squares), -damping]])
    poles, right = linalg.eig(S)
    condition = np.linalg.cond(right)
    if not np.isfinite(condition) or condition > 1e9:
        raise linalg.LinAlgError("the complex modes are nearly dependent")
    left = linalg.inv(right)[:, size:]
    output, source = shapes @ right[size:], shapes @ left.T
    real = np.flatnonzero(poles.imag == 0.0)
    upper = np.flatnonzero(poles.imag > 0.0)
    pairs = np.repeat(upper, 2)
    first = np.tile([True, False], upper.size)

    def interleaved(columns: NDArray[Any]) -> Array:
        chosen = columns[:, pairs]
        return np.ascontiguousarray(np.hstack([np.where(first, chosen.real, chosen.imag), columns[:, real].real]))

    kinds = np.concatenate([np.tile([PAIR_FIRST, PAIR_SECOND], upper.size), np.full(real.size, REAL_POLE)])
    p, q = (np.concatenate([part[pairs], part[real]]) for part in (poles.real, poles.imag))
    found = States(interleaved(output), interleaved(source), kinds.astype(np.int64), p, q)
    _check_states(found, shapes, inverse_squares, damping)
    return found


def _check_states(found: States, shapes: Array, inverse_squares: Array, damping: Array) -> None:
    """Compare with direct solutions across the spectrum; the decomposition must be right to 1e-9."""
    drive = np.linspace(1.0, 2.0, inverse_squares.size)
    received = found.input.T @ np.linalg.solve(shapes.T, drive)
    moving = inverse_squares[inverse_squares > 1e-12 * inverse_squares.max(initial=1e-300)]
    for frequency in 1.0 / np.sqrt(np.quantile(moving, [0.0, 0.3, 0.6, 1.0])):
        dynamic = np.eye(drive.size) + 1j * frequency * damping - frequency**2 * np.diag(inverse_squares)
        direct = shapes @ np.linalg.solve(dynamic, drive)
        gains = state_gains(1j * frequency, 1j, found.kind, found.p, found.q)
        state = gains[0] * received + gains[1] * received[partners(found.kind)]
        if float(np.max(np.abs(found.output @ state - direct))) > 1e-9 * float(np.max(np.abs(direct))):
            raise linalg.LinAlgError("the complex modes do not reproduce the receptance")


@njit(cache=True)
def _not_zero(value: complex) -> complex:
    """An undamped resonance met exactly has no finite motion: NaN, to which nothing converges."""
    return value if value != 0.0 else complex(np.nan, np.nan)


@njit(cache=True)
def state_gains(s: complex, ds: complex, kind: NDArray[np.int64], p: Array, q: Array) -> NDArray[np.complex128]:
    """Γ at s as rows (4, m): diagonal gains, cross gains to the partner, and the derivatives of both along ds."""
    gains = np.zeros((4, kind.size), dtype=np.complex128)
    for j in range(kind.size):
        if kind[j] == REAL_MODE:
            gain = 1.0 / _not_zero(1.0 + s * p[j] + s * s * q[j])
            gains[0, j], gains[2, j] = gain, -gain * gain * (p[j] + 2.0 * s * q[j]) * ds
        elif kind[j] == REAL_POLE:
            gain = 1.0 / (1.0 - s * p[j])
            gains[0, j], gains[2, j] = gain, gain * gain * p[j] * ds
        else:
            pole, sign = complex(p[j], q[j]), 1.0 if kind[j] == PAIR_FIRST else -1.0
            one, two = 1.0 / _not_zero(1.0 - s * pole), 1.0 / _not_zero(1.0 - s * pole.conjugate())
            d_one, d_two = one * one * pole * ds, two * two * pole.conjugate() * ds
            gains[0, j], gains[1, j] = sign * (one + two), 1j * (one - two)
            gains[2, j], gains[3, j] = sign * (d_one + d_two), 1j * (d_one - d_two)
    return gains


@njit(cache=True)
def partners(kind: NDArray[np.int64]) -> NDArray[np.int64]:
    """The state that shares a 2 x 2 block with each state; itself when alone."""
    partner = np.arange(kind.size)
    for j in range(kind.size):
        if kind[j] == PAIR_FIRST:
            partner[j] = j + 1
        elif kind[j] == PAIR_SECOND:
            partner[j] = j - 1
    return partner


@njit(cache=True)
def motion(modes: Modes, forces: Array, omega: float, level: float, w: Array, by_omega: Array, by_level: Array) -> None:
    """Motion w = e' − G'λ of contact rows and outputs (rows, 2H+1), and its derivatives by ω and by force level at fixed λ.

    forces: λ (contact rows, 2H+1), N; omega [rad/s].
    """
    size, columns = modes.kind.size, forces.shape[1]
    load = modes.static + level * modes.dynamic - modes.receiver.T @ forces
    partner = partners(modes.kind)
    state, state_omega, state_level = np.zeros((size, columns)), np.zeros((size, columns)), np.zeros((size, columns))
    for h in range((columns + 1) // 2):
        gains = state_gains(1j * h * omega, 1j * h, modes.kind, modes.p, modes.q)
        a, b = max(2 * h - 1, 0), 2 * h
        turn = 1j if h > 0 else 0j
        for j in range(size):
            k = partner[j]
            own, other = load[j, a] - turn * load[j, b], load[k, a] - turn * load[k, b]
            unit, unit_other = modes.dynamic[j, a] - turn * modes.dynamic[j, b], modes.dynamic[k, a] - turn * modes.dynamic[k, b]
            value = gains[0, j] * own + gains[1, j] * other
            omega_value = gains[2, j] * own + gains[3, j] * other
            level_value = gains[0, j] * unit + gains[1, j] * unit_other
            state[j, a], state_omega[j, a], state_level[j, a] = value.real, omega_value.real, level_value.real
            if h > 0:
                state[j, b], state_omega[j, b], state_level[j, b] = -value.imag, -omega_value.imag, -level_value.imag
    w[:, :] = modes.shape @ state
    by_omega[:, :] = modes.shape @ state_omega
    by_level[:, :] = modes.shape @ state_level


@njit(cache=True)
def receptance(modes: Modes, omega: float, harmonics: int, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> Array:
    """G' from contact rows `columns` to motion rows `rows`: (2, H+1, rows, columns), real and imaginary part."""
    size, width = modes.kind.size, columns.size
    partner = partners(modes.kind)
    driven = np.empty((size, 2 * (harmonics + 1) * width))
    for h in range(harmonics + 1):
        gains = state_gains(1j * h * omega, 1j * h, modes.kind, modes.p, modes.q)
        for j in range(size):
            for c in range(width):
                value = gains[0, j] * modes.receiver[columns[c], j] + gains[1, j] * modes.receiver[columns[c], partner[j]]
                driven[j, h * width + c] = value.real
                driven[j, (harmonics + 1 + h) * width + c] = value.imag
    shape = np.empty((rows.size, size))
    for r in range(rows.size):
        shape[r] = modes.shape[rows[r]]
    product = (shape @ driven).reshape(rows.size, 2, harmonics + 1, width)
    return np.ascontiguousarray(product.transpose(1, 2, 0, 3))


@njit(cache=True)
def pulled(modes: Modes, omega: float, weighted: Array, columns: NDArray[np.int64]) -> Array:
    """−weightedᵀ G' as (columns, 2H+1): how a weighted sum of motions, weighted (rows, 2H+1), depends on λ of rows `columns`."""
    result = np.empty((columns.size, weighted.shape[1]))
    state = modes.shape.T @ weighted
    partner = partners(modes.kind)
    for h in range((weighted.shape[1] + 1) // 2):
        gains = state_gains(1j * h * omega, 1j * h, modes.kind, modes.p, modes.q)
        a, b = max(2 * h - 1, 0), 2 * h
        for c in range(columns.size):
            total = 0j
            for j in range(modes.kind.size):
                receiver, other = modes.receiver[columns[c], j], modes.receiver[columns[c], partner[j]]
                pull = complex(state[j, a], state[j, b] if h > 0 else 0.0)
                total += pull * (gains[0, j] * receiver + gains[1, j] * other)
            result[c, a] = -total.real
            if h > 0:
                result[c, b] = -total.imag
    return result
