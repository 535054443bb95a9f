"""Sparse factors by SciPy's SuperLU, always available, with rows in the order of METIS.

The package pymetis is installed where wheels of it exist; elsewhere SuperLU orders by itself, and large factors fill up.
"""

from __future__ import annotations

from importlib import import_module, util
from typing import Any, Literal

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from stickslip.model.structure.pardiso import advice
from stickslip.model.structure.sparse import Report, Sparse
from stickslip.support.checks import Array, Index

PACKAGE = "pymetis"
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
        self._factorise(matrix)

    def again(self, matrix: Sparse) -> SuperLU:
        """Itself with the factor of another matrix with entries at the same places, in the same order."""
        self._factorise(matrix)
        return self

    def _factorise(self, matrix: Sparse) -> None:
        try:
            if self._order is None:
                self._lu = _factor(matrix)
            else:
                self._lu = _factor(sparse.csc_array(matrix[self._order][:, self._order]), "NATURAL")
        except RuntimeError as error:
            raise ArithmeticError(str(error)) from None
        if not np.array_equal(self._lu.perm_r, self._lu.perm_c):
            raise ArithmeticError("a pivot of zero on the diagonal")  # signs of pivots off it would say nothing
        pivots = self._lu.U.diagonal()
        self.negative = int(np.sum(pivots < 0.0))
        self.weak = int(np.sum(np.abs(pivots) <= SMALLEST_PIVOT))
        self.mebibytes = 12.0 * self._lu.nnz / 2**20
        """A number and an index for each entry."""

    def solve(self, loads: Array) -> Array:
        """A⁻¹ loads, for loads (n,) or (n, loads)."""
        if self._order is None:
            return np.asarray(self._lu.solve(loads))
        solution = np.empty_like(loads, dtype=float)
        solution[self._order] = self._lu.solve(loads[self._order])
        return solution


def _factor(matrix: Sparse, order: Literal["NATURAL", "MMD_AT_PLUS_A"] = "MMD_AT_PLUS_A") -> Any:
    """SciPy's factor with pivots from the diagonal."""
    return linalg.splu(matrix, permc_spec=order, diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def nested_dissection(matrix: Sparse) -> Index | None:
    """The rows in the order of elimination, (n,); None without the package.

    Separators of the graph of the matrix come last, those of its parts before them, and so on: A. George, SIAM Journal on
    Numerical Analysis 10 (1973) 345. In three dimensions the factor has O(n^(4/3)) entries.
    """
    if util.find_spec(PACKAGE) is None:
        return None
    metis = import_module(PACKAGE)
    graph = sparse.csr_array(matrix)
    graph.setdiag(0.0)
    graph.eliminate_zeros()
    adjacency = metis.CSRAdjacency(adj_starts=graph.indptr.astype(np.int32), adjacent=graph.indices.astype(np.int32))
    order, _ = metis.nested_dissection(adjacency)
    return np.asarray(order, dtype=np.int64)
