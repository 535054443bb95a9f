"""Settings of an analysis, declared once: the fields of a frozen dataclass derived from `Settings`.

They are the arguments of its function in Python (`takes`), what travels to processes, what names a case (`identity`) and, by
`study/settings_table.py`, the keys of its table in a study. The dataclass is the `Work` of the analysis as a rule.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, fields
from functools import wraps
from typing import Any, ParamSpec, TypeVar, get_type_hints

from stickslip.analyses.work_parts import EXECUTION, StateOfFields
from stickslip.runs.work import Checkpoint, Progress, Workers, silent
from stickslip.support.checks import MOST, among, between, fault, finite, of_kind

Arguments = ParamSpec("Arguments")
Given = TypeVar("Given")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Setting:
    """The mark of a field, in `Annotated`.

    check: takes name and value, and returns what is kept or raises a `fault`. It must accept what it has returned, since copies
    are checked again, and is not asked about None where that is the default. Inside a class it stands there by its name: a
    lambda in the text of an annotation does not see its module.
    means: for the reference of study files; a setting without a meaning is no key of the table. key: its name there, where that
    is another.
    """

    check: Callable[[str, Any], Any]
    means: str = ""
    key: str = ""


@dataclass(frozen=True)
class Whole:
    """The check of a whole number, whose bounds the table of a study takes over."""

    least: int
    most: int = MOST

    def __call__(self, name: str, value: Any) -> int:
        return between(name, value, self.least, self.most)


@dataclass(frozen=True)
class Within:
    """The check of a number between two bounds that it does not meet, which the table of a study takes over."""

    low: float
    high: float

    def __call__(self, name: str, value: Any) -> float:
        number = finite(name, value)
        if not self.low < number < self.high:
            raise fault(name, f"must lie between {self.low:g} and {self.high:g}", number)
        return number


@dataclass(frozen=True)
class OfKind:
    """The check of an object of a class."""

    kind: type[Any]

    def __call__(self, name: str, value: Any) -> Any:
        return of_kind(name, value, self.kind)


@dataclass(frozen=True)
class OneOf:
    """The check of one of some words."""

    words: tuple[str, ...]

    def __call__(self, name: str, value: Any) -> str:
        return among(name, value, self.words)


@dataclass(frozen=True, eq=False)
class Settings(StateOfFields):
    """Checks its marked fields when it is made; what two fields need together, `__post_init__` of a subclass checks after."""

    def __post_init__(self) -> None:
        for name, mark in marks(type(self)).items():
            if not not_given(type(self), name, getattr(self, name)):
                object.__setattr__(self, name, mark.check(name, getattr(self, name)))

    def identity(self, *but: str) -> str:
        """Everything that results depend on, less the fields that are named."""
        kept = {each.name: getattr(self, each.name) for each in fields(self) if each.name not in (*EXECUTION, *but)}
        return ", ".join(f"{name} {getattr(value, 'fingerprint', repr(value))}" for name, value in kept.items())


@dataclass(frozen=True, eq=False)
class Execution(Settings):
    """How the cases of an analysis are computed; no result depends on it."""

    _: KW_ONLY
    workers: Workers = 1
    checkpoint: Checkpoint | None = None
    progress: Progress = silent


def not_given(kind: type[Settings], name: str, value: Any) -> bool:
    """Whether a setting is None by default, and is None."""
    return value is None and getattr(kind, name, ...) is None


def marks(kind: type[Settings]) -> Mapping[str, Setting]:
    """The marks of the fields that have one, in their order; read once, since they stand in the text of the class."""
    if kind not in _KNOWN:
        _KNOWN[kind] = _read_marks(kind)
    return _KNOWN[kind]


_KNOWN: dict[type[Settings], Mapping[str, Setting]] = {}


def _read_marks(kind: type[Settings]) -> Mapping[str, Setting]:
    hints = get_type_hints(kind, include_extras=True)
    found = {each.name: getattr(hints[each.name], "__metadata__", ()) for each in fields(kind)}
    return {name: mark for name, given in found.items() for mark in given if isinstance(mark, Setting)}


def takes(kind: Callable[Arguments, Given]) -> Callable[[Callable[[Given], Result]], Callable[Arguments, Result]]:
    """A function of one object as a function of its flat arguments, whose types and defaults type checkers and `help` show."""
    hints, signature = get_type_hints(kind), inspect.signature(kind)
    last = sorted(signature.parameters.values(), key=lambda each: each.name in EXECUTION)
    plain = [each.replace(annotation=hints[each.name]) for each in last]

    def decorate(body: Callable[[Given], Result]) -> Callable[Arguments, Result]:
        @wraps(body)
        def function(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
            try:
                signature.bind(*args, **kwargs)
            except TypeError as error:
                raise TypeError(f"{body.__name__}() {error}") from None
            return body(kind(*args, **kwargs))

        returned = inspect.signature(body).return_annotation
        function.__signature__ = signature.replace(parameters=plain, return_annotation=returned)  # type: ignore[attr-defined]
        function.__annotations__ = {each.name: each.annotation for each in plain} | {"return": returned}
        return function

    return decorate
