"""CalculiX: the matrices of *FREQUENCY, SOLVER=MATRIXSTORAGE (.sti, .mas, .dof) with nodes and sets of the deck (.inp) beside.

`ccx blade` leaves blade.sti and blade.mas, one triangle each as lines "row column value", rows counted from 1, and blade.dof
with a line NODE.DIRECTION for each row; fixed degrees of freedom have none. (CalculiX CrunchiX User's Manual, *FREQUENCY.)
Of a deck without any of these files, the matrices are assembled here.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from stickslip.model.readers.assembled import assembled
from stickslip.model.readers.deck import Deck
from stickslip.model.readers.input_deck import read_deck
from stickslip.model.readers.model import Content, dof
from stickslip.model.readers.numbers import refuse_cut, table, triplets, whole
from stickslip.model.structure.sparse import Sparse, both_triangles
from stickslip.support.checks import Array, InputError, counted, fault

ENDINGS = (".sti", ".mas", ".dof")
DIRECTIONS = ("1", "2", "3", "4", "5", "6")
CUT_SHORT = "One of the two files was cut short: copy them again."
WRITE_THEM = "*FREQUENCY, SOLVER=MATRIXSTORAGE in the deck writes it."


def read(path: Path) -> Content:
    """The model of a run of which `path` is any of .sti, .mas, .dof or .inp, or of a deck alone."""
    stiffness, mass, names = run = tuple(path.with_suffix(ending) for ending in ENDINGS)
    if path.suffix.lower() == ".inp" and not any(file.exists() or file.with_name(f"{file.name}.gz").exists() for file in run):
        return assembled(path.name, read_deck(path))
    for file in (stiffness, mass, names):
        if not file.is_file():
            packed = file.with_name(f"{file.name}.gz")
            remedy = f"Unpack it: gunzip {packed.name}" if packed.is_file() else WRITE_THEM
            raise InputError(
                f"A model of CalculiX must have {file.name} beside {path.name}, but the file does not exist. {remedy}"
            )
    dofs, several = _names(names)
    entries = {}
    for letter, file in (("K", stiffness), ("M", mass)):
        if not file.stat().st_size:
            raise fault(file.name, "must hold a matrix", "empty", WRITE_THEM)
        refuse_cut(file, CUT_SHORT)
        entries[letter] = table(file, 3)
    # CalculiX writes both matrices over the same pattern of entries: a lost or damaged line of one shows beside the other.
    if len(entries["K"]) != len(entries["M"]):
        raise fault(mass.name, f"must have as many lines as {stiffness.name}, {len(entries['K'])}", len(entries["M"]), CUT_SHORT)
    differing = np.flatnonzero(np.any(entries["K"][:, :2] != entries["M"][:, :2], axis=1))
    if differing.size:
        line = int(differing[0])
        raise fault(
            f"Line {line + 1} of {mass.name}",
            f"must have the same row and column as in {stiffness.name}",
            entries["M"][line, :2].tolist(),
        )
    matrices = {letter: _matrix(file, entries[letter], len(dofs)) for letter, file in (("K", stiffness), ("M", mass))}
    beside = path.with_suffix(".inp")
    deck = read_deck(beside) if beside.is_file() else Deck()
    missing = (f"No {beside.name} beside the matrices: no coordinates and no sets of nodes.",)
    notes = deck.notes if beside.is_file() else missing
    if not several:
        return Content("CalculiX matrices", matrices, dofs, deck.nodes, deck.sets, notes, deck.cells, deck.solids)
    nodes = {node: point for node, point in deck.nodes.items() if node not in several}
    sets = {name: tuple(own for node in each for own in several.get(node, [node])) for name, each in deck.sets.items()}
    return Content("CalculiX matrices", matrices, dofs, nodes, sets, (*notes, _expanded(names.name, several)))


def _matrix(path: Path, entries: Array, size: int) -> Sparse:
    """One triangle in the file, both in the matrix."""
    if entries[:, :2].max() == 2 * size:
        raise fault(
            path.name,
            f"must be of the {size} rows of its .dof",
            f"{2 * size}: the real and the imaginary part of one nodal diameter of a cyclic analysis",
            "Write the matrices with CYCMPC=INACTIVE, or without *CYCLIC SYMMETRY MODEL: stickslip joins the faces itself.",
        )
    rows, columns = (whole(f"Rows of {path.name}", entries[:, k], 1, size) - 1 for k in (0, 1))
    if np.any(rows > columns) and np.any(rows < columns):
        raise fault(path.name, "must hold one triangle", "entries on both sides of the diagonal")
    return both_triangles(path.name, triplets(path.name, rows, columns, entries[:, 2], size))


def _expanded(file: str, several: Mapping[str, Sequence[str]]) -> str:
    """A note on the nodes that CalculiX made of one of a shell or beam, with the first as the example."""
    node, names = next(iter(several.items()))
    nodes = f"{counted(len(several), 'node')} of shells or beams"
    return (
        f"CalculiX expands shells and beams into solids, so {file} names {nodes} several times. The nodes made of node {node} "
        f"are called {', '.join(names)} here, in the order of the rows and without coordinates. "
        "If all but one of them are fixed, this one keeps the number and the coordinates of the original node."
    )


def _names(path: Path) -> tuple[tuple[str, ...], dict[str, list[str]]]:
    """NODE.DIRECTION of each row; and by node the names of those that CalculiX made of one of a shell or beam, 17-1, 17-2, ...

    Their rows follow one another: a direction that is not beyond the one before begins the next.
    """
    rows: list[tuple[str, int]] = []
    for line in path.read_text(encoding="ascii", errors="replace").split():
        node, dot, direction = line.partition(".")
        if not (dot and node.isdecimal() and direction in DIRECTIONS):
            raise fault(f"A line of {path.name}", "must be NODE.DIRECTION with a direction of 1 to 6", line[:40])
        rows.append((node, int(direction)))
    if not rows:
        raise fault(path.name, "must hold a line NODE.DIRECTION for each row", "empty", WRITE_THEM)
    parts: dict[str, int] = {}
    numbered: list[tuple[str, int, int]] = []
    last: tuple[str, int] = "", 0
    for node, number in rows:
        if node != last[0] or number <= last[1]:
            parts[node] = parts.get(node, 0) + 1
        numbered.append((node, parts[node], number))
        last = node, number
    several = {node: [f"{node}-{part}" for part in range(1, parts[node] + 1)] for node in parts if parts[node] > 1}
    names = (dof(f"{node}-{part}" if node in several else node, number) for node, part, number in numbered)
    return tuple(names), several
