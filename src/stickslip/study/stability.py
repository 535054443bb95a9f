"""Stability in a study: the table [stability] of a forced response."""

from __future__ import annotations

from pydantic import Field

from stickslip.study.analysis import Asked
from stickslip.study.fields import Number, Table


class StabilityTable(Table):
    """Stability of every point of the curves."""

    highest: Number | None = Field(
        default=None,
        gt=0.0,
        description="natural frequency in Hz up to which modes move by themselves; default: eight times the highest harmonic",
    )


def stability_of(asked: Asked) -> StabilityTable | None:
    """The table [stability]; None where it is not asked for."""
    table = asked.tables.get("stability")
    return table if isinstance(table, StabilityTable) else None
