"""The single-blade rig in the form that a code of nodes and connectors can take: matrices in coordinates that hold the contacts.

Pad nodes of the blade are replaced by the relative displacements of the flat contacts, exactly. The points of the cylinder
line depend on each other (a rigid body carries them): they are added as massless nodes on springs far stiffer than the contact.
"""

from __future__ import annotations

import numpy as np
from channel import Answer
from scipy.linalg import block_diag

from stickslip import Problem
from stickslip.model import rigs
from stickslip.model.contact.point import contact_table

TIE = 1e3
"""Stiffness of the springs that tie the added nodes, relative to the largest contact stiffness."""


def export_blade(request: dict) -> Answer:
    """Write matrices, loads and contact elements to the file request["path"]; nodes of three degrees of freedom come first."""
    problem = rigs.single_blade(preload_mass=4.6)
    table = contact_table(problem.contacts)
    flat = np.flatnonzero([any("pad" in name for name in contact.normal) for contact in problem.contacts])
    line = np.setdiff1d(np.arange(len(problem.contacts)), flat)
    T, added = _coordinates(problem, _rows(flat), _rows(line))
    M, K, C, load = _transformed(problem, T, added)
    elements = [
        (node, table.normal_stiffness[e], -table.normal_constant[e] / table.normal_stiffness[e], *_friction(table, c, i))
        for node, c in enumerate([*flat, *line])
        for i, e in enumerate(range(table.normal_first[c], table.normal_first[c + 1]))
    ]
    np.savez(request["path"], M=M, K=K, C=C, load=load, elements=np.array(elements), nodes=len(problem.contacts))
    return {"size": M.shape[0], "elements": len(elements)}


def _rows(contacts: np.ndarray) -> np.ndarray:
    return (3 * contacts[:, None] + np.arange(3)).ravel()


def _friction(table: object, contact: int, element: int) -> tuple[float, float]:
    """kt and μ of an element of the first tangential direction."""
    e = table.friction_first[table.first_row[contact]] + element  # type: ignore[attr-defined]
    return float(table.stiffness[e]), float(table.friction[e])  # type: ignore[attr-defined]


def _coordinates(problem: Problem, flat: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """T with q = T q', q' = (relative motion of the flat contacts, what is no pad), and the line's rows in q'."""
    B = problem.B
    pads = np.flatnonzero(["_pad_" in dof for dof in problem.structure.dofs])
    others = np.setdiff1d(np.arange(problem.structure.size), pads)
    P = np.linalg.inv(B[np.ix_(flat, pads)])
    T = np.zeros((problem.structure.size,) * 2)
    T[np.ix_(pads, np.arange(flat.size))] = P
    T[np.ix_(pads, np.arange(flat.size, T.shape[1]))] = -P @ B[np.ix_(flat, others)]
    T[others, np.arange(flat.size, T.shape[1])] = 1.0
    return T, B[line] @ T


def _transformed(problem: Problem, T: np.ndarray, added: np.ndarray) -> tuple[np.ndarray, ...]:
    """M, K, C (n, n) and loads (n, 2), static and cosine, with the added nodes after those of the flat contacts."""
    count, flat = added.shape[0], 30
    tie = TIE * float(np.max(problem.contact_stiffness))
    link = np.hstack([-added, np.eye(count)])
    K = block_diag(T.T @ problem.structure.K @ T, np.zeros((count, count))) + tie * link.T @ link
    M, C = (block_diag(T.T @ matrix @ T, np.zeros((count, count))) for matrix in (problem.structure.M, problem.C))
    load = np.vstack([T.T @ problem.load(1)[:, :2], np.zeros((count, 2))])
    size = K.shape[0]
    order = np.concatenate([np.arange(flat), np.arange(size - count, size), np.arange(flat, size - count)])
    return M[np.ix_(order, order)], K[np.ix_(order, order)], C[np.ix_(order, order)], load[order]
