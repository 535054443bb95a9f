"""Several bodies as one structure: names prefixed "body/node.x", matrices block diagonal, linear springs between them.

Rigid bodies have 6 degrees of freedom at the mass centre; rotations are small. A point p of a body moves by u + θ × (p − c);
along a direction d that is d·u + ((p − c) × d)·θ. `at(point)` gives this as coefficients of named degrees of freedom, which
contacts, springs and forces take.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg, sparse

from stickslip.model.structure.matrices import SparseStructure, Structure
from stickslip.support.checks import Array, InputError, fault, finite, not_negative, of_kind, positive, symmetric, vector


@dataclass(frozen=True)
class Spring:
    """A linear spring and viscous damper along a direction, coefficients of the assembled degrees of freedom.

    w = Σ coefficient × dof, force = stiffness w + damping ẇ; stiffness [N/m], damping [N s/m]. Two bodies are joined by
    {"blade/tip.x": 1, "disk/rim.x": -1}; one dof alone is joined to ground.
    """

    direction: Mapping[str, float] = field(default_factory=dict)
    stiffness: float = 0.0
    damping: float = 0.0

    def __post_init__(self) -> None:
        not_negative("Spring.stiffness", self.stiffness)
        not_negative("Spring.damping", self.damping)
        for dof, coefficient in self.direction.items():
            finite(f"Spring, coefficient of {dof}", coefficient)
        if not any(self.direction.values()):
            raise fault("Spring.direction", "must have a coefficient that is not zero", dict(self.direction))


def prefixed(body: str, name: str) -> str:
    """The name of a node or degree of freedom within an assembly: "body/name"; without a body unchanged."""
    return f"{body}/{name}" if body else name


def assemble(bodies: Mapping[str, Structure], springs: Sequence[Spring] = ()) -> Structure:
    """One structure of several bodies {name: structure} and springs between them or to ground.

    Names read "body/node.x" then, those of a body without a name as before.
    C is assembled if a body or spring brings one. Damping rules (modal, Rayleigh) belong to the assembled structure. One with a
    body that is sparse is sparse as well, and takes no springs.
    """
    if not bodies:
        raise fault("bodies", "must hold at least one structure", "none")
    for name, body in bodies.items():
        of_kind(f"Body {name!r}", body, Structure)
        if body.damping is not None:
            raise InputError(
                f"Body {name!r} must not bring a damping rule into an assembly, but has {body.damping!r}. "
                "Give it a matrix C, or set the rule on the assembled structure with `with_damping`."
            )
    parts = list(bodies.values())
    dofs = tuple(prefixed(name, dof) for name, body in bodies.items() for dof in body.dofs)
    nodes = {prefixed(name, node): point for name, body in bodies.items() for node, point in body.nodes.items()}
    sets = {
        prefixed(name, key): tuple(prefixed(name, node) for node in members)
        for name, body in bodies.items()
        for key, members in body.sets.items()
    }
    mesh = np.concatenate([body.mesh_points for body in parts])
    outlines = {prefixed(name, node): corners for name, body in bodies.items() for node, corners in body.outlines.items()}
    surfaces = tuple(surface.prefixed(name) for name, body in bodies.items() for surface in body.surfaces)
    stresses = tuple(stress.prefixed(name) for name, body in bodies.items() for stress in body.stresses)
    if any(isinstance(body, SparseStructure) for body in parts):
        if springs or any(body.C is not None for body in parts):
            raise InputError("An assembly with a body whose M and K are sparse cannot have springs or matrices C.")
        M, K = (
            sparse.block_diag([sparse.csc_array(A) for A in matrices])
            for matrices in zip(*((b.M, b.K) for b in parts), strict=True)
        )
        kept = {name: body.kept if isinstance(body, SparseStructure) else body.dofs for name, body in bodies.items()}
        whole: Structure = SparseStructure(M, K, dofs, kept=tuple(prefixed(name, dof) for name in kept for dof in kept[name]))
    else:
        whole = _dense(parts, dofs, springs)
    return replace(whole, nodes=nodes, sets=sets, mesh_points=mesh, outlines=outlines, surfaces=surfaces, stresses=stresses)


def _dense(parts: Sequence[Structure], dofs: tuple[str, ...], springs: Sequence[Spring]) -> Structure:
    """The matrices of all bodies with the springs between them."""
    M = linalg.block_diag(*(body.M for body in parts))
    K = linalg.block_diag(*(body.K for body in parts))
    bare = Structure(M, K, dofs)
    if springs:
        K = K + _springs(bare, springs, [spring.stiffness for spring in springs])
    C: Array | None = None
    if any(body.C is not None for body in parts) or any(spring.damping for spring in springs):
        blocks = [np.zeros_like(body.M) if body.C is None else body.C for body in parts]
        C = np.asarray(linalg.block_diag(*blocks) + _springs(bare, springs, [spring.damping for spring in springs]))
    rotating: dict[str, Any] = {}
    for name in ("softening", "coriolis"):
        if any(getattr(body, name) is not None for body in parts):
            blocks = [np.zeros_like(body.M) if getattr(body, name) is None else getattr(body, name) for body in parts]
            rotating[name] = np.asarray(linalg.block_diag(*blocks))
    return Structure(M, K, dofs, C=C, **rotating)


def _springs(bare: Structure, springs: Sequence[Spring], values: Sequence[float]) -> Array:
    """Σ k rowᵀ row over the springs, (n, n)."""
    rows = bare.rows([spring.direction for spring in springs])
    return np.asarray(rows.T @ (np.asarray(values, dtype=float)[:, None] * rows))


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
