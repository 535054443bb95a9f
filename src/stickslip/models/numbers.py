"""Fast, defensive parsing of number columns in text files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy import sparse

from stickslip.checks import Array, Index, fault
from stickslip.models.limits import rows_with_entries, within_memory


def table(path: Path, columns: int | None) -> Array:
    """Every line of a text file as `columns` numbers, split by blanks or commas, (lines, columns); None: as many as there are.

    Comments begin with * or #; exponents may be written with D.
    """
    within_memory(path.name, 12 * path.stat().st_size)
    text = _readable(path.read_bytes())
    # Without any comment to look for, lines are parsed in compiled code alone, four times as fast.
    comments = tuple(mark for mark in "*#" if mark in text)
    found = np.loadtxt(text.splitlines(), dtype=float, ndmin=2, comments=comments or None)
    if found.size == 0 or (columns is not None and found.shape[1] != columns):
        raise fault(
            f"Each line of {path.name}", f"must have {columns or 'several'} numbers", found.shape[1] if found.size else "empty"
        )
    return np.asarray(found)


def numbers_in(text: str) -> Array:
    """The numbers of a text, split by blanks or commas."""
    return np.array(_readable(text.encode("ascii", "replace")).split(), dtype=float)


def _readable(content: bytes) -> str:
    return content.translate(bytes.maketrans(b"Dd,", b"Ee ")).decode("ascii", "replace")


def whole(what: str, values: Array, lowest: int, highest: int | None = None) -> Index:
    """Numbers that stand for rows or nodes, as integers."""
    outside = (values < lowest) | (values > (2**31 - 1 if highest is None else highest)) | (values != np.floor(values))
    if np.any(outside):
        limit = "" if highest is None else f" up to {highest}"
        raise fault(what, f"must be whole numbers from {lowest}{limit}", float(values[outside].ravel()[0]))
    return np.asarray(values.astype(np.int64))


def triplets(what: str, rows: Index, columns: Index, values: Array, size: int) -> sparse.csc_array:
    """The matrix (size, size) of entries by row and column, both counted from 0; none stands twice."""
    rows_with_entries(what, size, len(values))
    matrix = sparse.coo_array((values, (rows, columns)), (size, size)).tocsc()
    if matrix.nnz < len(values):
        places, counts = np.unique(np.column_stack([rows, columns]), axis=0, return_counts=True)
        row, column = (places[counts > 1][0] + 1).tolist()
        raise fault(what, "must hold each entry once", f"row {row}, column {column} more than once", "Was it put together?")
    return matrix
