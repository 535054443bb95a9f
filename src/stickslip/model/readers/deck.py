"""What a deck says about nodes and elements, as the reader of each format returns it, and what becomes of its cards.

The lines of a deck come with those of the files that it includes, each with its file and number. An included file must lie in the
folder of the deck or below it: a deck of others would else read any file of the machine.

Nodes with axes of their own (CD of GRID, *TRANSFORM, angles of NBLOCK): their rows are turned along the axes of the model.

A row NODE.x of such a matrix moves along the first axis of the node, so that rigid motions, contact directions, shapes and the
centrifugal load would be wrong if it were taken for the x of the model.

Where the nodes of an input deck lie: in axes of *SYSTEM, in cylindrical coordinates, on lines and arcs, in instances.
"""

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy import sparse

from stickslip.model.readers.numbers import DIGITS, refuse_utf_16, within_memory
from stickslip.model.structure.centrifugal import rotation_about
from stickslip.model.structure.matrices import Point
from stickslip.model.structure.mesh_surface import CORNERS, Cells
from stickslip.support.checks import Array, Index, counted, fault, first_of, similar_file

if TYPE_CHECKING:
    from stickslip.model.readers.input_cards import Card, Solids


REPEATED_BYTES = 4 << 20
"""Bytes of files that a deck includes once more, beyond as many as its files have: seconds of reading."""
SECONDS, BYTES_PER_SECOND = 60.0, 1e5
"""Processor time for a deck, and for each of its bytes; the slowest reader takes a seventh of it."""
EACH_LINES = 4096
"""Lines between two looks at the time."""
MOST_FILES = 1000
DEEPEST = 20
"""Included files, and includes within each other: more is a file that includes itself."""


class Line(NamedTuple):
    """A line without its end; file and number say where it stands."""

    text: str
    file: str
    number: int

    @property
    def place(self) -> str:
        return f"{self.file}, line {self.number}"


Included = Callable[[str, Iterator[str]], str | None]
"""The name of the file that a line includes, None if it includes none; a card that goes on takes more lines from the iterator."""


@dataclass
class Lines:
    """deck: the file that was named; memory: bytes that a byte of text takes as it is read."""

    deck: Path
    included: Included
    memory: int
    size: int = 0
    files: int = 0
    sizes: dict[Path, int] = field(default_factory=dict)

    def read(self) -> Iterator[Line]:
        """Every line of the deck, that of an included file in the place of the card that names it."""
        begun = process_time()
        for number, line in enumerate(self._lines(self.deck, 0)):
            yield line
            if number % EACH_LINES == 0:
                limit = SECONDS + self.size / BYTES_PER_SECOND
                if process_time() - begun > limit:
                    rule = f"must be read within {limit:.0f} s of processor time"
                    raise fault(self.deck.name, rule, f"at {line.place} by then", "Is something in it made over and over again?")

    def of_file(self, name: str, card: Line) -> Iterator[Line]:
        """The lines of a file of data that a card names."""
        return self._lines(self._inside(name, card), 1)

    def _lines(self, path: Path, depth: int) -> Iterator[Line]:
        self.files += 1
        self.sizes[path] = path.stat().st_size
        self.size += self.sizes[path]
        own = sum(self.sizes.values())
        if self.size > 2 * own + REPEATED_BYTES:
            limit = f"must have at most {2 * own + REPEATED_BYTES} bytes with the files that it includes again"
            raise fault(self.deck.name, limit, f"more with {path.name}", "Include each file once.")
        if self.files > MOST_FILES or depth > DEEPEST:
            limit = f"must include at most {MOST_FILES} files, {DEEPEST} deep"
            raise fault(self.deck.name, limit, f"more with {path.name}", "Does a file include itself?")
        within_memory(self.deck.name, self.memory * self.size)
        refuse_utf_16(path)
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            numbered = enumerate(file, start=1)
            for number, text in numbered:
                line = Line(text.rstrip("\r\n"), path.name, number)
                name = self.included(line.text, (more for _, more in numbered))
                if name is None:
                    yield line
                else:
                    yield from self._lines(self._inside(name, line), depth + 1)

    def _inside(self, name: str, line: Line) -> Path:
        """The path of an included file, by its name from the folder of the deck."""
        folder = self.deck.parent.resolve()
        path = (folder / name.replace("\\", "/")).resolve()
        if not path.is_relative_to(folder):
            raise fault(f"The file that {line.place} includes", "must lie in the folder of the deck", name, "Copy it there.")
        if not path.is_file():
            remedy = f"{similar_file(path)} Copy it there, or delete the line if it holds no nodes, sets or elements.".strip()
            raise fault(f"The file that {line.place} includes", "must exist in the folder of the deck", name, remedy)
        return path


