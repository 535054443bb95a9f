"""Archives of Ansys (.cdb of CDWRITE): coordinates of nodes (NBLOCK), components of nodes (CMBLOCK) and the corners of elements
(EBLOCK), in fixed columns.

NBLOCK is followed by a line with its columns, "(3i9,6e21.13e3)": whole numbers, the first of which is the node, then x, y, z and
angles; zeros at the end of a line are left out. Archives without blocks have N,R5.3,LOC with coordinates and N,R5.3,ANG with
angles of a node. CMBLOCK, NAME, NODE, COUNT holds numbers; a negative one means "up to". A line of
EBLOCK, , SOLID has 11 numbers, the second the type and the ninth the number of nodes, then up to 8 nodes; the others follow.
(Mechanical APDL Programmer's Reference: Mapped files, coded database.)
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from stickslip.model.readers.deck import MOST_GENERATED, CardList, CardsMet, Deck, FoundCells, NodeAxes
from stickslip.model.readers.model import given_twice, located_once
from stickslip.model.readers.numbers import coordinate, integer, refuse_utf_16, within_memory
from stickslip.model.structure.matrices import Point
from stickslip.support.checks import Array, fault

ELEMENTS = {
    **dict.fromkeys(("45", "95", "185", "186"), "hexahedron"),
    **dict.fromkeys(("92", "187", "285"), "tetrahedron"),
    **dict.fromkeys(("63", "93", "181", "281"), "quadrilateral"),
}
"""Kinds of cells by the number of an element type, SOLID186 say; prisms, pyramids and triangles repeat nodes."""
LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
FIRST_NODE = 11
"""Numbers of a line of EBLOCK before its nodes."""
SIGNIFICANT = 4
"""Characters that make a command."""
SYSTEMS = ("LOCA", "CS", "CLOC", "CSKP", "CSWP")
"""Commands that make a coordinate system and activate it."""


ARCHIVE_COMMANDS = CardList.of("ansys", SIGNIFICANT)
TEXT = re.compile(r"\s*(/COM|/TIT|/STI|C\*\*\*|\*ABB|/SYP)", re.IGNORECASE)
"""How a line begins whose text is not commands."""
COLUMNS = re.compile(r"\(((?:\d+i\d+,?)+)(?:\d+[ea](\d+)(?:\.\d+)?(?:e\d+)?)?\)", re.IGNORECASE)


def read_archive(path: Path) -> Deck:
    """Nodes, node components and elements of an archive."""
    within_memory(path.name, 10 * path.stat().st_size)
    refuse_utf_16(path)
    archive, met = _Archive(), CardsMet(ARCHIVE_COMMANDS)
    with path.open(encoding="ascii", errors="replace") as file:
        lines = enumerate(file, start=1)
        for number, line in lines:
            for text in _several(line):
                words = [word.strip().upper() for word in text.split(",")]
                command = words[0].partition(" ")[0][:SIGNIFICANT]
                if re.match(r"[A-Z/*][^=]*$", words[0]) and met.obeys(command, f"{path.name}, line {number}"):
                    archive.take(command, words, (more for _, more in lines))
    deck = archive.deck(path.name)
    deck.notes = (*deck.notes, *met.notes(path.name))
    return deck


def _several(line: str) -> list[str]:
    """The commands of a line without its comment, between which $ stands; in titles and comments it is a letter.

    (Mechanical APDL Command Reference: Condensed Data Input.)
    """
    text = line.partition("!")[0]
    return [text] if TEXT.match(text) else text.split("$")


class _Archive:
    """What an archive says, command by command. types: kind of cell by element type; active: whether a system other than the
    global Cartesian one is active, in which the command N would place nodes."""

    def __init__(self) -> None:
        self.nodes: dict[str, Point] = {}
        self.sets: dict[str, tuple[str, ...]] = {}
        self.types: dict[str, str] = {}
        self.cells = FoundCells()
        self.turned: dict[str, Array] = {}
        self.active = False
        self.repeated = 0

    def take(self, command: str, words: list[str], lines: Iterator[str]) -> None:
        """A command with its arguments; `lines` are those after it."""
        if command == "NBLO":
            listed = list(_nodes(lines))
            _refuse_other_count("The nodes of NBLOCK", words, len(listed))
            for node, point, angles in listed:
                self._add(node, point, angles)
        elif command == "N":
            self._node(words)
        elif command == "ET" and len(words) > 2:
            self.types[words[1]] = ELEMENTS.get(words[2].lstrip(LETTERS), "")
        elif command == "ETBL":
            self.types |= {number: ELEMENTS.get(kind, "") for number, kind in _types(lines)}
        elif command == "EBLO" and words[2:3] == ["SOLID"]:
            _refuse_other_count("The elements of EBLOCK", words, _elements(lines, self.types, self.cells))
        elif command == "CMBL" and len(words) > 3 and words[2].startswith("NODE"):
            self.sets[words[1]] = tuple(map(str, _members(lines, integer(words[3]))))
        elif command in ("CSYS", *SYSTEMS):
            self.active = command != "CSYS" or words[1:2] not in ([], ["0"], [""])

    def _node(self, words: list[str]) -> None:
        """N, R5.3, LOC or ANG, node, three numbers, of an archive without blocks; or N, node, x, y, z, three angles,
        of which a node left out is the next one."""
        if words[1:2] and words[1].startswith("R5"):
            kind, node, numbers = words[2], words[3], [coordinate(word) for word in (*words[4:7], *[""] * 3)[:3]]
            if integer(node) > 0 and kind == "LOC":
                self._add(node, numbers, ())
            elif integer(node) > 0 and any(numbers):
                self.turned[node] = nodal_axes(numbers)
            return
        if self.active:
            raise fault("A command N", "must follow CSYS, 0", ", ".join(words[:5]), "Write the archive with CDWRITE.")
        numbers = [coordinate(word) for word in (*words[2:8], *[""] * 6)[:6]]
        node = words[1] if words[1:2] not in ([], [""]) else str(1 + max(map(int, self.nodes), default=0))
        self._add(node, numbers[:3], numbers[3:])

    def _add(self, node: str, point: Sequence[float], angles: Sequence[float]) -> None:
        x, y, z = point
        name = str(integer(node))
        self.repeated += located_once(self.nodes, name, (x, y, z))
        if any(angles):
            self.turned[name] = nodal_axes(angles)

    def deck(self, file: str) -> Deck:
        turned = NodeAxes(file, "angles of NBLOCK or N", self.turned)
        notes = (*given_twice(self.repeated, file), *self.cells.notes(file))
        return Deck(self.nodes, self.sets, notes, self.cells.cells, turned)


def nodal_axes(angles: Sequence[float]) -> Array:
    """The axes (columns) of a node with the angles THXY, THYZ, THZX in degrees: turned about its z, then about its new x, then
    about its new y. (Mechanical APDL Command Reference: N.)"""
    (xy, yz, zx), (cxy, cyz, czx) = np.sin(np.radians(angles)), np.cos(np.radians(angles))
    about_z = np.array([[cxy, -xy, 0.0], [xy, cxy, 0.0], [0.0, 0.0, 1.0]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cyz, -yz], [0.0, yz, cyz]])
    about_y = np.array([[czx, 0.0, zx], [0.0, 1.0, 0.0], [-zx, 0.0, czx]])
    return np.asarray(about_z @ about_x @ about_y)


def _columns(line: str) -> tuple[list[int], int]:
    """The widths of the whole numbers that a line begins with, and that of the numbers after them."""
    match = COLUMNS.fullmatch(line.strip())
    groups = [(int(count), int(width)) for count, width in re.findall(r"(\d+)i(\d+)", match[1].lower())] if match else []
    if not match or not all(0 < count < 100 and 0 < width < 100 for count, width in groups):
        raise fault("The columns of a block", "must be stated as (3i9,6e21.13e3)", line.strip()[:60])
    return [width for count, width in groups for _ in range(count)], int(match[2] or 0)


def _nodes(lines: Iterator[str]) -> Iterator[tuple[str, list[float], list[float]]]:
    """Nodes up to the end of a block, a line that begins with "N," or -1: coordinates, and angles of their axes."""
    widths, wide = _columns(next(lines, ""))
    if not wide:
        raise fault("The columns of NBLOCK", "must be stated as (3i9,6e21.13e3)", "without those of coordinates")
    for line in lines:
        text = line.rstrip("\n")
        if text.startswith("N,") or text.strip() == "-1":
            return
        start = sum(widths)
        numbers = [coordinate(text[start + k * wide : start + (k + 1) * wide]) for k in range(6)]
        yield text[: widths[0]], numbers[:3], numbers[3:]


def _types(lines: Iterator[str]) -> Iterator[tuple[str, str]]:
    """Number and element type of each line of a block that ends with -1."""
    widths, _ = _columns(next(lines, ""))
    for line in lines:
        numbers = _cut(line, len(widths), widths[0])
        if numbers[:1] == ["-1"] or len(numbers) < 2:
            return
        yield numbers[0], numbers[1]


def _refuse_other_count(what: str, words: Sequence[str], found: int) -> None:
    """Refuse a block that does not hold as many lines as its command says, NBLOCK,6,SOLID,largest number,count."""
    count = integer(words[4]) if len(words) > 4 and words[4] else 0
    if count > 0 and count != found:
        raise fault(what, f"must be {count}, as the command says", found, "The file is damaged, or cut short. Copy it again.")


def _elements(lines: Iterator[str], types: Mapping[str, str], cells: FoundCells) -> int:
    """Elements up to the end of a block: -1; returns how many. What has no faces is passed over."""
    widths, _ = _columns(next(lines, ""))
    found = 0
    for line in lines:
        numbers = _cut(line, len(widths), widths[0])
        if numbers[:1] == ["-1"] or not numbers:
            break
        found += 1
        count = integer(numbers[8]) if len(numbers) > FIRST_NODE else 0
        nodes = numbers[FIRST_NODE:]
        while len(nodes) < count:
            more = _cut(next(lines, ""), len(widths), widths[0])
            if not more:
                break
            nodes += more
        if types.get(numbers[1] if len(numbers) > 1 else ""):
            cells.add(types[numbers[1]], nodes)
    return found


def _members(lines: Iterator[str], count: int) -> Iterator[int]:
    """The nodes of a component of `count` numbers."""
    widths, _ = _columns(next(lines, ""))
    each, width = len(widths), widths[0]
    total = last = left = 0
    own = (next(lines, "") for _ in range(-(-count // each)))
    for text in chain.from_iterable(_cut(line, each, width) for line in own):
        number, left = integer(text), left + 1
        # −9 after 4 stands for 5, 6, 7, 8, 9.
        span = range(last + 1, -number + 1) if number < 0 else range(number, number + 1)
        total += len(span)
        if total > MOST_GENERATED:
            raise fault("A component of nodes", f"must have at most {MOST_GENERATED} members", total)
        yield from span
        last = abs(number)
    if left < count:
        raise fault("A component of nodes", f"must hold its {count} numbers", left, "The file is truncated.")


def _cut(line: str, count: int, width: int) -> list[str]:
    """Entries of fixed width that are not blank."""
    text = line.rstrip("\n")
    pieces = (text[k * width : (k + 1) * width].strip() for k in range(count))
    return [piece for piece in pieces if piece]
