"""Factorisation of a sparse symmetric matrix: solutions, inertia and memory.

MKL PARDISO does it for large matrices, where it is installed; SciPy's SuperLU, which is always there, for small ones and
elsewhere. The package pymetis orders the rows of SuperLU where wheels of it exist; without it large factors fill up.
"""

from importlib import import_module, util
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg

from stickslip.model.structure import pardiso
from stickslip.model.structure.matrices import Report, Sparse
from stickslip.model.structure.pardiso import Pardiso, advice
from stickslip.support.checks import Array, Index

METIS = "pymetis"
LARGE = 3000
"""Rows from which the faster solver is worth its start, and a better order of the rows its time."""
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

    def again(self, matrix: Sparse) -> "SuperLU":
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
    if util.find_spec(METIS) is None:
        return None
    metis = import_module(METIS)
    graph = sparse.csr_array(matrix)
    graph.setdiag(0.0)
    graph.eliminate_zeros()
    adjacency = metis.CSRAdjacency(adj_starts=graph.indptr.astype(np.int32), adjacent=graph.indices.astype(np.int32))
    order, _ = metis.nested_dissection(adjacency)
    return np.asarray(order, dtype=np.int64)


class Singular(ValueError):
    """The matrix has no factor."""


def solver(rows: int) -> type[SuperLU | Pardiso]:
    """What factorises a matrix of so many rows."""
    return Pardiso if rows >= LARGE and pardiso.usable() else SuperLU


class Factor:
    """A = D⁻¹ F D⁻¹ of symmetric A (n, n), D scaling its diagonal to ±1 and F factorised in an order of little fill.

    negative: how many eigenvalues of A are below zero; weak: how many pivots of F are indistinguishable from zero, so that A
    is singular; megabytes: the memory of the factor, MiB. report(text) is called with what is being done, for large matrices.
    diagonal (n,): what D scales instead, where that of A has small entries. earlier: the factor of a matrix with entries at the
    same places, whose order is taken over and which is lost.
    """

    def __init__(
        self, matrix: Sparse, report: Report = lambda text: None, diagonal: Array | None = None, earlier: "Factor | None" = None
    ) -> None:
        diagonal = np.abs(matrix.diagonal()) if diagonal is None else diagonal
        if np.any(diagonal == 0.0):
            raise Singular("a row without a diagonal entry")
        self.scale = 1.0 / np.sqrt(diagonal)
        entries = matrix.data * self.scale[matrix.indices] * np.repeat(self.scale, np.diff(matrix.indptr))
        scaled = sparse.csc_array((entries, matrix.indices, matrix.indptr), shape=matrix.shape)
        try:
            made = solver(matrix.shape[0])(scaled, report) if earlier is None else earlier._factor.again(scaled)
        except ArithmeticError as error:
            raise Singular(str(error)) from None
        self._factor: SuperLU | Pardiso = made
        self.negative, self.weak, self.megabytes = made.negative, made.weak, made.mebibytes

    def solve(self, loads: Array) -> Array:
        """A⁻¹ loads, for loads (n,) or (n, loads)."""
        scale = self.scale if loads.ndim == 1 else self.scale[:, None]
        return np.asarray(scale * self._factor.solve(scale * loads))


class Pencil:
    """K − σM of Hermitian K and M (n, n), real or complex, with the factor at one shift σ after another, in one order of rows.

    Complex S + iW is factorised as the real symmetric [[S, −W], [W, S]], which has every eigenvalue twice. negative, weak,
    megabytes: those of `Factor` at the last shift, of the complex matrix itself.
    """

    def __init__(self, K: Any, M: Any, report: Report = lambda text: None) -> None:
        self.K, self.M, self.report = K, M, report
        self.complex = np.iscomplexobj(K) or np.iscomplexobj(M)
        # The sum has an entry where either of the two has one.
        both = sparse.csc_array(_real(K, self.complex) + 1j * _real(M, self.complex))
        both.sort_indices()
        self._places = both.indices, both.indptr
        self._stiffness, self._mass = both.data.real.copy(), both.data.imag.copy()
        self._diagonals = np.abs(both.diagonal().real), np.abs(both.diagonal().imag)
        self._factor: Factor | None = None
        self.negative, self.weak, self.megabytes = 0, 0, 0.0

    def at(self, shift: float) -> "Pencil":
        """Itself with the factor of K − σM; `Singular` where there is none."""
        own, mass = self._diagonals
        entries = self._stiffness - shift * self._mass
        shifted = sparse.csc_array((entries, *self._places), shape=(own.size, own.size))
        self._factor = Factor(shifted, self.report, own + abs(shift) * mass, self._factor)
        self.megabytes = self._factor.megabytes
        self.negative, odd = divmod(self._factor.negative, 2) if self.complex else (self._factor.negative, 0)
        self.weak = self._factor.weak + odd  # rounding alone gives one of two equal eigenvalues another sign
        return self

    def solve(self, loads: NDArray[Any]) -> NDArray[Any]:
        """(K − σM)⁻¹ loads, for loads (n,) or (n, loads)."""
        assert self._factor is not None
        if not self.complex:
            return self._factor.solve(loads)
        both = self._factor.solve(np.concatenate([loads.real, loads.imag]))
        size = self.K.shape[0]
        return np.asarray(both[:size] + 1j * both[size:])


def _real(matrix: Any, double: bool) -> Sparse:
    """A Hermitian S + iW as the real symmetric [[S, −W], [W, S]]; unless it is to be double, a real one as it is."""
    if not double:
        return sparse.csc_array(matrix)
    return sparse.csc_array(sparse.block_array(((matrix.real, -matrix.imag), (matrix.imag, matrix.real))))
