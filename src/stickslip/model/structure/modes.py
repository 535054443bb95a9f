"""Natural frequencies and modes of M, K, including massless motions and rigid-body motions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from stickslip.model.structure.rigid_motions import unresisted
from stickslip.support.checks import Array, is_definite

MASSLESS = 1e-12
"""Motions below this share of the mass of their degrees of freedom count as massless."""


@dataclass(frozen=True, eq=False)
class Modes:
    """K φ = ω² M φ: squares ω² [1/s²], ascending, 0 for rigid motions, (modes,), and shapes (n, modes) with φᵀMφ = 1.

    Motions without mass follow the others statically and have no mode of their own: fewer modes than degrees of freedom.
    """

    squares: Array
    shapes: Array

    @property
    def frequencies(self) -> Array:
        """Hz; rigid motions have 0."""
        return np.asarray(np.sqrt(np.maximum(self.squares, 0.0)) / (2.0 * np.pi))


def natural_modes(M: Array, K: Array) -> Modes:
    """All modes of symmetric or complex Hermitian M (no negative eigenvalue) and K, (n, n); rigid motions have ω² = 0 exactly."""
    modes = modes_as_solved(M, K)
    return replace(modes, squares=np.where(unresisted(K, modes.shapes), 0.0, modes.squares))


def modes_as_solved(M: Array, K: Array) -> Modes:
    """All modes, of which rigid motions have the ω² that rounding leaves them.

    With massless motions q = V1 a + V0 b, V0 spanning the null space of M: K_00 b = −K_01 a, then the modes of the rest.
    """
    scale = np.sqrt(np.maximum(np.diag(M).real, 0.0))
    if scale.all() and is_definite(M / np.outer(scale, scale), -MASSLESS):
        return Modes(*linalg.eigh(K, M))
    with_mass, massless = _split(M)
    if not massless.shape[1]:
        return Modes(*linalg.eigh(K, M))
    held = massless.conj().T @ K
    inverse = linalg.pinvh(held @ massless, rtol=MASSLESS)
    follow = with_mass - massless @ (inverse @ (held @ with_mass))
    squares, amplitudes = linalg.eigh(_hermitian(follow.conj().T @ K @ follow), _hermitian(with_mass.conj().T @ M @ with_mass))
    return Modes(squares, follow @ amplitudes)


def definite_modes(M: Array, K: Array) -> Modes:
    """The modes with a positive square of a positive definite K and any symmetric or Hermitian M, (n, n), φᵀMφ = 1.

    M is indefinite where it holds what a rotor speed adds to the stiffness, K + Ω² K₁ = ω² M: stiffened motions may be met by no
    speed at all.
    """
    inverse_squares, shapes = linalg.eigh(M, K)
    met = inverse_squares > MASSLESS * np.abs(inverse_squares).max(initial=0.0)
    squares = 1.0 / inverse_squares[met]
    return Modes(squares[::-1], (shapes[:, met] * np.sqrt(squares))[:, ::-1])


def _split(M: Array) -> tuple[Array, Array]:
    """Bases of the motions with mass and of those without, (n, ...), independent of the units of the degrees of freedom."""
    scale = np.sqrt(np.maximum(np.diag(M).real, 0.0))
    scale[scale == 0.0] = scale.max(initial=0.0) or 1.0
    shares, vectors = linalg.eigh(M / np.outer(scale, scale))
    basis = vectors / scale[:, None]
    heavy = shares > MASSLESS
    return basis[:, heavy], basis[:, ~heavy]


def _hermitian(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.conj().T))
