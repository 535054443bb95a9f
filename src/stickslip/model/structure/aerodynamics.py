"""Gas forces of a bladed disk that go with its motion: influence coefficients between blades, or a stiffness of each wave.

A wave of nodal diameter n, u_j = u exp(−i n 2π j/N), feels the force −A_n u on each blade at the frequency at which A_n was
computed. Re A_n acts as a stiffness at all frequencies, Im A_n as the viscous damping Im A_n/ω of that frequency.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.structure.cyclic import NEXT, CyclicStructure
from stickslip.model.structure.modes import natural_modes
from stickslip.support.checks import Array, InputError, between, fault, finite, positive, whole

Values = Mapping[int, complex] | Sequence[complex] | NDArray[Any]
"""By blade or nodal diameter; a sequence counts from 0."""

MOST_SHIFT = 0.5
"""Of a frequency, relative: what is more is an error of units."""


@dataclass(frozen=True, eq=False)
class WaveStiffness:
    """Complex stiffness of every wave along a direction of the sector: waves (N,) [N/m], n = 0..N−1; omega: of A_n, rad/s."""

    direction: Mapping[str, float]
    waves: NDArray[np.complex128]
    omega: float

    def __repr__(self) -> str:
        """Every number of it: fingerprints are made of it."""
        return f"WaveStiffness({dict(self.direction)!r}, {self.waves.tolist()!r}, {self.omega!r})"

    def matrices(self, nodal_diameter: int, row: Array) -> tuple[Array, Array]:
        """What it adds to K and C of a nodal diameter, for the direction as a row (m,)."""
        value, square = self.waves[nodal_diameter % self.waves.size], np.outer(row, row)
        return value.real * square, value.imag / self.omega * square

    def between_sectors(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """The same between the sectors of the whole disk, Hermitian circulant matrices of stiffness and damping, (N, N).

        Waves that run with and against the numbering have values of their own, so the matrices are complex: they hold for
        harmonics exp(+iωt), and their conjugates for exp(−iωt).
        """
        N = self.waves.size
        turns = np.exp(-2j * np.pi * np.outer(np.arange(N), np.arange(N)) / N) / np.sqrt(N)
        stiffness, damping = (turns * part @ turns.conj().T for part in (self.waves.real, self.waves.imag / self.omega))
        return 0.5 * (stiffness + stiffness.conj().T), 0.5 * (damping + damping.conj().T)


@dataclass(frozen=True, eq=False, kw_only=True)
class Aerodynamics:
    """Gas forces on the blades of a disk that are proportional to the motion of the blades, at one frequency.

    One of
    influence: {k: L_k} [N/m], complex: the force on blade j is −Σ_k L_k u_(j+k), u along `direction`; blades that are not
    named have none;
    stiffness: A_n [N/m], complex, of every nodal diameter, a sequence n = 0..N−1 or {n: A_n} with −n for the wave that runs
    against the numbering of the sectors; A_n = Σ_k L_k exp(−i n 2π k/N);
    damping_ratio: of the blade alone with the gas forces of every nodal diameter, negative where they feed the vibration,
    with `frequency_shift`, relative, none unless given: Im A_n = 2ζ m ω², Re A_n = ((1 + shift)² − 1) m ω².

    frequency: at which the coefficients hold, Hz. direction: of a sector, one degree of freedom or coefficients; unless given the
    coordinate of the blade-alone mode number `mode` (`blade_alone`), whose frequency and unit modal mass are then the defaults.
    modal_mass: m of damping ratios, kg: kinetic energy of the blade is ½ m u̇².
    """

    influence: Mapping[int, complex] | None = None
    stiffness: Values | None = None
    damping_ratio: Values | None = None
    frequency_shift: Values | None = None
    frequency: float | None = None
    direction: str | Mapping[str, float] | None = None
    modal_mass: float | None = None
    mode: int = 1

    def __post_init__(self) -> None:
        given = [name for name in ("influence", "stiffness", "damping_ratio") if getattr(self, name) is not None]
        if len(given) != 1:
            what = " and ".join(given) or "none"
            raise fault("Aerodynamics", "must have one of influence, stiffness and damping_ratio", what)
        if self.frequency_shift is not None and self.damping_ratio is None:
            raise fault("frequency_shift", "must go with damping_ratio", "alone")
        if self.direction is not None and self.frequency is None:
            raise fault("frequency", "must be given with a direction: the coefficients hold at it", None)
        if self.direction is not None and self.damping_ratio is not None and self.modal_mass is None:
            raise fault("modal_mass", "must be given with a direction and damping ratios", None)
        if self.modal_mass is not None and (self.direction is None or self.damping_ratio is None):
            raise fault("modal_mass", "must go with a direction and damping ratios", self.modal_mass)
        for name in ("frequency", "modal_mass"):
            if getattr(self, name) is not None:
                positive(name, getattr(self, name))
        if isinstance(self.direction, Mapping) and not any(self.direction.values()):
            raise fault("Aerodynamics, direction", "must have a coefficient that is not zero", dict(self.direction))

    def on(self, disk: CyclicStructure) -> WaveStiffness:
        """The complex stiffness of every wave of a disk; refused where it has another number of sectors."""
        direction, frequency = self.direction, self.frequency
        if direction is None:
            alone = blade_alone(disk, self.mode)
            direction, frequency = alone.direction, frequency or alone.frequency
        direction = {direction: 1.0} if isinstance(direction, str) else dict(direction)
        beyond = sorted(dof for dof in direction if dof.startswith(NEXT))
        if beyond:
            raise fault("Aerodynamics, direction", "must be of the sector itself", beyond)
        disk.row(direction)
        assert frequency is not None
        omega = 2.0 * np.pi * frequency
        return WaveStiffness(direction, self._waves(disk.sectors, omega), omega)

    def _waves(self, sectors: int, omega: float) -> NDArray[np.complex128]:
        """A_n, (N,)."""
        if self.influence is not None:
            order = np.arange(sectors)
            blades = _by_number("influence", self.influence, sectors)
            return np.asarray(sum(L * np.exp(-2j * np.pi * order * k / sectors) for k, L in blades.items()), dtype=complex)
        if self.stiffness is not None:
            return _every_wave("stiffness", self.stiffness, sectors)
        assert self.damping_ratio is not None
        ratio = _real("damping_ratio", _every_wave("damping_ratio", self.damping_ratio, sectors))
        shift = np.zeros(sectors)
        if self.frequency_shift is not None:
            shift = _real("frequency_shift", _every_wave("frequency_shift", self.frequency_shift, sectors))
        for name, values, most in (("damping_ratio", ratio, 1.0), ("frequency_shift", shift, MOST_SHIFT)):
            largest = values[int(np.argmax(np.abs(values)))]
            if not abs(largest) < most:
                raise fault(name, f"must lie between {-most:g} and {most:g}", float(largest), "It is relative: 1 % is 0.01.")
        stiffness = (self.modal_mass or 1.0) * omega**2
        return np.asarray(stiffness * ((1.0 + shift) ** 2 - 1.0 + 2j * ratio))


@dataclass(frozen=True, eq=False)
class BladeMode:
    """A mode of a blade alone: `direction` gives its coordinate φᵀMq with φᵀMφ = 1, [m √kg]; frequency in Hz."""

    direction: Mapping[str, float]
    frequency: float


def blade_alone(disk: CyclicStructure, mode: int = 1) -> BladeMode:
    """A mode of one sector of a disk, its neighbours at rest, without contacts; mode: 1 the lowest.

    Degrees of freedom that no stiffness holds, those of free dampers, are left out.
    """
    M, K = (_own_block(disk.every(waves), disk.sectors) for waves in (disk.masses, disk.stiffnesses))
    held = np.flatnonzero(np.abs(K).max(axis=0) > 0.0)
    if not held.size:
        raise InputError("A sector must have a stiffness for its blade to have a mode, but has none.")
    M, K = M[np.ix_(held, held)], K[np.ix_(held, held)]
    modes = natural_modes(M, K)
    number = between("mode", mode, 1, modes.squares.size) - 1
    if not modes.squares[number] > 0.0:
        raise fault("mode", "must be one that stiffness holds", mode)
    row = M @ modes.shapes[:, number]
    # The sign of an eigenvector is rounding's choice: its largest part is positive on every machine.
    row *= np.sign(row[int(np.argmax(np.abs(row)))])
    direction = {disk.dofs[int(k)]: float(value) for k, value in zip(held, row, strict=True) if value != 0.0}
    return BladeMode(direction, float(np.sqrt(modes.squares[number])) / (2.0 * np.pi))


def _own_block(waves: NDArray[np.complex128], sectors: int) -> Array:
    """The block of a circulant matrix that a sector has with itself: the mean over all nodal diameters, n and N − n conjugate."""
    weights = np.full(waves.shape[0], 2.0)
    weights[0] = 1.0
    if sectors % 2 == 0:
        weights[-1] = 1.0
    block = np.tensordot(weights, waves.real, 1) / sectors
    return np.asarray(0.5 * (block + block.T))


def _by_number(what: str, given: Mapping[int, complex], sectors: int) -> dict[int, complex]:
    """Values by number modulo N; refused where two numbers are the same blade or wave, or one is beyond the disk."""
    values: dict[int, complex] = {}
    for number, value in given.items():
        k = whole(f"{what}, number", number)
        if not -sectors < k < sectors:
            rule = f"must have numbers between {1 - sectors} and {sectors - 1} on a disk of {sectors} sectors"
            raise fault(what, rule, k, "Aerodynamics must be those of a disk with as many blades.")
        if k % sectors in values:
            raise fault(what, "must hold every blade or wave once", k, f"On {sectors} sectors {k} is {k % sectors}.")
        real = finite(f"{what}[{k}], real part", np.real(value))
        imaginary = finite(f"{what}[{k}], imaginary part", np.imag(value))
        values[k % sectors] = complex(real, imaginary)
    if not values:
        raise fault(what, "must hold at least one value", "none")
    return values


def _every_wave(what: str, given: Any, sectors: int) -> NDArray[np.complex128]:
    """One value for each nodal diameter, (N,)."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise fault(what, "must be a list, or values by nodal diameter", given)
    numbered = dict(given) if isinstance(given, Mapping) else dict(enumerate(given))
    if len(numbered) != sectors:
        rule = f"must have one value for each of the {sectors} nodal diameters of the disk, those of -n included"
        raise fault(what, rule, f"{len(numbered)} values", "Aerodynamics must be those of a disk with as many blades.")
    values = _by_number(what, numbered, sectors)
    return np.array([values[n] for n in range(sectors)])


def _real(what: str, values: NDArray[np.complex128]) -> Array:
    """The values, of which none is complex."""
    if values.imag.any():
        raise fault(what, "must be real", complex(values[int(np.argmax(np.abs(values.imag)))]))
    return values.real.copy()
