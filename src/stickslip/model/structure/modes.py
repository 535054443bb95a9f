"""Natural frequencies and modes of M, K, including massless motions and rigid motions.

Rigid motions are those that K does not resist, a property of the body whatever its mesh, size and units. With coordinates the
six motions of a rigid body are known, and K acting on them shows at every node whether something holds it: a clamped node resists
as an element does, however fine the mesh and however low the first frequency. Without coordinates a mode is judged by its own
energy against the rounding of the product that computes it.

The lowest modes of large K φ = λ M φ, free or held, come with a proof that none is missing: Sylvester's count at a shift above
them. The block Lanczos method finds the eigenvalues next to a shift. A factor of K − σM is read from memory once for a block of
vectors. One vector at a time, as ARPACK takes them, reading it is what costs: of a blade of 60 864 rows a solution took 0.14 s
for one vector and 0.02 s for each of eight.

A Krylov space holds as many copies of an eigenvalue as its first block has vectors, and nothing in it shows that there are more.
The factor of K − μM has as many negative pivots as there are eigenvalues below μ. Where the count is higher than what was found,
the iteration begins again beside it, from other vectors.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components

from stickslip.model.structure.factor import Pencil, Singular
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


BLOCK = 8
"""Vectors of a block."""
RESIDUAL = 1e-10
"""Residual of S φ = θ φ, relative to θ, at which the iteration ends; the error of θ is about its square."""
LOST = 1e-10
"""Length of a vector, relative to what it was, below which nothing but rounding is left of it."""


class Eigenpairs(NamedTuple):
    """squares: the lowest eigenvalues λ > σ, ascending, (k,); shapes (n, k) with φᴴMφ = 1; beyond: upper bounds of the following
    ones, ascending, from which the iteration had not converged."""

    squares: Array
    shapes: NDArray[Any]
    beyond: Array


def eigenpairs_above(
    solve: Callable[[NDArray[Any]], NDArray[Any]],
    M: Sparse,
    number: int,
    shift: float = 0.0,
    known: NDArray[Any] | None = None,
    block: int = BLOCK,
) -> Eigenpairs:
    """At least `number` of the lowest eigenvalues, fewer where there are no more; of equal ones at most `block`.

    solve: (K − σM)⁻¹ of a block (n, b), with K Hermitian. M (n, n) may be singular, but not indefinite. The basis V of the Krylov
    space of S = (K − σM)⁻¹M is M-orthonormal, so that VᴴMSV is Hermitian with eigenvalues θ = 1/(λ − σ), the largest of which
    converge first: Grimes, Lewis and Simon, A shifted block Lanczos algorithm (1994). It is orthogonalised in full, twice.
    known: eigenvectors (n, k) with XᴴMX = 1 that are not met again; the iteration starts from other vectors for each k.
    """
    known = np.zeros((M.shape[0], 0)) if known is None else known
    weights = M @ known

    def inverse(loads: NDArray[Any]) -> NDArray[Any]:
        motions = solve(loads)
        return np.asarray(motions - known @ (weights.conj().T @ motions))

    draw = np.random.default_rng((1, known.shape[1]) if known.shape[1] else 1)
    image = inverse(M @ draw.standard_normal((M.shape[0], block)))
    blocks, products = np.empty((M.shape[0], 0), dtype=image.dtype, order="F"), np.empty((0, 0), dtype=image.dtype)
    vectors, _ = orthonormal(image, M, blocks, longest(image, M @ image))
    done = 0
    while True:
        begun, done = done, done + vectors.shape[1]
        if done > blocks.shape[1]:  # room is doubled, so that what is there is copied a few times only
            room = np.empty((M.shape[0], max(4 * number, 2 * done)), dtype=image.dtype, order="F")
            room[:, :begun] = blocks[:, :begun]
            blocks = room
        blocks[:, begun:done] = vectors
        basis = blocks[:, :done]
        image = inverse(M @ vectors)
        weighted = M @ image
        column = basis.conj().T @ weighted
        products = np.block([[products, column[:begun]], [column[:begun].conj().T, column[begun:]]])
        vectors, rest = orthonormal(image - basis @ column, M, basis, longest(image, weighted))
        projected = 0.5 * (products + products.conj().T)
        exhausted = vectors.shape[1] == 0 or done >= M.shape[0] - known.shape[1]
        if not exhausted and done < number:
            continue
        if not exhausted:  # the least of the wanted θ converges last; alone it takes a quarter of the time of all
            thetas, turned = linalg.eigh(projected, subset_by_index=[done - number, done - number])
            if not _converged(thetas, turned, rest)[0]:
                continue
        thetas, turned = linalg.eigh(projected)
        thetas, turned = thetas[::-1], turned[:, ::-1]
        right = _converged(thetas, turned, rest)
        first = int(np.argmin(right)) if not exhausted and not right.all() else done
        if first >= number or exhausted:
            break
    above = int(np.sum(thetas > 0.0))
    first = min(first, above)
    squares = shift + 1.0 / thetas[:above]
    return Eigenpairs(squares[:first], basis @ turned[:, :first], squares[first:])


def _converged(thetas: Array, turned: NDArray[Any], rest: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether S φ = θ φ within the residual allowed, for φ = V y and each column y of `turned` (v, k).

    What S V has outside V is rest (q, b), of the last b vectors of V alone.
    """
    residuals = np.linalg.norm(rest @ turned[-rest.shape[1] :], axis=0)
    return np.asarray(residuals <= RESIDUAL * np.abs(thetas))


