"""The coefficient of friction in a study file: a number, or a table of how it depends on the normal load."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, Tag

from stickslip.model.contact.friction import LoadDependentFriction
from stickslip.study.fields import NotNegative, Number, Positive, Table, Words, by_form
from stickslip.study.units import FORCE, Units, in_si
from stickslip.support.checks import fault

ENTRIES = Field(min_length=2)


class LoadDependentFrictionTable(Table):
    """A coefficient that depends on the normal load N of the contact: `over` and `values`, between which the slip limit µN is
    straight; or a power law, `value`, `at` and `exponent`: µ = value (N/at)^exponent. Beyond the loads µ is constant."""

    over: Annotated[
        Annotated[list[Positive], ENTRIES] | None,
        FORCE,
        Field(description="normal loads, ascending; of a power law the lowest and the highest, by default at/100 and 100 at"),
    ] = None
    values: Annotated[
        Annotated[list[Positive], ENTRIES] | None, Field(description="µ at each of these loads; µN must not fall as N grows")
    ] = None
    value: Annotated[Positive | None, Field(description="of a power law: µ at the load `at`")] = None
    at: Annotated[Positive | None, FORCE, Field(description="of a power law: the load of `value`")] = None
    exponent: Annotated[Number | None, Field(description="of a power law, from -1 to 1: negative where µ falls")] = None

    def friction(self, units: Units) -> LoadDependentFriction:
        """The coefficient over loads in newtons."""
        given = {key: value for key, value in in_si(self, units).items() if value is not None}
        power = {"value", "at", "exponent"}
        if given.keys() == {"over", "values"}:
            return LoadDependentFriction(**given)
        if given.keys() - {"over"} == power:
            return LoadDependentFriction.power(**given)
        remedy = "Such as { over = [10, 100], values = [0.6, 0.4] } or { value = 0.5, at = 50, exponent = -0.2 }."
        raise fault("mu", "must have over and values, or value, at and exponent", sorted(given), remedy)


Friction = Annotated[
    Annotated[NotNegative, Tag("<single>")] | Annotated[LoadDependentFrictionTable, Tag("<table>")],
    by_form(),
    Words("number or table"),
]

Frictions = Annotated[
    Annotated[NotNegative, Tag("<single>")]
    | Annotated[list[NotNegative], Field(min_length=1), Tag("<list>")]
    | Annotated[LoadDependentFrictionTable, Tag("<table>")],
    by_form(),
    Words("number, list of numbers or table"),
]


def friction_in_si(mu: Any, units: Units) -> Any:
    """A coefficient with its loads in newtons."""
    return mu.friction(units) if isinstance(mu, LoadDependentFrictionTable) else mu
