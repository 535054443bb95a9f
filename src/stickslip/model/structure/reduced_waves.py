"""Reduction of a sector for each nodal diameter by itself: sparse, for faces of any number of nodes, matching or not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from stickslip.model.structure.complete_modes import ModeCount, held_modes
from stickslip.model.structure.cyclic_reduction import Sector, hermitian, refuse_on_faces
from stickslip.model.structure.factor import Pencil, Singular
from stickslip.support.checks import Array, Index, InputError, fault

Progress = Callable[[float, str], None]


class ReducedWave(NamedTuple):
    """One nodal diameter on its kept and modal coordinates: M, K (m, m), motion of the whole sector from them (n, m), ω² of the
    fixed-interface modes [1/s²], (modes,), and how many of those there are up to the last these are, with its equals.
    """

    M: NDArray[Any]
    K: NDArray[Any]
    transformation: NDArray[Any]
    squares: Array
    counted: ModeCount


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
    body = Pencil(K[interior][:, interior], M[interior][:, interior])
    try:
        held = not (body.at(0.0).negative or body.weak)
    except Singular:
        held = False
    if not held:
        raise InputError(
            f"The sector must be held by its supports and the kept nodes, but at nodal diameter {nodal_diameter} some motion "
            "stays free or has negative stiffness. Check the supports, and that K is not prestressed beyond buckling."
        )
    basis = np.zeros((independent.size, kept.size + modes), dtype=K.dtype)
    basis[boundary, np.arange(kept.size)] = 1.0
    basis[interior, : kept.size] = -body.solve(K[interior][:, boundary].toarray())
    found = held_modes(body, modes)
    if found.squares.size < modes:
        raise fault("modes", f"must be at most {found.squares.size}, the modes that the sector has with mass", modes)
    basis[interior, kept.size :] = found.shapes[:, :modes]
    mass_of_basis, stiffness = (hermitian(basis.conj().T @ (A @ basis)) for A in (M, K))
    return ReducedWave(mass_of_basis, stiffness, T @ basis, found.squares[:modes], found.count)


def lowest_frequencies(sector: Sector, nodal_diameter: int, number: int) -> Array:
    """The lowest natural frequencies of a nodal diameter of a sector that its supports hold, Hz, without reduction."""
    M, K = sector.matrices(nodal_diameter)
    squares = held_modes(Pencil(K, M).at(0.0), number).squares[:number]
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi))
