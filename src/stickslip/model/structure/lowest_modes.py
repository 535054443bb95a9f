"""Lowest modes of a large free or held body by shift and invert, with a count of eigenvalues below the shift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from stickslip.model.structure.block_lanczos import eigenpairs_above
from stickslip.model.structure.factor import Factor, Singular
from stickslip.model.structure.modes import MASSLESS, Modes, modes_as_solved
from stickslip.model.structure.rigid_motions import unresisted
from stickslip.model.structure.sparse import Sparse
from stickslip.support.checks import SMALLEST, Array

DENSE_SIZE = 400
SHIFT, SHIFT_OF_HELD = -1e-7, -1e-12
"""The first shift, as a share of the largest K_ii/M_ii: of a body that may be free, and of one whose coordinates show it held."""
NEARER = 1e-2
"""Share of the shift below which the first elastic ω² is found again with a shift of its own size: the modes of a thin strip lie
far below the frequency of its stiffest node, and rounding goes by the shift."""


@dataclass(frozen=True)
class LowestModes:
    """squares: the lowest ω² [1/s²], ascending, 0 for rigid motions; rigid: how many of these; negative: motions of negative
    stiffness; megabytes: of the factor."""

    squares: Array
    rigid: int
    negative: int
    megabytes: float = 0.0

    @property
    def frequencies(self) -> Array:
        """Hz; 0 for rigid motions and those of negative stiffness."""
        return np.asarray(np.sqrt(np.maximum(self.squares, 0.0)) / (2.0 * np.pi))


def lowest_modes(M: Sparse, K: Sparse, number: int = 10, rigid: Array | None = None) -> LowestModes | None:
    """The lowest `number` modes of symmetric K and M (n, n), M without negative eigenvalue; None where K − σM has no factor.

    rigid: the rigid motions that coordinates show, (n, motions), of `rigid_motions`; None without coordinates: each mode is then
    judged by its energy.
    """
    known = np.zeros((K.shape[0], 0)) if rigid is None else _with_unit_mass(M, rigid)
    wanted = max(number - known.shape[1], 1)
    if M.shape[0] <= DENSE_SIZE:
        modes, below, size = _without(M, known, modes_as_solved(M.toarray(), K.toarray())), 0, 0.0
    else:
        try:
            modes, below, size = _near_zero(M, K, wanted, known, judged=rigid is None)
        except Singular:
            return None
    weightless = unresisted(K, modes.shapes)
    negative = below + int(np.sum((modes.squares < 0.0) & ~weightless))
    still = weightless if rigid is None else np.zeros(weightless.size, dtype=bool)
    squares = np.concatenate([np.zeros(known.shape[1]), np.where(still, 0.0, modes.squares)])
    return LowestModes(np.sort(squares)[:number], known.shape[1] + int(np.sum(still)), negative, size)


def _with_unit_mass(M: Sparse, motions: Array) -> Array:
    """The motions R (n, k) with mass, RᵀMR = 1; those without have no mode."""
    masses, turned = np.linalg.eigh(motions.T @ (M @ motions))
    heavy = masses > MASSLESS * masses.max(initial=0.0)
    return np.asarray(motions @ (turned[:, heavy] / np.sqrt(masses[heavy])))


def _without(M: Sparse, known: Array, modes: Modes) -> Modes:
    """The modes but those that the known motions make up: as many, of the largest share of them."""
    shares = np.sum((known.T @ (M @ modes.shapes)) ** 2, axis=0)
    others = np.sort(np.argsort(shares)[: shares.size - known.shape[1]])
    return Modes(modes.squares[others], modes.shapes[:, others])


def _near_zero(M: Sparse, K: Sparse, number: int, known: Array, judged: bool) -> tuple[Modes, int, float]:
    """The lowest modes above a shift but the known ones, how many lie below it, and the MiB of the factor; the shift goes as near
    to zero as the first elastic mode lies. judged: whether a mode without energy is a rigid motion.
    """
    mass = M.diagonal()
    heavy = mass > SMALLEST
    held = not judged and not known.shape[1]
    shift = (SHIFT_OF_HELD if held else SHIFT) * float(np.max(np.abs(K.diagonal()[heavy]) / mass[heavy], initial=0.0))
    while True:
        modes, below, size = _above(shift, M, K, number, known)
        elastic = np.abs(modes.squares[~unresisted(K, modes.shapes)] if judged else modes.squares)
        if below or not elastic.size or elastic[0] == 0.0 or elastic[0] >= NEARER * abs(shift):
            return modes, below, size
        shift = -float(elastic[0])


def _above(shift: float, M: Sparse, K: Sparse, number: int, known: Array) -> tuple[Modes, int, float]:
    """The lowest modes above `shift`, how many lie below it (the negative eigenvalues of K − shift M), and the MiB of the factor.

    Lanczos on (1 − R RᵀM) (K − shift M)⁻¹ does not meet the known motions R, RᵀMR = 1.
    """
    factor = Factor(sparse.csc_array(K - shift * M))
    weights = M @ known

    def solve(loads: Array) -> Array:
        motions = factor.solve(loads)
        return np.asarray(motions - known @ (weights.T @ motions))

    squares, shapes = eigenpairs_above(solve, M, number, shift)
    return Modes(squares, shapes), factor.negative, factor.megabytes
