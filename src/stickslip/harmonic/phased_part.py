"""The linear part where each harmonic sees a structure of its own: the nodal diameters of a disk, or springs on the mean alone.

Per harmonic G'(s) = B (K + BᴴK_cB + s C + s² M)⁻¹ Bᴴ with complex Hermitian matrices is a sum over decoupled states with gains
1/(1 + s p + s² q): real modes where C is diagonal on them, else the poles of the first-order form (q = 0, p = −1/pole).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.checks import Array, InputError
from stickslip.harmonic.fourier import complex_harmonics, real_harmonics
from stickslip.problem import LinearSystem, Problem

Complex = NDArray[np.complex128]
Rows = NDArray[np.int64]

DIAGONAL = 1e-10
"""Modal damping off the diagonal, relative to the largest, that is rounding."""
CONDITION = 1e9


class WaveStates(NamedTuple):
    """q = output (n, m) Γ(s) drive (m, n) p, gains 1/(1 + s p + s² q); shape (motion rows, m), receiver (m, rows)."""

    output: Complex
    drive: Complex
    shape: Complex
    receiver: Complex
    p: Complex
    q: Array

    def gains(self, s: complex, ds: complex) -> tuple[Complex, Complex]:
        """Gains and their derivative along ds; NaN at an undamped resonance met exactly."""
        stiffness = 1.0 + s * self.p + s * s * self.q
        gain = np.asarray(1.0 / np.where(stiffness == 0.0, np.nan, stiffness), dtype=complex)
        return gain, -gain * gain * (self.p + 2.0 * s * self.q) * ds


class PhasedPart:
    """Sums over the states of each harmonic's own structure."""

    def __init__(self, problem: Problem, harmonics: int) -> None:
        static, full = (complex_harmonics(problem.load(harmonics, level)) for level in (0.0, 1.0))
        waves: dict[int, WaveStates] = {}
        for h in range(harmonics + 1):
            if problem.wave(h) not in waves:
                waves[problem.wave(h)] = wave_sum(problem.waves(h))
        self.states = [waves[problem.wave(h)] for h in range(harmonics + 1)]
        self.static = [state.drive @ static[:, h] for h, state in enumerate(self.states)]
        self.dynamic = [state.drive @ (full - static)[:, h] for h, state in enumerate(self.states)]

    def motion(self, forces: Array, omega: float, level: float, w: Array, by_omega: Array, by_level: Array) -> None:
        pushed = complex_harmonics(forces)
        result = np.empty((3, w.shape[0], len(self.states)), dtype=complex)
        for h, state in enumerate(self.states):
            gain, slope = state.gains(1j * h * omega, 1j * h)
            load = self.static[h] + level * self.dynamic[h] - state.receiver @ pushed[:, h]
            result[:, :, h] = (state.shape @ np.stack([gain * load, slope * load, gain * self.dynamic[h]], axis=1)).T
        w[:], by_omega[:], by_level[:] = real_harmonics(result)

    def receptance(self, omega: float, harmonics: int, rows: Rows, columns: Rows) -> Array:
        blocks = np.stack([self._receptance(h, omega, rows, columns) for h in range(harmonics + 1)])
        return np.ascontiguousarray([blocks.real, blocks.imag])

    def _receptance(self, h: int, omega: float, rows: Rows, columns: Rows) -> Complex:
        state = self.states[h]
        gain, _ = state.gains(1j * h * omega, 1j * h)
        return (state.shape[rows] * gain) @ state.receiver[:, columns]

    def pulled(self, omega: float, weighted: Array, columns: Rows) -> Array:
        pull = complex_harmonics(weighted).conj()
        result = np.empty((columns.size, pull.shape[1]), dtype=complex)
        for h, state in enumerate(self.states):
            gain, _ = state.gains(1j * h * omega, 1j * h)
            result[:, h] = ((pull[:, h] @ state.shape) * gain) @ state.receiver[:, columns]
        return -real_harmonics(result.conj())

    def change(self, forces: Array, omega: float) -> Array:
        return real_harmonics(self._answered("shape", self._received(forces), omega))

    def whole_motion(self, forces: Array, omega: float, level: float) -> Array:
        received = self._received(forces)
        loads = [self.static[h] + level * self.dynamic[h] + received[h] for h in range(len(self.states))]
        return real_harmonics(self._answered("output", loads, omega))

    def whole_change(self, forces: Array, omega: float) -> Array:
        return real_harmonics(self._answered("output", self._received(forces), omega))

    def _received(self, forces: Array) -> list[Complex]:
        """How forces λ drive the states of each harmonic."""
        pushed = complex_harmonics(forces)
        return [-state.receiver @ pushed[:, h] for h, state in enumerate(self.states)]

    def _answered(self, place: str, loads: list[Complex], omega: float) -> Complex:
        """Motion of "shape" or "output" under the loads of the states, (.., H+1)."""
        gains = [state.gains(1j * h * omega, 1j * h)[0] for h, state in enumerate(self.states)]
        return np.stack([getattr(s, place) @ (g * p) for s, g, p in zip(self.states, gains, loads, strict=True)], axis=1)


