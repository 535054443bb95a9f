"""MATLAB files of version 5 to 7: elements of type and length, matrices among them, perhaps deflated one by one.

The format is that of MathWorks' "MAT-File Format". It is read here and not by SciPy, whose compiled reader takes the process
down on damaged files. Numeric, logical and sparse arrays, text and cell arrays of text are read; everything else is passed over.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.checks import fault
from stickslip.models.limits import within_memory

KINDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8", 16: "u1", 17: "u2", 18: "u4"}
"""NumPy types of the types of elements."""
MATRIX, DEFLATED = 14, 15
CELL, TEXT, SPARSE = 1, 4, 5
NUMERIC = range(6, 16)
COMPLEX = 0x0800
HEADER = 128
PEEK = 512


@dataclass(frozen=True)
class Element:
    """An element: type, content, and where the next one begins."""

    kind: int
    content: bytes
    end: int


def read(content: bytes) -> dict[str, Any]:
    """Arrays by name: numbers as arrays, sparse matrices, text as rows of text, cells of text as a list."""
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if len(content) < HEADER or order is None:
        raise fault("A MATLAB file", "must be of version 5 to 7.3", "another", "save('model.mat', 'M', 'K') writes one.")
    found: dict[str, Any] = {}
    place = HEADER
    while place < len(content):
        element = _element(content, place, order, padded=False)
        place = element.end
        inner = _inflated(element.content, order) if element.kind == DEFLATED else element
        if inner.kind == MATRIX:
            name, value = _matrix(inner.content, order)
            if value is not None:
                found[name] = value
    return found


def _element(content: bytes, place: int, order: str, padded: bool = True) -> Element:
    """The element at a place; small ones have length and content in their first eight bytes."""
    if place + 8 > len(content):
        raise fault("The file", "must end with a whole element", "cut off")
    kind, size = struct.unpack_from(f"{order}II", content, place)
    if kind >> 16:
        kind, size = kind & 0xFFFF, kind >> 16
        if size > 4:
            raise fault("A small element", "must have at most 4 bytes", size)
        return Element(kind, content[place + 4 : place + 4 + size], place + 8)
    start, end = place + 8, place + 8 + size
    if end > len(content):
        raise fault("An element", f"must fit into the {len(content)} bytes round it", size, "The file was cut short.")
    return Element(kind, content[start:end], end + (-size % 8 if padded else 0))


def _inflated(content: bytes, order: str) -> Element:
    """The element that was deflated; as much is unpacked as its own length says."""
    head = zlib.decompressobj().decompress(content, 8)
    if len(head) < 8:
        raise fault("A deflated element", "must hold an element", "less")
    size = struct.unpack(f"{order}II", head)[1]
    within_memory("A deflated element", 3 * size)
    return _element(zlib.decompressobj().decompress(content, 8 + size), 0, order)


def _parts(content: bytes, order: str) -> Iterator[Element]:
    place = 0
    while place < len(content):
        element = _element(content, place, order)
        place = element.end
        yield element


def _matrix(content: bytes, order: str) -> tuple[str, Any]:
    """The name and the value of a matrix; None where it is nothing that a model holds."""
    parts = list(_parts(content, order))
    if len(parts) < 3:
        raise fault("A matrix", "must have flags, sizes and a name", f"{len(parts)} parts")
    flags = _numbers(parts[0], order)
    sizes = [int(size) for size in _numbers(parts[1], order)]
    name = parts[2].content.decode("ascii", "replace")
    kind, complex_ = int(flags[0]) & 0xFF, bool(int(flags[0]) & COMPLEX)
    if len(sizes) != 2 or min(sizes) < 0:
        return name, None
    data, shape = parts[3:], (sizes[0], sizes[1])
    if kind == SPARSE:
        return name, _sparse(name, [_numbers(part, order) for part in data], shape, complex_)
    if kind in NUMERIC:
        return name, _dense(name, [_numbers(part, order) for part in data[: 1 + complex_]], shape)
    if name == "dofs" and kind == CELL:
        return name, [_text(_matrix(part.content, order)[1]) for part in data if part.kind == MATRIX]
    if kind == TEXT:
        return name, _rows_of_text(name, _numbers(data[0], order) if data else np.zeros(0), shape)
    return name, None


def _numbers(element: Element, order: str) -> Any:
    if element.kind not in KINDS:
        raise fault("The type of numbers", "must be a known one", element.kind)
    kind = np.dtype(order + KINDS[element.kind])
    return np.frombuffer(element.content[: len(element.content) // kind.itemsize * kind.itemsize], kind)


def _dense(name: str, parts: list[Any], sizes: tuple[int, int]) -> Any:
    """Columns one after the other; the imaginary part follows."""
    for part in parts:
        if part.size != sizes[0] * sizes[1]:
            raise fault(f"{name}, entries,", f"must be {sizes[0]} x {sizes[1]}", part.size)
    if not parts:
        raise fault(name, "must hold numbers", "none")
    values = parts[0] if len(parts) == 1 else parts[0] + 1j * parts[1]
    return values.reshape(sizes, order="F")


def _sparse(name: str, parts: list[Any], sizes: tuple[int, int], complex_: bool) -> Any:
    """Rows, starts of the columns, and values, of which there may be room for more than are used."""
    if len(parts) < 3 + complex_:
        raise fault(name, "must have rows, columns and values", f"{len(parts)} parts")
    rows, starts = (part.astype(np.int64) for part in parts[:2])
    used = int(starts[-1]) if starts.size else 0
    values = parts[2][:used] + 1j * parts[3][:used] if complex_ else parts[2][:used]
    matrix = sparse.csc_array((values, rows[:used], starts), sizes)
    matrix.check_format(full_check=True)
    return matrix


def _rows_of_text(name: str, codes: Any, sizes: tuple[int, int]) -> Any:
    if codes.size != sizes[0] * sizes[1]:
        raise fault(f"{name}, characters,", f"must be {sizes[0]} x {sizes[1]}", codes.size)
    return np.array(["".join(map(chr, row)) for row in codes.reshape(sizes, order="F").tolist()], dtype=np.str_)


def _text(value: Any) -> str:
    """The text of a cell."""
    return str(value[0]) if isinstance(value, np.ndarray) and value.dtype.kind == "U" and value.size else ""
