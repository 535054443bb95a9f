"""Harwell-Boeing and Rutherford-Boeing files (.rb, .rsa, .rua, .hb; .matrix of Ansys), one matrix a file.

Lines of Fortran: a title; the numbers of lines in all and of each part; type, rows, columns, entries; the formats of the parts;
then where each column starts, the rows of the entries, and their values. A right-hand side adds a line to the header and lines
at the end, which are passed over. (Duff, Grimes and Lewis, Users' Guide for the Harwell-Boeing Sparse Matrix Collection, 1992.)
HBMAT of Ansys writes NAME.mapping beside: number, node and direction of each row. (Ansys Command Reference, HBMAT.)
"""

import re
from pathlib import Path

from scipy import sparse

from stickslip.model.readers.model import Content, dof
from stickslip.model.readers.numbers import compressed_columns, fixed_words, number_lines, rows_with_entries, whole, within_memory
from stickslip.model.structure.matrices import both_triangles
from stickslip.support.checks import counted, fault

FORMAT = re.compile(r"\((?:\d*P,?)?(\d*)([IEDFG])(\d+)(?:\.\d+)?(?:E\d+)?\)")
"""Fields of a line, kind of number, letters of a field: (3E25.16), (1P,4D20.12), (10I8)."""
REAL = "EDFG"
PARTS = ("starts of columns", "rows of entries", "values")
LABELS = {"UX": 1, "UY": 2, "UZ": 3, "ROTX": 4, "ROTY": 5, "ROTZ": 6}
"""Directions as Ansys names them."""
HEADER = 4
"""Lines before the matrix; a fifth one describes a right-hand side."""


def read(path: Path) -> Content:
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
