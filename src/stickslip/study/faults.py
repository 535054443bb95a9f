"""Faults of a study file, collected in one pass from validation and construction, in a common format."""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from stickslip.study.fields import Table
from stickslip.support.checks import LARGEST, SMALLEST, Faults, InputError, counted, fault, nearest

WARNING = "Warning: "
"""How a note on a study begins that its reader shall look at."""

Made = TypeVar("Made")
Model = TypeVar("Model", bound=Table)

RULES = {
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "finite_number": "must be finite",
    "string_type": "must be a text in quotes",
    "bool_type": "must be true or false",
    "list_type": "must be a list",
    "dict_type": "must be a table",
    "model_type": "must be a table",
    "greater_than": "must be above {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be below {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "too_short": "must have {entries} or more",
    "too_long": "must have at most {entries}",
    "string_too_short": "must not be empty",
    "literal_error": "must be {expected}",
    "union_tag_invalid": "must be {forms}",
    "too_large": f"must not be larger than {LARGEST:g} in size",
    "too_small": f"must be at least {SMALLEST:g}",
}
FORMS = {
    "<single>": "a single value",
    "<table>": "a table",
    "<list>": "a list",
    "<several>": "a list of these",
    "<place>": "a place",
    "<title>": "a title",
    "<number>": "a number",
}
"""The forms of a value that may be written in several (`fields.by_form`)."""

REMEDIES = {"too_large": "Check its unit.", "too_small": "Check its unit."}


TRUTH = re.compile(r"(?<= is )(True|False)(?=\.)")
"""Truth values as messages write them; in a study they are `true` and `false`."""


class Found:
    """Collects the faults of one file, each with its location."""

    def __init__(self) -> None:
        self.messages: list[str] = []

    def attempt(self, place: str, make: Callable[..., Made], *arguments: Any) -> Made | None:
        """`make(*arguments)`, or None with the fault noted."""
        try:
            return make(*arguments)
        except InputError as error:
            messages = error.faults if isinstance(error, Faults) else (str(error),)
            self.messages += [f"{place}: {message}" if place else message for message in messages]
        return None

    def stop(self) -> None:
        """Raise what was found, if anything was."""
        if self.messages:
            raise Faults([TRUTH.sub(lambda found: found[0].lower(), message) for message in self.messages])


def parsed(model: type[Model], values: Any) -> Model:
    """`values` as a table; all its faults at once."""
    faults: list[str] = []
    if isinstance(values, dict):
        faults = misfits(model, values)
    try:
        table = model.model_validate(values)
    except ValidationError as error:
        raise Faults([*faults, *(sentence(model, details) for details in error.errors())]) from None
    if faults:
        raise Faults(faults)
    return table


def misfits(model: type[Table], values: Mapping[str, Any]) -> list[str]:
    """Keys that are missing beside others, or exclude each other."""
    faults = []
    for group in model.exactly_one + model.at_most_one:
        given = [key for key in group if key in values]
        if len(given) > 1:
            faults.append(f"{' and '.join(given)} must not be given together, but are. Leave one out.")
        elif not given and group in model.exactly_one:
            faults.append(f"{' or '.join(group)} must be given, but is missing.")
    for pair in model.together:
        given = [key for key in pair if key in values]
        if len(given) == 1 and not any(other in values and key in pair for other, key in model.in_place_of.items()):
            faults.append(f"{' and '.join(pair)} must be given together, but only {given[0]} is.")
    return faults


def sentence(model: type[Table], details: ErrorDetails) -> str:
    """One pydantic error as: what, rule, value, remedy."""
    path = tuple(part for part in details["loc"] if not str(part).startswith("<") and part != "[key]")
    kind, context = details["type"], details.get("ctx", {})
    if kind == "extra_forbidden":
        return str(
            fault(where(path[:-1], "key"), "must be a known one", path[-1], nearest(str(path[-1]), known_keys(model, path[:-1])))
        )
    if kind == "missing":
        return f"{where(path)} must be given, but is missing."
    if kind in ("too_short", "too_long"):
        context = context | {"entries": counted(context.get("min_length") or context["max_length"], "entry", "entries")}
    if kind == "union_tag_invalid":
        context = context | {"forms": " or ".join(words for form, words in FORMS.items() if form in context["expected_tags"])}
    if isinstance(context.get("le"), int):
        return str(fault(where(path), f"must be at most {context['le']}", details["input"]))
    rule = RULES[kind].format(**context) if kind in RULES else details["msg"].removeprefix("Value error, ")
    remedy = (
        nearest(str(details["input"]), context["expected"].replace("'", "").replace(" or ", ", ").split(", "))
        if kind == "literal_error"
        else REMEDIES.get(kind, "")
    )
    return str(fault(where(path), rule, details["input"], remedy))


def where(path: Sequence[str | int], last: str = "") -> str:
    """A path of keys and positions in words: `start, entry 2`. Positions count from 1."""
    words = [f"entry {part + 1}" if isinstance(part, int) else part for part in path] + ([last] if last else [])
    return ", ".join(words) or "The table"


def known_keys(model: type[Table], path: Sequence[str | int]) -> list[str]:
    """Keys of the table that stands at `path` inside `model`."""
    for part in path:
        if isinstance(part, str) and part in model.model_fields:
            inner = tables_in(model.model_fields[part].annotation)
            model = inner[0] if inner else model
    return list(model.model_fields)


def tables_in(annotation: Any) -> list[type[Table]]:
    """The tables that an annotation speaks of."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return [annotation]
    return [table for argument in get_args(annotation) for table in tables_in(argument)]
