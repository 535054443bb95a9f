"""Sparse factors by SciPy's SuperLU, always available."""

from __future__ import annotations

import numpy as np
from scipy.sparse import linalg

from stickslip.checks import Array
from stickslip.structure.sparse import Sparse

SMALLEST_PIVOT = 1e-13
"""A pivot up to it is that of a singular matrix."""


class SuperLU:
    """The factor L U of a symmetric matrix (n, n) whose diagonal entries are ±1, pivots taken from the diagonal.

    negative: how many eigenvalues are below zero, by the signs of the pivots; weak: how many pivots are indistinguishable
    from zero; mebibytes: of the factor.
    """

    name = "SuperLU"

    def __init__(self, matrix: Sparse) -> None:
        settings = {"SymmetricMode": True}
        try:
            self._lu = linalg.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=settings)
        except RuntimeError as error:
            raise ArithmeticError(str(error)) from None
        pivots = self._lu.U.diagonal()
        self.negative = int(np.sum(pivots < 0.0))
        self.weak = int(np.sum(np.abs(pivots) <= SMALLEST_PIVOT))
        self.mebibytes = 12.0 * self._lu.nnz / 2**20
        """A number and an index for each entry."""

    def solve(self, loads: Array) -> Array:
        """A⁻¹ loads, for loads (n,) or (n, loads)."""
        return np.asarray(self._lu.solve(loads))
