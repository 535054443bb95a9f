"""Names of degrees of freedom in a study: detection of unknown names, and directions as coefficients in SI."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from stickslip.model.contact.point import GROUND, between
from stickslip.model.readers.model import levers
from stickslip.model.structure.matrices import nearest_dof, of_single_nodes
from stickslip.study.units import Units


class Names:
    """The degrees of freedom that exist, with the factor of each, and `short` names of those of sets of one node."""

    def __init__(self, dofs: Sequence[str], units: Units) -> None:
        self.lever = dict(zip(dofs, levers(dofs, units.system).tolist(), strict=True))
        self.short = of_single_nodes(dofs)

    def coefficients(self, given: Sequence[str] | Mapping[str, float]) -> dict[str, float]:
        """A direction given as a pair of names or as a table, as coefficients in SI."""
        table = given if isinstance(given, Mapping) else between(*given)
        return {name: coefficient * self.lever.get(self.short.get(name, name), 1.0) for name, coefficient in table.items()}

    def faults(self, document: Mapping[str, Any]) -> list[str]:
        """Every name in the document that does not exist."""
        known = {*self.lever, *self.short}
        return [f"{place}: {self._fault(name)}" for place, name in names_in(document) if name not in known]

    def _fault(self, name: str) -> str:
        if name == GROUND:
            return f"must be a degree of freedom, which moves, but is {name!r}."
        return f"degree of freedom {name!r} does not exist. {nearest_dof(name, [*self.lever, GROUND])}"


def dofs_in(document: Mapping[str, Any]) -> list[str]:
    """The names of the degrees of freedom, as far as the document has them."""
    structure = document.get("structure")
    dofs = structure.get("dofs") if isinstance(structure, dict) and "body" not in document else None
    return [dof for dof in dofs if isinstance(dof, str)] if isinstance(dofs, list) else []


def names_in(document: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Places and names, read from the document as it stands, so that other faults do not hide a wrong name."""
    for key, places in (
        ("contact", ("between", "tangential", "normal")),
        ("force", ("direction",)),
        ("dashpot", ("between",)),
        ("mean_spring", ("direction",)),
    ):
        tables = document.get(key)
        for number, table in enumerate(tables if isinstance(tables, list) else (), start=1):
            if isinstance(table, dict) and not (key == "force" and "surface" in table):
                for place in places:
                    yield from ((f"[[{key}]] {number}: {place}", name) for name in words(table.get(place)))
    base = document.get("base")
    if isinstance(base, dict) and isinstance(base.get("direction"), dict):
        yield from (("[base]: direction", name) for name in base["direction"])
    sweep = document.get("sweep")
    outputs = sweep.get("outputs") if isinstance(sweep, dict) else None
    for output in outputs if isinstance(outputs, list) else ():
        value = output.get("direction") if isinstance(output, dict) else output
        yield from (("[sweep]: outputs", name) for name in words(value))


def words(value: Any) -> list[str]:
    """The names in a place: one, a pair (where "ground" is the fixed side), the keys of a table, or lists of these."""
    if isinstance(value, str):
        return [value]
    if isinstance(value, dict):
        return list(value)
    if not isinstance(value, list):
        return []
    return [word for item in value for word in words(item) if not (isinstance(item, str) and item == GROUND)]
