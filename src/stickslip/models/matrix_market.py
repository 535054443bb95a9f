"""Matrix Market files (.mtx, .mm): one matrix a file, in coordinates or as an array, general or one triangle.

The format is that of Boisvert, Pozo and Remington (NISTIR 5935, 1996). It says nothing of entries that stand twice: they add up,
as SciPy and others read and write them, and a note says so. It is read here and not by SciPy, whose compiled reader
takes the process down on damaged files.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.checks import Array, fault
from stickslip.models.content import Content
from stickslip.models.limits import rows_with_entries, within_file, within_memory
from stickslip.models.numbers import numbers_in, whole

START = b"%%MatrixMarket"
NUMBERS = {"real": 1, "integer": 1, "complex": 2}
"""Numbers of an entry."""
SYMMETRIES = ("general", "symmetric", "skew-symmetric", "hermitian")


def read(path: Path) -> Content:
    """The matrix, with both triangles."""
    within_memory(path.name, 12 * path.stat().st_size)
    head, _, rest = path.read_text(encoding="ascii", errors="replace").partition("\n")
    words = head.lower().split()[1:]
    if len(words) != 4 or words[0] != "matrix" or words[2] not in NUMBERS or words[3] not in SYMMETRIES:
        rule = f"must say matrix, coordinate or array, {', '.join(NUMBERS)}, and {', '.join(SYMMETRIES)}"
        raise fault(f"The first line of {path.name}", rule, head[:80])
    sizes, _, body = _without_comments(rest).partition("\n")
    counts = [int(word) for word in sizes.split() if word.isdecimal()]
    if len(counts) != (3 if words[1] == "coordinate" else 2):
        raise fault(f"The sizes of {path.name}", "must be rows, columns and, for coordinates, entries", sizes[:60])
    values = numbers_in(body)
    stored = (_coordinates if words[1] == "coordinate" else _array)(path.name, counts, values, NUMBERS[words[2]], words[3])
    return Content("Matrix Market", {"": _filled(stored, words[3])}, notes=_repeated(path.name, stored, counts[2:]))


def _repeated(name: str, stored: Any, claimed: list[int]) -> tuple[str, ...]:
    """A note on duplicate entries; `claimed`: how many entries a file of coordinates has."""
    number = claimed[0] - stored.nnz if claimed else 0
    return (f"{name} names places of entries again, {number} times: what stands there is added up.",) if number else ()


def _without_comments(text: str) -> str:
    while text.lstrip().startswith("%"):
        text = text.lstrip().partition("\n")[2]
    return text.lstrip()


def _coordinates(name: str, counts: list[int], values: Array, numbers: int, symmetry: str) -> Any:
    """Lines "row column value", rows and columns counted from 1."""
    rows, columns, entries = counts
    _as_many(name, entries * (2 + numbers), values)
    rows_with_entries(name, max(rows, columns), entries)
    table = values.reshape(entries, 2 + numbers)
    places = whole(f"Rows of {name}", table[:, 0], 1, rows) - 1, whole(f"Columns of {name}", table[:, 1], 1, columns) - 1
    return sparse.coo_array((_numbers(table[:, 2:]), places), (rows, columns)).tocsc()


def _array(name: str, counts: list[int], values: Array, numbers: int, symmetry: str) -> Any:
    """A value a line, column by column; of one triangle the rows from the diagonal on (below it, when skew-symmetric)."""
    rows, columns = counts
    within_file(f"{name}, entries", rows * columns, 2 * values.size + max(rows, columns), 1.0)
    if symmetry == "general":
        _as_many(name, rows * columns * numbers, values)
        return _numbers(values.reshape(rows * columns, numbers)).reshape(columns, rows).T
    if rows != columns:
        raise fault(f"{name}, {symmetry},", "must be square", (rows, columns))
    column, row = np.triu_indices(rows, 1 if symmetry == "skew-symmetric" else 0)
    _as_many(name, row.size * numbers, values)
    matrix = np.zeros((rows, rows), complex if numbers == 2 else float)
    matrix[row, column] = _numbers(values.reshape(row.size, numbers))
    return matrix


def _as_many(name: str, expected: int, values: Array) -> None:
    if values.size != expected:
        raise fault(f"{name}, numbers,", f"must be as many as its sizes say, {expected}", values.size, "Was it cut short?")


def _numbers(parts: Array) -> Any:
    return parts[:, 0] if parts.shape[1] == 1 else parts[:, 0] + 1j * parts[:, 1]


def _filled(matrix: Any, symmetry: str) -> Any:
    """Both triangles of a matrix that stores one."""
    if symmetry == "general":
        return matrix
    if sparse.tril(matrix, -1).multiply(sparse.triu(matrix, 1).T).nnz:
        raise fault(f"A {symmetry} matrix", "must store one triangle", "both", "Write `general` in its first line.")
    if symmetry == "skew-symmetric" and np.any(matrix.diagonal()):
        raise fault("A skew-symmetric matrix", "must have no diagonal", "one", "Is it symmetric?")
    other = matrix.conj().T if symmetry == "hermitian" else matrix.T
    whole = sparse.csc_array(matrix - other if symmetry == "skew-symmetric" else matrix + other)
    return whole - sparse.diags_array(matrix.diagonal()) if symmetry != "skew-symmetric" else whole
