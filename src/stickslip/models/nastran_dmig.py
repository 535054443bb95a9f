"""Nastran DMIG entries (.pch, .dmig, .bdf): matrices by grid point and component, with GRID entries for coordinates.

DMIG, NAME, 0, IFO, TIN, ... is the header; DMIG, NAME, GJ, CJ, , G1, C1, A1, B1 with continuations G2, C2, A2, B2, ... a column;
IFO 6 is symmetric, each pair of entries once; 1 is square; 2 and 9 are rectangular (loads), which no model needs. Small fields
of 8, large ones of 16 (DMIG*) and free format with commas are read. (MSC Nastran Quick Reference Guide, DMIG.)
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import sparse

from stickslip.checks import fault
from stickslip.models.content import Content, dof, located
from stickslip.models.deck import Deck
from stickslip.models.limits import within_memory
from stickslip.structure.matrices import Point
from stickslip.structure.sparse import both_triangles

SYMMETRIC, SQUARE = 6, 1
BASIC = ("", "0")
"""How an entry names the basic coordinate system."""
RECTANGULAR = (2, 9)
COMPLEX = (3, 4)
EXPONENT = re.compile(r"([0-9.])([+-]\d+)$")
GridComponent = tuple[int, int]
CARD = 10
"""Fields of an entry and its continuation mark in small format."""


@dataclass
class Matrix:
    """A matrix as it is read: its form and type, and entries by (grid point, component) of row and column."""

    form: int
    kind: int
    rows: list[GridComponent] = field(default_factory=list)
    columns: list[GridComponent] = field(default_factory=list)
    values: list[complex] = field(default_factory=list)


def read(path: Path) -> Content:
    """Every square DMIG matrix of the file, over the degrees of freedom of all of them in ascending order."""
    within_memory(path.name, 60 * path.stat().st_size)
    matrices, nodes = _taken(path)
    rectangular = [name for name, matrix in matrices.items() if matrix.form in RECTANGULAR]
    notes = (f"Rectangular matrices of the file are left out: {', '.join(rectangular)}.",) if rectangular else ()
    matrices = {name: matrix for name, matrix in matrices.items() if name not in rectangular}
    if not matrices:
        raise fault(path.name, "must hold square DMIG entries", "none")
    keys = sorted({key for matrix in matrices.values() for key in (*matrix.rows, *matrix.columns)})
    row = {key: index for index, key in enumerate(keys)}
    dofs = tuple(dof(*key) for key in keys)
    assembled = {name: _assembled(name, matrix, row) for name, matrix in matrices.items()}
    return Content("Nastran DMIG", assembled, dofs, nodes, notes=notes)


def read_grid(path: Path) -> Deck:
    """Coordinates of the grid points of a bulk data file, in the basic system; those in others are left out, with a note."""
    within_memory(path.name, 20 * path.stat().st_size)
    points: list[tuple[str, Point]] = []
    others = 0
    with path.open(encoding="ascii", errors="replace") as file:
        for entry in _entries(file):
            points += _grid_point(entry)
            others += entry[0] == "GRID" and entry[2] not in BASIC
    notes = (f"{others} grid points of {path.name} in coordinate systems of their own are left out.",) if others else ()
    return Deck(located(points), notes=notes)


def _grid_point(entry: list[str]) -> list[tuple[str, Point]]:
    """The number and place of a grid point in the basic system; nothing of another entry."""
    if entry[0] != "GRID" or entry[2] not in BASIC:
        return []
    return [(str(_integer(entry[1])), (_number(entry[3]), _number(entry[4]), _number(entry[5])))]


def _taken(path: Path) -> tuple[dict[str, Matrix], dict[str, Point]]:
    """The matrices by name, and the coordinates of grid points in the basic system."""
    matrices: dict[str, Matrix] = {}
    points: list[tuple[str, Point]] = []
    with path.open(encoding="ascii", errors="replace") as file:
        for entry in _entries(file):
            if entry[0] == "DMIG":
                _take(entry, matrices)
            points += _grid_point(entry)
    return matrices, located(points)


def _assembled(name: str, matrix: Matrix, row: dict[GridComponent, int]) -> sparse.csc_array:
    values = np.array(matrix.values)
    places = [row[key] for key in matrix.rows], [row[key] for key in matrix.columns]
    data = values if matrix.kind in COMPLEX else values.real
    stored = sparse.coo_array((data, places), (len(row), len(row))).tocsc()
    if stored.nnz < data.size:
        (row_of, column), _ = Counter(zip(matrix.rows, matrix.columns, strict=True)).most_common(1)[0]
        raise fault(f"DMIG {name}", "must hold each entry once", f"{dof(*row_of)}, {dof(*column)} more than once")
    return both_triangles(f"DMIG {name}", stored) if matrix.form == SYMMETRIC else stored


def _take(entry: list[str], matrices: dict[str, Matrix]) -> None:
    """A header, or a column with its terms."""
    name = entry[1]
    if _integer(entry[2]) == 0:
        if name in matrices:
            raise fault(f"DMIG {name}", "must have one header", "several", "Two files in one?")
        form, kind = _integer(entry[3]), _integer(entry[4])
        if form not in (SYMMETRIC, SQUARE, *RECTANGULAR):
            raise fault(f"IFO of {name}", "must be 1 (square), 2, 9 (rectangular) or 6 (symmetric)", form)
        matrices[name] = Matrix(form, kind)
        return
    if name not in matrices:
        raise fault(f"DMIG {name}", "must begin with its header (0 in the third field)", entry[2])
    matrix = matrices[name]
    if matrix.form in RECTANGULAR:
        return
    column = _integer(entry[2]), _component(entry[3])
    for start in range(5, len(entry), 4):
        grid, component, real, imaginary = (*entry[start : start + 4], "", "", "")[:4]
        if grid:
            matrix.rows.append((_integer(grid), _component(component)))
            matrix.columns.append(column)
            matrix.values.append(complex(_number(real), _number(imaginary)))


def _entries(lines: Iterator[str]) -> Iterator[list[str]]:
    """Each bulk data entry with its continuations as fields; the name without its star."""
    entry: list[str] = []
    for raw in lines:
        line = raw.split("$")[0].rstrip("\r\n").expandtabs()
        if not line.strip():
            continue
        first, *rest = _fields(line)
        if first in ("", "*") or first[0] in "+*":
            entry += rest
            continue
        if entry:
            yield entry
        entry = [first.rstrip("*").upper(), *rest]
    if entry:
        yield entry


def _fields(line: str) -> list[str]:
    """The first field, and eight small or four large ones; blanks where the line ends early."""
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        return (words + [""] * (CARD - 1))[: CARD - 1]
    width, number = (16, 4) if "*" in line[:8] else (8, 8)
    places = range(8, 8 + width * number, width)
    return [line[:8].strip(), *(line[place : place + width].strip() for place in places)]


def _integer(word: str) -> int:
    if not re.fullmatch(r"[+-]?\d{1,10}", word):
        raise fault("A field of an entry", "must be a whole number", word[:20])
    return int(word)


def _component(word: str) -> int:
    """The component of a grid point; scalar and extra points have none, or 0."""
    return _integer(word) if word else 0


def _number(word: str) -> float:
    """A number as Nastran writes it: 1.0+5 and 1.0D+5 are 1e5, a blank is 0."""
    text = EXPONENT.sub(r"\1E\2", word.upper().replace("D", "E"))
    try:
        return float(text or 0.0)
    except ValueError:
        raise fault("A field of an entry", "must be a number", word[:20]) from None
