"""Field types of study files. All are strict: no text for numbers, no unknown keys, no NaN.

A value that may have several forms (a number or a list) is a union that looks at the form first, so that a fault is reported
about the form the author meant. The marks of such forms are in angle brackets and never reach a message.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from stickslip.support.checks import LARGEST, LARGEST_SEED, SMALLEST

Groups = tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Words:
    """What the reference calls a type."""

    text: str


class Table(BaseModel):
    """A table of a study file."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, defer_build=True)

    exactly_one: ClassVar[Groups] = ()
    """Groups of keys of which one and only one must be given."""
    at_most_one: ClassVar[Groups] = ()
    """Groups of keys that exclude each other."""
    together: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Pairs of keys of which either both or none must be given."""
    in_place_of: ClassVar[dict[str, str]] = {}
    """Keys that stand for another one in these pairs: {"surface": "normal"}, and free its partner."""
    renamed: ClassVar[dict[str, str]] = {}
    """Keys of older files, with their names of today."""


def _form(value: Any) -> str:
    if isinstance(value, dict):
        return "<table>"
    return "<list>" if isinstance(value, list) else "<single>"


def _places_form(value: Any) -> str:
    if isinstance(value, list) and not (value and all(isinstance(item, str) for item in value)):
        return "<several>"
    return _form(value)


def by_form(form: Callable[[Any], str] = _form) -> Discriminator:
    """A union discriminated by `form`; a form that no member has is reported with the forms of all (`faults.FORMS`)."""
    return Discriminator(form)


Column = Annotated[
    Annotated[str, Tag("<title>")] | Annotated[int, Tag("<number>")],
    by_form(lambda value: "<title>" if isinstance(value, str) else "<number>"),
]
"""A column of a file by its title, or by its number from 1."""


def _not_huge(value: float) -> float:
    """As `checks.finite` refuses it, with the place in the file."""
    if abs(value) > LARGEST:
        raise PydanticCustomError("too_large", "too large")
    return value


def _not_tiny(value: float) -> float:
    """As `checks.positive` refuses it, with the place in the file."""
    if value < SMALLEST:
        raise PydanticCustomError("too_small", "too small")
    return value


NotHuge, NotTiny = AfterValidator(_not_huge), AfterValidator(_not_tiny)

Number = Annotated[float, Field(allow_inf_nan=False), NotHuge]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), NotHuge, NotTiny]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False), NotHuge]

QuantityName = Literal["displacement", "velocity", "acceleration", "receptance", "mobility", "inertance"]
"""What peaks are of; the last three are the same per force level."""

Harmonics = Annotated[
    Annotated[int, Field(ge=1, le=1000), Tag("<single>")]
    | Annotated[list[Annotated[int, Field(ge=0, le=1000)]], Field(min_length=1), Tag("<list>")],
    by_form(),
]
"""H for 0..H, or a list."""

Seed = Annotated[int, Field(ge=0, le=LARGEST_SEED)]

Vector = Annotated[list[Number], Field(min_length=3, max_length=3), Words("list of three numbers")]

Ratio = Annotated[float, Field(ge=-1, le=1)]

Numbers = Annotated[Annotated[Number, Tag("<single>")] | Annotated[list[Number], Tag("<list>")], by_form()]
Positives = Annotated[
    Annotated[Positive, Tag("<single>")] | Annotated[list[Positive], Field(min_length=1), Tag("<list>")], by_form()
]
NotNegatives = Annotated[
    Annotated[NotNegative, Tag("<single>")] | Annotated[list[NotNegative], Field(min_length=1), Tag("<list>")], by_form()
]

Coefficients = Annotated[dict[str, Number], Field(min_length=1), Words("table of coefficients")]
Pair = Annotated[list[str], Field(min_length=2, max_length=2), Words("pair of names")]
Direction = Annotated[Annotated[Pair, Tag("<list>")] | Annotated[Coefficients, Tag("<table>")], by_form(), Words("direction")]
Directions = Annotated[
    Annotated[Pair, Tag("<list>")]
    | Annotated[Coefficients, Tag("<table>")]
    | Annotated[list[Direction], Field(min_length=1, max_length=2), Tag("<several>")],
    by_form(_places_form),
    Words("direction or list of two directions"),
]
"""One direction (two names, or a table of coefficients), or a list of one or two of them."""

Place = Annotated[
    Annotated[str, Tag("<single>")] | Annotated[Coefficients, Tag("<table>")], by_form(), Words("name or table of coefficients")
]
Amplitude = Annotated[
    Annotated[Number, Tag("<single>")] | Annotated[list[Number], Field(min_length=2, max_length=2), Tag("<list>")],
    by_form(),
    Words("number or pair of numbers"),
]
