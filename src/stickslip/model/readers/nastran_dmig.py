"""Nastran DMIG entries (.pch, .dmig, .bdf): matrices by grid point and component, with GRID entries for coordinates.

DMIG, NAME, 0, IFO, TIN, ... is the header; DMIG, NAME, GJ, CJ, , G1, C1, A1, B1 with continuations G2, C2, A2, B2, ... a column;
IFO 6 is symmetric, each pair of entries once; 1 is square; 2 and 9 are rectangular (loads), which no model needs.
(MSC Nastran Quick Reference Guide, DMIG.)
"""

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import sparse

from stickslip.model.readers.deck import Line
from stickslip.model.readers.model import Content, dof
from stickslip.model.readers.nastran_deck import BulkData, bulk_lines, entries, number, positive_integer
from stickslip.model.readers.numbers import CUT_SHORT, integer, refuse_cut
from stickslip.model.structure.sparse import both_triangles
from stickslip.support.checks import counted, fault

SYMMETRIC, SQUARE = 6, 1
RECTANGULAR = (2, 9)
COMPLEX = (3, 4)
TYPES = (1, 2, *COMPLEX)
NAME = re.compile(r"[A-Z][A-Z0-9]{0,7}")
CUT_BY_COMMENT = re.compile(r"[*+]\s*\$")
LOST_COMMA = "Is the comma missing with which a continuation begins?"
GridComponent = tuple[int, int]


@dataclass
class Matrix:
    """A matrix as it is read: its form and type, how many columns it says it has (0: nothing), and entries by (grid point,
    component) of row and column."""

    form: int
    kind: int
    size: int
    rows: list[GridComponent] = field(default_factory=list)
    columns: list[GridComponent] = field(default_factory=list)
    values: list[complex] = field(default_factory=list)


def read(path: Path) -> Content:
    """Every square DMIG matrix of the file, over the degrees of freedom of all of them in ascending order."""
    matrices: dict[str, Matrix] = {}
    bulk, last = BulkData(), ""
    for entry in entries(map(_whole, bulk_lines(path, 60))):
        last = entry.fields[0]
        if last == "DMIG":
            _take(entry.fields, matrices)
        elif matrices and not NAME.fullmatch(last):
            raise fault("An entry of bulk data", "must begin with its name", last or "blank", LOST_COMMA)
        bulk.take(entry)
    if last == "DMIG":
        refuse_cut(path)
    grid = bulk.deck(path.name)
    rectangular = [name for name, matrix in matrices.items() if matrix.form in RECTANGULAR]
    notes: tuple[str, ...] = (f"Rectangular matrices of the file are left out: {', '.join(rectangular)}.",) if rectangular else ()
    matrices = {name: matrix for name, matrix in matrices.items() if name not in rectangular}
    if not matrices:
        raise fault(path.name, "must hold square DMIG entries", "none")
    notes += tuple(
        f"DMIG {name} holds {counted(len(set(matrix.columns)), 'column')} of the {matrix.size} that its header names."
        for name, matrix in matrices.items()
        if matrix.size and matrix.size != len(set(matrix.columns))
    )
    keys = sorted({key for matrix in matrices.values() for key in (*matrix.rows, *matrix.columns)})
    scalar = {grid for grid, component in keys if component == 0} & {grid for grid, component in keys if component}
    if scalar:
        raise fault(
            f"Point {min(scalar)}", "must be a grid point with components or a scalar point without them", "both", LOST_COMMA
        )
    row = {key: index for index, key in enumerate(keys)}
    dofs = tuple(dof(*key) for key in keys)
    assembled = {name: _assembled(name, matrix, row) for name, matrix in matrices.items()}
    notes = (*notes, *grid.notes)
    return Content("Nastran DMIG", assembled, dofs, grid.nodes, notes=notes, cells=grid.cells, turned=grid.turned)


def _whole(line: Line) -> Line:
    """A line, unless a comment begins where a continuation has its fields."""
    if CUT_BY_COMMENT.match(line.text):
        raise fault("A continuation", "must hold fields", line.text.strip()[:60])
    return line


def _assembled(name: str, matrix: Matrix, row: dict[GridComponent, int]) -> sparse.csc_array:
    """The sparse matrix, with both triangles, over the rows of all matrices; no entry stands twice."""
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
    if not NAME.fullmatch(name.upper()):
        raise fault("The name of a DMIG matrix", "must be a letter and up to seven letters or digits", name)
    if integer(entry[2]) == 0:
        if name in matrices:
            raise fault(f"DMIG {name}", "must have one header", "several", "Two files in one?")
        form, kind, polar = integer(entry[3]), integer(entry[4]), entry[6]
        if form not in (SYMMETRIC, SQUARE, *RECTANGULAR):
            raise fault(f"IFO of {name}", "must be 1 (square), 2, 9 (rectangular) or 6 (symmetric)", form)
        if kind not in TYPES:
            raise fault(f"TIN of {name}", "must be 1, 2 (real, single or double), 3 or 4 (complex)", kind)
        if polar not in ("", "0"):
            raise fault(f"POLAR of {name}", "must be 0 or blank: real and imaginary parts", polar)
        matrices[name] = Matrix(form, kind, integer(entry[8] or "0") if len(entry) > 8 else 0)
        return
    if name not in matrices:
        raise fault(f"DMIG {name}", "must begin with its header (0 in the third field)", entry[2])
    matrix = matrices[name]
    if matrix.form in RECTANGULAR:
        return
    column = positive_integer(entry[2]), _component(entry[3])
    if entry[4]:
        raise fault(f"The fifth field of a column of DMIG {name}", "must be blank", entry[4], LOST_COMMA)
    for start in range(5, len(entry), 4):
        grid, component, real, imaginary = (*entry[start : start + 4], "", "", "")[:4]
        if any(entry[start : start + 4]) and not (grid and (real or imaginary)):
            raise fault(f"A term of DMIG {name}", "must have a grid point and a value", entry[start : start + 4], CUT_SHORT)
        if imaginary and matrix.kind not in COMPLEX:
            raise fault(f"A term of DMIG {name}", "must be real, as its header says", entry[start : start + 4])
        if grid:
            matrix.rows.append((positive_integer(grid), _component(component)))
            matrix.columns.append(column)
            matrix.values.append(complex(_value(real), _value(imaginary)))


def _value(word: str) -> float:
    """A real number, which has a decimal point or an exponent."""
    if word and not set(".EeDd") & set(word):
        raise fault("A value of a term", "must have a decimal point", word[:20])
    return number(word)


def _component(word: str) -> int:
    """The component of a grid point; scalar and extra points have none, or 0."""
    component = integer(word) if word else 0
    if component not in range(7):
        raise fault("The component of a grid point", "must be 1 to 6, or 0 for scalar points", component)
    return component
