"""Nastran OUTPUT4 files (.op4), formatted or binary of either byte order, dense, sparse and sparse for big matrices.

A matrix is a header (columns, rows, form, type, name), a record for each column that is not empty, in their order, and a last
record with the number of columns plus 1, whose length need not be that of its content. A column record has its number, the row of
its first entry, and its length in words; row 0 says that the column comes in strings, each with a header of its own: L and row in
one word IS = row + 65536 (L + 1), or, for big matrices (negative number of rows), in two words L + 1 and row. Each length is
compared with what is there, and what a symmetric form says with the entries.
(NX Nastran DMAP Programmer's Guide, OUTPUT4.)
"""

import re
import struct
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path

import numpy as np
from scipy import sparse

from stickslip.model.readers.model import SYNONYMS, Content
from stickslip.model.readers.numbers import fixed_words, number_lines, within_memory
from stickslip.model.structure.matrices import symmetric_sparse
from stickslip.support.checks import Array, InputError, counted, fault

DOUBLE, COMPLEX = (2, 4), (3, 4)
"""Types: 1 and 2 are real, 1 and 3 single."""
TYPES = range(1, 5)
SYMMETRIC, FORMS = 6, range(1, 16)
NAME = re.compile(r"\w{1,8}", re.ASCII)
FORMAT = re.compile(r"(?:1P,)?(\d+)[ED](\d+)\.\d+", re.IGNORECASE)
USUAL_LAYOUT = 5, 16
"""Numbers of a line and letters of each where the header gives no format: 1P,5E16.9."""
HEADERS = ((8, 8, 8, 8), (16, 16, 8, 8), (16, 16, 16, 16))
"""Widths of the four numbers of a header."""
WIDTHS, STRING_WIDTHS = (8, 16), (12, 16)
"""Of those that announce a column, or a string in one word."""
STRING = 65536
"""The header of a string is its length times this plus its first row; a matrix of more rows has two words instead."""
LONG = 8
"""Bytes of a long word."""
MODEL = {name for names in SYNONYMS.values() for name in names}
"""Names of matrices of a model; others, such as marks between data blocks, may stand again."""


