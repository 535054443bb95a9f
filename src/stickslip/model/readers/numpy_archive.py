"""NumPy archives (.npz): M, K, C, and if there are any `dofs` (names) and `nodes` (rows id, x, y, z). No pickle.

A file that `scipy.sparse.save_npz` wrote holds one matrix; it is read together with the file of the other one.
"""

import zipfile
from math import prod
from os import SEEK_CUR
from pathlib import Path
from typing import Any

from numpy.lib import format as npy
from scipy import sparse

from stickslip.model.readers.model import Content
from stickslip.model.readers.named_rows import from_tables
from stickslip.model.readers.numbers import MOST_DEFLATED, compressed_columns, within_file, within_memory
from stickslip.support.checks import Array, fault

PLAIN, MOST_UNPACKED = 1 << 28, 100
"""Bytes up to which an array may be packed however well, and how many times its packed size a larger one may have."""


def read(path: Path) -> Content:
    """Every array of the archive; those that hold no matrix only by name."""
    members = arrays(path)
    if {"format", "data", "shape"} <= set(members):
        return Content("scipy.sparse archive", {"": _sparse(members)})
    return from_tables("NumPy archive", members)


def arrays(path: Path) -> dict[str, Any]:
    """The arrays by name, each checked against the bytes that are there."""
    try:
        archive = zipfile.ZipFile(path)
    except zipfile.BadZipFile as error:
        raise fault("A .npz file", "must be a .npz archive", f"{path.name}: {error}", "Write it with numpy.savez.") from None
    with archive:
        members = {member.filename.removesuffix(".npy"): member for member in archive.infolist()}
        if len(members) < len(archive.infolist()):
            raise fault("A .npz file", "must hold each array once", f"{path.name} holds one again")
        return {name: _array(archive, member) for name, member in members.items()}


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Any:
    """One array, whose header must agree with the bytes that are there."""
    within_file(f"{member.filename}, bytes", member.file_size, member.compress_size, 1.0 / MOST_DEFLATED)
    within_memory(member.filename, member.file_size)
    if member.file_size > max(PLAIN, MOST_UNPACKED * member.compress_size):
        raise fault(
            member.filename,
            f"must unpack to at most {MOST_UNPACKED} times its size",
            f"{member.file_size / max(member.compress_size, 1):.0f} times",
            "Keep a matrix of so many zeros sparse: scipy.sparse.save_npz.",
        )
    with archive.open(member) as file:
        read_header = npy.read_array_header_1_0 if npy.read_magic(file) == (1, 0) else npy.read_array_header_2_0
        shape, _, kind = read_header(file)
        claimed = prod(map(int, shape))
        behind = member.file_size - file.seek(0, SEEK_CUR)
    if kind.hasobject:
        raise fault(
            member.filename, "must hold numbers or text", "Python objects", "They are never unpickled (allow_pickle=False)."
        )
    if claimed * kind.itemsize != behind:
        raise fault(
            f"{member.filename}, entries", f"must fill the {behind} bytes behind its header", claimed, "Its header is wrong."
        )
    with archive.open(member) as file:
        return npy.read_array(file, allow_pickle=False)


def _sparse(arrays: dict[str, Any]) -> Any:
    """The matrix of a file written by scipy.sparse.save_npz."""
    kind = arrays["format"].item()
    name = kind.decode() if isinstance(kind, bytes) else str(kind)
    rows, columns = (int(length) for length in arrays["shape"])
    shape = rows, columns
    data: Array = arrays["data"]
    if name == "coo":
        return sparse.coo_array((data, (arrays["row"], arrays["col"])), shape)
    if name not in ("csc", "csr"):
        raise fault("The sparse format", "must be coo, csc or csr", name, "Convert it with .tocsc().")
    shape = shape if name == "csc" else shape[::-1]
    matrix = compressed_columns("A sparse matrix", data, arrays["indices"], arrays["indptr"], shape)
    matrix.sum_duplicates()
    if matrix.nnz < data.size:
        raise fault("A sparse matrix", "must hold each entry once", f"{matrix.nnz} entries of {data.size} values")
    return matrix if name == "csc" else matrix.T
