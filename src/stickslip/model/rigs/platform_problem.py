"""A damper between prescribed platforms as a `Problem`, for harmonic balance and every other analysis."""

from __future__ import annotations

import numpy as np

from stickslip.model.dampers.between_platforms import DAMPER, LEFT, RIGHT, BetweenPlatforms
from stickslip.model.dampers.platform_motion import PlatformMotion
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import positive


def platform_problem(rig: BetweenPlatforms, motion: PlatformMotion, ratio: float = 1e5) -> Problem:
    """The left platform is held by springs `ratio` times as stiff as its contacts, whose far ends move as prescribed.

    The platform follows to about 1/ratio. A rigid right platform is held the same way. Outputs: the damper's x and y, and the
    forces are those of the contacts. Force level 1 is the motion as given.
    """
    table = rig.table
    spring = positive("ratio", ratio) * float(table.stiffness.sum() + table.normal_stiffness.sum())
    dofs = (*DAMPER, *LEFT, *RIGHT)
    M, C, K = (np.zeros((len(dofs), len(dofs))) for _ in range(3))
    M[:3, :3], K[3:5, 3:5], K[5:, 5:] = rig.matrices[0][:3, :3], spring * np.eye(2), spring * np.eye(2)
    if rig.right is not None:
        M[5:, 5:], C[5:, 5:], K[5:, 5:] = (matrix[3:, 3:] for matrix in rig.matrices)
    values = spring * np.asarray(motion.harmonics)
    moved = [
        Force(dof, {h: row[2 * h - 1] - 1j * row[2 * h] for h in range(1, (row.size + 1) // 2)}, float(row[0]), "platform motion")
        for dof, row in zip(LEFT, values, strict=True)
    ]
    pull = [Force(dof, static=float(f), name="pull") for dof, f in zip(DAMPER, rig.pull, strict=False) if f]
    body = rig.damper.body
    corners, place = np.reshape(body.outline, (-1, 3)), tuple(np.asarray(body.centre).tolist())
    outlines = {"damper": np.asarray(body.centre) + corners} if corners.size else {}
    structure = Structure(M, K, dofs, C=C, nodes={"damper": place}, outlines=outlines)
    return Problem(structure, rig.contacts, (*moved, *pull), ("damper.x", "damper.y"), rig.title)
