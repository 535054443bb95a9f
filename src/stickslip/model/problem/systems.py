"""The linear structures that the harmonics of a motion see, with all contacts stuck.

Harmonic h of a problem without symmetry sees M, C and K + BᵀK_cB whatever h is. With cyclic symmetry each nodal diameter has
matrices of its own: `disks` holds those kinds.

The mean of some motions friction alone restrains: the axial position of a wedge between two platforms, the roll of a cylinder.
While some contact sticks, friction holds it. Where every contact slips or opens at some time of the period, the forces are the
same wherever the body lies along such a motion: its mean position is not determined, and Newton's method may take it anywhere. A
spring that acts on the mean alone, far softer than the sticking contacts, holds it and leaves the vibration as it is.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.loads import excited_harmonics
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.modes import Modes, definite_modes, gyroscopic_modes, natural_modes, unresisted
from stickslip.support.checks import Array

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
