"""MATLAB files of version 7.3: HDF5, with arrays columns first, sparse matrices and cell arrays as groups and references."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.model.readers.hdf5 import refuse_data_elsewhere, refuse_odd_numbers, refuse_other_files, refuse_too_much
from stickslip.model.readers.limits import rows_with_entries
from stickslip.model.readers.matlab_5 import OBJECT_NAMES
from stickslip.model.readers.numbers import compressed_columns
from stickslip.support.checks import fault
from stickslip.support.late import h5py

OBJECT = "MATLAB_object_decode"
"""Attribute of an object, whose numbers lie elsewhere."""
DEEPEST = 4
"""Structs in structs."""


def arrays(path: Path) -> dict[str, Any]:
    """Arrays by name."""
    with h5py.File(path, "r") as file:
        refuse_other_files(file)
        tops = [top for top in file if not top.startswith("#")]
        objects = [top for top in tops if OBJECT in file[top].attrs]
        named = (item for top in tops if top not in objects for item in _items(file, top, file[top], DEEPEST))
        return dict(named) | ({OBJECT_NAMES: objects} if objects else {})


def _items(file: Any, name: str, item: Any, depth: int) -> Iterator[tuple[str, Any]]:
    """A dense or sparse matrix or, for `dofs`, names; the fields of a struct as "rom.M"; nothing for anything else."""
    if isinstance(item, h5py.Group):
        if "MATLAB_sparse" in item.attrs:  # the number of rows; data, ir and jc are compressed columns
            rows, columns = int(item.attrs["MATLAB_sparse"]), int(item["jc"].size) - 1
            data, indices = (_dense(name, item[key]) if key in item else np.zeros(0, np.int64) for key in ("data", "ir"))
            rows_with_entries(name, max(rows, columns), data.size)
            yield name, compressed_columns(name, data, indices, _dense(name, item["jc"]), (rows, columns))
        elif depth:
            for field in item:
                yield from _items(file, f"{name}.{field}", item[field], depth - 1)
    elif name.rpartition(".")[2] == "dofs":
        yield name, _names(file, item)
    elif item.dtype.kind in "fiu" or item.dtype.names == ("real", "imag"):
        yield name, _dense(name, item).T


def _dense(name: str, item: Any) -> Any:
    """A stored array, columns first as MATLAB keeps it; {real, imag} becomes complex."""
    refuse_too_much(name, item)
    refuse_odd_numbers(name, item)
    values = item[()]
    return values["real"] + 1j * values["imag"] if item.dtype.names else values


def _names(file: Any, item: Any) -> list[str]:
    """Names from rows of characters, or from a cell array: references to character arrays."""
    refuse_too_much("dofs", item)
    if item.dtype.kind in "ui":
        return ["".join(map(chr, row)).strip() for row in np.atleast_2d(item[()].T)]
    if item.dtype != h5py.ref_dtype:
        raise fault("dofs", "must hold text", str(item.dtype), 'A cell array of names such as "17.x", one for each row.')
    names = []
    for reference in item[()].T.ravel():
        cell = file[reference]
        refuse_data_elsewhere(cell.id)  # no link need lead to the cell, so `refuse_other_files` may not have seen it
        refuse_too_much("dofs", cell)
        names.append("".join(map(chr, cell[()].ravel())))
    return names
