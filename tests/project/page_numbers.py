"""Measured numbers on the hand-written pages, and what computes them by docs/numbers.toml: the rules stand in CONTRIBUTING.md.

A page is read in pieces (a paragraph, a list item, a row of a table), and `faults` compares the numbers of each with its sources.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from pathlib import Path

from verify.row import PAGE

ROOT = Path(__file__).parents[2]
REGISTER = ROOT / "docs" / "numbers.toml"
# What commands write: these pages need no sources, since nobody can change a number on them.
GENERATED = {
    "verify": "docs/verification.md",
    "variability": "docs/variability_numbers.md",
    "robustness": "docs/robustness.md",
    "calibration": "docs/calibration.md",
    "bench": "docs/benchmarks.md",
    "mutation": "docs/mutation.md",
    "study": "docs/study_reference.md",
}
STATED = ("given", "published")
KINDS = ("verify", "test", "variability", "robustness", "bench", *STATED)

ALL = "all of: "
"""Before the opening words of a block whose numbers all have a source."""

_FENCE = re.compile(r"^ *(```+|:::+).*?^ *\1 *$", re.S | re.M)
# A formula that is only a power of ten is a number; all others are formulas.
_POWER = re.compile(r"\$\s*(?:(\d+(?:\.\d+)?)\s*\\cdot\s*)?10\^\{?(-?\d+)\}?\s*\$")
_NOT_TEXT = (
    re.compile(r"\A---\n.*?^---$", re.S | re.M),  # front matter
    re.compile(r"(`+)(?!`).+?(?<!`)\1(?!`)", re.S),  # code
    re.compile(r"\$\$.*?\$\$|\$[^$\n]+\$", re.S),  # formulas
    re.compile(r"(?<=\])\([^()\s]*(?:\([^()]*\)[^()\s]*)?\)|<https?://[^>]*>"),  # targets of links
)
_RULE = re.compile(r"\s*\|(\s*:?-+:?\s*\|)+\s*$")  # below the head of a table
_SUPERSCRIPTS = str.maketrans("⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹", "-+0123456789")
_NUMBER = re.compile(
    r"(?<![\w.])(?P<digits>\d+(?:\.\d+)?|\.\d+)(?P<power>e[-+]?\d+|(?:\s?[·×]\s?)10[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
    r"(?P<reciprocal>st|nd|rd|th)?(?!\.?\d|\w|[⁻⁰¹²³⁴⁵⁶⁷⁸⁹])|(?<![\w.·×])(?P<ten>10[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)"
)
_PERCENT = r"%|per ?cent\b"
_UNITS = (
    r"rad/s|kHz|Hz|[mµun]m/N|m/s/N|[kMG]?N/[µm]?m|nm|µm|um|mrad|[mµ]?J|[MG]Pa|[MG]i?B|"
    r"[mµ]s|s(?!\w)|milliseconds?|seconds?|min(?:utes?)?|hours?|times"
)
_UNIT = re.compile(rf"\s*(?:(?P<percent>{_PERCENT})|(?:{_UNITS})(?![\w/]))")
_IN_HEADER = re.compile(rf"(?<![\w/])(?:{_UNITS})(?![\w/])")
_JOIN = re.compile(r"\s*(?:,|,? ?to|,? ?and|,? ?or|–|±|against|instead of)\s*[-−]?\Z")


@dataclass(frozen=True)
class Number:
    """A number as it stands on a page: exact value, half a unit of its last digit."""

    text: str
    value: Fraction
    half: Fraction
    percent: bool = False
    reciprocal: bool = False

    def agrees(self, computed: float) -> bool:
        """Whether it is this value rounded to its digits; the unit may have another prefix (10³, 10⁻⁶, ...), or be per cent."""
        exact = abs(Fraction(computed))
        factors = [Fraction(100)] if self.percent else [Fraction(1000) ** k for k in range(-4, 5)]
        values = [exact * factor for factor in factors]
        if self.reciprocal and exact:
            values.append(1 / exact)
        return any(abs(self.value - value) <= self.half * (1 + Fraction(1, 10**9)) for value in values)


@dataclass(frozen=True)
class Source:
    """Where numbers are computed, or which numbers were given or published, for what begins with some words of a page."""

    opening: str
    kind: str
    body: str

    def holds_for(self, piece: Piece) -> bool:
        if self.opening.startswith(ALL):
            return piece.block.startswith(self.opening.removeprefix(ALL))
        return piece.opening.startswith(self.opening)


@dataclass
class Piece:
    """A paragraph, list item or row: its lines with numbers in their places, and the words with which it and its block, all from
    one empty line to the next, open."""

    opening: str
    block: str
    lines: list[tuple[int, str]] = field(default_factory=list)
    columns: tuple[bool, ...] = ()  # of a row: whose heads name a unit

    def numbers(self) -> Iterator[tuple[int, Number]]:
        """Line and number of every measured number."""
        if self.columns:
            line, text = self.lines[0]
            for i, cell in enumerate(cells(text)):
                yield from ((line, number) for _, number in measured(cell, self.columns[min(i, len(self.columns) - 1)]))
            return
        starts, text = [], ""
        for line, part in self.lines:
            starts.append((len(text), line))
            text += part + "\n"
        for place, number in measured(text):
            yield max(entry for entry in starts if entry[0] <= place)[1], number


def opening(line: str) -> str:
    """A line in words: without the signs of lists, tables, heads and emphasis."""
    return " ".join(re.sub(r"[|*`#>_]|^\s*(?:[-+:]|\d+\.)\s", " ", line).split())


def cells(row: str) -> list[str]:
    """The cells of a row of a table."""
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", row.strip().strip("|"))]


def _read(found: re.Match[str], percent: bool = False) -> Number:
    digits = found["digits"] or "1"
    power = (found["power"] or found["ten"] or "0").translate(_SUPERSCRIPTS)
    scale = Fraction(10) ** int(re.sub(r"^(e|\s?[·×]\s?10|10)", "", power) or 0)
    half = Fraction(1, 2) * Fraction(10) ** -len(digits.partition(".")[2]) * scale
    return Number(found[0], Fraction(digits) * scale, half, percent, bool(found["reciprocal"]))


def measured(text: str, whole: bool = False) -> list[tuple[int, Number]]:
    """Place and number of what counts as measured: with decimal point, exponent, per cent, ordinal or unit; all when `whole`.

    In a list ("503 to 529 Hz") the unit at the end is that of every number before it.
    """
    found = list(_NUMBER.finditer(text))
    numbers: list[tuple[int, Number]] = []
    unit, percent, behind = False, False, len(text)
    for match in reversed(found):
        own = _UNIT.match(text, match.end())
        if own is not None:
            unit, percent = True, own["percent"] is not None
        elif not _JOIN.match(text[match.end() : behind]):
            unit, percent = False, False
        behind = match.start()
        number = _read(match, percent)
        if whole or unit or "." in number.text or match["power"] or match["ten"] or number.reciprocal:
            numbers.append((match.start(), number))
    return numbers[::-1]


def _blank(match: re.Match[str]) -> str:
    """Spaces in place of text, so that lines and places stay."""
    return re.sub(r"[^\n]", " ", match[0])


def _power(match: re.Match[str]) -> str:
    return f"{match[1] or 1}e{match[2]}".ljust(len(match[0]))


def pieces(page: str) -> Iterator[Piece]:
    """The pieces of a page, without code, formulas and targets of links."""
    page = _FENCE.sub(_blank, page)
    text = _POWER.sub(_power, page)
    for pattern in _NOT_TEXT:
        text = pattern.sub(_blank, text)
    block = ""
    columns: tuple[bool, ...] = ()
    piece: Piece | None = None
    lines = text.splitlines()
    for i, (line, original) in enumerate(zip(lines, page.splitlines(), strict=True)):
        if not original.strip():
            if piece is not None:
                yield piece
            piece, block, columns = None, "", ()
            continue
        block = block or opening(original)
        if piece is None and _RULE.match(lines[i + 1] if i + 1 < len(lines) else ""):
            columns = tuple(bool(_IN_HEADER.search(cell)) for cell in cells(line))
        if piece is None or columns or re.match(r"\s*([*+-]|\d+\.|#+|:)\s", line):
            if piece is not None:
                yield piece
            piece = Piece(opening(original), block, columns=columns)
        piece.lines.append((i + 1, line))
    if piece is not None:
        yield piece


@cache
def verified() -> dict[str, list[float]]:
    """What docs/verification.md says of each of its rows: value, reference (unless it comes from the page itself), tolerance.

    Rows in per cent say so at the end of their name.
    """
    rows: dict[str, list[float]] = {}
    for line in (ROOT / GENERATED["verify"]).read_text().splitlines():
        row = cells(line)
        if len(row) == 7 and row[6] in ("yes", "**no**"):
            stated = row[1], "" if row[5] == PAGE else row[2], row[4]
            unit = 0.01 if row[0].endswith("%") else 1.0
            rows.setdefault(row[0].replace(r"\|", "|"), []).extend(unit * float(cell) for cell in stated if cell)
    return rows


def _of_verify(body: str) -> list[float] | str:
    pattern = re.compile(".*".join(map(re.escape, body.split("*"))))
    rows = [values for name, values in verified().items() if pattern.fullmatch(name)]
    return [value for row in rows for value in row] or f"{GENERATED['verify']} has no row {body!r}"


def _literals(node: ast.AST) -> Iterator[float]:
    for part in ast.walk(node):
        if isinstance(part, ast.Constant) and isinstance(part.value, (int, float)) and not isinstance(part.value, bool):
            yield float(part.value)


def _of_test(body: str) -> list[float] | str:
    """The numbers in a test, its decorators and the constants of its file that these name."""
    path, _, name = body.partition("::")
    if not (ROOT / path).is_file():
        return f"there is no file {path}"
    tree = ast.parse((ROOT / path).read_text())
    functions = [part for part in ast.walk(tree) if isinstance(part, ast.FunctionDef) and part.name == name.split("::")[-1]]
    if not name or not functions:
        return f"{path} has no test {name!r}"
    test = functions[0]
    if not any(isinstance(part, ast.Assert) or getattr(part, "attr", "").startswith("assert_") for part in ast.walk(test)):
        return f"{body} asserts nothing"
    used = {part.id for part in ast.walk(test) if isinstance(part, ast.Name)}
    named = [
        part.value
        for part in tree.body
        if isinstance(part, (ast.Assign, ast.AnnAssign)) and part.value is not None
        for target in (part.targets if isinstance(part, ast.Assign) else [part.target])
        if isinstance(target, ast.Name) and target.id in used
    ]
    return [value for node in (test, *named) for value in _literals(node)]


def _of_generated(kind: str, body: str) -> list[float] | str:
    """The numbers of the lines of a generated page that hold the key; "HEADING / FIRST CELL" for one row of one table."""
    title, _, key = body.rpartition(" / ")
    heading, values = "", []
    for line in (ROOT / GENERATED[kind]).read_text().splitlines():
        if line.startswith(("#", "**")):
            heading = line
        held = cells(line)[0] == key if title and line.startswith("|") else not title and key in line
        if held and title in heading:
            values += [float(number.value) / (100 if number.percent else 1) for _, number in measured(line, whole=True)]
    return values or f"{GENERATED[kind]} has no line {body!r}"


def _stated(source: Source) -> list[Number] | str:
    """The numbers of "4.6, 80 Hz; publication"."""
    listed, _, publication = source.body.partition(";")
    if source.kind == "published" and not publication.strip():
        return "the publication must follow the numbers, after a semicolon"
    return [_read(found) for found in _NUMBER.finditer(listed)] or "the numbers themselves must stand in it"


def _meant(source: Source) -> list[float] | list[Number] | str:
    """The numbers that a source answers for, or what is wrong with it."""
    if source.kind == "verify":
        return _of_verify(source.body)
    if source.kind == "test":
        return _of_test(source.body)
    if source.kind in STATED:
        return _stated(source)
    return _of_generated(source.kind, source.body) if source.kind in KINDS else f"a source is one of {', '.join(KINDS)}"


def _covers(meant: float | Number, number: Number) -> bool:
    if isinstance(meant, Number):
        return (number.value, number.half) == (meant.value, meant.half)
    return number.agrees(meant)


def register() -> dict[str, dict[str, list[str]]]:
    """The sources of all pages, by page and opening words."""
    return tomllib.loads(REGISTER.read_text())


def faults(page: str, sources: dict[str, list[str]], name: str = "page") -> list[str]:
    """Every measured number that no source answers for, and every source that names nothing or answers for no number."""
    listed = []
    for words, texts in sources.items():
        listed += [Source(words, kind, body.strip()) for kind, _, body in (text.partition(":") for text in texts)]
    meant = {source: _meant(source) for source in listed}
    found: list[str] = []
    used: dict[Source, set[float | Number]] = {}
    for piece in pieces(page):
        own = [source for source in listed if source.holds_for(piece)]
        for line, number in piece.numbers():
            covering = [
                (source, one) for source in own for one in meant[source] if not isinstance(one, str) and _covers(one, number)
            ]
            for source, one in covering:
                used.setdefault(source, set()).add(one)
            if not covering:
                held = "; ".join(f"{source.kind}: {source.body}" for source in own)
                place = f"{name}:{line}: {number.text}: "
                found.append(place + (f"not given by {held}" if held else f'no source; "{piece.opening}" begins no entry'))
    for source, numbers in meant.items():
        unused = [number.text for number in numbers if isinstance(number, Number) and number not in used.get(source, ())]
        place = f"{name}: {source.opening}: {source.kind}: "
        if isinstance(numbers, str):
            found.append(place + numbers)
        elif unused or source not in used:
            found.append(f"{place}{', '.join(unused) or source.body}: no such number in what begins so")
    return found
