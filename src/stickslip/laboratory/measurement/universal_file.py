"""Universal files (UFF, UNV): functions of data sets 58 and 58b, and what sets 15, 151, 164 and 2411 say of them.

Formats by the documents of SDRC: lines with fields of fixed width; 58b holds its values as bytes, which its first line counts.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.model.readers.numbers import CUT_SHORT, number_of, within_memory
from stickslip.support.checks import Array, InputError, fault

ENDINGS = (".uff", ".unv", ".uf", ".unf")
MARK = re.compile(rb"^ {4}-1[ \t]*\r?$", re.MULTILINE)
"""The line before and after a data set."""
AFTER_BYTES = re.compile(rb"[\r\n]{0,2} {4}-1[ \t]*(?:\r?\n|\r?\Z)")
"""The same after the bytes of a 58b, with or without a new line."""
BLANK = re.compile(rb"(?:[ \t]*\r?\n)*(?:[ \t]*\Z)?")
"""Empty lines between data sets."""
HEADER = 11
"""Lines of a data set 58 before its values."""
NODES = (15, 2411)
"""Data sets of coordinates."""

NOT_FINITE = re.compile(r"[+-]?(?:nan|inf(?:inity)?)", re.IGNORECASE)

SINGLE, DOUBLE = 13, 20
"""Columns of a value."""
PRECISION = {2: (False, SINGLE), 4: (False, DOUBLE), 5: (True, SINGLE), 6: (True, DOUBLE)}
"""Whether values are complex, and the columns of each, by the type of the ordinate."""
COUNTS = (6, 6, 12, 12)
"""Columns of order of bytes, floating point format, lines of the header and bytes after it, in the first line of a 58b."""
LINES_OF_UNITS = 3
LITTLE_ENDIAN, BIG_ENDIAN, IEEE = 1, 2, 2
DAMAGED = "The file is damaged."
DIRECTIONS = ("S", "X", "Y", "Z", "RX", "RY", "RZ")


@dataclass(frozen=True)
class Freedom:
    """A node and its direction: 0 is a scalar, 1 to 3 translations along X, Y, Z, 4 to 6 rotations, negative against the axis."""

    entity: str
    node: int
    direction: int

    def __str__(self) -> str:
        if not (self.entity or self.node or self.direction):
            return ""
        sign = "-" if self.direction < 0 else "+" if self.direction else ""
        return f"{self.entity + ':' if self.entity else ''}{self.node}:{sign}{DIRECTIONS[abs(self.direction)]}"


@dataclass(frozen=True)
class Axis:
    """What abscissa, ordinate or denominator hold: the specific data type of the format, and the label of the unit or ""."""

    kind: int
    label: str
    unit: str


@dataclass(frozen=True)
class FileUnits:
    """A data set 164: its code, and the factors that divide lengths and forces of the file to SI."""

    code: int
    length: float
    force: float


@dataclass(frozen=True, eq=False)
class UniversalFunction:
    """A data set 58: y (n,) real or complex over x (n,), in the units of the file; number: its place among them, from 1."""

    number: int
    kind: int
    ids: tuple[str, ...]
    response: Freedom
    reference: Freedom
    abscissa: Axis
    ordinate: Axis
    denominator: Axis
    x: Array
    y: NDArray[np.float64] | NDArray[np.complex128]
    units: FileUnits | None

    @property
    def name(self) -> str:
        """`12:+Z / 1:+X`, response and reference; where it states neither, its first line that says something."""
        both = [str(end) for end in (self.response, self.reference) if str(end)]
        return " / ".join(both) or next(iter(self.ids), "without a name")


@dataclass(frozen=True)
class UniversalFile:
    """Functions, coordinates of nodes in units of the file, and notes."""

    name: str
    functions: tuple[UniversalFunction, ...]
    nodes: dict[int, tuple[float, ...]]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Layout:
    """What the seventh line of a data set 58 says of its values: complex or real, the columns of each, how many, and whether
    abscissas are even, so that they are not among the values."""

    complex_: bool
    width: int
    points: int
    even: bool

    def rows(self, order: str) -> list[np.dtype[np.void]]:
        """What the bytes of a point can be in 58b: uneven abscissas are single precision, or written as the ordinates are."""
        ordinates = ("f4" if self.width == SINGLE else "f8",) * (2 if self.complex_ else 1)
        abscissas: tuple[tuple[str, ...], ...] = ((),) if self.even else (("f4",), ("f8",))
        return [np.dtype([(f"{k}", order + kind) for k, kind in enumerate((*one, *ordinates))]) for one in abscissas]

    @property
    def sizes(self) -> tuple[int, ...]:
        """How many bytes the values can have in 58b."""
        return tuple(self.points * row.itemsize for row in self.rows("<"))


@dataclass(frozen=True)
class _DataSet:
    """Its number, its lines as bytes without their ends, those of values as bytes where it is binary, and its first line."""

    number: int
    first: str
    lines: list[bytes]
    values: bytes | None
    start: int


def is_universal(path: Path) -> bool:
    """Whether a file is one, by its ending or its first line."""
    with path.open("rb") as file:
        start = file.read(256)
    return path.suffix.lower() in ENDINGS or bool(re.match(rb"\s*^ {4}-1[ \t]*\r?\n {0,5}\d", start, re.MULTILINE))


def read_universal(path: Path) -> UniversalFile:
    """The file; refused where it is cut off or contradicts itself."""
    within_memory(path.name, 6 * path.stat().st_size)
    functions: list[UniversalFunction] = []
    nodes: dict[int, tuple[float, ...]] = {}
    notes: list[str] = []
    others: set[int] = set()
    units: FileUnits | None = None
    for one in _data_sets(path.name, path.read_bytes()):
        if one.number == 58:
            functions.append(_function(path.name, one, len(functions) + 1, units))
        elif one.number == 164:
            units = _units(path.name, one)
        elif one.number == 151:
            notes += _origin(path.name, one)
        elif one.number in NODES:
            try:
                nodes |= _nodes(path.name, one)
            except InputError as error:
                notes.append(f"Data set {one.number} is not read: {error}")
        else:
            others.add(one.number)
    if others:
        notes.append(f"Data sets of {path.name} that are not read: {', '.join(map(str, sorted(others)))}.")
    return UniversalFile(path.name, tuple(functions), nodes, tuple(dict.fromkeys(notes)))


def _data_sets(name: str, data: bytes) -> Iterator[_DataSet]:
    """The data sets of a file, each between two marks."""
    place, line = 0, 1
    while True:
        begun, place = place, BLANK.match(data, place).end()  # type: ignore[union-attr]
        if place >= len(data):
            return
        line += data.count(b"\n", begun, place)
        mark = MARK.match(data, place)
        if mark is None:
            shown = _text(_next_line(data, place)[0][:40])
            raise fault(f"Line {line} of {name}", 'must be "    -1" before a data set', shown, DAMAGED)
        first, body = _next_line(data, mark.end() + 1)
        head = _text(first)
        if not re.fullmatch(r"(?=.{6}) *\d+", head[:6], re.ASCII):
            raise fault(f"Line {line + 1} of {name}", "must be the number of a data set", head[:20], DAMAGED)
        what = f"Data set {int(head[:6])}, line {line + 1} of {name},"
        values: bytes | None = None
        if head[6:7].lower() == "b":
            lines, values, closing = _binary(what, data, body, head)
        else:
            lines, closing = _lines(what, data, body)
        yield _DataSet(int(head[:6]), head, lines, values, line + 2)
        line += data.count(b"\n", place, closing)
        place = closing


def _lines(what: str, data: bytes, place: int) -> tuple[list[bytes], int]:
    """The lines of a data set and the place after the mark that ends it."""
    closing = MARK.search(data, place)
    if closing is None:
        raise fault(what, 'must end with "    -1"', "cut off", CUT_SHORT)
    return [line.removesuffix(b"\r") for line in data[place : closing.start()].split(b"\n")[:-1]], closing.end() + 1


def _binary(what: str, data: bytes, place: int, head: str) -> tuple[list[bytes], bytes, int]:
    """The lines of a 58b, its bytes and the place after the mark that ends it."""
    lines = []
    for _ in range(HEADER):
        line, place = _next_line(data, place)
        lines.append(line)
    order, format_, count_of_lines, count = (
        _integer(f"{what} field of its first line,", cell) for cell in _cells(head[7:], COUNTS)
    )
    for subject, rule, value, good in (
        ("order of bytes,", "must be 1 (little endian) or 2 (big endian)", order, (LITTLE_ENDIAN, BIG_ENDIAN)),
        ("floating point format,", "must be 2, IEEE 754", format_, (IEEE,)),
        ("lines of its header,", f"must be {HEADER}", count_of_lines, (HEADER,)),
    ):
        if value not in good:
            raise fault(f"{what} {subject}", rule, value, "Export it as ASCII (58).")
    by_values = _layout(what, _text(lines[6])).sizes if int(head[:6]) == 58 else ()
    left = len(data) - place
    for size in (count, *by_values):  # pyuff counts half the bytes of complex values
        if 0 < size <= left and (closing := AFTER_BYTES.match(data, place + size)) is not None:
            return lines, data[place : place + size], closing.end()
    counts = [f"the {count} bytes that its first line counts", *(f"the {size} bytes of its values" for size in by_values)]
    rule = f'must end with "    -1" after {" or ".join(counts)}'
    raise fault(what, rule, "not ended there", "The counts disagree: the file is damaged, or cut short. Copy it again.")


def _next_line(data: bytes, place: int) -> tuple[bytes, int]:
    """The line that begins at a place, without its end, and the place of the next."""
    end = data.find(b"\n", place)
    end = len(data) if end < 0 else end
    return data[place:end].removesuffix(b"\r"), end + 1


def _text(line: bytes) -> str:
    try:
        return line.decode("utf-8")
    except UnicodeDecodeError:
        return line.decode("cp1252", errors="replace")


def _cells(line: str, widths: Sequence[int]) -> list[str]:
    """The fields of a line, without blanks around them."""
    return [line[a:b].strip() for a, b in pairwise([0, *accumulate(widths)])]


def _integer(what: str, cell: str) -> int:
    if not re.fullmatch(r"[+-]?\d{1,12}|", cell, re.ASCII):
        raise fault(what, "must be a whole number in its columns", cell, DAMAGED)
    return int(cell or 0)


def _float(what: str, cell: str) -> float:
    value = float(cell) if NOT_FINITE.fullmatch(cell) else number_of(cell)
    if value is None:
        raise fault(what, "must be a number in its columns", cell, DAMAGED)
    return value


def _function(name: str, one: _DataSet, number: int, units: FileUnits | None) -> UniversalFunction:
    if len(one.lines) < HEADER:
        raise fault(f"Function {number} of {name}", f"must have a header of {HEADER} lines", len(one.lines), DAMAGED)
    header = [_text(line) for line in one.lines[:HEADER]]
    what = f"Function {number} of {name}"
    kind, _, _, _, entity, node, direction, entity_2, node_2, direction_2 = _cells(
        header[5], (5, 10, 5, 10, 11, 10, 4, 11, 10, 4)
    )
    response, reference = _freedom(what, entity, node, direction), _freedom(what, entity_2, node_2, direction_2)
    layout = _layout(what, header[6])
    of_abscissa = _cells(header[6][30:], (13, 13, 13))
    if header[6][30:].split() != of_abscissa:
        raise fault(
            f"{what}, first abscissa, step and value of the z axis,", "must be in their columns", header[6].strip(), DAMAGED
        )
    first, step, _ = (_float(f"{what}, first abscissa, step and value of the z axis,", cell) for cell in of_abscissa)
    points, each = layout.points, (0 if layout.even else 1) + (2 if layout.complex_ else 1)
    values = _numbers(name, one, _widths(layout)) if one.values is None else _unpacked(what, one, layout)
    if values.size != each * points or points < 1:
        raise fault(f"{what}, number of values,", f"must go with the {values.size} numbers that it holds", points, DAMAGED)
    rows = values.reshape(points, each)
    if layout.even:
        x = np.asarray(first + step * np.arange(points))
    else:
        x = np.array(rows[:, 0])
    y = np.ascontiguousarray(rows[:, -2:]).view(complex)[:, 0] if layout.complex_ else rows[:, -1].copy()
    axes = [line.rstrip("\r\n") for line in header[7:11]]
    padded = [len(line) for line in axes] if sum(line != line.rstrip() for line in axes) >= len(axes) - 1 else [0]
    abscissa, ordinate, denominator = (_axis(what, line, padded) for line in axes[:3])
    ids = tuple(text for line in header[:5] if (text := line[:80].strip()) and text != "NONE")
    return UniversalFunction(
        number, _integer(f"{what}, type,", kind), ids, response, reference, abscissa, ordinate, denominator, x, y, units
    )


def _layout(what: str, record: str) -> _Layout:
    """The layout of the values, by the seventh line of a data set 58."""
    form, count, spacing = _cells(record, (10, 10, 10))
    complex_, width = PRECISION.get(_integer(f"{what}, type of ordinate,", form), (False, 0))
    if not width:
        raise fault(f"{what}, type of ordinate,", f"must be one of {', '.join(map(str, PRECISION))}", form)
    points = _integer(f"{what}, number of values,", count)
    even = _integer(f"{what}, spacing,", spacing)
    if even not in (0, 1):
        raise fault(f"{what}, spacing,", "must be 0 (uneven) or 1 (even)", spacing)
    return _Layout(complex_, width, points, even == 1)


def _freedom(what: str, entity: str, node: str, direction: str) -> Freedom:
    toward = _integer(f"{what}, direction,", direction)
    if abs(toward) >= len(DIRECTIONS):
        raise fault(f"{what}, direction,", "must be a number from -6 to 6", toward, DAMAGED)
    return Freedom("" if entity.upper() == "NONE" else entity, _integer(f"{what}, node,", node), toward)


def _axis(what: str, line: str, widths: Sequence[int]) -> Axis:
    """An axis by its line. Its columns have shifted where a blank column holds a letter, the unit has come into the label, or a
    line is of another length than most, which are padded with blanks."""
    kind, _, _, _, label, unit = _cells(line, (10, 5, 5, 5, 21, 21))
    usual = max(widths, key=widths.count)
    shifted = line[25:26].strip() or line[46:47].strip() or (not unit and re.search(r"\S {2,}\S", line[26:46]))
    if shifted or (len(widths) > 1 and len(line) != usual and widths.count(usual) == len(widths) - 1):
        raise fault(f"{what}, line of an axis,", "must have its label and its unit in their columns", line.strip(), DAMAGED)
    return Axis(_integer(f"{what}, type of data,", kind), *("" if text.upper() == "NONE" else text for text in (label, unit)))


def _widths(layout: _Layout) -> tuple[int, ...]:
    """Columns of the values of a whole line."""
    if layout.width == SINGLE:
        return (SINGLE,) * 6
    if layout.even:
        return (DOUBLE,) * 4
    return (SINGLE, DOUBLE, DOUBLE) if layout.complex_ else (SINGLE, DOUBLE) * 2


def _numbers(name: str, one: _DataSet, widths: Sequence[int]) -> Array:
    """The values of all lines after the header. All but the last line are whole, and all end alike: a lost digit shortens one."""
    found: list[float] = []
    lines = [_text(line) for line in one.lines[HEADER:]]
    padded = len({len(line) for line in lines[:-1]}) == 1 < len({len(line.rstrip()) for line in lines[:-1]})
    short = None
    for k, line in enumerate(lines):
        where = f"Line {one.start + HEADER + k} of {name}"
        cells = _cells(line, widths)
        while k == len(lines) - 1 and cells and not cells[-1]:
            cells.pop()
        if not line.isprintable():
            raise fault(where, "must hold no control characters", line.strip()[:80], DAMAGED)
        missing = sum(widths[: len(cells)]) - len(line.rstrip())
        short = missing if short is None else short
        if missing < 0 or (missing != short and not padded):
            rule = f"must have its {len(cells)} numbers in columns of {' and '.join(map(str, sorted({*widths})))}, as the others"
            raise fault(where, rule, line.strip(), DAMAGED)
        found += [_float(where, cell) for cell in cells]
    return np.array(found)


def _unpacked(what: str, one: _DataSet, layout: _Layout) -> Array:
    """The values of a 58b, point by point; refused where they make sense in the other order of bytes alone."""
    data, little = one.values or b"", _cells(one.first[7:], (6,))[0] == str(LITTLE_ENDIAN)
    stated, other_order = (LITTLE_ENDIAN, BIG_ENDIAN) if little else (BIG_ENDIAN, LITTLE_ENDIAN)
    for row, other in zip(layout.rows("<" if little else ">"), layout.rows(">" if little else "<"), strict=True):
        if layout.points * row.itemsize == len(data):
            values, swapped = (_stored(data, each) for each in (row, other))
            ordinates = 2 if layout.complex_ else 1
            if _is_nonsense(values[:, -ordinates:]) and _makes_sense(swapped[:, -ordinates:]):
                shown = f"{stated}, while they make sense in the other order alone"
                remedy = f"Write {other_order} into column 13 of the first line, or export it as ASCII (58)."
                raise InputError(f"{what}, order of bytes, must be that of its values, but is {shown}. {remedy}")
            return values.ravel()
    raise fault(f"{what}, number of values,", f"must go with the {len(data)} bytes that it holds", layout.points, DAMAGED)


def _stored(data: bytes, row: np.dtype[np.void]) -> Array:
    stored = np.frombuffer(data, row)
    with np.errstate(invalid="ignore"):  # NaN of any bits
        return np.stack([stored[key].astype(float) for key in stored.dtype.names or ()], axis=1)


def _decades(values: Array) -> tuple[float, float]:
    """The median of the powers of ten of numbers that are not zero, and of their steps from point to point."""
    sizes = [np.log10(np.abs(column[column != 0.0])) for column in values.T]
    steps = np.concatenate([np.abs(np.diff(column)) for column in sizes])
    powers = np.concatenate(sizes)
    return (float(np.median(powers)) if powers.size else 0.0, float(np.median(steps)) if steps.size else 0.0)


def _makes_sense(values: Array) -> bool:
    """Whether numbers are of a size that is measured, and go on from point to point."""
    if not np.all(np.isfinite(values)):
        return False
    power, step = _decades(values)
    return abs(power) < 15.0 and step < 2.0


def _is_nonsense(values: Array) -> bool:
    """Whether numbers are as those of swapped bytes: their powers of ten are drawn by the last digits, or beyond all reason."""
    if not np.all(np.isfinite(values)):
        return True
    power, step = _decades(values)
    return abs(power) > 30.0 or step > 4.0


def _units(name: str, one: _DataSet) -> FileUnits:
    what = f"Data set 164 of {name}"
    if len(one.lines) != LINES_OF_UNITS:
        raise fault(what, f"must have {LINES_OF_UNITS} lines", len(one.lines), DAMAGED)
    code, factors, offset = map(_text, one.lines)
    length, force, *_ = (_float(what, cell) for cell in [*_cells(factors, (25, 25, 25)), offset.strip()])
    if not (0.0 < length < np.inf and 0.0 < force < np.inf):
        raise fault(what, "must have positive factors of length and force", [length, force], DAMAGED)
    return FileUnits(_integer(what, code[:10].strip()), length, force)


def _origin(name: str, one: _DataSet) -> list[str]:
    """The sentence on program and date of a data set 151."""
    lines = [_text(line).strip() for line in one.lines[:7]]
    said = [text for text in (lines[5:6] + lines[6:7]) if text and text != "NONE"]
    return [f"Program and date of {name}: {', '.join(' '.join(text.split()) for text in said)}."] if said else []


def _nodes(name: str, one: _DataSet) -> dict[int, tuple[float, ...]]:
    """Coordinates by node of a data set 15, a line a node, or 2411, two lines a node."""
    what, found = f"Data set {one.number} of {name}", {}
    lines = [_text(line) for line in one.lines if line.strip()]
    pairs = [(line, line[40:], SINGLE) for line in lines]
    if one.number != 15:
        if len(lines) % 2:
            raise fault(what, "must have two lines for each node", len(lines))
        pairs = [(first, second, 25) for first, second in zip(lines[::2], lines[1::2], strict=True)]
    for first, second, width in pairs:
        found[_integer(what, first[:10].strip())] = tuple(_float(what, cell) for cell in _cells(second, (width,) * 3))
    return found
