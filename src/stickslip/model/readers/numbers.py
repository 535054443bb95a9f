"""Numbers in text files of unknown origin: each is a whole token, or the file is refused. Compiled code reads all lines at once.

A header is accepted only if file size and memory support it, a last line only if it is whole.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.support import machine
from stickslip.support.checks import Array, Index, fault

DIGITS = 18
"""Digits of a whole number that a machine's integer holds."""
MOST_DEFLATED = 1100
"""No deflate stream unpacks to more than 1032 times its size."""
CUT_SHORT = "The file was cut short: copy it again."
EMPTY_ROWS = 1000
"""Rows that a matrix may have beyond two for each of its entries."""


PACKED = {".gz": "gunzip", ".zip": "unzip", ".bz2": "bunzip2", ".xz": "unxz", ".zst": "unzstd", ".7z": "7z x", ".tar": "tar xf"}
"""Endings of packed files, and what unpacks them."""


def refuse_packed(what: str, path: Path) -> None:
    """Refuse a packed file: readers look for other files of the model beside it, by its name."""
    tool = PACKED.get(path.suffix.lower())
    if tool:
        raise fault(what, "must be unpacked", path.name, f"Unpack it first, with {tool}, beside the other files of the model.")


def memory() -> int:
    """Half of the machine's memory, bytes: more is not spent on one model."""
    return machine.memory() // 2


def refuse_utf_16(path: Path) -> None:
    """Refuse a text in UTF-16, as some editors of Windows save it: every other byte of it is zero."""
    with path.open("rb") as file:
        start = file.read(64)
    if start.startswith((b"\xff\xfe", b"\xfe\xff")) or (len(start) > 8 and not any(start[1::2]) and start[::2].isascii()):
        raise fault(path.name, "must be a text in ASCII or UTF-8", "UTF-16", "Save it again in that encoding.")


def refuse_cut(path: Path, remedy: str = CUT_SHORT) -> None:
    """Refuse a file of lines, not empty, whose last one has no end: a number there may have lost digits."""
    refuse_utf_16(path)
    with path.open("rb") as file:
        file.seek(-1, 2)
        if file.read() != b"\n":
            raise fault(path.name, "must end with a whole line", "cut off", remedy)


def within_file(what: str, claimed: int, file_size: int, smallest: float) -> None:
    """Refuse a header that claims more entries than the file can hold at `smallest` bytes an entry."""
    if claimed < 0 or claimed * smallest > file_size:
        raise fault(what, f"must fit into a file of {file_size} bytes", claimed, "The file is truncated, or its header is wrong.")


def within_memory(what: str, needed: int) -> None:
    """Refuse what would need more than half of the machine's memory."""
    if needed > memory():
        raise fault(what, f"must fit into {memory() / 2**30:.1f} GiB, half of the memory", f"{needed / 2**30:.1f} GiB")


def rows_with_entries(what: str, rows: int, entries: int) -> None:
    """Refuse a matrix with far more rows than entries: its size is not to be believed."""
    if rows > 2 * entries + EMPTY_ROWS:
        raise fault(f"The size of {what}", f"must go with its {entries} entries", rows, "Is its header right?")


WITHOUT_LETTER = re.compile(r"((?:\d+\.\d*|\.\d+))([+-]\d+)(?=\s|$)", re.MULTILINE)
"""A number whose exponent has a sign alone, as Fortran writes 1.5-103 where three digits leave no place for the letter."""

NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?", re.ASCII)
"""A number as a whole word; Python's float takes more, such as 1_0, infinity and digits of other scripts."""

COMMENT = re.compile(rb"^[ \t]*[*#].*$", re.MULTILINE)


def table(path: Path, columns: int | None) -> Array:
    """Every line of a text file as `columns` numbers, split by blanks or commas, (lines, columns); None: as many as there are.

    Lines that begin with * or # are comments.
    """
    within_memory(path.name, 12 * path.stat().st_size)
    refuse_utf_16(path)
    content = COMMENT.sub(b"", path.read_bytes()).replace(b",", b" ")
    rows = number_lines(path.name, content)
    if rows.size == 0 or (columns is not None and rows.shape[1] != columns):
        raise fault(
            f"Each line of {path.name}", f"must have {columns or 'several'} numbers", rows.shape[1] if rows.size else "empty"
        )
    return rows


