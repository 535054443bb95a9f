"""Dampers: a rigid body, contact surfaces and a centrifugal pull; one file per shape. `SHAPES` lists the shapes."""

from stickslip.dampers.damper import ContactSurface, Damper
from stickslip.dampers.flat_cylinder import FlatCylinder

SHAPES = (FlatCylinder,)
"""Every shape: a frozen dataclass of dimensions with defaults, and `damper(name, pad_centre, side, pull, label)`."""

__all__ = ["SHAPES", "ContactSurface", "Damper", "FlatCylinder"]
