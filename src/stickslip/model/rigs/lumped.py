"""Lumped rigs for hand calculation: one mass, chains of masses, two blades with a wedge damper.

The chains and the single mass are the problems on which harmonic balance codes are compared and timed.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, radians, sin

import numpy as np

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, between
from stickslip.model.contact.start import Start, TractionRatio
from stickslip.model.dampers.wedge import wedge_outline
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import Array, fault


def single_mass(
    mass: float = 1.0, damping: float = 0.02, stiffness: float = 1.0, kt: float = 1.0, limit: float = 1.0, force: float = 1.0
) -> Problem:
    """One mass with spring and viscous damper to ground and a Jenkins element (kt, slip limit μN) beside them.

    mass [kg], damping [N s/m], stiffness, kt [N/m], limit, force amplitude (cosine) [N]. The defaults are the benchmark.
    """
    M, K, C = (np.array([[value]], dtype=float) for value in (mass, stiffness, damping))
    structure = Structure(M, K, ("1.x",), C=C)
    return Problem(structure, (_slider("1.x", "ground", kt, limit),), (Force("1.x", force),), ("1.x",), "Single mass")


def chain(
    masses: int = 20,
    sliders: Sequence[int] = tuple(range(11, 21)),
    kt: float = 0.5,
    limit: float = 1.0,
    forced: int = 10,
    force: float = 1.0,
) -> Problem:
    """Unit masses in a row, springs 1 from ground to mass 1 and on to the free last mass, C = 0.01 K.

    sliders: masses with a Jenkins element to ground (kt [N/m], slip limit μN [N]); forced: the mass that carries the
    cosine force [N] and is reported.
    """
    _check_masses(masses, (*sliders, forced))
    K = chain_stiffness(masses)
    dofs = tuple(f"{i}.x" for i in range(1, masses + 1))
    contacts = tuple(_slider(f"{i}.x", "ground", kt, limit) for i in sliders)
    structure = Structure(np.eye(masses), K, dofs, C=0.01 * K)
    return Problem(structure, contacts, (Force(f"{forced}.x", force),), (f"{forced}.x",), f"Chain of {masses} masses")


def chain_varying_load(
    masses: int = 20,
    touching: Sequence[int] = tuple(range(11, 21)),
    kt: float = 0.5,
    kn: float = 1.0,
    mu: float = 0.5,
    preload: float = 2.0,
    forced: int = 10,
    force: float = 1.0,
    normal_force: float = 1.0,
) -> Problem:
    """The chain with a second direction y per mass (grounded by a spring 1), which loads and unloads friction along x.

    touching: masses on friction contacts to ground (kt, kn [N/m], mu, preload N0 [N], counted from the preloaded
    equilibrium); force: cosine force along x on mass `forced`; normal_force: in phase along y on all touching masses [N].
    """
    _check_masses(masses, (*touching, forced))
    Kx = chain_stiffness(masses)
    K = np.kron(Kx, np.eye(2)) + np.kron(np.eye(masses), np.diag([0.0, 1.0]))
    dofs = tuple(f"{i}.{axis}" for i in range(1, masses + 1) for axis in "xy")
    law = Macroslip(kt, mu, kn, preload)
    contacts = [
        Contact(f"{i}", law, (between(f"{i}.x", "ground"),), between(f"{i}.y", "ground"), balanced=True) for i in touching
    ]
    loads = (Force(f"{forced}.x", force), *(Force(f"{i}.y", normal_force) for i in touching))
    structure = Structure(np.eye(2 * masses), K, dofs, C=0.01 * K)
    return Problem(structure, tuple(contacts), loads, (f"{forced}.x",), f"Chain of {masses} masses, varying normal load")


def chain_of_three(kt: float = 20.0, limit: float = 1.0, damping: float = 0.02, force: float = 1.0) -> Problem:
    """Three unit masses between two walls, springs 1, a viscous damper beside each; sliders wall-1 and 1-2 (kt, limit μN).

    The cosine force acts on mass 2. NLvib (Krack and Gross) gives reference curves for it.
    """
    K = 2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    structure = Structure(np.eye(3), K, ("1.x", "2.x", "3.x"), C=damping * K)
    contacts = (_slider("1.x", "ground", kt, limit), _slider("1.x", "2.x", kt, limit))
    return Problem(structure, contacts, (Force("2.x", force),), ("1.x", "2.x", "3.x"), "Chain of three masses")


def three_mass_wedge(
    traction_ratio: float | Start = 0.0,
    *,
    platform_angle: float = 30.0,
    pull: float = 120.0,
    excitation: tuple[float, float] = (-20.0, 5.0),
    kt: float = 3e5,
    kn: float = 3e5,
    mu: float = 0.5,
) -> Problem:
    """Two planar blades and a wedge damper D, all of two degrees of freedom: the smallest case of non-unique friction.

    traction_ratio: start state m of both contacts at the last sample, or any start rule; platform_angle [degrees];
    pull: static force on D.y [N]; excitation: sine amplitudes on 1.y and 2.x [N]; kt, kn [N/m], mu of both contacts.
    Source: the three-mass planar oscillator of the literature on non-unique friction forces, numbers of this project.
    """
    # Blades: ground springs k, x and y coupled by k, blade to blade by k12; damper: x and y coupled by k, else free.
    k, k12, couple = 3e5, 7e5, np.array([[1.0, -1.0], [-1.0, 1.0]])
    K = np.zeros((6, 6))
    K[:4, :4] = k * np.eye(4) + k * np.kron(np.eye(2), couple) + k12 * np.kron(couple, np.eye(2))
    K[4:, 4:] = k * couple
    M, C = np.diag([1.0] * 4 + [0.1] * 2), np.diag([20.0] * 4 + [0.0] * 2)
    outlines = {"D": wedge_outline(platform_angle)} if 0.0 < platform_angle < 90.0 else {}
    structure = Structure(M, K, ("1.x", "1.y", "2.x", "2.y", "D.x", "D.y"), C=C, outlines=outlines)
    start = TractionRatio(traction_ratio) if isinstance(traction_ratio, int | float) else traction_ratio
    c, s = cos(radians(platform_angle)), sin(radians(platform_angle))
    law = Macroslip(kt, mu, kn)
    contacts = (
        Contact("blade 1", law, (_relative("1", c, s),), _relative("1", -s, c), start),
        Contact("blade 2", law, (_relative("2", c, -s),), _relative("2", s, c), start),
    )
    loads = (Force("1.y", -1j * excitation[0]), Force("2.x", -1j * excitation[1]), Force("D.y", static=pull))
    return Problem(structure, contacts, loads, ("2.y", "1.y", "1.x", "2.x"), "Two blades and a wedge damper")


def _relative(blade: str, x: float, y: float) -> dict[str, float]:
    """The displacement of the damper relative to a blade along (x, y)."""
    return {"D.x": x, "D.y": y, f"{blade}.x": -x, f"{blade}.y": -y}


def chain_stiffness(masses: int) -> Array:
    """Springs 1 from ground to mass 1 and from mass to mass, the last one free, (masses, masses)."""
    K = 2.0 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    K[-1, -1] = 1.0
    return np.asarray(K)


def _slider(a: str, b: str, kt: float, limit: float) -> Contact:
    """A Jenkins element of constant slip limit μN between two degrees of freedom."""
    return Contact(f"{a.split('.')[0]}-{b.split('.')[0]}", Macroslip(kt, 1.0, normal_load=limit), (between(a, b),))


def _check_masses(masses: int, used: Sequence[int]) -> None:
    """Refuse numbers of masses that a chain does not have."""
    outside = sorted({i for i in used if not 1 <= i <= masses})
    if outside:
        raise fault("Numbers of masses", f"must lie between 1 and {masses}", outside)
