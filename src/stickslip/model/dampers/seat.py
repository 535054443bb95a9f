"""Where a damper sits between two flat platforms, from points on them: nobody works out its place, axes and angles by hand.

With n_l and n_r out of the left and the right platform, each towards the other, z is along both, n_l × n_r, and y points out to
the ridge of the roof that they form: along the pull, or where it is not stated in the middle between both. With x = y × z the
platforms have n_l = (sin α, −cos α) and n_r = (−sin β, −cos β), α and β the slopes of a `Shape`. Its mass centre c lies where its
contact points p touch both planes, n_l·(c + p_l − m_l) = 0 and n_r·(c + p_r − m_r) = 0.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.dampers.damper import Shape
from stickslip.support.checks import Array, fault

LEVEL = 0.02
"""Sine of the angle between two platforms below which nothing says where between them a damper lies: one degree."""


@dataclass(frozen=True, eq=False)
class Seat:
    """axes (3, 3): rows x, y, z of the damper; normals, middles (2, 3): of the platforms, left and right; low, high (2,): ends of
    what lies opposite on both, along y and z [m]."""

    axes: Array
    normals: Array
    middles: Array
    low: Array
    high: Array

    @classmethod
    def between(cls, left: ArrayLike, right: ArrayLike, out: ArrayLike | None = None) -> "Seat":
        """The seat between two platforms with points (n, 3) [m] on each; out: a direction towards the ridge."""
        places = [np.asarray(points, dtype=float) for points in (left, right)]
        middles = np.array([points.mean(axis=0) for points in places])
        across = middles[1] - middles[0]
        normals = np.array([np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2] for points in places])
        normals *= np.sign(normals @ across * (1.0, -1.0))[:, None]
        along = np.cross(*normals)
        if np.linalg.norm(along) < LEVEL:
            raise fault(
                "between", "must name two inclined platforms, which form a roof", "parallel ones", "Give centre and axes."
            )
        z = along / np.linalg.norm(along)
        y = -normals.sum(axis=0) if out is None else np.asarray(out, dtype=float)
        y = y - (y @ z) * z
        x = np.cross(y, z)
        if x @ across < 0.0:
            x, z = -x, -z
        axes = np.array([each / (np.linalg.norm(each) or 1.0) for each in (x, y, z)])
        found = [points @ axes[1:].T for points in places]
        low, high = (
            pick([each(points, axis=0) for points in found], axis=0) for pick, each in ((np.max, np.min), (np.min, np.max))
        )
        seat = cls(axes, normals, middles, low, high)
        if np.any(low >= high):
            raise fault(
                "between", "must name two platforms that lie opposite each other", "two that do not", "Give centre and axes."
            )
        if min(seat.slopes) < 0.0 or max(seat.slopes) >= 90.0:
            words = " and ".join(f"{slope:.4g}" for slope in seat.slopes)
            raise fault(
                "Slopes of the platforms towards the pull", "must lie in [0, 90) degrees", words, "Check the pull and the sets."
            )
        return seat

    @property
    def slopes(self) -> tuple[float, float]:
        """α and β, degrees."""
        (left, right), (x, y, _) = self.normals, self.axes
        return float(np.degrees(np.arctan2(left @ x, -left @ y))), float(np.degrees(np.arctan2(-right @ x, -right @ y)))

    def dimensions(self, kind: type[Shape], given: dict[str, Any]) -> dict[str, float]:
        """The dimensions of a shape that the platforms say and that are not given: slopes, the common depth, and of a wedge the
        base and the height along which both platforms lie opposite."""
        known = dict(zip(("left_angle", "right_angle"), self.slopes, strict=True))
        height, depth = self.high - self.low
        places = (self.middles + (self.low[0] - self.middles @ self.axes[1])[:, None] * self._uphill) @ self.axes[0]
        known |= {"depth": depth, "height": height, "width": places[1] - places[0]}
        return {each.name: known[each.name] for each in fields(kind) if each.name in known and each.name not in given}  # type: ignore[arg-type]

    @property
    def _uphill(self) -> Array:
        """The directions in both platforms along which y grows by one, (2, 3)."""
        x, y, _ = self.axes
        along, up = self.normals @ x, self.normals @ y
        return np.asarray(y - np.divide(up, along, out=np.zeros(2), where=along != 0.0)[:, None] * x)

    def centre(self, shape: Shape) -> Array:
        """Where the mass centre of a shape lies that touches both platforms, in the middle of their common depth, (3,) [m]."""
        plane = self.axes[:2]
        touches = [np.asarray(touch.points)[0, :2] @ plane for touch in (shape.left(), shape.right())]
        right = [normal @ (middle - touch) for normal, middle, touch in zip(self.normals, self.middles, touches, strict=True)]
        return np.asarray(
            np.linalg.solve(self.normals @ plane.T, right) @ plane + 0.5 * (self.low[1] + self.high[1]) * self.axes[2]
        )
