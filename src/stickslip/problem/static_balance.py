"""Whether contacts can carry the static load of a loose body at all, before any equilibrium is looked for.

A body that nothing but contacts holds is at rest where its load p and the forces of its contacts add up to nothing,
Σ B_cᵀ f_c = p, with normal forces N_e ≥ 0 and friction |T| ≤ Σ (μ Σ N_e + L0) in each direction: a linear program in N_e and T,
whatever the contacts' stiffness. Without a solution of it there is no state of rest, and no steady vibration either.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import linalg
from scipy.optimize import linprog
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from stickslip.checks import Array
from stickslip.contact.law import SLIDERS
from stickslip.contact.point import Contact
from stickslip.contact.start import MeanTraction

if TYPE_CHECKING:
    from stickslip.problem.problem import Problem

LOOSE = 1e-9
"""Stiffness of a body in a motion over that with stuck contacts, below which contacts alone hold it."""

LARGEST = 60
"""Degrees of freedom of a body from which on it is taken for a held finite-element model."""

MISSING = 1e-3
"""Share of the load that contacts must leave over to be said not to carry it."""


class _Forces(NamedTuple):
    """The forces x of a contact: `acts` x on a body, `within` x ≤ `limits`, each x from `least` on."""

    acts: Array
    within: Array
    limits: Array
    least: list[float | None]


def unbearable_loads(problem: Problem) -> list[str]:
    """The names of loose bodies whose static load their contacts cannot carry."""
    _, _, stuck, B, _ = problem.systems.at(0)
    if np.any(np.imag(B)):
        return []
    found = []
    stuck, B = stuck.real, B.real
    held = stuck - B.T @ (problem.contact_stiffness[:, None] * B)
    size = np.sqrt(np.diag(stuck))
    size[size == 0.0] = 1.0
    held = np.where(np.abs(held) > LOOSE * np.outer(size, size), held, 0.0)
    ends = np.cumsum([len(contact.directions) for contact in problem.contacts])
    rows = [B[end - len(contact.directions) : end] for contact, end in zip(problem.contacts, ends, strict=True)]
    nodes = np.array([dof.rpartition(".")[0] for dof in problem.structure.dofs])
    _, bodies = connected_components(csr_array((held != 0.0) | (nodes[:, None] == nodes)), directed=False)
    for body in np.flatnonzero(np.bincount(bodies) < LARGEST):
        dofs = np.flatnonzero(bodies == body)
        stiffness, motions = linalg.eigh(held[np.ix_(dofs, dofs)] / np.outer(size[dofs], size[dofs]))
        loose = motions[:, stiffness < LOOSE] / size[dofs, None]
        moved = [(contact, own[:, dofs] @ loose) for contact, own in zip(problem.contacts, rows, strict=True)]
        touching = [_forces(contact, own) for contact, own in moved if own.any()]
        if touching and _left_over(touching, problem.static_load[dofs].real @ loose) > MISSING:
            node = str(nodes[dofs[0]])
            found.append(node.rpartition("/")[0] or node)
    return found


def _forces(contact: Contact, rows: Array) -> _Forces:
    """The forces of a contact on a body, N_e and one T a tangential direction; rows: of B, in the loose motions of the body.

    Friction of a law that is no table of sliders, or of a prescribed mean, may have any size.
    """
    normal = contact.elements.normal
    elements = 0 if normal is None else normal.stiffness.size
    acts = np.concatenate([np.repeat(rows[-1:], elements, axis=0), rows[: len(contact.tangential)]]).T
    within, limits = np.zeros((0, acts.shape[1])), []
    for t, (start, group) in enumerate(zip(contact.starts, contact.elements.friction, strict=True)):
        if isinstance(start, MeanTraction) or not (contact.law.kind == SLIDERS or contact.law.couples_directions):
            continue
        constant = group.limits(np.zeros(elements)).sum()
        line = np.zeros(acts.shape[1])
        line[:elements] = [constant - group.limits(unit).sum() for unit in np.eye(elements)]
        direction = np.eye(acts.shape[1])[elements + t]
        within = np.vstack([within, line + direction, line - direction])
        limits += [constant, constant]
    return _Forces(acts, within, np.array(limits), [0.0] * elements + [None] * len(contact.tangential))


def _left_over(forces: list[_Forces], load: Array) -> float:
    """The least sum of what contacts leave over of a load, as a share of it, each motion scaled by the largest arm in it."""
    acts = np.hstack([force.acts for force in forces])
    arms = np.abs(acts).max(axis=1)
    scale = np.where(arms > 0.0, arms, 1.0)
    wanted = load / scale
    size = np.abs(wanted).max(initial=0.0)
    if not size:
        return 0.0
    limits, over = np.concatenate([force.limits for force in forces]), np.eye(load.size)
    found = linprog(
        np.concatenate([np.zeros(acts.shape[1]), np.ones(2 * load.size)]),
        A_ub=np.hstack([linalg.block_diag(*(force.within for force in forces)), np.zeros((len(limits), 2 * load.size))]),
        b_ub=limits / size,
        A_eq=np.hstack([acts / scale[:, None], over, -over]),
        b_eq=wanted / size,
        bounds=[*((least, None) for force in forces for least in force.least), *[(0.0, None)] * (2 * load.size)],
    )
    return found.fun or 0.0
