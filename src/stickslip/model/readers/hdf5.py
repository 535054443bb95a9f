"""HDF5 files of unknown origin: what would have other files of the machine read, or more than a file can hold, is refused
before it is read."""

from __future__ import annotations

from typing import Any

from stickslip.model.readers.limits import MOST_DEFLATED, within_file, within_memory
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


def refuse_odd_numbers(name: str, item: Any) -> None:
    """Refuse an `h5py.Dataset` of real numbers with another bias or other bits of the exponent than every processor's."""
    if item.dtype.kind == "f" and item.id.get_type() != h5py.h5t.py_create(item.dtype):
        raise fault(name, "must hold usual floating-point numbers", "others", "The file is damaged.")


def _elsewhere(name: bytes, how: str) -> InputError:
    remedy = "No file but the one that is named is read: write one that holds all of its data."
    return fault(
        f"/{name.decode(errors='replace')}" if name else "The dataset of a reference",
        "must be stored in its own file",
        how,
        remedy,
    )