def number_lines(what: str, content: bytes) -> Array:
    """Lines of numbers split by blanks, (lines, numbers); blank lines are passed over.

    Exponents have an E, a D or, with a decimal point before them, a sign alone, as Fortran writes them. What is no number as a
    whole, such as 2000,5 or 20_00.5 or 0x7d0, is refused, and so are lines of different lengths.
    """
    if not content or content.isspace():
        return np.zeros((0, 0))
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    # Fortran's D is an E to NumPy; no other letter of a number is changed, and words stay no numbers.
    text = content.translate(bytes.maketrans(b"Dd", b"Ee")).decode("ascii", "replace")
    try:
        try:
            return np.loadtxt(text.split("\n"), dtype=float, ndmin=2, comments=None)
        except ValueError:
            return np.loadtxt(WITHOUT_LETTER.sub(r"\1E\2", text).split("\n"), dtype=float, ndmin=2, comments=None)
    except ValueError as error:
        raise fault(f"Each line of {what}", "must hold as many numbers as the first", str(error).partition(";")[0]) from None


def number_of(word: str) -> float | None:
    """The number that a word is, None where it is none; exponents as `number_lines` takes them."""
    text = WITHOUT_LETTER.sub(r"\1E\2", word.strip())
    return float(text.upper().replace("D", "E")) if NUMBER.fullmatch(text) else None


def coordinate(word: str) -> float:
    """The number of a field of a deck, of which an empty one is 0."""
    value = number_of(word) if word.strip() else 0.0
    if value is None:
        raise fault("A field", "must be a number", word[:20])
    return value


def integer(word: str) -> int:
    """The whole number of a field."""
    if not re.fullmatch(rf"[+-]?\d{{1,{DIGITS}}}", word.strip(), re.ASCII):
        raise fault("A field", "must be a whole number", word[:20])
    return int(word)


def fixed_words(what: str, lines: Sequence[bytes], count: int, layout: tuple[int, int], *, real: bool = True) -> list[bytes]:
    """`count` numbers, each as a word, from fields of one width, between which there need be no blanks.

    layout: fields of a line and letters of a field; every line but the last is full. Where blanks part as many numbers, the width
    may be another one, as SciPy writes it. Real numbers have a decimal point, others none.
    """
    per_line, width = layout
    kind = "with a decimal point" if real else "without a decimal point"
    rule = f"must be {count} numbers {kind}, {per_line} a line, in fields of {width} letters"
    if per_line < 1 or width < 1 or len(lines) != -(-count // per_line):
        raise fault(what, rule, f"{len(lines)} lines")
    words: list[bytes] = []
    for line, first in zip(lines, range(0, count, per_line), strict=True):
        number = min(per_line, count - first)
        own = line.split()
        if len(own) != number:
            own = [line[start : start + width].strip() for start in range(0, len(line.rstrip()), width)]
        if len(own) != number or any(word.count(b".") != real or len(word.split()) != 1 for word in own):
            raise fault(what, rule, line.decode("ascii", "replace")[:60])
        words += own
    return words


def whole(what: str, values: Array, lowest: int, highest: int | None = None) -> Index:
    """Numbers that stand for rows or nodes, as integers."""
    outside = (values < lowest) | (values > (2**31 - 1 if highest is None else highest)) | (values != np.floor(values))
    if np.any(outside):
        limit = "" if highest is None else f" up to {highest}"
        raise fault(what, f"must be whole numbers from {lowest}{limit}", float(values[outside].ravel()[0]))
    return np.asarray(values.astype(np.int64))


def compressed_columns(what: str, values: Any, indices: Any, starts: Any, shape: tuple[int, int]) -> sparse.csc_array:
    """The matrix of its values column by column, their rows (`indices`) and the place where each column starts, from 0.

    SciPy does not look at rows and starts where the last start is 0, and its compiled code trusts them.
    """
    rows, columns = shape
    shapes_fit = values.ndim == indices.ndim == 1 and starts.shape == (columns + 1,)
    if not shapes_fit or indices.dtype.kind not in "iu" or starts.dtype.kind not in "iu":
        raise fault(what, f"must have {columns + 1} starts of columns, and rows in whole numbers", [starts.shape, indices.dtype])
    if starts[0] != 0 or np.any(starts[1:] < starts[:-1]) or not starts[-1] == values.size == indices.size:
        counts = [int(starts[-1]), values.size, indices.size]
        raise fault(what, "must have starts of columns that rise to the number of its values and rows", counts)
    if np.any((indices < 0) | (indices >= rows)):
        raise fault(what, f"must have entries in rows up to {rows}", int(indices.max()) + 1)
    return sparse.csc_array((values, indices.astype(np.int64), starts.astype(np.int64)), shape)


def triplets(what: str, rows: Index, columns: Index, values: Array, size: int) -> sparse.csc_array:
    """The matrix (size, size) of entries by row and column, both counted from 0; none stands twice."""
    rows_with_entries(what, size, len(values))
    matrix = sparse.coo_array((values, (rows, columns)), (size, size)).tocsc()
    if matrix.nnz < len(values):
        places, counts = np.unique(np.column_stack([rows, columns]), axis=0, return_counts=True)
        row, column = (places[counts > 1][0] + 1).tolist()
        raise fault(what, "must hold each entry once", f"row {row}, column {column} more than once", "Was it put together?")
    return matrix