def longest(vectors: NDArray[Any], weighted: NDArray[Any]) -> float:
    """The largest of √(vᴴMv), weighted being M v."""
    return float(np.sqrt(np.max(np.sum(vectors.conj() * weighted, axis=0).real, initial=0.0)))


def orthonormal(vectors: NDArray[Any], M: Sparse, basis: NDArray[Any], length: float) -> tuple[NDArray[Any], NDArray[Any]]:
    """Q (n, k) with QᴴMQ = 1 and VᴴMQ = 0, and R (k, b): what is left of vectors (n, b) off the basis V is Q R.

    Directions that are rounding beside the length that the vectors once had are left out: the space is then exhausted there.
    """
    vectors = vectors - basis @ (basis.conj().T @ (M @ vectors))
    triangle = np.eye(vectors.shape[1], dtype=vectors.dtype)
    for _ in range(2):  # the second time removes what rounding left of the first
        weighted = M @ vectors
        _, turned = linalg.eigh(vectors.conj().T @ weighted)
        vectors = vectors @ turned
        lengths = np.sqrt(np.maximum(np.sum(vectors.conj() * (weighted @ turned), axis=0).real, 0.0))
        kept = lengths > LOST * length
        vectors = vectors[:, kept] / lengths[kept]
        triangle = (lengths[:, None] * turned.conj().T)[kept] @ triangle
        if np.any(lengths[kept] < np.sqrt(LOST) * length):  # of what is short, rounding is a large share
            vectors -= basis @ (basis.conj().T @ (M @ vectors))
        length = 1.0
    return vectors, triangle


DENSE_SIZE = 400
"""Bodies of up to so many rows, or with more than half of their modes wanted, are solved densely."""
BEYOND_ROUNDING = 1e-13
"""Share of the largest 1/ω² below which it is rounding."""
PARTS = (0.5, 0.25, 0.75)
"""Where in a gap the count is made, in turn, if the matrix has no good factor there."""
FRUITLESS = 2
"""Restarts in turn that find nothing of what the count says is missing: the count is then not believed."""


