"""The linear structures that the harmonics of a motion see, with all contacts stuck.

Harmonic h of a problem without symmetry sees M, C and K + BᵀK_cB whatever h is. With cyclic symmetry each nodal diameter has
matrices of its own: `disks` holds those kinds.

The mean of some motions friction alone restrains: the axial position of a wedge between two platforms, the roll of a cylinder.
While some contact sticks, friction holds it. Where every contact slips or opens at some time of the period, the forces are the
same wherever the body lies along such a motion: its mean position is not determined, and Newton's method may take it anywhere. A
spring that acts on the mean alone, far softer than the sticking contacts, holds it and leaves the vibration as it is.

Modal truncation: a problem on few coordinates, for finite-element models with many contacts. Every contact stays.

The harmonic balance solves for the coordinates of the structure, and contacts feel few of these: its low modes with all contacts
stuck, and what the modes above still add to the deformation of the contact springs.

With φ of the stuck structure, φᵀK'φ = 1, K' = K + BᵀK_cB, a motion Σ z_j φ_j of the modes above stores the energy ½ |z|², and of
that ½ |K_c^½ B Φ z|² in the contact springs. So the squared singular values σ² ≤ 1 of K_c^½ B Φ are the shares of the contacts in
the energy of its right singular vectors. Where σ² is small, releasing all contacts softens the shape by that share only, and
contacts hardly drive it. Shapes above `LEAST_SHARE` are kept, with the static shapes of loads and outputs, and the structure is
projected on all of them (Ritz). What was left out is known afterwards: the highest peaks are solved once more on all modes
(`analyses.truncation`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.loads import BaseMotion, excited_harmonics
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.modes import Modes, definite_modes, gyroscopic_modes, natural_modes, unresisted
from stickslip.support.checks import Array, InputError, positive

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Problem

if TYPE_CHECKING:
    from stickslip.model.problem import Problem


BARELY = 1e-10
"""Share of the contacts' stiffness that holds a structure without contacts, whose K may be singular beside an indefinite M."""


class LinearSystem(NamedTuple):
    """The linear structure of one harmonic with its contacts stuck: M, C, K + BᴴK_cB, (n, n); B (rows, n); outputs (.., n)."""

    M: NDArray[Any]
    C: NDArray[Any]
    K: NDArray[Any]
    B: NDArray[Any]
    outputs: NDArray[Any]

    def without_contacts(self, stiffness: Array) -> NDArray[Any]:
        """K of the structure alone (n, n), the contacts' stiffness K_c (rows,) taken away again."""
        alone: NDArray[Any] = self.K - self.B.conj().T @ (stiffness[:, None] * self.B)
        return alone


class Wave(NamedTuple):
    """An uncoupled part of a structure, z its motion: each sector's share of it, (sectors,), and its own linear system.

    The motion of all sectors is shares ⊗ z, summed over the waves.
    """

    shares: NDArray[np.complex128]
    system: LinearSystem