def wave_sum(waves: Sequence[tuple[Complex, LinearSystem]]) -> WaveStates:
    """The states of all waves together: motion turn ⊗ z of the sectors for motion z of a wave."""
    parts = [(turn[:, None], wave_states(system)) for turn, system in waves]
    return WaveStates(
        np.hstack([np.kron(turn, part.output) for turn, part in parts]),
        np.vstack([np.kron(turn.conj().T, part.drive) for turn, part in parts]),
        np.hstack([part.shape for _, part in parts]),
        np.vstack([part.receiver for _, part in parts]),
        np.concatenate([part.p for _, part in parts]),
        np.concatenate([part.q for _, part in parts]),
    )


def wave_states(system: LinearSystem) -> WaveStates:
    """The decoupled states of one harmonic's structure; refused where the damping does not decouple accurately."""
    inverse_squares, shapes = linalg.eigh(system.M, system.K)
    squares = np.maximum(inverse_squares, 0.0)
    damping = shapes.conj().T @ system.C @ shapes
    diagonal = np.diag(damping)
    if np.abs(damping - np.diag(diagonal)).max(initial=0.0) <= DIAGONAL * np.abs(diagonal).max(initial=1e-300):
        return _seen(system, shapes, shapes.conj().T, diagonal, squares)
    poles, drive, output = _poles(squares, damping)
    return _seen(system, shapes @ output, drive @ shapes.conj().T, -poles, np.zeros(poles.size))


def _poles(squares: Array, damping: NDArray[Any]) -> tuple[Complex, Complex, Complex]:
    """η = output (1 − s pole)⁻¹ drive f of η + s c η + s² m η = f: from η = [0 I](I − s S)⁻¹[0; I] f, S = [[0, I], [−m, −c]]."""
    size = squares.size
    S = np.block([[np.zeros((size, size)), np.eye(size)], [-np.diag(squares), -damping]])
    poles, right = linalg.eig(S)
    if not np.linalg.cond(right) < CONDITION:
        raise InputError(
            "The damping of a disk must decouple into modes, but two of them are critically damped together. "
            "Use modal damping, or change C a little."
        )
    return poles, linalg.inv(right)[:, size:], right[size:]


def _seen(system: LinearSystem, output: NDArray[Any], drive: NDArray[Any], p: NDArray[Any], q: Array) -> WaveStates:
    shape, receiver = np.vstack([system.B, system.outputs]) @ output, drive @ system.B.conj().T
    output, drive, shape, receiver = (np.ascontiguousarray(part, dtype=complex) for part in (output, drive, shape, receiver))
    return WaveStates(output, drive, shape, receiver, p.astype(complex), q)
