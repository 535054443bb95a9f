"""A tuned disk under engine-order excitation, solved as one sector.

Engine order EO forces sector j (0..N−1) by F cos(ωt − 2π EO j/N). The steady motion travels along: sector j is late by j EO/N
periods. So harmonic h has nodal diameter h EO mod N, and the far side of a damper sees the neighbour's motion times
exp(−i h 2π EO/N). The linear systems by harmonic are those of one sector, or of all sectors together.

A disk with every sector of its own: all sectors together, tuned or mistuned.

A whole disk on few coordinates of each nodal diameter, for mistuned finite-element disks: every contact and blade stays.

A disk of N sectors with m degrees of freedom each has matrices of N m rows, the third power of which a mode analysis takes. The
motion of the mistuned disk lies, but for little, in that of the tuned one at all nodal diameters n, q_n = T_n y_n, T_n (m, k):
its stuck modes up to a frequency, and what the modes above add to the deformation of contacts, blades, loads and outputs
(`problem/systems.py` has the equations). The coordinates y of all sectors stand for a real structure again, whose
matrices Tᴴ A T are circulant until sectors deviate (Ritz). Dampers keep their own degrees of freedom, so that one may be missing.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from math import gcd
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.contact.point import Contact, OnSurface, TractionRatio
from stickslip.model.loads import BaseMotion, Force, Output, excited_harmonics
from stickslip.model.problem import Problem, modal_damping_matrix
from stickslip.model.problem.speed import SpeedDependence
from stickslip.model.problem.systems import HarmonicSystems, LinearSystem, Wave, kept_shapes, load_and_output_rows
from stickslip.model.structure.aerodynamics import Aerodynamics, WaveStiffness
from stickslip.model.structure.cyclic import NEXT, CyclicStructure, WaveMatrices, Waves, circulant, of_all_sectors, sector_name
from stickslip.model.structure.matrices import ModalDamping, RayleighDamping, Structure
from stickslip.model.structure.mesh_surface import SectorSurface
from stickslip.model.structure.modes import Modes, natural_modes
from stickslip.model.structure.stress import StressRecovery
from stickslip.support.checks import Array, InputError, between, fault, finite_complex, first_of, of_kind, several, unique, whole

SAME = 1e-10
"""How far the blocks of a circulant matrix may differ, relative to its largest entry: rounding."""


def repeats(sectors: int, engine_order: int) -> int:
    """After how many sectors the motion under an engine order is in phase again, N / gcd(N, EO)."""
    return sectors // gcd(sectors, engine_order)


class SectorSystems(HarmonicSystems):
    """Systems of one sector of a tuned disk: harmonic h sees nodal diameter h EO mod N."""

    alike = False
    one_frame = False
    one_for_vibration = False

    def __init__(self, disk: "TunedDisk") -> None:
        super().__init__(disk)
        self.disk, self.engine_order, self.sectors, self.gas = disk.disk, disk.engine_order, disk.sectors, disk.wave_stiffnesses
        self.repeats = self.sample_multiple = repeats(disk.sectors, disk.engine_order)
        self._known: dict[int, LinearSystem] = {}
        self._modes: dict[tuple[int, bool], Modes] = {}
        self._kept: dict[int, tuple[NDArray[Any], int]] = {}

    def key(self, harmonic: int) -> int:
        """The nodal diameter of a harmonic; −1 for harmonic 0 where springs act on the mean alone, or gas forces on vibration."""
        if self.stiffens:
            return harmonic
        return -1 if harmonic == 0 and (self.problem.mean_springs or self.gas) else harmonic * self.engine_order % self.sectors

    def at(self, harmonic: int) -> LinearSystem:
        """The system of a harmonic, computed once for all that share it."""
        key = self.key(harmonic)
        if key not in self._known:
            n = harmonic * self.engine_order
            M, stuck, C = self.matrices(n)
            assert C is not None
            if harmonic == 0:
                stuck = stuck + self.problem.mean_stiffness
            else:
                gas_stiffness, gas_damping = self.gas_forces(n)
                stuck, C = stuck + gas_stiffness, C + gas_damping
            system = LinearSystem(M, C, stuck, self.relative_rows(n), self.problem.output_rows)
            speed = self.problem.speed
            added = None if speed is None or speed.stiffness is None else self.disk.diameters.pick(speed.stiffness, n)
            self._known[key] = self.stiffened(system, harmonic, added)
        return self._known[key]

    def kept(self, harmonic: int) -> tuple[NDArray[Any], int] | None:
        """Those of the nodal diameter of a harmonic, found once."""
        problem = self.problem
        if problem.modes_to is None:
            return None
        key = self.key(harmonic)
        if key not in self._kept:
            system = self.at(harmonic)
            M, K, B = (part if np.any(part.imag) else part.real for part in (system.M, system.K, system.B))
            squares, scaled = linalg.eigh(M, K)
            directions = load_and_output_rows(problem)
            self._kept[key] = kept_shapes(squares, scaled, B, problem.contact_stiffness, directions, problem.modes_to)
        return self._kept[key]

    def mass(self, harmonic: int) -> NDArray[np.complex128]:
        return self.disk.at(harmonic * self.engine_order).M

    def vibrating(self) -> Iterator[tuple[str, LinearSystem]]:
        """Waves of every nodal diameter that the disk holds, which gas forces may feed whatever the excitation is."""
        for n in [*(-n for n in reversed(self.disk.diameters.held) if 0 < 2 * n < self.sectors), *self.disk.diameters.held]:
            M, stuck, C = self.matrices(n)
            assert C is not None
            stiffness, damping = self.gas_forces(n)
            rows = self.relative_rows(n), self.problem.output_rows
            yield f" of nodal diameter {n}", LinearSystem(M, C + damping, stuck + stiffness, *rows)

    def without_contacts(self) -> Iterator[tuple[NDArray[Any], NDArray[Any], NDArray[Any]]]:
        """Those of every nodal diameter that the disk holds; N − n has the conjugates of n."""
        for n in self.disk.diameters.held:
            M, _, C = self.matrices(n)
            assert C is not None
            yield M, self.disk.at(n).K, C

    def free_stiffness(self, harmonic: int) -> NDArray[np.complex128]:
        return self.disk.at(harmonic * self.engine_order).K

    def gas_forces(self, nodal_diameter: int) -> tuple[Array, Array]:
        """What gas forces that go with the motion add to K and C of a nodal diameter, (n, n)."""
        stiffness, damping = np.zeros((2, self.disk.size, self.disk.size))
        for gas in self.gas:
            parts = gas.matrices(nodal_diameter, self.disk.row(gas.direction))
            stiffness, damping = stiffness + parts[0], damping + parts[1]
        return stiffness, damping

    def relative_rows(self, nodal_diameter: int) -> NDArray[np.complex128]:
        """B of a nodal diameter: relative contact displacements per motion of the sector, (rows, n)."""
        phase = np.exp(-2j * np.pi * (nodal_diameter % self.sectors) / self.sectors)
        rows = [self.disk.phased_row(d, phase) for contact in self.problem.contacts for d in contact.directions]
        return np.array(rows, dtype=complex).reshape(len(rows), self.disk.size)

    def matrices(self, nodal_diameter: int) -> WaveMatrices:
        """M, K + BᴴK_cB and C (the damping rule applied) of a nodal diameter, (n, n) complex."""
        bare, stuck = self.disk.at(nodal_diameter), self.stuck_stiffness(nodal_diameter)
        C = np.zeros_like(bare.M) if bare.C is None else bare.C
        match self.disk.damping:
            case RayleighDamping(mass_factor=a, stiffness_factor=b):
                C = np.asarray(a * bare.M + b * bare.K)
            case ModalDamping() as rule:
                C = np.asarray(modal_damping_matrix(bare.M, self.modes(nodal_diameter, rule.on == "stuck"), rule))  # type: ignore[arg-type]
        return WaveMatrices(bare.M, stuck, C)

    def stuck_stiffness(self, nodal_diameter: int) -> NDArray[np.complex128]:
        """K + BᴴK_cB of a nodal diameter."""
        B = self.relative_rows(nodal_diameter)
        return np.asarray(self.disk.at(nodal_diameter).K + B.conj().T @ (self.problem.contact_stiffness[:, None] * B))

    def modes(self, nodal_diameter: int, stuck: bool = True) -> Modes:
        """Natural modes of a nodal diameter with all contacts stuck, or without them; complex shapes of one sector."""
        n = nodal_diameter % self.sectors
        if (n, stuck) not in self._modes:
            bare = self.disk.at(n)
            self._modes[n, stuck] = natural_modes(bare.M, self.stuck_stiffness(n) if stuck else bare.K)  # type: ignore[arg-type]
        return self._modes[n, stuck]

    def frequencies(self, stuck: bool) -> Array:
        """Natural frequencies of all nodal diameters that the engine orders excite, Hz, ascending."""
        folded = {h: h * self.engine_order % self.sectors for h in self.excited}
        diameters = {h if self.stiffens else min(n, self.sectors - n): h for h, n in folded.items()}
        return np.sort(np.concatenate([self.frequencies_of(h, stuck) for h in diameters.values()]))

    def frequencies_of(self, harmonic: int, stuck: bool) -> Array:
        """Natural frequencies of the nodal diameter of a harmonic, Hz, ascending; where the speed stiffens them, those at which
        this harmonic meets them."""
        if self.stiffens:
            return self.synchronous(stuck, harmonic)
        return self.modes(harmonic * self.engine_order, stuck).frequencies


class AllSectorSystems(HarmonicSystems):
    """Systems of all sectors of a disk: N uncoupled waves of a sector's size where they are equal, else one large system."""

    one_frame = False

    def __init__(self, disk: "FullDisk") -> None:
        super().__init__(disk)
        self.sectors, self.gas = disk.sectors, disk.aerodynamics
        self.sample_multiple = repeats(disk.sectors, disk.engine_order)

    @property
    def alike(self) -> bool:
        """Whether one real system serves every harmonic: gas forces that go with the motion do not act on the mean."""
        return super().alike and not self.gas

    def at(self, harmonic: int) -> LinearSystem:
        """The system of a harmonic; complex Hermitian where gas forces go with the motion."""
        system = super().at(harmonic)
        if harmonic == 0 or not self.gas:
            return system
        stiffness, damping = self.gas_forces
        return system._replace(K=system.K + stiffness, C=system.C + damping)

    @cached_property
    def gas_forces(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """What gas forces that go with the motion add to K and C of the whole disk, (n, n)."""
        structure, size = self.problem.structure, self.problem.structure.size
        stiffness, damping = np.zeros((2, size, size), dtype=complex)
        for gas in self.gas:
            named = [{sector_name(j, dof): c for dof, c in gas.direction.items()} for j in range(1, self.sectors + 1)]
            rows = structure.rows(named)
            parts = gas.between_sectors()
            stiffness, damping = stiffness + rows.T @ parts[0] @ rows, damping + rows.T @ parts[1] @ rows
        return stiffness, damping

    @cached_property
    def uncoupled(self) -> bool:
        """Whether structure, damping and contact stiffness of all sectors are alike, to rounding."""
        problem = self.problem
        matrices = [problem.structure.M, problem.C, problem.stuck_stiffness]
        if problem.speed is not None and problem.speed.stiffness is not None:
            matrices.append(problem.speed.stiffness)
        return all(_is_circulant(matrix, self.sectors) for matrix in matrices)

    def waves(self, harmonic: int) -> Sequence[Wave]:
        """N small systems, one for each nodal diameter, instead of a large one; of a mistuned disk the large one."""
        if not self.uncoupled:
            return super().waves(harmonic)
        whole = self.at(harmonic)
        N = self.sectors
        # Blocks (j, 0) of a circulant matrix times exp(+i n 2π j/N), summed; rows of B and outputs times exp(−i n 2π j/N)/√N.
        M, C, K = (N * np.fft.ifft(matrix.reshape(N, -1, N, matrix.shape[1] // N)[:, :, 0], axis=0) for matrix in whole[:3])
        B, outputs = (np.fft.fft(rows.reshape(rows.shape[0], N, rows.shape[1] // N), axis=1) / np.sqrt(N) for rows in whole[3:])
        turns = np.exp(-2j * np.pi * np.outer(np.arange(N), np.arange(N)) / N) / np.sqrt(N)
        M, C, K = (0.5 * (blocks + blocks.conj().swapaxes(1, 2)) for blocks in (M, C, K))
        return [Wave(turns[n], LinearSystem(M[n], C[n], K[n], B[:, n], outputs[:, n])) for n in range(N)]


def _is_circulant(matrix: Array, sectors: int) -> bool:
    """Whether block (j, k) of a matrix depends on j − k alone, to rounding."""
    size, rest = divmod(matrix.shape[0], sectors)
    if rest:
        return False
    blocks = matrix.reshape(sectors, size, sectors, size)
    turned = np.roll(blocks, (1, 1), axis=(0, 2))
    return bool(np.abs(turned - blocks).max() <= SAME * np.abs(blocks).max(initial=1e-300))


@dataclass(frozen=True, eq=False, repr=False)
class FullDisk(Problem):
    """A disk with all its sectors, tuned or mistuned: a `Problem` that knows how many there are and what excites them.

    aerodynamics: gas forces that go with the motion, by wave; mistuning leaves them as they are. surface: of a meshed sector, for
    pictures. stresses: at places of one sector, from the motion of its waves.
    """

    sectors: int = 1
    engine_order: int = 0
    aerodynamics: tuple[WaveStiffness, ...] = ()
    surface: SectorSurface | None = None
    stresses: tuple[StressRecovery, ...] = ()

    def __repr__(self) -> str:
        return f"{super().__repr__()}; {self.sectors} sectors, engine order {self.engine_order}"

    @cached_property
    def systems(self) -> AllSectorSystems:
        return AllSectorSystems(self)

    @cached_property
    def fingerprint(self) -> str:
        """As of any problem, with the gas forces that go with the motion."""
        if not self.aerodynamics:
            return super().fingerprint
        return sha256(f"{super().fingerprint} {self.aerodynamics!r}".encode()).hexdigest()[:16]

    @property
    def tuned(self) -> bool:
        """Whether structure, damping and contact stiffness of all sectors are alike, to rounding."""
        return self.systems.uncoupled


def full_structure(
    disk: CyclicStructure, dampings: NDArray[np.complex128] | None = None, shapes: Waves | None = None
) -> Structure:
    """All sectors of a disk as one real structure, names "SECTOR/NODE.DIRECTION"; dampings: C of each nodal diameter; shapes:
    coordinates of each nodal diameter on which the disk is projected, (N//2 + 1, m, k) (`few_waves`)."""
    M, K = (circulant(projected(disk.every(waves), shapes), disk.sectors) for waves in (disk.masses, disk.stiffnesses))
    C = None if dampings is None or not dampings.any() else circulant(projected(dampings, shapes), disk.sectors)
    names = tuple(sector_name(j, dof) for j in range(1, disk.sectors + 1) for dof in disk.dofs)
    return Structure(M, K, names, C, shapes=None if shapes is None else of_all_sectors(shapes, disk.sectors))


def projected(waves: Waves, shapes: Waves | None) -> Waves:
    """Tᴴ A T of each nodal diameter, (N//2 + 1, k, k); A itself without shapes T."""
    return waves if shapes is None else np.asarray(shapes.conj().swapaxes(1, 2) @ waves @ shapes)


MOST_NAMED = 6
"""Engine orders that a title names."""


@dataclass(frozen=True)
class SeveralOrders:
    """Engine orders, ascending, with the forces of one order and those under all of them."""

    orders: tuple[int, ...]
    single: tuple[Force, ...]
    forces: tuple[Force, ...]


@dataclass(frozen=True, eq=False, repr=False)
class TunedDisk(Problem):
    """A disk of equal sectors and dampers under engine-order excitation, solved as one sector.

    structure: a `CyclicStructure`. Contacts, forces and outputs are those of the first sector; a contact between a sector and the
    following one names the latter's degrees of freedom with the prefix "next/". Its `load` is that on the first sector.
    surface: of a meshed sector, for pictures. aerodynamics: gas forces that go with the motion of all blades. several_orders: as
    `with_engine_orders` sets it.
    """

    engine_order: int = 1
    surface: SectorSurface | None = None
    aerodynamics: tuple[Aerodynamics, ...] = ()
    several_orders: SeveralOrders | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.structure, CyclicStructure):
            raise InputError("A tuned disk must have a cyclic structure. Make it by `cyclic` or `sector_chain`.")
        check_engine_order(self.engine_order, self.sectors)
        if self.dashpots or any(isinstance(force, BaseMotion) for force in self.forces):
            raise InputError("A tuned disk must be without dashpots and base motion. Put dampers into the sector's C.")
        loads, outputs = [force.coefficients for force in self.forces], [Output.of(output).direction for output in self.outputs]
        for what, directions in (("A force", loads), ("An output", outputs)):
            beyond = sorted(dof for direction in directions for dof in direction if dof.startswith(NEXT))
            if beyond:
                raise fault(what, "must act on the sector itself", beyond)
        object.__setattr__(self, "aerodynamics", several("aerodynamics", self.aerodynamics))
        for given in self.aerodynamics:
            of_kind("aerodynamics", given, Aerodynamics)
        _ = self.wave_stiffnesses
        super().__post_init__()

    def __repr__(self) -> str:
        return f"{super().__repr__()}; one of {self.sectors} sectors, {self.orders_in_words}"

    @property
    def orders_in_words(self) -> str:
        """`engine order 2`, `engine orders 2 and 3`, or the first of many."""
        orders = [str(order) for order in self.excited_orders]
        if len(orders) == 1:
            return f"engine order {orders[0]}"
        listed = first_of(orders, MOST_NAMED) if len(orders) > MOST_NAMED else f"{', '.join(orders[:-1])} and {orders[-1]}"
        return f"engine orders {listed}"

    @property
    def heading(self) -> str:
        said = self.orders_in_words in self.title
        return self.title if said else ", ".join(filter(None, (self.title, self.orders_in_words)))

    @property
    def disk(self) -> CyclicStructure:
        """The structure, as what it is."""
        assert isinstance(self.structure, CyclicStructure)
        return self.structure

    @property
    def sectors(self) -> int:
        return self.disk.sectors

    def _stiffened(self, added: NDArray[Any]) -> CyclicStructure:
        waves = np.array([self.systems.matrices(n).C for n in self.disk.diameters.held])
        stiffened = replace(self.disk, K=self.disk.K + added[0].real, stiffnesses=self.disk.whole_stiffness + added)
        return stiffened.with_damping(waves)

    @cached_property
    def wave_stiffnesses(self) -> tuple[WaveStiffness, ...]:
        """The gas forces as complex stiffnesses of the waves of this disk."""
        return tuple(given.on(self.disk) for given in self.aerodynamics)

    @cached_property
    def systems(self) -> SectorSystems:
        return SectorSystems(self)

    def modes(self, nodal_diameter: int, stuck: bool = True) -> Modes:
        """Natural modes of a nodal diameter with all contacts stuck, or without them; complex shapes of one sector."""
        return self.systems.modes(nodal_diameter, stuck)

    def frequencies_by_order(self, stuck: bool) -> dict[int, NDArray[np.float64]]:
        """{EO: natural frequencies in Hz of its nodal diameter, EO mod N, ascending}, as `frequencies`."""
        harmonics = zip(self.excited_orders, self.systems.excited, strict=True)
        return {order: self.systems.frequencies_of(harmonic, stuck) for order, harmonic in harmonics}

    @cached_property
    def fingerprint(self) -> str:
        """As of any problem, with the matrices of every nodal diameter and the engine order."""
        digest = sha256(super().fingerprint.encode())
        disk = self.disk
        for waves in (disk.masses, disk.stiffnesses, disk.dampings, self.systems.relative_rows(1)):
            digest.update(b"" if waves is None else np.ascontiguousarray(waves).tobytes())
        digest.update(b"" if disk.diameters.complete else repr(disk.diameters.held).encode())
        digest.update(f"engine order {self.engine_order} of {self.sectors}".encode())
        digest.update(b"" if self.modes_to is None else f"modes to {self.modes_to!r} Hz".encode())
        if self.aerodynamics:
            digest.update(repr(self.wave_stiffnesses).encode())
        return digest.hexdigest()[:16]

    def with_engine_order(self, engine_order: int) -> Self:
        """A copy under another engine order, and that alone."""
        return replace(self, forces=self._forces_of_one_order, engine_order=engine_order, several_orders=None)

    def with_engine_orders(self, amplitudes: Mapping[int, complex]) -> Self:
        """A copy under several engine orders at once: p_j(t) = Re Σ_EO a_EO F exp(i EO (Ωt − 2πj/N)), Ω the rotor speed.

        amplitudes: {EO: a_EO}, complex factors on the first harmonic F of each force. All engine orders are harmonics EO/g of one
        excitation g Ω, g their greatest common divisor, which is the `engine_order` of the copy, modulo N: a frequency f of its
        response belongs to the speed 60 f/g rev/min, and `harmonics` must hold each EO/g. Where no engine order is g, peaks
        are those of `measure="max_abs"` or "rms", since the first harmonic is not excited.
        """
        if not isinstance(amplitudes, Mapping):
            raise fault("engine orders", "must be a dict {engine order: complex factor}", amplitudes)
        given = {
            between("engine order", order, 1): finite_complex(f"The factor of engine order {order}", amplitude)
            for order, amplitude in amplitudes.items()
        }
        orders = tuple(sorted(order for order, amplitude in given.items() if amplitude))
        if not orders:
            raise fault("engine orders", "must hold at least one with a factor other than zero", given)
        common, single = gcd(*orders), self._forces_of_one_order
        forces = tuple(_under_orders(force, {order // common: given[order] for order in orders}) for force in single)
        return replace(
            self,
            forces=forces,
            engine_order=common % self.sectors,
            speed=None if self.speed is None else replace(self.speed, engine_order=common),
            several_orders=SeveralOrders(orders, single, forces),
        )

    @property
    def _forces_of_one_order(self) -> tuple[Force, ...]:
        """The forces as they were before `with_engine_orders`."""
        given = self.several_orders
        return self.forces if given is None or given.forces != self.forces else given.single

    @property
    def excited_orders(self) -> tuple[int, ...]:
        """The engine orders that the forces excite, ascending."""
        given = self.several_orders
        if given is not None and given.forces == self.forces:
            return given.orders
        return tuple(harmonic * self.engine_order for harmonic in sorted(excited_harmonics(self.forces)))

    def with_blade_rows(self, pressures: Mapping[int, Sequence[complex]]) -> Self:
        """A copy under the wakes of neighbouring blade rows: a row of V blades excites the engine orders V, 2V, 3V, ...

        pressures: {V: (a_1, a_2, ...)}, the harmonics of the blade passing as complex factors on the first harmonic of a force;
        equal engine orders of two rows add. Frequencies and harmonics as of `with_engine_orders`.
        """
        if not isinstance(pressures, Mapping):
            raise fault("blade rows", "must be a dict {number of blades: (pressure harmonics, ...)}", pressures)
        amplitudes: dict[int, complex] = {}
        for blades, harmonics in pressures.items():
            for k, amplitude in enumerate(several(f"The pressures of {blades} blades", harmonics), start=1):
                order = k * between("number of blades", blades, 1)
                factor = finite_complex(f"Pressure {k} of {blades} blades", amplitude)
                amplitudes[order] = amplitudes.get(order, 0.0) + factor
        return self.with_engine_orders(amplitudes)

    def with_aerodynamics(self, *aerodynamics: Aerodynamics) -> Self:
        """A copy with other gas forces that go with the motion; none given: without them."""
        return replace(self, aerodynamics=aerodynamics)

    def full(self, reported: Sequence[int] | None = None, shapes: Waves | None = None) -> "FullDisk":
        """The whole disk, every sector and damper of its own, names "SECTOR/NODE.DIRECTION", sectors from 1 on.

        reported: sectors whose outputs are reported, all unless given. The structure, damping and loads are those of the tuned
        disk; `with_structure` and `with_contacts` then detune it. shapes: few coordinates of each nodal diameter (`few_waves`) to
        which the structure is reduced.
        """
        sectors = range(1, self.sectors + 1)
        chosen = sectors if reported is None else sectors_of("reported", reported, self.sectors) or sectors
        self.disk.diameters.require_all()
        waves = [self.systems.matrices(n).C for n in self.disk.diameters.held]
        structure = full_structure(self.disk, np.array(waves), shapes)
        contacts = tuple(self._contact(contact, j) for j in sectors for contact in self.contacts)
        forces = []
        for j in sectors:
            turn = np.exp(-2j * np.pi * self.engine_order * (j - 1) / self.sectors)
            for force in self.forces:
                amplitudes = {h: amplitude * turn**h for h, amplitude in force.amplitudes.items()}
                forces.append(replace(force, direction=self._named(force.coefficients, j), amplitude=amplitudes))
        one = [Output.of(output) for output in self.outputs]
        outputs = tuple(Output(f"{j}/{output.name}", self._named(output.direction, j)) for j in chosen for output in one)
        speed = self.speed
        if speed is not None:  # K₁ of the nodal diameters together, and the loads of each sector
            added = None if speed.stiffness is None else circulant(projected(speed.stiffness, shapes), self.sectors)
            loads = [replace(load, direction=self._named(load.coefficients, j)) for j in sectors for load in speed.loads]
            speed = SpeedDependence(speed.engine_order, added, tuple(loads))
        return FullDisk(
            structure,
            contacts,
            tuple(forces),
            outputs,
            f"{self.heading}, all {self.sectors} sectors",
            tuple(replace(spring, direction=self._named(spring.direction, j)) for j in sectors for spring in self.mean_springs),
            self.sectors,
            self.engine_order,
            self.wave_stiffnesses,
            self.surface,
            self.disk.stresses,
            speed=speed,
        )

    def _named(self, direction: Mapping[str, float], sector: int) -> dict[str, float]:
        """A direction of the first sector in the names of another one and of the one that follows it."""
        following = sector % self.sectors + 1
        return {
            sector_name(following if dof.startswith(NEXT) else sector, dof.removeprefix(NEXT)): coefficient
            for dof, coefficient in direction.items()
        }

    def _contact(self, contact: Contact, sector: int) -> Contact:
        """A contact of the first sector in another one."""
        if sector > 1 and any(isinstance(start, TractionRatio) for start in contact.starts):
            raise InputError(
                "Start states of a full disk must be slider offsets or mean tractions, but contact "
                f"{contact.name!r} has a traction ratio, which is tied to the last sample of the first sector, not of the others."
            )
        tangential = tuple(self._named(direction, sector) for direction in contact.tangential)
        normal = None if contact.normal is None else self._named(contact.normal, sector)
        part = contact.surface and OnSurface(contact.surface.name, contact.surface.share, contact.surface.further)
        return replace(contact, name=f"{sector} {contact.name}", tangential=tangential, normal=normal, nodes=(), surface=part)


def _under_orders(force: Force, factors: Mapping[int, complex]) -> Force:
    """A force whose first harmonic becomes several, {harmonic: factor}."""
    if not any(force.amplitudes.values()):
        return force
    if set(force.amplitudes) != {1}:
        raise fault(
            f"The force {force.name or force.direction!r}", "must have the first harmonic alone", sorted(force.amplitudes)
        )
    return replace(force, amplitude={h: factor * force.amplitudes[1] for h, factor in factors.items()})


def check_engine_order(order: object, sectors: int) -> None:
    """Refuse one that is not a whole number from 0 to N."""
    is_whole = isinstance(order, int | np.integer) and not isinstance(order, bool)
    if not is_whole or not 0 <= order <= sectors:  # type: ignore[operator]
        rule = f"must be a whole number and lie between 0 and the number of sectors, {sectors}"
        raise fault("engine_order", rule, order, "Engine order EO + N acts as EO does, turn by turn.")


def sectors_of(what: str, given: Sequence[int], sectors: int) -> tuple[int, ...]:
    """Sectors of a disk, each from 1 to `sectors` and given once."""
    numbers = tuple(whole(what, sector) for sector in several(what, given))
    unknown = [sector for sector in numbers if not 1 <= sector <= sectors]
    if unknown:
        raise fault(what, f"must hold sectors from 1 to {sectors}", unknown)
    unique(what, numbers)
    return numbers


LEAST_SHARE = 1e-4
"""Share of the energy of a shape that deforms contacts and blades, or of a load's compliance, down to which it is kept."""

REACH = 6.0
"""How far beyond the highest harmonic of the highest frequency modes are kept whole. With 3 the amplitudes of a wheel of 1836
degrees of freedom are 8e-7 off those on all of them, with 6 by 2e-7."""

LARGE = 2000
"""Degrees of freedom of a whole disk from which on it is put on few coordinates."""


def few_waves(disk: "TunedDisk", modes_to: float, blade: Sequence[str] = (), deviation: float = 0.0) -> Waves:
    """T_n of each nodal diameter, (N//2 + 1, m, k), with k the same for all.

    modes_to [Hz]: natural frequency up to which the modes of every nodal diameter are kept whole; blade: degrees of freedom of a
    sector that make up its blade, whose frequency deviates by about `deviation`, relative.
    """
    waves = [_StuckWave.of(disk, n, blade, deviation) for n in range(disk.sectors // 2 + 1)]
    low = max(int(np.count_nonzero(wave.squares >= (2.0 * np.pi * modes_to) ** -2)) for wave in waves)
    above = [wave.above(low) for wave in waves]
    more = max(int(np.count_nonzero(shares > LEAST_SHARE)) for _, shares in above)
    few = [np.hstack([wave.modes[:, :low], shapes[:, :more]]) for wave, (shapes, _) in zip(waves, above, strict=True)]
    return np.array([_with_damper(disk, shapes) for shapes in few], dtype=complex)


def most_coordinates(disk: "TunedDisk", modes_to: float, blade: Sequence[str]) -> int:
    """An upper bound of k of `few_waves`, from the nodal diameter that is excited."""
    modes = int(np.count_nonzero(disk.frequencies(stuck=True) <= modes_to))
    return modes + len(disk.contact_stiffness) + len(disk.forces) + len(disk.outputs) + len(blade) + len(loose_dofs(disk))


@dataclass(frozen=True, eq=False)
class _StuckWave:
    """A nodal diameter with all contacts stuck: squares 1/ω² (m,), descending, and modes with φᴴK'φ = 1 (m, m); rows (rows, m)
    whose squared product with a shape is what it adds, as a share, to the energy of contacts and blades or to a compliance."""

    squares: Array
    modes: NDArray[Any]
    rows: NDArray[Any]

    @classmethod
    def of(cls, disk: "TunedDisk", n: int, blade: Sequence[str], deviation: float) -> Self:
        M: NDArray[Any] = disk.disk.at(n).M
        stuck: NDArray[Any] = disk.systems.stuck_stiffness(n)
        B: NDArray[Any] = disk.systems.relative_rows(n)
        if not (M.imag.any() or stuck.imag.any()):  # of nodal diameters 0 and N/2 the shapes are real
            M, stuck, B = M.real, stuck.real, B.real
        squares, modes = linalg.eigh(M, stuck)
        squares, modes = squares[::-1], modes[:, ::-1]
        loads = [force.coefficients for force in disk.forces] + [Output.of(output).direction for output in disk.outputs]
        directions = disk.structure.rows(loads)
        rows = [np.sqrt(disk.contact_stiffness)[:, None] * B, directions / np.linalg.norm(directions @ modes, axis=1)[:, None]]
        if blade and deviation:
            bent, K_bb = (part if np.iscomplexobj(M) else part.real for part in blade_motion(disk, n, blade))
            rows.append(np.sqrt(2.0 * deviation) * linalg.cholesky(K_bb) @ bent)
        return cls(np.asarray(squares, dtype=float), modes, np.vstack(rows))

    def above(self, low: int) -> tuple[NDArray[Any], Array]:
        """The shapes of all modes above the first `low`, those that matter most first, and their shares."""
        vectors, sizes, _ = linalg.svd((self.rows @ self.modes[:, low:]).conj().T)
        return self.modes[:, low:] @ vectors, np.pad(sizes**2, (0, len(vectors) - sizes.size))


def blade_motion(disk: "TunedDisk", n: int, blade: Sequence[str]) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """How a blade b moves relative to the rest, [I −Ψ] = K_bb⁻¹ K_b of nodal diameter n, (b, m), and K_bb."""
    K, b = disk.disk.at(n).K, [disk.structure.index(dof) for dof in blade]
    K_bb = K[np.ix_(b, b)]
    return np.asarray(linalg.solve(K_bb, K[b], assume_a="pos")), K_bb


def loose_dofs(disk: "TunedDisk") -> list[str]:
    """Degrees of freedom of a sector that no stiffness holds but that of contacts: its damper."""
    held = np.abs(np.asarray(disk.disk.stiffnesses)).max(axis=(0, 2))
    return [dof for dof, stiffness in zip(disk.structure.dofs, held, strict=True) if stiffness == 0.0]


def _with_damper(disk: "TunedDisk", shapes: NDArray[Any]) -> NDArray[Any]:
    """Shapes (m, k + d) whose span holds those given (m, k) and every motion of the d degrees of freedom of the damper alone."""
    loose = [disk.structure.index(dof) for dof in loose_dofs(disk)]
    held = np.setdiff1d(np.arange(len(shapes)), loose)
    scales = np.sqrt(np.diag(disk.disk.at(0).K).real[held])[:, None]
    spanned = linalg.svd(scales * shapes[held], full_matrices=False)[0] / scales
    whole = np.zeros((len(shapes), spanned.shape[1] + len(loose)), dtype=shapes.dtype)
    whole[held, : spanned.shape[1]] = spanned
    whole[loose, spanned.shape[1] + np.arange(len(loose))] = 1.0
    return whole