class HarmonicSystems:
    """The linear systems of a problem by harmonic.

    repeats: after how many delays of one sector against the next the motion repeats itself. sample_multiple: what the number of
    samples must be a multiple of, so that such a delay is a whole number of samples. one_frame: whether x, y and z are
    the same directions at all nodes; those of sectors are turned against each other. one_for_vibration: whether one system serves
    every harmonic but the mean.
    """

    repeats = 1
    sample_multiple = 1
    one_frame = True
    one_for_vibration = True
    gas: Sequence[Any] = ()
    """Gas forces that go with the motion."""

    def __init__(self, problem: "Problem") -> None:
        self.problem = problem

    def enough_samples(self, samples: int) -> int:
        """The number of samples that is used: the next one with which delays between sectors are whole."""
        return samples + -samples % self.sample_multiple

    @property
    def stiffens(self) -> bool:
        """Whether the stiffness goes with the rotor speed, and so with the frequency."""
        return self.problem.speed is not None and self.problem.speed.stiffness is not None

    @property
    def alike(self) -> bool:
        """Whether one real system serves every harmonic, the mean with the mean springs in addition."""
        return not self.stiffens

    def key(self, harmonic: int) -> int:
        """A number that harmonics with one and the same system share."""
        alike = self.alike and not self.problem.mean_springs
        return harmonic if self.stiffens else 0 if alike else min(harmonic, 1)

    def at(self, harmonic: int) -> LinearSystem:
        """The system of a harmonic."""
        problem = self.problem
        stiffness = problem.stuck_stiffness + (problem.mean_stiffness if harmonic == 0 else 0.0)
        added = None if problem.speed is None else problem.speed.stiffness
        return self.stiffened(
            LinearSystem(problem.structure.M, problem.C, stiffness, problem.B, problem.output_rows), harmonic, added
        )

    def stiffened(self, system: LinearSystem, harmonic: int, added: NDArray[Any] | None) -> LinearSystem:
        """The system of a harmonic h at rest with what the speed adds to K, K₁ Ω² = −(i h ω)² K₁/(h EO)², as an effective mass.

        For the mean −(i ω)² K₁/EO²: it sees i ω in place of i h ω (`order`), and no damping.
        """
        if added is None or self.problem.speed is None:
            return system
        share = added / (max(harmonic, 1) * self.problem.speed.engine_order) ** 2
        return system._replace(M=system.M - share) if harmonic else system._replace(M=-share, C=np.zeros_like(system.C))

    def kept(self, harmonic: int) -> tuple[NDArray[Any], int] | None:
        """The shapes (n, kept) on which a truncated problem meets a harmonic, and how many of them are its modes; None where the
        degrees of freedom of the structure are the coordinates."""
        return None

    @property
    def coordinates(self) -> int:
        """How many coordinates each harmonic is solved for."""
        kept = self.kept(self.excited[-1])
        return self.problem.structure.size if kept is None else kept[0].shape[1]

    def order(self, harmonic: int) -> int:
        """k of i k ω at which the system of a harmonic responds: the harmonic, or 1 for a mean that the speed stiffens."""
        return 1 if harmonic == 0 and self.stiffens else harmonic

    def mass(self, harmonic: int) -> NDArray[Any]:
        """M of a harmonic."""
        return self.problem.structure.M

    def free_stiffness(self, harmonic: int) -> NDArray[Any]:
        """K of a vibrating harmonic at rest, without contacts."""
        return self.problem.structure.K

    def without_contacts(self) -> Iterator[tuple[NDArray[Any], NDArray[Any], NDArray[Any]]]:
        """M, K and C of each uncoupled part of the structure at rest, without contacts and gas forces."""
        yield self.problem.structure.M, self.problem.structure.K, self.problem.C

    @property
    def passive(self) -> bool:
        """Whether the damping can feed no motion: damping rules are not negative; gas forces, dashpots and a given C may be."""
        return not self.gas and self.problem.structure.C is None and all(dashpot.c >= 0.0 for dashpot in self.problem.dashpots)

    def vibrating(self) -> Iterator[tuple[str, LinearSystem]]:
        """The systems in which a vibration may grow by itself, each with words that name it."""
        yield "", self.at(1)

    @property
    def uncoupled(self) -> bool:
        """Whether the structure consists of more than one uncoupled wave."""
        return False

    def waves(self, harmonic: int) -> Sequence[Wave]:
        """The uncoupled waves that make up the system of a harmonic."""
        return [Wave(np.ones(1, dtype=complex), self.at(harmonic))]

    def frequencies(self, stuck: bool) -> Array:
        """Natural frequencies in Hz, ascending: of the stuck structure, or of the free one (contacts absent)."""
        if self.stiffens:
            return self.synchronous(stuck)
        coriolis, mesh = self.problem.structure.coriolis, self.problem.mesh
        if coriolis is not None:
            structure = self.problem.structure
            modes = self.stuck_modes if stuck else natural_modes(structure.M, structure.K)
            return gyroscopic_modes(modes, coriolis).frequencies
        found = self.stuck_modes.frequencies if stuck else self._free
        if mesh is None:
            return found
        return found[found <= (mesh.stuck.modes_to if stuck else mesh.stuck.free_to)]  # coordinates above are no modes

    @cached_property
    def stuck_modes(self) -> Modes:
        """Modes with all contacts stuck, at rest."""
        return natural_modes(self.problem.structure.M, self.problem.stuck_stiffness)

    @cached_property
    def _free(self) -> Array:
        """Natural frequencies without contacts, Hz."""
        return natural_modes(self.problem.structure.M, self.problem.structure.K).frequencies

    @property
    def excited(self) -> list[int]:
        """The harmonics that the forces excite, ascending."""
        return sorted(excited_harmonics(self.problem.forces))

    def frequencies_of(self, harmonic: int, stuck: bool) -> Array:
        """Natural frequencies that an excited harmonic meets, Hz, ascending."""
        return HarmonicSystems.frequencies(self, stuck)

    def met(self, stuck: bool) -> Array:
        """Frequencies of the excitation at which one of its harmonics h meets a natural frequency, f/h, Hz, ascending."""
        return np.sort(np.concatenate([self.frequencies_of(h, stuck) / h for h in self.excited]))

    def synchronous(self, stuck: bool, harmonic: int = 1) -> Array:
        """Natural frequencies at the speeds at which a harmonic of the excitation meets them, Hz, ascending; 0 of motions that
        nothing holds."""
        system = self.at(harmonic)
        held = self.problem.contact_stiffness * (1.0 if stuck else BARELY)
        released = self.problem.contact_stiffness - held
        modes = definite_modes(system.M, system.K - system.B.conj().T @ (released[:, None] * system.B))
        if stuck:
            return modes.frequencies
        return np.where(unresisted(self.free_stiffness(harmonic), modes.shapes), 0.0, modes.frequencies)


