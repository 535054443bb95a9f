"""Checks of large sparse matrices: square, finite, symmetric.

A structure whose matrices stay sparse: a finite-element model that its contacts reduce.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar
from weakref import WeakValueDictionary

import numpy as np
from scipy import sparse

from stickslip.model.structure.matrices import Structure, check_names
from stickslip.support.checks import LARGEST, Array, fault

Sparse = sparse.csc_array
_Compressed = TypeVar("_Compressed", sparse.csc_array, sparse.csr_array)
Report = Callable[[str], None]
"""Called with what is being done with a large matrix."""


def square_sparse(what: str, matrix: Any) -> Sparse:
    """`matrix`, dense or sparse, as a finite square (n, n)."""
    if np.ndim(matrix) != 2:
        raise fault(what, "must be a square matrix", np.shape(matrix), "Give as many rows as columns.")
    stored = sparse.coo_array(matrix)
    if stored.shape[0] != stored.shape[1]:
        raise fault(what, "must be a square matrix", stored.shape, "Give as many rows as columns.")
    wrong = np.flatnonzero(~np.isfinite(stored.data))
    if wrong.size:
        row, column = (indices[wrong[0]] for indices in stored.coords)
        raise fault(f"{what}[{row}, {column}]", "must be finite", float(stored.data[wrong[0]]))
    largest = float(np.max(np.abs(stored.data), initial=0.0))
    if largest > LARGEST:
        raise fault(what, f"must not be larger than {LARGEST:g} in size", largest, "Check its unit, and the file for damage.")
    return with_short_indices(stored.tocsc())


def with_short_indices(matrix: _Compressed) -> _Compressed:
    """A compressed matrix with indices of 32 bits where these suffice: a quarter less memory, and products a quarter faster."""
    if max(matrix.nnz, *matrix.shape) <= np.iinfo(np.int32).max:
        matrix.indices, matrix.indptr = (each.astype(np.int32, copy=False) for each in (matrix.indices, matrix.indptr))
    return matrix


_symmetric: WeakValueDictionary[int, Sparse] = WeakValueDictionary()
"""The matrices that `symmetric_sparse` returned, by their identity."""


def symmetric_sparse(what: str, matrix: Any, tolerance: float = 1e-8) -> Sparse:
    """`matrix` as a finite square equal to its transpose within `tolerance` of its largest entry; returned exactly symmetric.

    One that was returned is returned as it is: copies of structures check their matrices again.
    """
    known = _symmetric.get(id(matrix))
    if known is not None and known is matrix:
        return known
    stored = square_sparse(what, matrix)
    gap = sparse.coo_array(stored - stored.T)
    scale = float(np.max(np.abs(stored.data), initial=0.0))
    if gap.nnz and float(np.abs(gap.data).max()) > tolerance * scale:
        worst = int(np.abs(gap.data).argmax())
        row, column = sorted((int(gap.coords[0][worst]), int(gap.coords[1][worst])))
        raise fault(
            what,
            "must be symmetric",
            f"{what}[{row}, {column}] = {stored[row, column]:g} against {what}[{column}, {row}] = {stored[column, row]:g}",
            "Only one triangle stored? Fill the other; else check the export.",
        )
    stored = sparse.csc_array(0.5 * (stored + stored.T)) if gap.nnz else stored
    return _symmetric.setdefault(id(stored), stored)


def both_triangles(what: str, matrix: Any) -> Sparse:
    """The symmetric matrix of which `matrix` stores each pair of entries once, on either side of the diagonal."""
    stored = sparse.csc_array(matrix)
    twice = sparse.coo_array(sparse.tril(stored, -1).multiply(sparse.triu(stored, 1).T))
    if twice.nnz:
        row, column = (int(place[0]) + 1 for place in twice.coords)
        remedy = "A symmetric matrix stores one triangle; a whole one must be written as general (square)."
        raise fault(what, "must hold each entry once", f"row {row}, column {column} and its mirror image", remedy)
    return sparse.csc_array(stored + stored.T - sparse.diags_array(stored.diagonal()))


@dataclass(frozen=True, eq=False, repr=False)
class SparseStructure(Structure):
    """M q̈ + C q̇ + K q = p with sparse M and K (n, n), C by a damping rule alone.

    kept: the degrees of freedom whose motion a problem of this structure has to know, beside those that contacts and loads name.
    directions: coefficients (n,) of directions in which all of the structure moves, by names that a problem knows them by.
    """

    M: Any
    K: Any
    kept: tuple[str, ...] = field(default=(), kw_only=True)
    directions: Mapping[str, Array] = field(default_factory=dict, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "M", symmetric_sparse("M", self.M))
        object.__setattr__(self, "K", symmetric_sparse("K", self.K))
        check_names(self.dofs)
        for what, matrix in (("M", self.M), ("K", self.K)):
            if matrix.shape[0] != len(self.dofs):
                raise fault(what, f"must have the {len(self.dofs)} rows of dofs", matrix.shape)

    def rows(self, directions: Sequence[Mapping[str, float]]) -> Any:
        """The coefficients of several directions over the degrees of freedom, sparse, (len(directions), n)."""
        columns = [self.index(dof) for direction in directions for dof in direction]
        values = [value for direction in directions for value in direction.values()]
        at = np.repeat(np.arange(len(directions)), [len(direction) for direction in directions])
        return with_short_indices(sparse.csr_array((values, (at, columns)), shape=(len(directions), self.size), dtype=float))
