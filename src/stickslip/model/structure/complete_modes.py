"""Lowest modes of large K φ = λ M φ, free or held, with a proof that none is missing: Sylvester's count at a shift above them.

The block Lanczos method finds the eigenvalues next to a shift. A factor of K − σM is read from memory once for a block of
vectors. One vector at a time, as ARPACK takes them, reading it is what costs: of a blade of 60 864 rows a solution took 0.14 s
for one vector and 0.02 s for each of eight.

A Krylov space holds as many copies of an eigenvalue as its first block has vectors, and nothing in it shows that there are more.
The factor of K − μM has as many negative pivots as there are eigenvalues below μ. Where the count is higher than what was found,
the iteration begins again beside it, from other vectors.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.structure.factor import Pencil, Singular
from stickslip.model.structure.matrices import Sparse
from stickslip.model.structure.modes import MASSLESS, ROUNDING, modes_as_solved, unresisted
from stickslip.support.checks import SMALLEST, Array

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