LOOSE, PRESSING = 1e-9, 1e-6
"""Shares that are rounding: of the structure in the energy of a stuck motion, of the normal motion in that of all contacts."""

SOFT = 1e-3
"""Stiffness of the springs on the mean, relative to that of the sticking contacts along the same motion.

Two finite-element blades on a wedge of which all contacts open (40 kN/m): peaks are the same to 3e-10 with springs a tenth and
ten times as stiff. Softer ones let the wedge move so far that a curve takes up to 28 times as many evaluations.
"""


def loose_motions(problem: "Problem") -> Array:
    """Motions that structure, mean springs and normal directions of contacts leave free, (motions, n), orthonormal.

    Rigid motions of K are those in which it stores none of the energy of the stuck structure, vᵀK v / vᵀK'v = 0, to the rounding
    of K v itself: a soft spring beside stiff contacts holds. Of these, the ones that press no contact are loose.
    """
    stuck = problem.stuck_stiffness + problem.mean_stiffness
    own = problem.structure.K + problem.mean_stiffness
    shares, motions = linalg.eigh(own, stuck)
    rigid = motions[:, (shares <= LOOSE) & unresisted(own, motions)]
    pressing = problem.structure.rows([contact.normal for contact in problem.contacts if contact.normal is not None]) @ rigid
    moving = np.linalg.norm(problem.B @ rigid)
    _, sizes, turned = np.linalg.svd(np.vstack([pressing, np.zeros_like(rigid.T @ rigid)]))
    loose = rigid @ turned[sizes <= PRESSING * moving].T
    return np.asarray(linalg.orth(loose).T)


def soft_springs(problem: "Problem") -> tuple[Spring, ...]:
    """A soft spring for the mean of each loose motion, at one degree of freedom each, so that each holds one of the motions."""
    motions, structure = problem.loose_motions.T, problem.structure
    if not motions.size:
        return ()
    dofs = structure.dofs if structure.shapes is None else structure.dofs[: -structure.size]  # the others are coordinates
    moved = structure.motion(motions)[: len(dofs)]
    held = linalg.qr(moved.T, pivoting=True, mode="r")[1][: motions.shape[1]]
    motions = motions @ np.linalg.inv(moved[held])  # each moves one of these alone, by one
    stiffness = np.einsum("ij,ij->j", motions, problem.stuck_stiffness @ motions)
    return tuple(Spring({dofs[row]: 1.0}, SOFT * float(own)) for row, own in zip(held, stiffness, strict=True))


