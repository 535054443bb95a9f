"""A damper: a rigid body, the surfaces with which it touches its neighbours, and its centrifugal pull.

A shape (one file each) makes a `Damper` from a few dimensions; a rig places it and gives each surface a law and the places
that lie opposite. Normals point from the neighbour into the damper: contact point A is the neighbour, B the damper.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.contact.law import Law
from stickslip.model.contact.point import Contact, Motion, Start, contact_in_space
from stickslip.model.loads import Force
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.rigid_body import RigidBody
from stickslip.support.checks import Array, InputError, fault, finite, nearest, not_negative, square, vector

LawOfShare = Callable[[float], Law]
"""The law of a contact point that carries this share of its surface's stiffness: `lambda share: Macroslip(share * kt, ...)`."""


@dataclass(frozen=True, eq=False)
class ContactSurface:
    """A line or area contact as a set of points.

    points: (k, 3) [m], on the undeformed damper; frame: (3, 3), rows t1, t2, n, n into the damper;
    weights: (k,), the share of each point in the stiffness of the whole surface, sum 1; radius of the damper's rounding where
    it touches [m], on which it rolls; 0 where it cannot roll.
    """

    name: str
    points: ArrayLike
    frame: ArrayLike
    weights: ArrayLike
    radius: float = 0.0

    def __post_init__(self) -> None:
        points = np.asarray(self.points, dtype=float)
        if points.ndim != 2 or points.shape[1] != 3 or not points.size or not np.all(np.isfinite(points)):
            raise fault(f"Points of surface {self.name!r}", "must be finite, of shape (points, 3)", points.tolist())
        weights = vector(f"Weights of surface {self.name!r}", self.weights, points.shape[0])
        if np.any(weights <= 0.0) or abs(weights.sum() - 1.0) > 1e-9:
            raise fault(f"Weights of surface {self.name!r}", "must be positive with sum 1", weights.tolist())
        frame = square(f"Frame of surface {self.name!r}", self.frame, 3)
        not_negative(f"Radius of surface {self.name!r}", self.radius)
        for key, value in (("points", points), ("weights", weights), ("frame", frame)):
            object.__setattr__(self, key, value)


@dataclass(frozen=True, eq=False)
class Damper:
    """A rigid damper, named as its body is in the assembly.

    body: rigid body; surfaces: where it touches; pull: centrifugal force vector (3,) [N] at its mass centre.
    label: a readable name, in front of the names of its contacts (the name itself unless given).
    """

    name: str
    body: RigidBody
    surfaces: tuple[ContactSurface, ...]
    pull: ArrayLike = (0.0, 0.0, 0.0)
    label: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "surfaces", tuple(self.surfaces))
        object.__setattr__(self, "pull", vector("pull", self.pull, 3))
        names = [surface.name for surface in self.surfaces]
        if not names or len(set(names)) < len(names):
            raise fault(f"Surfaces of damper {self.name!r}", "must be at least one, with different names", names)

    @property
    def structure(self) -> Structure:
        """The free body, to be assembled under the damper's name."""
        return self.body.structure()

    def surface(self, name: str) -> ContactSurface:
        """The contact surface of this name."""
        for surface in self.surfaces:
            if surface.name == name:
                return surface
        known = nearest(name, [surface.name for surface in self.surfaces])
        raise InputError(f"Damper {self.name!r} has no contact surface {name!r}. {known}")

    def at(self, point: ArrayLike) -> Motion:
        """The motion of a point of the damper [m], in the names of the assembly."""
        return self.body.at(point, self.name)

    def contacts(
        self, surface: str, law: LawOfShare, neighbour: Motion | Sequence[Motion], start: Start | None = None
    ) -> tuple[Contact, ...]:
        """Contacts of a surface, named "LABEL SURFACE 1", ...: w = frame (u_neighbour − u_damper).

        neighbour: the place opposite each point, or one rigid place (such as `ground`) for all.
        """
        place = self.surface(surface)
        points = np.asarray(place.points)
        opposite = [neighbour] * len(points) if callable(neighbour) else list(neighbour)
        if len(opposite) != len(points):
            raise fault(f"Places opposite surface {surface!r}", f"must be one, or {len(points)}, one per point", len(opposite))
        title = f"{self.label or self.name} {surface}"
        return tuple(
            contact_in_space(f"{title} {i + 1}", law(float(weight)), opposite[i], self.at(point), place.frame, start)
            for i, (point, weight) in enumerate(zip(points, np.asarray(place.weights), strict=True))
        )

    def forces(self) -> tuple[Force, ...]:
        """The centrifugal pull as static forces at the mass centre."""
        pull = np.asarray(self.pull)
        node = f"{self.name}/{self.body.node}"
        return tuple(
            Force(f"{node}.{axis}", static=finite("pull", f), name=f"{self.label or self.name} centrifugal pull")
            for axis, f in zip("xyz", pull, strict=True)
            if f != 0.0
        )

    def wrench(self, surface: str, forces: Array) -> Array:
        """Force and moment about the mass centre, (6,), of contact forces (points, 3) given along t1, t2, n on the damper."""
        place = self.surface(surface)
        vectors = np.asarray(forces) @ np.asarray(place.frame)
        arms = np.asarray(place.points) - np.asarray(self.body.centre)
        return np.concatenate([vectors.sum(axis=0), np.cross(arms, vectors).sum(axis=0)])
