"""The solid elements of a deck with their materials, from which stress is recovered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from typing import NamedTuple

from stickslip.model.readers.input_cards import Card, fields
from stickslip.model.readers.numbers import coordinate
from stickslip.model.structure.solid import Material
from stickslip.support.checks import InputError, fault

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
    materials: the *ELASTIC cards by the name of a material; pascals: the unit of stress of the deck, Pa.

    Materials are read where an element needs them: a deck that describes more than stress needs stays readable.
    """

    nodes: Mapping[str, tuple[str, ...]]
    kinds: Mapping[str, str]
    sections: Sequence[tuple[Set[str], str]]
    materials: Mapping[str, Sequence[Card]]
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
        known = {name: self._material(name) for name in set(material.values())}
        return [SolidElement(self.kinds[element], own, known[material[element]]) for element, own in nodes_of.items()]

    def _material(self, name: str) -> Material:
        """E and ν of one line of *ELASTIC."""
        cards = self.materials.get(name, ())
        lines = [fields(line) for card in cards for line in card.data]
        isotropic = all(card.name("TYPE") in ("", "ISO", "ISOTROPIC") for card in cards)
        if not isotropic or len(lines) != 1 or len(lines[0]) < 2:
            what = f"The material {name} at a place of stress"
            said = "another TYPE" if not isotropic else f"{len(lines)} lines"
            raise fault(what, "must have E and Poisson's ratio in one line of *ELASTIC, the same in all directions", said)
        try:
            young, poisson = (coordinate(word) for word in lines[0][:2])
            return Material(self.pascals * young, poisson)
        except InputError as error:
            raise InputError(f"The material {name}: {error}") from None
