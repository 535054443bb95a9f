"""Stress at named nodes of a model, from the elements of its deck: sparse rows over the degrees of freedom of the model.

Places to keep in a reduction: a node id, a node set, or the node nearest to given coordinates.

Stress due to rotation at places of a sector or of a body, from its centrifugal load.

The rotor speed that a stiffness matrix belongs to, from its spin softening.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from stickslip.model.readers.deck import OWN_AXES
from stickslip.model.readers.model import Model
from stickslip.model.structure.centrifugal import CentrifugalLoads, RotationAxis
from stickslip.model.structure.cyclic import HeldDiameters
from stickslip.model.structure.cyclic_reduction import Sector, hermitian
from stickslip.model.structure.factor import Factor, Singular
from stickslip.model.structure.solid import Material
from stickslip.model.structure.stress import COMPONENTS, KINDS, StressRecovery, nodal_stress, strain_along, von_mises
from stickslip.support.checks import Array, Faults, InputError, counted, fault, nearest, several, vector

Where = str | int | Sequence[float]
"""A node (17 or "17"), a set ("PAD"), a degree of freedom ("17.x"), or coordinates (x, y, z)."""
Keep = Mapping[str, Where] | Sequence[str | int]

ROUNDING = 1e-9
"""Distance, m, below which a node is at a point asked for: a nanometre."""


@dataclass(frozen=True)
class Place:
    """A place that was found: the names of its degrees of freedom and their rows in the model.

    nodes: of the model; distance: from the coordinates asked for to the node, m (0 for ids and sets).
    """

    name: str
    nodes: tuple[str, ...]
    dofs: Mapping[str, int]
    distance: float = 0.0

    def __str__(self) -> str:
        listed = ", ".join(self.nodes[:6]) + (f", ... ({len(self.nodes)})" if len(self.nodes) > 6 else "")
        away = f", {self.distance * 1e3:.3g} mm from the point asked for" if self.distance > ROUNDING else ""
        return f"{self.name}: node{'s' if len(self.nodes) > 1 else ''} {listed}{away}"


def places_of(model: Model, keep: Keep, metres: float = 1.0, surfaces: Sequence[str] = ()) -> tuple[Place, ...]:
    """Every place of `keep`, {name: where} or a list of ids, sets and degrees of freedom; coordinates in units of `metres`.

    A named node gives NAME.x, NAME.y, ...; a named set NAME/NODE.x, ...; what stands in a list keeps the names of the model.
    surfaces: sets kept besides, of which nodes may stand elsewhere too: these have the names that they have there.
    """
    named = keep.items() if isinstance(keep, Mapping) else [("", where) for where in several("keep", keep)]
    places, faults = [], []
    for name, where in named:
        try:
            places.append(_place(model, name, where, metres))
        except InputError as error:
            faults.append(f"keep{f', {name}' if name else ''}: {error}")
    names = [dof for place in places for dof in place.dofs]
    rows = [row for place in places for row in place.dofs.values()]
    if len(set(rows)) < len(rows) or len(set(names)) < len(names):
        repeated = sorted({model.dofs[row] for row in rows if rows.count(row) > 1})
        faults.append(str(fault("keep", "must name each degree of freedom once", repeated[:5] or "repeated names")))
    if faults:
        raise Faults(faults)
    taken = {node for place in places for node in place.nodes}
    for name in surfaces:
        whole = _place(model, name, name, metres)
        fresh = {node: f"{name}/{node}" for node in whole.nodes if node not in taken}
        taken |= set(fresh)
        places.append(Place(name, whole.nodes, _dofs(model, fresh)))
    return tuple(places)


def _place(model: Model, name: str, where: Any, metres: float) -> Place:
    """A degree of freedom, a set, a node, or the node nearest to coordinates; `name` is empty for what keeps its own."""
    if isinstance(where, str | Integral):
        word = str(where)
        if word in model.rows:
            return Place(name or word, (word.rpartition(".")[0],), {name or word: model.rows[word]})
        if word in model.sets:
            nodes = tuple(node for node in model.sets[word] if node in model.directions)
            if not nodes:
                raise fault(f"The set {word}", "must have nodes with rows", "all of them fixed, or not in the matrices")
            return Place(name or word, nodes, _dofs(model, {node: f"{name}/{node}" if name else node for node in nodes}))
        if word in model.directions:
            return Place(name or word, (word,), _dofs(model, {word: name or word}))
        raise InputError(f"Node or set {word!r} does not exist. {nearest(word, [*model.sets, *model.directions])}")
    if not isinstance(where, list | tuple | np.ndarray):
        raise fault("A place", "must be a node, a set or coordinates (x, y, z)", where)
    node, distance = nearest_of(*model.located, where, metres)
    return Place(name or node, (node,), _dofs(model, {node: name or node}), distance)


def _dofs(model: Model, names: Mapping[str, str]) -> dict[str, int]:
    """The row of each degree of freedom of nodes, under the name that is given to the node."""
    return {f"{name}.{axis}": model.rows[f"{node}.{axis}"] for node, name in names.items() for axis in model.directions[node]}


def nearest_of(names: Sequence[str], points: Array, point: ArrayLike, metres: float = 1.0) -> tuple[str, float]:
    """The node, of those with coordinates `points` (nodes, 3) [m], nearest to `point` (in units of `metres`) and its distance, m;
    refused where no node is near.

    Near means: not farther than that node's own nearest neighbour.
    """
    coordinates = vector("Coordinates", point, 3)
    if not names:
        remedy = "Name nodes, or give a file of names."
        raise fault("Coordinates", "must go with a model that has coordinates", coordinates.tolist(), remedy)
    distances = np.linalg.norm(points - metres * coordinates, axis=1)
    index = int(distances.argmin())
    # A mesh has its own measure of what is near: beyond the next node, another one or none at all was meant.
    around = np.linalg.norm(points - points[index], axis=1)
    spacing = float(np.min(around[around > 0.0], initial=np.inf))
    if distances[index] > spacing:
        where = (points[index] / metres).tolist()
        raise fault(
            f"The node nearest to {coordinates.tolist()}",
            f"must lie within {spacing * 1e3:.3g} mm, its distance to its neighbour",
            f"{distances[index] * 1e3:.3g} mm away (node {names[index]} at {np.round(where, 9).tolist()})",
            "Check the coordinates and the units.",
        )
    return names[index], float(distances[index])


MOST_PLACES = 200
"""Places of stress of one model: results hold 13 numbers for each at every point of every curve."""


@dataclass(frozen=True)
class StrainGauge:
    """A place of stress with a strain gauge.

    at: a node, or coordinates (x, y, z). direction (3,): the direction in which the gauge measures, in the axes of the model; a
    vector of any length.
    """

    at: Where
    direction: Sequence[float]


@dataclass(frozen=True, eq=False)
class StressRows:
    """σ = rows u at named nodes: rows (6 places, n) [Pa/m], sparse, all components of one place after another; u of the model.
    nodes: of the model, by the name of the place; gauges: as of a `StressRecovery`; notes: on what was found."""

    nodes: Mapping[str, str]
    rows: sparse.csr_array
    gauges: Mapping[str, Array]
    notes: tuple[str, ...] = ()

    @property
    def bytes(self) -> bytes:
        """Identifies the rows."""
        return b"".join(part.tobytes() for part in (self.rows.data, self.rows.indices, self.rows.indptr))

    def recovery(
        self, rows: Array, dofs: tuple[str, ...], diameters: HeldDiameters | None = None, rotation: Array | None = None
    ) -> StressRecovery:
        """The recovery from reduced coordinates `dofs`: rows (6 places, m), of a sector for each of its nodal diameters;
        rotation (6 places,): stress of the rotation, Pa."""
        places = (len(self.nodes), len(COMPONENTS), len(dofs))
        if diameters is None:
            return StressRecovery(tuple(self.nodes), rows.reshape(places), dofs, gauges=self.gauges)
        waves = rows.reshape(-1, *places)
        mean = None if rotation is None else rotation.reshape(-1, len(COMPONENTS))
        return StressRecovery(tuple(self.nodes), waves[0].real, dofs, waves, diameters, self.gauges, mean)


def stress_rows_of(model: Model, asked: Mapping[str, Where | StrainGauge], metres: float = 1.0) -> StressRows:
    """The stress at places {name: node, set or coordinates (x, y, z) in units of `metres`}, averaged over the elements of a node,
    and the strain at those that are a `StrainGauge`.

    The nodes of a set are NAME/NODE. Fixed nodes and those in the middle of an edge are places too.
    """
    if model.solids is None or not model.solids.nodes:
        raise fault(
            "A model with places of stress",
            f"must come with the elements of its deck (CalculiX, Abaqus: {', '.join(KINDS)})",
            "one without",
            "Put the .inp beside the matrices, or name it in `names`.",
        )
    gauges = {name: where for name, where in asked.items() if isinstance(where, StrainGauge)}
    places = {name: where.at if isinstance(where, StrainGauge) else where for name, where in asked.items()}
    nodes = _nodes(model, places, metres)
    for name in gauges:
        if name not in nodes:
            raise fault(f"stress, {name}: a strain gauge", "must be at one node", f"the set {places[name]!r}")
    number = {node: k for k, node in enumerate(dict.fromkeys(nodes.values()))}
    shares, around, materials = np.zeros(len(number)), set[str](), dict[str, Material]()
    parts: list[tuple[int, Array, Array]] = []
    for kind, own, material in model.solids.around(number.keys()):
        stress = nodal_stress(kind, _points(model, kind, own), material)
        columns = np.array([[model.rows.get(f"{node}.{axis}", -1) for axis in "xyz"] for node in own]).ravel()
        around.update(own)
        for node, values in zip(own, stress, strict=True):
            if node in number:
                shares[number[node]] += 1.0
                if materials.setdefault(node, material) != material and any(nodes[name] == node for name in gauges):
                    raise fault("A strain gauge", "must be where all elements have one material", f"node {node}")
                parts.append((number[node], columns, values.reshape(len(COMPONENTS), -1)))
    lonely = next((node for node, k in number.items() if not shares[k]), None)
    if lonely is not None:
        raise fault("A place of stress", "must be a node of a solid element", f"node {lonely}")
    mean: Any = sparse.lil_array((6 * len(number), model.size + 1))  # fixed directions, −1, are the last column, left out below
    for k, columns, values in parts:
        mean[6 * k : 6 * k + 6, columns] += values / shares[k]
    # A node may be that of several places: each gets its rows.
    order = np.concatenate([6 * number[node] + np.arange(6) for node in nodes.values()])
    strains = {}
    for name, gauge in gauges.items():
        try:
            strains[name] = strain_along(gauge.direction, materials[nodes[name]])
        except InputError as error:
            raise InputError(f"stress, {name}: {error}") from None
    listed = ", ".join(f"{name} (node {node})" for name, node in list(nodes.items())[:6])
    note = f"Stress at {listed}{f', ... ({len(nodes)})' if len(nodes) > 6 else ''}"
    held = sum(node not in model.directions for node in around)
    note += f"; {counted(held, 'node')} of the elements there have no rows and count as fixed" if held else ""
    return StressRows(nodes, sparse.csr_array(mean)[order][:, :-1], strains, (note,))


def _points(model: Model, kind: str, nodes: tuple[str, ...]) -> Array:
    """Coordinates of the nodes of an element, (nodes, 3), m."""
    if kind in KINDS and len(nodes) != KINDS[kind]:
        raise fault(f"A {kind} at a place of stress", f"must have {KINDS[kind]} nodes", len(nodes))
    missing = [node for node in nodes if node not in model.nodes]
    if missing:
        raise fault("The nodes of an element at a place of stress", "must have coordinates", f"node {missing[0]} without")
    return np.array([model.nodes[node] for node in nodes])


def _nodes(model: Model, places: Mapping[str, Where], metres: float) -> dict[str, str]:
    """The node of each place, by its name; those of a set are NAME/NODE."""
    nodes: dict[str, str] = {}
    for name, where in places.items():
        try:
            if not isinstance(where, str | Integral):
                points = np.array(list(model.nodes.values()))
                nodes[name] = nearest_of(tuple(model.nodes), points, where, metres)[0]
            elif str(where) in model.sets:
                nodes |= {f"{name}/{node}": node for node in model.sets[str(where)]}
            elif str(where) in model.nodes:
                nodes[name] = str(where)
            else:
                known = nearest(str(where), [*model.sets, *model.nodes])
                raise InputError(f"Node or set {str(where)!r} does not exist. {known}")
        except InputError as error:
            raise InputError(f"stress, {name}: {error}") from None
    if not 1 <= len(nodes) <= MOST_PLACES:
        raise fault("The number of places of stress", f"must be from 1 to {MOST_PLACES}", len(nodes), "Name fewer nodes.")
    return nodes


INCOMPATIBLE = "C3D8I"
"""The element of CalculiX whose three incompatible modes are nodes of their own in its matrices, without a place."""
UNRESISTED = 1e-9
"""Resistance of a row to a translation along the axis, relative to the sum of the sizes of what acts on it, that is rounding."""
SAME_SPEED = 0.01
"""Relative difference up to which two speeds are one."""
UNEXPLAINED = 0.05
"""Share of the resistance to a translation across the axis that may be something else than spin softening."""


def spin_softening(model: Model, axis: RotationAxis) -> float:
    """Ω in rad/s of the spin softening −Ω² M (1 − d dᵀ) in K, d the axis of rotation; 0 where K has none.

    A rigid translation meets neither elastic nor stress stiffness, at nodes that no fixed node or spring holds: those that do
    not resist a translation along d. There K r = −Ω² M r for r across d.
    """
    d = np.array(axis.direction)
    r = _translation(model, d)
    resisted, size = np.asarray(model.K @ r), np.asarray(abs(model.K) @ np.abs(r))
    first = np.cross(d, np.eye(3)[np.argmin(np.abs(d))])
    across = [first / np.linalg.norm(first), np.cross(d, first / np.linalg.norm(first))]
    _, node = np.unique([dof.rpartition(".")[0] for dof in model.dofs], return_inverse=True)
    held = np.bincount(node, np.abs(resisted) > UNRESISTED * size) > 0.0
    free = ~held[node]  # of a node with some held rows, others may be free of K r by the symmetry of the mesh alone
    force, inertia = (
        np.concatenate([(matrix @ _translation(model, direction))[free] for direction in across]) for matrix in (model.K, model.M)
    )
    moved = float(inertia @ inertia)
    square = -float(force @ inertia) / moved if moved else 0.0
    explained = np.linalg.norm(force + square * inertia) <= UNEXPLAINED * np.linalg.norm(force)
    return float(np.sqrt(square)) if square > 0.0 and explained else 0.0


def _translation(model: Model, direction: Array) -> Array:
    """The rigid translation along a vector, (n,); rows without a place beside others that have one move relative to these."""
    placed = model.nodes or model.directions
    named = (dof.rpartition(".") for dof in model.dofs)
    return np.array([direction["xyz".index(axis)] if axis in "xyz" and node in placed else 0.0 for node, _, axis in named])


def prestress_note(model: Model, axis: RotationAxis, speed: float | None) -> str:
    """What K holds of the rotation, and whether that fits the speed in rev/min; "" where none is given or found."""
    softened = 60.0 / (2.0 * np.pi) * spin_softening(model, axis)
    if speed is not None and softened and abs(softened - speed) > SAME_SPEED * max(softened, speed):
        raise fault(
            "The speed of a model",
            f"must be that whose spin softening its K contains, {softened:.6g} rev/min",
            speed,
            f"Write {softened:.6g}, or take the matrices of another step.",
        )
    if softened:
        return f"K contains the spin softening of {softened:.6g} rev/min, and is assumed to contain its stress stiffening too"
    if speed:
        return (
            f"K is assumed to be that at {speed:g} rev/min, but contains no spin softening: was it written after a step with "
            "CENTRIF? Programs that leave out spin softening give frequencies that are too high"
        )
    return "K contains no spin softening: it is that of the disk at rest" if speed is not None else ""


def rotation_stress(sector: Sector, rows: sparse.csr_array, axis: RotationAxis, speed: float) -> Array:
    """Stress due to rotation (rows,) from `rows` of the motion of a sector, Pa: K u = Ω² M r at nodal diameter 0.

    r: the distance of each node from the axis, as a vector; speed: the speed of K, in rev/min. If K contains the spin
    softening −Ω² M, the load acts at the deformed position.
    """
    solid = sector.solid
    away = (solid.points - np.array(axis.point)) @ axis.across
    held = solid.numbers < 0
    r = np.zeros(solid.size)
    r[solid.numbers[~held]] = away[~held]
    T = sector.constraint(0)
    K, load = (T.conj().T @ solid.K @ T).tocsc(), _per_distance(speed) * (T.conj().T @ (solid.M @ r))
    motion = T @ _solved(sparse.csc_array(hermitian(K)), load, "the disk must be held along and about its axis")
    return np.asarray((rows @ motion).real)


def rotation_stress_of_body(model: Model, rows: sparse.csr_array, axis: RotationAxis, speed: float) -> Array:
    """The same of a whole model that its supports hold, from `rows` of its motion: K u = Ω² M r."""
    load = _per_distance(speed) * centrifugal_loads(model).about(axis)[0]
    return np.asarray(rows @ _solved(sparse.csc_array(model.K), load, "the model must be held by its supports"))


def centrifugal_loads(model: Model) -> CentrifugalLoads:
    """The centrifugal loads of a model. Nodes without coordinates are the three incompatible modes of each C3D8I, or refused."""
    refuse_own_axes(model)
    inner = [node for node in model.directions if node not in model.nodes]
    elements = () if model.solids is None else model.solids.kinds.values()
    known = len(inner) == 3 * sum(kind == INCOMPATIBLE for kind in elements)
    return CentrifugalLoads.of(model.M, model.dofs, model.nodes, inner if known else ())


def refuse_own_axes(model: Model) -> None:
    """Rows along axes of their own have another part of the centrifugal load."""
    if any(OWN_AXES in note for note in model.notes):
        raise fault(
            "For loads and stress due to rotation all nodes",
            "must have rows along x, y and z of the model",
            "axes of their own",
            "Write the matrices without the local axes of nodes (*TRANSFORM, CD, NROTAT), or leave out the speed.",
        )


def _per_distance(speed: float) -> float:
    """Ω² [1/s²] of a speed in rev/min."""
    return (2.0 * np.pi * speed / 60.0) ** 2


def _solved(K: sparse.csc_array, load: Array, rule: str) -> Array:
    """K⁻¹ load."""
    try:
        factor = Factor(K)
    except Singular:
        factor = None
    if factor is None or factor.weak:
        raise InputError(
            f"For the stress due to rotation {rule}, but it is free to move there. Fix some of its nodes, or leave out the speed."
        )
    return factor.solve(load)


def rotation_note(stress: StressRows, mean: Array, speed: float) -> str:
    """What is in the mean stress, by place."""
    sizes = von_mises(mean.reshape(-1, 6)) / 1e6
    listed = ", ".join(f"{size:.4g} MPa at {name}" for name, size in list(zip(stress.nodes, sizes, strict=True))[:6])
    more = f", ... ({len(sizes)})" if len(sizes) > 6 else ""
    return f"The mean stress contains the stress due to rotation at {speed:g} rev/min, von Mises {listed}{more}"
