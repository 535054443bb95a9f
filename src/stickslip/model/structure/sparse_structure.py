"""A structure whose matrices stay sparse: a finite-element model that its contacts reduce."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.structure.matrices import Structure, check_names
from stickslip.model.structure.sparse import symmetric_sparse, with_short_indices
from stickslip.support.checks import Array, fault


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
