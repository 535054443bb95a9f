"""Dampers: a rigid body with contact surfaces and a centrifugal pull, one file per shape. `SHAPES` lists the shapes.

A shape turns a few dimensions into contact points with frames and laws, mass and inertia. Imports `contact`, `structure` and
`loads`. Begin with `wedge.py`, the shortest shape; `between_platforms.py` is the damper on its own.
"""

from stickslip.dampers.between_platforms import BetweenPlatforms as BetweenPlatforms
from stickslip.dampers.between_platforms import ElasticPlatform as ElasticPlatform
from stickslip.dampers.curved_flat import CurvedFlat as CurvedFlat
from stickslip.dampers.cylinder import Cylinder as Cylinder
from stickslip.dampers.cylinder import HalfCylinder as HalfCylinder
from stickslip.dampers.damper import ContactSurface as ContactSurface
from stickslip.dampers.damper import Damper as Damper
from stickslip.dampers.flat_cylinder import FlatCylinder as FlatCylinder
from stickslip.dampers.laboratory import CrossedCurvedFlat as CrossedCurvedFlat
from stickslip.dampers.laboratory import ThreePoint as ThreePoint
from stickslip.dampers.platform_motion import PlatformMotion as PlatformMotion
from stickslip.dampers.platform_motion import elliptic as elliptic
from stickslip.dampers.platform_motion import in_phase as in_phase
from stickslip.dampers.platform_motion import measured as measured
from stickslip.dampers.platform_motion import out_of_phase as out_of_phase
from stickslip.dampers.shape import Shape as Shape
from stickslip.dampers.shape import key_of
from stickslip.dampers.wedge import Wedge as Wedge

SHAPES: dict[str, type[Shape]] = {
    key_of(one): one for one in list(globals().values()) if isinstance(one, type) and issubclass(one, Shape) and one is not Shape
}
"""Every shape by its key in a study file."""
