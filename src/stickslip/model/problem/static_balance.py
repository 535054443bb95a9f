"""Whether contacts can carry the static load of loose bodies at all, before any equilibrium is looked for.

Bodies that nothing but contacts holds are at rest where their load p and the forces of the contacts add up to nothing in every
motion φ that no stiffness resists, φᵀ Σ B_cᵀ f_c = φᵀ p, with normal forces N_e ≥ 0 and friction |T| ≤ Σ (μ Σ N_e + L0) in each
direction: one linear program in the N_e and T of all contacts, whatever their stiffness. Without a solution of it there is no
state of rest, and no steady vibration either. Of a limit that bends with the load stand the lines that bound it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components

from stickslip.model.contact.point import Contact
from stickslip.support.checks import Array

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Mesh, Problem
    from stickslip.model.problem.systems import LinearSystem

LOOSE = 1e-12
"""Stiffness of a body in a motion over that with stuck contacts, below which it is rounding and contacts alone hold the body."""

LARGEST = 300
"""Degrees of freedom of a body from which on it is taken for a held finite-element model."""

MISSING = 1e-4
"""Share of the load that contacts must leave over to be said not to carry it."""


class _Forces(NamedTuple):
    """The forces x of a contact, of which `rows` of B say how they act: `within` x ≤ `limits`, each x from `least` on."""

    rows: Array
    within: Array
    limits: Array
    least: list[float | None]


class _Loose(NamedTuple):
    """A body and the motions (n, k) of the structure that no stiffness resists, each moving the contacts by 1 at most."""

    name: str
    motions: Array
    dofs: frozenset[str]


def unbearable_loads(problem: Problem, sign: float = 1.0) -> list[str]:
    """The names of loose bodies whose static load times `sign` contacts cannot carry; all of them where they cannot together."""
    system = problem.systems.at(0)
    if np.any(np.imag(system.B)):
        return []
    bodies, ends = _loose_bodies(problem, system), np.cumsum([len(contact.directions) for contact in problem.contacts])
    rows = [system.B.real[end - len(contact.directions) : end] for contact, end in zip(problem.contacts, ends, strict=True)]
    forces = [_forces(contact, own) for contact, own in zip(problem.contacts, rows, strict=True)]
    load = sign * problem.static_load.real
    unbearable = [body.name for body in bodies if not _carried(forces, [body], load)]
    if unbearable or len(bodies) < 2 or _carried(forces, bodies, load):
        return unbearable
    return [" and ".join(body.name for body in bodies)]


def dampers(problem: Problem) -> dict[str, frozenset[str]]:
    """The bodies of one node that nothing but contacts holds and a static load presses on them, by name, with their degrees of
    freedom; none where directions of contacts are complex."""
    system, load = problem.systems.at(0), problem.static_load.real
    if np.any(np.imag(system.B)):
        return {}
    pulled = [body for body in _loose_bodies(problem, system) if np.any(load @ body.motions)]
    return {body.name: body.dofs for body in pulled if len({dof.rpartition(".")[0] for dof in body.dofs}) == 1}


def _loose_bodies(problem: Problem, system: LinearSystem) -> list[_Loose]:
    """The bodies, degrees of freedom that stiffness or a node joins, with motions that move contacts and meet no stiffness."""
    if problem.mesh is not None:
        return _bodies_of_mesh(problem.mesh, problem, system.B.real)
    held, size = system.without_contacts(problem.contact_stiffness).real, np.sqrt(np.diag(system.K.real))
    size[size == 0.0] = 1.0
    held = np.where(np.abs(held) > LOOSE * np.outer(size, size), held, 0.0)
    nodes = np.array([dof.rpartition(".")[0] for dof in problem.structure.dofs])
    _, bodies = connected_components(sparse.csr_array((held != 0.0) | (nodes[:, None] == nodes)), directed=False)
    loose = []
    for body in np.flatnonzero(np.bincount(bodies) < LARGEST):
        dofs = np.flatnonzero(bodies == body)
        stiffness, shapes = linalg.eigh(held[np.ix_(dofs, dofs)] / np.outer(size[dofs], size[dofs]))
        motions = np.zeros((len(held), int(np.sum(stiffness < LOOSE))))
        motions[dofs] = shapes[:, stiffness < LOOSE] / size[dofs, None]
        moved = np.abs(system.B.real @ motions).max(axis=0, initial=0.0)
        touching = moved > 0.0
        if np.any(touching):
            name = str(nodes[dofs[0]])
            moving = np.any(motions[:, touching] != 0.0, axis=1)
            names = frozenset(problem.structure.dofs[row] for row in np.flatnonzero(moving))
            loose.append(_Loose(name.rpartition("/")[0] or name, motions[:, touching] / moved[touching], names))
    return loose


def _bodies_of_mesh(mesh: Mesh, problem: Problem, B: Array) -> list[_Loose]:
    """The same of bodies of a mesh, whose rigid motions the coordinates hold."""
    loose = []
    for name, rows, rigid in mesh.stuck.bodies:
        motions = mesh.on_coordinates(rigid)
        moved = np.abs(B @ motions).max(axis=0, initial=0.0)
        touching = moved > LOOSE * moved.max(initial=0.0)
        if np.any(touching):
            dofs = frozenset(mesh.stuck.structure.dofs[row] for row in rows)
            loose.append(_Loose(name, motions[:, touching] / moved[touching], dofs))
    return loose


def _forces(contact: Contact, rows: Array) -> _Forces:
    """N_e and one T a tangential direction of a contact with these rows of B; springs without friction may have any force."""
    normal = contact.elements.normal
    elements = 0 if normal is None else normal.stiffness.size
    acts = np.concatenate([np.repeat(rows[-1:], elements, axis=0), rows[: len(contact.tangential)]])
    within, limits = np.zeros((0, len(acts))), []
    for t, group in enumerate(contact.elements.friction if contact.law.rubs else ()):
        direction = np.eye(len(acts))[elements + t]
        for slope, beside in group.bounds():
            constant = (slope * group.line(np.zeros(elements)) + beside).sum()
            line = np.zeros(len(acts))
            line[:elements] = [constant - (slope * group.line(unit) + beside).sum() for unit in np.eye(elements)]
            within = np.vstack([within, line + direction, line - direction])
            limits += [constant, constant]
    return _Forces(acts, within, np.array(limits), [0.0] * elements + [None] * len(contact.tangential))


def _carried(forces: list[_Forces], bodies: list[_Loose], load: Array) -> bool:
    """Whether contacts leave over no more than a small share of the load of bodies."""
    motions = np.hstack([body.motions for body in bodies])
    wanted, whole = motions.T @ load, np.abs(motions).T @ np.abs(load)
    size = whole.max(initial=0.0)
    if size <= LOOSE * np.abs(motions).max() * np.abs(load).max():  # rounding of a load across the motions
        return True
    forces = [force for force in forces if np.any(force.rows @ motions)]
    limits, over = np.concatenate([force.limits for force in forces]), np.eye(wanted.size)
    within: Any = sparse.block_diag([sparse.csr_array(force.within) for force in forces])
    beside: Any = sparse.hstack([within, sparse.csr_array((len(limits), 2 * wanted.size))])
    program = scipy.optimize.linprog(
        np.concatenate([np.zeros(within.shape[1]), np.ones(2 * wanted.size)]),
        A_ub=beside,
        b_ub=limits / size,
        A_eq=np.hstack([np.vstack([force.rows for force in forces]).dot(motions).T, over, -over]),
        b_eq=wanted / size,
        bounds=[*((least, None) for force in forces for least in force.least), *[(0.0, None)] * (2 * wanted.size)],
    )
    return (program.fun or 0.0) <= MISSING
