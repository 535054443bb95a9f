"""The lowest modes of large K φ = λ M φ with a proof that none is missing: Sylvester's count at a shift above the last of them.

A Krylov space holds as many copies of an eigenvalue as its first block has vectors, and nothing in it shows that there are more.
The factor of K − μM has as many negative pivots as there are eigenvalues below μ. Where the count is higher than what was found,
the iteration begins again beside it, from other vectors.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.structure.block_lanczos import BLOCK, RESIDUAL, Eigenpairs, eigenpairs_above
from stickslip.model.structure.factor import Pencil, Singular
from stickslip.model.structure.rigid_motions import ROUNDING
from stickslip.support.checks import Array

DENSE_SIZE = 400
"""Bodies of up to so many rows, or with more than half of their modes wanted, are solved densely."""
MASSLESS = 1e-13
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
    def of(cls, numbers: Array) -> ModeCount:
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

    def first(self, number: int, tolerance: float) -> CompleteModes:
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
        heavy = np.flatnonzero(thetas > MASSLESS * thetas[-1])[::-1]
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
