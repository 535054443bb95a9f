"""Raw content of a model file, as every reader returns it: matrices, names, coordinates, sets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stickslip.model.readers.node_axes import NodeAxes
from stickslip.model.structure.matrices import Point
from stickslip.model.structure.mesh_surface import Cells
from stickslip.support.checks import Faults, counted, fault, nearest

if TYPE_CHECKING:
    from stickslip.model.readers.solids import Solids

SYNONYMS = {
    "M": ("M", "MAA", "MAAX", "MGG", "MXX", "MHH", "MASS"),
    "K": ("K", "KAA", "KAAX", "KGG", "KXX", "KHH", "STIFFNESS"),
    "C": ("C", "BAA", "BAAX", "BGG", "BXX", "BHH", "DAMPING", "VISCOUS"),
}
"""Names under which programs write mass, stiffness and damping; the first that a file has counts."""
NEEDED = ("M", "K")

DIRECTIONS = {1: "x", 2: "y", 3: "z", 4: "rx", 5: "ry", 6: "rz"}
"""Names of the directions that programs number."""


@dataclass(frozen=True, eq=False)
class Content:
    """Matrices by their names in the file (dense or sparse), and what the file says about their rows.

    dofs: the name NODE.DIRECTION of each row, or none; nodes: coordinates, in the file's unit of length; sets: nodes by the name
    of a set; cells: corner nodes of the elements by kind, where known; notes: what the reader left out or took for granted;
    solids: elements with their materials, where stress can be recovered; turned: nodes along whose own axes rows are.
    """

    format: str
    matrices: Mapping[str, Any]
    dofs: tuple[str, ...] = ()
    nodes: Mapping[str, Point] = field(default_factory=dict)
    sets: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    cells: Cells = field(default_factory=dict)
    solids: Solids | None = None
    turned: NodeAxes = field(default_factory=NodeAxes)


def chosen(content: Content, variables: Mapping[Any, str], file: str, needed: Sequence[str] = NEEDED) -> dict[str, Any]:
    """The matrices M, K and, if there is one, C; `variables` names them, {"K": "KELAST"}, where usual names do not do."""
    unknown = [key for key in variables if key not in SYNONYMS]
    if unknown:
        raise fault("variables", "must name M, K or C", unknown[0])
    for letter, name in variables.items():
        if not isinstance(name, str):
            raise fault(f"variables, {letter}", "must be a name", name)
    matrices: dict[str, Any] = {}
    faults = []
    for letter, usual in SYNONYMS.items():
        names = (variables[letter],) if letter in variables else usual
        present = next((name for name in names if name in content.matrices), None)
        if present is not None:
            matrices[letter] = content.matrices[present]
        elif letter in needed or letter in variables:
            faults.append(f"{file}: matrix {names[0]} must be in the file, but is missing. {nearest(names[0], content.matrices)}")
    if faults:
        raise Faults(faults)
    return matrices


def located(pairs: Iterable[tuple[str, Point]]) -> dict[str, Point]:
    """Coordinates by node; one that stands twice must stand in one place."""
    nodes: dict[str, Point] = {}
    for node, point in pairs:
        located_once(nodes, node, point)
    return nodes


def located_once(nodes: dict[str, Point], node: str, point: Point) -> bool:
    """Add the coordinates of a node; whether they were there already."""
    known = node in nodes
    if nodes.setdefault(node, point) != point:
        raise fault(f"The coordinates of node {node}", "must be given once", [nodes[node], point], "Delete the wrong ones.")
    return known


def given_twice(count: int, file: str) -> tuple[str, ...]:
    """A note on nodes that a deck defines again at the same place; none without such nodes."""
    what = counted(count, "node is", "nodes are")
    return (f"{what} defined more than once in {file}, each time at the same place.",) if count else ()


def dof(node: object, direction: int) -> str:
    """NODE.DIRECTION of a numbered direction: 1 to 3 along x, y, z, 4 to 6 about them, others q0, q7, ... (scalar, modal)."""
    return f"{node}.{DIRECTIONS.get(direction, f'q{direction}')}"
