"""Study files as text: a file from its document, as the commands that stand for a study keep it beside their results; and the
line of the table, or of the key, that the message of a fault names."""

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
    written = {key if BARE.fullmatch(key) else json.dumps(key, ensure_ascii=False): value for key, value in table.items()}
    return [f"{key} = {_value(value)}" for key, value in written.items() if value is not None]


def _value(value: Any) -> str:
    """A value on one line; texts and numbers are written as in JSON."""
    if isinstance(value, Mapping):
        return f"{{ {', '.join(_pairs(value))} }}" if value else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value, ensure_ascii=False) if not isinstance(value, float) else repr(value)  # TOML has nan and inf


HEAD = re.compile(r"\s*\[\[?\s*([\w.\s\"'-]+?)\s*\]\]?\s*(?:#.*)?$")
PLACE = re.compile(r"(?:\[\[(?P<several>\w+)\]\](?: (?P<number>\d+))?|\[(?P<single>\w+)\]|units\b)(?P<colon>: )?")
UNKNOWN = re.compile(r".*?must be a known one, but is '([^']*)'")
KEY = re.compile(r"[\w.-]+")


def with_line(message: str, text: str, document: Mapping[str, Any]) -> str:
    """The message of a fault, `[table]: key must ...`, with the line of the text at which its table or key stands.

    Unchanged where it names neither. A key of an inline table or of a list that goes over several lines counts as its own line.
    """
    place = PLACE.match(message)
    words = message[place.end() :] if place else message
    if place:
        table = place["several"] or place["single"] or "units"
        within = _lines_of(table, int(place["number"] or 1), text, document)
    else:
        within = list(enumerate(text.splitlines(), start=1))
    named = [unknown[1]] if (unknown := UNKNOWN.match(words)) else []
    named += KEY.findall(words.partition(" must")[0]) if not place or place["colon"] else []
    for key in named:
        line = next((number for number, line in within if _names(line, key, bool(place))), None)
        if line is not None:
            return _with(line, message, place)
    return _with(within[0][0], message, place) if place and within else message


def _with(line: int, message: str, place: re.Match[str] | None) -> str:
    return f"Line {line}{',' if place and place['colon'] else ':'} {message}"


def _names(line: str, key: str, in_table: bool) -> bool:
    """Whether a line gives a key, or opens the table of that name."""
    given = re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*(=|\.)", line) if in_table else None
    head = HEAD.match(line)
    return bool(given) or bool(head and key == head[1].rpartition(".")[2].strip("\"'"))


def _lines_of(table: str, number: int, text: str, document: Mapping[str, Any]) -> list[tuple[int, str]]:
    """The lines, with their numbers from 1, of the table [table] and its inner ones; of several, [[table]], that of a number."""
    lines, count, inside = [], 0, False
    for place, line in enumerate(text.splitlines(), start=1):
        head = HEAD.match(line)
        first = head[1].partition(".")[0].strip(" \"'") if head else ""
        if head and first in document:
            count += head[1].strip("\"'") == table
            inside = first == table and (count == number or not isinstance(document[table], list))
        if inside or (not head and not count and re.match(rf"\s*{re.escape(table)}\s*[=.]", line)):
            lines.append((place, line))
    return lines
