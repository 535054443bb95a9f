"""Start rules of a study file: one per contact or per direction; values for all, per direction or per element."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, Tag

from stickslip.model.contact.point import STARTS, SliderOffset, Start
from stickslip.study.fields import FORCE, LENGTH, Number, Numbers, Ratio, Table, Units, Words, by_form, in_si
from stickslip.support.checks import fault

Values = Annotated[Annotated[Number, Tag("<single>")] | Annotated[list[Numbers], Field(min_length=1), Tag("<list>")], by_form()]
RatioOrList = Annotated[Annotated[Ratio, Tag("<single>")] | Annotated[list[Ratio], Tag("<list>")], by_form()]
Ratios = Annotated[
    Annotated[Ratio, Tag("<single>")] | Annotated[list[RatioOrList], Field(min_length=1), Tag("<list>")],
    by_form(),
    Words("number or list"),
]
"""A number for all; a list with one entry per direction, or per element; a list of lists: per direction and element."""


class StartTable(Table):
    """Exactly one rule. Its value: a number for all, a list per direction or per element of an array, or a list of lists."""

    slider_offset: Annotated[Values | None, LENGTH, Field(description="where the slider rests (0: a virgin contact)")] = None
    traction_ratio: Annotated[Ratios | None, Field(description="T/(µN) at the last sample, from −1 to 1")] = None
    mean_traction: Annotated[Values | None, FORCE, Field(description="mean of T over the period")] = None


Starts = Annotated[
    Annotated[StartTable, Tag("<table>")] | Annotated[list[StartTable], Field(min_length=1, max_length=2), Tag("<list>")],
    by_form(),
]
"""One rule for a contact, or a list with one per tangential direction."""


RuleName = Literal["slider_offset", "traction_ratio", "mean_traction", "virgin"]
RuleOrRules = Annotated[
    Annotated[RuleName, Tag("<single>")] | Annotated[list[RuleName], Field(min_length=2, max_length=2), Tag("<list>")],
    by_form(),
    Words('`"slider_offset"`, `"traction_ratio"`, `"mean_traction"`, `"virgin"`, or a list of two'),
]
"""What the start states of all contacts are drawn from, or of tangential and normal directions."""


def start_rules(start: StartTable | list[StartTable] | None, units: Units, directions: int, elements: int) -> tuple[Start, ...]:
    """One rule per tangential direction, in SI. `elements` is the number of friction elements of each direction."""
    if start is None:
        return (SliderOffset(),) * directions
    if isinstance(start, StartTable):
        return spread(start, units, directions, elements)
    if len(start) != directions:
        raise fault("start", f"must have one rule per tangential direction ({directions})", len(start))
    return tuple(spread(table, units, 1, elements)[0] for table in start)


def spread(table: StartTable, units: Units, directions: int, elements: int) -> tuple[Start, ...]:
    """The rule of a table for each direction."""
    given = {key: value for key, value in in_si(table, units).items() if value is not None}
    if len(given) != 1:
        raise fault(
            "start", "must name exactly one rule", sorted(given), "Known: " + ", ".join(rule.key for rule in STARTS) + "."
        )
    ((key, value),) = given.items()
    rule = next(rule for rule in STARTS if rule.key == key)
    return tuple(rule(each) for each in per_direction(key, value, directions, elements))


def per_direction(key: str, value: Any, directions: int, elements: int) -> list[Any]:
    """The value of each direction: a number, or a list with one number per element."""
    if not isinstance(value, list):
        return [value] * directions
    nested = any(isinstance(item, list) for item in value)
    if nested or (len(value) == directions and elements != directions) or (elements == 1 and len(value) == directions):
        if len(value) != directions:
            raise fault(key, f"must have one list per tangential direction ({directions})", len(value))
        return list(value)
    if len(value) == directions == elements:
        raise fault(
            key, "must say what its entries stand for", value, f"{directions} directions or elements? Write a list of lists."
        )
    if len(value) != elements:
        raise fault(key, f"must have an entry per direction ({directions}) or per element ({elements})", len(value))
    return [value] * directions
