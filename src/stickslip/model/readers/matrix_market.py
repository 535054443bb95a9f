"""Matrix Market files (.mtx, .mm): one matrix a file, in coordinates or as an array, general or one triangle.

The format is that of Boisvert, Pozo and Remington (NISTIR 5935, 1996). It says nothing of entries that stand twice: they add up,
as SciPy and others read and write them, and a note says so.
"""

import re
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.readers.model import Content
from stickslip.model.readers.numbers import number_lines, rows_with_entries, whole, within_memory
from stickslip.support.checks import Array, counted, fault

START = b"%%MatrixMarket"
FIELDS = ("real", "integer", "complex")
SYMMETRIES = ("general", "symmetric", "skew-symmetric", "hermitian")
COMMENTS_AND_SIZE = re.compile(rb"(?:[ \t]*(?:%[^\n]*)?\r?\n)*([^\n]*)\n?")


def read(path: Path) -> Content:
    """The matrix, with both triangles."""
    within_memory(path.name, 12 * path.stat().st_size)
    head, _, body = path.read_bytes().partition(b"\n")
    first_line = head[:400].decode("ascii", "replace").strip()
    words = first_line.lower().split()[1:]
    known = (("matrix",), ("coordinate", "array"), FIELDS, SYMMETRIES)
    if len(words) != len(known) or not all(word in names for word, names in zip(words, known, strict=True)):
        rule = f"must say matrix, coordinate or array, {', '.join(FIELDS)}, and {', '.join(SYMMETRIES)}"
        raise fault(f"The first line of {path.name}", rule, first_line[:80])
    _, layout, field, symmetry = words
    line = COMMENTS_AND_SIZE.match(body)
    sizes = line[1].decode("ascii", "replace").split() if line else []
    coordinates = layout == "coordinate"
    if len(sizes) != (3 if coordinates else 2) or not all(re.fullmatch(r"\d{1,18}", size) for size in sizes):
        what = "rows, columns and entries" if coordinates else "rows, columns"
        raise fault(f"The line of sizes of {path.name}", f"must hold the numbers of {what}", " ".join(sizes)[:60])
    rows, columns, *entries = map(int, sizes)
    if symmetry != "general" and rows != columns:
        raise fault(f"A {symmetry} matrix", "must be square", (rows, columns))
    triangle = rows * (rows - 1) // 2 if symmetry == "skew-symmetric" else rows * (rows + 1) // 2
    count = entries[0] if coordinates else rows * columns if symmetry == "general" else triangle
    width = (2 if coordinates else 0) + (2 if field == "complex" else 1)
    numbers = number_lines(path.name, body[line.end() if line else 0 :])
    if numbers.shape != (count, width) and (count or numbers.size):
        raise fault(path.name, f"must hold {count} lines of {counted(width, 'number')}, as it says", numbers.shape)
    numbers = numbers.reshape(count, width)
    values = numbers[:, -2] + 1j * numbers[:, -1] if field == "complex" else numbers[:, -1]
    if field == "integer" and np.any(values != np.floor(values)):
        raise fault(f"{path.name}, values,", "must be whole numbers, as its first line says", values[values % 1 != 0][0])
    if not coordinates:
        return Content("Matrix Market", {"": _array(values, rows, columns, symmetry)})
    rows_with_entries(path.name, max(rows, columns), count)
    at = [whole(f"{path.name}, rows and columns,", numbers[:, k], 1, size) - 1 for k, size in enumerate((rows, columns))]
    stored = sparse.coo_array((values, tuple(at)), (rows, columns)).tocsc()
    again = count - stored.nnz
    notes = (f"{path.name} repeats places of entries {again} times: the entries of one place are added up.",) if again else ()
    return Content("Matrix Market", {"": _filled(stored, symmetry)}, notes=notes)


def _array(values: Array, rows: int, columns: int, symmetry: str) -> Array:
    """The dense matrix of values that stand column by column."""
    if symmetry == "general":
        return values.reshape(columns, rows).T
    skew = symmetry == "skew-symmetric"
    upper = np.zeros((rows, rows), values.dtype)
    upper[np.triu_indices(rows, int(skew))] = values  # rows of the upper triangle are columns of the lower one
    lower = upper.T
    if skew:
        return np.asarray(lower - upper)
    return np.asarray(lower + np.triu(upper.conj() if symmetry == "hermitian" else upper, 1))


def _filled(matrix: Any, symmetry: str) -> Any:
    """Both triangles of a matrix that stores one."""
    if symmetry == "general":
        return matrix
    if sparse.tril(matrix, -1).nnz and sparse.triu(matrix, 1).nnz:
        raise fault(f"A {symmetry} matrix", "must store one triangle", "both", "Write `general` in its first line.")
    if symmetry == "skew-symmetric" and np.any(matrix.diagonal()):
        raise fault("A skew-symmetric matrix", "must have no diagonal", "one", "Is it symmetric?")
    other = matrix.conj().T if symmetry == "hermitian" else matrix.T
    whole_matrix = sparse.csc_array(matrix - other if symmetry == "skew-symmetric" else matrix + other)
    return whole_matrix - sparse.diags_array(matrix.diagonal()) if symmetry != "skew-symmetric" else whole_matrix