OWN_AXES = "axes of their own"
"""In the note on nodes whose rows are not along the axes of the model."""
ALONG = 1e-6
"""How far an axis may point away from one of the model that it is meant to be along: decks print six digits."""
TRIPLES = (("x", "y", "z"), ("rx", "ry", "rz"))


@dataclass(frozen=True, eq=False)
class NodeAxes:
    """axes: by node, (3, 3), the directions of its rows x, y, z as columns in the axes of the model, None where the deck does not
    say them; card: what gives the nodes of this file axes."""

    file: str = ""
    card: str = ""
    axes: Mapping[str, Array | None] = field(default_factory=dict)


class Turned(NamedTuple):
    """Matrices and names of rows along the axes of the model, what was done, and whether rows of any were turned or left."""

    matrices: dict[str, Any]
    dofs: tuple[str, ...]
    notes: tuple[str, ...]
    any: bool
    left: bool


def radial(point: Array, origin: Array, axes: Array) -> Array | None:
    """The axes r, θ, z (columns) at a point of a cylindrical system whose z is the third column of `axes`; None on that axis."""
    away = point - origin
    along = axes[:, 2] * (axes[:, 2] @ away)
    distance = np.linalg.norm(away - along)
    if distance <= ALONG * np.linalg.norm(away):
        return None
    first = (away - along) / distance
    return np.column_stack([first, np.cross(axes[:, 2], first), axes[:, 2]])


def along_model(matrices: Mapping[str, Any], dofs: Sequence[str], own: NodeAxes) -> Turned:
    """The matrices T A Tᵀ, T turning the rows of nodes with axes of their own.

    A support along an own axis leaves its row out. The others of the node are turned where they span axes of the model, and get
    their names; where they do not, no names of rows would say how they move: they stay as they are.
    """
    names, rows = list(dofs), {name: row for row, name in enumerate(dofs)}
    blocks = [*_blocks(rows, own)]
    left = sorted({node for node, *_, block in blocks if block is None}, key=lambda node: (len(node), node))
    done = {node for node, *_ in blocks} - set(left)
    turned = [(places, directions, block) for node, places, directions, block in blocks if node in done and block is not None]
    stay = np.ones(len(names))
    data, to, source = [], [], []
    for places, directions, block in turned:
        stay[places] = 0.0
        for place, direction in zip(places.tolist(), directions, strict=True):
            names[place] = f"{names[place].rpartition('.')[0]}.{direction}"
        data.append(block.ravel())
        to.append(np.repeat(places, places.size))
        source.append(np.tile(places, places.size))
    notes = (
        [
            f"{own.file} has {counted(len(left), 'node')} with {OWN_AXES} ({own.card}), along which x, y, z of their rows are, "
            f"since the deck does not say these axes or a support leaves rows out: {first_of(left)}."
        ]
        if left
        else []
    )
    if not turned:
        return Turned(dict(matrices), tuple(dofs), tuple(notes), False, bool(left))
    entries = np.concatenate(data), (np.concatenate(to), np.concatenate(source))
    T = sparse.csc_array(sparse.diags_array(stay) + sparse.coo_array(entries, shape=(len(names), len(names))))
    result = {letter: sparse.csc_array(T @ matrix @ T.T) for letter, matrix in matrices.items()}
    for letter in result.keys() & {"M", "K"}:  # rounding leaves them a little unsymmetric
        result[letter] = sparse.csc_array(0.5 * (result[letter] + result[letter].T))
    of = f"{counted(len(done), 'node')} ({own.card})"
    said = f"{own.file} gives local axes to {of}: their rows are turned along those of the model."
    return Turned(result, tuple(names), (said, *notes), True, bool(left))


