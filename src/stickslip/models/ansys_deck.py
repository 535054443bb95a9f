"""Archives of Ansys (.cdb of CDWRITE): coordinates of nodes (NBLOCK), components of nodes (CMBLOCK) and the corners of elements
(EBLOCK), in fixed columns.

NBLOCK is followed by a line with its columns, "(3i9,6e21.13e3)": whole numbers, the first of which is the node, then x, y, z and
angles; zeros at the end of a line are left out. CMBLOCK, NAME, NODE, COUNT holds numbers; a negative one means "up to". A line of
EBLOCK, , SOLID has 11 numbers, the second the type and the ninth the number of nodes, then up to 8 nodes; the others follow.
(Mechanical APDL Programmer's Reference: Mapped files, coded database.)
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path

from stickslip.checks import fault
from stickslip.models.cells import FoundCells
from stickslip.models.content import located
from stickslip.models.deck import MOST_GENERATED, Deck
from stickslip.models.limits import within_memory
from stickslip.structure.matrices import Point

ELEMENTS = {
    **dict.fromkeys(("45", "95", "185", "186"), "hexahedron"),
    **dict.fromkeys(("92", "187", "285"), "tetrahedron"),
    **dict.fromkeys(("63", "93", "181", "281"), "quadrilateral"),
}
"""Kinds of cells by the number of an element type, SOLID186 say; prisms, pyramids and triangles repeat nodes."""
LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
FIRST_NODE = 11
"""Numbers of a line of EBLOCK before its nodes."""
COLUMNS = re.compile(r"\(((?:\d+i\d+,?)+)(?:\d+e(\d+)\.\d+(?:e\d+)?)?\)", re.IGNORECASE)


def read_archive(path: Path) -> Deck:
    """Nodes and node components of an archive; all else is passed over."""
    within_memory(path.name, 10 * path.stat().st_size)
    nodes: list[tuple[str, Point]] = []
    sets: dict[str, tuple[str, ...]] = {}
    types: dict[str, str] = {}
    found = FoundCells()
    with path.open(encoding="ascii", errors="replace") as file:
        for line in file:
            words = [word.strip().upper() for word in line.partition("!")[0].split(",")]
            if words[0] == "NBLOCK":
                nodes += _nodes(file, found)
            elif words[0] == "ET" and len(words) > 2:
                types[words[1]] = ELEMENTS.get(words[2].lstrip(LETTERS), "")
            elif words[0] == "EBLOCK" and words[2:3] == ["SOLID"]:
                _elements(file, types, found)
            elif words[0] == "CMBLOCK" and len(words) > 3 and words[2].startswith("NODE"):
                sets[words[1]] = tuple(map(str, _members(file, int(words[3]))))
    return Deck(located(nodes), sets, found.notes(path.name), found.cells)


def _columns(line: str) -> tuple[list[int], int]:
    """The widths of the whole numbers that a line begins with, and that of the numbers after them."""
    match = COLUMNS.fullmatch(line.strip())
    groups = [(int(count), int(width)) for count, width in re.findall(r"(\d+)i(\d+)", match[1].lower())] if match else []
    if not match or not all(0 < count < 100 and 0 < width < 100 for count, width in groups):
        raise fault("The columns of a block", "must be stated as (3i9,6e21.13e3)", line.strip()[:60])
    return [width for count, width in groups for _ in range(count)], int(match[2] or 0)


def _nodes(lines: Iterator[str], found: FoundCells) -> Iterator[tuple[str, Point]]:
    """Nodes up to the end of a block: a line that begins with "N," or -1."""
    widths, wide = _columns(next(lines, ""))
    if not wide:
        raise fault("The columns of NBLOCK", "must be stated as (3i9,6e21.13e3)", "without those of coordinates")
    for line in lines:
        text = line.rstrip("\n")
        if text.startswith("N,") or text.strip() == "-1":
            return
        start = sum(widths)
        # Angles turn the axes along which the node moves.
        found.turned |= bool(text[start + 3 * wide :].strip(" 0.E+-"))
        x, y, z = (float(text[start + k * wide : start + (k + 1) * wide].strip() or 0.0) for k in range(3))
        yield str(int(text[: widths[0]])), (x, y, z)


def _elements(lines: Iterator[str], types: Mapping[str, str], found: FoundCells) -> None:
    """Elements up to the end of a block: -1. What has no faces is passed over."""
    widths, _ = _columns(next(lines, ""))
    for line in lines:
        numbers = _cut(line, len(widths), widths[0])
        if numbers[:1] == ["-1"] or not numbers:
            return
        count = int(numbers[8]) if len(numbers) > FIRST_NODE else 0
        nodes = numbers[FIRST_NODE:]
        while len(nodes) < count:
            more = _cut(next(lines, ""), len(widths), widths[0])
            if not more:
                break
            nodes += more
        if types.get(numbers[1] if len(numbers) > 1 else ""):
            found.add(types[numbers[1]], nodes)


def _members(lines: Iterator[str], count: int) -> Iterator[int]:
    """The nodes of a component of `count` numbers."""
    widths, _ = _columns(next(lines, ""))
    each, width = len(widths), widths[0]
    total = last = left = 0
    for text in chain.from_iterable(_cut(line, each, width) for line in _first(lines, -(-count // each))):
        number, left = int(text), left + 1
        span = range(last + 1, -number + 1) if number < 0 else range(number, number + 1)
        total += len(span)
        if total > MOST_GENERATED:
            raise fault("A component of nodes", f"must have at most {MOST_GENERATED} members", total)
        yield from span
        last = abs(number)
    if left < count:
        raise fault("A component of nodes", f"must hold its {count} numbers", left, "The file is truncated.")


def _first(lines: Iterator[str], count: int) -> Iterator[str]:
    for _ in range(count):
        yield next(lines, "")


def _cut(line: str, count: int, width: int) -> list[str]:
    """Entries of fixed width that are not blank."""
    text = line.rstrip("\n")
    pieces = (text[k * width : (k + 1) * width].strip() for k in range(count))
    return [piece for piece in pieces if piece]
