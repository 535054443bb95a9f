"""Names of rows: from arrays `dofs` and `nodes` beside the matrices, from a list, or from a file of names.

A file of names is a deck of the program (coordinates and sets of nodes), or a table (CSV) with columns `node`, and if wanted `x`,
`y`, `z` (in the unit of the model) and `set` (several, split by blanks): a line for each node, or with a column `direction`
(x, y, z, rx, ry, rz or 1 to 6) one for each row of the matrices, in their order.
"""

import csv
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.model.readers.ansys_deck import read_archive
from stickslip.model.readers.deck import Deck
from stickslip.model.readers.input_deck import read_deck
from stickslip.model.readers.model import DIRECTIONS, Content, located, located_once
from stickslip.model.readers.nastran_deck import read_grid
from stickslip.model.readers.numbers import number_of, refuse_packed, whole
from stickslip.model.structure.matrices import Point
from stickslip.support.checks import InputError, counted, existing, fault, first_of, nearest

COLUMNS = ("node", "direction", "x", "y", "z", "set")
DECKS: Mapping[str, Callable[[Path], Deck]] = {
    ".cdb": read_archive,
    ".inp": read_deck,
    **dict.fromkeys((".bdf", ".dat", ".nas", ".pch", ".asm"), read_grid),
}
"""Readers of the decks of programs, by the ending of the file."""
SCALAR = "q0"
"""The direction of a mode or scalar point."""
LONGEST_NAME = 200
"""Characters of a node's or set's name."""


def from_tables(format: str, arrays: Mapping[str, Any]) -> Content:
    """A content of named arrays: `dofs` and `nodes` describe the rows, everything else counts as a matrix."""
    matrices = {name: value for name, value in arrays.items() if name not in ("dofs", "nodes")}
    dofs: tuple[str, ...] = ()
    if arrays.get("dofs") is not None:
        texts = np.asarray(arrays["dofs"])
        if texts.dtype.kind not in "USO":
            raise fault("dofs", "must hold text", str(texts.dtype), 'Names such as "17.x", one for each row.')
        names = (text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text) for text in texts.ravel().tolist())
        dofs = tuple(checked_name(name.strip()) for name in names)
    nodes: dict[str, Point] = {}
    if arrays.get("nodes") is not None:
        rows = np.asarray(arrays["nodes"])
        if rows.ndim != 2 or rows.shape[1] != 4 or rows.dtype.kind not in "fiu":
            raise fault("nodes", "must have rows of id, x, y, z", f"{rows.shape} of {rows.dtype}")
        if not np.all(np.isfinite(rows)):
            raise fault("nodes", "must be finite", "NaN or infinite")
        ids = whole("Ids of nodes", rows[:, 0].astype(float), 0).tolist()
        points = rows[:, 1:].astype(float).tolist()
        nodes = located((str(node), (x, y, z)) for node, (x, y, z) in zip(ids, points, strict=True))
    return Content(format, matrices, dofs, nodes)


def checked_name(name: str) -> str:
    """A name that can be typed."""
    if not name or len(name) > LONGEST_NAME or not name.isprintable():
        raise fault("dofs", f"must be printable names of 1 to {LONGEST_NAME} characters", name[:40])
    return name


def with_names(content: Content, path: Path) -> Content:
    """The content with the names, coordinates and sets of a file of names."""
    existing("The file of names", [path])
    refuse_packed("The file of names", path)
    reader = DECKS.get(path.suffix.lower())
    if reader is not None:
        return with_nodes(content, _deck(reader, path), path.name)
    rows = _table(path)
    nodes: dict[str, Point] = {}
    members: dict[str, dict[str, None]] = {}
    for row in rows:
        if any(row.get(axis) for axis in "xyz"):
            x, y, z = (number_of(row[axis]) if axis in row else 0.0 for axis in "xyz")
            if x is None or y is None or z is None:
                what = f"The coordinates of node {row['node']}"
                raise fault(what, "must be finite numbers", [row.get(axis) for axis in "xyz"])
            located_once(nodes, row["node"], (x, y, z))
        for name in (row.get("set") or "").split():
            members.setdefault(name, {})[row["node"]] = None
    deck = Deck(nodes, {name: tuple(own) for name, own in members.items()})
    if "direction" in rows[0]:
        dofs = tuple(checked_name(f"{row['node']}.{_direction(row['direction'])}") for row in rows)
        content = replace(content, dofs=dofs, nodes={}, sets={}, cells={}, solids=None)
    return with_nodes(content, deck, path.name)


