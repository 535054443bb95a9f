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

SOFT = 30.0
"""Times the lowest natural frequency up to which a motion is soft: across its plane a thin blade has several modes within 10
times the lowest; in its plane, 10⁴ times as stiff, they begin at 100 times. Stiffer kept rows do not count. Of a shrouded wheel
on 36 and on 216 coordinates, frequencies between two speeds are right to 0.03 %."""


@dataclass(frozen=True, eq=False)
class Turning:
    """back: from the eigenvectors of W to forces, (m, m); first, last: both K between these; angles of its eigenvalues, (m,);
    real: whether M and both K are."""

    back: NDArray[Any]
    first: NDArray[Any]
    last: NDArray[Any]
    angles: Array
    real: bool

    @classmethod
    def between(cls, M: NDArray[Any], first: NDArray[Any], last: NDArray[Any]) -> "Turning":
        """From M, positive definite, and K at both ends.

        S = (K² − c²M²)(K² + c²M²)⁻¹ in coordinates in which M = 1 is −1 for motions much softer than c and 1 for stiffer ones, W
        the unitary factor of 1 + S'S: it takes soft motions into soft ones the shortest way. √c is `SOFT` times the lowest
        frequency of both; a motion of negative stiffness is soft.
        """
        L = linalg.cholesky(M, lower=True)
        one, other = (
            hermitian(linalg.solve_triangular(L, linalg.solve_triangular(L, K, lower=True).conj().T, lower=True))
            for K in (first, last)
        )
        ends = [linalg.eigh(each) for each in (one, other)]
        lowest = [values[values > ROUNDING * abs(values[-1])][:1] for values, _ in ends]
        c = SOFT**2 * min([value for each in lowest for value in each], default=1.0)
        soft, its = (
            (vectors * (1.0 - 2.0 / (1.0 + (np.maximum(values, 0.0) / c) ** 2))) @ vectors.conj().T for values, vectors in ends
        )
        left, _, right = linalg.svd(np.eye(len(L)) + its @ soft)
        W = left @ right
        turned, Q = linalg.eigh(hermitian(1j * linalg.solve(np.eye(len(L)) + W, np.eye(len(L)) - W)))  # tan(angle/2)
        angles = 2.0 * np.arctan(turned)
        phases = np.exp(1j * angles)
        real = not any(np.imag(each).any() for each in (M, first, last))
        return cls(L @ Q, Q.conj().T @ one @ Q, phases.conj()[:, None] * (Q.conj().T @ other @ Q) * phases, angles, real)

    def at(self, share: float) -> NDArray[Any]:
        """K at a share of the way."""
        by = self.back * np.exp(1j * share * self.angles)
        K = hermitian(by @ (self.first + share * (self.last - self.first)) @ by.conj().T)
        return np.asarray(K.real if self.real else K)
