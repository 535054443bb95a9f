"""Dampers: a rigid body with contact surfaces and a centrifugal pull, one file per shape. `SHAPES` lists the shapes.

A shape turns a few dimensions into contact points with frames and laws, mass and inertia. Imports `contact`, `structure` and
`loads`. Begin with `wedge.py`, the shortest shape; `between_platforms.py` is the damper on its own.
"""

from stickslip.dampers.between_platforms import BetweenPlatforms, ElasticPlatform
from stickslip.dampers.curved_flat import CurvedFlat
from stickslip.dampers.cylinder import Cylinder, HalfCylinder
from stickslip.dampers.damper import ContactSurface, Damper
from stickslip.dampers.flat_cylinder import FlatCylinder
from stickslip.dampers.laboratory import CrossedCurvedFlat, ThreePoint
from stickslip.dampers.platform_motion import PlatformMotion, elliptic, in_phase, measured, out_of_phase
from stickslip.dampers.shape import Shape
from stickslip.dampers.wedge import Wedge

SHAPES = (FlatCylinder, Cylinder, HalfCylinder, Wedge, CurvedFlat, ThreePoint, CrossedCurvedFlat)
"""Every shape: a frozen dataclass of dimensions with defaults, and `damper(name, place, side, pull, label)`."""

__all__ = [
    "SHAPES",
    "BetweenPlatforms",
    "ContactSurface",
    "CrossedCurvedFlat",
    "CurvedFlat",
    "Cylinder",
    "Damper",
    "ElasticPlatform",
    "FlatCylinder",
    "HalfCylinder",
    "PlatformMotion",
    "Shape",
    "ThreePoint",
    "Wedge",
    "elliptic",
    "in_phase",
    "measured",
    "out_of_phase",
]
