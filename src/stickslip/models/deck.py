"""Input decks of Abaqus and CalculiX: node coordinates, node sets and the corners of elements."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from stickslip.checks import fault
from stickslip.models.cells import PLATES, SOLIDS, FoundCells
from stickslip.models.content import located
from stickslip.models.limits import within_memory
from stickslip.structure.matrices import Point
from stickslip.structure.mesh_surface import Cells

ELEMENT = re.compile(r"(C3D|SC|S|STRI|M3D)(\d{1,2})(?!V)[A-Z]*\d?[A-Z]*")
"""Names of elements with faces: family and number of nodes, which those with V have a choice of."""
SHAPES = {
    **{("C3D", nodes): kind for kind, counts in SOLIDS.items() for nodes in counts},
    **{(family, nodes): kind for family in ("S", "STRI", "M3D") for kind, counts in PLATES.items() for nodes in counts},
    ("SC", 6): "wedge",
    ("SC", 8): "hexahedron",
}
MOST_GENERATED = 10_000_000
"""Members of a generated set of nodes: more is a slip of the deck."""


@dataclass
class Deck:
    """nodes: coordinates by node; sets: nodes by the name of a set, in capitals; cells: corner nodes of elements by kind; notes:
    what was not read."""

    nodes: dict[str, Point] = field(default_factory=dict)
    sets: dict[str, tuple[str, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    cells: Cells = field(default_factory=dict)


def read_deck(path: Path) -> Deck:
    """Nodes and sets of nodes of a deck; others are passed over; a note says that includes are not followed."""
    within_memory(path.name, 10 * path.stat().st_size)
    deck = Deck()
    members: dict[str, dict[str, None]] = {}
    nodes: list[tuple[str, Point]] = []
    found = FoundCells()
    with path.open(encoding="utf-8", errors="replace") as file:
        for keyword, options, data in cards(file):
            if keyword == "NODE":
                numbered = [_node(line) for line in data]
                nodes += numbered
                if "NSET" in options:
                    _add(members, options["NSET"], [node for node, _ in numbered])
            elif keyword == "ELEMENT":
                _elements(options.get("TYPE", ""), data, found)
            elif keyword == "TRANSFORM":
                found.turned = True
            elif keyword == "INCLUDE":
                deck.notes = (
                    f"{path.name} includes other files, which are not read: nodes, sets and elements there are missing.",
                )
            elif keyword == "NSET" and "NSET" in options:
                _add(members, options["NSET"], _members(data, "GENERATE" in options, members))
    if not nodes and not deck.notes:
        deck.notes = (f"{path.name} holds no nodes.",)
    deck.nodes, deck.cells, deck.notes = located(nodes), found.cells, (*deck.notes, *found.notes(path.name))
    deck.sets = {name: tuple(nodes) for name, nodes in members.items()}
    return deck


def cards(lines: Iterator[str] | list[str]) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Each keyword with its options and its data lines; names in capitals, comments left out."""
    keyword = ""
    options: dict[str, str] = {}
    data: list[str] = []
    for raw in lines:
        line = raw.strip()
        if line.startswith("**") or not line:
            continue
        if line.startswith("*"):
            if keyword:
                yield keyword, options, data
            words = [word.strip() for word in line[1:].upper().split(",")]
            pairs = (word.partition("=") for word in words[1:])
            keyword, data = words[0], []
            options = {name.strip(): value.strip() for name, _, value in pairs}
        elif keyword:
            data.append(line)
    if keyword:
        yield keyword, options, data


def fields(line: str) -> list[str]:
    """The entries of a data line."""
    return [word.strip() for word in line.rstrip(",").split(",")]


def _node(line: str) -> tuple[str, Point]:
    words = [*fields(line), "", "", ""]
    try:
        x, y, z = (float(word.upper().replace("D", "E") or 0.0) for word in words[1:4])
        return str(int(words[0])), (x, y, z)
    except ValueError:
        raise fault("A line of *NODE", "must hold a number and coordinates", line[:60]) from None


def _elements(kind: str, data: list[str], found: FoundCells) -> None:
    """Elements over one or more lines each: number, nodes. What has no faces, such as springs and beams, is passed over."""
    match = ELEMENT.fullmatch(kind)
    shape = SHAPES.get((match[1], int(match[2]))) if match else None
    if match is None or shape is None:
        return
    words: list[str] = []
    for line in data:
        words += [word for word in fields(line) if word]
        if len(words) > int(match[2]):
            found.add(shape, words[1:])
            words = []
    found.lost += bool(words)


def _add(members: dict[str, dict[str, None]], name: str, nodes: list[str]) -> None:
    members.setdefault(name, {}).update(dict.fromkeys(nodes))


def _members(data: list[str], generate: bool, known: dict[str, dict[str, None]]) -> list[str]:
    """Nodes of a set: numbers, other sets, or first, last, step."""
    found: list[str] = []
    for line in data:
        words = [word for word in fields(line) if word]
        if generate:
            found += _generated(words, line)
        else:
            for word in words:
                found += [str(int(word))] if word.isdecimal() else known.get(word.upper(), {})
    return found


def _generated(words: list[str], line: str) -> list[str]:
    try:
        first, last, step = (int(word) for word in (*words, "1")[:3])
        span = range(first, last + 1, step)
    except ValueError:
        raise fault("A line of *NSET, GENERATE", "must hold first, last and step", line[:60]) from None
    if len(span) > MOST_GENERATED:
        raise fault("A set of nodes", f"must have at most {MOST_GENERATED} members", len(span))
    return [str(node) for node in span]
