"""CalculiX: the matrices of *FREQUENCY, SOLVER=MATRIXSTORAGE (.sti, .mas, .dof) with nodes and sets of the deck (.inp) beside.

`ccx blade` leaves blade.sti and blade.mas, one triangle each as lines "row column value", rows counted from 1, and blade.dof
with a line NODE.DIRECTION for each row; fixed degrees of freedom have none. (CalculiX CrunchiX User's Manual, *FREQUENCY.)
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stickslip.checks import Array, fault
from stickslip.models.content import Content, dof
from stickslip.models.deck import Deck, read_deck
from stickslip.models.limits import refuse_cut
from stickslip.models.numbers import table, triplets, whole
from stickslip.structure.sparse import Sparse, both_triangles

ENDINGS = (".sti", ".mas", ".dof")
DIRECTIONS = ("1", "2", "3", "4", "5", "6")
CUT_SHORT = "One of the two files was cut short: copy them again."
WRITE_THEM = "*FREQUENCY, SOLVER=MATRIXSTORAGE in the deck writes it."


def read(path: Path) -> Content:
    """The model of a run of which `path` is any of .sti, .mas, .dof or .inp."""
    stiffness, mass, names = (path.with_suffix(ending) for ending in ENDINGS)
    for file in (stiffness, mass, names):
        if not file.is_file():
            packed = file.with_name(f"{file.name}.gz")
            remedy = f"Unpack it: gunzip {packed.name}" if packed.is_file() else WRITE_THEM
            raise fault("A model of CalculiX", f"must have {file.name} beside {path.name}", "missing", remedy)
    dofs = _names(names)
    entries = {letter: _entries(file) for letter, file in (("K", stiffness), ("M", mass))}
    if len(entries["K"]) != len(entries["M"]):
        raise fault(mass.name, f"must have as many lines as {stiffness.name}, {len(entries['K'])}", len(entries["M"]), CUT_SHORT)
    differing = np.flatnonzero(np.any(entries["K"][:, :2] != entries["M"][:, :2], axis=1))
    if differing.size:
        line = int(differing[0])
        raise fault(
            f"Line {line + 1} of {mass.name}",
            f"must have the row and column of that of {stiffness.name}",
            entries["M"][line, :2].tolist(),
        )
    matrices = {letter: _matrix(file, entries[letter], len(dofs)) for letter, file in (("K", stiffness), ("M", mass))}
    deck = path.with_suffix(".inp")
    found = read_deck(deck) if deck.is_file() else Deck()
    missing = (f"No {deck.name} beside the matrices: no coordinates and no sets of nodes.",)
    return Content(
        "CalculiX matrices", matrices, dofs, found.nodes, found.sets, found.notes if deck.is_file() else missing, found.cells
    )


def _entries(path: Path) -> Array:
    """Lines "row column value", (entries, 3); the last one whole."""
    if not path.stat().st_size:
        raise fault(path.name, "must hold a matrix", "empty", WRITE_THEM)
    refuse_cut(path, CUT_SHORT)
    return table(path, 3)


def _matrix(path: Path, entries: Array, size: int) -> Sparse:
    """One triangle in the file, both in the matrix."""
    rows, columns = (whole(f"Rows of {path.name}", entries[:, k], 1, size) - 1 for k in (0, 1))
    if np.any(rows > columns) and np.any(rows < columns):
        raise fault(path.name, "must hold one triangle", "entries on both sides of the diagonal")
    return both_triangles(path.name, triplets(path.name, rows, columns, entries[:, 2], size))


def _names(path: Path) -> tuple[str, ...]:
    """NODE.DIRECTION of each row."""
    found = []
    for line in path.read_text(encoding="ascii", errors="replace").split():
        node, dot, direction = line.partition(".")
        if not (dot and node.isdecimal() and direction in DIRECTIONS):
            raise fault(f"A line of {path.name}", "must be NODE.DIRECTION with a direction of 1 to 6", line[:40])
        found.append(dof(node, int(direction)))
    if not found:
        raise fault(path.name, "must hold a line NODE.DIRECTION for each row", "empty", WRITE_THEM)
    return tuple(found)
