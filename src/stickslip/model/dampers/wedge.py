"""The wedge: flat towards both platforms; symmetric with equal angles, asymmetric with different ones."""

from dataclasses import dataclass
from math import radians, tan

import numpy as np

from stickslip.model.dampers.damper import Section, Shape, Touch, polygon
from stickslip.model.structure.assembly import RigidBody
from stickslip.support.checks import Array, between, fault

MOST_LINES = 1000
"""Lines of contact of a face: more resolve nothing of the contact mechanics, and the cycle takes hours."""


@dataclass(frozen=True)
class Wedge(Shape):
    """A trapezium: width of the base, height, depth along z [m]; density [kg/m³]; slopes of its faces [degrees].

    Each face touches along `lines` lines, the middles of as many equal strips.
    """

    width: float = 20e-3
    height: float = 6e-3
    depth: float = 30e-3
    density: float = 7800.0
    left_angle: float = 45.0
    right_angle: float = 45.0
    lines: int = 3

    def __post_init__(self) -> None:
        self.check("width", "height", "depth", "density", "left_angle", "right_angle")
        between("lines", self.lines, 1, MOST_LINES)
        if self.corners()[2, 0] < self.corners()[3, 0]:
            lower = self.width / (1.0 / tan(radians(self.left_angle)) + 1.0 / tan(radians(self.right_angle)))
            meet = f"must be below {lower / self.width:.4g}, where the two faces meet"
            raise fault("height over width", meet, float(f"{self.height / self.width:.4g}"))

    def corners(self) -> Array:
        """Corners (4, 2) counter-clockwise from the lower left one, which is the origin."""
        inset_left, inset_right = (self.height / tan(radians(angle)) for angle in (self.left_angle, self.right_angle))
        return np.array(
            [[0.0, 0.0], [self.width, 0.0], [self.width - inset_right, self.height], [inset_left, self.height]], dtype=float
        )

    def section(self) -> Section:
        """The trapezium."""
        return Section.bounded_by(polygon(self.corners()))

    def body(self) -> RigidBody:
        return self.section().prism(self.depth, self.density, np.zeros(3))

    def left(self) -> Touch:
        return self._face(self.left_angle, 0, 3)

    def right(self) -> Touch:
        return self._face(self.right_angle, 1, 2)

    def _face(self, angle: float, low: int, high: int) -> Touch:
        """The face between two corners."""
        corners, shares = self.corners() - self.section().centroid, (np.arange(self.lines) + 0.5) / self.lines
        return Touch.on_lines(angle, corners[low] + np.outer(shares, corners[high] - corners[low]), self.depth)


def wedge_outline(angle: float) -> Array:
    """A wedge of equal slopes [degrees] for drawings of rigs without dimensions: corners (4, 3) [m], about its centroid."""
    width = Wedge.width
    section = Wedge(width, min(Wedge.height, 0.35 * width * tan(radians(angle))), left_angle=angle, right_angle=angle).section()
    return np.pad(section.outline - section.centroid, ((0, 0), (0, 1)))
