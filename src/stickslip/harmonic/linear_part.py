"""The linear part of the balance behind one door: motion under loads and λ, receptance columns, the whole structure's motion.

`ModalPart` wherever the structure decouples, `DirectPart` where it does not (critical damping), `PhasedPart` where the harmonics
see different structures (cyclic symmetry).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.checks import Array
from stickslip.harmonic.fourier import complex_harmonics, real_harmonics
from stickslip.harmonic.phased_part import PhasedPart
from stickslip.harmonic.receptance import Modes, States, motion, pulled, receptance, states
from stickslip.problem import Problem

Rows = NDArray[np.int64]


class LinearPart(Protocol):
    """What the balance asks of the linear structure."""

    def motion(self, forces: Array, omega: float, level: float, w: Array, by_omega: Array, by_level: Array) -> None:
        """Fill the motion of contact rows and outputs and its derivatives; forces λ (rows, 2H+1)."""

    def receptance(self, omega: float, harmonics: int, rows: Rows, columns: Rows) -> Array:
        """G' (2, H+1, rows, columns), real and imaginary part."""

    def pulled(self, omega: float, weighted: Array, columns: Rows) -> Array:
        """−weightedᵀ G' (columns, 2H+1) for weights on the motion (rows, 2H+1)."""

    def change(self, forces: Array, omega: float) -> Array:
        """Change of motion −G'δλ (rows, 2H+1) for a change of forces δλ."""

    def whole_motion(self, forces: Array, omega: float, level: float) -> Array:
        """q of every degree of freedom (n, 2H+1), m."""

    def whole_change(self, forces: Array, omega: float) -> Array:
        """Change of q (n, 2H+1) for a change of forces δλ."""


def linear_part(problem: Problem, harmonics: int) -> LinearPart:
    """The cheapest linear part that is accurate for this problem."""
    if problem.differs_by_harmonic or problem.falls_apart:
        return PhasedPart(problem, harmonics)
    try:
        decoupled = states(problem.structure.M, problem.C, problem.stuck_stiffness)
    except linalg.LinAlgError:
        return DirectPart(problem, harmonics)
    return ModalPart(problem, harmonics, decoupled)


def motion_rows(problem: Problem) -> Array:
    """Rows of everything the balance watches: contact rows, then outputs."""
    return np.ascontiguousarray(np.vstack([problem.B, problem.output_rows]))


class ModalPart:
    """Sums over decoupled states."""

    def __init__(self, problem: Problem, harmonics: int, decoupled: States) -> None:
        static, full = problem.load(harmonics, 0.0), problem.load(harmonics, 1.0)
        self.decoupled = decoupled
        self.modes = Modes(
            shape=np.ascontiguousarray(motion_rows(problem) @ decoupled.output),
            receiver=np.ascontiguousarray(problem.B @ decoupled.input),
            static=np.ascontiguousarray(decoupled.input.T @ static),
            dynamic=np.ascontiguousarray(decoupled.input.T @ (full - static)),
            kind=decoupled.kind,
            p=decoupled.p,
            q=decoupled.q,
        )
        self._unloaded = self.modes._replace(static=0.0 * self.modes.static, dynamic=0.0 * self.modes.dynamic)

    def motion(self, forces: Array, omega: float, level: float, w: Array, by_omega: Array, by_level: Array) -> None:
        motion(self.modes, forces, omega, level, w, by_omega, by_level)

    def receptance(self, omega: float, harmonics: int, rows: Rows, columns: Rows) -> Array:
        return receptance(self.modes, omega, harmonics, rows, columns)

    def pulled(self, omega: float, weighted: Array, columns: Rows) -> Array:
        return pulled(self.modes, omega, weighted, columns)

    def change(self, forces: Array, omega: float) -> Array:
        w, by_omega, by_level = (np.empty((self.modes.shape.shape[0], forces.shape[1])) for _ in range(3))
        motion(self._unloaded, forces, omega, 0.0, w, by_omega, by_level)
        return w

    def whole_motion(self, forces: Array, omega: float, level: float) -> Array:
        return self._whole(self.modes, forces, omega, level)

    def whole_change(self, forces: Array, omega: float) -> Array:
        return self._whole(self._unloaded, forces, omega, 0.0)

    def _whole(self, modes: Modes, forces: Array, omega: float, level: float) -> Array:
        shape = (self.decoupled.output.shape[0], forces.shape[1])
        q, by_omega, by_level = np.empty(shape), np.empty(shape), np.empty(shape)
        motion(modes._replace(shape=self.decoupled.output), forces, omega, level, q, by_omega, by_level)
        return q


class DirectPart:
    """The dynamic stiffness factorised anew at every frequency."""

    def __init__(self, problem: Problem, harmonics: int) -> None:
        structure = problem.structure
        self.M, self.C, self.B, self.shape = structure.M, problem.C, problem.B, motion_rows(problem)
        self.static = problem.load(harmonics, 0.0)
        self.dynamic = problem.load(harmonics, 1.0) - self.static

        @lru_cache(maxsize=4 * harmonics + 4)
        def factors(harmonic: int, omega: float) -> Any:
            s = 1j * harmonic * omega
            return linalg.lu_factor(s * s * structure.M + s * problem.C + problem.stuck_stiffness)

        self._factors = factors

    def _slope(self, harmonic: int, omega: float) -> NDArray[np.complex128]:
        """Derivative of the dynamic stiffness of a harmonic by ω."""
        return np.asarray(-2.0 * harmonic**2 * omega * self.M + 1j * harmonic * self.C)

    def _solve(self, load: Array, omega: float) -> NDArray[np.complex128]:
        """q (n, H+1) complex under loads in real storage (n, 2H+1)."""
        right = complex_harmonics(load)
        return np.stack([linalg.lu_solve(self._factors(h, omega), right[:, h]) for h in range(right.shape[1])], axis=1)

    def motion(self, forces: Array, omega: float, level: float, w: Array, by_omega: Array, by_level: Array) -> None:
        q = self._solve(self.static + level * self.dynamic - self.B.T @ forces, omega)
        slopes = [linalg.lu_solve(self._factors(h, omega), self._slope(h, omega) @ q[:, h]) for h in range(q.shape[1])]
        w[:] = self.shape @ real_harmonics(q)
        by_omega[:] = -self.shape @ real_harmonics(np.stack(slopes, axis=1))
        by_level[:] = self.shape @ real_harmonics(self._solve(self.dynamic, omega))

    def receptance(self, omega: float, harmonics: int, rows: Rows, columns: Rows) -> Array:
        right = self.B[columns].T.astype(complex)
        blocks = [self.shape[rows] @ linalg.lu_solve(self._factors(h, omega), right) for h in range(harmonics + 1)]
        return np.ascontiguousarray([np.real(blocks), np.imag(blocks)])

    def pulled(self, omega: float, weighted: Array, columns: Rows) -> Array:
        harmonics = (weighted.shape[1] - 1) // 2
        G = self.receptance(omega, harmonics, np.arange(self.shape.shape[0]), columns)
        pull = np.conj(complex_harmonics(weighted))
        return -real_harmonics(np.conj(np.einsum("rh,hrc->ch", pull, G[0] + 1j * G[1])))

    def change(self, forces: Array, omega: float) -> Array:
        return -self.shape @ real_harmonics(self._solve(self.B.T @ forces, omega))

    def whole_motion(self, forces: Array, omega: float, level: float) -> Array:
        return real_harmonics(self._solve(self.static + level * self.dynamic - self.B.T @ forces, omega))

    def whole_change(self, forces: Array, omega: float) -> Array:
        return -real_harmonics(self._solve(self.B.T @ forces, omega))
