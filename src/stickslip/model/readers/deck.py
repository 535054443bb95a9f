"""What a deck says about nodes and elements, as the reader of each format returns it, and what becomes of its cards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from stickslip.model.readers.node_axes import NodeAxes
from stickslip.model.structure.matrices import Point
from stickslip.model.structure.mesh_surface import CORNERS, Cells
from stickslip.support.checks import fault, first_of

if TYPE_CHECKING:
    from stickslip.model.readers.solids import Solids

SOLIDS = {"tetrahedron": (4, 10), "pyramid": (5, 13), "wedge": (6, 15), "hexahedron": (8, 20)}
PLATES = {"triangle": (3, 6), "quadrilateral": (4, 8, 9)}
"""Kinds of cells by the number of nodes of their elements, linear and quadratic; corners come first."""

LONGEST = 18
"""Digits of a number of a node, which a machine's integer holds."""

MOST_GENERATED = 1_000_000
"""Members of a generated set of nodes: more is a slip of the deck."""
MOST_MADE = 2_000_000
"""Nodes that cards of a deck make of others, in all."""
SHOWN = 8
"""Cards that a note lists."""


@dataclass
class Deck:
    """nodes: coordinates by node; sets: nodes by the name of a set, in capitals; cells: corner nodes of elements by kind; notes:
    what was not read; turned: nodes with axes of their own, along which rows of matrices are;
    rows: the names of the rows of matrices, where the deck says them; solids: elements with materials, where
    stress can be recovered."""

    nodes: dict[str, Point] = field(default_factory=dict)
    sets: dict[str, tuple[str, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    cells: Cells = field(default_factory=dict)
    turned: NodeAxes = field(default_factory=NodeAxes)
    rows: tuple[str, ...] = ()
    solids: Solids | None = None


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


@dataclass(frozen=True)
class CardList:
    """The cards of a format by what a reader of nodes, sets and elements does with them.

    obeyed: they count; harmless: they say nothing about nodes, sets and elements, or only what the matrices hold already;
    refused: by card what to do instead, since nodes or sets would be wrong or missing; noted: by card what is missing without
    it, while all else is right.
    """

    obeyed: frozenset[str]
    harmless: frozenset[str]
    refused: Mapping[str, str]
    noted: Mapping[str, str]
    sign: str = ""

    @property
    def known(self) -> frozenset[str]:
        return self.obeyed | self.harmless | self.refused.keys() | self.noted.keys()


@dataclass
class CardsMet:
    """The cards of one deck that are not obeyed, for its notes."""

    cards: CardList
    missing: dict[str, str] = field(default_factory=dict)
    unknown: dict[str, str] = field(default_factory=dict)

    def obeys(self, name: str, place: str) -> bool:
        """Whether the reader obeys the card at `place`, "blade.inp, line 7"; refuses one that would make the rest wrong."""
        if name in self.cards.obeyed:
            return True
        shown = self.cards.sign + name
        if name in self.cards.refused:
            raise fault(place, "must hold cards that this reader obeys", shown, self.cards.refused[name])
        if name in self.cards.noted:
            self.missing.setdefault(shown, self.cards.noted[name])
        elif name not in self.cards.harmless:
            self.unknown.setdefault(shown, place)
        return False

    def notes(self, file: str) -> tuple[str, ...]:
        """One sentence for each card that is missing, one for all that are not known."""
        missing = tuple(f"{file}: {card} is not read; {what}." for card, what in self.missing.items())
        if not self.unknown:
            return missing
        listed = first_of([f"{card} ({place})" for card, place in self.unknown.items()], SHOWN)
        return *missing, f"{file}: this reader does not know {listed}. Their effect on nodes and sets, if any, is missing."
