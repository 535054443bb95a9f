"""The laboratory rig of Gola and Gastaldi (ASME GT2014-25240): a damper between two platforms moved by actuators.

Published: contact stiffness, friction, radii, foot distance, the motion. Not published: platform angles, the places of the
contacts and the mass; those here are this project's, with 45 degrees (G45) and 37 degrees (G37) as the two geometries.
"""

from numpy.typing import ArrayLike

from stickslip.model.dampers.between_platforms import BetweenPlatforms, ElasticPlatform
from stickslip.model.dampers.laboratory import CrossedCurvedFlat, ThreePoint
from stickslip.support.checks import fault
from stickslip.support.units import N_per_um

FRICTION = (0.18, 0.199, 0.45)
"""Published friction coefficients of L1, L2 and R, tuned to a measured cycle."""

KT, KN = 56.0 * N_per_um, 84.0 * N_per_um
"""Published contact stiffness of every line."""

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
