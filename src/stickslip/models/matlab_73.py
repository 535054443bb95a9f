"""MATLAB files of version 7.3: HDF5, with arrays columns first, sparse matrices and cell arrays as groups and references.

HDF5 is read in a process of its own: its library can take a process down on a damaged file, even as that process ends.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.checks import InputError, fault
from stickslip.models import numpy_archive
from stickslip.models.limits import MOST_DEFLATED, rows_with_entries, within_file, within_memory

WRONG = 2
"""Exit code of the process that reads, when the file is at fault."""
SECONDS, BYTES_PER_SECOND = 60.0, 1e6
PARTS = ("data", "indices", "indptr", "shape")


def read(path: Path) -> dict[str, Any]:
    """Arrays by name, read in a process of its own; what ends that process is a fault of the file."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "arrays.npz"
        command = [sys.executable, "-m", "stickslip.models.matlab_73", os.fspath(path.absolute()), os.fspath(target)]
        limit = SECONDS + path.stat().st_size / BYTES_PER_SECOND
        try:
            ended = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=limit, check=False)
        except subprocess.TimeoutExpired:
            raise fault("Reading HDF5", f"must end within {limit:.0f} s", "still going on", "The file is damaged.") from None
        if ended.returncode == WRONG:
            raise InputError(ended.stderr.strip()[:500])
        if not target.is_file():
            raise fault("The file", "must be sound HDF5", f"damaged (its reader ended with {ended.returncode})")
        return _assembled(numpy_archive.arrays(target))


def _assembled(parts: dict[str, Any]) -> dict[str, Any]:
    """Sparse matrices out of their parts NAME/data, NAME/indices, ...; everything else as it is."""
    found = {name: value for name, value in parts.items() if "/" not in name}
    for name in {name.partition("/")[0] for name in parts if "/" in name}:
        data, indices, starts, shape = (parts[f"{name}/{part}"] for part in PARTS)
        found[name] = sparse.csc_array((data, indices, starts), (int(shape[0]), int(shape[1])))
    return found


def _apart(name: str, value: Any) -> dict[str, Any]:
    """A value as arrays that a .npz file holds."""
    if isinstance(value, sparse.csc_array):
        return {f"{name}/{part}": np.asarray(getattr(value, part)) for part in PARTS}
    return {name: np.array(value, dtype=np.str_) if isinstance(value, list) else value}


def arrays(path: Path) -> dict[str, Any]:
    """Arrays by name, read in this process."""
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


def main(source: str, target: str) -> int:
    """Read `source` and write its arrays to `target`; returns the exit code."""
    try:
        found = {key: array for name, value in arrays(Path(source)).items() for key, array in _apart(name, value).items()}
        np.savez(target, **found)
    except Exception as error:  # the library raises whatever a damaged file leads it to
        sys.stderr.write(str(error) if isinstance(error, InputError) else f"As HDF5 it is damaged ({str(error)[:200]}).")
        return WRONG
    return 0


if __name__ == "__main__":
    code = main(sys.argv[1], sys.argv[2])
    sys.stderr.flush()
    os._exit(code)  # without the clean-up in which the library may fail
