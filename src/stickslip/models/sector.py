"""A sector of a bladed disk from another program, as a cyclic structure.

The model is one sector with both faces free: the ties of a cyclic analysis must not act in its matrices. Nodes of the two faces
are matched by their coordinates, one turned by 2π/N about the axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from stickslip.checks import Array, Index, InputError, between, fault
from stickslip.models.model import Model
from stickslip.models.places import Keep, places_of
from stickslip.models.read import Paths, read_model
from stickslip.models.reduction import Progress, kept_nodes, kept_sets, quiet
from stickslip.structure.cyclic import MOST_SECTORS, CyclicStructure
from stickslip.structure.cyclic_reduction import Sector, about, cyclic_craig_bampton, sector_of
from stickslip.structure.damping import Damping
from stickslip.structure.solid import Solid
from stickslip.units import UnitSystem, unit_system

MODES, SECTOR_MODES = 30, 60
"""Fixed-interface modes of each nodal diameter, and of the sector with both faces held, unless given."""


def read_sector(
    path: Paths,
    *,
    sectors: int,
    faces: tuple[str, str],
    keep: Keep,
    axis: str = "z",
    modes: int = MODES,
    sector_modes: int = SECTOR_MODES,
    units: str | UnitSystem = "SI",
    damping: Damping | None = None,
    names: str | Path | None = None,
    progress: Progress = quiet,
) -> CyclicStructure:
    """Read the finite-element model of one sector and return the disk of `sectors` equal sectors, reduced for every nodal
    diameter, in SI.

    faces: the two sets of nodes at which a sector meets its neighbours, in any order; their meshes must match. keep: the nodes
    to retain, as in `read_structure`, none of them on the faces. axis: axis of rotation, "x", "y" or "z", through the origin;
    the following sector comes counter-clockwise about it. modes: number of fixed-interface modes of each nodal diameter, in
    addition to the retained nodes; sector_modes: number of modes of the sector with both faces fixed, from which the former are
    computed (`cyclic_craig_bampton`).

    A pair of nodes on the faces is fixed if either node is fixed. Matrices with a constraint between the faces are refused: in
    CalculiX write them without *CYCLIC SYMMETRY MODEL, or with CYCMPC=INACTIVE.
    """
    system = unit_system(units)
    model = read_model(path, units=system, names=names)
    if model.C is not None:
        raise InputError("The model of a sector must not contain C. Use a damping rule, or pass the matrices to `with_damping`.")
    places = places_of(model, keep, system.metres)
    for place in places:
        progress(0.0, str(place))
    sector, rows = sector_of_model(model, sectors, faces, axis)
    kept = {name: int(rows[row]) for place in places for name, row in place.dofs.items()}
    held = sorted(name for name, row in kept.items() if row < 0)
    if held:
        raise fault("Kept degrees of freedom", "must not be fixed by their partner on the other face", held)
    structure = cyclic_craig_bampton(sector, kept, modes, sector_modes).structure
    whole = {name: row for place in places for name, row in place.dofs.items()}
    nodes, sets = kept_nodes(model, whole), kept_sets(model, places)
    return replace(structure, nodes=nodes, sets=sets, mesh_points=model.located[1], damping=damping)


def sector_of_model(model: Model, sectors: int, faces: tuple[str, str], axis: str = "z") -> tuple[Sector, Index]:
    """The sector of a model, and of each row of the model the row in it, −1 where a partner on the other face holds it."""
    count, order = between("sectors", sectors, 2, MOST_SECTORS), about(axis)
    names, points = tuple(model.nodes), np.array([model.nodes[node] for node in model.nodes]).reshape(-1, 3)
    numbers = np.array([[model.rows.get(f"{node}.{direction}", -1) for direction in "xyz"] for node in names]).reshape(-1, 3)
    sides = [_side(model, names, face) for face in faces]
    body = Solid(model.M, model.K, points[:, order], numbers[:, order])
    pairs = _matched(body, count, sides, faces)
    free = numbers[np.concatenate([pairs.left, pairs.right])] >= 0
    if np.any(free.any(axis=1) != free.all(axis=1)):
        raise fault(
            "Nodes on the faces of a sector",
            "must be free or fixed in all three directions",
            "some are fixed in one or two",
            "Fix these nodes in all three directions, or support other nodes instead.",
        )
    left, right = np.split(free[:, 0], 2)
    if not np.any(left & right):
        raise InputError(
            f"The sector must be written with both faces free, but no pair of nodes of {faces[0]} and {faces[1]} has rows on "
            "both: the matrices contain a cyclic constraint, or both faces are fixed. In CalculiX omit *CYCLIC SYMMETRY MODEL, "
            "or write CYCMPC=INACTIVE."
        )
    held = np.concatenate([numbers[pairs.left[left & ~right]], numbers[pairs.right[right & ~left]]]).ravel()
    kept = np.setdiff1d(np.arange(model.size), held)
    rows = np.full(model.size + 1, -1, dtype=np.int64)
    rows[kept] = np.arange(kept.size)
    reduced = Solid(model.M[kept][:, kept], model.K[kept][:, kept], body.points, rows[numbers[:, order]])
    return replace(pairs, solid=reduced), rows[:-1]


def _side(model: Model, names: Sequence[str], face: str) -> Array:
    """Which nodes belong to a face."""
    if face not in model.sets:
        raise fault("A face of the sector", "must be a set of nodes of the model", face, f"Its sets: {', '.join(model.sets)}.")
    members = set(model.sets[face])
    return np.array([node in members for node in names])


def _matched(body: Solid, sectors: int, sides: Sequence[Array], faces: tuple[str, str]) -> Sector:
    """The pairs of nodes, whichever face comes first."""
    faults = []
    for left, right in (sides, sides[::-1]):
        try:
            return sector_of(body, sectors, lambda points, side=left: side, lambda points, side=right: side)  # type: ignore[misc]
        except InputError as error:
            faults.append(str(error))
    raise InputError(f"The faces {faces[0]} and {faces[1]} of the sector: {min(faults, key=len)}")
