"""Files of one matrix each: Matrix Market (.mtx, .mm), and Harwell-Boeing and Rutherford-Boeing (.rb, .rsa, .rua, .hb; .matrix of
Ansys).

A Matrix Market file has it in coordinates or as an array, general or one triangle. The format is that of Boisvert, Pozo and
Remington (NISTIR 5935, 1996). It says nothing of entries that stand twice: they add up, as SciPy and others read and write them,
and a note says so.

Lines of Fortran make a Harwell-Boeing file: a title; the numbers of lines in all and of each part; type, rows, columns, entries;
the formats of the parts; then where each column starts, the rows of the entries, and their values. A right-hand side adds a line
to the header and lines at the end, which are passed over. (Duff, Grimes and Lewis, Users' Guide for the Harwell-Boeing Sparse
Matrix Collection, 1992.) HBMAT of Ansys writes NAME.mapping beside: number, node and direction of each row. (Ansys Command
Reference, HBMAT.)
"""

import re
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.readers.model import Content, dof
from stickslip.model.readers.numbers import compressed_columns, fixed_words, number_lines, rows_with_entries, whole, within_memory
from stickslip.model.structure.matrices import both_triangles
from stickslip.support.checks import Array, counted, fault

START = b"%%MatrixMarket"
FIELDS = ("real", "integer", "complex")
SYMMETRIES = ("general", "symmetric", "skew-symmetric", "hermitian")
COMMENTS_AND_SIZE = re.compile(rb"(?:[ \t]*(?:%[^\n]*)?\r?\n)*([^\n]*)\n?")


def read_matrix_market(path: Path) -> Content:
    """The matrix, with both triangles."""
    within_memory(path.name, 12 * path.stat().st_size)
    head, _, body = path.read_bytes().partition(b"\n")
    first_line = head[:400].decode("ascii", "replace").strip()
    words = first_line.lower().split()[1:]
    known = (("matrix",), ("coordinate", "array"), FIELDS, SYMMETRIES)
    if len(words) != len(known) or not all(word in names for word, names in zip(words, known, strict=True)):
        rule = f"must say matrix, coordinate or array, {', '.join(FIELDS)}, and {', '.join(SYMMETRIES)}"
        raise fault(f"The first line of {path.name}", rule, first_line[:80])
    _, layout, field, symmetry = words
    line = COMMENTS_AND_SIZE.match(body)
    sizes = line[1].decode("ascii", "replace").split() if line else []
    coordinates = layout == "coordinate"
    if len(sizes) != (3 if coordinates else 2) or not all(re.fullmatch(r"\d{1,18}", size) for size in sizes):
        what = "rows, columns and entries" if coordinates else "rows, columns"
        raise fault(f"The line of sizes of {path.name}", f"must hold the numbers of {what}", " ".join(sizes)[:60])
    rows, columns, *entries = map(int, sizes)
    if symmetry != "general" and rows != columns:
        raise fault(f"A {symmetry} matrix", "must be square", (rows, columns))
    triangle = rows * (rows - 1) // 2 if symmetry == "skew-symmetric" else rows * (rows + 1) // 2
    count = entries[0] if coordinates else rows * columns if symmetry == "general" else triangle
    width = (2 if coordinates else 0) + (2 if field == "complex" else 1)
    numbers = number_lines(path.name, body[line.end() if line else 0 :])
    if numbers.shape != (count, width) and (count or numbers.size):
        raise fault(path.name, f"must hold {count} lines of {counted(width, 'number')}, as it says", numbers.shape)
    numbers = numbers.reshape(count, width)
    values = numbers[:, -2] + 1j * numbers[:, -1] if field == "complex" else numbers[:, -1]
    if field == "integer" and np.any(values != np.floor(values)):
        raise fault(f"{path.name}, values,", "must be whole numbers, as its first line says", values[values % 1 != 0][0])
    if not coordinates:
        return Content("Matrix Market", {"": _array(values, rows, columns, symmetry)})
    rows_with_entries(path.name, max(rows, columns), count)
    at = [whole(f"{path.name}, rows and columns,", numbers[:, k], 1, size) - 1 for k, size in enumerate((rows, columns))]
    stored = sparse.coo_array((values, tuple(at)), (rows, columns)).tocsc()
    again = count - stored.nnz
    notes = (f"{path.name} repeats places of entries {again} times: the entries of one place are added up.",) if again else ()
    return Content("Matrix Market", {"": _filled(stored, symmetry)}, notes=notes)


def _array(values: Array, rows: int, columns: int, symmetry: str) -> Array:
    """The dense matrix of values that stand column by column."""
    if symmetry == "general":
        return values.reshape(columns, rows).T
    skew = symmetry == "skew-symmetric"
    upper = np.zeros((rows, rows), values.dtype)
    upper[np.triu_indices(rows, int(skew))] = values  # rows of the upper triangle are columns of the lower one
    lower = upper.T
    if skew:
        return np.asarray(lower - upper)
    return np.asarray(lower + np.triu(upper.conj() if symmetry == "hermitian" else upper, 1))


