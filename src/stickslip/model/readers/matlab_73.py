"""MATLAB files of version 7.3: HDF5, with arrays columns first, sparse matrices and cell arrays as groups and references.

HDF5 files of unknown origin: what would have other files of the machine read, or more than a file can hold, is refused
before it is read.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.model.readers.matlab_5 import OBJECT_NAMES
from stickslip.model.readers.numbers import MOST_DEFLATED, compressed_columns, rows_with_entries, within_file, within_memory
from stickslip.support.checks import InputError, fault
from stickslip.support.late import h5py


def refuse_other_files(file: Any) -> None:
    """Refuse an open `h5py.File` with a link to another file or with data in another file, in whichever group."""
    names: list[bytes] = []
    file.id.links.visit(names.append)  # follows no link but the hard ones; h5py loses an exception raised here
    for name in names:
        kind = file.id.links.get_info(name).type
        if kind == h5py.h5l.TYPE_HARD:
            refuse_data_elsewhere(h5py.h5o.open(file.id, name), name)
        elif kind != h5py.h5l.TYPE_SOFT:  # which names a path within the file
            raise _elsewhere(name, "an external link")


def refuse_data_elsewhere(item: Any, name: bytes = b"") -> None:
    """Refuse a dataset, by its identifier, whose values lie in another file: as raw bytes, or as a part of its datasets.

    name: its place in the file, where a link leads to it.
    """
    if isinstance(item, h5py.h5d.DatasetID):
        created = item.get_create_plist()
        if created.get_layout() == h5py.h5d.VIRTUAL:
            raise _elsewhere(name, "a virtual dataset")
        if created.get_external_count():
            raise _elsewhere(name, "external storage")


def refuse_too_much(name: str, item: Any) -> None:
    """Refuse an `h5py.Dataset` that claims more than its bytes can hold, or half of the memory."""
    within_file(f"{name}, entries", int(item.size), max(item.id.get_storage_size(), 1), 1.0 / MOST_DEFLATED)
    within_memory(name, int(item.size) * item.dtype.itemsize)


def _elsewhere(name: bytes, how: str) -> InputError:
    remedy = "No file but the one that is named is read: write one that holds all of its data."
    return fault(
        f"/{name.decode(errors='replace')}" if name else "The dataset of a reference",
        "must be stored in its own file",
        how,
        remedy,
    )


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
    if item.dtype.kind == "f" and item.id.get_type() != h5py.h5t.py_create(item.dtype):  # of another bias or exponent
        raise fault(name, "must hold usual floating-point numbers", "others", "The file is damaged.")
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
