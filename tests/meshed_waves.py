"""Natural frequencies of a meshed sector by SuperLU and ARPACK, beside the factor and the block Lanczos method of the package."""

import numpy as np
from scipy.sparse import linalg


def cyclic_frequencies(sector, nodal_diameter, number):
    """The lowest natural frequencies of a nodal diameter of the meshed disk, Hz, without reduction."""
    M, K = sector.matrices(nodal_diameter)
    factor = linalg.splu(K, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    inverse = linalg.LinearOperator(K.shape, matvec=lambda load: factor.solve(load.astype(K.dtype)), dtype=K.dtype)
    start = np.random.default_rng(1).standard_normal(K.shape[0]).astype(K.dtype)
    squares = linalg.eigsh(K, number, M, sigma=0.0, OPinv=inverse, v0=start, return_eigenvectors=False)
    return np.sqrt(np.sort(np.maximum(squares.real, 0.0))) / (2.0 * np.pi)
