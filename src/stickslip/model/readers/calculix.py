"""CalculiX: the matrices of *FREQUENCY, SOLVER=MATRIXSTORAGE (.sti, .mas, .dof) with nodes and sets of the deck (.inp) beside.

`ccx blade` leaves blade.sti and blade.mas, one triangle each as lines "row column value", rows counted from 1, and blade.dof
with a line NODE.DIRECTION for each row; fixed degrees of freedom have none. (CalculiX CrunchiX User's Manual, *FREQUENCY.)

Of a deck of Abaqus or CalculiX without any of these files, M and K are assembled here from its mesh, materials and supports.
What such a deck says beside these and would change the matrices is refused by name; loads have no part in them, and a note says
so. (CalculiX CrunchiX User's Manual: *BOUNDARY, *SOLID SECTION; Abaqus Keywords Guide: *BOUNDARY.)
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from stickslip.model.readers.deck import CardList, Deck
from stickslip.model.readers.input_cards import MODEL_CARDS, Card, Solids, fields, label
from stickslip.model.readers.input_deck import read_deck
from stickslip.model.readers.model import Content, dof
from stickslip.model.readers.numbers import coordinate, refuse_cut, table, triplets, whole
from stickslip.model.structure.matrices import Point, Sparse, both_triangles
from stickslip.model.structure.solid import NODES, Group, mesh_matrices
from stickslip.support.checks import Array, InputError, counted, fault, finite, first_of, nearest

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


MESH_CARDS = CardList.of("mesh", sign="*")
LET_CALCULIX = "Or let CalculiX write the matrices: *FREQUENCY, SOLVER=MATRIXSTORAGE in a *STEP (docs/calculix.md)."
NAMED = {"ENCASTRE": "1,6", "PINNED": "1,3", "XSYMM": "1,1", "YSYMM": "2,2", "ZSYMM": "3,3"}
"""Supports that have a name, and the first and the last direction that they fix at a node of a solid."""
OF_MESHERS = ("CPS", "T3D", "S3", "S4", "S6", "S8")
"""How kinds of elements begin that gmsh and FreeCAD write for faces and edges of solids."""
NO_LOADS = ("STEP", "STATIC", "FREQUENCY", "FILE", "PRINT", "OUTPUT")
"""How cards of a step end that are no loads."""
Support = tuple[Sequence[str], int, int]


def assembled(file: str, deck: Deck) -> Content:
    """The model of a deck: a row for each direction in which a node of its elements can move, in the order of the numbers."""
    if deck.solids is None:
        raise fault("A deck without matrices", "must hold one instance with all elements written out", "another", LET_CALCULIX)
    densities, supports, loads = _obeyed(deck)
    elements = _elements(deck.solids, deck.nodes)
    names = sorted({node for own in elements.values() for nodes in own.values() for node in nodes}, key=int)
    index = {name: place for place, name in enumerate(names)}
    materials = {name: deck.solids.material(name, densities.get(name, ())) for _, name in elements}
    groups = [
        Group(kind, materials[name], tuple(own), np.array([[index[node] for node in nodes] for nodes in own.values()]))
        for (kind, name), own in elements.items()
    ]
    points = np.array([[finite(f"The coordinates of node {name}", x) for x in deck.nodes[name]] for name in names])
    M, K = mesh_matrices(points, groups)
    fixed = np.zeros(points.shape, dtype=bool)
    for nodes, first, last in supports:
        fixed[[index[node] for node in nodes if node in index], first - 1 : last] = True
    for node in deck.turned.axes.keys() & index.keys():
        if 0 < fixed[index[node]].sum() < 3:
            rule = "must fix all three directions of a node with axes of its own (*TRANSFORM), or none"
            raise fault("*BOUNDARY", rule, f"one or two of node {node}", LET_CALCULIX)
    free = np.flatnonzero(~fixed)
    parts = [f"{counted(len(own), 'element')} {kind} of {name}" for (kind, name), own in elements.items()]
    of = [f"{name} with E = {m.young:g}, ν = {m.poisson:g}, density {m.density:g}" for name, m in materials.items()]
    notes = [
        f"M and K are assembled from the mesh of {file}, without a run: {first_of(parts)} ({'; '.join(of)}); mass "
        f"{M.sum() / 3.0:.6g} in the units of the deck; *BOUNDARY holds {counted(int(fixed.any(axis=1).sum()), 'node')}."
    ]
    if left := len(deck.solids.kinds) - sum(map(len, elements.values())):
        kinds = sorted({kind for kind in deck.solids.kinds.values() if kind not in NODES})
        notes.append(f"{counted(left, 'element')} without a section ({first_of(kinds)}) are left out of M and K.")
    if loads:
        notes.append(f"Of the steps of {file}, *BOUNDARY alone counts, not {first_of(list(dict.fromkeys(loads)))}.")
    matrices = {"M": M[free][:, free], "K": K[free][:, free]}
    dofs = tuple(dof(names[row // 3], row % 3 + 1) for row in free.tolist())
    return Content("mesh of a deck", matrices, dofs, deck.nodes, deck.sets, (*notes, *deck.notes), deck.cells, deck.solids)


def _obeyed(deck: Deck) -> tuple[dict[str, list[Card]], list[Support], list[str]]:
    """The *DENSITY cards by material, the supports in force in the last step, and the cards of steps that have no effect."""
    densities, supports, loads = dict[str, list[Card]](), list[Support](), list[str]()
    material, new_step = "", False
    for card, in_step in deck.others:
        new_step |= card.keyword == "STEP"
        if card.keyword == "MATERIAL":
            material = card.name("NAME")
        elif card.keyword == "DENSITY":
            densities.setdefault(material, []).append(card)
        elif card.keyword == "BOUNDARY":
            if new_step and card.name("OP") == "NEW":
                supports.clear()
            new_step = False
            supports += _supports(card, deck)
        elif in_step and not card.keyword.startswith(("CHANGE ", "MODEL CHANGE")):
            loads += [] if card.keyword.endswith(NO_LOADS) else [f"*{card.keyword}"]
        elif card.keyword not in MESH_CARDS.harmless | MODEL_CARDS.obeyed:
            rule = "must hold cards that count where stickslip assembles the matrices"
            remedy = MESH_CARDS.refused.get(card.keyword, "Delete it if it changes nothing.")
            raise fault(card.line.place, rule, f"*{card.keyword}", f"{remedy} {LET_CALCULIX}")
    return densities, supports, loads


def _supports(card: Card, deck: Deck) -> Iterator[Support]:
    """Nodes that one *BOUNDARY fixes, and the first and the last direction."""
    for option in card.options.keys() - {"OP", "FIXED", "AMPLITUDE", "TYPE", ""}:
        raise fault(f"{card.line.place}, *BOUNDARY", "must fix nodes", option, LET_CALCULIX)
    for line in card.data:
        what = f"{card.line.place}, *BOUNDARY, {line[:60]}:"
        where, *words = (label(word) for word in [*fields(line), "", "", ""])
        bare = where.rpartition(".")[2].lstrip("0")
        if where not in deck.sets and bare not in deck.nodes:
            remedy = nearest(where, deck.sets) if deck.sets else "gmsh writes sets of nodes with Mesh.SaveGroupsOfNodes = 1."
            raise fault(what, "must begin with a node or a set of nodes", where, remedy)
        start, end = fields(NAMED[words[0]]) if words[0] in NAMED else (words[0], words[1] or words[0])
        if not {start, end} <= set("123456") or start > end:
            raise fault(what, "must fix directions from 1 to 6", words[:2])
        if coordinate(words[2]):
            raise fault(what, "must hold the nodes at 0", words[2], LET_CALCULIX)
        yield deck.sets.get(where, (bare,)), int(start), int(end)


def _elements(solids: Solids, known: Mapping[str, Point]) -> dict[tuple[str, str], dict[str, list[str]]]:
    """The nodes of each element, by its kind and the name of its material."""
    material = {element: name for members, name in solids.sections for element in members}
    found: dict[tuple[str, str], dict[str, list[str]]] = {}
    for element, words in solids.nodes.items():
        kind, nodes = solids.kinds[element], [word.lstrip("0") for word in words]
        what = f"Element {element} ({kind})"
        if kind.startswith(OF_MESHERS) and element not in material:
            continue  # without a section it has no stiffness
        if kind not in NODES:
            raise fault(what, f"must be one of {', '.join(NODES)}", kind, LET_CALCULIX)
        if element in solids.repeated:
            raise fault(what, "must be defined once", "defined again", "Delete one of the two, or number it anew.")
        if not len(set(nodes)) == len(nodes) == NODES[kind]:
            raise fault(what, f"must name {NODES[kind]} different nodes", f"with {', '.join(nodes)}")
        if not known.keys() >= set(nodes):
            raise fault(what, "must have all its nodes in *NODE", f"with {', '.join(set(nodes) - known.keys())} missing")
        if element not in material:
            raise fault(what, "must be in the ELSET of a *SOLID SECTION", "in none", "Give its ELSET a section with a material.")
        found.setdefault((kind, material[element]), {})[element] = nodes
    if not found:
        raise fault("A deck without matrices", "must hold solid elements", "without", f"Add *ELEMENT. {LET_CALCULIX}")
    of_order: tuple[set[str], set[str]] = set(), set()
    for (kind, _), own in found.items():
        of_order[kind in ("C3D4", "C3D8")].update(*own.values())
    if common := of_order[0] & of_order[1]:
        rule = "must have no nodes in common: between these the mesh would gape"
        raise fault("Linear and quadratic elements", rule, f"joined at node {min(common, key=int)}", "Mesh the body anew.")
    return found
