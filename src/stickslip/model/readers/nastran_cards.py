"""Bulk data of Nastran as entries of fields: small fields of 8, large ones of 16 (NAME*), free format with commas.

Included files are read in place, replicated entries (=) written out, and nothing is read after ENDDATA.
(MSC Nastran Quick Reference Guide, Format of bulk data entries; Replication; INCLUDE; ENDDATA.)

What the reader of grid points does with each entry stands in `cards.toml`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from stickslip.model.readers.deck import CardList
from stickslip.model.readers.included_files import Line, Lines
from stickslip.model.readers.limits import refuse_utf_16, within_memory
from stickslip.model.readers.numbers import number_of
from stickslip.support.checks import fault

BULK_CARDS = CardList.of("nastran")


EXPONENT = re.compile(r"([0-9.])([+-]\d+)$")
REPEAT = re.compile(r"=\(?(\d{1,9})\)?")
SECTION = re.compile(r"\s*BEGIN\s+(BULK\b.*|SUPER\b.*|MODULE\b.*|AUXMODEL\b.*|$)", re.IGNORECASE)
BEGIN = "BEGIN"
"""The name of the entry that stands for BEGIN BULK, BEGIN SUPER=7: its second field is what follows the word."""
MOST_REPLICATED = 100_000
"""Entries that = makes in a deck: more is a slip."""
SMALL, LARGE = 8, 4
"""Fields of a line beside its first and the mark of its continuation."""


class Entry(NamedTuple):
    """The fields of an entry with its continuations, the name without its star first; and where it begins."""

    fields: list[str]
    line: Line


WITH_TEXT = {"DEQATN", "DRESP3", "GROUP", "MONCARL", "MONDSP1", "MONGRP", "MONSUM", "MONSUM1", "MONSUMT", "UDNAME"}
WITH_TEXT |= {"MONPNT1", "MONPNT2", "MONPNT3"}
"""Entries with an equation, a label or a name of a file, in which commas part no fields."""
FREE_FORMAT = re.compile(
    r"\s*(BEGIN|CHEXA|CORD[12][CRS]|CPENTA|CPYRAM?|CQUAD[48R]|CTETRA|CTRIA[36R]|DMIG|EXTRN|GRDSET|GRID)\s*,", re.IGNORECASE
)
"""A line of such an entry that counts, behind blanks."""


def included(text: str, more: Iterator[str]) -> str | None:
    """The file of INCLUDE 'FILE', whose name in quotation marks may go on over several lines."""
    match = re.match(r"\s*INCLUDE\b\s*=?\s*(.*)", text, re.IGNORECASE)
    if not match:
        return None
    name = match[1].strip()
    mark = name[:1]
    if mark not in ("'", '"'):
        return name.split("$")[0].strip()
    while name.count(mark) < 2 and (line := next(more, None)) is not None:
        name += line.strip()
    return name.split(mark)[1]


def bulk_lines(path: Path, memory: int) -> Iterator[Line]:
    """The lines of the bulk data of a deck, after Executive and Case Control where it has them; memory: as `Lines` has it."""
    within_memory(path.name, memory * path.stat().st_size)
    refuse_utf_16(path)
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        started = not any(SECTION.match(text) for text in file)

    def named(text: str, more: Iterator[str]) -> str | None:
        nonlocal started
        started = started or SECTION.match(text) is not None
        return included(text, more) if started else None

    yield from (line for line in Lines(path, named, memory).read() if started)


def entries(lines: Iterable[Line]) -> Iterator[Entry]:
    """Each bulk data entry with its continuations, replicated ones written out; up to ENDDATA."""
    entry: Entry | None = None  # the last one, until a line shows that no continuation of it follows
    mark = ""
    pattern: list[str] = []
    made = 0
    for line in lines:
        text = line.text.split("$")[0].expandtabs()
        if not text.strip():
            continue
        if re.match(r"\s*ENDDATA\b", text, re.IGNORECASE):
            break
        section = SECTION.match(text)
        name = re.match(r"\s*([A-Z][A-Z0-9]*)", text, re.IGNORECASE)
        if not section and name and name[1].upper() in WITH_TEXT:
            if entry is not None:
                yield entry
            entry, mark = Entry([name[1].upper()], line), ""
            continue
        if entry is not None and entry.fields[0] in WITH_TEXT and re.match(r" {8}|[+*]", text) and not FREE_FORMAT.match(text):
            continue
        first, *rest = [BEGIN, section[1].upper()] if section else _fields(text, line)
        if first.startswith("=") and entry is not None:
            yield entry
            count = REPEAT.fullmatch(first)
            pattern = pattern if count else rest  # =(3) repeats the pattern of the line before, = has one of its own
            times = int(count[1]) if count else 1
            made += times
            if made > MOST_REPLICATED or not pattern or len(entry.fields) > SMALL + 1:
                raise fault(f"{line.place}, replication", "must repeat entries of one line", first, "Write the entries out.")
            for number in range(times):
                entry = Entry(_replicated(entry.fields, pattern, line), line)
                if number < times - 1:
                    yield entry
        elif first in ("", "*") or first[0] in "+*":
            _refuse_out_of_order(entry, mark, first, line)
            if entry is not None:
                entry.fields.extend(rest)
            mark = _mark(text)
        else:
            mark = _mark(text)
            if entry is not None:
                yield entry
            entry = Entry([first.partition(" ")[0].rstrip("*").upper(), *rest], line)
    if entry is not None:
        yield entry


def _refuse_out_of_order(entry: Entry | None, mark: str, first: str, line: Line) -> None:
    """Refuse a continuation that does not stand behind the line it continues, whose last field has the same mark."""
    own = first.lstrip("+*").strip().upper()
    alone = entry is None or entry.fields[0] == BEGIN
    if alone or (own and mark and own != mark):
        remedy = "Sort the file, so that each entry is whole."
        behind = "behind no entry" if alone else f"behind a line that ends in {mark!r}"
        raise fault(f"{line.place}, the continuation {first!r}", "must follow the line it continues", behind, remedy)


def _mark(text: str) -> str:
    """The mark of the continuation, the last field of a line."""
    words = text.split(",")
    count = LARGE if "*" in words[0][:8] else SMALL
    last = words[count + 1] if len(words) > count + 1 else "" if len(words) > 1 else text[72:80]
    return last.strip().lstrip("+*").strip().upper()


def _fields(text: str, line: Line) -> list[str]:
    """The first field, and eight small or four large ones; blanks where the line ends early."""
    count = LARGE if "*" in text.split(",")[0][:8] and not text.startswith("=") else SMALL
    if "," in text:
        words = [word.strip() for word in text.split(",")]
        if any(words[count + 2 :]):
            raise fault(
                line.place, f"must hold at most {count} fields after its name", words[:20], "Continue it on another line."
            )
        return (words + [""] * count)[: count + 1]
    width = 64 // count
    return [text[:8].strip(), *(text[start : start + width].strip() for start in range(8, 72, width))]


def _replicated(previous: list[str], pattern: list[str], line: Line) -> list[str]:
    """The entry after `previous`: = is the same field, *x one greater by x, == all fields that are left, others themselves."""
    made = [previous[0]]
    for old, word in zip(previous[1:], pattern, strict=False):
        if word == "==":
            return [*made, *previous[len(made) :]]
        if word.startswith("*"):
            step = word.strip("*()")
            plain = re.fullmatch(r"[+-]?\d*", old) and re.fullmatch(r"[+-]?\d+", step)
            made.append(str(int(old or 0) + int(step)) if plain else repr(number(old) + number(step)))
        elif word.startswith("=") and word != "=":
            raise fault(f"{line.place}, replication", "must hold =, ==, *increment or a value", word, "Write the entries out.")
        else:
            made.append(old if word == "=" else word)
    return made


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
    text = EXPONENT.sub(r"\1E\2", word)
    value = number_of(text) if text else 0.0
    if value is None:
        raise fault("A field of an entry", "must be a number", word[:20])
    return value
