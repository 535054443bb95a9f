"""Craig-Bampton reduction: a large M, K with a few kept degrees of freedom becomes a small `Structure`.

Craig and Bampton (1968): interior motion = static modes of the kept (boundary) motion + fixed-interface modes. The static
response to loads on the kept degrees of freedom is exact with any number of modes; with all of them everything is exact.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse

from stickslip.model.structure.complete_modes import ModeCount, held_modes
from stickslip.model.structure.factor import Pencil, Singular, solver
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.sparse import symmetric_sparse
from stickslip.support.checks import Array, InputError, fault

Progress = Callable[[float, str], None]


@dataclass(frozen=True, eq=False)
class Reduction:
    """q_full = transformation @ q, with q the degrees of freedom of `structure`: kept ones first, then "mode/1.q", ...

    transformation: (full size, reduced size), for the recovery of motion and stress inside; frequencies: of the
    fixed-interface modes kept, Hz; count: how many of those there are these are. beyond: (full size, k), what given loads
    deform beyond `transformation`.
    """

    structure: Structure
    transformation: Array
    frequencies: Array
    count: ModeCount
    beyond: Array


def craig_bampton(
    M: sparse.csc_array | Array,
    K: sparse.csc_array | Array,
    kept: Mapping[str, int],
    modes: int | None = None,
    progress: Progress = lambda share, text: None,
    loads: Array | None = None,
) -> Reduction:
    """The reduction of M, K (n, n; sparse or dense) with mass-normalised fixed-interface modes.

    kept: {"NODE.DIRECTION": row in M and K}; they must hold the body (interior stiffness positive definite).
    modes: number of fixed-interface modes, lowest first, with those equal to the last of them; None: all (dense; massless
    interior motions have none).
    progress(share, text) is called with what is being done and the memory that the factor takes. loads (n, k): static ones on
    the whole body, whose motion the modes describe in part: (K_ii⁻¹ − Φ Λ⁻¹ Φᵀ) p_i is what they lack.
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
    body = Pencil(stiffness[interior][:, interior], mass[interior][:, interior], lambda text: progress(0.1, text))
    acting = np.zeros((size, 0)) if loads is None else loads
    static = np.hstack([-stiffness[interior][:, boundary].toarray(), acting[interior]])
    if interior.size:
        _hold(body)
        memory = f"the factor takes {body.megabytes:.0f} MiB"
        progress(0.3, f"static modes; {memory}")
        static = body.solve(static)
        progress(0.5, f"fixed-interface modes; {memory}")
    found = held_modes(body, modes)
    squares, shapes = found.squares, found.shapes
    progress(0.9, "projecting the matrices")
    T = np.zeros((size, boundary.size + squares.size))
    T[boundary, np.arange(boundary.size)] = 1.0
    T[interior] = np.hstack([static[:, : boundary.size], shapes])
    beyond = np.zeros_like(acting)
    beyond[interior] = static[:, boundary.size :] - shapes @ ((shapes.T @ acting[interior]) / squares[:, None])
    # K of kept and modal coordinates has blocks that vanish or are diagonal by construction: they are written exactly.
    reduced = linalg.block_diag(_projected(stiffness, T[:, : boundary.size]), np.diag(squares))
    structure = Structure(_projected(mass, T), reduced, (*names, *mode_names(squares.size)))
    return Reduction(structure, T, np.sqrt(squares) / (2.0 * np.pi), found.count, beyond)


def mode_names(modes: int) -> tuple[str, ...]:
    """The names of the modal coordinates."""
    return tuple(f"mode/{index}.q" for index in range(1, modes + 1))


def _projected(matrix: sparse.csc_array, T: Array) -> Array:
    """TᵀAT of a symmetric matrix, exactly symmetric."""
    reduced = T.T @ (matrix @ T)
    return np.asarray(0.5 * (reduced + reduced.T))


def _hold(body: Pencil) -> None:
    """The factor of the body with its kept degrees of freedom held, which must be positive definite."""
    if np.any(body.K.diagonal() <= 0.0):
        raise _not_held()
    try:
        body.at(0.0)
    except Singular:
        raise _not_held() from None
    if body.negative or body.weak:
        raise _not_held()


def _not_held() -> InputError:
    return InputError(
        "The interior stiffness of a Craig-Bampton reduction must be positive definite, but it is singular: with the kept "
        "degrees of freedom held, some motion stays free. Keep more of them, or check the supports and the mesh."
    )
