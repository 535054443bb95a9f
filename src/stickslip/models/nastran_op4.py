"""Nastran OUTPUT4 files (.op4), formatted or binary of either byte order, dense, sparse and sparse for big matrices.

A matrix is a header (columns, rows, form, type, name), a record for each column that is not empty, and a last record with a
column number beyond the last, whose length need not be that of its content. A column record has its number, the row of its
first entry, and its length in words; row 0 says that the column comes in strings, each with a header of its own: L and row in
one word IS = row + 65536 (L + 1), or, for big matrices (negative number of rows), in two words L + 1 and row.
(NX Nastran DMAP Programmer's Guide, OUTPUT4.)
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import sparse

from stickslip.checks import Array, fault
from stickslip.models.content import Content
from stickslip.models.limits import within_memory

WORDS = {1: 1, 2: 2, 3: 2, 4: 4}
"""Words of an entry of type real single, real double, complex single, complex double."""
COMPLEX = (3, 4)
FORMAT = re.compile(r"(\d+)[EDFG](\d+)\.\d+", re.IGNORECASE)
USUAL_WIDTH = 16
"""Of a number where the header gives no format: 1P,5E16.9."""
STRING = 65536
"""The header of a string is its length times this plus its first row; a matrix of more rows has two words instead."""


@dataclass
class Matrix:
    """A matrix as it is read: its header, and entries column by column."""

    name: str
    columns: int
    rows: int
    kind: int
    entries: list[tuple[int, int, Array]] = field(default_factory=list)

    @property
    def big(self) -> bool:
        return self.rows < 0 or self.rows >= STRING

    def add(self, column: int, row: int, values: Array) -> None:
        """Values from `row` downwards, both counted from 1."""
        if column < 1 or row < 1 or row - 1 + values.size > abs(self.rows):
            raise fault(f"Column {column} of {self.name}", f"must have rows from 1 to {abs(self.rows)}", (row, values.size))
        self.entries.append((column, row, values))

    def assembled(self) -> sparse.coo_array:
        """The sparse matrix."""
        sizes = np.array([values.size for _, _, values in self.entries], dtype=np.int64)
        columns = np.repeat([column - 1 for column, _, _ in self.entries], sizes)
        rows = np.concatenate(
            [np.arange(row - 1, row - 1 + values.size) for _, row, values in self.entries] or [np.zeros(0, int)]
        )
        values = np.concatenate([values for _, _, values in self.entries] or [np.zeros(0)])
        return sparse.coo_array((values, (rows, columns)), (abs(self.rows), self.columns))


def read(path: Path) -> Content:
    """All matrices of the file."""
    within_memory(path.name, 12 * path.stat().st_size)
    content = path.read_bytes()
    order = _byte_order(content)
    found = list(_formatted(content.decode("ascii", "replace")) if order is None else _binary(content, *order))
    if not found:
        raise fault(path.name, "must hold matrices", "none")
    form = "formatted" if order is None else "binary"
    return Content(f"Nastran OUTPUT4, {form}", {matrix.name: matrix.assembled() for matrix in found})


def _header(name: str, columns: int, rows: int, kind: int) -> Matrix:
    if kind not in WORDS:
        raise fault(f"The type of {name}", "must lie between 1 and 4", kind)
    return Matrix(name, columns, rows, kind)


def _byte_order(content: bytes) -> tuple[str, int] | None:
    """Byte order and bytes of a word, by the length of the first record; None where the file is text."""
    for order in "<>":
        for word in (4, 8):
            if len(content) >= 4 and struct.unpack_from(f"{order}i", content)[0] == 6 * word:
                return order, word
    return None


def _binary(content: bytes, order: str, word: int) -> Iterator[Matrix]:
    integer = np.dtype(f"{order}i{word}")
    matrix: Matrix | None = None
    for record in _records(content, order):
        if matrix is None:
            columns, rows, _, kind = np.frombuffer(record, integer, 4).tolist()
            matrix = _header(_name(record[4 * word :]), columns, rows, kind)
            continue
        column, row, length = np.frombuffer(record, integer, 3).tolist()
        if column > matrix.columns:
            yield matrix
            matrix = None
            continue
        data = record[3 * word : (3 + length) * word]
        if length < 0 or len(data) != length * word:
            raise fault(f"Column {column} of {matrix.name}", f"must have {length} words", len(data) // word)
        for first, values in _strings(matrix, data, row, integer):
            matrix.add(column, first, values)
    if matrix is not None:
        raise fault(matrix.name, "must end with its last record", "cut off")


def _name(content: bytes) -> str:
    """The name in two words: those of eight bytes hold four letters each and blanks."""
    return "".join(content.decode("ascii", "replace").split())


def _records(content: bytes, order: str) -> Iterator[bytes]:
    """The records of a Fortran file: each between two copies of its length."""
    place = 0
    while place < len(content):
        if place + 4 > len(content):
            raise fault("The file", "must end with a whole record", "cut off")
        (length,) = struct.unpack_from(f"{order}i", content, place)
        end = place + 4 + length
        if length < 0 or content[place : place + 4] != content[end : end + 4]:
            raise fault(f"The record at byte {place}", "must stand between two copies of its length", length)
        yield content[place + 4 : end]
        place = end + 4


def _strings(matrix: Matrix, data: bytes, row: int, integer: np.dtype[np.int64]) -> Iterator[tuple[int, Array]]:
    """The first row and the values of each string of a column; a dense column is one string."""
    word = integer.itemsize
    if row > 0:
        yield row, _values(data, matrix.kind, integer)
        return
    place, heads = 0, 2 if matrix.big else 1
    while place < len(data):
        head = np.frombuffer(data[place : place + heads * word], integer, heads).tolist()
        words, first = (head[0] - 1, head[1]) if matrix.big else (head[0] // STRING - 1, head[0] % STRING)
        start, place = place + heads * word, place + (heads + words) * word
        if words < 1 or place > len(data):
            raise fault(f"A string of {matrix.name}", "must fit into its column", words)
        yield first, _values(data[start:place], matrix.kind, integer)


def _values(data: bytes, kind: int, integer: np.dtype[np.int64]) -> Array:
    """Numbers of a type: single ones in a word, double ones in two of four bytes or one of eight."""
    size = 8 if integer.itemsize == 8 or kind in (2, 4) else 4
    numbers = np.frombuffer(data, np.dtype(f"{integer.str[0]}f{size}")).astype(float)
    return numbers.view(complex) if kind in COMPLEX else numbers


def _formatted(text: str) -> Iterator[Matrix]:
    lines = iter(text.replace("\r\n", "\n").split("\n"))
    for line in lines:
        if line.strip():
            yield _formatted_matrix(line, lines)


def _formatted_matrix(header: str, lines: Iterator[str]) -> Matrix:
    """One matrix. Lines with a decimal point hold values, three integers begin a column, one or two a string."""
    width = 8 if _integers(header[:32], 8) is not None else 16
    counts = _integers(header[: 4 * width], width)
    if counts is None or len(counts) != 4:
        raise fault("The header of a matrix", "must hold four integers, a name and a format as 1P,3E23.16", header[:60])
    matrix = _header(header[4 * width : 4 * width + 8].strip(), counts[0], counts[1], counts[3])
    layout = FORMAT.search(header[4 * width + 8 :])
    number_width = int(layout[2]) if layout else USUAL_WIDTH
    column, row, values = 0, 0, []
    for line in lines:
        if "." in line:
            values += _numbers(line, number_width)
            continue
        _add(matrix, column, row, values)
        column, row, values = *_place(matrix, line, width, column), []
        if column > matrix.columns:
            next(lines, None)
            return matrix
    raise fault(matrix.name, "must end with its last record", "cut off")


def _place(matrix: Matrix, line: str, width: int, column: int) -> tuple[int, int]:
    """The column and row that a line of integers announces; row 0 where strings follow."""
    if not matrix.big and re.fullmatch(r" *\d+ *", line):
        return column, int(line) % STRING
    match _integers(line, width):
        case [number, row, _]:
            return number, row
        case [_, row] if matrix.big:
            return column, row
    raise fault(f"A line of {matrix.name}", "must announce a column or a string", line[:60])


def _add(matrix: Matrix, column: int, row: int, values: list[float]) -> None:
    if values:
        numbers = np.array(values)
        matrix.add(column, row, numbers.view(complex) if matrix.kind in COMPLEX else numbers)


def _integers(line: str, width: int) -> list[int] | None:
    """The integers in fields of `width`, or None."""
    words = [line[place : place + width].strip() for place in range(0, len(line.rstrip()), width)]
    return [int(word) for word in words] if words and all(re.fullmatch(r"-?\d+", word) for word in words) else None


def _numbers(line: str, width: int) -> list[float]:
    """The numbers in fields of `width`, which need no blank between them."""
    if width == 0:
        raise fault("The width of a number", "must be above 0", width)
    return [float(line[place : place + width].upper().replace("D", "E")) for place in range(0, len(line.rstrip()), width)]
