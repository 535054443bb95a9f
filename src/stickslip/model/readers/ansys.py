"""Ansys .full files, read by `ansys-mapdl-reader` (optional: pip install "stickslip[ansys]"), in double precision.

The file holds one triangle, and rows and columns of zeros for constrained degrees of freedom: the triangle is mirrored, the
empty rows are dropped.
"""

from importlib import import_module, util
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.readers.model import Content, dof
from stickslip.model.readers.numbers import within_memory
from stickslip.model.readers.process import arrays_of
from stickslip.support.checks import fault

PACKAGE = "ansys.mapdl.reader"


def installed() -> bool:
    """Whether the package that reads .full files is there."""
    try:
        return util.find_spec(PACKAGE) is not None
    except ModuleNotFoundError:
        return False


def read(path: Path) -> Content:
    """Stiffness and mass of a .full file."""
    if not installed():
        raise fault("Ansys .full files", "must have their reader", "not installed", 'Get it: pip install "stickslip[ansys]".')
    within_memory(path.name, 12 * path.stat().st_size)
    read_arrays = arrays_of(path, __name__)
    stiffness, mass = _mirrored(read_arrays["K"]), _mirrored(read_arrays["M"])
    present = np.flatnonzero(stiffness.diagonal() != 0.0)
    dofs = tuple(dof(int(node), int(direction) + 1) for node, direction in read_arrays["rows"][present])
    dropped = stiffness.shape[0] - present.size
    notes = (f"{dropped} constrained rows of the file are left out.",) if dropped else ()
    matrices = {"K": stiffness[present][:, present], "M": mass[present][:, present]}
    return Content("Ansys .full file", matrices, dofs, notes=notes)


def arrays(path: Path) -> dict[str, Any]:
    """Node and direction (from 0) of each row, and one triangle of stiffness and mass."""
    file = import_module(PACKAGE).read_binary(str(path))
    if not hasattr(file, "load_km"):
        raise fault(path.name, "must be a .full file", type(file).__name__, "A result file (.rst) holds no matrices.")
    rows, K, M = file.load_km(as_sparse=True, sort=False)
    named: dict[str, Any] = {"rows": np.asarray(rows)}
    for name, matrix in (("K", K), ("M", M)):
        named[name] = sparse.csc_array(matrix)
        named[name].sum_duplicates()
    return named


def _mirrored(matrix: Any) -> sparse.csc_array:
    """Both triangles, of a matrix that has one of them or both."""
    stored = sparse.csc_array(matrix)
    upper, lower = sparse.triu(stored, 1), sparse.tril(stored, -1)
    one = upper if upper.nnz >= lower.nnz else lower.T
    return sparse.csc_array(one + one.T + sparse.diags_array(stored.diagonal()))
