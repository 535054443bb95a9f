"""Harwell-Boeing files (.rb, .rsa, .rua, .hb), one matrix a file, read by SciPy."""

from __future__ import annotations

import re
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io

from stickslip.checks import fault
from stickslip.models.content import Content
from stickslip.models.limits import rows_with_entries, within_file
from stickslip.models.process import arrays_of
from stickslip.structure.sparse import both_triangles


def read(path: Path) -> Content:
    """An assembled matrix; of symmetric ones (second letter S of the type) the file holds one triangle."""
    kind, counts = _header(path)
    size = path.stat().st_size
    for what, claimed in zip(("rows", "columns", "entries"), counts, strict=True):
        within_file(f"{path.name}, {what}", claimed, size, 1.0)
    rows_with_entries(path.name, max(counts[:2]), counts[2])
    matrix = arrays_of(path, __name__)["matrix"]
    return Content("Harwell-Boeing", {"": both_triangles(path.name, matrix) if kind[1] == "s" else matrix})


def arrays(path: Path) -> dict[str, Any]:
    """The stored entries. SciPy reads those of unsymmetric matrices alone, which symmetric ones have in the same lines."""
    lines = path.read_text(encoding="ascii", errors="replace").splitlines(keepends=True)
    lines[2] = re.sub(r"(\s*\S)\S", r"\1U", lines[2], count=1)
    return {"matrix": io.hb_read(StringIO("".join(lines)), spmatrix=False)}


def _header(path: Path) -> tuple[str, list[int]]:
    """The type (three letters) and the numbers of rows, columns and entries, from the third line."""
    with path.open("rb") as file:
        third = [file.readline(400) for _ in range(3)][2].decode("ascii", "replace")
    fields = third.split()
    if len(fields) < 4 or not re.fullmatch("[a-z]{3}", fields[0].lower()) or not all(word.isdecimal() for word in fields[1:4]):
        raise fault(f"{path.name}, line 3", "must hold a type of three letters and the counts", third.strip()[:60])
    if fields[0][0].lower() != "r" or fields[0][2].lower() != "a":
        raise fault(f"{path.name}, type", "must be real and assembled (R?A)", fields[0])
    return fields[0].lower(), [min(int(word), np.iinfo(np.int64).max) for word in fields[1:4]]
