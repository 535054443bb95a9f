"""A structure: M, C, K with degrees of freedom named "NODE.DIRECTION". All linear models take this form.

Its damping is a matrix C, Rayleigh damping, or modal damping on free or stuck modes. The matrices of a finite-element model that
its contacts reduce stay sparse; large ones are checked to be square, finite and symmetric.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Literal, TypeVar
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from stickslip.support import checks
from stickslip.support.checks import LARGEST, Array, Index, InputError, fault

if TYPE_CHECKING:
    from stickslip.model.structure.centrifugal import CentrifugalLoads
    from stickslip.model.structure.mesh_surface import MeshSurface
    from stickslip.model.structure.stress import StressRecovery


@dataclass(frozen=True)
class ModalDamping:
    """Damping ratio ζ of every mode (a number), or of the first modes one by one (then zero).

    on = "stuck": the modes of K + BᵀK_cB; "free": those of K, the contacts absent.
    """

    ratio: float | Sequence[float]
    on: Literal["stuck", "free"] = "stuck"

    def __post_init__(self) -> None:
        if np.any(checks.vector("damping ratio", np.asarray(self.ratio)) < 0.0):
            raise fault("damping ratio", "must not be negative", self.ratio)
        if self.on not in ("stuck", "free"):
            raise fault("on", 'must be "stuck" or "free"', self.on)


@dataclass(frozen=True)
class RayleighDamping:
    """C = mass_factor M + stiffness_factor K. Factors in 1/s and s."""

    mass_factor: float
    stiffness_factor: float

    def __post_init__(self) -> None:
        checks.not_negative("mass_factor", self.mass_factor)
        checks.not_negative("stiffness_factor", self.stiffness_factor)


@dataclass(frozen=True)
class Dashpot:
    """A viscous damper along a direction, force c ẇ with w = Σ coefficient × dof; c [N s/m].

    It adds c rowᵀ row to C, whatever the damping of the structure is, and to the viscous part of all energies.
    """

    direction: Mapping[str, float]
    c: float

    def __post_init__(self) -> None:
        checks.positive("c of a dashpot", self.c)
        _check_direction("A dashpot", self.direction)


@dataclass(frozen=True)
class AerodynamicDamping:
    """The viscous part of gas forces that follow the motion along a direction, c ẇ; c [N s/m], negative where they feed it.

    It stands in `Problem(dashpots=...)`. c = Im(L)/ω of a complex stiffness L [N/m] at ω, or 2ζmω of a damping
    ratio ζ and a modal mass m along the direction.
    """

    direction: Mapping[str, float]
    c: float

    def __post_init__(self) -> None:
        if checks.finite("c of an aerodynamic damping", self.c) == 0.0:
            raise fault("c of an aerodynamic damping", "must not be zero", self.c)
        _check_direction("An aerodynamic damping", self.direction)


def _check_direction(what: str, direction: object) -> None:
    if not isinstance(direction, Mapping):
        rule = "must have a direction: coefficients by degree of freedom"
        raise fault(what, rule, direction, 'Write {"1.x": 1.0} for motion along x of node 1.')
    for dof, coefficient in direction.items():
        checks.finite(f"{what}, coefficient of {dof}", coefficient)
    if not any(direction.values()):
        raise fault(what, "must have a direction", dict(direction))


Damping = ModalDamping | RayleighDamping


Point = tuple[float, float, float]
"""Coordinates, m."""


@dataclass(frozen=True, eq=False, repr=False)
class Structure:
    """M q̈ + C q̇ + K q = p, dense; SciPy sparse matrices are taken and made dense.

    M, K: (n, n), symmetric, M without negative eigenvalues; C: (n, n) or None; dofs: n names "NODE.DIRECTION".
    damping: instead of C, a rule (`ModalDamping`, `RayleighDamping`). Neither: undamped.
    nodes: coordinates of nodes, m, and sets: nodes by the name of a set, where they are known; contact surfaces need them.
    mesh_points: coordinates of all nodes of the mesh behind a reduced model, (points, 3) [m], for drawings only.
    mesh_triangles: of the outer surface, (triangles, 3), places among mesh_points, of a sector whose elements are known.
    surfaces: outer surfaces of meshed bodies with their motion, for deformed shapes only.
    stresses: at named places of models, from the motion q.
    centrifugal: loads of rotation of a model that was read, whose nodes inside may no longer be there; softening: the matrix that
    times Ω² was taken from K, (n, n) [kg]; coriolis: what Coriolis forces add to C or the damping rule, skew, (n, n) [N s/m].
    outlines: sections of rigid bodies by the node at their mass centre, corners (k, 3) [m], for drawings only.
    shapes: where M, C, K are (m, m), of m coordinates y fewer than degrees of freedom, the motion q = shapes y, (n, m);
    `Problem.truncated` makes such structures.
    """

    M: Array
    K: Array
    dofs: tuple[str, ...]
    C: Array | None = None
    damping: Damping | None = None
    nodes: Mapping[str, Point] = field(default_factory=dict, kw_only=True)
    sets: Mapping[str, tuple[str, ...]] = field(default_factory=dict, kw_only=True)
    mesh_points: Array = field(default_factory=lambda: np.zeros((0, 3)), kw_only=True)
    mesh_triangles: Index = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64), kw_only=True)
    outlines: Mapping[str, Array] = field(default_factory=dict, kw_only=True)
    surfaces: "tuple[MeshSurface, ...]" = field(default=(), kw_only=True)
    stresses: "tuple[StressRecovery, ...]" = field(default=(), kw_only=True)
    shapes: Array | None = field(default=None, kw_only=True)
    centrifugal: "CentrifugalLoads | None" = field(default=None, kw_only=True)
    softening: Array | None = field(default=None, kw_only=True)
    coriolis: Array | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "dofs", checks.several("dofs", self.dofs))
        size = self.size
        check_names(self.dofs)
        object.__setattr__(self, "M", checks.symmetric("M", self.M, size))
        object.__setattr__(self, "K", checks.symmetric("K", self.K, size))
        if self.C is not None:
            if self.damping is not None:
                raise InputError("A structure must have either C or a damping rule, but has both. Leave one out.")
            object.__setattr__(self, "C", checks.square("C", self.C, size))
            part, most = 0.5 * (self.C + self.C.T), 1e-9 * size * float(np.max(np.abs(self.C), initial=0.0))
            if most > 0.0 and not checks.is_definite(part, most):  # a viscous damper takes energy out
                lowest = float(np.linalg.eigvalsh(part)[0])
                raise fault("C", "must not feed energy in (no negative eigenvalue)", lowest, "Check the sign of the damping.")
        if not isinstance(self.damping, ModalDamping | RayleighDamping | None):
            raise fault("damping", "must be a rule, ModalDamping(...) or RayleighDamping(...)", self.damping)
        scale = float(np.max(np.abs(self.M), initial=0.0))
        if scale < checks.SMALLEST:
            raise fault("M", "must have mass", f"{scale:g} at most", "Check its unit.")
        if not checks.is_definite(self.M, 1e-9 * scale * size):
            lowest = float(np.linalg.eigvalsh(self.M)[0])
            raise fault("M", "must have no negative eigenvalue", lowest, "Check the sign and the units of the mass.")

    def __repr__(self) -> str:
        rule = "undamped" if self.damping is None else type(self.damping).__name__
        return f"{type(self).__name__}: {freedoms(self.dofs)}, {rule if self.C is None else 'with C'}"

    @property
    def extent(self) -> float:
        """The longest side of the box round its nodes, m; 0 where no coordinates are known."""
        places = np.concatenate([self.mesh_points, np.reshape(list(self.nodes.values()), (-1, 3))])
        return float(np.ptp(places, axis=0).max()) if len(places) else 0.0

    @property
    def whole_stiffness(self) -> NDArray[Any]:
        """K; of a cyclic structure that of each nodal diameter."""
        return self.K

    @property
    def size(self) -> int:
        """The number of coordinates: the degrees of freedom, or fewer (`shapes`)."""
        return len(self.dofs) if self.shapes is None else int(self.shapes.shape[1])

    def motion(self, y: Array) -> Array:
        """q (n, ...) [m] of every degree of freedom for a motion of the coordinates y (m, ...)."""
        return y if self.shapes is None else np.asarray(self.shapes @ y)

    @cached_property
    def _positions(self) -> dict[str, int]:
        """The position of each degree of freedom, found once."""
        return {dof: position for position, dof in enumerate(self.dofs)}

    @cached_property
    def _alone(self) -> dict[str, str]:
        """The degrees of freedom of sets of one node by their short names, found once."""
        return of_single_nodes(self.dofs)

    def index(self, dof: str) -> int:
        """Position of a degree of freedom; tip.x stands for tip/1430.x where that is the only node of the set tip."""
        try:
            return self._positions[self._alone.get(dof, dof)]
        except KeyError:
            raise InputError(f"Degree of freedom {dof!r} does not exist. {nearest_dof(dof, self.dofs)}") from None

    def row(self, direction: Mapping[str, float]) -> Array:
        """The coefficients of a direction as a row vector over the coordinates, (m,)."""
        return np.asarray(self.rows([direction])[0])

    def rows(self, directions: Sequence[Mapping[str, float]]) -> Array:
        """The coefficients of several directions over the coordinates, (len(directions), m)."""
        columns = np.array([self.index(dof) for direction in directions for dof in direction], dtype=np.int64)
        values = np.array([value for direction in directions for value in direction.values()], dtype=float)
        at = np.repeat(np.arange(len(directions)), [len(direction) for direction in directions])
        rows = np.zeros((len(directions), self.size))
        if self.shapes is None:
            np.add.at(rows, (at, columns), values)
        else:
            np.add.at(rows, at, values[:, None] * self.shapes[columns])
        return rows

    def shifted(self, by: Sequence[float]) -> "Structure":
        """A copy whose nodes stand elsewhere, `by` (x, y, z) [m]: the same blade again beside it."""
        step = checks.vector("by", by, 3)
        x, y, z = step.tolist()
        nodes = {name: (p[0] + x, p[1] + y, p[2] + z) for name, p in self.nodes.items()}
        outlines = {name: corners + step for name, corners in self.outlines.items()}
        surfaces = tuple(surface.shifted(step) for surface in self.surfaces)
        loads = None if self.centrifugal is None else self.centrifugal.shifted(step)
        moved = replace(self, nodes=nodes, mesh_points=self.mesh_points + step, outlines=outlines, surfaces=surfaces)
        return replace(moved, centrifugal=loads)

    def with_damping(self, damping: Damping | Array | None) -> "Structure":
        """A copy with another damping: a rule, a matrix C, or none."""
        if isinstance(damping, ModalDamping | RayleighDamping | None):
            return replace(self, C=None, damping=damping)
        return replace(self, C=damping, damping=None)


def freedoms(dofs: Sequence[str]) -> str:
    """How many degrees of freedom there are, and the first and last of them."""
    listed = ", ".join(dofs) if len(dofs) < 5 else f"{', '.join(dofs[:2])}, ..., {dofs[-1]}"
    return f"{checks.counted(len(dofs), 'degree of freedom', 'degrees of freedom')} ({listed})"


@lru_cache(maxsize=8)
def check_names(dofs: tuple[str, ...]) -> None:
    """Names of degrees of freedom are different, can be written, and say node and direction; those of copies are known."""
    for dof in dofs:
        checks.storable("A name in dofs", dof)
        if not all(dof.rpartition(".")[::2]):
            raise fault("A name in dofs", "must be NODE.DIRECTION", dof, f"Write {dof.strip('.') or '1'!s}.x, say.")
    checks.unique("dofs", dofs)


def of_single_nodes(dofs: Iterable[str]) -> dict[str, str]:
    """Short names of the degrees of freedom of sets of one node: {"tip.x": "tip/1430.x"}; names that exist keep their meaning."""
    members: dict[str, list[str]] = {}
    for dof in dofs:
        node, _, direction = dof.rpartition(".")
        name, _, number = node.rpartition("/")
        if name and number.isdecimal():
            members.setdefault(f"{name}.{direction}", []).append(dof)
    known = set(dofs)
    return {short: own[0] for short, own in members.items() if len(own) == 1 and short not in known}


def nearest_dof(name: str, dofs: Iterable[str]) -> str:
    """A remedy that names the nearest degree of freedom, of the same structure where that exists."""
    own = [dof for dof in dofs if "/" in name and dof.startswith(f"{name.partition('/')[0]}/")]
    return checks.nearest(name, own or dofs)


Sparse = sparse.csc_array
_Compressed = TypeVar("_Compressed", sparse.csc_array, sparse.csr_array)
Report = Callable[[str], None]
"""Called with what is being done with a large matrix."""


def square_sparse(what: str, matrix: Any) -> Sparse:
    """`matrix`, dense or sparse, as a finite square (n, n)."""
    if np.ndim(matrix) != 2:
        raise fault(what, "must be a square matrix", np.shape(matrix), "Give as many rows as columns.")
    stored = sparse.coo_array(matrix)
    if stored.shape[0] != stored.shape[1]:
        raise fault(what, "must be a square matrix", stored.shape, "Give as many rows as columns.")
    wrong = np.flatnonzero(~np.isfinite(stored.data))
    if wrong.size:
        row, column = (indices[wrong[0]] for indices in stored.coords)
        raise fault(f"{what}[{row}, {column}]", "must be finite", float(stored.data[wrong[0]]))
    largest = float(np.max(np.abs(stored.data), initial=0.0))
    if largest > LARGEST:
        raise fault(what, f"must not be larger than {LARGEST:g} in size", largest, "Check its unit, and the file for damage.")
    return with_short_indices(stored.tocsc())


def with_short_indices(matrix: _Compressed) -> _Compressed:
    """A compressed matrix with indices of 32 bits where these suffice: a quarter less memory, and products a quarter faster."""
    if max(matrix.nnz, *matrix.shape) <= np.iinfo(np.int32).max:
        matrix.indices, matrix.indptr = (each.astype(np.int32, copy=False) for each in (matrix.indices, matrix.indptr))
    return matrix


_symmetric: WeakValueDictionary[int, Sparse] = WeakValueDictionary()
"""The matrices that `symmetric_sparse` returned, by their identity."""


def symmetric_sparse(what: str, matrix: Any, tolerance: float = 1e-8) -> Sparse:
    """`matrix` as a finite square equal to its transpose within `tolerance` of its largest entry; returned exactly symmetric.

    One that was returned is returned as it is: copies of structures check their matrices again.
    """
    known = _symmetric.get(id(matrix))
    if known is not None and known is matrix:
        return known
    stored = square_sparse(what, matrix)
    gap = sparse.coo_array(stored - stored.T)
    scale = float(np.max(np.abs(stored.data), initial=0.0))
    if gap.nnz and float(np.abs(gap.data).max()) > tolerance * scale:
        worst = int(np.abs(gap.data).argmax())
        row, column = sorted((int(gap.coords[0][worst]), int(gap.coords[1][worst])))
        raise fault(
            what,
            "must be symmetric",
            f"{what}[{row}, {column}] = {stored[row, column]:g} against {what}[{column}, {row}] = {stored[column, row]:g}",
            "Only one triangle stored? Fill the other; else check the export.",
        )
    stored = sparse.csc_array(0.5 * (stored + stored.T)) if gap.nnz else stored
    return _symmetric.setdefault(id(stored), stored)


def both_triangles(what: str, matrix: Any) -> Sparse:
    """The symmetric matrix of which `matrix` stores each pair of entries once, on either side of the diagonal."""
    stored = sparse.csc_array(matrix)
    twice = sparse.coo_array(sparse.tril(stored, -1).multiply(sparse.triu(stored, 1).T))
    if twice.nnz:
        row, column = (int(place[0]) + 1 for place in twice.coords)
        remedy = "A symmetric matrix stores one triangle; a whole one must be written as general (square)."
        raise fault(what, "must hold each entry once", f"row {row}, column {column} and its mirror image", remedy)
    return sparse.csc_array(stored + stored.T - sparse.diags_array(stored.diagonal()))


@dataclass(frozen=True, eq=False, repr=False)
class SparseStructure(Structure):
    """M q̈ + C q̇ + K q = p with sparse M and K (n, n), C by a damping rule alone.

    kept: the degrees of freedom whose motion a problem of this structure has to know, beside those that contacts and loads name.
    directions: coefficients (n,) of directions in which all of the structure moves, by names that a problem knows them by.
    """

    M: Any
    K: Any
    kept: tuple[str, ...] = field(default=(), kw_only=True)
    directions: Mapping[str, Array] = field(default_factory=dict, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "M", symmetric_sparse("M", self.M))
        object.__setattr__(self, "K", symmetric_sparse("K", self.K))
        check_names(self.dofs)
        for what, matrix in (("M", self.M), ("K", self.K)):
            if matrix.shape[0] != len(self.dofs):
                raise fault(what, f"must have the {len(self.dofs)} rows of dofs", matrix.shape)

    def rows(self, directions: Sequence[Mapping[str, float]]) -> Any:
        """The coefficients of several directions over the degrees of freedom, sparse, (len(directions), n)."""
        columns = [self.index(dof) for direction in directions for dof in direction]
        values = [value for direction in directions for value in direction.values()]
        at = np.repeat(np.arange(len(directions)), [len(direction) for direction in directions])
        return with_short_indices(sparse.csr_array((values, (at, columns)), shape=(len(directions), self.size), dtype=float))
