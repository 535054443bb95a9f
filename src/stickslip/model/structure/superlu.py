"""Sparse factors by SciPy's SuperLU, always available."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from stickslip.model.structure.ordering import nested_dissection
from stickslip.model.structure.pardiso import advice
from stickslip.model.structure.sparse import Report, Sparse
from stickslip.support.checks import Array, Index

LARGE = 3000
"""Rows from which a better order is worth its time."""

SMALLEST_PIVOT = 1e-13
"""A pivot up to it is that of a singular matrix."""


class SuperLU:
    """The factor L U of a symmetric matrix (n, n) whose diagonal entries are ±1, pivots taken from the diagonal.

    negative: how many eigenvalues are below zero, by the signs of the pivots; weak: how many pivots are indistinguishable
    from zero; mebibytes: of the factor. Large matrices are ordered by nested dissection, where METIS is installed.
    """

    name = "SuperLU"

    def __init__(self, matrix: Sparse, report: Report = lambda text: None) -> None:
        large = matrix.shape[0] >= LARGE
        report(f"factorising the stiffness of {matrix.shape[0]} rows by {self.name}{advice() if large else ''}")
        self._order = nested_dissection(matrix) if large else None
        try:
            self._lu = _factor(matrix) if self._order is None else _factor(_ordered(matrix, self._order), "NATURAL")
        except RuntimeError as error:
            raise ArithmeticError(str(error)) from None
        pivots = self._lu.U.diagonal()
        self.negative = int(np.sum(pivots < 0.0))
        self.weak = int(np.sum(np.abs(pivots) <= SMALLEST_PIVOT))
        self.mebibytes = 12.0 * self._lu.nnz / 2**20
        """A number and an index for each entry."""

    def solve(self, loads: Array) -> Array:
        """A⁻¹ loads, for loads (n,) or (n, loads)."""
        if self._order is None:
            return np.asarray(self._lu.solve(loads))
        found = np.empty_like(loads, dtype=float)
        found[self._order] = self._lu.solve(loads[self._order])
        return found


def _ordered(matrix: Sparse, order: Index) -> Sparse:
    """The matrix with its rows and columns in an order."""
    return sparse.csc_array(matrix[order][:, order])


def _factor(matrix: Sparse, order: Literal["NATURAL", "MMD_AT_PLUS_A"] = "MMD_AT_PLUS_A") -> Any:
    return linalg.splu(matrix, permc_spec=order, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