def lasting_stiffness(problem: "Problem") -> Array | None:
    """The mean springs as springs of all harmonics, (n, n): K_m = B diag(k) Bᵀ, B = K'V (VᵀK'V)⁻¹. V (n, springs) are the motions
    that neither K nor closed contacts resist, to the share `LOOSE`, each of which moves one spring alone, by one. None where the
    springs hold anything else, or are more than ten times `SOFT`, so that the vibration would feel them.
    """
    structure, stuck, k = problem.structure, problem.stuck_stiffness, np.array([each.stiffness for each in problem.mean_springs])
    if not k.size:
        return np.zeros_like(stuck)
    normals = structure.rows([contact.normal for contact in problem.contacts if contact.normal is not None])
    shares, motions = linalg.eigh(structure.K + np.max(problem.contact_stiffness) * (normals.T @ normals), stuck)
    V, moved = motions[:, shares <= LOOSE], structure.rows([each.direction for each in problem.mean_springs]) @ motions
    loose = moved[:, shares <= LOOSE]
    sizes = np.linalg.norm(moved, axis=1, keepdims=True)
    if V.shape[1] != k.size or np.linalg.matrix_rank(loose / sizes, tol=PRESSING) < k.size:
        return None
    V = V @ np.linalg.inv(loose)
    forces = stuck @ V
    B = np.linalg.solve(V.T @ forces, forces.T)
    return None if np.any(k > 10.0 * SOFT * np.diag(V.T @ forces)) else np.asarray(B.T @ (k[:, None] * B))


MANY_ROWS = 150
"""Contact rows from which on a problem is truncated by itself: about fifty contacts with two directions of friction."""

REACH = 3.0
"""How far beyond the highest harmonic of the highest frequency modes are kept whole."""

LEAST_SHARE = 1e-2
"""σ² down to which shapes of the contacts are kept."""

NEGLIGIBLE_LOAD = 1e-6
"""Share of the modes above in the static compliance of a load or an output, below which its shape is left out."""

DEPENDENT = 1e-6
"""Singular value of unit vectors below which one is a combination of the others."""


def on_few_coordinates(problem: "Problem", frequency: float, modes_to: float | None = None) -> "Problem":
    """The problem truncated, its loose means held, where contacts are many; else itself.

    frequency [Hz]: the highest that is balanced, H times that of the excitation; modes_to [Hz]: that of earlier results.
    Patches count with all their nodes, since their highest peaks are solved with all nodes in any case: on few coordinates 144
    rows of patches of two finite-element blades took 13 CPU s, on 996 degrees of freedom 99, and their means were loose.
    """
    if problem.mesh is not None:
        if problem.modes_to not in problem.known_few:
            springs = (*problem.mean_springs, *soft_springs(problem))
            problem.known_few[problem.modes_to or 0.0] = replace(problem, mean_springs=springs)
        return problem.known_few[problem.modes_to or 0.0]
    rows = sum(len(contact.directions) * max(len(contact.nodes), 1) for contact in problem.contacts)
    if problem.modes_to is not None or (modes_to is None and rows < MANY_ROWS):
        return problem
    if modes_to is None and not can_be_truncated(problem):
        return problem
    modes_to = modes_to or REACH * frequency
    if modes_to not in problem.known_few:
        few = truncated(problem, modes_to)
        springs = soft_springs(problem) if type(problem.systems) is HarmonicSystems else ()
        few = replace(few, mean_springs=(*few.mean_springs, *springs))
        problem.known_few[modes_to] = few if few.systems.coordinates < problem.systems.coordinates else problem
    return problem.known_few[modes_to]


def truncated(problem: "Problem", modes_to: float) -> "Problem":
    """The problem on its stuck modes up to a frequency [Hz] and the shapes above that contacts, loads and outputs feel.

    Those of a tuned disk belong to a nodal diameter each: its `systems` find them.
    """
    positive("modes_to", modes_to)
    if not can_be_truncated(problem):
        raise InputError(
            "A problem can be truncated only if it has all its degrees of freedom and no base motion. A full disk, and a disk "
            "whose stiffness varies with the speed, cannot be truncated."
        )
    if type(problem.systems) is not HarmonicSystems:
        return replace(problem, modes_to=modes_to)
    structure = problem.structure
    modes = problem.systems.stuck_modes
    if modes.squares.size == structure.size and np.all(modes.squares > 0.0):
        squares, scaled = 1.0 / modes.squares, modes.shapes / np.sqrt(modes.squares)  # 1/ω², φᵀK'φ = 1
    else:  # massless motions, which follow the others, have shapes too; so has one that is slow beyond rounding
        squares, scaled = linalg.eigh(structure.M, problem.stuck_stiffness)
    loose = problem.loose_motions @ problem.stuck_stiffness
    directions = np.vstack([load_and_output_rows(problem), loose])
    shapes, first = kept_shapes(squares, scaled, problem.B, problem.contact_stiffness, directions, modes_to)
    M, C, K = (shapes.T @ matrix @ shapes for matrix in (structure.M, problem.structural_damping, structure.K))
    speed = problem.speed
    if speed is not None and speed.stiffness is not None:
        speed = replace(speed, stiffness=shapes.T @ speed.stiffness @ shapes)
    coriolis = None if structure.coriolis is None else shapes.T @ structure.coriolis @ shapes
    few = replace(structure, M=M, C=uncoupled_beyond(first, C), K=K, damping=None, shapes=shapes, coriolis=coriolis)
    return replace(problem, structure=few, speed=speed, modes_to=modes_to)


