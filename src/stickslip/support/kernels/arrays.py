"""What kernels do with whole arrays, compiled once for all of them.

NumPy's own functions and expressions of arrays are compiled anew, at several times the length, wherever they stand in a kernel.
"""

import numpy as np
from numpy.typing import NDArray

from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inner


@inner
def empty_line(size: int) -> Array:
    """Uninitialised array of (size,) numbers."""
    return np.empty(size)


@inner
def empty_table(rows: int, columns: int) -> Array:
    """Uninitialised array of (rows, columns) numbers."""
    return np.empty((rows, columns))


@inner
def empty_blocks(blocks: int, rows: int, columns: int) -> Array:
    """Uninitialised array of (blocks, rows, columns) numbers."""
    return np.empty((blocks, rows, columns))


@inner
def zero_line(size: int) -> Array:
    """Zeros (size,)."""
    found = empty_line(size)
    for i in range(size):
        found[i] = 0.0
    return found


@inner
def zero_table(rows: int, columns: int) -> Array:
    """Zeros (rows, columns)."""
    found = empty_table(rows, columns)
    fill(found, 0.0)
    return found


@inner
def zero_numbers(size: int) -> Index:
    """Whole numbers 0, (size,)."""
    found = np.empty(size, dtype=np.int64)
    for i in range(size):
        found[i] = 0
    return found


@inner
def zero_complex(rows: int, columns: int) -> NDArray[np.complex128]:
    """Complex zeros (rows, columns)."""
    found = np.empty((rows, columns), dtype=np.complex128)
    for i in range(rows):
        for j in range(columns):
            found[i, j] = 0.0
    return found


@inner
def fill(table: Array, value: float) -> None:
    """Every entry of a table (rows, columns) becomes the value."""
    for i in range(table.shape[0]):
        for j in range(table.shape[1]):
            table[i, j] = value


@inner
def moved_by(table: Array, length: float, step: Array) -> Array:
    """table + length step, (rows, columns)."""
    found = empty_table(table.shape[0], table.shape[1])
    for i in range(table.shape[0]):
        for j in range(table.shape[1]):
            found[i, j] = table[i, j] + length * step[i, j]
    return found


@inner
def all_finite(table: Array) -> bool:
    """Whether every entry of a table (rows, columns) is finite."""
    for i in range(table.shape[0]):
        for j in range(table.shape[1]):
            if not np.isfinite(table[i, j]):
                return False
    return True


@inner
def same_numbers(a: Index, b: Index) -> bool:
    """Whether two lists of whole numbers of one length (size,) are equal."""
    different = 0
    for i in range(a.size):
        different += a[i] != b[i]
    return different == 0


@inner
def rows_of(values: Array, rows: Index) -> Array:
    """values[rows]."""
    found = np.empty((rows.size, values.shape[1]))
    for i in range(rows.size):
        found[i] = values[rows[i]]
    return found
