"""Dampers: a rigid body with contact surfaces and a centrifugal pull, one file per shape. `SHAPES` lists the shapes.

A shape turns a few dimensions into contact points with frames and laws, mass and inertia. Imports `contact`, `structure` and
`loads`. Begin with `wedge.py`, the shortest shape; `between_platforms.py` is the damper on its own.
"""

from stickslip.model.dampers.between_platforms import BetweenPlatforms as BetweenPlatforms
from stickslip.model.dampers.between_platforms import ElasticPlatform as ElasticPlatform
from stickslip.model.dampers.between_platforms import PlatformMotion as PlatformMotion
from stickslip.model.dampers.between_platforms import elliptic as elliptic
from stickslip.model.dampers.between_platforms import in_phase as in_phase
from stickslip.model.dampers.between_platforms import measured as measured
from stickslip.model.dampers.between_platforms import out_of_phase as out_of_phase
from stickslip.model.dampers.cylinder import CurvedFlat as CurvedFlat
from stickslip.model.dampers.cylinder import Cylinder as Cylinder
from stickslip.model.dampers.cylinder import FlatCylinder as FlatCylinder
from stickslip.model.dampers.cylinder import HalfCylinder as HalfCylinder
from stickslip.model.dampers.damper import ContactSurface as ContactSurface
from stickslip.model.dampers.damper import Damper as Damper
from stickslip.model.dampers.damper import Shape as Shape
from stickslip.model.dampers.damper import key_of
from stickslip.model.dampers.laboratory import CrossedCurvedFlat as CrossedCurvedFlat
from stickslip.model.dampers.laboratory import ThreePoint as ThreePoint
from stickslip.model.dampers.seat import Seat as Seat
from stickslip.model.dampers.wedge import Wedge as Wedge

SHAPES: dict[str, type[Shape]] = {
    key_of(one): one for one in list(globals().values()) if isinstance(one, type) and issubclass(one, Shape) and one is not Shape
}
"""Every shape by its key in a study file."""
