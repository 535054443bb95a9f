"""Lowest modes of a large free or held body by shift and invert, with a count of eigenvalues below the shift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from stickslip.checks import SMALLEST, Array
from stickslip.structure.factor import Factor, Singular
from stickslip.structure.modes import natural_modes
from stickslip.structure.sparse import Sparse

DENSE_SIZE = 400
RIGID = 1e-11
"""ω² below this share of the largest K_ii/M_ii is that of a rigid motion: rounding leaves no more of it."""
SHIFT = -1e-7
"""The shift, as a share of the same: rigid motions stay well away from it, so that they do not spoil the others."""


@dataclass(frozen=True)
class LowestModes:
    """squares: the lowest ω² [1/s²], ascending, 0 for rigid motions; rigid: how many of these; negative: motions of negative
    stiffness; megabytes: of the factor."""

    squares: Array
    rigid: int
    negative: int
    megabytes: float = 0.0

    @property
    def frequencies(self) -> Array:
        """Hz; 0 for rigid motions and those of negative stiffness."""
        return np.asarray(np.sqrt(np.maximum(self.squares, 0.0)) / (2.0 * np.pi))


def lowest_modes(M: Sparse, K: Sparse, number: int = 10) -> LowestModes | None:
    """The lowest `number` modes of symmetric K and M (n, n), M without negative eigenvalue; None where K − σM has no factor."""
    mass = M.diagonal()
    heavy = mass > SMALLEST
    highest = float(np.max(np.abs(K.diagonal()[heavy]) / mass[heavy], initial=0.0))
    if M.shape[0] <= DENSE_SIZE:
        squares, below, size = natural_modes(M.toarray(), K.toarray()).squares, 0, 0.0
    else:
        try:
            squares, below, size = _above(SHIFT * highest, M, K, number)
        except Singular:
            return None
    rigid = np.abs(squares) <= RIGID * highest
    negative = below + int(np.sum((squares < 0.0) & ~rigid))
    return LowestModes(np.where(rigid, 0.0, squares)[:number], int(np.sum(rigid)), negative, size)


def _above(shift: float, M: Sparse, K: Sparse, number: int) -> tuple[Array, int, float]:
    """The lowest ω² above `shift`, how many lie below it (the negative eigenvalues of K − shift M), and the MiB of the factor."""
    factor = Factor(sparse.csc_array(K - shift * M))
    inverse = linalg.LinearOperator(K.shape, matvec=factor.solve, dtype=float)
    start = np.random.default_rng(1).standard_normal(K.shape[0])
    squares = linalg.eigsh(K, number, M, sigma=shift, which="LA", OPinv=inverse, v0=start, return_eigenvectors=False)
    return np.sort(squares), factor.negative, factor.megabytes
