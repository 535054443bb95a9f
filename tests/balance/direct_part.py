"""The linear part without modes: the dynamic stiffness solved anew at every frequency. What the sums over states must equal."""

from __future__ import annotations

import numpy as np

from stickslip.model.problem import Problem
from stickslip.solve.balance.fourier import complex_harmonics, real_harmonics


class DirectPart:
    """Every question that `LinearPart` answers, by K' + i h ω C − h²ω² M of each harmonic."""

    def __init__(self, problem: Problem, harmonics: int) -> None:
        self.systems = [problem.systems.at(h) for h in range(harmonics + 1)]
        self.problem, self.harmonics = problem, harmonics

    def _solve(self, h: int, omega: float, right: np.ndarray) -> np.ndarray:
        system = self.systems[h]
        return np.linalg.solve(system.K + 1j * h * omega * system.C - (h * omega) ** 2 * system.M, right)

    def _pushed(self, forces: np.ndarray) -> list[np.ndarray]:
        """Bᴴλ of each harmonic."""
        return [s.B.conj().T @ f for s, f in zip(self.systems, complex_harmonics(forces).T, strict=True)]

    def _excited(self, omega: float) -> np.ndarray:
        """What one more force level adds to the loads."""
        return self.problem.load(self.harmonics, 1.0, omega) - self.problem.load(self.harmonics, 0.0, omega)

    def _excited_slope(self, omega: float) -> np.ndarray:
        """Its derivative by ω; a central difference is exact up to ω²."""
        step = 0.1 * omega
        return (self._excited(omega + step) - self._excited(omega - step)) / (2.0 * step)

    def _loads(self, forces: np.ndarray, omega: float, level: float) -> list[np.ndarray]:
        given = complex_harmonics(self.problem.load(self.harmonics, level, omega)).T
        return [load - push for load, push in zip(given, self._pushed(forces), strict=True)]

    def _q(self, loads: list[np.ndarray], omega: float) -> list[np.ndarray]:
        return [self._solve(h, omega, load) for h, load in enumerate(loads)]

    def _seen(self, q: list[np.ndarray]) -> np.ndarray:
        """Motion of contact rows and outputs in real storage."""
        rows = [np.vstack([s.B, s.outputs]) @ q_h for s, q_h in zip(self.systems, q, strict=True)]
        return real_harmonics(np.stack(rows, axis=1))

    def motion(self, forces: np.ndarray, omega: float, level: float) -> np.ndarray:
        return self._seen(self._q(self._loads(forces, omega, level), omega))

    def slope(self, forces: np.ndarray, omega: float, level: float, by_level: bool) -> np.ndarray:
        if by_level:
            return self._seen(self._q(list(complex_harmonics(self._excited(omega)).T), omega))
        q = self._q(self._loads(forces, omega, level), omega)
        turned = [(2.0 * h**2 * omega * s.M - 1j * h * s.C) @ q[h] for h, s in enumerate(self.systems)]
        loads = complex_harmonics(level * self._excited_slope(omega)).T
        return self._seen(self._q([a + b for a, b in zip(turned, loads, strict=True)], omega))

    def receptance(self, omega: float, harmonics: int, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        blocks = []
        for h, s in enumerate(self.systems[: harmonics + 1]):
            blocks.append(np.vstack([s.B, s.outputs])[rows] @ self._solve(h, omega, s.B[columns].conj().T.astype(complex)))
        return np.array([np.real(blocks), np.imag(blocks)])

    def pulled(self, omega: float, weighted: np.ndarray, columns: np.ndarray) -> np.ndarray:
        G = self.receptance(omega, (weighted.shape[1] - 1) // 2, np.arange(weighted.shape[0]), columns)
        pull = np.conj(complex_harmonics(weighted))
        return -real_harmonics(np.conj(np.einsum("rh,hrc->ch", pull, G[0] + 1j * G[1])))

    def change(self, forces: np.ndarray, omega: float) -> np.ndarray:
        return -self._seen(self._q(self._pushed(forces), omega))

    def whole_motion(self, forces: np.ndarray, omega: float, level: float) -> np.ndarray:
        return real_harmonics(np.stack(self._q(self._loads(forces, omega, level), omega), axis=1))
