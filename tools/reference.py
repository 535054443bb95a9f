"""Generator of the study file reference: every key with type, unit, default, range and meaning.

`python -m tools.reference FILE` writes it; the documentation includes that file.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from contextlib import suppress
from inspect import cleandoc, getsource
from itertools import pairwise
from pathlib import Path
from textwrap import dedent
from typing import Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic.fields import FieldInfo

from stickslip.study.analysis import KINDS, StudyTable
from stickslip.study.contacts import LAWS, LoadDependentFrictionTable, StartTable
from stickslip.study.faults import tables_in
from stickslip.study.fields import SYSTEMS, Dimension, Table, Units, Words
from stickslip.study.structure import AerodynamicsTable
from stickslip.study.tables import (
    AtSpeedTable,
    AxisTable,
    BaseTable,
    BodyTable,
    DampingTable,
    DashpotTable,
    ExcitationTable,
    FilesTable,
    ForceTable,
    LoadStepTable,
    MatricesTable,
    MeanSpringTable,
    OutputTable,
    RotationTable,
    SectorTable,
    StructureTable,
    SweepTable,
)
from stickslip.support.files import write_text

SECTIONS: dict[str, tuple[type[Table], ...]] = {
    "[study]": (StudyTable,),
    "[structure]": (StructureTable, MatricesTable, FilesTable),
    "[structure.sector]": (SectorTable, AxisTable, AtSpeedTable),
    "[[body]]": (BodyTable,),
    "[rotation]": (RotationTable,),
    "[[load_step]]": (LoadStepTable,),
    "[damping]": (DampingTable,),
    "[[contact]]": (*LAWS.values(), LoadDependentFrictionTable, StartTable),
    "[[force]]": (ForceTable,),
    "[excitation]": (ExcitationTable,),
    "[[mean_spring]]": (MeanSpringTable,),
    "[base]": (BaseTable,),
    "[[dashpot]]": (DashpotTable,),
    "[aerodynamics]": (AerodynamicsTable,),
    "[sweep]": (SweepTable, OutputTable),
    **{f"[{key}]": (model,) for kind in KINDS.values() for key, model in kind.tables.items()},
    "[units]": (Units,),
}
TITLES: dict[type[Table], str] = {
    MatricesTable: "`matrices` as a table",
    FilesTable: "`model` as a table",
    AxisTable: "`axis`",
    AtSpeedTable: "An entry of `at_speeds`",
    LoadDependentFrictionTable: "`mu` as a table",
    StartTable: "`start`",
    OutputTable: "An entry of `outputs` as a table",
    **{model: f'`law = "{law}"`' for law, model in LAWS.items()},
}
WORDS = {float: "number", int: "whole number", str: "text", bool: "true or false"}
HEAD = "| key | type | unit | default | range | meaning |\n| --- | --- | --- | --- | --- | --- |"


def reference() -> str:
    """The whole reference as Markdown."""
    parts = [
        "<!-- Written by `make reference` from the models in src/stickslip/study. Do not edit. -->",
        "# Every key of the study file",
    ]
    for section, models in SECTIONS.items():
        parts.append(f"## `{section}`")
        for model in models:
            parts += [f"### {TITLES[model]}"] if model in TITLES else []
            parts += [cleandoc(model.__doc__ or ""), "\n".join([HEAD, *rows(model)]), *rules(model)]
    parts.append(f"Instead of a table, `units` may be the name of a system: {', '.join(f'`{name}`' for name in SYSTEMS)}.")
    return "\n\n".join(parts) + "\n"


def rows(model: type[Table]) -> Iterator[str]:
    """One row per key."""
    below = meanings(model)
    for name, field in sorted(model.model_fields.items(), key=lambda item: item[0] != "law"):
        cells = (
            f"`{name}`",
            kind_of(field),
            unit(field),
            default(field),
            limits(field),
            field.description or below.get(name, ""),
        )
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def meanings(model: type[Table]) -> dict[str, str]:
    """What keys mean where the sentence stands below them in the source, as that of a constant does."""
    found = {}
    for table in reversed(model.__mro__):
        with suppress(OSError, TypeError):  # tables made of settings have no source
            for key, following in pairwise(ast.parse(dedent(getsource(table))).body[0].body):
                match key, following:
                    case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(sentence))):
                        found[name] = cleandoc(sentence)
    return found


def rules(model: type[Table]) -> list[str]:
    """Which keys need or exclude each other, in words."""
    lines = [f"* Exactly one of {listed(group)}." for group in model.exactly_one]
    lines += [f"* At most one of {listed(group)}." for group in model.at_most_one]
    lines += [f"* {listed(pair)} go together." for pair in model.together]
    return ["\n".join(lines)] if lines else []


def listed(keys: tuple[str, ...]) -> str:
    return ", ".join(f"`{key}`" for key in keys)


def kind_of(field: FieldInfo) -> str:
    """The type of a field in words."""
    named = [item.text for item in field.metadata if isinstance(item, Words)]
    return named[0] if named else kind(field.annotation)


def plural(words: str) -> str:
    """Several of a type: "number or table" gives "numbers or tables"."""
    return " or ".join(_several(word) for word in words.split(" or "))


def _several(word: str) -> str:
    """ "table of numbers" gives "tables of numbers"."""
    first, of, rest = word.partition(" of ")
    return f"{first}s{of}{rest}"


def kind(annotation: Any) -> str:
    """A type in words; alternatives in the order of the model."""
    named = [item.text for item in getattr(annotation, "__metadata__", ()) if isinstance(item, Words)]
    if named or annotation in WORDS:
        return named[0] if named else WORDS[annotation]
    origin, arguments = get_origin(annotation), [a for a in get_args(annotation) if a is not type(None)]
    if origin is Literal:
        return ", ".join(f'`"{value}"`' for value in arguments)
    if origin is list:
        return f"list of {plural(kind(arguments[0]))}"
    if origin is dict:
        return "table" if arguments[1] is Any else f"table of {plural(kind(arguments[1]))}"
    if hasattr(annotation, "__metadata__"):
        return kind(arguments[0])
    if tables_in(annotation) == [annotation]:
        return "table"
    return " or ".join(dict.fromkeys(kind(argument) for argument in arguments))


def unit(field: FieldInfo) -> str:
    return next((item.symbol for item in field.metadata if isinstance(item, Dimension)), "-")


def default(field: FieldInfo) -> str:
    """The default as it would be typed."""
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True, validated_data={})
    if value is None or value == {} or value == "":
        return "-"
    return f"`{str(value).lower() if isinstance(value, bool) else repr(value).replace(chr(39), chr(34))}`"


def limits(field: FieldInfo) -> str:
    """Bounds of the numbers."""
    found = list(dict.fromkeys(bound for item in all_metadata(field) if (bound := bound_text(item))))
    return ", ".join(found) or "-"


def bound_text(item: Any) -> str:
    """One bound in words."""
    match item:
        case Gt(gt=value):
            return f"> {value:g}"
        case Lt(lt=value):
            return f"< {value:g}"
        case Ge(ge=value):
            return f"≥ {value:g}"
        case Le(le=value):
            return f"≤ {value}" if isinstance(value, int) else f"≤ {value:g}"
        case _:
            return ""


def all_metadata(field: FieldInfo) -> Iterator[Any]:
    """Constraints of a field, of its alternatives and of their entries."""
    yield from flat(field.metadata)
    yield from nested_metadata(field.annotation)


def nested_metadata(annotation: Any) -> Iterator[Any]:
    yield from flat(getattr(annotation, "__metadata__", ()))
    for argument in get_args(annotation):
        if not (isinstance(argument, type) and issubclass(argument, Table)):
            yield from nested_metadata(argument)


def flat(metadata: Any) -> Iterator[Any]:
    """Constraints, out of the `Field`s that hold them."""
    for item in metadata:
        yield from item.metadata if isinstance(item, FieldInfo) else (item,)


if __name__ == "__main__":
    write_text(Path(sys.argv[1]), reference())
