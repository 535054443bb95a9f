"""Places to keep in a reduction: a node id, a node set, or the node nearest to given coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.readers.model import Model
from stickslip.support.checks import Array, Faults, InputError, fault, nearest, several, vector

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
