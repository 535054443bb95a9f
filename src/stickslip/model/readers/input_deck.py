"""Input decks of Abaqus and CalculiX: node coordinates, node sets and the corners of elements.

Nodes stand in the deck itself or in parts, which instances place in an assembly: moved first, then turned about an axis. The
nodes of the only instance keep their numbers; those of several are INSTANCE.NUMBER, as the assembly itself calls them.
(Abaqus Keywords Guide: *NODE, *NGEN, *NFILL, *SYSTEM, *NSET, *ELSET, *INSTANCE; Analysis Guide: Defining an assembly.)
"""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from stickslip.model.readers.deck import (
    GLOBAL,
    MOST_GENERATED,
    MOST_MADE,
    PLATES,
    SOLIDS,
    CardsMet,
    Deck,
    FoundCells,
    Frame,
    Lines,
    NodeAxes,
    Turning,
    between,
    cartesian,
    frame,
    on_line,
    turned_about,
    turning_points,
)
from stickslip.model.readers.input_cards import MODEL_CARDS, Card, Solids, cards, fields, included, label
from stickslip.model.readers.model import given_twice, located_once
from stickslip.model.readers.numbers import coordinate, integer
from stickslip.model.structure.matrices import Point
from stickslip.support.checks import Array, InputError, fault, nearest

ELEMENT = re.compile(r"[DA]?(C3D|SC|S|STRI|M3D)(\d{1,2})(?!V)[A-Z]*\d?[A-Z]*")
"""Names of elements with faces: family and number of nodes, which those with V have a choice of."""
SHAPES = {
    **{("C3D", nodes): kind for kind, counts in SOLIDS.items() for nodes in counts},
    **{(family, nodes): kind for family in ("S", "STRI", "M3D") for kind, counts in PLATES.items() for nodes in counts},
    ("SC", 6): "wedge",
    ("SC", 8): "hexahedron",
}
NUMBERED_ANEW = (
    "{file} is an assembly: its nodes are called INSTANCE.NUMBER, such as {node}. Abaqus renumbers the nodes of an assembly in "
    "its matrices and lists the new numbers in the .dat file of the job. Give a table of rows (`names`) that names each row."
)
SET_OPTIONS = {"NSET", "ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED", "INPUT", ""}
"""Parameters of *NSET and *ELSET: a member after a comma at the end of the line must not be taken for one."""
Members = dict[str, dict[str, None]]
"""Nodes or elements by the name of a set, in the order of the deck."""


@dataclass
class Mesh:
    """Nodes, sets and elements of a part, an instance, or the deck itself with its assembly; `frame` is that of *SYSTEM.

    elements: all nodes by element; turned: *TRANSFORM by its set of nodes, which may stand after it; unsorted: sets whose
    members keep their order; kinds: names of the kinds of elements; sections: sets of elements and their materials; placed: the
    data lines that place an instance; repeated: elements that stand once more.
    """

    nodes: dict[str, Point] = field(default_factory=dict)
    sets: Members = field(default_factory=dict)
    elements: dict[str, tuple[str, ...]] = field(default_factory=dict)
    elsets: Members = field(default_factory=dict)
    cells: FoundCells = field(default_factory=FoundCells)
    turned: list[Turning] = field(default_factory=list)
    unsorted: set[str] = field(default_factory=set)
    kinds: dict[str, str] = field(default_factory=dict)
    sections: list[tuple[str, str]] = field(default_factory=list)
    frame: Frame = GLOBAL
    placed: list[str] = field(default_factory=list)
    repeated: list[str] = field(default_factory=list)


def read_deck(path: Path) -> Deck:
    """Nodes, sets of nodes and elements of a deck and the files that it includes."""
    lines = Lines(path, included, 15)
    reader, met, in_step = _Reader(lines), CardsMet(MODEL_CARDS), False
    for card in cards(lines.read()):
        in_step = card.keyword == "STEP" or (in_step and card.keyword != "END STEP")
        if card.keyword not in ("NODE", "ELEMENT", "NSET", "ELSET"):  # of these, the many lines are not kept
            reader.others.append((card, in_step))
        if card.keyword in READ or not in_step:
            try:
                if met.obeys(card.keyword, card.line.place):
                    READ[card.keyword](reader, card)
            except InputError as error:
                message = str(error)
                located = f"line {card.line.number}" in message
                raise error if located else InputError(f"{card.line.place}, *{card.keyword}: {message}") from None
    deck = reader.deck(path.name)
    deck.others = reader.others
    if met.missing:  # elements that are not read share the stress at a node
        deck.solids = None
    none = () if deck.nodes else (f"{path.name} holds no nodes.",)
    deck.notes = (*none, *reader.cut, *given_twice(reader.repeated, path.name), *deck.notes, *met.notes(path.name))
    return deck


