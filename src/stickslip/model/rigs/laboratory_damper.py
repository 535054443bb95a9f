"""The laboratory rig of Gola and Gastaldi (ASME GT2014-25240): a damper between two platforms moved by actuators.

Published: contact stiffness, friction, radii, foot distance, the motion. Not published: platform angles, the places of the
contacts and the mass; those here are this project's, with 45 degrees (G45) and 37 degrees (G37) as the two geometries.

A damper between prescribed platforms as a `Problem`, for harmonic balance and every other analysis.
"""

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.dampers.between_platforms import DAMPER, LEFT, RIGHT, BetweenPlatforms, ElasticPlatform, PlatformMotion
from stickslip.model.dampers.laboratory import CrossedCurvedFlat, ThreePoint
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import fault, positive
from stickslip.support.units import N_per_um

FRICTION = (0.18, 0.199, 0.45)
"""Published friction coefficients of L1, L2 and R, tuned to a measured cycle."""

KT, KN = 56.0 * N_per_um, 84.0 * N_per_um
"""Published contact stiffness of every line."""

FRICTION_ROWS = (
    (0.14, 0.13, 0.13),
    (0.14, 0.22, 0.13),
    (0.14, 0.22, 0.14),
    (0.22, 0.22, 0.13),
    (0.32, 0.22, 0.32),
    (0.40, 0.22, 0.32),
)
"""The six rows of the source's friction study; whether their columns are L1, L2, R or R, L1, L2 is not readable in it."""

RIG_STIFFNESS, RIG_MASS = 30.0 * N_per_um, 1.0
"""Right platform on its load cells: this project's choice."""


def laboratory_damper(
    platform_angle: float = 45.0,
    pull: float = 80.0,
    friction: ArrayLike = FRICTION,
    shape: str = "three_point",
    kt: ArrayLike = KT,
    kn: ArrayLike = KN,
    elastic: bool = False,
) -> BetweenPlatforms:
    """The three-point damper ("three_point") or the crossed curved-flat one ("crossed_curved_flat") between two platforms.

    platform_angle [degrees] of both; pull: weight on the damper [N]; friction of L1, L2, R; kt, kn [N/m], each a number or one
    entry a line of contact; elastic: the right platform on the stiffness of the rig instead of rigid.
    """
    dimensions = {"three_point": ThreePoint, "crossed_curved_flat": CrossedCurvedFlat}
    if shape not in dimensions:
        raise fault("shape", f"must be one of {', '.join(dimensions)}", shape)
    damper = dimensions[shape](left_angle=platform_angle, right_angle=platform_angle).damper(pull=pull)
    right = ElasticPlatform([[RIG_STIFFNESS, 0.0], [0.0, RIG_STIFFNESS]], RIG_MASS) if elastic else None
    title = f"{shape.replace('_', ' ').capitalize()} damper, {platform_angle:g} degrees, {pull:g} N"
    return BetweenPlatforms.macroslip(damper, kt, kn, friction, right, title)


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
