"""Order of the rows of a sparse symmetric matrix in which its factor has little fill: nested dissection by METIS.

The package pymetis is installed where wheels of it exist; elsewhere the factorisers order by themselves.
"""

from __future__ import annotations

from importlib import import_module, util

import numpy as np
from scipy import sparse

from stickslip.model.structure.sparse import Sparse
from stickslip.support.checks import Index

PACKAGE = "pymetis"


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