@dataclass(frozen=True)
class ModeCount:
    """found: modes up to bound, a λ [1/s²] between the last of them and the next, infinite where there is none; there: how many
    there are by Sylvester's law, None where K − λM had no good factor in the gap."""

    found: int
    there: int | None
    bound: float

    @classmethod
    def of(cls, numbers: Array) -> "ModeCount":
        """The count that a file holds as three numbers, −1 for none."""
        found, there, bound = numbers
        return cls(int(found), None if there < 0.0 else int(there), float(bound))

    @property
    def numbers(self) -> Array:
        """As a file holds it."""
        return np.array([self.found, -1 if self.there is None else self.there, self.bound])

    @property
    def hertz(self) -> float:
        """The bound as a frequency."""
        return float(np.sqrt(max(self.bound, 0.0))) / (2.0 * np.pi)

    def __str__(self) -> str:
        """ "30 of 30 below 1234 Hz"."""
        if self.there is None:
            return f"{self.found}, not counted, since K − ω²M has no good factor above them: some may be missing"
        below = f" below {self.hertz:.5g} Hz" if np.isfinite(self.bound) else ""
        return f"{self.found} of {self.there}{below}"


@dataclass(frozen=True, eq=False)
class CompleteModes:
    """squares: the lowest λ above a shift, ascending, (k,); shapes (n, k), φᴴMφ = 1."""

    squares: Array
    shapes: NDArray[Any]
    count: ModeCount

    def first(self, number: int, tolerance: float) -> "CompleteModes":
        """The lowest `number`, and those equal to the last of them: that differ from it, one by one, by `tolerance` at most."""
        last = whole(self.squares, number, tolerance)
        if last == self.squares.size:
            return self
        bound = float(np.mean(self.squares[max(last - 1, 0) : last + 1]))
        count = ModeCount(last, None if self.count.there is None else last, bound)
        return CompleteModes(self.squares[:last], self.shapes[:, :last], count)


def whole(squares: Array, number: int, tolerance: float) -> int:
    """How many of ascending `squares` are the lowest `number` and those equal to the last of these."""
    last = min(number, squares.size)
    while 0 < last < squares.size and squares[last] - squares[last - 1] <= tolerance:
        last += 1
    return last


def held_modes(pencil: Pencil, number: int | None = None) -> CompleteModes:
    """The lowest `number` modes of a body whose K is positive definite, all of them for None; the largest entry of each shape is
    real and positive, so that shapes are the same on every machine. The pencil has its factor at 0, and another afterwards.

    Densely from M φ = θ K φ with θ = 1/ω², so that massless motions (θ = 0) do no harm: they have no mode.
    """
    size = pencil.M.shape[0]
    if not size or number == 0:
        return CompleteModes(np.zeros(0), np.zeros((size, 0)), ModeCount(0, 0, 0.0))
    if number is not None and size > DENSE_SIZE and 2 * number <= size:
        found = completed(pencil, eigenpairs_above(pencil.solve, pencil.M, number), number)
    else:
        thetas, shapes = linalg.eigh(pencil.M.toarray(), pencil.K.toarray())
        heavy = np.flatnonzero(thetas > BEYOND_ROUNDING * thetas[-1])[::-1]
        found = CompleteModes(
            1.0 / thetas[heavy], shapes[:, heavy] / np.sqrt(thetas[heavy]), ModeCount(heavy.size, heavy.size, np.inf)
        )
        if number is not None and number < heavy.size:
            found = found.first(number, equal_within(pencil, found.squares, found.shapes, number))
    largest = found.shapes[np.abs(found.shapes).argmax(axis=0), np.arange(found.squares.size)]
    return replace(found, shapes=found.shapes * (np.abs(largest) / largest))


