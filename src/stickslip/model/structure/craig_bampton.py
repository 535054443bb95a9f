"""Craig-Bampton reduction: a large M, K with a few kept degrees of freedom becomes a small `Structure`.

Craig and Bampton (1968): interior motion = static modes of the kept (boundary) motion + fixed-interface modes. The static
response to loads on the kept degrees of freedom is exact with any number of modes; with all of them everything is exact.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse

from stickslip.model.structure.block_lanczos import eigenpairs_above
from stickslip.model.structure.factor import Factor, Singular, solver
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.sparse import Report, symmetric_sparse
from stickslip.support.checks import Array, InputError, fault

Progress = Callable[[float, str], None]

DENSE_SIZE = 400
"""Interior problems up to this size, or with more than half of their modes wanted, are solved densely."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """q_full = transformation @ q, with q the degrees of freedom of `structure`: kept ones first, then "mode/1.q", ...

    transformation: (full size, reduced size), for the recovery of motion and stress inside; frequencies: of the
    fixed-interface modes kept, Hz.
    """

    structure: Structure
    transformation: Array
    frequencies: Array


def craig_bampton(
    M: sparse.csc_array | Array,
    K: sparse.csc_array | Array,
    kept: Mapping[str, int],
    modes: int | None = None,
    progress: Progress = lambda share, text: None,
) -> Reduction:
    """The reduction of M, K (n, n; sparse or dense) with mass-normalised fixed-interface modes.

    kept: {"NODE.DIRECTION": row in M and K}; they must hold the body (interior stiffness positive definite).
    modes: number of fixed-interface modes, lowest first; None: all (dense; massless interior motions have none).
    progress(share, text) is called with what is being done and the memory that the factor takes.
    """
    stiffness, mass = symmetric_sparse("K", K), symmetric_sparse("M", M)
    size = stiffness.shape[0]
    if mass.shape != stiffness.shape:
        raise fault("M", f"must have the shape of K, {stiffness.shape}", mass.shape)
    names, boundary = list(kept), np.array(list(kept.values()), dtype=int)
    outside = boundary[(boundary < 0) | (boundary >= size)]
    if outside.size:
        raise fault("Rows of kept degrees of freedom", f"must lie between 0 and {size - 1}", outside.tolist())
    if np.unique(boundary).size < boundary.size:
        raise fault("Rows of kept degrees of freedom", "must be different", sorted(boundary.tolist()))
    interior = np.setdiff1d(np.arange(size), boundary)
    if modes is not None and not 0 <= modes <= interior.size:
        raise fault("modes", f"must lie between 0 and {interior.size}, the interior degrees of freedom", modes)
    progress(0.05, f"ordering the stiffness of {interior.size} rows for {solver(interior.size).name}")
    own = stiffness[interior][:, interior], mass[interior][:, interior]
    solve = _Interior(own[0], own[1], lambda text: progress(0.1, text))
    progress(0.3, f"static modes; the factor takes {solve.megabytes:.0f} MiB")
    static = -solve(stiffness[interior][:, boundary].toarray())
    progress(0.5, f"fixed-interface modes; the factor takes {solve.megabytes:.0f} MiB")
    squares, shapes = solve.modes(modes)
    progress(0.9, "projecting the matrices")
    T = np.zeros((size, boundary.size + squares.size))
    T[boundary, np.arange(boundary.size)] = 1.0
    T[interior] = np.hstack([static, shapes])
    # K of kept and modal coordinates has blocks that vanish or are diagonal by construction: they are written exactly.
    reduced = linalg.block_diag(_projected(stiffness, T[:, : boundary.size]), np.diag(squares))
    structure = Structure(_projected(mass, T), reduced, (*names, *mode_names(squares.size)))
    return Reduction(structure, T, np.sqrt(squares) / (2.0 * np.pi))


def mode_names(modes: int) -> tuple[str, ...]:
    """The names of the modal coordinates."""
    return tuple(f"mode/{index}.q" for index in range(1, modes + 1))


def _projected(matrix: sparse.csc_array, T: Array) -> Array:
    """TᵀAT of a symmetric matrix, exactly symmetric."""
    reduced = T.T @ (matrix @ T)
    return np.asarray(0.5 * (reduced + reduced.T))


class _Interior:
    """The body with its kept degrees of freedom held: solves K_ii x = b and finds its modes with one factorisation."""

    def __init__(self, K: sparse.csc_array, M: sparse.csc_array, report: Report) -> None:
        self.K, self.M = K, M
        if np.any(K.diagonal() <= 0.0):
            raise _not_held()
        if K.shape[0] == 0:
            return
        try:
            self.factor = Factor(K, report)
        except Singular:
            raise _not_held() from None
        if self.factor.negative or self.factor.weak:
            raise _not_held()

    @property
    def megabytes(self) -> float:
        """The memory of the factor, MiB."""
        return self.factor.megabytes if self.K.shape[0] else 0.0

    def __call__(self, loads: Array) -> Array:
        """K_ii⁻¹ loads, for loads (interior,) or (interior, loads)."""
        return self.factor.solve(loads) if self.K.shape[0] else loads

    def modes(self, number: int | None) -> tuple[Array, Array]:
        """ω² [1/s²], ascending, and mass-normalised shapes (interior, modes)."""
        size = self.K.shape[0]
        if size == 0 or number == 0:
            return np.zeros(0), np.zeros((size, 0))
        if number is None or size <= DENSE_SIZE or 2 * number > size:
            return self._dense_modes(number)
        squares, shapes = eigenpairs_above(self, self.M, number)
        return squares, _fixed_sign(shapes)

    def _dense_modes(self, number: int | None) -> tuple[Array, Array]:
        """From M φ = θ K φ with θ = 1/ω², so that massless motions (θ = 0) do no harm: they are left out."""
        inverse_squares, shapes = linalg.eigh(self.M.toarray(), self.K.toarray())
        with_mass = np.flatnonzero(inverse_squares > 1e-13 * inverse_squares[-1])[::-1][:number]
        inverse_squares = inverse_squares[with_mass]
        return 1.0 / inverse_squares, _fixed_sign(shapes[:, with_mass] / np.sqrt(inverse_squares))


def _fixed_sign(shapes: Array) -> Array:
    """Shapes whose largest entry is positive: the same on every machine."""
    largest = np.abs(shapes).argmax(axis=0)
    return np.asarray(shapes * np.sign(shapes[largest, np.arange(shapes.shape[1])]))


def _not_held() -> InputError:
    return InputError(
        "The interior stiffness of a Craig-Bampton reduction must be positive definite, but it is singular: with the kept "
        "degrees of freedom held, some motion stays free. Keep more of them, or check the supports and the mesh."
    )
