"""Motions that friction alone restrains: the axial position of a wedge between two platforms, the roll of a cylinder.

While some contact sticks, friction holds their mean. Where every contact slips or opens at some time of the period, the forces
are the same wherever the body lies along such a motion: its mean position is not determined, and Newton's method may take it
anywhere. A spring that acts on the mean alone, far softer than the sticking contacts, holds it and leaves the vibration as it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import linalg

from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.modes import unresisted
from stickslip.support.checks import Array

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Problem

LOOSE, PRESSING = 1e-9, 1e-6
"""Shares that are rounding: of the structure in the energy of a stuck motion, of the normal motion in that of all contacts."""

SOFT = 1e-3
"""Stiffness of the springs on the mean, relative to that of the sticking contacts along the same motion.

Two finite-element blades on a wedge of which all contacts open (40 kN/m): peaks are the same to 3e-10 with springs a tenth and
ten times as stiff. Softer ones let the wedge move so far that a curve takes up to 28 times as many evaluations.
"""


def loose_motions(problem: Problem) -> Array:
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


def soft_springs(problem: Problem) -> tuple[Spring, ...]:
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