@dataclass
class Matrix:
    """A matrix as it is read: its header, and its strings of entries, column by column.

    long: whether a word has eight bytes and holds a double number, of which other words take two.
    strings: column, first row, entries of each; parts: their real numbers in order, two for a complex entry; column, end: where
    the last entry so far stands.
    """

    name: str
    columns: int
    rows: int
    form: int
    kind: int
    long: bool = False
    strings: list[tuple[int, int, int]] = field(default_factory=list)
    parts: list[Array] = field(default_factory=list)
    column: int = 0
    end: int = 0
    unit: int | None = None

    def __post_init__(self) -> None:
        if not NAME.fullmatch(self.name):
            raise fault("The name of a matrix", "must be one to eight letters or digits", self.name)
        if self.kind not in TYPES:
            raise fault(f"The type of {self.name}", f"must lie between {TYPES[0]} and {TYPES[-1]}", self.kind)
        if self.form not in FORMS:
            raise fault(f"The form of {self.name}", f"must lie between {FORMS[0]} and {FORMS[-1]}", self.form)

    @property
    def big(self) -> bool:
        return self.rows < 0 or self.rows >= STRING

    @property
    def reals(self) -> int:
        """Real numbers of an entry."""
        return 2 if self.kind in COMPLEX else 1

    @property
    def words(self) -> int:
        """Words of a real number."""
        return 2 if self.kind in DOUBLE and not self.long else 1

    def begin(self, column: int) -> bool:
        """Go on to a column; false where the matrix ends, one column beyond its last one."""
        if not self.column < column <= self.columns + 1:
            raise fault(f"A column of {self.name}", f"must have a number from {self.column + 1} to {self.columns + 1}", column)
        self.column, self.end = column, 0
        return column <= self.columns

    def add(self, row: int, words: int) -> int:
        """Note so many words of the column from `row` on, counted from 1, below those so far; returns their real numbers."""
        entries, left = divmod(words, self.words * self.reals)
        if entries < 1 or left:
            rule = f"must have {self.words * self.reals} words an entry"
            raise fault(f"Column {self.column} of {self.name}", rule, words)
        if not self.end < row <= abs(self.rows) + 1 - entries:
            rule = f"must have rows from {self.end + 1} to {abs(self.rows)}"
            raise fault(f"Column {self.column} of {self.name}", rule, [row, row + entries - 1])
        self.end = row + entries - 1
        self.strings.append((self.column, row, entries))
        return entries * self.reals

    def string(self, head: Sequence[int], left: int) -> tuple[int, int]:
        """The first row and the words of a string, by its header of one or two words, where its column has `left` words left."""
        words, row = (head[0] - 1, head[1]) if self.big else (head[0] // STRING - 1, head[0] % STRING)
        if words > left:
            raise fault(f"A string of {self.name}", f"must fit into the {left} words that its column has left", words)
        return row, words

    def assembled(self) -> sparse.coo_array:
        """The sparse matrix."""
        columns, rows, sizes = np.array(self.strings, dtype=np.int64).reshape(-1, 3).T
        first = np.cumsum(sizes) - sizes
        places = np.arange(sizes.sum()) + np.repeat(rows - 1 - first, sizes), np.repeat(columns - 1, sizes)
        values = np.concatenate(self.parts or [np.zeros(0)])
        matrix = sparse.coo_array(
            (values.view(complex) if self.kind in COMPLEX else values, places), (abs(self.rows), self.columns)
        )
        if self.form == SYMMETRIC:
            symmetric_sparse(f"{self.name}, of symmetric form,", matrix)
        return matrix


def read(path: Path) -> Content:
    """All matrices of the file."""
    within_memory(path.name, 12 * path.stat().st_size)
    content = path.read_bytes()
    # The first record of a binary file is a header of six words: its length shows the order of bytes, and how many a word has.
    first = content[:4]
    orders = ((order, word) for order in "<>" for word in (4, 8) if first == struct.pack(f"{order}i", 6 * word))
    binary = next(orders, None)
    matrices: dict[str, sparse.coo_array] = {}
    for matrix in _binary(content, *binary) if binary else _formatted(content):
        if matrix.name in matrices and matrix.name in MODEL:
            raise fault(f"Matrix {matrix.name}", "must occur once in the file", "repeated", "Are these two files in one?")
        matrices[matrix.name] = matrix.assembled()
    if not matrices:
        raise fault(path.name, "must hold matrices", "none")
    return Content(f"Nastran OUTPUT4, {'binary' if binary else 'formatted'}", matrices)


def _binary(content: bytes, order: str, word: int) -> Iterator[Matrix]:
    """The matrices of a binary file: each record of a column must have the length that it announces."""
    integer = np.dtype(f"{order}i{word}")
    records = _records(content, order)
    for header in records:
        if len(header) != 6 * word:
            raise fault("The header of a matrix", "must have six words", f"{len(header)} bytes")
        columns, rows, form, kind = np.frombuffer(header, integer, 4).tolist()
        matrix = Matrix("".join(header[4 * word :].decode("ascii", "replace").split()), columns, rows, form, kind, word == LONG)
        for record in records:
            column, row, length = np.frombuffer(record, integer, 3).tolist()
            if not matrix.begin(column):
                break
            if len(record) != (3 + length) * word:
                raise fault(f"Column {column} of {matrix.name}", f"must have {length} words", len(record) / word - 3)
            _take_column(matrix, record[3 * word :], row, integer)
        else:
            raise _cut_off(matrix)
        yield matrix


def _cut_off(matrix: Matrix) -> InputError:
    return fault(matrix.name, "must end with its last record", "cut off")


def _records(content: bytes, order: str) -> Iterator[bytes]:
    """The records of a Fortran file: each between two copies of its length."""
    start = 0
    while start < len(content):
        if start + 4 > len(content):
            raise fault("The file", "must end with a whole record", "cut off")
        (length,) = struct.unpack_from(f"{order}i", content, start)
        end = start + 4 + length
        if length < 0 or content[start : start + 4] != content[end : end + 4]:
            raise fault(f"The record at byte {start}", "must stand between two copies of its length", length)
        yield content[start + 4 : end]
        start = end + 4


def _take_column(matrix: Matrix, data: bytes, row: int, integer: np.dtype[np.int64]) -> None:
    """The values of a column, which is dense or comes in strings."""
    word, heads = integer.itemsize, 0 if row else 2 if matrix.big else 1
    number = np.dtype(f"{integer.str[0]}f{word * matrix.words}")
    start = 0
    while start < len(data):
        head = np.frombuffer(data[start : start + heads * word], integer, heads).tolist()
        start += heads * word
        left = (len(data) - start) // word
        first, words = matrix.string(head, left) if head else (row, left)
        matrix.parts.append(np.frombuffer(data, number, matrix.add(first, words), start).astype(float))
        start += words * word


def _formatted(content: bytes) -> Iterator[Matrix]:
    """The matrices of a text file, between which lines may be blank."""
    lines = deque(content.replace(b"\r\n", b"\n").split(b"\n"))
    while lines:
        header = lines.popleft()
        if header.strip():
            yield _formatted_matrix(header.decode("ascii", "replace"), lines)


def _formatted_matrix(header: str, lines: deque[bytes]) -> Matrix:
    """One matrix, whose lengths say what each line is."""
    widths = next((widths for widths in HEADERS if _integers(header, widths)), None)
    if widths is None:
        raise fault("The header of a matrix", "must hold four integers, a name and a format as 1P,3E23.16", header[:60])
    (columns, rows, form, kind), rest = _integers(header, widths), header[sum(widths) :]
    matrix = Matrix(rest[:8].strip(" \0"), columns, rows, form, kind)
    stated = FORMAT.match(rest[8:].strip())
    layout = (int(stated[1]), int(stated[2])) if stated else USUAL_LAYOUT
    values: list[bytes] = []
    while lines:
        column, row, words = _announced(matrix, lines, 3)
        if not matrix.begin(column):
            _values(matrix, lines, 1, layout)
            matrix.parts.append(number_lines(matrix.name, b"\n".join(values)).ravel())
            return matrix
        if row:  # a dense column; row 0 announces strings
            values += _values(matrix, lines, matrix.add(row, words * matrix.words // _unit(matrix, lines, words, layout)), layout)
        while not row and words > 0:
            head = _announced(matrix, lines, 2 if matrix.big else 1)
            words -= len(head)
            first, length = matrix.string(head, words)
            values += _values(matrix, lines, matrix.add(first, length), layout)
            words -= length
    raise _cut_off(matrix)


def _unit(matrix: Matrix, lines: deque[bytes], words: int, layout: tuple[int, int]) -> int:
    """What the length of a dense column of text counts, alike in all columns: words or, as Nastran has it, numbers (1)."""
    if matrix.unit is None:
        per_line, width = layout
        taken = [line.rstrip() for line in takewhile(lambda line: b"." in line, lines)]
        numbers = per_line * (len(taken) - 1) + -(-len(taken[-1]) // width) if taken and width else 0
        matrix.unit = 1 if numbers == words else matrix.words
    return matrix.unit


def _announced(matrix: Matrix, lines: deque[bytes], count: int) -> list[int]:
    """The integers of the next line, which announce a column or a string."""
    text = lines.popleft().decode("ascii", "replace").rstrip() if lines else ""
    fitting = (
        _integers(text, (width,) * count) for width in (STRING_WIDTHS if count == 1 else WIDTHS) if len(text) <= count * width
    )
    numbers = next(filter(None, fitting), None)
    if numbers is None:
        raise fault(
            f"A line of {matrix.name}", f"must hold {counted(count, 'integer')} that announce a column or a string", text[:60]
        )
    return numbers


def _values(matrix: Matrix, lines: deque[bytes], count: int, layout: tuple[int, int]) -> list[bytes]:
    """The next lines, as the words of so many numbers."""
    taken = [lines.popleft() for _ in range(min(len(lines), -(-count // layout[0]) if layout[0] else 0))]
    return fixed_words(f"Column {matrix.column} of {matrix.name}", taken, count, layout)


def _integers(line: str, widths: tuple[int, ...]) -> list[int]:
    """The integers in fields of these widths, or none."""
    ends = np.cumsum(widths).tolist()
    words = [line[end - width : end].strip() for end, width in zip(ends, widths, strict=True)]
    return [int(word) for word in words] if all(re.fullmatch(r"-?\d+", word) for word in words) else []
