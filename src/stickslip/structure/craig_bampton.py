"""Craig-Bampton reduction: a large M, K with a few kept degrees of freedom becomes a small `Structure`.

Craig and Bampton (1968): interior motion = static modes of the kept (boundary) motion + fixed-interface modes. The static
response to loads on the kept degrees of freedom is exact with any number of modes; with all of them everything is exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse
from scipy.sparse import linalg as sparse_linalg

from stickslip.checks import Array, InputError, fault
from stickslip.structure.matrices import Structure

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
    M: sparse.csc_array | Array, K: sparse.csc_array | Array, kept: Mapping[str, int], modes: int | None = None
) -> Reduction:
    """The reduction of M, K (n, n; sparse or dense) with mass-normalised fixed-interface modes.

    kept: {"NODE.DIRECTION": row in M and K}; they must hold the body (interior stiffness positive definite).
    modes: number of fixed-interface modes, lowest first; None: all (dense; massless interior motions have none).
    """
    stiffness, mass = _matrix("K", K), _matrix("M", M)
    size = stiffness.shape[0]
    if mass.shape != stiffness.shape:
        raise fault("M", f"must have the shape of K, {stiffness.shape}", mass.shape)
    names, boundary = list(kept), np.array(list(kept.values()), dtype=int)
    _check_kept(boundary, size)
    interior = np.setdiff1d(np.arange(size), boundary)
    if modes is not None and not 0 <= modes <= interior.size:
        raise fault("modes", f"must lie between 0 and {interior.size}, the interior degrees of freedom", modes)
    solve = _Interior(stiffness[interior][:, interior], mass[interior][:, interior])
    static = -solve(stiffness[interior][:, boundary].toarray())
    squares, shapes = solve.modes(modes)
    T = np.zeros((size, boundary.size + squares.size))
    T[boundary, np.arange(boundary.size)] = 1.0
    T[interior] = np.hstack([static, shapes])
    dofs = (*names, *(f"mode/{index}.q" for index in range(1, squares.size + 1)))
    structure = Structure(_reduced(mass, T), _reduced_stiffness(stiffness, T, squares), dofs)
    return Reduction(structure, T, np.sqrt(squares) / (2.0 * np.pi))


def _matrix(what: str, matrix: sparse.csc_array | Array) -> sparse.csc_array:
    """The matrix in sparse form; refused unless square, finite and symmetric."""
    stored = sparse.csc_array(matrix)
    if stored.shape[0] != stored.shape[1]:
        raise fault(what, "must be a square matrix", stored.shape)
    if not np.all(np.isfinite(stored.data)):
        raise fault(what, "must be finite", f"NaN or infinite in {int(np.sum(~np.isfinite(stored.data)))} entries")
    asymmetry, scale = abs(stored - stored.T).max(), abs(stored).max()
    if asymmetry > 1e-8 * scale:
        remedy = "Only one triangle stored? Fill the other; else check the export."
        raise fault(what, "must be symmetric", f"unsymmetric by {asymmetry:.3g} of up to {scale:.3g}", remedy)
    return stored


def _check_kept(boundary: Array, size: int) -> None:
    outside = boundary[(boundary < 0) | (boundary >= size)]
    if outside.size:
        raise fault("Rows of kept degrees of freedom", f"must lie between 0 and {size - 1}", outside.tolist())
    if np.unique(boundary).size < boundary.size:
        raise fault("Rows of kept degrees of freedom", "must be different", sorted(boundary.tolist()))


def _reduced(matrix: sparse.csc_array, T: Array) -> Array:
    reduced = T.T @ (matrix @ T)
    return np.asarray(0.5 * (reduced + reduced.T))


def _reduced_stiffness(stiffness: sparse.csc_array, T: Array, squares: Array) -> Array:
    """TᵀKT, with the blocks that vanish or are diagonal by construction written exactly."""
    kept = T.shape[1] - squares.size
    K = np.zeros((T.shape[1], T.shape[1]))
    K[:kept, :kept] = _reduced(stiffness, T[:, :kept])
    K[kept:, kept:] = np.diag(squares)
    return K


class _Interior:
    """The body with its kept degrees of freedom held: solves K_ii x = b and finds its modes with one factorisation."""

    def __init__(self, K: sparse.csc_array, M: sparse.csc_array) -> None:
        self.K, self.M = K, M
        diagonal = K.diagonal()
        if np.any(diagonal <= 0.0):
            raise _not_held()
        self.scale = 1.0 / np.sqrt(diagonal)
        if K.shape[0] == 0:
            return
        unit = sparse.csc_array(sparse.diags_array(self.scale) @ K @ sparse.diags_array(self.scale))
        try:
            self.factor = sparse_linalg.splu(
                unit, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError:
            raise _not_held() from None
        if np.any(self.factor.U.diagonal() <= 1e-13):
            raise _not_held()

    def __call__(self, loads: Array) -> Array:
        """K_ii⁻¹ loads, for loads (interior,) or (interior, loads)."""
        if self.K.shape[0] == 0:
            return loads
        scale = self.scale if loads.ndim == 1 else self.scale[:, None]
        return np.asarray(scale * self.factor.solve(scale * loads))

    def modes(self, number: int | None) -> tuple[Array, Array]:
        """ω² [1/s²], ascending, and mass-normalised shapes (interior, modes)."""
        size = self.K.shape[0]
        if size == 0 or number == 0:
            return np.zeros(0), np.zeros((size, 0))
        if number is None or size <= DENSE_SIZE or 2 * number > size:
            return self._dense_modes(number)
        inverse = sparse_linalg.LinearOperator(self.K.shape, matvec=self, dtype=float)
        start = np.random.default_rng(1).standard_normal(size)
        squares, shapes = sparse_linalg.eigsh(self.K, number, self.M, sigma=0.0, OPinv=inverse, v0=start)
        order = np.argsort(squares)
        return squares[order], _fixed_sign(shapes[:, order])

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
