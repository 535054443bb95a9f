"""MATLAB files: version 5 to 7 (`matlab_5`) and 7.3, which is HDF5 (h5py). M, K, C dense or sparse, `dofs`, `nodes`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.checks import fault
from stickslip.models import matlab_5
from stickslip.models.content import Content
from stickslip.models.limits import MOST_DEFLATED, rows_with_entries, within_file, within_memory
from stickslip.models.named_rows import from_tables

HDF5 = b"\x89HDF\r\n\x1a\n"
USER_BLOCKS = (0, 512, 1024, 2048)


def read(path: Path) -> Content:
    """The numeric arrays of a MATLAB file, of whatever version."""
    if _is_hdf5(path):
        return from_tables("MATLAB 7.3 file", _hdf5(path))
    within_memory(path.name, 3 * path.stat().st_size)
    return from_tables("MATLAB file", matlab_5.read(path.read_bytes()))


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        start = file.read(USER_BLOCKS[-1] + len(HDF5))
    return any(start[place : place + len(HDF5)] == HDF5 for place in USER_BLOCKS)


def _hdf5(path: Path) -> dict[str, Any]:
    import h5py

    with h5py.File(path, "r") as file:
        return {name: value for name in file if not name.startswith("#") and (value := _item(file, name)) is not None}


def _item(file: Any, name: str) -> Any:
    """A dense or sparse matrix or, for `dofs`, names; None for anything else."""
    import h5py

    item = file[name]
    if isinstance(item, h5py.Group):
        return _sparse_group(name, item) if "MATLAB_sparse" in item.attrs else None
    if name == "dofs":
        return _hdf5_names(file, item)
    return _dense(name, item).T if item.dtype.kind in "fiu" or item.dtype.names == ("real", "imag") else None


def _dense(name: str, item: Any) -> Any:
    """A stored array, columns first as MATLAB keeps it; {real, imag} becomes complex."""
    _bounded(name, item)
    values = item[()]
    return values["real"] + 1j * values["imag"] if item.dtype.names else values


def _bounded(name: str, item: Any) -> None:
    within_file(f"{name}, entries", int(item.size), max(item.id.get_storage_size(), 1), 1.0 / MOST_DEFLATED)
    within_memory(name, int(item.size) * item.dtype.itemsize)


def _sparse_group(name: str, group: Any) -> Any:
    """The compressed columns data, ir, jc; the attribute holds the number of rows."""
    rows, columns = int(group.attrs["MATLAB_sparse"]), int(group["jc"].size) - 1
    data, indices = (_dense(name, group[key]) if key in group else np.zeros(0) for key in ("data", "ir"))
    rows_with_entries(name, max(rows, columns), data.size)
    starts = _dense(name, group["jc"])
    matrix = sparse.csc_array((data, indices.astype(np.int64), starts.astype(np.int64)), (rows, columns))
    matrix.check_format(full_check=True)
    return matrix


def _hdf5_names(file: Any, item: Any) -> list[str]:
    """Names from rows of characters, or from a cell array: references to character arrays."""
    import h5py

    _bounded("dofs", item)
    if item.dtype.kind in "ui":
        return ["".join(map(chr, row)).strip() for row in np.atleast_2d(item[()].T)]
    if item.dtype != h5py.ref_dtype:
        raise fault("dofs", "must hold text", str(item.dtype), 'A cell array of names such as "17.x", one for each row.')
    return ["".join(map(chr, file[reference][()].ravel())) for reference in item[()].T.ravel()]