class _Reader:
    """The deck as far as it is read: `mesh` is the one that cards speak of at present."""

    def __init__(self, lines: Lines) -> None:
        self.lines = lines
        self.whole = self.mesh = Mesh()
        self.parts: dict[str, Mesh] = {}
        self.instances: dict[str, Mesh] = {}
        self.made = self.listed = self.repeated = 0
        self.cut: list[str] = []
        self.material = ""
        self.materials: dict[str, list[Card]] = {}
        self.others: list[tuple[Card, bool]] = []

    def node(self, card: Card) -> None:
        kind = card.name("SYSTEM") or "R"
        points: list[tuple[str, Point]] = []
        for line in self._data(card):
            words = [*fields(line), "", "", ""]
            try:
                x, y, z = map(coordinate, words[1:4])
                points.append((str(integer(words[0])), (x, y, z)))
            except InputError:
                raise fault("A line of *NODE", "must hold a number and coordinates", line[:60]) from None
        for node, point in points:
            self.repeated += located_once(self.mesh.nodes, node, self.mesh.frame.place(cartesian(kind, point)))
        self._into_set(card, (node for node, _ in points))

    def ngen(self, card: Card) -> None:
        if card.name("SYSTEM") not in ("", "RC"):
            raise fault("SYSTEM of *NGEN", "must be RC", card.name("SYSTEM"), "Write the nodes out.")
        made: list[str] = []
        for line in card.data:
            words = [*fields(line), *[""] * 10][:10]
            first, last = (self._known(word) for word in words[:2])
            start, end, step = integer(first), integer(last), integer(words[2] or "1")
            if step < 1 or end <= start or (end - start) % step:
                raise fault("Generated nodes", "must lead from one number to a higher one in equal steps", line[:60])
            numbers = range(start, end + 1, step)
            self._make(len(numbers))
            extra: Point | None = None  # the point that an arc needs: a node, or coordinates
            if card.name("LINE"):
                x, y, z = self.mesh.nodes[self._known(words[3])] if words[3] else tuple(map(coordinate, words[4:7]))
                extra = x, y, z
            normal = tuple(coordinate(word) for word in words[7:10])
            if self.mesh.frame is not GLOBAL and (any(normal) or (extra is not None and not words[3])):
                raise fault("An arc of *NGEN", "must have a node as its centre where *SYSTEM is in force", line[:60])
            ends = self.mesh.nodes[first], self.mesh.nodes[last]
            points = on_line(card.name("LINE"), *ends, extra, normal, len(numbers) - 1)
            for number, point in zip(numbers[1:-1], points[1:-1], strict=True):
                self._add(str(number), point)
            made += map(str, numbers)
        self._into_set(card, made)

    def nfill(self, card: Card) -> None:
        for option in ("BIAS", "SINGULAR", "TWOSTEP"):
            if option in card.options and card.name(option) != "1":
                raise fault("*NFILL", "must have equal distances", option, "Write the nodes out.")
        made: list[str] = []
        for line in card.data:
            one, other, *counts = [*fields(line), "", ""][:4]
            ends = []
            for name in (one, other):  # of a set in ascending order, unless it is UNSORTED
                members = list(self._meant(label(name), self.mesh, "", "sets"))
                ends.append(members if label(name) in self.mesh.unsorted else sorted(members, key=int))
            if len(ends[0]) != len(ends[1]):
                raise fault("The sets of *NFILL", "must have the same number of nodes", [len(ends[0]), len(ends[1])])
            intervals, step = (integer(word or "1") for word in counts)
            self._make(intervals * len(ends[0]))
            for first, last in zip(*ends, strict=True):
                points = between(self.mesh.nodes[self._known(first)], self.mesh.nodes[self._known(last)], intervals)
                inner = [str(int(first) + k * step) for k in range(1, intervals)]
                for node, point in zip(inner, points[1:-1], strict=True):
                    self._add(node, point)
                made += [first, *inner, last]
        self._into_set(card, made)

    def system(self, card: Card) -> None:
        self.mesh.frame = frame([coordinate(word) for line in card.data for word in fields(line)])

    def nset(self, card: Card) -> None:
        if elsets := card.name("ELSET"):
            name, mesh, prefix = self._dotted(elsets, *self._scope(card), "elsets")
            members = [f"{prefix}{node}" for element in mesh.elsets[name] for node in self._nodes_of(mesh, element)]
        else:
            members = list(self._listed(card, "sets"))
        self._into_set(card, members)

    def elset(self, card: Card) -> None:
        own = self.mesh.elsets.setdefault(card.name("ELSET"), {})
        own.update(dict.fromkeys(self._listed(card, "elsets")))

    def element(self, card: Card) -> None:
        kind = card.name("TYPE")
        match = ELEMENT.fullmatch(kind)
        shape = SHAPES.get((match[1], int(match[2]))) if match else None
        size = int(match[2]) if match and shape else None
        own = self.mesh.elsets.setdefault(card.name("ELSET"), {})
        for words, whole in _elements(self._data(card), size):
            if shape is not None and whole:
                self.mesh.cells.add(shape, words[1:])
            self.mesh.cells.lost += not whole
            if words[0] in self.mesh.elements:
                self.mesh.repeated.append(words[0])
            self.mesh.elements[words[0]] = tuple(words[1:])
            self.mesh.kinds[words[0]] = kind
            own[words[0]] = None

    def solid_section(self, card: Card) -> None:
        self.mesh.sections.append((card.name("ELSET"), card.name("MATERIAL")))

    def named_material(self, card: Card) -> None:
        self.material = card.name("NAME")

    def elastic(self, card: Card) -> None:
        self.materials.setdefault(self.material, []).append(card)

    def transform(self, card: Card) -> None:
        numbers = [coordinate(word) for line in card.data for word in fields(line)]
        self.mesh.turned.append(Turning(card.name("NSET"), card.name("TYPE") or "R", *turning_points(numbers)))

    def part(self, card: Card) -> None:
        self.mesh = self.parts[card.name("NAME")] = Mesh()

    def instance(self, card: Card) -> None:
        for option in ("INSTANCE", "LIBRARY"):
            if option in card.options:
                raise fault(
                    "*INSTANCE", "must be of a part of this deck", f"{option} of another analysis", "Write the nodes out."
                )
        part = card.name("PART")
        if part not in self.parts:
            raise fault("PART of *INSTANCE", "must be a part of the deck", part, nearest(part, self.parts))
        self._make(len(self.parts[part].nodes))
        self._list(sum(map(len, (*self.parts[part].sets.values(), *self.parts[part].elsets.values()))))
        self.mesh = self.instances[card.name("NAME")] = deepcopy(self.parts[part])
        self.mesh.placed = card.data

    def end_instance(self, card: Card) -> None:
        rows = [[coordinate(word) for word in fields(line)] for line in self.mesh.placed]
        shift = np.array([*(rows[0] if rows else []), 0.0, 0.0, 0.0][:3])
        turn = rows[1] if len(rows) > 1 else []
        if len(rows) > 2 or len(turn) not in (0, 7) or (rows and len(rows[0]) > 3):
            rule = "must be placed by a translation, and a line of two points and an angle"
            raise fault("*INSTANCE", rule, self.mesh.placed[:3])
        moved = turned_about(shift, turn)
        self.mesh.nodes = {node: moved(point) for node, point in self.mesh.nodes.items()}
        self.mesh.turned = [each.moved(moved) for each in self.mesh.turned]
        self.mesh = self.whole

    def end_part(self, card: Card) -> None:
        self.mesh = self.whole

    def deck(self, file: str) -> Deck:
        """Everything under the names that the rows of the matrices have."""
        if self.instances:
            return self._assembled(file)
        whole = self.whole
        if len(self.parts) == 1 and not whole.nodes:  # CalculiX knows no parts: the nodes of one are those of the deck
            (part,) = self.parts.values()
            self.whole = whole = replace(part, sets=part.sets | whole.sets, turned=part.turned + whole.turned)
        sets = {name: tuple(members) for name, members in whole.sets.items()}
        return Deck(
            whole.nodes,
            sets,
            whole.cells.notes(file),
            whole.cells.cells,
            self._turned(file, {}, whole.nodes),
            solids=self._solids(whole),
        )

    def _assembled(self, file: str) -> Deck:
        """The deck of an assembly: nodes of the only instance keep their numbers, those of several are INSTANCE.NUMBER."""
        (first, only), *others = self.instances.items()
        # Rows of matrices have the plain numbers of the only instance, unless the assembly has nodes with the same ones.
        plain = not others and not only.nodes.keys() & self.whole.nodes.keys()
        names = {f"{first}.{node}": node for node in only.nodes} if plain else {}
        nodes, own = dict(self.whole.nodes), list[tuple[str, tuple[str, ...]]]()
        for instance, mesh in self.instances.items():
            named = {node: names.get(f"{instance}.{node}", f"{instance}.{node}") for node in mesh.nodes}
            nodes |= {named[node]: point for node, point in mesh.nodes.items()}
            own += [(f"{instance}.{name}", tuple(named.get(node, node) for node in each)) for name, each in mesh.sets.items()]
        sets = {name: tuple(names.get(node, node) for node in members) for name, members in self.whole.sets.items()}
        # A set that only one instance has may be named without it.
        bare = Counter(name.rpartition(".")[2] for name, _ in own)
        alone = {name.rpartition(".")[2]: each for name, each in own if bare[name.rpartition(".")[2]] == 1}
        notes = () if plain else (NUMBERED_ANEW.format(file=file, node=f"{first}.{next(iter(only.nodes), 1)}"),)
        cells = only.cells.cells if plain else {}
        solids = self._solids(only) if plain else None
        named_sets = alone | sets | dict(own)
        return Deck(nodes, named_sets, (*notes, *only.cells.notes(file)), cells, self._turned(file, names, nodes), solids=solids)

    def _solids(self, mesh: Mesh) -> Solids:
        sections = [(mesh.elsets.get(elset, {}).keys(), material) for elset, material in mesh.sections]
        elements, kinds = mesh.elements, mesh.kinds
        if self.instances:  # elements of the assembly itself, such as springs, have numbers of their own
            elements = elements | {f"{number} of the assembly": nodes for number, nodes in self.whole.elements.items()}
            kinds = kinds | {f"{number} of the assembly": kind for number, kind in self.whole.kinds.items()}
        return Solids(elements, kinds, sections, self.materials, mesh.repeated)

    def _turned(self, file: str, names: Mapping[str, str], nodes: Mapping[str, Point]) -> NodeAxes:
        """The axes of *TRANSFORM at nodes by their names in the matrices, `names` where these differ from INSTANCE.NUMBER."""
        meshes = [(self.whole, ""), *((mesh, f"{name}.") for name, mesh in self.instances.items())]
        axes: dict[str, Array | None] = {}
        for mesh, prefix in meshes:
            for each in mesh.turned:
                for own in self._meant(each.nset, mesh, prefix, "sets"):
                    node = names.get(own, own)
                    axes[node] = each.axes_at(nodes[node]) if node in nodes else None
        return NodeAxes(file, "*TRANSFORM, which Abaqus applies to rows", axes)

    def _data(self, card: Card) -> Iterable[str]:
        """The data lines of a card, those of its file if it names one."""
        if "INPUT" not in card.options:
            return card.data
        texts = (line.text.strip() for line in self.lines.of_file(card.options["INPUT"].strip("\"'"), card.line))
        return [*(text for text in texts if text and not text.startswith("**")), *card.data]

    def _make(self, number: int) -> None:
        """Count nodes that a card makes of others."""
        self.made += number
        if number < 0 or self.made > MOST_MADE:
            raise fault("Nodes that cards of the deck make", f"must be at most {MOST_MADE}", self.made)

    @property
    def _most_listed(self) -> int:
        return MOST_GENERATED + self.lines.size

    def _present(self, card: Card, span: range, known: Iterable[str]) -> list[int]:
        """Those of a long range that the deck holds; Abaqus leaves out the others, too."""
        found = sorted(number for name in known if name.isdecimal() and (number := int(name)) in span)
        what = "nodes" if card.keyword == "NSET" else "elements"
        name = card.name("NSET") or card.name("ELSET")
        held = f"names {len(span)} {what} in a range, of which the deck holds {len(found)} up to there"
        self.cut.append(f"*{card.keyword} {name} ({card.line.place}) {held}: the others are left out.")
        return found

    def _list(self, number: int) -> None:
        """Count members of sets: few bytes may name many."""
        self.listed += number
        if self.listed > self._most_listed:
            limit = f"must be at most {MOST_GENERATED} and one for each byte of the deck"
            raise fault("Members of the sets of the deck", limit, self.listed)

    def _add(self, node: str, point: Point) -> None:
        located_once(self.mesh.nodes, node, point)

    def _into_set(self, card: Card, members: Iterable[str]) -> None:
        if name := card.name("NSET"):
            if "UNSORTED" in card.options:
                self.mesh.unsorted.add(name)
            self.mesh.sets.setdefault(name, {}).update(dict.fromkeys(members))

    def _known(self, word: str) -> str:
        node = str(integer(word)) if word.isdecimal() else word
        if node not in self.mesh.nodes:
            raise fault("A node from which others are made", "must be defined before them", word)
        return node

    def _scope(self, card: Card) -> tuple[Mesh, str]:
        """The mesh that the numbers of a card belong to, and what stands before them in the assembly."""
        name = card.name("INSTANCE")
        if not name or self.mesh is not self.whole or not (self.parts or self.instances):
            return self.mesh, ""
        if name not in self.instances:
            raise fault("INSTANCE", "must be an instance of the assembly", name, nearest(name, self.instances))
        return self.instances[name], f"{name}."

    def _dotted(self, word: str, mesh: Mesh, prefix: str, kind: str) -> tuple[str, Mesh, str]:
        """A set by its name in its mesh: INSTANCE.NAME leads to that of the instance."""
        instance, _, name = word.rpartition(".")
        if word not in getattr(mesh, kind) and instance in self.instances:
            word, mesh, prefix = name, self.instances[instance], f"{instance}."
        known = getattr(mesh, kind)
        if word not in known:
            raise fault("A member of a set", "must be a number or a set defined before", word, nearest(word, known))
        return word, mesh, prefix

    def _meant(self, word: str, mesh: Mesh, prefix: str, kind: str) -> Iterator[str]:
        """The nodes or elements that a word of a data line means: one or those of a set."""
        instance, _, number = word.rpartition(".")
        if word.isdecimal():
            yield f"{prefix}{integer(word)}"
        elif instance in self.instances and number.isdecimal():
            yield f"{instance}.{integer(number)}"
        else:
            name, mesh, prefix = self._dotted(word, mesh, prefix, kind)
            yield from (f"{prefix}{member}" for member in getattr(mesh, kind)[name])

    def _listed(self, card: Card, kind: str) -> Iterator[str]:
        """The members that a card of a set lists: numbers, other sets, or first, last, step."""
        strange = next((option for option, value in card.options.items() if not value and option not in SET_OPTIONS), None)
        if strange is not None:
            known = ", ".join(sorted(SET_OPTIONS - {""}))
            raise fault(f"A parameter of *{card.keyword}", f"must be one of {known}", strange, "Is it a member of the set?")
        mesh, prefix = self._scope(card)
        for line in self._data(card):
            words = [label(word) for word in fields(line) if word]
            if "GENERATE" in card.options:
                try:
                    first, last, step = (integer(word) for word in (*words, "1")[:3])
                    span = range(first, last + 1, step)
                except (InputError, ValueError):
                    raise fault("A line of *NSET, GENERATE", "must hold first, last and step", line[:60]) from None
                numbers: Sequence[int] = span
                if len(span) > self._most_listed - self.listed:
                    numbers = self._present(card, span, mesh.nodes if kind == "sets" else mesh.elements)
                self._list(len(numbers))
                yield from (f"{prefix}{number}" for number in numbers)
            else:
                for word in words:
                    members = list(self._meant(word, mesh, prefix, kind))
                    self._list(len(members))
                    yield from members

    def _nodes_of(self, mesh: Mesh, element: str) -> Iterable[str]:
        """The nodes of an element, 5 or P-1.5."""
        instance, _, number = element.rpartition(".")
        if instance in self.instances:
            return (f"{instance}.{node}" for node in self._nodes_of(self.instances[instance], number))
        if element not in mesh.elements:
            raise fault("The elements of *NSET, ELSET=", "must stand in the deck", element, "Write the nodes of the set out.")
        return mesh.elements[element]


