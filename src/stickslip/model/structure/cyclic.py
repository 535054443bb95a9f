"""A disk of equal sectors: the matrices of one sector for each nodal diameter.

Sector j of N moves by u_j = u exp(−i n 2π j/N) at nodal diameter n: a wave that travels with the numbering of the sectors.
The matrices of n are Hermitian, those of N − n their conjugates; n = 0 (all sectors alike) and n = N/2 are real.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import gcd
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from stickslip.model.structure.assembly import assemble
from stickslip.model.structure.centrifugal import Z_AXIS, RotationAxis
from stickslip.model.structure.matrices import Damping, Structure
from stickslip.support.checks import Array, InputError, between, fault, first_of, is_definite, several, square, whole

Waves = NDArray[np.complex128]
"""A matrix for each nodal diameter 0..N//2, or for each of those that a disk holds, (N//2 + 1, m, m)."""

MOST_SECTORS = 1000
"""Of a disk; no machine has as many blades on one."""
NEXT = "next/"
"""Prefix of the names of the following sector's degrees of freedom: "next/pad_1.x"."""


@dataclass(frozen=True)
class HeldDiameters:
    """The nodal diameters for which something of a disk of N `sectors` is known: `held`, ascending, of 0..N//2."""

    sectors: int
    held: tuple[int, ...]

    @classmethod
    def of(cls, sectors: int, chosen: Sequence[int] | None = None) -> Self:
        """Those chosen, whose waves may run either way round, and 0; all of them unless given."""
        if chosen is None:
            return cls(sectors, tuple(range(sectors // 2 + 1)))
        turned = [whole("nodal_diameters", n) % sectors for n in several("nodal_diameters", chosen)]
        return cls(sectors, tuple(sorted({0, *(min(n, sectors - n) for n in turned)})))

    @classmethod
    def excited(cls, sectors: int, engine_order: int) -> Self:
        """Those that any harmonic h of an engine order can excite, h EO mod N: the multiples of their greatest common divisor;
        and N//2, to compare natural frequencies with."""
        return cls.of(sectors, [*range(0, sectors, gcd(sectors, engine_order)), sectors // 2])

    @property
    def complete(self) -> bool:
        """Whether all are held, as the whole disk needs them."""
        return len(self.held) == self.sectors // 2 + 1

    def pick(self, waves: NDArray[Any], nodal_diameter: int) -> NDArray[Any]:
        """That of `waves` (held, ...) for any whole number: n and n + N are the same wave, N − n is the conjugate of n."""
        n = nodal_diameter % self.sectors
        turned = 2 * n > self.sectors
        n = self.sectors - n if turned else n
        if n not in self.held:
            raise self.missing(f"nodal diameter {n}")
        wave = waves[self.held.index(n)]
        return np.asarray(wave.conj() if turned else wave)

    def require_all(self) -> None:
        """Refuse a disk of which some are missing."""
        if not self.complete:
            raise self.missing(f"all nodal diameters from 0 to {self.sectors // 2}")

    def missing(self, wanted: str) -> InputError:
        """What is said where one is asked for that is not held."""
        remedy = "Read the sector with more `nodal_diameters`, or the study by `read_problem(..., whole_disk=True)`."
        return fault("The disk", f"must hold {wanted}", first_of([*map(str, self.held)]), remedy)


ONE_SECTOR = HeldDiameters(1, (0,))
"""Of a structure that is no disk."""


class WaveMatrices(NamedTuple):
    """M, K and C (or None) of one nodal diameter, (m, m) complex Hermitian."""

    M: Waves
    K: Waves
    C: Waves | None


@dataclass(frozen=True, eq=False, repr=False)
class CyclicStructure(Structure):
    """A disk of `sectors` equal sectors; as a `Structure` it is the motion in which all sectors are alike (nodal diameter 0).

    masses, stiffnesses, dampings: (N//2 + 1, m, m) complex, one Hermitian matrix for each of the nodal `diameters`, which are all
    of 0..N//2 unless a reduction was asked for some. Made by `cyclic` or `sector_chain`. Directions may name degrees of freedom
    of the following sector with the prefix "next/". axis: about which the following sector comes counter-clockwise; z through
    the origin unless given. turns: whether K at several speeds are those of shapes that the load turns (`Turning`).
    """

    diameters: HeldDiameters = ONE_SECTOR
    masses: Waves | None = None
    stiffnesses: Waves | None = None
    dampings: Waves | None = None
    axis: RotationAxis = Z_AXIS
    turns: bool = False

    @property
    def sectors(self) -> int:
        """N."""
        return self.diameters.sectors

    @property
    def whole_stiffness(self) -> NDArray[Any]:
        assert self.stiffnesses is not None
        return self.stiffnesses

    def __repr__(self) -> str:
        return f"{super().__repr__()}, {self.sectors} sectors"

    def index(self, dof: str) -> int:
        """Position of a degree of freedom, of this sector or of the following one."""
        return super().index(dof.removeprefix(NEXT))

    def phased_row(self, direction: Any, phase: complex) -> NDArray[np.complex128]:
        """The coefficients of a direction (m,) where the following sector moves by `phase` times this one's motion."""
        row = np.zeros(self.size, dtype=complex)
        for dof, coefficient in direction.items():
            row[self.index(dof)] += coefficient * (phase if dof.startswith(NEXT) else 1.0)
        return row

    def at(self, nodal_diameter: int) -> WaveMatrices:
        """The matrices of a nodal diameter, any whole number: n and n + N are the same wave, N − n runs the other way."""
        waves = (self.masses, self.stiffnesses, self.dampings)
        M, K, C = (each if each is None else self.diameters.pick(each, nodal_diameter) for each in waves)
        assert M is not None
        assert K is not None
        return WaveMatrices(M, K, C)

    def every(self, waves: Waves | None) -> Waves:
        """Matrices of this disk for all nodal diameters 0..N//2; refused where the disk holds some of them only."""
        self.diameters.require_all()
        assert waves is not None
        return waves

    def with_damping(self, damping: Damping | NDArray[Any] | None) -> Self:
        """A copy with another damping: a rule, one matrix for each nodal diameter, or none."""
        if isinstance(damping, np.ndarray):
            waves = _hermitian("C", damping, self.diameters, self.size)
            return replace(self, C=waves[0].real, damping=None, dampings=waves)
        return replace(self, C=None, damping=damping, dampings=None)


def cyclic(
    sectors: int,
    dofs: Sequence[str],
    masses: ArrayLike,
    stiffnesses: ArrayLike,
    dampings: ArrayLike | None = None,
    damping: Damping | None = None,
    axis: RotationAxis = Z_AXIS,
    nodal_diameters: Sequence[int] | None = None,
) -> CyclicStructure:
    """The disk of Hermitian matrices for nodal diameters 0..N//2, each (N//2 + 1, m, m); axis: z unless given.

    nodal_diameters: those that the matrices are for, 0 among them, where some of 0..N//2 are missing. Such a disk can be solved
    as one sector under engine orders whose harmonics excite no others.
    """
    diameters = HeldDiameters.of(between("sectors", sectors, 2, MOST_SECTORS), nodal_diameters)
    M, K = (_hermitian(what, waves, diameters, len(dofs)) for what, waves in (("M", masses), ("K", stiffnesses)))
    C = None if dampings is None else _hermitian("C", dampings, diameters, len(dofs))
    rounding = 1e-9 * float(np.abs(M).max()) * len(dofs)
    if not all(is_definite(mass, rounding) for mass in M):
        lowest = min(float(np.linalg.eigvalsh(mass)[0]) for mass in M)
        raise fault("M", "must have no negative eigenvalue at any nodal diameter", lowest)
    return CyclicStructure(M[0].real, K[0].real, tuple(dofs), None if C is None else C[0].real, damping, diameters, M, K, C, axis)


def sector_chain(sector: Structure, sectors: int, K_next: ArrayLike, M_next: ArrayLike | None = None) -> CyclicStructure:
    """A ring of equal sectors: `sector` (M, K, C of one sector with its share of the joints) coupled to its neighbours.

    K_next, M_next (m, m): the force on a sector per motion and acceleration of the following one; the preceding one acts by
    their transposes, K_n = K + K_next exp(−i 2π n/N) + K_nextᵀ exp(+i 2π n/N). Couplings are undamped unless a rule is set.
    """
    size, sectors = sector.size, between("sectors", sectors, 2, MOST_SECTORS)
    couple = {
        "K": square("K_next", K_next, size),
        "M": np.zeros((size, size)) if M_next is None else square("M_next", M_next, size),
    }
    turns = np.exp(-2j * np.pi * np.arange(sectors // 2 + 1) / sectors)[:, None, None]

    def waves(own: Array, following: Array) -> Waves:
        return np.asarray(own + turns * following + turns.conj() * following.T)

    C = None if sector.C is None else waves(sector.C, np.zeros((size, size)))
    return cyclic(sectors, sector.dofs, waves(sector.M, couple["M"]), waves(sector.K, couple["K"]), C, sector.damping)


def with_bodies(disk: CyclicStructure, bodies: Mapping[str, Structure]) -> CyclicStructure:
    """The disk with free bodies (dampers) added to each sector, named "BODY/NODE.DIRECTION" beside the disk's own names."""
    added = assemble(bodies)
    if disk.dampings is not None or disk.damping is not None or added.C is not None:
        raise InputError("Bodies must be added to a disk before its damping is set.")

    def waves(own: Waves | None, free: Array) -> Waves:
        assert own is not None
        return np.array([linalg.block_diag(wave, free) for wave in own])

    masses, stiffnesses = waves(disk.masses, added.M), waves(disk.stiffnesses, added.K)
    whole = cyclic(disk.sectors, (*disk.dofs, *added.dofs), masses, stiffnesses, None, None, disk.axis, disk.diameters.held)
    nodes = {**disk.nodes, **added.nodes}
    whole = replace(whole, sets=disk.sets, mesh_points=disk.mesh_points, mesh_triangles=disk.mesh_triangles)
    whole = replace(whole, stresses=disk.stresses, turns=disk.turns)
    return replace(whole, nodes=nodes, outlines=added.outlines)


def circulant(waves: Waves, sectors: int) -> Array:
    """The symmetric matrix of the whole disk, (N m, N m), of Hermitian matrices for nodal diameters 0..N//2; `of_all_sectors`."""
    matrix = of_all_sectors(waves, sectors)
    return np.asarray(0.5 * (matrix + matrix.T))


def of_all_sectors(waves: Waves, sectors: int, chosen: Sequence[int] | None = None) -> Array:
    """A linear map of the whole disk, real (N r, N m), of those for nodal diameters 0..N//2, (N//2 + 1, r, m): block (j, k) is
    Σ_n A_n exp(−i n 2π (j − k)/N)/N over n = 0..N−1. chosen: sectors, from 0, whose rows it has; all unless given."""
    half = waves.shape[0]
    every = np.concatenate([waves, waves[1 : sectors - half + 1][::-1].conj()])
    blocks = np.fft.fft(every, axis=0).real / sectors
    rows = range(sectors) if chosen is None else chosen
    whole = np.array([blocks[(j - np.arange(sectors)) % sectors] for j in rows])  # (chosen, N, r, m)
    return whole.swapaxes(1, 2).reshape(len(rows) * waves.shape[1], sectors * waves.shape[2])


def sector_name(sector: int, dof: str) -> str:
    """The name of a sector's degree of freedom in the whole disk: "3/tip.x"; sectors count from 1."""
    return f"{sector}/{dof}"


def _hermitian(what: str, given: ArrayLike, diameters: HeldDiameters, size: int) -> Waves:
    """The matrices of all nodal diameters, Hermitian, and real at 0 and N/2, where all sectors move in phase or in antiphase."""
    waves = np.asarray(given, dtype=complex)
    shape = (len(diameters.held), size, size)
    if waves.shape != shape:
        raise fault(f"{what} by nodal diameter", f"must have shape {shape}", waves.shape)
    if not np.all(np.isfinite(waves)):
        raise InputError(f"{what} by nodal diameter must be finite, but holds NaN or infinite values.")
    scale = float(np.abs(waves).max(initial=0.0))
    gap = float(np.abs(waves - waves.conj().swapaxes(1, 2)).max(initial=0.0))
    if gap > 1e-8 * scale:
        raise fault(f"{what} by nodal diameter", "must be Hermitian", f"unsymmetric by {gap:.3g} of up to {scale:.3g}")
    ends = [k for k, n in enumerate(diameters.held) if 2 * n in (0, diameters.sectors)]
    if float(np.abs(waves[ends].imag).max(initial=0.0)) > 1e-8 * scale:
        raise fault(f"{what} of nodal diameters 0 and N/2", "must be real", "complex")
    waves = 0.5 * (waves + waves.conj().swapaxes(1, 2))
    waves[ends] = waves[ends].real
    return np.asarray(waves)