def _blocks(rows: Mapping[str, int], own: NodeAxes) -> Iterator[tuple[str, Index, tuple[str, ...], Array | None]]:
    """By node and kind of motion: its rows, the names of their directions afterwards, and the matrix that turns them, None where
    none does; nothing of nodes without rows."""
    for node, axes in own.axes.items():
        for triple in TRIPLES:
            present = [k for k, direction in enumerate(triple) if f"{node}.{direction}" in rows]
            places = np.array([rows[f"{node}.{triple[k]}"] for k in present], dtype=int)
            if not present:
                continue
            across = None if axes is None else _spanned(axes, present)
            if axes is None or across is None:
                yield node, places, (), None
            else:
                yield node, places, tuple(triple[k] for k in across), axes[np.ix_(across, present)]


def _spanned(axes: Array, present: Sequence[int]) -> list[int] | None:
    """The axes of the model that the columns `present` span, or None: those along which none of the others points."""
    missing = [k for k in range(3) if k not in present]
    held = np.abs(axes[:, missing]).argmax(axis=0)
    off = 1.0 - np.abs(axes[held, missing])
    across = [k for k in range(3) if k not in held]
    return across if np.all(off <= ALONG**2) and len(across) == len(present) else None


SOLIDS = {"tetrahedron": (4, 10), "pyramid": (5, 13), "wedge": (6, 15), "hexahedron": (8, 20)}
PLATES = {"triangle": (3, 6), "quadrilateral": (4, 8, 9)}
"""Kinds of cells by the number of nodes of their elements, linear and quadratic; corners come first."""

MOST_GENERATED = 1_000_000
"""Members of a generated set of nodes: more is a slip of the deck."""
MOST_MADE = 2_000_000
"""Nodes that cards of a deck make of others, in all."""


