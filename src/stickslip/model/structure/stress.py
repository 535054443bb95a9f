"""Stress recovery in a meshed body from the degrees of freedom of its reduced model, and the fatigue limit to compare it with.

σ = D ε(u), u = T q: for chosen places the product is one small matrix, made once. Linear elasticity, small strains.

Finite elements of other programs have stress at their nodes, as CalculiX gives it: computed at the integration points,
extrapolated to the corners; a node in the middle of an edge has the mean of the two corners. (CalculiX CrunchiX User's Manual,
chapters Element types and Shape functions.)

The limit is the amplitude of stress that a material stands, over the mean stress (Haigh diagram). Source: R. C. Juvinall and
K. M. Marshek, Fundamentals of Machine Component Design, chapter 8 (Goodman, Gerber, Soderberg); G. Sines, Behavior of metals
under complex static and alternating stresses (1959), for several components.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg

from stickslip.model.structure.cyclic import ONE_SECTOR, HeldDiameters, of_all_sectors, sector_name
from stickslip.model.structure.cyclic_reduction import Reduction
from stickslip.model.structure.matrices import freedoms
from stickslip.model.structure.solid import NODES, STEEL, Material, Solid, element, slopes_of
from stickslip.support.checks import Array, InputError, among, counted, fault, numbers, positive, vector
from stickslip.support.late import skfem

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")
INSIDE = 1e-6
"""How far beyond its cell, in local coordinates from 0 to 1, a place on a face may lie by rounding."""
TENSOR = [0, 3, 5, 3, 1, 4, 5, 4, 2]
"""Where the nine entries of the stress tensor stand among `COMPONENTS`."""
EQUAL = 1e-6
"""Relative difference up to which two principal stresses are one."""


@dataclass(frozen=True, eq=False, repr=False)
class StressRecovery:
    """σ = rows q at named places. rows (places, 6, dofs) [Pa/m], components xx, yy, zz, xy, yz, zx; dofs: names of q.

    waves (N//2 + 1, places, 6, dofs), complex: of one sector of a disk, the rows for each of its nodal `diameters`.
    gauges: places with a strain gauge, and the strain that it measures per stress there, (6,) [1/Pa].
    rotation (places, 6): stress of the rotation, which is added to the mean, Pa; None where it is not known.
    """

    places: tuple[str, ...]
    rows: Array
    dofs: tuple[str, ...]
    waves: NDArray[Any] | None = None
    diameters: HeldDiameters = ONE_SECTOR
    gauges: Mapping[str, Array] = field(default_factory=dict)
    rotation: Array | None = None

    def at(self, nodal_diameter: int) -> NDArray[Any]:
        """The rows of a nodal diameter, any whole number: that of N − n runs the other way, its rows are conjugate."""
        return self.rows if self.waves is None else self.diameters.pick(self.waves, nodal_diameter)

    def of_whole_disk(self, chosen: Sequence[int] | None = None) -> "StressRecovery":
        """Of one sector, that of all sectors of its disk, or of some, from 1: all names are "SECTOR/..."."""
        if self.waves is None:
            raise InputError("The stress recovery of a disk must be of one of its sectors, with rows for each nodal diameter.")
        self.diameters.require_all()
        sectors = self.diameters.sectors
        every = range(1, sectors + 1)
        here = every if chosen is None else chosen
        waves = self.waves.reshape(len(self.waves), -1, len(self.dofs))
        places, gauges = (tuple(sector_name(j, name) for j in here for name in names) for names in (self.places, self.gauges))
        dofs = tuple(sector_name(j, name) for j in every for name in self.dofs)
        rows = of_all_sectors(waves, sectors, [j - 1 for j in here]).reshape(len(places), len(COMPONENTS), len(dofs))
        strains = dict(zip(gauges, [*self.gauges.values()] * len(here), strict=True))
        rotation = None if self.rotation is None else np.tile(self.rotation, (len(here), 1))
        return StressRecovery(places, rows, dofs, gauges=strains, rotation=rotation)

    def prefixed(self, body: str) -> "StressRecovery":
        """The same within an assembly, where places and degrees of freedom are named "BODY/..."."""
        places, dofs, gauges = (
            tuple(f"{body}/{name}" if body else name for name in names) for names in (self.places, self.dofs, self.gauges)
        )
        return replace(self, places=places, dofs=dofs, gauges=dict(zip(gauges, self.gauges.values(), strict=True)))

    def __repr__(self) -> str:
        return f"StressRecovery: {counted(len(self.places), 'place')} from {freedoms(self.dofs)}"


def joined(recoveries: Sequence[StressRecovery]) -> StressRecovery:
    """One recovery of several bodies."""
    if len(recoveries) == 1:
        return recoveries[0]
    places = tuple(place for each in recoveries for place in each.places)
    dofs = tuple(dof for each in recoveries for dof in each.dofs)
    blocks = linalg.block_diag(*(each.rows.reshape(-1, len(each.dofs)) for each in recoveries))
    gauges = {name: strain for each in recoveries for name, strain in each.gauges.items()}
    rotations = [each.rotation for each in recoveries]
    none = [np.zeros((len(each.places), len(COMPONENTS))) for each in recoveries]
    rotation = np.concatenate([own if own is not None else zero for own, zero in zip(rotations, none, strict=True)])
    known = None if all(each is None for each in rotations) else rotation
    return StressRecovery(places, blocks.reshape(len(places), 6, len(dofs)), dofs, gauges=gauges, rotation=known)


def stress_recovery(
    mesh: Any, body: Solid, reduction: Reduction, places: Mapping[str, ArrayLike], prefix: str = "", material: Material = STEEL
) -> StressRecovery:
    """The recovery of a reduced body at places {name: (x, y, z)} in m.

    mesh, body: the `MeshHex` and what `solid` made of it, clamped as it was reduced; prefix: of the body's names in an assembly,
    "blade/". At a place that several cells share, the mean of their stresses.
    """
    full = np.array([stress_rows(mesh, body, vector(f"The place {name}", at, 3), material) for name, at in places.items()])
    dofs = tuple(prefix + dof for dof in reduction.structure.dofs)
    return StressRecovery(tuple(places), full.reshape(len(places), 6, body.size) @ reduction.transformation, dofs)


def stress_rows(mesh: Any, body: Solid, place: Array, material: Material = STEEL) -> Array:
    """Stress at a place per displacement of the unreduced body, (6, n), Pa/m."""
    basis = skfem.Basis(mesh, skfem.ElementHexS2(), intorder=1)
    cells = _cells_around(basis, mesh, place)
    rows = np.zeros((6, body.size + 1))  # the last column takes clamped directions, −1
    for cell, local in cells:
        at, only = local.reshape(3, 1), np.array([cell])
        for a in range(basis.Nbfun):
            gradient = np.reshape(basis.elem.gbasis(basis.mapping, at, a, only)[0].grad, 3)
            node = basis.element_dofs[a, cell]
            rows[:, body.numbers[node]] += _stress(gradient, material) / len(cells)
    return rows[:, :-1]


def von_mises(stress: Array) -> Array:
    """√(½((σxx − σyy)² + (σyy − σzz)² + (σzz − σxx)²) + 3 (τxy² + τyz² + τzx²)) of stresses (..., 6), Pa."""
    x, y, z, xy, yz, zx = np.moveaxis(np.asarray(stress), -1, 0)
    return np.asarray(np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) + 3.0 * (xy**2 + yz**2 + zx**2)))


def principal_size(stress: Array) -> Array:
    """The size of the largest principal stress, max |σ_k|, of stresses (..., 6), Pa."""
    return np.asarray(np.abs(_principal_ends(stress)).max(axis=0))


def _principal_ends(stress: Array) -> Array:
    """The largest and the smallest principal stress of stresses (..., 6), (2, ...).

    With the deviator's invariants J₂, J₃: σ_k = I₁/3 + 2 √(J₂/3) cos(θ − 2πk/3), cos 3θ = (3√3/2) J₃/J₂^{3/2}.
    """
    x, y, z, xy, yz, zx = np.moveaxis(np.asarray(stress, dtype=float), -1, 0)
    mean = (x + y + z) / 3.0
    x, y, z = x - mean, y - mean, z - mean
    second = von_mises(stress) ** 2 / 3.0
    third = x * y * z + 2.0 * xy * yz * zx - x * yz**2 - y * zx**2 - z * xy**2
    with np.errstate(divide="ignore", invalid="ignore"):
        lode = np.where(second > 0.0, 1.5 * np.sqrt(3.0) * third / second**1.5, 1.0)
    angle = np.arccos(np.clip(lode, -1.0, 1.0)) / 3.0
    radius = 2.0 * np.sqrt(second / 3.0)
    return np.stack([mean + radius * np.cos(angle), mean + radius * np.cos(angle + 2.0 * np.pi / 3.0)])


def critical_plane(vibration: Array, mean: Array) -> tuple[float, float]:
    """Amplitude and mean of the normal stress on the plane where its amplitude is largest, Pa.

    vibration (instants, 6): stress over a period, without its mean (6,). σ_a = ½ max_n (max_t nᵀσ(t)n − min_t nᵀσ(t)n), which
    is half the largest principal stress of all differences σ(t₁) − σ(t₂); σ_m = the middle of both with nᵀσ̄n.
    Of several planes of equal amplitude, as in pure shear, that of the largest mean.
    Source: D. F. Socie and G. B. Marquis, Multiaxial Fatigue, SAE (2000), critical planes of normal stress.
    """
    high, low = _principal_ends(vibration)
    likely = vibration[[np.argmax(high), np.argmin(low)]]
    least = (1.0 - EQUAL) * float(principal_size(vibration - likely[:, None]).max())
    # σ₁(A − B) ≤ σ₁(A) − σ₃(B): all other pairs of instants stay below.
    pairs = high[:, None] - low >= least
    first, second = np.nonzero(np.triu(pairs | pairs.T)) if least > 0.0 else np.zeros((2, 1), dtype=int)
    differences = vibration[first] - vibration[second]
    sizes = principal_size(differences)
    near = differences[sizes >= (1.0 - EQUAL) * sizes.max()]
    # Where principal stresses are equal, their axes are those of the mean.
    tilt = EQUAL**2 * sizes.max() / (np.abs(mean).max() or 1.0) or 1.0
    _, axes = np.linalg.eigh((near + tilt * mean)[:, TENSOR].reshape(-1, 3, 3))
    normal = normal_rows(axes.swapaxes(1, 2).reshape(-1, 3))
    over_time = vibration @ normal.T
    high, low = over_time.max(axis=0), over_time.min(axis=0)
    amplitudes, means = 0.5 * (high - low), 0.5 * (high + low) + normal @ mean
    largest = amplitudes >= (1.0 - EQUAL) * amplitudes.max()
    return float(amplitudes[largest].max()), float(means[largest].max())


def normal_rows(directions: Array) -> Array:
    """nᵀσn per stress, (..., 6), of unit vectors n (..., 3)."""
    x, y, z = np.moveaxis(directions, -1, 0)
    return np.stack([x * x, y * y, z * z, 2.0 * x * y, 2.0 * y * z, 2.0 * z * x], axis=-1)


def strain_along(direction: ArrayLike, material: Material) -> Array:
    """The normal strain along a direction per stress, (6,) [1/Pa]: ε = dᵀ ((1 + ν) σ − ν tr(σ) 1) d / E, |d| = 1."""
    d = vector("direction", direction, 3)
    size = float(np.linalg.norm(d))
    if not size:
        raise fault("direction", "must not be zero", d.tolist())
    nu, young = material.poisson, material.young
    return np.asarray(((1.0 + nu) * normal_rows(d / size) - nu * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])) / young)


def _cells_around(basis: Any, mesh: Any, place: Array) -> list[tuple[int, Array]]:
    """The cells that hold a place, with its local coordinates there."""
    corners = mesh.p[:, mesh.t]
    size = np.ptp(corners, axis=1)
    low, high = corners.min(axis=1) - INSIDE * size, corners.max(axis=1) + INSIDE * size
    near = np.flatnonzero(np.all((low <= place[:, None]) & (place[:, None] <= high), axis=0))
    cells = []
    for cell in near.tolist():
        local = np.asarray(basis.mapping.invF(place.reshape(3, 1, 1), tind=np.array([cell]))).reshape(3)
        if np.all(np.abs(local - 0.5) <= 0.5 + INSIDE):
            cells.append((cell, np.clip(local, 0.0, 1.0)))
    if not cells:
        box = f"the body reaches from {mesh.p.min(axis=1).tolist()} to {mesh.p.max(axis=1).tolist()} m"
        raise fault("A place of stress", "must lie in the body", place.tolist(), f"({box}.)")
    return cells


def _stress(slopes: Array, material: Material) -> Array:
    """Stress (..., 6, 3) of the displacement N along each axis with ∇N = slopes (..., 3): λ tr ε 1 + 2 μ ε, Pa/m."""
    lam, shear = material.lame
    stress = np.zeros((*slopes.shape[:-1], 6, 3))
    for axis in range(3):
        stress[..., :3, axis] += lam * slopes[..., axis, None]
        stress[..., axis, axis] += 2.0 * shear * slopes[..., axis]
    for component, (one, other) in enumerate(((0, 1), (1, 2), (2, 0)), start=3):
        stress[..., component, one] += shear * slopes[..., other]
        stress[..., component, other] += shear * slopes[..., one]
    return stress


KINDS = {kind: nodes for kind, nodes in NODES.items() if kind != "C3D20"}
"""Elements whose stress is recovered, and the number of their nodes."""


def _polynomial(at: Array, terms: int) -> Array:
    """The terms of the polynomial through 1, 4 or 8 integration points, (places, terms): constant, linear or trilinear."""
    x, y, z = at.T
    return np.column_stack([np.ones(len(at)), x, y, z, x * y, y * z, z * x, x * y * z])[:, :terms]


def nodal_stress(kind: str, points: Array, material: Material) -> Array:
    """Stress at the nodes of one element per displacement of its nodes, (nodes, 6, nodes, 3) [Pa/m]: xx, yy, zz, xy, yz, zx.

    kind: one of `KINDS`; points (nodes, 3) in the order of the deck, m.
    """
    if kind not in KINDS:
        remedy = "Choose another place, or model this region with one of them."
        raise fault("An element at a place of stress", f"must be one of {', '.join(KINDS)}", kind, remedy)
    own = element(kind)
    to_corners = _polynomial(own.corners, len(own.points)) @ np.linalg.inv(_polynomial(own.points, len(own.points)))
    slopes, _ = slopes_of(kind, ["at a place of stress"], points[None])
    return np.asarray(np.einsum("np,pmcx->ncmx", to_corners[own.ends].mean(axis=1), _stress(slopes[0].swapaxes(1, 2), material)))


Criterion = Literal["goodman", "gerber", "soderberg"]
CRITERIA = ("goodman", "gerber", "soderberg")


@dataclass(frozen=True)
class FatigueLimit:
    """The stress amplitude σ_A [Pa] that a material stands at a mean stress σ_m [Pa], any number of cycles.

    fatigue_strength: σ_A without mean stress, S. criterion: "goodman", σ_A = S (1 − σ_m/R_m); "gerber",
    σ_A = S (1 − (σ_m/R_m)²); "soderberg", σ_A = S (1 − σ_m/R_p). ultimate_strength: R_m; yield_strength: R_p, beside the first
    two also σ_A + |σ_m| ≤ R_p. points: pairs (σ_m, σ_A) of a measured diagram in place of all these, with straight lines
    between. A mean stress in compression gains nothing; beyond R_m, or the last point, the material stands nothing.
    """

    fatigue_strength: float | None = None
    ultimate_strength: float | None = None
    yield_strength: float | None = None
    criterion: Criterion = "goodman"
    points: Sequence[Sequence[float]] = field(default=())

    def __post_init__(self) -> None:
        among("criterion", self.criterion, CRITERIA)
        if len(self.points):
            if (self.fatigue_strength, self.ultimate_strength, self.yield_strength) != (None, None, None):
                raise fault("points", "must stand alone", "beside a strength", "They are the whole diagram.")
            table, pairs = numbers("points", self.points), list(map(list, self.points))
            if table.ndim != 2 or table.shape[1] != 2 or len(table) < 2:
                raise fault("points", "must be two or more pairs of mean stress and amplitude", pairs)
            if np.any(np.diff(table[:, 0]) <= 0.0) or np.any(table[:, 1] < 0.0):
                raise fault("points", "must have rising mean stresses, and no negative amplitude", pairs)
            return
        if self.fatigue_strength is None:
            raise fault("fatigue_strength", "must be given", "none", "Or give points of a Haigh diagram.")
        for name in ("fatigue_strength", "ultimate_strength", "yield_strength"):
            if getattr(self, name) is not None:
                positive(name, getattr(self, name))
        needed = "yield_strength" if self.criterion == "soderberg" else "ultimate_strength"
        most = getattr(self, needed)
        if most is None:
            raise fault(needed, f'must go with criterion = "{self.criterion}"', "none")
        if self.fatigue_strength >= most:
            raise fault("fatigue_strength", f"must be below {needed} = {most:g}", self.fatigue_strength, "Are they exchanged?")

    def amplitude(self, mean: ArrayLike) -> Array:
        """σ_A [Pa] at mean stresses [Pa]."""
        mean = np.asarray(mean, dtype=float)
        if len(self.points):
            at, allowed = np.asarray(self.points, dtype=float).T
            return np.asarray(np.interp(mean, at, allowed, right=0.0))
        strength, tension = self.fatigue_strength or 0.0, np.maximum(mean, 0.0)
        if self.criterion == "gerber":
            allowed = strength * (1.0 - (tension / (self.ultimate_strength or np.inf)) ** 2)
        else:
            most = self.yield_strength if self.criterion == "soderberg" else self.ultimate_strength
            allowed = strength * (1.0 - tension / (most or np.inf))
        if self.yield_strength is not None:
            allowed = np.minimum(allowed, self.yield_strength - np.abs(mean))
        return np.asarray(np.maximum(allowed, 0.0))

    @property
    def largest_mean(self) -> float:
        """The mean stress [Pa] from which on the material stands no vibration, or that of the last point."""
        if len(self.points):
            return float(self.points[-1][0])
        known = [size for size in (self.ultimate_strength, self.yield_strength) if size is not None]
        return float(min(known))

    @property
    def words(self) -> str:
        """ "Goodman", or "given diagram"."""
        return "given diagram" if len(self.points) else self.criterion.capitalize()