def load_and_output_rows(problem: "Problem") -> Array:
    """The directions of loads and outputs over the degrees of freedom, (rows, n)."""
    highest = max(harmonic for force in problem.forces for harmonic in force.factors)
    harmonic = np.hstack([powers[:, np.any(powers != 0.0, axis=0)] for powers in problem.load_powers(highest)])
    return np.vstack([problem.static_powers, harmonic.T, problem.output_rows])


def kept_shapes(
    squares: Array, scaled: NDArray[Any], B: NDArray[Any], stiffness: Array, directions: NDArray[Any], modes_to: float
) -> tuple[NDArray[Any], int]:
    """The shapes that are kept of one structure, (n, kept), real or complex, and how many of them, the first, are its modes.

    squares, scaled: 1/ω² and modes φ with φᴴK'φ = 1 of the stuck structure; B, stiffness: contact rows and K_c; directions
    (rows, n): loads and outputs, whose static shapes stay.
    """
    low = squares >= (2.0 * np.pi * modes_to) ** -2
    above = scaled[:, ~low]
    sprung = np.sqrt(stiffness)[:, None] * (B @ above)
    shares, vectors = linalg.eigh(sprung.conj().T @ sprung)
    chosen = [vectors[:, shares > LEAST_SHARE]]
    for direction in directions:
        flexible, whole = above.conj().T @ direction, scaled.conj().T @ direction
        if np.linalg.norm(flexible) ** 2 > NEGLIGIBLE_LOAD * np.linalg.norm(whole) ** 2:
            chosen.append(flexible[:, None] / np.linalg.norm(flexible))
    kept, sizes, _ = linalg.svd(np.hstack(chosen), full_matrices=False)
    kept = kept[:, sizes > DEPENDENT]
    # Modes of the kept shapes by themselves, so that the coordinates are natural ones.
    kept = kept @ linalg.eigh(kept.conj().T @ (squares[~low, None] * kept))[1][:, ::-1]
    return np.ascontiguousarray(np.hstack([scaled[:, low], above @ kept])), int(np.count_nonzero(low))


COUPLED = 1e-6
"""Damping between modes and shapes beyond them, of √(c_i c_j), up to which the damping counts as modal."""


def uncoupled_beyond(first: int, C: NDArray[Any]) -> NDArray[Any]:
    """The damping of kept shapes; where it is modal, without what couples the shapes beyond the modes.

    Far from resonance that counts for nothing, and would make all modes complex. Damping that couples modes with these shapes, as
    βK and discrete dampers in C do, stays whole: without a part of it, C could feed energy in.
    """
    sizes = np.sqrt(np.abs(np.diag(C)))
    limits = COUPLED * np.outer(sizes[:first], sizes[first:]) + COUPLED**2 * np.max(sizes, initial=0.0) ** 2
    if np.all(np.abs(C[:first, first:]) <= limits):
        C[first:, first:] = np.diag(np.diag(C[first:, first:]))
    return C


def can_be_truncated(problem: "Problem") -> bool:
    """Whether `truncated` takes a problem. A base moves rows of M that few coordinates no longer have; the sectors of a full disk
    have waves of their own, and where the speed stiffens a disk each harmonic meets other modes at each frequency."""
    moved = any(isinstance(force, BaseMotion) for force in problem.forces)
    one_sector = not problem.systems.one_for_vibration and not problem.systems.stiffens
    return (type(problem.systems) is HarmonicSystems or one_sector) and problem.modes_to is None and not moved
