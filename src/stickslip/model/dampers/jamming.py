"""Jamming: the condition under which friction locks a damper between its platforms at any force.

While the platforms close, the force at each side leans to its friction cone's edge. The damper slides out only while
cot(α_R + φ_R) + cot(α_L + φ_L) > 0, that is α_L + φ_L + α_R + φ_R < 180°: H = F_C/(that sum). Beyond, it is locked.
"""

from __future__ import annotations

from math import atan, degrees

import numpy as np

from stickslip.model.contact.friction import Friction, LoadDependentFriction
from stickslip.model.dampers.between_platforms import BetweenPlatforms


def jamming(rig: BetweenPlatforms) -> str:
    """The cause why the damper can jam, "" where it cannot."""
    (left, left_cone), (right, right_cone) = (_slope_and_cone(rig, side) for side in ("left", "right"))
    total = left + left_cone + right + right_cone
    if total < 180.0:
        return ""
    return (
        f"friction holds it against any closing force, since platform and friction angles add up to {total:.1f} degrees, "
        f"180 or more (left {left:.1f} + {left_cone:.1f}, right {right:.1f} + {right_cone:.1f}). "
        "Less friction or flatter platforms free it."
    )


def _slope_and_cone(rig: BetweenPlatforms, side: str) -> tuple[float, float]:
    """Slope of the platform and the friction angle of its line of least friction, degrees: the damper leaves where it can."""
    points = [(point, law) for point, law in zip(rig.points, rig.laws, strict=True) if point.side == side]
    normal = points[0][0].normal
    slope = degrees(np.arctan2(abs(normal[0]), abs(normal[1])))
    return slope, degrees(atan(min(_under_any_load(getattr(law, "mu", 0.0)) for _, law in points)))


def _under_any_load(mu: Friction) -> float:
    """The coefficient under a load as large as it takes to jam."""
    return mu.values[-1] if isinstance(mu, LoadDependentFriction) else float(mu)
