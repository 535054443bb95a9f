"""The matrices of a deck of Abaqus or CalculiX that comes without a run: M and K assembled from its mesh, materials and supports.

What a deck says beside these and would change the matrices is refused by name; loads have no part in them, and a note says so.
(CalculiX CrunchiX User's Manual: *BOUNDARY, *SOLID SECTION; Abaqus Keywords Guide: *BOUNDARY.)
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from stickslip.model.readers.deck import CardList, Deck
from stickslip.model.readers.input_cards import MODEL_CARDS, Card, Physics, Solids, constants, fields, label
from stickslip.model.readers.model import Content, dof
from stickslip.model.readers.numbers import coordinate, integer
from stickslip.model.structure.elements import NODES, Group, mesh_matrices
from stickslip.model.structure.solid import Material
from stickslip.support.checks import InputError, counted, fault, finite, first_of, nearest

MESH_CARDS = CardList.of("mesh", sign="*")
LET_CALCULIX = "Or let CalculiX write the matrices: *FREQUENCY, SOLVER=MATRIXSTORAGE in a *STEP (docs/calculix.md)."
NAMED = {"ENCASTRE": "1,6", "PINNED": "1,3", "XSYMM": "1,1", "YSYMM": "2,2", "ZSYMM": "3,3"}
"""Supports that have a name, and the first and the last direction that they fix at a node of a solid."""
SUPPORT_OPTIONS = {"OP", "FIXED", "AMPLITUDE", "TYPE", ""}
NO_LOADS = ("STEP", "STATIC", "FREQUENCY", "FILE", "PRINT", "OUTPUT", "BOUNDARY")
"""How cards of a step end that are no loads."""
QUADRATIC = ("C3D10", "C3D20", "C3D20R")


def assembled(file: str, deck: Deck) -> Content:
    """The model of a deck, with a row for each direction in which a node of its elements can move, in the order of the numbers."""
    solids, physics = deck.solids, deck.physics
    if physics is None or solids is None:
        raise fault("A deck without matrices", "must hold one instance with all elements written out", "another", LET_CALCULIX)
    for keyword, place in physics.places.items():
        if keyword not in MESH_CARDS.harmless | MODEL_CARDS.obeyed:
            remedy = MESH_CARDS.refused.get(keyword, "Delete it if it changes nothing.")
            rule = "must hold cards that count where stickslip assembles the matrices"
            raise fault(place, rule, f"*{keyword}", f"{remedy} {LET_CALCULIX}")
    elements = _elements(solids, physics, deck)
    names = sorted({node for group in elements.values() for nodes in group.values() for node in nodes}, key=int)
    index = {name: place for place, name in enumerate(names)}
    materials = {name: _material(name, solids, physics) for _, name in elements}
    groups = [
        Group(kind, materials[name], tuple(own), np.array([[index[node] for node in nodes] for nodes in own.values()]))
        for (kind, name), own in elements.items()
    ]
    points = np.array([[finite(f"The coordinates of node {name}", x) for x in deck.nodes[name]] for name in names])
    M, K, masses = mesh_matrices(points, groups)
    fixed = _fixed(physics, deck, index)
    free = np.flatnonzero(~fixed.ravel())
    dofs = tuple(dof(names[row // 3], row % 3 + 1) for row in free.tolist())
    parts = [
        f"{counted(len(group.names), 'element')} {group.kind} of {name} (E = {group.material.young:g}, Poisson's ratio "
        f"{group.material.poisson:g}, density {group.material.density:g}; mass {mass:.6g})"
        for (_, name), group, mass in zip(elements, groups, masses, strict=True)
    ]
    notes = [
        f"M and K are assembled here from {file}, beside which there are no matrices, in the units of the deck: {first_of(parts)}. "
        f"*BOUNDARY holds {counted(int(fixed.any(axis=1).sum()), 'node')}."
    ]
    if loads := [f"*{keyword}" for keyword in physics.loads if not keyword.endswith(NO_LOADS)]:
        notes.append(f"Of the steps of {file}, *BOUNDARY alone counts, not {first_of(loads)}.")
    matrices = {"M": M[free][:, free], "K": K[free][:, free]}
    return Content(
        "deck, assembled by stickslip", matrices, dofs, deck.nodes, deck.sets, (*notes, *deck.notes), deck.cells, solids
    )


def _elements(solids: Solids, physics: Physics, deck: Deck) -> dict[tuple[str, str], dict[str, list[str]]]:
    """The nodes of each element, by its kind and the name of its material."""
    if physics.repeated:
        raise fault("Each element of the deck", "must be defined once", f"element {physics.repeated[0]} twice", "Delete one.")
    material = {element: name for members, name in solids.sections for element in members}
    found: dict[tuple[str, str], dict[str, list[str]]] = {}
    order: dict[str, tuple[bool, str]] = {}
    for element, words in solids.nodes.items():
        kind = solids.kinds[element]
        if kind not in NODES:
            raise fault(f"Element {element}", f"must be one of {', '.join(NODES)}", kind, LET_CALCULIX)
        nodes = [word.lstrip("0") for word in words]
        if len(set(nodes)) != NODES[kind] or len(nodes) != NODES[kind]:
            raise fault(f"Element {element} ({kind})", f"must name {NODES[kind]} different nodes", f"with {', '.join(nodes)}")
        for node in nodes:
            if node not in deck.nodes:
                raise fault(f"The nodes of element {element} ({kind})", "must stand in *NODE", f"node {node} without coordinates")
            other = order.setdefault(node, (kind in QUADRATIC, element))
            if other[0] != (kind in QUADRATIC):
                rule = "must all be linear or all be quadratic: the mesh would gape between their nodes"
                raise fault(
                    f"Elements with common nodes, {other[1]} and {element},", rule, f"joined at node {node}", "Mesh it anew."
                )
        if element not in material:
            remedy = "Give all elements in its ELSET a section, one after the other."
            raise fault(f"Element {element} ({kind})", "must be in the ELSET of a *SOLID SECTION", "in none", remedy)
        found.setdefault((kind, material[element]), {})[element] = nodes
    if not found:
        raise fault("A deck without matrices", "must hold solid elements", "without", f"Add *ELEMENT. {LET_CALCULIX}")
    return found


def _material(name: str, solids: Solids, physics: Physics) -> Material:
    """E, ν and ρ of a material, in the units of the deck."""
    if name not in solids.materials:
        remedy = nearest(name, solids.materials)
        raise fault("MATERIAL of *SOLID SECTION", "must be a *MATERIAL of the deck with *ELASTIC", name, remedy)
    elastic = solids.elastic(name)
    try:
        (density,) = constants("must have one line of *DENSITY", physics.densities.get(name, ()), 1)
        return replace(elastic, density=density)
    except InputError as error:
        raise InputError(f"The material {name}: {error}") from None


def _fixed(physics: Physics, deck: Deck, index: Mapping[str, int]) -> np.ndarray:
    """Whether *BOUNDARY fixes each direction of each node, (nodes, 3)."""
    fixed = np.zeros((len(index), 3), dtype=bool)
    for card in physics.supports:
        for nodes, first, last in _supports(card, deck):
            places = [index[node] for node in nodes if node in index]
            fixed[places, first - 1 : last] = True
    for node in deck.turned.axes:
        if node in index and 0 < fixed[index[node]].sum() < 3:
            rule = "must fix all three directions of a node with axes of its own (*TRANSFORM), or none"
            raise fault("*BOUNDARY", rule, f"one or two of node {node}", LET_CALCULIX)
    return fixed


def _supports(card: Card, deck: Deck) -> Iterator[tuple[tuple[str, ...], int, int]]:
    """Nodes, and the first and the last direction in which they are fixed."""
    for option in card.options.keys() - SUPPORT_OPTIONS:
        raise fault(f"{card.line.place}, *BOUNDARY", "must fix nodes", option, LET_CALCULIX)
    for line in card.data:
        what = f"{card.line.place}, *BOUNDARY, {line[:60]}:"
        where, *words = (label(word) for word in [*fields(line), "", ""])
        bare = where.rpartition(".")[2].lstrip("0")
        if where not in deck.sets and bare not in deck.nodes:
            raise fault(what, "must begin with a node or a set of nodes", where, nearest(where, deck.sets))
        numbers = fields(NAMED[words[0]]) if words[0] in NAMED else words
        first, last = integer(numbers[0]), integer(numbers[1] or numbers[0])
        if not 1 <= first <= last <= 6:
            raise fault(what, "must fix directions from 1 to 6", [first, last])
        if value := coordinate(words[2]):
            raise fault(what, "must hold the nodes at 0", value, LET_CALCULIX)
        yield deck.sets.get(where, (bare,)), first, last
