"""Rigid bodies: 6 degrees of freedom at the mass centre; small rotations.

A point p of a body moves by u + θ × (p − c); along a direction d that is d·u + ((p − c) × d)·θ. `at(point)` gives this as
coefficients of named degrees of freedom, which contacts, springs and forces take.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.structure.assembly import prefixed
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import Array, fault, positive, symmetric, vector

Motion = Callable[[Sequence[float]], Mapping[str, float]]
"""A place that can move: gives the displacement along a direction as coefficients of degrees of freedom."""

SPACE = ("x", "y", "z", "rx", "ry", "rz")


def box_inertia(mass: float, sides: ArrayLike) -> Array:
    """Inertia about the centre of a homogeneous box, (3, 3) in kg m²: J_xx = m (b² + c²)/12, ...; sides (a, b, c) in m."""
    squares = vector("sides", sides, 3) ** 2
    return np.diag(positive("mass", mass) / 12.0 * (squares.sum() - squares))


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A rigid body in space: mass [kg], inertia (3, 3) about the mass centre [kg m²], mass centre (3,) [m].

    Degrees of freedom: node.x, .y, .z [m] and node.rx, .ry, .rz [rad] of its mass centre. outline: corners of a section from
    the mass centre, (k, 3) [m], for drawings only.
    """

    mass: float
    inertia: ArrayLike
    centre: ArrayLike = (0.0, 0.0, 0.0)
    node: str = "centre"
    outline: ArrayLike = ()

    def __post_init__(self) -> None:
        positive("mass", self.mass)
        inertia = symmetric("inertia", self.inertia, 3)
        moments = np.linalg.eigvalsh(inertia)
        if moments[0] <= 0.0 or moments[2] > (moments[0] + moments[1]) * (1.0 + 1e-9):
            rule = "must have positive principal moments, none above the sum of the others"
            raise fault("inertia", rule, moments.tolist(), "Check its unit (kg m²) and signs.")
        object.__setattr__(self, "inertia", inertia)
        object.__setattr__(self, "centre", vector("centre", self.centre, 3))

    def structure(self) -> Structure:
        """The free body, without stiffness: M = diag(m, m, m, J)."""
        M = np.zeros((6, 6))
        M[:3, :3] = self.mass * np.eye(3)
        M[3:, 3:] = self.inertia
        x, y, z = np.asarray(self.centre).tolist()
        corners = np.reshape(self.outline, (-1, 3))
        outlines = {self.node: np.asarray(self.centre) + corners} if corners.size else {}
        names = tuple(f"{self.node}.{axis}" for axis in SPACE)
        return Structure(M, np.zeros((6, 6)), names, nodes={self.node: (x, y, z)}, outlines=outlines)

    def at(self, point: ArrayLike, body: str = "") -> Motion:
        """The motion of the body's point [m]; `body` is its name in an assembly, where dofs read "body/node.x"."""
        arm = vector("point", point, 3) - np.asarray(self.centre)
        name = prefixed(body, self.node)

        def motion(direction: Sequence[float]) -> dict[str, float]:
            d = vector("direction", direction, 3)
            values = np.concatenate([d, np.cross(arm, d)]).tolist()
            return {f"{name}.{axis}": value for axis, value in zip(SPACE, values, strict=True) if value != 0.0}

        return motion

    def nearest_face(self, point: ArrayLike) -> tuple[float, Array] | None:
        """The side of the section that is nearest to a point, seen along the section: its distance [m] and its outward normal;
        None without an outline. A section is the same all along a body, whose ends are not known here."""
        corners = np.reshape(self.outline, (-1, 3))
        if len(corners) < 3:
            return None
        sides = np.roll(corners, -1, axis=0) - corners
        along = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
        length = np.linalg.norm(sides, axis=1)
        if not (np.linalg.norm(along) and np.all(length)):
            return None
        along /= np.linalg.norm(along)
        arm = np.asarray(point, dtype=float) - np.asarray(self.centre)
        arm = arm - (arm @ along) * along
        share = np.clip(np.einsum("ki,ki->k", arm - corners, sides) / length**2, 0.0, 1.0)
        away = np.linalg.norm(arm - corners - share[:, None] * sides, axis=1)
        side = int(np.argmin(away))
        return float(away[side]), np.cross(sides[side], along) / length[side]


def arm_of(directions: Sequence[Mapping[str, float]], node: str) -> Array:
    """The arm p − c (3,) [m] of the point of the body at `node` that moves by these directions: the inverse of `at`.

    Coefficients of rotations are (p − c) × d; where they leave a component open, such as one along all d, it is 0.
    """
    along = np.array([[d.get(f"{node}.{axis}", 0.0) for axis in SPACE[:3]] for d in directions])
    turning = np.array([[d.get(f"{node}.{axis}", 0.0) for axis in SPACE[3:]] for d in directions])
    cross = np.concatenate([[[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]] for x, y, z in along])
    return np.asarray(np.linalg.lstsq(cross, turning.ravel(), rcond=None)[0])
