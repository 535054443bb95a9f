"""Several bodies as one structure: names prefixed "body/node.x", matrices block diagonal, linear springs between them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import linalg, sparse

from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.sparse import SparseStructure
from stickslip.support.checks import Array, InputError, fault, finite, not_negative, of_kind


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
