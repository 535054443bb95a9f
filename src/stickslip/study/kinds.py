"""Analyses available in study files, by their name in `[study] analysis`: the `KIND` of the module of that name in
`study/analyses/`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from pkgutil import iter_modules
from typing import Annotated, Literal

from pydantic import Field

from stickslip.study import analyses
from stickslip.study.analysis import Kind
from stickslip.study.fields import Table

NAMES = tuple(module.name for module in iter_modules(analyses.__path__))


class _Kinds(Mapping[str, Kind]):
    """The kinds by name. Each module is imported when its kind is first asked for: all take as long as a small study."""

    def __getitem__(self, name: str) -> Kind:
        if name not in NAMES:
            raise KeyError(name)
        kind: Kind = import_module(f"{analyses.__name__}.{name}").KIND
        return kind

    def __iter__(self) -> Iterator[str]:
        return iter(NAMES)

    def __len__(self) -> int:
        return len(NAMES)


KINDS = _Kinds()


class StudyTable(Table):
    """What the study is."""

    title: Annotated[str, Field(description="title of results and report")] = ""
    analysis: Annotated[Literal[NAMES], Field(description="what to compute")]  # type: ignore[valid-type]


PROBLEM_KEYS = (
    "structure",
    "body",
    "rotation",
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


def keys_of(kind: Kind) -> tuple[str, ...]:
    """The keys that a study file of a kind may have."""
    return ("units", "study", *PROBLEM_KEYS * kind.on_problem, *kind.tables)


def owners(key: str) -> list[str]:
    """The analyses that a table belongs to."""
    return [name for name, kind in KINDS.items() if key in keys_of(kind)]


def all_keys() -> tuple[str, ...]:
    """Every key of study files."""
    return (*COMMON_KEYS, *dict.fromkeys(key for kind in KINDS.values() for key in kind.tables))