@dataclass
class Deck:
    """nodes: coordinates by node; sets: nodes by the name of a set, in capitals; cells: corner nodes of elements by kind; notes:
    what was not read; turned: nodes with axes of their own, along which rows of matrices are;
    rows: the names of the rows of matrices, where the deck says them; solids: elements with materials, where
    stress can be recovered; others: cards of an input deck beside its mesh, and whether each is part of a step."""

    nodes: dict[str, Point] = field(default_factory=dict)
    sets: dict[str, tuple[str, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    cells: Cells = field(default_factory=dict)
    turned: NodeAxes = field(default_factory=NodeAxes)
    rows: tuple[str, ...] = ()
    solids: "Solids | None" = None
    others: "Sequence[tuple[Card, bool]]" = ()


@dataclass
class FoundCells:
    """Cells as they are read; lost: elements without numbers of all their corners."""

    corners: dict[str, list[tuple[int, ...]]] = field(default_factory=dict)
    lost: int = 0

    def add(self, kind: str, nodes: Sequence[str]) -> None:
        """One element by its nodes, of which the corners are kept."""
        corners = nodes[: CORNERS[kind]]
        if len(corners) == CORNERS[kind] and all(word.isdecimal() and len(word) < DIGITS for word in corners):
            self.corners.setdefault(kind, []).append(tuple(map(int, corners)))
        else:
            self.lost += 1

    @property
    def cells(self) -> Cells:
        """The cells by kind."""
        return {kind: np.array(rows, dtype=np.int64) for kind, rows in self.corners.items()}

    def notes(self, file: str) -> tuple[str, ...]:
        """What was left out."""
        return (f"{self.lost} elements of {file} are left out: they do not name all their corners.",) if self.lost else ()


@dataclass(frozen=True)
class CardList:
    """The cards of a format by what a reader of nodes, sets and elements does with them, as `cards.toml` lists them.

    obeyed: they count; harmless: they say nothing about nodes, sets and elements, or only what the matrices hold already;
    refused: by card what to do instead, since nodes or sets would be wrong or missing; noted: by card what is missing without
    it, while all else is right.
    """

    obeyed: frozenset[str]
    harmless: frozenset[str]
    refused: Mapping[str, str]
    noted: Mapping[str, str]
    sign: str = ""

    @classmethod
    def of(cls, name: str, letters: int | None = None, sign: str = "") -> "CardList":
        """The cards of a format by its name; letters: how many of a card count."""
        listed = tomllib.loads(files("stickslip.model.readers").joinpath("cards.toml").read_text(encoding="utf-8"))[name]
        obeyed, harmless = (frozenset(card[:letters] for card in listed[key]) for key in ("obeyed", "harmless"))
        refused, noted = (
            {card[:letters]: text for text, cards in listed[key].items() for card in cards} for key in ("refused", "noted")
        )
        return cls(obeyed, harmless, refused, noted, sign)

    @property
    def known(self) -> frozenset[str]:
        return self.obeyed | self.harmless | self.refused.keys() | self.noted.keys()


@dataclass
class CardsMet:
    """The cards of one deck that are not obeyed, for its notes."""

    cards: "CardList"
    missing: dict[str, str] = field(default_factory=dict)
    unknown: dict[str, str] = field(default_factory=dict)

    def obeys(self, name: str, place: str) -> bool:
        """Whether the reader obeys the card at `place`, "blade.inp, line 7"; refuses one that would make the rest wrong."""
        if name in self.cards.obeyed:
            return True
        shown = self.cards.sign + name
        if name in self.cards.refused:
            raise fault(place, "must hold cards that this reader obeys", shown, self.cards.refused[name])
        if name in self.cards.noted:
            self.missing.setdefault(shown, self.cards.noted[name])
        elif name not in self.cards.harmless:
            self.unknown.setdefault(shown, place)
        return False

    def notes(self, file: str) -> tuple[str, ...]:
        """One sentence for each card that is missing, one for all that are not known."""
        missing = tuple(f"{file}: {card} is not read; {what}." for card, what in self.missing.items())
        if not self.unknown:
            return missing
        listed = first_of([f"{card} ({place})" for card, place in self.unknown.items()])
        return *missing, f"{file}: this reader does not know {listed}. Their effect on nodes and sets, if any, is missing."


class Frame(NamedTuple):
    """Origin and axes (columns) of the coordinates of nodes, in those of the part."""

    origin: Array
    axes: Array

    def place(self, point: Point) -> Point:
        """A point of the frame in the axes of the part; in these themselves it keeps its digits."""
        return point if self is GLOBAL else _point(self.origin + self.axes @ np.array(point))


GLOBAL = Frame(np.zeros(3), np.eye(3))


def frame(numbers: Sequence[float]) -> Frame:
    """The frame of *SYSTEM: origin a, point b on the first axis, point c of the plane of the first and the second axis.

    a alone moves the origin; without c the third axis stays and the first is that of b in the (x, y) plane; nothing at all means
    the axes of the part.
    """
    if len(numbers) not in (0, 3, 6, 9):
        raise fault("*SYSTEM", "must hold one, two or three points", list(numbers))
    if not numbers:
        return GLOBAL
    origin, *points = np.array(numbers).reshape(-1, 3)
    if not points:
        return Frame(origin, np.eye(3))
    first, plane = points[0] - origin, points[-1] - origin
    if len(points) == 1:
        first, plane = first * [1.0, 1.0, 0.0], np.array([-first[1], first[0], 0.0])
    across = np.cross(first, plane)
    if not np.linalg.norm(across) > 1e-12 * np.linalg.norm(first) * np.linalg.norm(plane):
        raise fault("The points of *SYSTEM", "must not lie on one line", list(numbers))
    e1, e3 = first / np.linalg.norm(first), across / np.linalg.norm(across)
    return Frame(origin, np.column_stack([e1, np.cross(e3, e1), e3]))


def turning_points(numbers: Sequence[float]) -> tuple[Point, Point]:
    """The points a and b of *TRANSFORM; numbers left out at the end are zero."""
    if not 1 <= len(numbers) <= 6:
        raise fault("*TRANSFORM", "must hold two points", list(numbers))
    whole = np.array([*numbers, *6 * [0.0]][:6])
    return _point(whole[:3]), _point(whole[3:])


class Turning(NamedTuple):
    """*TRANSFORM of a set of nodes. R: a on the first axis, b on the plane of the first and the second, seen from the origin; C:
    r, θ, z about the axis from a to b. Of S, the manual leaves the sign of two axes open."""

    nset: str
    kind: str
    a: Point
    b: Point
    origin: Point = (0.0, 0.0, 0.0)

    def moved(self, motion: Callable[[Point], Point]) -> "Turning":
        """With the instance that it stands in."""
        return self._replace(a=motion(self.a), b=motion(self.b), origin=motion(self.origin))

    def axes_at(self, node: Point) -> Array | None:
        """The axes (columns) of the rows of a node, None where the deck does not give them."""
        a, b, origin = np.array(self.a), np.array(self.b), np.array(self.origin)
        if self.kind == "R":
            return frame([*origin, *a, *b]).axes
        length = np.linalg.norm(b - a)
        if self.kind != "C" or not length:
            return None
        z = (b - a) / length
        return radial(np.array(node), a, np.column_stack([z, z, z]))


def cartesian(system: str, point: Point) -> Point:
    """Coordinates of *NODE, SYSTEM=R (x, y, z) or C (r, θ in degrees, z) as x, y, z."""
    if system == "R":
        return point
    if system != "C":
        raise fault("SYSTEM of *NODE", "must be R or C", system, "Write Cartesian coordinates.")
    r, angle, z = point
    return _point(np.array([r * np.cos(np.radians(angle)), r * np.sin(np.radians(angle)), z]))


def between(first: Point, last: Point, intervals: int) -> list[Point]:
    """Points at equal distances from the first to the last, both included."""
    share = np.arange(intervals + 1)[:, None] / intervals
    return [_point(row) for row in (1.0 - share) * np.array(first) + share * np.array(last)]


def on_line(kind: str, first: Point, last: Point, extra: Point | None, normal: tuple[float, ...], intervals: int) -> list[Point]:
    """Points at equal distances of *NGEN: on a straight line, or with LINE=C on an arc about `extra`, less than half a turn
    unless its normal is given."""
    if not kind or extra is None:
        return between(first, last, intervals)
    if kind != "C":
        raise fault("LINE of *NGEN", "must be C, or left out", kind, "Write the nodes out.")
    centre = np.array(extra)
    a, b = np.array(first) - centre, np.array(last) - centre
    axis = np.array(normal) if any(normal) else np.cross(a, b)
    radius, length = np.linalg.norm(a), np.linalg.norm(axis)
    if abs(radius - np.linalg.norm(b)) > 1e-3 * radius or (not any(normal) and not length > 1e-9 * radius**2):
        raise fault("The ends of an arc of *NGEN", "must be equally far from its centre, not opposite", [first, last, extra])
    axis = axis / length
    angle = np.arctan2(np.cross(a, b) @ axis, a @ b) % (2.0 * np.pi)
    return [_point(centre + rotation_about(axis, angle * k / intervals) @ a) for k in range(intervals + 1)]


def turned_about(shift: Array, turn: Sequence[float]) -> Callable[[Point], Point]:
    """The motion of an instance: `shift` (3,), then `turn`: a point, another that makes an axis with it, degrees about that."""
    if not turn:
        return (lambda point: _point(np.array(point) + shift)) if np.any(shift) else (lambda point: point)
    start, end, angle = np.array(turn[:3]), np.array(turn[3:6]), np.radians(turn[6])
    if not np.linalg.norm(end - start):
        raise fault("The axis of an instance", "must be given by two points", turn)
    rotation = rotation_about((end - start) / np.linalg.norm(end - start), angle)
    return lambda point: _point(start + rotation @ (np.array(point) + shift - start))


def _point(values: Array) -> Point:
    x, y, z = map(float, values)
    return x, y, z