READ: Mapping[str, Callable[[_Reader, Card], None]] = {
    "NODE": _Reader.node,
    "NGEN": _Reader.ngen,
    "NFILL": _Reader.nfill,
    "NSET": _Reader.nset,
    "ELEMENT": _Reader.element,
    "ELSET": _Reader.elset,
    "SYSTEM": _Reader.system,
    "TRANSFORM": _Reader.transform,
    "PART": _Reader.part,
    "END PART": _Reader.end_part,
    "ASSEMBLY": _Reader.end_part,
    "END ASSEMBLY": _Reader.end_part,
    "INSTANCE": _Reader.instance,
    "END INSTANCE": _Reader.end_instance,
    "SOLID SECTION": _Reader.solid_section,
    "MATERIAL": _Reader.named_material,
    "ELASTIC": _Reader.elastic,
}
"""What each card that counts does."""


def _elements(data: Iterable[str], size: int | None) -> Iterator[tuple[list[str], bool]]:
    """Elements over one or more lines each, number and nodes, and whether they are whole; of an unknown number of nodes, a line
    that ends in a comma goes on."""
    words: list[str] = []
    for line in data:
        words += [word.upper() for word in fields(line) if word]
        if len(words) > size if size is not None else not line.endswith(","):
            yield words, True
            words = []
    if words:
        yield words, size is None
