"""Matrix Market files (.mtx, .mm), read by SciPy: one matrix a file, in coordinates or as an array, general or one triangle.

The format is that of Boisvert, Pozo and Remington (NISTIR 5935, 1996). It says nothing of entries that stand twice: they add up,
as SciPy and others read and write them, and a note says so.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io, sparse

from stickslip.checks import fault
from stickslip.models.content import Content
from stickslip.models.limits import rows_with_entries, within_file, within_memory
from stickslip.models.process import arrays_of

START = b"%%MatrixMarket"
FIELDS = ("real", "integer", "complex")
SYMMETRIES = ("general", "symmetric", "skew-symmetric", "hermitian")


def read(path: Path) -> Content:
    """The matrix, with both triangles."""
    symmetry = _header(path)[2]
    found = arrays_of(path, __name__)
    stored, repeated = found["matrix"], int(found["repeated"])
    notes = (f"{path.name} names places of entries again, {repeated} times: what stands there is added up.",) if repeated else ()
    return Content("Matrix Market", {"": _filled(stored, symmetry) if sparse.issparse(stored) else stored}, notes=notes)


def _header(path: Path) -> tuple[str, str, str]:
    """Layout, field and symmetry, from the first line."""
    with path.open("rb") as file:
        head = file.readline(400).decode("ascii", "replace").strip()
    words = head.lower().split()[1:]
    known = len(words) == 4 and words[0] == "matrix" and words[1] in ("coordinate", "array")
    if not known or words[2] not in FIELDS or words[3] not in SYMMETRIES:
        rule = f"must say matrix, coordinate or array, {', '.join(FIELDS)}, and {', '.join(SYMMETRIES)}"
        raise fault(f"The first line of {path.name}", rule, head[:80])
    return words[1], words[2], words[3]


def arrays(path: Path) -> dict[str, Any]:
    """The stored entries: those of one triangle where the file is in coordinates and not general; how many stand again."""
    layout, field, _ = _header(path)
    size = path.stat().st_size
    within_memory(path.name, 12 * size)
    rows, columns, entries, *_ = io.mminfo(path)
    within_file(f"{path.name}, entries", entries, 2 * size + max(rows, columns), 2.0 if layout == "coordinate" else 1.0)
    if layout == "array":
        return {"matrix": io.mmread(path, spmatrix=False), "repeated": np.array(0)}
    rows_with_entries(path.name, max(rows, columns), entries)
    # Under a general header SciPy hands the entries on as they stand; else it mirrors them, and both triangles would add up.
    body = path.read_bytes().partition(b"\n")[2]
    stored = io.mmread(BytesIO(START + f" matrix coordinate {field} general\n".encode() + body), spmatrix=False)
    matrix = sparse.coo_array(stored).tocsc()
    return {"matrix": matrix, "repeated": np.array(entries - matrix.nnz)}


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
