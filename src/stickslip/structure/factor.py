"""One factorisation of a sparse symmetric matrix: solves with it, the signs of its pivots, the memory it takes."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from stickslip.checks import Array
from stickslip.structure.sparse import Sparse


class Singular(ValueError):
    """The matrix has no factor."""


class Factor:
    """A = D⁻¹ L U D⁻¹ of symmetric A (n, n), D scaling its diagonal to ±1, rows and columns in one order of little fill."""

    def __init__(self, matrix: Sparse) -> None:
        diagonal = np.abs(matrix.diagonal())
        if np.any(diagonal == 0.0):
            raise Singular("a row without a diagonal entry")
        self.scale = 1.0 / np.sqrt(diagonal)
        scaling = sparse.diags_array(self.scale)
        unit = sparse.csc_array(scaling @ matrix @ scaling)
        settings = {"SymmetricMode": True}
        try:
            self._lu = linalg.splu(unit, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=settings)
        except RuntimeError as error:
            raise Singular(str(error)) from None
        self.pivots: Array = self._lu.U.diagonal()

    @property
    def megabytes(self) -> float:
        """The memory of the factor, MiB: a number and an index for each entry."""
        return float(12.0 * self._lu.nnz / 2**20)

    def solve(self, loads: Array) -> Array:
        """A⁻¹ loads, for loads (n,) or (n, loads)."""
        scale = self.scale if loads.ndim == 1 else self.scale[:, None]
        return np.asarray(scale * self._lu.solve(scale * loads))
