"""Where a damper sits between two flat platforms, from points on them: nobody works out its place, axes and angles by hand.

The platforms form a roof above the damper. Their normals n_l and n_r, out of the platforms, point down from it, against the pull;
z is along both, n_l × n_r, and y the direction of the pull across z. With x = y × z the platforms have n_l = (sin α, −cos α) and
n_r = (−sin β, −cos β), α and β the slopes of a `Shape`. Its mass centre c lies where its contact points p touch both planes,
n_l·(c + p_l − m_l) = 0 and n_r·(c + p_r − m_r) = 0, m a point of each platform.
"""

from collections.abc import Collection
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.dampers.damper import Shape
from stickslip.model.dampers.wedge import Wedge
from stickslip.support.checks import Array, fault, vector

FLAT = 0.02
"""Distance of nodes from a plane over the width of a platform, above which it is not flat, and sine of the angle between two
platforms, about a degree, below which they are parallel and say nothing of where between them a damper lies."""
BY_HAND = "Give centre and axes."


@dataclass(frozen=True, eq=False)
class Seat:
    """axes (3, 3): rows x, y, z of the damper; normals, middles (2, 3): of the left and the right platform; low, high (2, 2):
    where each of them begins and ends along y and z [m]."""

    axes: Array
    normals: Array
    middles: Array
    low: Array
    high: Array

    @classmethod
    def between(cls, left: ArrayLike, right: ArrayLike, out: ArrayLike) -> "Seat":
        """The seat between two platforms with points (n, 3) [m] on each; out: the direction of the pull, towards the ridge."""
        places = [np.asarray(points, dtype=float).reshape(-1, 3) for points in (left, right)]
        middles, pull = np.array([points.mean(axis=0) for points in places if len(points)]), vector("out", out, 3)
        normals = np.array([_normal(points) for points in places])
        normals *= -np.where(normals @ pull < 0.0, -1.0, 1.0)[:, None]
        along = np.cross(*normals)
        if np.linalg.norm(along) < FLAT:
            raise fault("between", "must name two inclined platforms, which form a roof", "parallel ones", BY_HAND)
        z = along / np.linalg.norm(along)
        y = pull - (pull @ z) * z
        if np.linalg.norm(y) <= abs(pull @ z):
            raise fault(
                "The pull", "must point to the ridge of the platforms", "along it", "Check the pull, or give centre and axes."
            )
        y /= np.linalg.norm(y)
        x = np.cross(y, z)
        if x @ (middles[1] - middles[0]) < 0.0:
            x, z = -x, -z
        found = [points @ np.array([y, z]).T for points in places]
        low, high = (np.array([pick(points, axis=0) for points in found]) for pick in (np.min, np.max))
        seat = cls(np.array([x, y, z]), normals, middles, low, high)
        if np.any(low.max(axis=0) >= high.min(axis=0)):
            raise fault("between", "must name two platforms that lie opposite each other", "two that do not", BY_HAND)
        if min(seat.slopes) < 0.0 or max(seat.slopes) >= 90.0:
            words = " and ".join(f"{slope:.4g}" for slope in seat.slopes)
            cure = "Check the pull, and which set is left of the damper."
            raise fault("Slopes of the platforms towards the pull", "must lie in [0, 90) degrees", words, cure)
        return seat

    @property
    def slopes(self) -> tuple[float, float]:
        """α and β, degrees."""
        (left, right), (x, y, _) = self.normals, self.axes
        return float(np.degrees(np.arctan2(left @ x, -left @ y))), float(np.degrees(np.arctan2(-right @ x, -right @ y)))

    def dimensions(self, kind: type[Shape], given: Collection[str]) -> dict[str, float]:
        """The dimensions of a shape that the platforms say and that are not given: slopes, the common depth, and the base and the
        height of a wedge; it reaches to where both platforms end, from where both begin or from where its width fits."""
        known = dict(zip(("left_angle", "right_angle"), self.slopes, strict=True))
        (begin, first), (end, last) = self.low.max(axis=0), self.high.min(axis=0)
        known["depth"] = last - first
        if issubclass(kind, Wedge):
            x, y, _ = self.axes
            up, rates = self.normals @ y, self.normals @ x
            slants = -np.divide(up, rates, out=np.zeros(2), where=rates != 0.0)  # change of x in each platform along y
            edges = self.middles @ x + (begin - self.middles @ y) * slants
            known |= {"width": edges[1] - edges[0], "height": end - begin}
        return {each.name: float(known[each.name]) for each in fields(kind) if each.name in known and each.name not in given}  # type: ignore[arg-type]

    def narrower(self, width: float) -> float:
        """The height of a wedge whose base is narrower than where both platforms begin: from there to where both end."""
        whole = self.dimensions(Wedge, ())
        steep = sum(1.0 / np.tan(np.radians(slope)) for slope in self.slopes)
        return float(whole["height"] - (whole["width"] - width) / steep)

    def centre(self, shape: Shape) -> Array:
        """Where the mass centre of a shape lies that touches both platforms, in the middle of their common depth, (3,) [m].

        A shape that would touch one of them beyond its ends is refused.
        """
        plane, touches = self.axes[:2], [np.asarray(touch.points)[:, :2] for touch in (shape.left(), shape.right())]
        sides = zip(self.normals, self.middles, touches, strict=True)
        right = [normal @ (middle - touch[0] @ plane) for normal, middle, touch in sides]
        x, y = np.linalg.solve(self.normals @ plane.T, right)
        for side, touch, low, high in zip(("left", "right"), touches, self.low[:, 0], self.high[:, 0], strict=True):
            place, margin = y + touch[:, 1].mean(), FLAT * (high - low)
            if not low - margin <= place <= high + margin:
                where = f"{1e3 * max(low - place, place - high):.3g} mm beyond its ends"
                raise fault(
                    f"The damper on the {side} platform", "must touch it", where, "Check the dimensions, or give centre and axes."
                )
        middle = 0.5 * (self.low[:, 1].max() + self.high[:, 1].min())
        return np.asarray(np.array([x, y, middle]) @ self.axes)


def _normal(points: Array) -> Array:
    """The unit normal of a flat platform, of either sign."""
    if len(points) < 3:
        raise fault("A platform", "must have at least three nodes", len(points), "Name a set of nodes of its surface.")
    _, sizes, directions = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if not sizes[1] > FLAT * sizes[0]:
        raise fault("A platform", "must be a surface", "a line of nodes", "Name a set of nodes of its surface.")
    if sizes[2] > FLAT * sizes[1]:
        raise fault("A platform", "must be flat", f"{sizes[2] / sizes[1]:.2g} times as thick as wide", BY_HAND)
    return np.asarray(directions[2])
