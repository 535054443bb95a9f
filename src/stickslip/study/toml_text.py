"""A study file from its document, as the commands that stand for a study keep it beside their results."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

BARE = re.compile(r"[A-Za-z0-9_-]+")
"""Keys that TOML takes without quotes."""


def toml_text(document: Mapping[str, Any]) -> str:
    """The document as TOML, tables in its order; what is None is left out."""
    single = {key: value for key, value in document.items() if not _is_table(value)}
    lines = _pairs(single) + ([""] if single else [])
    for key, value in document.items():
        if isinstance(value, Mapping):
            lines += [f"[{key}]", *_pairs(value), ""]
        elif _is_table(value):
            for one in value:
                lines += [f"[[{key}]]", *_pairs(one), ""]
    return "\n".join(lines).rstrip() + "\n"


def _is_table(value: Any) -> bool:
    """Whether a value is written as a table, or as several of one name."""
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and isinstance(value[0], Mapping))


def _pairs(table: Mapping[str, Any]) -> list[str]:
    return [f"{_key(key)} = {_value(value)}" for key, value in table.items() if value is not None]


def _key(key: str) -> str:
    return key if BARE.fullmatch(key) else json.dumps(key, ensure_ascii=False)


def _value(value: Any) -> str:
    """A value on one line; texts and numbers are written as in JSON."""
    if isinstance(value, Mapping):
        return f"{{ {', '.join(_pairs(value))} }}" if value else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value, ensure_ascii=False) if not isinstance(value, float) else repr(value)  # TOML has nan and inf
