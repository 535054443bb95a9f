"""MATLAB files: version 4 to 7, read by SciPy, and 7.3, which is HDF5 with arrays columns first.

M, K, C dense or sparse, `dofs`, `nodes`: numeric, logical and sparse arrays, text and a cell array `dofs` of names are read, also
as fields of a struct, rom.M; everything else is passed over.

HDF5 files of unknown origin: what would have other files of the machine read, or more than a file can hold, is refused before it
is read.
"""

import json
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io

from stickslip.model.readers.model import Content
from stickslip.model.readers.named_rows import from_tables
from stickslip.model.readers.numbers import MOST_DEFLATED, compressed_columns, rows_with_entries, within_file, within_memory
from stickslip.model.readers.process import arrays_of
from stickslip.support.checks import InputError, fault
from stickslip.support.late import h5py

HDF5 = b"\x89HDF\r\n\x1a\n"
OCTAVE = b"# Created by Octave"
USER_BLOCKS = (0, 512, 1024, 2048)
"""Bytes of the text that may stand before an HDF5 file."""


def read(path: Path) -> Content:
    """The numeric arrays of a MATLAB file, of whatever version; `dofs` and `nodes` may stand in its only struct that has them."""
    (tables,) = arrays_of_several([path])
    objects = [str(name) for name in tables.pop(OBJECT_NAMES, ())]
    square = [value for value in tables.values() if np.ndim(value) == 2 and value.shape[0] == value.shape[1]]
    if objects and len(square) < len("MK"):
        remedy = "Save M and K as arrays: M = ...; K = ...; save('model.mat', 'M', 'K')."
        raise fault("A MATLAB file", "must hold arrays; objects are not read", ", ".join(objects), remedy)
    for name in ("dofs", "nodes"):
        inner = [key for key in tables if key.endswith(f".{name}")]
        if name not in tables and len(inner) == 1:
            tables[name] = tables.pop(inner[0])
    return from_tables("MATLAB 7.3 file" if _is_hdf5(path) else "MATLAB file", tables)


def arrays_of_several(paths: Sequence[Path]) -> list[dict[str, Any]]:
    """The arrays of each of several files by name, those of structs as "FRF.f", read in one process of their own: to start one
    for each takes longer than to read it."""
    with tempfile.TemporaryDirectory() as folder:
        listed = Path(folder) / "files.json"
        listed.write_text(json.dumps([str(path.absolute()) for path in paths]), encoding="utf-8")
        found = arrays_of(listed, __name__)
    own: list[dict[str, Any]] = [{} for _ in paths]
    for key, values in found.items():
        number, name = key.split(":", 1)
        own[int(number)][name] = values
    return own


def arrays(path: Path) -> dict[str, Any]:
    """The arrays of all files that the file at `path` lists in JSON, by number of the file and name: "0:hyst"."""
    numbered: dict[str, Any] = {}
    names = json.loads(path.read_text(encoding="utf-8"))
    for number, name in enumerate(names):
        try:
            own = _arrays_of_hdf5(Path(name)) if _is_hdf5(Path(name)) else _arrays_of_version_5(Path(name))
        except Exception as error:  # the libraries raise whatever a damaged file leads them to
            if len(names) == 1:  # which needs no name
                raise
            what = str(error) if isinstance(error, InputError) else f"The file is damaged ({str(error)[:200]})."
            raise InputError(f"{Path(name).name}: {what}") from None
        numbered |= {f"{number}:{key}": value for key, value in own.items()}
    return numbered


def _is_hdf5(path: Path) -> bool:
    """Whether a file is of version 7.3."""
    with path.open("rb") as file:
        start = file.read(USER_BLOCKS[-1] + len(HDF5))
    if start.startswith(OCTAVE):
        raise InputError("A MATLAB file must be binary, but this is a text file of Octave. Save it again: save -v7 model.mat M K")
    return any(start[offset : offset + len(HDF5)] == HDF5 for offset in USER_BLOCKS)


OBJECTS, WORKSPACE = ("object", "opaque", "function"), "__function_workspace__"
"""Classes of what is no array, and the variable in which MATLAB keeps their content."""
OBJECT_NAMES = "__objects__"
"""Among the arrays, the names of the objects, which are not read."""
DEEPEST = 4
"""Structs in structs."""
NUMBERS = ("double", "single", "logical", "sparse", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)))
"""MATLAB's classes of numbers."""


def _arrays_of_version_5(path: Path) -> dict[str, Any]:
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


def _arrays_of_hdf5(path: Path) -> dict[str, Any]:
    """The same of version 7.3."""
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
