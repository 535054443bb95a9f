"""Natural frequencies and modes of M, K, including massless motions and rigid motions.

Rigid motions are those that K does not resist, a property of the body whatever its mesh, size and units. With coordinates the
six motions of a rigid body are known, and K acting on them shows at every node whether something holds it: a clamped node resists
as an element does, however fine the mesh and however low the first frequency. Without coordinates a mode is judged by its own
energy against the rounding of the product that computes it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components

from stickslip.model.structure.matrices import Sparse
from stickslip.support.checks import SMALLEST, Array, is_definite

ROUNDING = 64.0 * float(np.finfo(float).eps)
"""Of K v, whose entries are sums of element stiffnesses, relative to |K||v|. Measured are 1e-15 and less; elements resist at
their nodes with 0.01 to 1, the spring of a soft support of 1 Hz under a body of steel with 4e-9."""
MIXED = 1e-10
"""Share of other modes that rounding mixes into one; it counts by its square. A free body beside an elastic one has no more."""
TURNED = 1e-8
"""Share of the largest motion below which a rigid motion moves no degree of freedom, such as the spin of nodes on one line."""


def unresisted(K: Any, shapes: NDArray[Any]) -> NDArray[np.bool_]:
    """Which motions (n, k) are rigid: |vᴴKv| ≤ ε |v|ᵀ|K||v| + δᵀ|K|δ, the rounding of that very product and of v; K (n, n),
    dense or sparse. δ (n,): what rounding mixes into v, a share of the largest of all motions at each row.
    """
    sizes, stiffness = np.abs(shapes), abs(K)
    mixed = MIXED * sizes.max(axis=1, initial=0.0)
    energies = np.abs(np.sum(shapes.conj() * (K @ shapes), axis=0))
    return np.asarray(energies <= ROUNDING * np.sum(sizes * (stiffness @ sizes), axis=0) + mixed @ (stiffness @ mixed))


def rigid_motions(K: Sparse, dofs: Sequence[str], nodes: Mapping[str, Sequence[float]], within: float = ROUNDING) -> Array:
    """The rigid motions that K (n, n) leaves free, (n, motions), orthonormal; dofs: "NODE.DIRECTION" of each row; nodes:
    coordinates. Rows of nodes without coordinates do not move: modes of a reduction, incompatible modes of elements.

    Of each connected part, K acts on its six motions R about its middle. The row that resists most, relative to |K||R|, takes a
    combination of them away, until what is left of K R is rounding at every row, or another share of |K||R| that it is `within`.
    """
    motions = _of_nodes(dofs, nodes)
    by_row = sparse.csr_array(K)
    by_row.eliminate_zeros()
    number, parts = connected_components(by_row, directed=False)
    order = np.argsort(parts, kind="stable")
    ends = np.searchsorted(parts[order], np.arange(number + 1))
    rows_of = [order[low:high] for low, high in pairwise(ends)]
    free = [(rows, _free(by_row, motions, rows, within)) for rows in rows_of]
    rigid = np.zeros((len(dofs), sum(part.shape[1] for _, part in free)))
    first = 0
    for rows, part in free:
        rigid[rows, first : first + part.shape[1]] = part
        first += part.shape[1]
    return rigid


def _of_nodes(dofs: Sequence[str], nodes: Mapping[str, Sequence[float]]) -> Array:
    """Displacements and rotations of the rows for unit translations along x, y, z and rotations about them, (n, 6)."""
    axes = {"x": 0, "y": 1, "z": 2}
    motions = np.zeros((len(dofs), 6))
    for row, (node, _, direction) in enumerate(dof.rpartition(".") for dof in dofs):
        axis = axes.get(direction.removeprefix("r"))
        if node not in nodes or axis is None:
            continue
        if direction.startswith("r"):
            motions[row, 3 + axis] = 1.0
            continue
        point = nodes[node]
        motions[row, axis] = 1.0
        after, last = (axis + 1) % 3, (axis + 2) % 3
        motions[row, 3 + after], motions[row, 3 + last] = point[last], -point[after]  # (ω × r) along the axis
    return motions


def _free(K: sparse.csr_array, motions: Array, rows: NDArray[Any], within: float) -> Array:
    """The rigid motions of one connected part, over its rows, that its K leaves free, orthonormal."""
    own = K[rows][:, rows]
    free = _independent(motions[rows])
    bounds = np.maximum((abs(own) @ np.abs(free)).sum(axis=1), SMALLEST)
    while free.shape[1]:
        forces = own @ free
        resistance = np.linalg.norm(forces, axis=1) / bounds
        most = int(np.argmax(resistance))
        if resistance[most] <= within:
            break
        free = free @ linalg.null_space(forces[most][None])
    return free


def _independent(motions: Array) -> Array:
    """An orthonormal basis of rigid motions (n, 6), with lengths relative to the size of the part."""
    translations, rotations = motions[:, :3], motions[:, 3:]
    middle = np.linalg.lstsq(translations, rotations, rcond=None)[0]
    about_middle = rotations - translations @ middle
    size = np.abs(about_middle).max(initial=0.0)
    scaled = np.hstack([translations, about_middle / size]) if size else translations
    vectors, lengths, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(vectors[:, lengths > TURNED * lengths.max(initial=0.0)])


def without_resistance(K: Array, motions: Array) -> Array:
    """K (n, n) that resists none of the motions (n, k), P K P with P = 1 − R (RᵀR)⁻¹ Rᵀ: without what rounding left."""
    basis, _ = np.linalg.qr(motions)
    halfway = K - basis @ (basis.T @ K)
    cleaned = halfway - (halfway @ basis) @ basis.T
    return np.asarray(0.5 * (cleaned + cleaned.T))


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


def gyroscopic_modes(modes: Modes, skew: Array) -> Modes:
    """The modes of M q̈ + G q̇ + K q = 0 for a skew G (n, n) from those without it: complex shapes of as much energy as a mode of
    that frequency and φᵀMφ = 1 has. G takes no energy, and frequencies stay real.

    With q = φ η the state (ω₀ η, η̇) goes with a skew matrix, i ω v = [[0, ω₀], [−ω₀, −φᵀGφ]] v, v of length one.
    """
    own = np.diag(np.sqrt(np.maximum(modes.squares, 0.0)))
    matrix = np.block([[np.zeros_like(own), own], [-own, -(modes.shapes.T @ skew @ modes.shapes)]])
    omega, states = linalg.eigh(-1j * matrix)
    size = own.shape[0]
    return Modes(np.asarray(omega[size:] ** 2, dtype=float), modes.shapes @ (-1j * np.sqrt(2.0) * states[size:, size:]))


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