def with_nodes(content: Content, deck: Deck, file: str) -> Content:
    """The content with coordinates and sets of a deck, which must speak of its nodes; and with its names of rows."""
    if not content.dofs and deck.rows:
        content = replace(content, dofs=deck.rows)
    if not content.dofs:
        remedy = "Give a table with columns node and direction and a line for each row."
        raise fault(file, "must name the rows of the matrices, whose own file does not", "a file of nodes", remedy)
    known = {name.rpartition(".")[0] for name in content.dofs}
    stated = deck.nodes.keys() | {node for members in deck.sets.values() for node in members}
    if stated and not known & stated:
        few = f"{', '.join(sorted(known)[:3])}{', ...' if len(known) > 3 else ''}"
        raise fault(file, f"must hold nodes of the model ({few})", sorted(stated)[:3])
    infinite = next((node for node, point in deck.nodes.items() if not np.all(np.isfinite(point))), None)
    if infinite is not None:
        raise fault(f"{file}: the coordinates of node {infinite}", "must be finite numbers", list(deck.nodes[infinite]))
    nodes, sets = {**content.nodes, **deck.nodes}, {**content.sets, **deck.sets}
    notes = [*content.notes, *deck.notes]
    without = sorted(known - deck.nodes.keys()) if deck.nodes else []
    if without:
        listed = f"{counted(len(without), 'node')} of the model: {first_of(without)}"
        notes.append(f"{file} gives no coordinates of {listed}.")
    strange = sorted({node for members in deck.sets.values() for node in members} - known - nodes.keys())
    if strange:
        listed = f"{counted(len(strange), 'node')} that the model does not have: {first_of(strange)}"
        notes.append(f"Sets of {file} name {listed}.")
    cells, solids = deck.cells or content.cells, deck.solids or content.solids
    # CalculiX writes its matrices along the axes of the model whatever *TRANSFORM says (2.20, tried).
    turned = deck.turned if deck.turned.axes and not content.format.startswith("CalculiX") else content.turned
    return replace(content, nodes=nodes, sets=sets, notes=tuple(notes), cells=cells, solids=solids, turned=turned)


def _deck(reader: Callable[[Path], Deck], path: Path) -> Deck:
    """A deck by its reader; what that raises on a damaged one becomes an `InputError`."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return reader(path)
    except InputError as error:
        message = str(error)
        raise InputError(message if message.startswith(path.name) else f"{path.name}: {message}") from None
    except MemoryError:
        raise fault(path.name, "must fit into the memory", "larger") from None
    except Exception as error:  # whatever a damaged deck leads to
        raise fault("The file of names", "must be readable", path.name, f"It is damaged ({str(error)[:200]}).") from None


def _table(path: Path) -> list[dict[str, str]]:
    """The lines of a table of names by its columns, all of them full."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, skipinitialspace=True, restval="", restkey="more")
            rows = list(reader)
            columns = list(reader.fieldnames or ())
    except (UnicodeDecodeError, csv.Error, OSError) as error:
        raise fault("The file of names", "must be a table in UTF-8", f"{path.name} ({error})") from None
    for column in columns:
        if column not in COLUMNS:
            raise fault(f"{path.name}, column", "must be a known one", column, nearest(str(column), COLUMNS))
    if (
        not ({"node", "direction"} <= set(columns) or {"node", "x"} <= set(columns) or {"node", "set"} <= set(columns))
        or not rows
    ):
        raise fault(path.name, "must have columns node and direction and a line for each row, or node, x, y, z", columns)
    if not all(row["node"].strip() for row in rows):
        raise fault(f"{path.name}, node,", "must be given in each line", "missing")
    if any("more" in row for row in rows):
        raise fault(path.name, f"must have {len(columns)} entries in each line", "more")
    return rows


def _direction(text: str) -> str:
    """The name of a direction, given by itself or by its number."""
    if text in DIRECTIONS.values():
        return text
    if text in map(str, DIRECTIONS):
        return DIRECTIONS[int(text)]
    if text == "0":
        return SCALAR
    raise fault("A direction of the table", "must be x, y, z, rx, ry, rz or 1 to 6, or 0 for a mode or scalar point", text)
