"""Analyses available in study files, by their name in `[study] analysis`: the `KINDS` of all modules in `study/analyses/`."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import Annotated, Literal

from pydantic import Field

from stickslip.study import analyses
from stickslip.study.analysis import Kind
from stickslip.study.fields import Table

KINDS: dict[str, Kind] = {
    name: kind
    for module in iter_modules(analyses.__path__, f"{analyses.__name__}.")
    for name, kind in import_module(module.name).KINDS.items()
}


class StudyTable(Table):
    """What the study is."""

    title: Annotated[str, Field(description="title of results and report")] = ""
    analysis: Annotated[Literal[tuple(KINDS)], Field(description="what to compute")]  # type: ignore[valid-type]


PROBLEM_KEYS = (
    "structure",
    "body",
    "damping",
    "contact",
    "force",
    "excitation",
    "mean_spring",
    "dashpot",
    "base",
    "aerodynamics",
    "sweep",
)
"""Tables that state a problem and where to compute it, for every analysis of one."""
COMMON_KEYS = ("units", "study", *PROBLEM_KEYS)
KEYS = (*COMMON_KEYS, *dict.fromkeys(key for kind in KINDS.values() for key in kind.tables))


def owners(key: str) -> list[str]:
    """The analyses that a table belongs to."""
    return [name for name, kind in KINDS.items() if key in kind.tables or (key in PROBLEM_KEYS and kind.on_problem)]
