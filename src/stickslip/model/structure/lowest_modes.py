"""Lowest modes of a large free or held body by shift and invert, complete by a count of eigenvalues."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stickslip.model.structure.block_lanczos import RESIDUAL, eigenpairs_above
from stickslip.model.structure.complete_modes import DENSE_SIZE, CompleteModes, ModeCount, completed
from stickslip.model.structure.factor import Pencil, Singular
from stickslip.model.structure.modes import MASSLESS, modes_as_solved
from stickslip.model.structure.rigid_motions import ROUNDING, unresisted
from stickslip.model.structure.sparse import Sparse
from stickslip.support.checks import SMALLEST, Array

SHIFT, SHIFT_OF_HELD = -1e-7, -1e-12
"""The first shift, as a share of the largest K_ii/M_ii: of a body that may be free, and of one whose coordinates show it held."""
NEARER = 1e-2
"""Share of the shift below which the first elastic ω² is found again with a shift of its own size: the modes of a thin strip lie
far below the frequency of its stiffest node, and rounding goes by the shift."""


@dataclass(frozen=True)
class LowestModes:
    """squares: the lowest ω² [1/s²], ascending, 0 for rigid motions; rigid: how many of these; negative: motions of negative
    stiffness; count: how many there are of the modes listed; megabytes: of the factor."""

    squares: Array
    rigid: int
    negative: int
    count: ModeCount
    megabytes: float = 0.0

    @property
    def frequencies(self) -> Array:
        """Hz; 0 for rigid motions and those of negative stiffness."""
        return np.asarray(np.sqrt(np.maximum(self.squares, 0.0)) / (2.0 * np.pi))


def lowest_modes(M: Sparse, K: Sparse, number: int = 10, rigid: Array | None = None) -> LowestModes | None:
    """The rigid motions and other lowest modes, together `number` and those equal to the last, of symmetric K and M (n, n), M
    without negative eigenvalue; None where K − σM has no factor.

    rigid: the rigid motions that coordinates show, (n, motions), of `rigid_motions`; None without coordinates: each mode is then
    judged by its energy.
    """
    known = np.zeros((K.shape[0], 0)) if rigid is None else _with_unit_mass(M, rigid)
    wanted = max(number - known.shape[1], 1)
    pencil = Pencil(K, M)
    if M.shape[0] <= DENSE_SIZE:
        modes, below = _all(pencil, known, wanted), 0
    else:
        try:
            modes, below = _near_zero(pencil, wanted, known, judged=rigid is None)
        except Singular:
            return None
    weightless = unresisted(K, modes.shapes)
    negative = below + int(np.sum((modes.squares < 0.0) & ~weightless))
    still = weightless if rigid is None else np.zeros(weightless.size, dtype=bool)
    squares = np.sort(np.concatenate([np.zeros(known.shape[1]), np.where(still, 0.0, modes.squares)]))
    count = replace(modes.count, found=squares.size, there=modes.count.there and modes.count.there + known.shape[1])
    return LowestModes(squares, known.shape[1] + int(np.sum(still)), negative, count, pencil.megabytes)


def _with_unit_mass(M: Sparse, motions: Array) -> Array:
    """The motions R (n, k) with mass, RᵀMR = 1; those without have no mode."""
    masses, turned = np.linalg.eigh(motions.T @ (M @ motions))
    heavy = masses > MASSLESS * masses.max(initial=0.0)
    return np.asarray(motions @ (turned[:, heavy] / np.sqrt(masses[heavy])))


def _all(pencil: Pencil, known: Array, number: int) -> CompleteModes:
    """The lowest of all modes but those that the known motions make up: as many, of the largest share of them."""
    modes = modes_as_solved(pencil.M.toarray(), pencil.K.toarray())
    shares = np.sum((known.T @ (pencil.M @ modes.shapes)) ** 2, axis=0)
    others = np.sort(np.argsort(shares)[: shares.size - known.shape[1]])
    squares, shapes = modes.squares[others], modes.shapes[:, others]
    every = CompleteModes(squares, shapes, ModeCount(others.size, others.size, np.inf))
    if others.size <= number:
        return every
    return every.first(number, max(RESIDUAL * abs(squares[number - 1]), ROUNDING * abs(squares[-1])))


def _near_zero(pencil: Pencil, number: int, known: Array, judged: bool) -> tuple[CompleteModes, int]:
    """The lowest modes above a shift but the known ones, and how many lie below it; the shift goes as near to zero as the first
    elastic mode lies. judged: whether a mode without energy is a rigid motion.
    """
    mass, stiffness = pencil.M.diagonal(), pencil.K.diagonal()
    heavy = mass > SMALLEST
    held = not judged and not known.shape[1]
    shift = (SHIFT_OF_HELD if held else SHIFT) * float(np.max(np.abs(stiffness[heavy]) / mass[heavy], initial=0.0))
    while True:
        below = pencil.at(shift).negative
        pairs = eigenpairs_above(pencil.solve, pencil.M, number, shift, known)
        elastic = np.abs(pairs.squares[~unresisted(pencil.K, pairs.shapes)] if judged else pairs.squares)
        if below or not elastic.size or elastic[0] == 0.0 or elastic[0] >= NEARER * abs(shift):
            return completed(pencil, pairs, number, shift, known), below
        shift = -float(elastic[0])
