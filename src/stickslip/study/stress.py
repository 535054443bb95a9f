"""Stress in a study: the table [stress] of a forced response."""

from __future__ import annotations

import inspect
from typing import Annotated

from pydantic import Field

from stickslip.analyses.stress import own_recovery
from stickslip.model import rigs
from stickslip.model.structure.stress import StressRecovery
from stickslip.study.analysis import Asked
from stickslip.study.fields import Number, Table, Words
from stickslip.support.checks import InputError

Point = Annotated[list[Number], Field(min_length=3, max_length=3), Words("list of three numbers")]


class StressTable(Table):
    """Stress along the curves at places of a rig's finite elements."""

    places: Annotated[
        dict[str, Point],
        Field(min_length=1, description="NAME = [x, y, z], in m and in the axes of the rig's body"),
        Words("table of places"),
    ]


def recovery_of(asked: Asked) -> StressRecovery | None:
    """The recovery at the places of the models, or of [stress] from the elements of a rig; None where no stress is asked for."""
    table = asked.tables.get("stress")
    if not isinstance(table, StressTable):
        return None if asked.sweep is None else own_recovery(asked.sweep.problem)
    rig, parameters = asked.rig
    maker = rigs.STRESS.get(rig)
    if maker is None:
        known = " or ".join(rigs.STRESS)
        raise InputError(
            f"[stress] must go with a rig whose finite elements are known ({known}), but stands beside {rig or 'matrices'!r}. "
            "Places of a model are named in [structure] stress."
        )
    shared = inspect.signature(maker).parameters
    return maker(table.places, **{name: value for name, value in parameters.items() if name in shared})
