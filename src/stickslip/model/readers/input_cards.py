"""Cards of the input decks of Abaqus and CalculiX: how they are written, and which of them say something about nodes.

The lists hold model data alone: what stands between *STEP and *END STEP cannot make, move or turn nodes.
(Abaqus Keywords Guide; CalculiX CrunchiX User's Manual, Input deck format.)

The solid elements of a deck with their materials, from which stress is recovered.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import NamedTuple

from stickslip.model.readers.deck import CardList, Line
from stickslip.model.readers.numbers import coordinate
from stickslip.model.structure.solid import Material
from stickslip.support.checks import InputError, fault, nearest

COMMA = re.compile(r',(?=(?:[^"]*"[^"]*")*[^"]*$)')
"""A comma outside of quotation marks."""
PARAMETER = re.compile(r"[A-Za-z]")
"""How a parameter begins."""


@dataclass(frozen=True)
class Card:
    """A keyword with its options, names in capitals, and its data lines; file names keep their letters."""

    keyword: str
    options: dict[str, str]
    data: list[str]
    line: Line

    def name(self, option: str) -> str:
        """A name that an option gives, as `label` has it."""
        return label(self.options.get(option, ""))


def cards(lines: Iterable[Line]) -> Iterator[Card]:
    """Each keyword with its data lines; comments and blank lines are left out."""
    card: Card | None = None
    for line in _joined(lines):
        if line.text.startswith("*"):
            if card is not None:
                yield card
            card = _card(line)
        elif card is not None:
            card.data.append(line.text)
    if card is not None:
        yield card


def _joined(lines: Iterable[Line]) -> Iterator[Line]:
    """Keyword lines that end in a comma with the lines on which they go on, all others as they are.

    A number is no parameter: before one the comma is one too many, as CalculiX takes it.
    """
    unfinished: Line | None = None
    for line in lines:
        text = line.text.strip()
        if text.startswith("**") or not text:
            continue
        if unfinished is not None and PARAMETER.match(text):
            unfinished = unfinished._replace(text=unfinished.text + text)
            if not text.endswith(","):
                yield unfinished
                unfinished = None
            continue
        if unfinished is not None:
            yield unfinished
        unfinished = line._replace(text=text) if text.startswith("*") and text.endswith(",") else None
        if unfinished is None:
            yield line._replace(text=text)
    if unfinished is not None:
        yield unfinished


def _card(line: Line) -> Card:
    keyword, *words = _split(line.text[1:])
    pairs = (word.partition("=") for word in words)
    options = {"".join(name.upper().split()): value.strip() for name, _, value in pairs}
    compact = "".join(keyword.upper().split())
    return Card(SPACED.get(compact, compact), options, [], line)


def included(text: str, more: Iterator[str]) -> str | None:
    """The file of *INCLUDE, INPUT=FILE."""
    if text[:8].upper() != "*INCLUDE":
        return None
    while text.rstrip().endswith(","):
        text = text.rstrip() + next(more, "")
    return _card(Line(text.strip(), "", 0)).options.get("INPUT", "").strip("\"' ")


def fields(line: str) -> list[str]:
    """The entries of a data line."""
    return [word.strip() for word in _split(line.rstrip(","))]


def label(word: str) -> str:
    """A label in capitals and without quotation marks, which also stand round one part of "Part 1-1".tip alone.

    Labels in quotation marks may hold blanks, commas and dots. Abaqus keeps their small letters; here these count as capitals.
    """
    return word.strip().replace('"', "").upper()


def _split(text: str) -> list[str]:
    """A line at its commas, but not at those within quotation marks."""
    return COMMA.split(text) if '"' in text else text.split(",")


MODEL_CARDS = CardList.of("abaqus", sign="*")
SPACED = {"".join(name.split()): name for name in (*MODEL_CARDS.known, "STEP", "END STEP")}
"""Keywords as the manuals write them; blanks in a keyword do not count."""


NO_STRESS = ("MASS", "SPRING", "DASHPOT", "ROTARYI", "GAP", "DCOUP")
"""How names of elements begin that have no stress at their nodes."""


class SolidElement(NamedTuple):
    """The name of its kind, its nodes in the order of the deck, and its material in SI."""

    kind: str
    nodes: tuple[str, ...]
    material: Material


@dataclass(frozen=True, eq=False)
class Solids:
    """nodes and kinds: of each element; sections: a set of elements and the name of its material, in the order of the deck;
    materials: the *ELASTIC cards by the name of a material; repeated: elements that stand once more; pascals: the unit of
    stress of the deck, Pa.

    Materials are read where an element needs them: a deck that describes more than stress needs stays readable.
    """

    nodes: Mapping[str, tuple[str, ...]]
    kinds: Mapping[str, str]
    sections: Sequence[tuple[Set[str], str]]
    materials: Mapping[str, Sequence[Card]]
    repeated: Sequence[str] = ()
    pascals: float = 1.0

    def around(self, nodes: Set[str]) -> list[SolidElement]:
        """The elements that have one of the nodes."""
        nodes_of = {}
        for element, words in self.nodes.items():
            own = tuple(str(int(word)) if word.isdecimal() else word for word in words)
            if not nodes.isdisjoint(own) and not self.kinds[element].startswith(NO_STRESS):
                nodes_of[element] = own
        material = {element: name for members, name in self.sections for element in members & nodes_of.keys()}
        missing = [element for element in nodes_of if element not in material]
        if missing:
            raise fault("An element at a place of stress", "must have a *SOLID SECTION with a material", f"element {missing[0]}")
        known = {name: self.material(name) for name in set(material.values())}
        return [SolidElement(self.kinds[element], own, known[material[element]]) for element, own in nodes_of.items()]

    def material(self, name: str, densities: Sequence[Card] | None = None) -> Material:
        """E and ν of one line of *ELASTIC, and the density of one line where its cards are given."""
        cards = self.materials.get(name, ())
        rule = "must have E and Poisson's ratio in one line of *ELASTIC, the same in all directions"
        try:
            if not all(card.name("TYPE") in ("", "ISO", "ISOTROPIC") for card in cards):
                raise fault("it", rule, "another TYPE")
            young, poisson = _constants(rule, cards, 2)
            elastic = Material(self.pascals * young, poisson)
            one = "must have one line of *DENSITY"
            return elastic if densities is None else replace(elastic, density=_constants(one, densities, 1)[0])
        except InputError as error:
            raise InputError(f"The material {name}: {error}{'' if cards else ' ' + nearest(name, self.materials)}") from None


def _constants(rule: str, cards: Sequence[Card], number: int) -> list[float]:
    """The first numbers of the only data line of the cards of a material."""
    lines = [fields(line) for card in cards for line in card.data]
    if len(lines) != 1 or len(lines[0]) < number:
        raise fault("it", rule, f"{len(lines)} lines" if cards else "without that card")
    return [coordinate(word) for word in lines[0][:number]]
