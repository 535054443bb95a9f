"""Elements of decks as the corner nodes of cells, by kind; deformed shapes are drawn with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stickslip.model.structure.mesh_surface import CORNERS, Cells

SOLIDS = {"tetrahedron": (4, 10), "pyramid": (5, 13), "wedge": (6, 15), "hexahedron": (8, 20)}
PLATES = {"triangle": (3, 6), "quadrilateral": (4, 8, 9)}
"""Kinds of cells by the number of nodes of their elements, linear and quadratic; corners come first."""

LONGEST = 18
"""Digits of a number of a node, which a machine's integer holds."""


@dataclass
class FoundCells:
    """Cells as they are read; lost: elements without numbers of all their corners."""

    corners: dict[str, list[tuple[int, ...]]] = field(default_factory=dict)
    lost: int = 0

    def add(self, kind: str, nodes: Sequence[str]) -> None:
        """One element by its nodes, of which the corners are kept."""
        corners = nodes[: CORNERS[kind]]
        if len(corners) == CORNERS[kind] and all(word.isdecimal() and len(word) < LONGEST for word in corners):
            self.corners.setdefault(kind, []).append(tuple(map(int, corners)))
        else:
            self.lost += 1

    @property
    def cells(self) -> Cells:
        """The cells by kind."""
        return {kind: np.array(rows, dtype=np.int64) for kind, rows in self.corners.items()}

    def notes(self, file: str) -> tuple[str, ...]:
        """What was left out."""
        return (f"{self.lost} elements of {file} are left out: they do not name all their corners.",) if self.lost else ()
