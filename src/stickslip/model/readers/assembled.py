"""The matrices of a deck of Abaqus or CalculiX that comes without a run: M and K assembled from its mesh, materials and supports.

What a deck says beside these and would change the matrices is refused by name; loads have no part in them, and a note says so.
(CalculiX CrunchiX User's Manual: *BOUNDARY, *SOLID SECTION; Abaqus Keywords Guide: *BOUNDARY.)
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from stickslip.model.readers.deck import CardList, Deck
from stickslip.model.readers.input_cards import MODEL_CARDS, Card, Solids, fields, label
from stickslip.model.readers.model import Content, dof
from stickslip.model.readers.numbers import coordinate
from stickslip.model.structure.matrices import Point
from stickslip.model.structure.solid import NODES, Group, mesh_matrices
from stickslip.support.checks import counted, fault, finite, first_of, nearest

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
