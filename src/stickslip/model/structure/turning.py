"""K between two rotor speeds where the steady deformation turns parts of a blade.

The K of a program at speed is that of the deformed shape. A thin blade is soft across its plane and 10⁴ times as stiff in it, so
that a turn of one degree between two models makes K + share (K' − K) stiff where neither is: third frequency of a shrouded wheel
16 % too high. The motions with either K are therefore turned into each other first, as far as one is soft and the other stiff:
K' = W K″ Wᴴ, WᴴMW = M, and K = Wˢ (K + s (K″ − K)) W⁻ˢ. Without turn, W = 1, that is K + s (K' − K); changes of the soft motions
among themselves, as by stress stiffening, remain linear.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.structure.cyclic_reduction import hermitian
from stickslip.model.structure.modes import ROUNDING
from stickslip.support.checks import Array


@dataclass(frozen=True, eq=False)
class Turning:
    """back: from the eigenvectors of W to forces, (m, m); first, last: both K between these; angles of its eigenvalues, (m,)."""

    back: NDArray[Any]
    first: NDArray[Any]
    last: NDArray[Any]
    angles: Array

    @classmethod
    def between(cls, M: NDArray[Any], first: NDArray[Any], last: NDArray[Any]) -> "Turning":
        """From M, positive definite, and K at both ends.

        S = (K − cM)(K + cM)⁻¹ is −1 for motions much softer than c and 1 for stiffer ones, W the unitary factor of 1 + S'S: it
        takes soft motions into soft ones the shortest way. √c is the geometric mean of the lowest and the highest frequency.
        """
        L = linalg.cholesky(M, lower=True)
        one, other = (
            hermitian(linalg.solve_triangular(L, linalg.solve_triangular(L, K, lower=True).conj().T, lower=True))
            for K in (first, last)
        )
        values, vectors = linalg.eigh(one)
        c = np.sqrt(values[values > ROUNDING * values[-1]][0] * values[-1])
        soft = (vectors * ((values - c) / (values + c))) @ vectors.conj().T
        shift = c * np.eye(len(L))
        left, _, right = linalg.svd(np.eye(len(L)) + linalg.solve(other + shift, (other - shift) @ soft, assume_a="her"))
        W = left @ right
        turned, Q = linalg.eigh(hermitian(1j * linalg.solve(np.eye(len(L)) + W, np.eye(len(L)) - W)))  # tan(angle/2)
        angles = 2.0 * np.arctan(turned)
        phases = np.exp(1j * angles)
        return cls(L @ Q, Q.conj().T @ one @ Q, phases.conj()[:, None] * (Q.conj().T @ other @ Q) * phases, angles)

    def at(self, share: float) -> NDArray[Any]:
        """K at a share of the way."""
        by = self.back * np.exp(1j * share * self.angles)
        return np.asarray(hermitian(by @ (self.first + share * (self.last - self.first)) @ by.conj().T))
