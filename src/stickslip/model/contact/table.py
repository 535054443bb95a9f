"""All contacts of a problem as flat arrays for the compiled kernels.

Rows of w, f and λ are (contact, direction) in the order t1, t2, n of each contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.dispatch import kind_of
from stickslip.model.contact.march import prepare
from stickslip.model.contact.point import Contact
from stickslip.model.contact.protocol import ContactData
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inner


class ContactTable(NamedTuple):
    """Flat arrays over contacts, rows, normal elements and friction elements.

    first_row (contacts + 1): rows of contact c are first_row[c] .. first_row[c + 1] − 1.
    normal_row (contacts): the row of the normal direction, −1 without one.
    normal_first (contacts + 1), normal_stiffness, normal_constant: N_e = max(stiffness z + constant, 0).
    friction_first (rows + 1): friction elements of each row (none for a normal row); stiffness kt, friction μ,
    constant_limit; load_first, load_last: the normal elements that load it; start_kind, start_value: the start state.
    bend_first (elements + 1): the bends of each limit, at bend [N] of the limit without them, with the change of slope.
    kind (contacts): the number of its law's kernels (`dispatch.py`); parameter_first (contacts + 1), parameter:
    their own numbers.
    loading_row (rows): the row of the normal load of a tangential row, partner_row (rows): the other tangential row where the law
    couples both; −1 without one.
    """

    first_row: Index
    normal_row: Index
    normal_first: Index
    normal_stiffness: Array
    normal_constant: Array
    friction_first: Index
    stiffness: Array
    friction: Array
    constant_limit: Array
    load_first: Index
    load_last: Index
    bend_first: Index
    bend: Array
    change: Array
    start_kind: Index
    start_value: Array
    kind: Index
    parameter_first: Index
    parameter: Array
    loading_row: Index
    partner_row: Index

    @property
    def rows(self) -> int:
        return int(self.first_row[-1])


@inner
def bent(table: ContactTable, e: int, line: float) -> tuple[float, float]:
    """L = ℓ + Σ change max(ℓ − bend, 0) of friction element e for ℓ = μ Σ N + L0, and dL/dℓ; bends ascend."""
    limit, slope = line, 1.0
    for k in range(table.bend_first[e], table.bend_first[e + 1]):
        beyond = line - table.bend[k]
        if beyond <= 0.0:
            break
        limit += table.change[k] * beyond
        slope += table.change[k]
    return limit, slope


@inner
def contact_data(table: ContactTable, c: int) -> ContactData:
    """Contact c of a table whose law has kernels of its own."""
    first, last = table.first_row[c], table.first_row[c + 1]
    if table.normal_row[c] >= 0:
        last -= 1
    kt, value, kind = np.zeros(last - first), np.zeros(last - first), np.zeros(last - first, dtype=np.int64)
    a, b = table.friction_first[first], table.friction_first[last]
    spring, direction = table.stiffness[a:b].copy(), np.zeros(b - a, dtype=np.int64)
    for r in range(first, last):
        for e in range(table.friction_first[r], table.friction_first[r + 1]):
            direction[e - a] = r - first
            kt[r - first] += table.stiffness[e]
            if e == table.friction_first[r]:
                kind[r - first], value[r - first] = table.start_kind[e], table.start_value[e]
    parameter = table.parameter[table.parameter_first[c] : table.parameter_first[c + 1]]
    return ContactData(table.kind[c], parameter, kt, kind, value, spring, direction)


def remembering(contacts: Sequence[Contact]) -> NDArray[np.bool_]:
    """Friction elements whose law remembers its start state, (elements,)."""
    sizes = [sum(group.stiffness.size for group in contact.elements.friction) for contact in contacts]
    return np.repeat(np.array([contact.law.remembers_start for contact in contacts], dtype=bool), sizes)


def contact_table(contacts: Sequence[Contact]) -> ContactTable:
    """The table of a sequence of contacts; the kernels of their laws are ready with it."""
    prepare(*{type(contact.law) for contact in contacts})
    first_row, normal_row, normal_first, friction_first = [0], [], [0], [0]
    normal: list[tuple[float, float]] = []
    friction: list[tuple[float, float, float, int, int, int, float]] = []
    bends: list[tuple[float, float]] = []
    bend_first: list[int] = [0]
    parameter_first: list[int] = [0]
    parameter: list[float] = []
    loading_row: list[int] = []
    partner_row: list[int] = []
    for contact in contacts:
        elements = contact.elements
        base = len(normal)
        if elements.normal is not None:
            normal += zip(elements.normal.stiffness, elements.normal.constant, strict=True)
        for group, start in zip(elements.friction, contact.starts, strict=True):
            values = start.values(group.stiffness.size)
            for e in range(group.stiffness.size):
                loads = (base + int(group.first[e]), base + int(group.last[e]))
                parameters = (group.stiffness[e], group.friction[e], group.constant_limit[e])
                friction.append((*parameters, *loads, start.code, values[e]))
                bends += zip(group.bend[:, e], group.change[:, e], strict=True) if group.bend.size else ()
                bend_first.append(len(bends))
            friction_first.append(len(friction))
        row, both = first_row[-1], contact.law.couples_directions
        normal_row.append(row + len(elements.friction) if elements.normal is not None else -1)
        if elements.normal is not None:
            friction_first.append(len(friction))
        first_row.append(first_row[-1] + len(contact.directions))
        alone = [-1] * (elements.normal is not None)
        loading_row += [normal_row[-1]] * len(elements.friction) + alone
        partner_row += ([row + 1, row] if both else [-1] * len(elements.friction)) + alone
        parameter += elements.parameters
        parameter_first.append(len(parameter))
        normal_first.append(len(normal))
    springs = np.array(normal, dtype=float).reshape(len(normal), 2)
    bent_at = np.array(bends, dtype=float).reshape(len(bends), 2)
    sliders = np.array(friction, dtype=float).reshape(len(friction), 7)

    def integers(values: object) -> Index:
        return np.ascontiguousarray(values, dtype=np.int64)

    def floats(values: Array) -> Array:
        return np.ascontiguousarray(values, dtype=float)

    return ContactTable(
        first_row=integers(first_row),
        normal_row=integers(normal_row),
        normal_first=integers(normal_first),
        normal_stiffness=floats(springs[:, 0]),
        normal_constant=floats(springs[:, 1]),
        friction_first=integers(friction_first),
        stiffness=floats(sliders[:, 0]),
        friction=floats(sliders[:, 1]),
        constant_limit=floats(sliders[:, 2]),
        load_first=integers(sliders[:, 3]),
        load_last=integers(sliders[:, 4]),
        bend_first=integers(bend_first),
        bend=floats(bent_at[:, 0]),
        change=floats(bent_at[:, 1]),
        start_kind=integers(sliders[:, 5]),
        start_value=floats(sliders[:, 6]),
        kind=integers([kind_of(type(contact.law)) for contact in contacts]),
        parameter_first=integers(parameter_first),
        parameter=floats(np.array(parameter)),
        loading_row=integers(loading_row),
        partner_row=integers(partner_row),
    )
