"""Reduction of a sector for each nodal diameter by itself: sparse, for faces of any number of nodes, matching or not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

from stickslip.model.structure.block_lanczos import eigenpairs_above
from stickslip.model.structure.craig_bampton import DENSE_SIZE
from stickslip.model.structure.cyclic_reduction import Sector, hermitian, refuse_on_faces
from stickslip.model.structure.factor import HermitianFactor, Singular
from stickslip.support.checks import Array, Index, InputError, fault

Progress = Callable[[float, str], None]


class ReducedWave(NamedTuple):
    """One nodal diameter on its kept and modal coordinates: M, K (m, m), motion of the whole sector from them (n, m), and ω² of
    the fixed-interface modes [1/s²], (modes,).
    """

    M: NDArray[Any]
    K: NDArray[Any]
    transformation: NDArray[Any]
    squares: Array


def reduced_waves(
    sector: Sector,
    kept: Mapping[str, int],
    modes: int,
    nodal_diameters: Sequence[int],
    progress: Progress = lambda share, text: None,
) -> Iterator[ReducedWave]:
    """The reduction of each of the nodal diameters, one after the other, since each may take as much memory as the sector."""
    refuse_on_faces(sector, kept)
    inside = sector.solid.size - sector.dependent.size - len(kept)
    if not 1 <= modes <= inside:
        raise fault("modes", f"must lie between 1 and {inside}", modes)
    for done, n in enumerate(nodal_diameters):
        which = f"nodal diameter {n}, {done + 1} of {len(nodal_diameters)}"
        progress(done / len(nodal_diameters), f"reducing {which}, {sector.solid.size} rows")
        yield _reduced_wave(sector, np.array(list(kept.values()), dtype=int), modes, n)


def _reduced_wave(sector: Sector, kept: Index, modes: int, nodal_diameter: int) -> ReducedWave:
    """Craig–Bampton of one nodal diameter on its independent degrees of freedom, then the motion of the whole sector."""
    T = sector.constraint(nodal_diameter)
    M, K = (sparse.csc_array(hermitian(T.conj().T @ A @ T)) for A in (sector.solid.M, sector.solid.K))
    independent = np.setdiff1d(np.arange(sector.solid.size), sector.dependent)
    boundary = np.searchsorted(independent, kept)
    interior = np.setdiff1d(np.arange(independent.size), boundary)
    own, mass = K[interior][:, interior], M[interior][:, interior]
    try:
        factor = HermitianFactor(own)
    except Singular:
        factor = None
    if factor is None or factor.negative or factor.weak:
        raise InputError(
            f"The sector must be held by its supports and the kept nodes, but at nodal diameter {nodal_diameter} some motion "
            "stays free or has negative stiffness. Check the supports, and that K is not prestressed beyond buckling."
        )
    basis = np.zeros((independent.size, kept.size + modes), dtype=K.dtype)
    basis[boundary, np.arange(kept.size)] = 1.0
    basis[interior, : kept.size] = -factor.solve(K[interior][:, boundary].toarray())
    squares, basis[interior, kept.size :] = _lowest(own, mass, factor, modes)
    mass_of_basis, stiffness = (hermitian(basis.conj().T @ (A @ basis)) for A in (M, K))
    return ReducedWave(mass_of_basis, stiffness, T @ basis, squares)


def _lowest(K: sparse.csc_array, M: sparse.csc_array, factor: HermitianFactor, number: int) -> tuple[Array, NDArray[Any]]:
    """The lowest ω² [1/s²], ascending, and mass-normalised shapes whose largest entries are real and positive."""
    size = K.shape[0]
    if size <= DENSE_SIZE or 2 * number > size:
        squares, shapes = linalg.eigh(K.toarray(), M.toarray(), subset_by_index=[0, number - 1])
    else:
        squares, shapes = eigenpairs_above(factor.solve, M, number, dtype=K.dtype)
    largest = shapes[np.abs(shapes).argmax(axis=0), np.arange(number)]
    return squares, shapes * (np.abs(largest) / largest)


def lowest_frequencies(sector: Sector, nodal_diameter: int, number: int) -> Array:
    """The lowest natural frequencies of a nodal diameter of a sector that its supports hold, Hz, without reduction."""
    M, K = sector.matrices(nodal_diameter)
    squares, _ = _lowest(K, M, HermitianFactor(K), number)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi))
