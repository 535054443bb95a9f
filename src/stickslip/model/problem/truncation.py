"""Modal truncation: a problem on few coordinates, for finite-element models with many contacts. Every contact stays.

The harmonic balance solves for the coordinates of the structure, and contacts feel few of these: its low modes with all contacts
stuck, and what the modes above still add to the deformation of the contact springs.

With φ of the stuck structure, φᵀK'φ = 1, K' = K + BᵀK_cB, a motion Σ z_j φ_j of the modes above stores the energy ½ |z|², and of
that ½ |K_c^½ B Φ z|² in the contact springs. So the squared singular values σ² ≤ 1 of K_c^½ B Φ are the shares of the contacts in
the energy of its right singular vectors. Where σ² is small, releasing all contacts softens the shape by that share only, and
contacts hardly drive it. Shapes above `LEAST_SHARE` are kept, with the static shapes of loads and outputs, and the structure is
projected on all of them (Ritz). What was left out is known afterwards: the highest peaks are solved once more on all modes
(`analyses.truncation`).
"""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.loads import BaseMotion
from stickslip.model.problem.systems import HarmonicSystems, soft_springs
from stickslip.support.checks import Array, InputError, positive

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Problem

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
