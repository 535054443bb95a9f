"""MATLAB files of version 4 to 7, read by SciPy.

Numeric, logical and sparse arrays, text and a cell array `dofs` of names are read, also as fields of a struct, rom.M; everything
else is passed over.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io

from stickslip.support.checks import fault

OBJECTS, WORKSPACE = ("object", "opaque", "function"), "__function_workspace__"
"""Classes of what is no array, and the variable in which MATLAB keeps their content."""
OBJECT_NAMES = "__objects__"
"""Among the arrays, the names of the objects, which are not read."""
DEEPEST = 4
"""Structs in structs."""
NUMBERS = ("double", "single", "logical", "sparse", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)))
"""MATLAB's classes of numbers."""


def arrays(path: Path) -> dict[str, Any]:
    """Arrays by name: numbers as arrays, sparse matrices, rows of characters as text, the cells of `dofs` as a list of text."""
    with path.open("rb") as file:
        start = file.read(128)
    if start[126:128] not in (b"IM", b"MI") and 0 not in start[:4]:
        raise fault("A MATLAB file", "must be of version 4 to 7.3", "another", "save('model.mat', 'M', 'K') writes one.")
    stored = io.whosmat(path)
    for name, shape, kind in stored:
        if kind == "unknown" or not name.isidentifier() or (kind in NUMBERS and len(shape) < 2):
            rule = "must have a name, a known class and two dimensions or more"
            raise fault("A variable of a MATLAB file", rule, [name, kind, shape], "The file is damaged.")
    objects = [name for name, _, kind in stored if kind in OBJECTS]
    of_matrices = (*NUMBERS, "struct")
    wanted = [
        name
        for name, shape, kind in stored
        if kind == "char" or (len(shape) == 2 and (kind in of_matrices or (kind == "cell" and name == "dofs")))
    ]
    wanted = [name for name in wanted if name != WORKSPACE]
    loaded = io.loadmat(path, variable_names=wanted, spmatrix=False) if wanted else {}
    found = {name: value for each in wanted if each in loaded for name, value in _values(each, loaded[each], DEEPEST)}
    return found | ({OBJECT_NAMES: objects} if objects else {})


def _values(name: str, value: Any, depth: int) -> Iterator[tuple[str, Any]]:
    """An array under its name; those of a struct under theirs, "rom.M"."""
    if value.dtype.names:
        for field in value.dtype.names if depth and value.size == 1 else ():
            inner = value[field].item()
            if isinstance(inner, np.ndarray) or hasattr(inner, "nnz"):
                yield from _values(f"{name}.{field}", inner, depth - 1)
    elif value.dtype != object:
        yield name, value
    elif name.rpartition(".")[2] == "dofs":
        cells = value.T.flat  # column by column; the name is empty where a cell holds no text
        yield name, [str(cell[0]) if getattr(cell, "dtype", np.dtype(float)).kind == "U" and cell.size else "" for cell in cells]
