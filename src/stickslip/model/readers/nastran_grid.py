"""Coordinates of Nastran's grid points (GRID, GRDSET) in the basic system, from rectangular, cylindrical and spherical systems,
and the corners of elements.

CORD2x, CID, RID, A1, A2, A3, B1, ..., C3: origin A, a point B of the third axis and a point C of the plane of the first and the
third, in the system RID; CORD1x, CID, G1, G2, G3 has them at grid points. Coordinates are (x, y, z), (r, θ, z) or (r, θ, φ) with
θ from the third axis and φ about it, in degrees. (MSC Nastran Quick Reference Guide, CORD1C to CORD2S, GRID.)
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from stickslip.model.readers.deck import CardsMet, Deck, FoundCells, NodeAxes, radial
from stickslip.model.readers.model import dof, given_twice, located
from stickslip.model.readers.nastran_cards import BEGIN, BULK_CARDS, Entry, bulk_lines, entries, integer, number, positive_integer
from stickslip.model.structure.matrices import Point
from stickslip.support.checks import Array, InputError, fault

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
