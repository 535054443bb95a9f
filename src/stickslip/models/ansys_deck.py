"""Archives of Ansys (.cdb of CDWRITE): coordinates of nodes (NBLOCK) and components of nodes (CMBLOCK), in fixed columns.

NBLOCK is followed by a line with its columns, "(3i9,6e21.13e3)": whole numbers, the first of which is the node, then x, y, z and
angles; zeros at the end of a line are left out. CMBLOCK, NAME, NODE, COUNT holds numbers; a negative one means "up to".
(Mechanical APDL Programmer's Reference: Mapped files, coded database.)
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from stickslip.checks import fault
from stickslip.models.content import located
from stickslip.models.deck import MOST_GENERATED, Deck
from stickslip.models.limits import within_memory
from stickslip.structure.matrices import Point

COLUMNS = re.compile(r"\(((?:\d+i\d+,?)+)(?:\d+e(\d+)\.\d+(?:e\d+)?)?\)", re.IGNORECASE)


def read_archive(path: Path) -> Deck:
    """Nodes and node components of an archive; all else is passed over."""
    within_memory(path.name, 10 * path.stat().st_size)
    nodes: list[tuple[str, Point]] = []
    sets: dict[str, tuple[str, ...]] = {}
    with path.open(encoding="ascii", errors="replace") as file:
        for line in file:
            words = [word.strip().upper() for word in line.partition("!")[0].split(",")]
            if words[0] == "NBLOCK":
                nodes += _nodes(file)
            elif words[0] == "CMBLOCK" and len(words) > 3 and words[2].startswith("NODE"):
                sets[words[1]] = tuple(map(str, _members(file, int(words[3]))))
    return Deck(located(nodes), sets)


def _columns(line: str) -> tuple[list[int], int]:
    """The widths of the whole numbers that a line begins with, and that of the numbers after them."""
    match = COLUMNS.fullmatch(line.strip())
    groups = [(int(count), int(width)) for count, width in re.findall(r"(\d+)i(\d+)", match[1].lower())] if match else []
    if not match or not all(0 < count < 100 and 0 < width < 100 for count, width in groups):
        raise fault("The columns of a block", "must be stated as (3i9,6e21.13e3)", line.strip()[:60])
    return [width for count, width in groups for _ in range(count)], int(match[2] or 0)


def _nodes(lines: Iterator[str]) -> Iterator[tuple[str, Point]]:
    """Nodes up to the end of a block: a line that begins with "N," or -1."""
    widths, wide = _columns(next(lines, ""))
    if not wide:
        raise fault("The columns of NBLOCK", "must be stated as (3i9,6e21.13e3)", "without those of coordinates")
    for line in lines:
        text = line.rstrip("\n")
        if text.startswith("N,") or text.strip() == "-1":
            return
        start = sum(widths)
        x, y, z = (float(text[start + k * wide : start + (k + 1) * wide].strip() or 0.0) for k in range(3))
        yield str(int(text[: widths[0]])), (x, y, z)


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
