"""Bulk data of Nastran: its entries, coordinates of grid points (GRID, GRDSET) in the basic system, corners of elements, and
matrices by grid point and component (DMIG; .pch, .dmig, .bdf).

Entries have small fields of 8, large ones of 16 (NAME*) or commas. Included files are read in place, replicated entries (=)
written out, and nothing is read after ENDDATA. What the reader of grid points does with each entry stands in `cards.toml`.

Coordinates are (x, y, z), (r, θ, z) or (r, θ, φ) with θ from the third axis and φ about it, in degrees. CORD2x, CID, RID, A1,
A2, A3, B1, ..., C3: origin A, a point B of the third axis and a point C of the plane of the first and the third, in the system
RID; CORD1x, CID, G1, G2, G3 has them at grid points. (MSC Nastran Quick Reference Guide, Format of bulk data entries;
Replication; INCLUDE; ENDDATA; CORD1C to CORD2S; GRID.)

DMIG, NAME, 0, IFO, TIN, ... is the header; DMIG, NAME, GJ, CJ, , G1, C1, A1, B1 with continuations G2, C2, A2, B2, ... a column;
IFO 6 is symmetric, each pair of entries once; 1 is square; 2 and 9 are rectangular (loads), which no model needs.
(MSC Nastran Quick Reference Guide, DMIG.)
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import sparse

from stickslip.model.readers.deck import CardList, CardsMet, Deck, FoundCells, Line, Lines, NodeAxes, radial
from stickslip.model.readers.model import Content, dof, given_twice, located
from stickslip.model.readers.numbers import CUT_SHORT, integer, number_of, refuse_cut, refuse_utf_16, within_memory
from stickslip.model.structure.matrices import Point, both_triangles
from stickslip.support.checks import Array, InputError, counted, fault

BULK_CARDS = CardList.of("nastran")


EXPONENT = re.compile(r"([0-9.])([+-]\d+)$")
REPEAT = re.compile(r"=\(?(\d{1,9})\)?")
SECTION = re.compile(r"\s*BEGIN\s+(BULK\b.*|SUPER\b.*|MODULE\b.*|AUXMODEL\b.*|$)", re.IGNORECASE)
BEGIN = "BEGIN"
"""The name of the entry that stands for BEGIN BULK, BEGIN SUPER=7: its second field is what follows the word."""
MOST_REPLICATED = 100_000
"""Entries that = makes in a deck: more is a slip."""
SMALL, LARGE = 8, 4
"""Fields of a line beside its first and the mark of its continuation."""


class Entry(NamedTuple):
    """The fields of an entry with its continuations, the name without its star first; and where it begins."""

    fields: list[str]
    line: Line


WITH_TEXT = {"DEQATN", "DRESP3", "GROUP", "MONCARL", "MONDSP1", "MONGRP", "MONSUM", "MONSUM1", "MONSUMT", "UDNAME"}
WITH_TEXT |= {"MONPNT1", "MONPNT2", "MONPNT3"}
"""Entries with an equation, a label or a name of a file, in which commas part no fields."""
FREE_FORMAT = re.compile(
    r"\s*(BEGIN|CHEXA|CORD[12][CRS]|CPENTA|CPYRAM?|CQUAD[48R]|CTETRA|CTRIA[36R]|DMIG|EXTRN|GRDSET|GRID)\s*,", re.IGNORECASE
)
"""A line of such an entry that counts, behind blanks."""


def included(text: str, more: Iterator[str]) -> str | None:
    """The file of INCLUDE 'FILE', whose name in quotation marks may go on over several lines."""
    match = re.match(r"\s*INCLUDE\b\s*=?\s*(.*)", text, re.IGNORECASE)
    if not match:
        return None
    name = match[1].strip()
    mark = name[:1]
    if mark not in ("'", '"'):
        return name.split("$")[0].strip()
    while name.count(mark) < 2 and (line := next(more, None)) is not None:
        name += line.strip()
    return name.split(mark)[1]


def bulk_lines(path: Path, memory: int) -> Iterator[Line]:
    """The lines of the bulk data of a deck, after Executive and Case Control where it has them; memory: as `Lines` has it."""
    within_memory(path.name, memory * path.stat().st_size)
    refuse_utf_16(path)
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        started = not any(SECTION.match(text) for text in file)

    def named(text: str, more: Iterator[str]) -> str | None:
        nonlocal started
        started = started or SECTION.match(text) is not None
        return included(text, more) if started else None

    yield from (line for line in Lines(path, named, memory).read() if started)


def entries(lines: Iterable[Line]) -> Iterator[Entry]:
    """Each bulk data entry with its continuations, replicated ones written out; up to ENDDATA."""
    entry: Entry | None = None  # the last one, until a line shows that no continuation of it follows
    mark = ""
    pattern: list[str] = []
    made = 0
    for line in lines:
        text = line.text.split("$")[0].expandtabs()
        if not text.strip():
            continue
        if re.match(r"\s*ENDDATA\b", text, re.IGNORECASE):
            break
        section = SECTION.match(text)
        name = re.match(r"\s*([A-Z][A-Z0-9]*)", text, re.IGNORECASE)
        if not section and name and name[1].upper() in WITH_TEXT:
            if entry is not None:
                yield entry
            entry, mark = Entry([name[1].upper()], line), ""
            continue
        if entry is not None and entry.fields[0] in WITH_TEXT and re.match(r" {8}|[+*]", text) and not FREE_FORMAT.match(text):
            continue
        first, *rest = [BEGIN, section[1].upper()] if section else _fields(text, line)
        if first.startswith("=") and entry is not None:
            yield entry
            count = REPEAT.fullmatch(first)
            pattern = pattern if count else rest  # =(3) repeats the pattern of the line before, = has one of its own
            times = int(count[1]) if count else 1
            made += times
            if made > MOST_REPLICATED or not pattern or len(entry.fields) > SMALL + 1:
                raise fault(f"{line.place}, replication", "must repeat entries of one line", first, "Write the entries out.")
            for number in range(times):
                entry = Entry(_replicated(entry.fields, pattern, line), line)
                if number < times - 1:
                    yield entry
        elif first in ("", "*") or first[0] in "+*":
            _refuse_out_of_order(entry, mark, first, line)
            if entry is not None:
                entry.fields.extend(rest)
            mark = _mark(text)
        else:
            mark = _mark(text)
            if entry is not None:
                yield entry
            entry = Entry([first.partition(" ")[0].rstrip("*").upper(), *rest], line)
    if entry is not None:
        yield entry


def _refuse_out_of_order(entry: Entry | None, mark: str, first: str, line: Line) -> None:
    """Refuse a continuation that does not stand behind the line it continues, whose last field has the same mark."""
    own = first.lstrip("+*").strip().upper()
    alone = entry is None or entry.fields[0] == BEGIN
    if alone or (own and mark and own != mark):
        remedy = "Sort the file, so that each entry is whole."
        behind = "behind no entry" if alone else f"behind a line that ends in {mark!r}"
        raise fault(f"{line.place}, the continuation {first!r}", "must follow the line it continues", behind, remedy)


def _mark(text: str) -> str:
    """The mark of the continuation, the last field of a line."""
    words = text.split(",")
    count = LARGE if "*" in words[0][:8] else SMALL
    last = words[count + 1] if len(words) > count + 1 else "" if len(words) > 1 else text[72:80]
    return last.strip().lstrip("+*").strip().upper()


def _fields(text: str, line: Line) -> list[str]:
    """The first field, and eight small or four large ones; blanks where the line ends early."""
    count = LARGE if "*" in text.split(",")[0][:8] and not text.startswith("=") else SMALL
    if "," in text:
        words = [word.strip() for word in text.split(",")]
        if any(words[count + 2 :]):
            raise fault(
                line.place, f"must hold at most {count} fields after its name", words[:20], "Continue it on another line."
            )
        return (words + [""] * count)[: count + 1]
    width = 64 // count
    return [text[:8].strip(), *(text[start : start + width].strip() for start in range(8, 72, width))]


def _replicated(previous: list[str], pattern: list[str], line: Line) -> list[str]:
    """The entry after `previous`: = is the same field, *x one greater by x, == all fields that are left, others themselves."""
    made = [previous[0]]
    for old, word in zip(previous[1:], pattern, strict=False):
        if word == "==":
            return [*made, *previous[len(made) :]]
        if word.startswith("*"):
            step = word.strip("*()")
            plain = re.fullmatch(r"[+-]?\d*", old) and re.fullmatch(r"[+-]?\d+", step)
            made.append(str(int(old or 0) + int(step)) if plain else repr(number(old) + number(step)))
        elif word.startswith("=") and word != "=":
            raise fault(f"{line.place}, replication", "must hold =, ==, *increment or a value", word, "Write the entries out.")
        else:
            made.append(old if word == "=" else word)
    return made


def positive_integer(word: str) -> int:
    """The number of a grid point."""
    value = integer(word)
    if value < 1:
        raise fault("The number of a grid point", "must be positive", value)
    return value


def number(word: str) -> float:
    """A number as Nastran writes it: 1.0+5 and 1.0D+5 are 1e5, a blank is 0."""
    text = EXPONENT.sub(r"\1E\2", word)
    value = number_of(text) if text else 0.0
    if value is None:
        raise fault("A field of an entry", "must be a number", word[:20])
    return value


ELEMENTS = {
    "CTETRA": "tetrahedron",
    **dict.fromkeys(("CPYRAM", "CPYRA"), "pyramid"),
    "CPENTA": "wedge",
    "CHEXA": "hexahedron",
    **dict.fromkeys(("CTRIA3", "CTRIA6", "CTRIAR"), "triangle"),
    **dict.fromkeys(("CQUAD4", "CQUAD8", "CQUADR"), "quadrilateral"),
}
"""Entries of elements with faces: ELEMENT, EID, PID, G1, G2, ..., corners first."""

BASIC = 0
"""Number of the basic coordinate system; a blank field means it too."""

MOST_NESTED = 100
"""Systems that refer to each other in a row; those beyond are left out."""


class CoordinateSystem(NamedTuple):
    """R, C or S; origin and axes (columns) in the basic system."""

    kind: str
    origin: Array
    axes: Array

    def place(self, coordinates: Array) -> Array:
        """A point in the basic system."""
        a, b, c = coordinates
        if self.kind == "C":
            a, b = a * np.cos(np.radians(b)), a * np.sin(np.radians(b))
        elif self.kind == "S":
            polar, about = np.radians(b), np.radians(c)
            a, b, c = a * np.sin(polar) * np.cos(about), a * np.sin(polar) * np.sin(about), a * np.cos(polar)
        return np.asarray(self.origin + self.axes @ np.array([a, b, c]))

    def axes_at(self, point: Array) -> Array | None:
        """The directions of displacements (columns) at a point of the basic system; None where the system has none there."""
        if self.kind == "R":
            return self.axes
        around = radial(point, self.origin, self.axes)
        if around is None or self.kind == "C":
            return around
        out = (point - self.origin) / np.linalg.norm(point - self.origin)
        return np.column_stack([out, np.cross(around[:, 1], out), around[:, 1]])


BASIC_SYSTEM = CoordinateSystem("R", np.zeros(3), np.eye(3))


class _Defined(NamedTuple):
    """A system as it is written: by three points in a system `of`, or by three grid points."""

    kind: str
    of: int
    points: Array | None
    grids: tuple[int, ...]


@dataclass
class Grid:
    """Entries of a file that say where grid points are: number, CP, coordinates and CD of each; systems by number.

    default: CP and CD of GRDSET, wherever it stands; external: grid point and components of EXTRN.
    """

    written: list[tuple[int, str, Point, str]] = field(default_factory=list)
    systems: dict[int, _Defined] = field(default_factory=dict)
    default: tuple[str, str] = ("", "")
    external: list[tuple[str, str]] = field(default_factory=list)
    elements: FoundCells = field(default_factory=FoundCells)

    def take(self, entry: list[str]) -> None:
        """Keep what an entry says, if it is one of these."""
        name = entry[0]
        if name == "GRID":
            grid, system, *coordinates, motion = [*entry, *[""] * 7][1:7]
            x, y, z = map(number, coordinates)
            self.written.append((positive_integer(grid), system, (x, y, z), motion))
        elif name in ELEMENTS:
            self.elements.add(ELEMENTS[name], [word for word in entry[3:] if word])
        elif name == "EXTRN":
            pairs = zip(entry[1::2], entry[2::2], strict=False)
            self.external += [(grid, components) for grid, components in pairs if grid]
        elif name == "GRDSET":
            self.default = entry[2], entry[6] if len(entry) > 6 else ""
        elif name in ("CORD2R", "CORD2C", "CORD2S"):
            values = np.array([number(word) for word in (*entry[3:], *[""] * 9)[:9]]).reshape(3, 3)
            self.systems[integer(entry[1])] = _Defined(name[-1], integer(entry[2] or "0"), values, ())
        elif name in ("CORD1R", "CORD1C", "CORD1S"):
            for first in (1, 5):
                number_of, *grids = entry[first : first + 4]
                if number_of:
                    self.systems[integer(number_of)] = _Defined(name[-1], BASIC, None, tuple(map(integer, grids)))

    def deck(self, file: str) -> Deck:
        """The grid points in the basic system, with notes on those that are not there."""
        default = self.default[0] or "0"
        points = [(grid, integer(system or default), point) for grid, system, point, _ in self.written]
        known = self._known(points)
        places = list(zip(points, _places(points, known), strict=True))
        placed = [(str(grid), point) for (grid, _, _), point in places if point is not None]
        lost = len(points) - len(placed)
        notes = [f"{lost} grid points of {file} are left out: their coordinate systems are not in the file."] if lost else []
        motions = [integer(motion or self.default[1] or "0") for *_, motion in self.written]
        turned = {
            str(grid): known[motion].axes_at(np.array(point)) if motion in known and point is not None else None
            for ((grid, *_), point), motion in zip(places, motions, strict=True)
            if motion > BASIC
        }
        rows = tuple(
            dof(positive_integer(grid), integer(component))
            for grid, components in self.external
            for component in components or "0"
        )
        nodes = located(placed)
        notes += given_twice(len(placed) - len(nodes), file)
        return Deck(
            nodes, {}, (*notes, *self.elements.notes(file)), self.elements.cells, NodeAxes(file, "CD of GRID", turned), rows
        )

    def _known(self, points: list[tuple[int, int, Point]]) -> dict[int, CoordinateSystem]:
        """The systems by number, of points given by number, system and coordinates."""
        known = {BASIC: BASIC_SYSTEM}
        for _ in range(MOST_NESTED):
            needed = {grid for system in self.systems.values() for grid in system.grids}
            at = {grid: known[of].place(np.array(point)) for grid, of, point in points if grid in needed and of in known}
            waiting = [(name, _system(name, defined, known, at)) for name, defined in self.systems.items() if name not in known]
            more = {name: system for name, system in waiting if system is not None}
            if not more:
                break
            known |= more
        return known


MAIN = "BULK"


@dataclass
class BulkData:
    """What a file holds by its sections, MAIN and those of superelements: each has grid points of its own."""

    sections: dict[str, Grid] = field(default_factory=lambda: {MAIN: Grid()})
    met: CardsMet = field(default_factory=lambda: CardsMet(BULK_CARDS))
    present: str = MAIN

    def take(self, entry: Entry) -> None:
        """Keep what an entry says, in the section where it stands."""
        name, *rest = entry.fields
        if name == BEGIN:
            self.present = " ".join(rest[0].replace("BULK", " ").replace("=", " ").split()) or MAIN
            self.sections.setdefault(self.present, Grid())
        elif self.met.obeys(name, entry.line.place):
            try:
                self.sections[self.present].take(entry.fields)
            except InputError as error:
                raise InputError(f"{entry.line.place}, {name}: {error}") from None

    def deck(self, file: str) -> Deck:
        """The grid points of the main section; those of the only superelement where that has none, as a punch file of one."""
        others = [section for section in self.sections if section != MAIN]
        whole = not self.sections[MAIN].written and len(others) == 1
        deck = self.sections[others[0] if whole else MAIN].deck(file)
        left = "" if whole else ", ".join(section for section in others if self.sections[section].written)
        notes = (
            f"{file}: the grid points of {left} are left out, since their numbering is separate. Use a file of the superelement.",
        )
        deck.notes = (*(notes if left else ()), *deck.notes, *self.met.notes(file))
        return deck


def read_grid(path: Path) -> Deck:
    """Coordinates of the grid points of a bulk data file and the files that it includes."""
    bulk = BulkData()
    for entry in entries(bulk_lines(path, 20)):
        bulk.take(entry)
    return bulk.deck(path.name)


def _places(points: list[tuple[int, int, Point]], known: dict[int, CoordinateSystem]) -> list[Point | None]:
    """Where each grid point is, given by number, system and coordinates; None in a system that is not known."""
    placed: list[Point | None] = []
    for _, of, point in points:
        if of in known and of != BASIC:
            x, y, z = map(float, known[of].place(np.array(point)))
            point = x, y, z
        placed.append(point if of in known else None)  # what is in the basic system keeps its digits
    return placed


def _system(name: int, defined: _Defined, known: dict[int, CoordinateSystem], at: dict[int, Array]) -> CoordinateSystem | None:
    """A system in the basic one; None where that which it refers to is not known."""
    if defined.points is None:
        if not all(grid in at for grid in defined.grids):
            return None
        origin, third, plane = (at[grid] for grid in defined.grids)
    elif defined.of in known:
        origin, third, plane = (known[defined.of].place(point) for point in defined.points)
    else:
        return None
    z, across = third - origin, np.cross(third - origin, plane - origin)
    size = np.linalg.norm(z) * np.linalg.norm(plane - origin)
    if not np.linalg.norm(across) > 1e-12 * size:
        given = list(defined.grids) if defined.points is None else defined.points.tolist()
        raise fault(f"Coordinate system {name}", "must be given by three points that are not in line", given)
    e3, e2 = z / np.linalg.norm(z), across / np.linalg.norm(across)
    return CoordinateSystem(defined.kind, origin, np.column_stack([np.cross(e2, e3), e2, e3]))


SYMMETRIC, SQUARE = 6, 1
RECTANGULAR = (2, 9)
COMPLEX = (3, 4)
TYPES = (1, 2, *COMPLEX)
NAME = re.compile(r"[A-Z][A-Z0-9]{0,7}")
CUT_BY_COMMENT = re.compile(r"[*+]\s*\$")
LOST_COMMA = "Is the comma missing with which a continuation begins?"
GridComponent = tuple[int, int]


@dataclass
class Matrix:
    """A matrix as it is read: its form and type, how many columns it says it has (0: nothing), and entries by (grid point,
    component) of row and column."""

    form: int
    kind: int
    size: int
    rows: list[GridComponent] = field(default_factory=list)
    columns: list[GridComponent] = field(default_factory=list)
    values: list[complex] = field(default_factory=list)


def read(path: Path) -> Content:
    """Every square DMIG matrix of the file, over the degrees of freedom of all of them in ascending order."""
    matrices: dict[str, Matrix] = {}
    bulk, last = BulkData(), ""
    for entry in entries(map(_whole, bulk_lines(path, 60))):
        last = entry.fields[0]
        if last == "DMIG":
            _take(entry.fields, matrices)
        elif matrices and not NAME.fullmatch(last):
            raise fault("An entry of bulk data", "must begin with its name", last or "blank", LOST_COMMA)
        bulk.take(entry)
    if last == "DMIG":
        refuse_cut(path)
    grid = bulk.deck(path.name)
    rectangular = [name for name, matrix in matrices.items() if matrix.form in RECTANGULAR]
    notes: tuple[str, ...] = (f"Rectangular matrices of the file are left out: {', '.join(rectangular)}.",) if rectangular else ()
    matrices = {name: matrix for name, matrix in matrices.items() if name not in rectangular}
    if not matrices:
        raise fault(path.name, "must hold square DMIG entries", "none")
    notes += tuple(
        f"DMIG {name} holds {counted(len(set(matrix.columns)), 'column')} of the {matrix.size} that its header names."
        for name, matrix in matrices.items()
        if matrix.size and matrix.size != len(set(matrix.columns))
    )
    keys = sorted({key for matrix in matrices.values() for key in (*matrix.rows, *matrix.columns)})
    scalar = {grid for grid, component in keys if component == 0} & {grid for grid, component in keys if component}
    if scalar:
        raise fault(
            f"Point {min(scalar)}", "must be a grid point with components or a scalar point without them", "both", LOST_COMMA
        )
    row = {key: index for index, key in enumerate(keys)}
    dofs = tuple(dof(*key) for key in keys)
    assembled = {name: _assembled(name, matrix, row) for name, matrix in matrices.items()}
    notes = (*notes, *grid.notes)
    return Content("Nastran DMIG", assembled, dofs, grid.nodes, notes=notes, cells=grid.cells, turned=grid.turned)


def _whole(line: Line) -> Line:
    """A line, unless a comment begins where a continuation has its fields."""
    if CUT_BY_COMMENT.match(line.text):
        raise fault("A continuation", "must hold fields", line.text.strip()[:60])
    return line


def _assembled(name: str, matrix: Matrix, row: dict[GridComponent, int]) -> sparse.csc_array:
    """The sparse matrix, with both triangles, over the rows of all matrices; no entry stands twice."""
    values = np.array(matrix.values)
    places = [row[key] for key in matrix.rows], [row[key] for key in matrix.columns]
    data = values if matrix.kind in COMPLEX else values.real
    stored = sparse.coo_array((data, places), (len(row), len(row))).tocsc()
    if stored.nnz < data.size:
        (row_of, column), _ = Counter(zip(matrix.rows, matrix.columns, strict=True)).most_common(1)[0]
        raise fault(f"DMIG {name}", "must hold each entry once", f"{dof(*row_of)}, {dof(*column)} more than once")
    return both_triangles(f"DMIG {name}", stored) if matrix.form == SYMMETRIC else stored


def _take(entry: list[str], matrices: dict[str, Matrix]) -> None:
    """A header, or a column with its terms."""
    name = entry[1]
    if not NAME.fullmatch(name.upper()):
        raise fault("The name of a DMIG matrix", "must be a letter and up to seven letters or digits", name)
    if integer(entry[2]) == 0:
        if name in matrices:
            raise fault(f"DMIG {name}", "must have one header", "several", "Two files in one?")
        form, kind, polar = integer(entry[3]), integer(entry[4]), entry[6]
        if form not in (SYMMETRIC, SQUARE, *RECTANGULAR):
            raise fault(f"IFO of {name}", "must be 1 (square), 2, 9 (rectangular) or 6 (symmetric)", form)
        if kind not in TYPES:
            raise fault(f"TIN of {name}", "must be 1, 2 (real, single or double), 3 or 4 (complex)", kind)
        if polar not in ("", "0"):
            raise fault(f"POLAR of {name}", "must be 0 or blank: real and imaginary parts", polar)
        matrices[name] = Matrix(form, kind, integer(entry[8] or "0") if len(entry) > 8 else 0)
        return
    if name not in matrices:
        raise fault(f"DMIG {name}", "must begin with its header (0 in the third field)", entry[2])
    matrix = matrices[name]
    if matrix.form in RECTANGULAR:
        return
    column = positive_integer(entry[2]), _component(entry[3])
    if entry[4]:
        raise fault(f"The fifth field of a column of DMIG {name}", "must be blank", entry[4], LOST_COMMA)
    for start in range(5, len(entry), 4):
        grid, component, real, imaginary = (*entry[start : start + 4], "", "", "")[:4]
        if any(entry[start : start + 4]) and not (grid and (real or imaginary)):
            raise fault(f"A term of DMIG {name}", "must have a grid point and a value", entry[start : start + 4], CUT_SHORT)
        if imaginary and matrix.kind not in COMPLEX:
            raise fault(f"A term of DMIG {name}", "must be real, as its header says", entry[start : start + 4])
        if grid:
            matrix.rows.append((positive_integer(grid), _component(component)))
            matrix.columns.append(column)
            matrix.values.append(complex(_value(real), _value(imaginary)))


def _value(word: str) -> float:
    """A real number, which has a decimal point or an exponent."""
    if word and not set(".EeDd") & set(word):
        raise fault("A value of a term", "must have a decimal point", word[:20])
    return number(word)


def _component(word: str) -> int:
    """The component of a grid point; scalar and extra points have none, or 0."""
    component = integer(word) if word else 0
    if component not in range(7):
        raise fault("The component of a grid point", "must be 1 to 6, or 0 for scalar points", component)
    return component
