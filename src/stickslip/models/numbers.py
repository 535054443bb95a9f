"""Columns of numbers in text files, read fast and without trust."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy import sparse

from stickslip.checks import Array, Index, fault
from stickslip.models.limits import rows_with_entries, within_memory


def table(path: Path, columns: int, delimiter: str | None = None) -> Array:
    """Every line of a text file as `columns` numbers, (lines, columns); exponents may be written with D."""
    within_memory(path.name, 12 * path.stat().st_size)
    text = path.read_bytes().replace(b"D", b"E").replace(b"d", b"e").decode("ascii", "replace")
    found = np.loadtxt(text.splitlines(), dtype=float, delimiter=delimiter, ndmin=2, comments=("*", "#"))
    if found.size and found.shape[1] != columns:
        raise fault(f"Each line of {path.name}", f"must have {columns} numbers", found.shape[1])
    return found.reshape(-1, columns)


def whole(what: str, values: Array, lowest: int, highest: int | None = None) -> Index:
    """Numbers that stand for rows or nodes, as integers."""
    outside = (values < lowest) | (values > (highest or 2**31 - 1)) | (values != np.floor(values))
    if np.any(outside):
        limit = f" up to {highest}" if highest else ""
        raise fault(what, f"must be whole numbers from {lowest}{limit}", float(values[outside].ravel()[0]))
    return np.asarray(values.astype(np.int64))


def triplets(what: str, rows: Index, columns: Index, values: Array, size: int) -> sparse.csc_array:
    """The matrix (size, size) of entries by row and column, both counted from 0; entries named twice add up."""
    rows_with_entries(what, size, len(values))
    return sparse.coo_array((values, (rows, columns)), (size, size)).tocsc()


def numbering(keys: Sequence[tuple[int, int]]) -> dict[tuple[int, int], int]:
    """A row for each (node, direction), in ascending order."""
    return {key: row for row, key in enumerate(sorted(set(keys)))}