def _filled(matrix: Any, symmetry: str) -> Any:
    """Both triangles of a matrix that stores one."""
    if symmetry == "general":
        return matrix
    if sparse.tril(matrix, -1).nnz and sparse.triu(matrix, 1).nnz:
        raise fault(f"A {symmetry} matrix", "must store one triangle", "both", "Write `general` in its first line.")
    if symmetry == "skew-symmetric" and np.any(matrix.diagonal()):
        raise fault("A skew-symmetric matrix", "must have no diagonal", "one", "Is it symmetric?")
    other = matrix.conj().T if symmetry == "hermitian" else matrix.T
    whole_matrix = sparse.csc_array(matrix - other if symmetry == "skew-symmetric" else matrix + other)
    return whole_matrix - sparse.diags_array(matrix.diagonal()) if symmetry != "skew-symmetric" else whole_matrix


FORMAT = re.compile(r"\((?:\d*P,?)?(\d*)([IEDFG])(\d+)(?:\.\d+)?(?:E\d+)?\)")
"""Fields of a line, kind of number, letters of a field: (3E25.16), (1P,4D20.12), (10I8)."""
REAL = "EDFG"
PARTS = ("starts of columns", "rows of entries", "values")
LABELS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}
"""Directions as Ansys names them."""
HEADER = 4
"""Lines before the matrix; a fifth one describes a right-hand side."""


def read_harwell_boeing(path: Path) -> Content:
    """An assembled matrix; of symmetric ones (second letter S of the type) the file holds one triangle."""
    within_memory(path.name, 12 * path.stat().st_size)
    lines = path.read_bytes().rstrip().splitlines()
    if len(lines) <= HEADER:
        raise fault(path.name, f"must hold {HEADER} lines before its matrix", len(lines))
    total, *parts = _counts(f"{path.name}, line 2,", lines[1], 4)
    rows, columns, entries, *elements = _counts(f"{path.name}, line 3 after its type,", lines[2][3:], 3)
    kind, right_hand_side = lines[2][:3].decode("ascii", "replace").upper(), sum(parts[3:])
    if kind not in ("RUA", "RSA") or any(elements):
        raise fault(f"{path.name}, type", "must be real, assembled and unsymmetric or symmetric (RUA, RSA)", kind)
    rows_with_entries(path.name, max(rows, columns), entries)
    body = lines[HEADER + (right_hand_side > 0) :]
    if not sum(parts) == total == len(body):
        raise fault(
            path.name, f"must have as many lines as its header says, {total} and {' + '.join(map(str, parts))}", len(body)
        )
    formats = FORMAT.findall(lines[3].decode("ascii", "replace").upper().replace(" ", ""))
    if len(formats) != 3 or [letter in REAL for _, letter, _ in formats] != [False, False, True]:
        raise fault(
            f"{path.name}, line 4",
            "must hold three formats such as (10I8) (10I8) (3E25.16)",
            lines[3][:72].decode("ascii", "replace"),
        )
    numbers, first = [], 0
    for part, count, length, (repeat, letter, width) in zip(PARTS, (columns + 1, entries, entries), parts, formats, strict=False):
        layout = int(repeat or 1), int(width)
        what = f"{path.name}, {part},"
        words = fixed_words(what, body[first : first + length], count, layout, real=letter in REAL)
        numbers.append(number_lines(what, b"\n".join(words)).ravel())
        first += length
    starts = whole(f"{path.name}, {PARTS[0]},", numbers[0], 1, entries + 1) - 1
    indices = whole(f"{path.name}, {PARTS[1]},", numbers[1], 1, rows) - 1
    matrix = compressed_columns(path.name, numbers[2], indices, starts, (rows, columns))
    if not matrix.has_canonical_format:
        raise fault(f"{path.name}, {PARTS[1]},", "must rise in each column", "not in order, or one twice")
    if kind == "RSA" and sparse.triu(matrix, 1).nnz:
        raise fault(f"{path.name}, a symmetric matrix,", "must store its lower triangle", "entries above the diagonal")
    mapping = path.with_suffix(".mapping")
    dofs = _mapped(mapping, rows) if mapping.is_file() else ()
    return Content("Harwell-Boeing", {"": both_triangles(path.name, matrix) if kind == "RSA" else matrix}, dofs)


def _mapped(path: Path, size: int) -> tuple[str, ...]:
    """The names of the rows, below a heading one line for each: its number, the node and the label of its direction."""
    lines = [words for words in map(str.split, path.read_text(encoding="ascii", errors="replace").splitlines()) if words]
    lines = [words for words in lines if words[0].isdecimal()]
    for position, words in enumerate(lines, start=1):
        if not (len(words) == 3 and words[0] == str(position) and words[1].isdecimal() and words[2] in LABELS):
            rule = f"must be {position}, a node and {', '.join(LABELS)}"
            raise fault(f"Line {position} of {path.name} below its heading", rule, " ".join(words)[:60])
    if len(lines) != size:
        raise fault(path.name, f"must have a line for each of the {counted(size, 'row')} of its matrix", len(lines))
    return tuple(dof(words[1], LABELS[words[2]]) for words in lines)


def _counts(what: str, line: bytes, least: int) -> list[int]:
    """The whole numbers of a line of the header."""
    counts = line.decode("ascii", "replace").split()
    if len(counts) not in (least, least + 1) or not all(re.fullmatch(r"\d{1,14}", word) for word in counts):
        raise fault(what, f"must hold {least} or {least + 1} counts", " ".join(counts)[:60])
    return [int(word) for word in counts]