def completed(pencil: Pencil, pairs: Eigenpairs, number: int, shift: float = 0.0, known: Array | None = None) -> CompleteModes:
    """The lowest `number` modes above the shift σ at which the pencil has its factor, and those equal to the last of them, from
    what the iteration found there. The pencil has another factor afterwards.

    known: modes (n, k) with XᴴMX = 1 between the shift and all others, which are not met and not counted.
    """
    known = np.zeros((pencil.M.shape[0], 0)) if known is None else known
    below = pencil.negative + known.shape[1]
    squares, shapes, beyond = pairs
    if not squares.size:
        return CompleteModes(squares, shapes, ModeCount(0, 0, np.inf))
    contradictions = FRUITLESS if pencil.weak else 0
    while True:
        last = min(number, squares.size)
        tolerance = equal_within(pencil, squares, shapes, last, shift)
        low, high = _gap(squares, beyond, last, tolerance, shift)
        count, bound = (None, high) if contradictions == FRUITLESS else _count(pencil, low, high, squares, shapes, below)
        found = squares.size if count is None else int(np.sum(squares < bound))
        if count is None or count == found:
            complete = CompleteModes(squares[:found], shapes[:, :found], ModeCount(found, count, bound))
            return complete.first(number, tolerance)
        missing = min(count - found, squares.size)
        pencil.at(shift)
        more = eigenpairs_above(pencil.solve, pencil.M, missing, shift, np.hstack([known, shapes]), max(BLOCK, missing))
        contradictions = 0 if np.any(more.squares < bound) else contradictions + 1
        squares, shapes = _together(pencil, np.hstack([shapes, more.shapes]), shift)
        beyond = more.beyond


def equal_within(pencil: Pencil, squares: Array, shapes: NDArray[Any], last: int, shift: float = 0.0) -> float:
    """How far λ near that of mode `last`, counted from 1, may be apart and still count as equal.

    By the residual of the iteration; by the rounding of θ = 1/(λ − σ), which goes by the largest; and by that of xᴴ(K − λM)x, of
    which a factor has no less.
    """
    above, size = squares[last - 1] - shift, np.abs(shapes[:, last - 1])
    energies = size @ (abs(pencil.K) @ size + abs(squares[last - 1]) * (abs(pencil.M) @ size))
    return float(max(RESIDUAL * above, ROUNDING * above**2 / (squares[0] - shift), ROUNDING * energies))


def _gap(squares: Array, beyond: Array, last: int, tolerance: float, shift: float) -> tuple[float, float]:
    """The ends of the gap above the first `last` of `squares`, and those equal to them, whether the iteration has converged at
    these or not. Beyond all that it knows of, there are none."""
    levels = np.sort(np.concatenate([squares[last - 1 :], beyond]))
    lowest = whole(levels, 1, tolerance)
    low = float(levels[lowest - 1])
    return low, float(levels[lowest]) if lowest < levels.size else low + (low - shift)


def _count(pencil: Pencil, low: float, high: float, squares: Array, shapes: NDArray[Any], below: int) -> tuple[int | None, float]:
    """How many λ there are up to a bound in a gap, those `below` the shift aside, and the bound; None where no factor is good.

    A factor is that of K − μM + E. For a mode φ whose λ is next to μ, x = (K − μM + E)⁻¹Mφ leaves Mφ − (K − μM) x = E x, and
    |φᴴE x| = |φᴴEφ|/|λ − μ| < 1/2 says that E does not bring λ to the other side.
    """
    for part in PARTS:
        bound = low + part * (high - low)
        try:
            pencil.at(bound)
        except Singular:
            continue
        near = shapes[:, squares < bound][:, -BLOCK:]
        loads = pencil.M @ near
        motions = pencil.solve(loads)
        moved = np.sum(near.conj() * (loads - pencil.K @ motions + bound * (pencil.M @ motions)), axis=0)
        count = pencil.negative - below
        if not pencil.weak and np.all(np.abs(moved) < 0.5) and count >= int(np.sum(squares < bound)):
            return count, bound
    return None, high


def _together(pencil: Pencil, shapes: NDArray[Any], shift: float) -> tuple[Array, NDArray[Any]]:
    """λ, ascending, and shapes of the modes in the space of `shapes` (n, k), of two iterations: Rayleigh and Ritz."""
    weighted = pencil.M @ shapes
    products, masses = weighted.conj().T @ pencil.solve(weighted), shapes.conj().T @ weighted
    thetas, turned = linalg.eigh(0.5 * (products + products.conj().T), 0.5 * (masses + masses.conj().T))
    return shift + 1.0 / thetas[::-1], shapes @ turned[:, ::-1]


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
    known = np.zeros((K.shape[0], 0)) if rigid is None else with_unit_mass(M, rigid)
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


def with_unit_mass(M: Sparse, motions: Array) -> Array:
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
