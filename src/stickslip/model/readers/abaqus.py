"""Abaqus matrices (.mtx): of *MATRIX OUTPUT, and substructures of *SUBSTRUCTURE MATRIX OUTPUT, which CalculiX writes too.

*MATRIX OUTPUT, FORMAT=MATRIX INPUT: one matrix a file (JOB_STIF1.mtx, JOB_MASS1.mtx), lines "node, direction, node, direction,
value"; FORMAT=COORDINATE: lines "row, column, value". A symmetric matrix has one triangle or both. Substructures stand as
*USER ELEMENT with the nodes in comments, then *MATRIX, TYPE=STIFFNESS and MASS: the columns up to the diagonal, one after
the other. (Abaqus Keywords Guide: *MATRIX INPUT, *USER ELEMENT, *MATRIX, *SUBSTRUCTURE MATRIX OUTPUT.)
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.readers.deck import Deck, Line
from stickslip.model.readers.input_cards import cards, fields
from stickslip.model.readers.input_deck import read_deck
from stickslip.model.readers.model import Content, dof
from stickslip.model.readers.numbers import number_lines, refuse_cut, table, triplets, whole, within_file, within_memory
from stickslip.model.structure.matrices import Sparse, both_triangles
from stickslip.support.checks import Array, Index, counted, fault

FORMAT = "Abaqus matrix"
HELD = 1e35
"""Stiffness on the diagonal of K from which a boundary condition holds the row: Abaqus writes 1e36 there."""
JOB = re.compile(r"(.+)_(?:STIF|MASS|DMPV|DMPS)\d*", re.IGNORECASE)


def read(path: Path) -> Content:
    """A matrix or a substructure; coordinates and sets from JOB.inp where that stands beside."""
    refuse_cut(path)
    job = JOB.fullmatch(path.stem)
    beside = path.with_name(f"{job[1] if job else path.stem}.inp")
    deck = read_deck(beside) if beside.is_file() else Deck()
    with path.open(encoding="ascii", errors="replace") as file:
        head = file.read(1 << 16).upper()
    if "*USER ELEMENT" in head:
        return _substructure(path, deck)
    entries = table(path, None)
    if entries.shape[1] == 3:
        rows, columns = (whole(f"Rows of {path.name}", entries[:, k], 1) - 1 for k in (0, 1))
        size = int(max(rows.max(initial=-1), columns.max(initial=-1))) + 1
        return Content("Abaqus coordinate matrix", {"": _square(path.name, rows, columns, entries[:, 2], size)})
    if entries.shape[1] != 5:
        raise fault(f"Each line of {path.name}", "must have 5 or 3 numbers", entries.shape[1])
    # Internal nodes have negative numbers; the rows of the model are in ascending order of node and direction.
    keys = whole(f"Nodes and directions of {path.name}", entries[:, :4], -(2**31)).reshape(-1, 2)
    freedoms, numbers = np.unique(keys, axis=0, return_inverse=True)
    pairs = numbers.reshape(-1, 2)
    matrix = _square(path.name, pairs[:, 0], pairs[:, 1], entries[:, 4], len(freedoms))
    dofs = tuple(dof(int(node), int(direction)) for node, direction in freedoms)
    return Content(FORMAT, {"": matrix}, dofs, deck.nodes, deck.sets, deck.notes, deck.cells, deck.solids, deck.turned)


def without_held(
    matrices: Mapping[str, Any], dofs: tuple[str, ...]
) -> tuple[dict[str, Sparse], tuple[str, ...], tuple[str, ...]]:
    """The matrices and names without the rows that boundary conditions hold, and a note on them."""
    diagonal = np.abs(sparse.csc_array(matrices["K"]).diagonal())
    free = np.flatnonzero(diagonal < HELD)
    kept = {letter: sparse.csc_array(matrix)[free][:, free] for letter, matrix in matrices.items()}
    held = len(dofs) - free.size
    note = f"{counted(held, 'row')} held by boundary conditions, with 1e36 on the diagonal of K, are left out."
    return kept, tuple(dofs[row] for row in free.tolist()), (note,) if held else ()


def _square(what: str, rows: Index, columns: Index, values: Array, size: int) -> Sparse:
    """The matrix of its entries, mirrored where none has its mirror image: a triangle in the order of the program."""
    matrix = triplets(what, rows, columns, values, size)
    off = rows != columns
    whole_matrix = np.isin(rows[off] * size + columns[off], columns[off] * size + rows[off]).any()
    return matrix if whole_matrix else both_triangles(what, matrix)


def _substructure(path: Path, deck: Deck) -> Content:
    """The matrices of *USER ELEMENT; a note names the cards whose lines are not read."""
    within_memory(path.name, 12 * path.stat().st_size)
    text = path.read_text(encoding="ascii", errors="replace")
    nodes, matrices = _element_nodes(text), {}
    dofs: tuple[str, ...] = ()
    skipped: list[str] = []
    for card in cards(Line(line, path.name, number) for number, line in enumerate(text.splitlines(), start=1)):
        if card.keyword == "USER ELEMENT":
            if dofs:
                raise fault(path.name, "must hold one substructure", "several *USER ELEMENT")
            dofs = _directions(card.data, nodes)
        elif card.keyword == "MATRIX":
            kind = card.name("TYPE")
            if not kind:
                raise fault("*MATRIX", "must have a TYPE", ", ".join(card.options) or "nothing")
            matrices[kind] = _packed(f"{path.name}, {kind}", card.data, len(dofs))
        elif card.data:
            skipped.append(f"*{card.keyword}")
    notes = (f"{path.name}: the lines below {', '.join(skipped)} are not read.",) if skipped else ()
    return Content(
        "Abaqus substructure", matrices, dofs, deck.nodes, deck.sets, (*deck.notes, *notes), deck.cells, deck.solids, deck.turned
    )


def _element_nodes(text: str) -> list[str]:
    """The nodes, which stand in comments after *USER ELEMENT: as many as it says."""
    match = re.search(r"^\*USER ELEMENT.*?NODES\s*=\s*(\d{1,9}).*$", text, re.IGNORECASE | re.MULTILINE)
    if match is None:
        raise fault("*USER ELEMENT", "must say NODES=", "nothing")
    number = int(match[1])
    within_file("Nodes of *USER ELEMENT", number, len(text), 1.0)
    nodes: list[str] = []
    for line in text[match.end() :].splitlines():
        words = [word.strip() for word in line.lstrip("*").split(",") if word.strip()]
        if line.startswith("**") and words and all(re.fullmatch(r"-?\d+", word) for word in words):
            nodes += words
    return nodes if len(nodes) == number else [str(position) for position in range(1, number + 1)]


def _directions(data: list[str], nodes: list[str]) -> tuple[str, ...]:
    """The first line: directions at the first node; then "position, directions" wherever they change from there on."""
    lines = [[int(word) for word in fields(line) if word] for line in data]
    if not lines:
        raise fault("*USER ELEMENT", "must list directions", "none")
    changes = {1: lines[0]} | {line[0]: line[1:] for line in lines[1:] if line}
    names: list[str] = []
    present = lines[0]
    for position, node in enumerate(nodes, start=1):
        present = changes.get(position, present)
        names += [dof(node, direction) for direction in present]
    return tuple(names)


def _packed(what: str, data: list[str], size: int) -> Array:
    """The symmetric matrix of its columns up to the diagonal, or a whole matrix column by column."""
    words = " ".join(data).encode("ascii", "replace").replace(b",", b" ").split()
    values = number_lines("a matrix", b"\n".join(words)).ravel()
    triangle = 2 * values.size == size * (size + 1)
    if not triangle and values.size != size * size:
        raise fault(what, f"must have {size * (size + 1) // 2} or {size * size} entries for {size} rows", values.size)
    lengths = [len(fields(line)) for line in data]
    # A comma lost on one line and one gained on another leave the count as it is, but not the lengths of the lines.
    columns, longest = range(1, size + 1) if triangle else [size] * size, max(lengths)
    layouts = ([min(longest, n - first) for n in parts for first in range(0, n, longest)] for parts in ([values.size], columns))
    if lengths not in layouts:
        raise fault(what, "must have full lines except the last one, of the matrix or of each column", lengths[:20])
    if not triangle:
        return values.reshape(size, size).T
    within_memory(what, 8 * size * size)
    matrix = np.zeros((size, size))
    matrix[np.tril_indices(size)] = values
    return np.asarray(matrix + matrix.T - np.diag(np.diag(matrix)))
