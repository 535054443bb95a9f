"""Bulk data of Nastran as entries of fields: small fields of 8, large ones of 16 (NAME*), free format with commas.

(MSC Nastran Quick Reference Guide, Format of bulk data entries.)
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from stickslip.checks import fault

EXPONENT = re.compile(r"([0-9.])([+-]\d+)$")
CARD = 10
"""Fields of an entry and its continuation mark in small format."""


def entries(lines: Iterator[str]) -> Iterator[list[str]]:
    """Each bulk data entry with its continuations as fields; the name without its star."""
    entry: list[str] = []
    for raw in lines:
        line = raw.split("$")[0].rstrip("\r\n").expandtabs()
        if not line.strip():
            continue
        first, *rest = _fields(line)
        if first in ("", "*") or first[0] in "+*":
            entry += rest
            continue
        if entry:
            yield entry
        entry = [first.rstrip("*").upper(), *rest]
    if entry:
        yield entry


def _fields(line: str) -> list[str]:
    """The first field, and eight small or four large ones; blanks where the line ends early."""
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        return (words + [""] * (CARD - 1))[: CARD - 1]
    width, number = (16, 4) if "*" in line[:8] else (8, 8)
    places = range(8, 8 + width * number, width)
    return [line[:8].strip(), *(line[place : place + width].strip() for place in places)]


def integer(word: str) -> int:
    """A whole number; large fields hold up to 16 digits."""
    if not re.fullmatch(r"[+-]?\d{1,16}", word):
        raise fault("A field of an entry", "must be a whole number", word[:20])
    return int(word)


def positive_integer(word: str) -> int:
    """The number of a grid point."""
    value = integer(word)
    if value < 1:
        raise fault("The number of a grid point", "must be positive", value)
    return value


def number(word: str) -> float:
    """A number as Nastran writes it: 1.0+5 and 1.0D+5 are 1e5, a blank is 0."""
    text = EXPONENT.sub(r"\1E\2", word.upper().replace("D", "E"))
    try:
        return float(text or 0.0)
    except ValueError:
        raise fault("A field of an entry", "must be a number", word[:20]) from None
