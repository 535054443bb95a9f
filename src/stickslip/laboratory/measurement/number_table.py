"""Tables of numbers from text files with any common separator and from MATLAB files, with titles and units where they are.

Units of measured responses: frequency, force, phase, and motions, by themselves or per force.
"""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.model.readers.matlab import OBJECT_NAMES, arrays_of_several
from stickslip.model.readers.numbers import DIGITS, number_of
from stickslip.support.checks import Array, InputError, counted, fault, first_of, nearest

DEGREE = np.pi / 180.0
INCH, FOOT, POUND, GRAVITY = 0.0254, 0.3048, 4.4482216152605, 9.80665
"""In m, N and m/s², exactly, by the international yard and pound of 1959 and the standard gravity of 1901."""

LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "cm": 1e-2}
LENGTHS |= {"in": INCH, "inch": INCH, "ft": FOOT, "mil": 1e-3 * INCH}
FORCES = {"n": 1.0, "kn": 1e3, "mN": 1e-3, "MN": 1e6, "dan": 10.0, "lbf": POUND, "kgf": GRAVITY}
RESPONSE_UNITS: dict[str, dict[str, float]] = {
    "frequency": {"hz": 1.0, "khz": 1e3, "rad/s": 0.5 / np.pi},
    "displacement": LENGTHS,
    "velocity": {f"{length}/s": factor for length, factor in LENGTHS.items()} | {"ips": INCH},
    "acceleration": {
        **{f"{length}/s{two}": factor for length, factor in LENGTHS.items() for two in ("2", "²", "^2")},
        "g": GRAVITY,
        "gn": GRAVITY,
    },
    "force": {**FORCES, "1": 1.0},
    "phase": {"rad": 1.0, "deg": DEGREE, "degree": DEGREE, "degrees": DEGREE, "°": DEGREE},
}
"""Units of a column in Hz, m, m/s, m/s², N or rad."""

MOTIONS = ("displacement", "velocity", "acceleration")
BY_MASS = {"s2/kg": "displacement", "s^2/kg": "displacement", "s²/kg": "displacement", "s/kg": "velocity", "1/kg": "acceleration"}
"""The same per force in base units: 1 N is 1 kg m/s²."""

_FORCE = "|".join(FORCES)
_PER_FORCE = re.compile(rf"(.+)/\(?({_FORCE})\)?", re.IGNORECASE)
_BY_FORCE = re.compile(rf"\(1/({_FORCE})\)(.+)", re.IGNORECASE)
_PER_PRODUCT = re.compile(rf"(.+)/\((?:({_FORCE})(s(?:2|²|\^2)?)|(s(?:2|²|\^2)?)({_FORCE}))\)", re.IGNORECASE)


@dataclass(frozen=True)
class ResponseUnit:
    """What a unit is of, its factor to SI, and whether it is per force: mm/N, (m/s^2)/N, g/N, m/(N s²), 1/kg."""

    kind: str
    factor: float
    per_force: bool = False


@dataclass(frozen=True)
class FileUnit:
    """Unit of a column of a file, its factor to SI, and whether it was assumed since the file states none."""

    text: str
    factor: float
    assumed: bool = False


def response_unit(text: str) -> ResponseUnit | None:
    """The unit that a text names, or None."""
    unit = re.sub(r"[\s·*]", "", text).replace("_", "/")  # m_s2, rad_s
    unit = re.sub(r"(?<![A-Za-z])sec(?![A-Za-z])", "s", unit)  # in/sec^2
    if match := _BY_FORCE.fullmatch(unit):  # (1/N)*(m/s2)
        unit = f"{match.group(2)}/{match.group(1)}"
    if found := _single(unit):
        return ResponseUnit(*found)
    if unit.lower() in BY_MASS:
        return ResponseUnit(BY_MASS[unit.lower()], 1.0, True)
    if match := _PER_PRODUCT.fullmatch(unit):
        length, force, time, time_2, force_2 = match.groups()
        motion, force = f"{length}/{time or time_2}", force or force_2
    elif match := _PER_FORCE.fullmatch(unit):
        motion, force = match.group(1).strip("()"), match.group(2)
    else:
        return None
    above, below = _single(motion), _single(force)
    if above is None or below is None or above[0] not in MOTIONS:
        return None
    return ResponseUnit(above[0], above[1] / below[1], True)


def known_unit(what: str, text: str, kinds: Sequence[str]) -> ResponseUnit:
    """The unit that a text names, which must be of one of some kinds, by itself or per force."""
    unit = response_unit(text)
    if unit is None or unit.kind not in kinds:
        known = [name for kind in kinds for name in RESPONSE_UNITS[kind]]
        rule = f"must be one of {', '.join(known)}" + (", or one of these per N" if kinds[0] in MOTIONS else "")
        raise fault(what, rule, text, nearest(text, known))
    return unit


def per_force_unit(what: str, text: str, kinds: Sequence[str], key: str = "amplitude") -> ResponseUnit:
    """The unit that a text names, which must be that of a motion per force."""
    unit = known_unit(what, text, kinds)
    if not unit.per_force:
        right = per_newton(text)
        raise fault(what, "must be per force", text, f"Say units={{'{key}': '{right}'}} (--unit '{key}={right}').")
    return unit


def per_newton(unit: str) -> str:
    """The unit of a motion per force, from that of the motion."""
    return f"({unit})/N" if "/" in unit else f"{unit}/N"


def contradicted(name: str, key: str, stated: str | None, given: str) -> list[str]:
    """The note on a unit that is given against that of the file."""
    if stated is None or response_unit(stated) == response_unit(given):
        return []
    return [f"The unit of {key} in {name} is taken for {given}, as given, though the file says {stated}."]


def _single(unit: str) -> tuple[str, float] | None:
    """Kind and factor of a unit that is not per force; mN is not MN."""
    for spelling in (unit, unit.lower()):
        for kind, known in RESPONSE_UNITS.items():
            if spelling in known:
                return kind, known[spelling]
    return None


UNITS: dict[str, tuple[str, float]] = {
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "us": ("s", 1e-6),
    "µs": ("s", 1e-6),
    "min": ("s", 60.0),
    **{length: ("m", factor) for length, factor in LENGTHS.items()},
    **{f"{prefix}N": ("N", factor) for prefix, factor in (("", 1.0), ("k", 1e3), ("da", 10.0), ("m", 1e-3))},
    **{f"{micro}N": ("N", 1e-6) for micro in "uµμ"},
    **{force: ("N", FORCES[force]) for force in ("lbf", "kgf")},
    "rad": ("rad", 1.0),
    "mrad": ("rad", 1e-3),
    "deg": ("rad", DEGREE),
}
"""Units of columns: the SI unit that each stands for, and the factor to it."""

SEPARATORS = ("\t", ";", ",", None)
"""None stands for blanks. The comma comes last but one: before it, it may be a decimal comma."""

COMMENT = "#%!"
STAMP = re.compile(
    r"(?:\d{1,4}([-/.])\d{1,2}\1\d{1,4}(?:[ T]|$))?(?:\d{1,2}:\d{2}(?::\d{2}(?:[.,]\d+)?)?(?: ?[AP]M|Z)?)?(?<=.)", re.ASCII
)
"""A date, a time of day, or both."""
LINE_NAME = re.compile(r".*:$|(?:names?|titles?|units?|channels?|signals?|quantity|quantities)\b", re.IGNORECASE)
"""What a line above the numbers is called, before its first column."""
BEHIND = re.compile(r"(?<=[\s;,])#.*")
"""A comment behind the numbers of a row."""
FAULTY_CELL = re.compile(r"#(?:N/A|REF!|VALUE!|DIV/0!|NUM!|NAME\?|NULL!)")
"""What spreadsheets write into a cell without a value, which is no comment."""
FEWEST_ROWS = 3
"""Rows of a curve."""
FEWEST_ALIKE = 10
"""Rows from which a column of as many decimals is no chance."""
MISREAD = re.compile(r"(?=.*[\d.])[\d.,+\-eEOolISB]+")
"""A number with letters that were taken for digits."""
HYSTERESIS = "hyst"
"""Name of the matrix (displacement, force) in MATLAB files of single loops."""


@dataclass(frozen=True, eq=False)
class NumberTable:
    """numbers (rows, columns), titles of the columns without their units or None, units or None of each, notes."""

    name: str
    numbers: Array
    titles: tuple[str, ...] | None
    units: tuple[str | None, ...]
    notes: tuple[str, ...] = ()


def text_table(path: Path, knows: Callable[[str], bool] = lambda title: False) -> NumberTable:
    """The numbers of a text file: from the first line of at least two numbers that the next line continues, and from the damaged
    rows directly above it, which are refused like later ones.

    knows: whether a title is understood; of several lines above the numbers, the one with the most of these holds the titles.
    """
    text = _text(path)
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    for place, (_, line) in enumerate(lines[:-1]):
        for separator in SEPARATORS:
            cells = _cells(line, separator)
            row, count = [_number(cell, separator) for cell in cells if not STAMP.fullmatch(cell)], len(cells)
            if len(row) > 1 and None not in row and count == len(_cells(lines[place + 1][1], separator)):
                place = _first_row([text for _, text in lines[:place]], separator, count, knows)
                body = [
                    pair for pair in lines[place:] if pair[1].lstrip()[0] not in COMMENT or FAULTY_CELL.match(pair[1].lstrip())
                ]
                numbers = _numbers(path.name, body, separator, count)
                titles, units = _head([text for _, text in lines[:place]], separator, count, knows)
                _refuse_other_digits(path.name, body, separator, count)
                notes = [f"{path.name}: {place} lines above the numbers are no titles."] if titles is None and place > 0 else []
                read = {number for number, _ in body}
                left = [number for number, _ in lines[place:] if number not in read]
                between = [str(number) for number in left if number < body[-1][0]]
                if not text.endswith(("\n", "\r")) and len(body) > 1 and _is_shorter(body[-2][1], body[-1][1], separator):
                    notes.append(f"{path.name}: the last line has no end, and fewer decimals than the line above. Is it cut off?")
                rows_above = [str(n) for n, text in lines[:place] if _is_whole_row(text, separator, count)]
                if rows_above:
                    notes.append(f"{path.name}: numbers above the titles are left out, line {first_of(rows_above, 3)}.")
                if between:
                    notes.append(f"{path.name}: comments between the numbers are left out, line {first_of(between, 3)}.")
                return NumberTable(path.name, numbers, titles, units, tuple(notes))
    shown = f"{counted(len(lines), 'line')} without two such rows in turn" if lines else "empty"
    raise fault(path.name, "must hold two rows of numbers or more, in two columns or more", shown)


def _first_row(above: Sequence[str], separator: str | None, count: int, knows: Callable[[str], bool]) -> int:
    """How many of the lines above a row of numbers are no rows, damaged ones included.

    A row of another number of cells may be a line of settings, unless a row or the titles stand above it.
    """
    place = first = len(above)
    while place > 0 and (cells := _row_cells(above[place - 1], separator, count, knows)):
        place -= 1
        first = place if cells == count else first
    return place if place < first and place > 0 and _titles(above[place - 1], separator, count) else first


def _is_whole_row(line: str, separator: str | None, count: int) -> bool:
    """Whether a line holds nothing but as many numbers as a row."""
    cells = _cells(line, separator)
    return len(cells) == count and all(_number(cell, separator) is not None and not STAMP.fullmatch(cell) for cell in cells)


def _row_cells(line: str, separator: str | None, count: int, knows: Callable[[str], bool]) -> int:
    """The number of cells of a line that is a row, though a cell may be damaged or the separator be another (-1); 0 for any other
    line. Of a row half of the cells or more are numbers, and the first is no word, such as the name of a setting."""
    if line.lstrip()[0] in COMMENT and not FAULTY_CELL.match(line.lstrip()):
        return 0
    cells = _cells(line, separator)
    cells = cells if len(cells) == count else _split(line, separator)
    if any(knows(bare(cell)) for cell in cells) or _holds_units(cells):
        return 0
    for every, found in ((cells, len(cells)), (re.split(r"[\s;,]+", line.strip()), -1)):
        filled = [cell for cell in every if cell and not STAMP.fullmatch(cell)]
        numbers = sum(_number(cell, separator) is not None for cell in filled)
        named = re.match(r"[^\W\d_]", every[0]) and not MISREAD.fullmatch(every[0]) and _number(every[0], separator) is None
        if numbers >= max(1, len(filled) / 2) and not named:
            return found
    return 0


def _text(path: Path) -> str:
    """The text of a file in UTF-8, UTF-16 or, failing these, the code page of Western Europe."""
    data = path.read_bytes()
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return data.decode("utf-16", errors="replace")
    if b"\0" in data[:4096]:
        remedy = "Export it as text, or save it as .mat."
        raise fault(path.name, "must be a text file, or a MATLAB file that ends in .mat", "binary", remedy)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _split(line: str, separator: str | None) -> list[str]:
    return [cell.strip().strip('"').strip() for cell in line.strip("\r\n" if separator == "\t" else None).split(separator)]


def _cells(line: str, separator: str | None) -> list[str]:
    """The cells of a line of numbers, without an empty first or last one."""
    cells = _split(line, separator)
    return cells[int(not cells[0]) : len(cells) - int(not cells[-1])] if len(cells) > 1 else cells


def _number(cell: str, separator: str | None) -> float | None:
    """The number of a cell; none (NaN) for a date or a time of day."""
    if STAMP.fullmatch(cell):
        return float("nan")
    return number_or_gap(cell if separator == "," else cell.replace(",", ".")) if cell else None


def _numbers(name: str, lines: Sequence[tuple[int, str]], separator: str | None, count: int) -> Array:
    """(rows, columns) of lines of text, NaN for empty cells; each comes with its number in the file, for messages."""
    texts = [text if separator == "," else text.replace(",", ".") for _, text in lines]
    try:
        plain = [BEHIND.sub("", text).strip().rstrip(separator) for text in texts]
        found = np.loadtxt(plain, delimiter=separator, ndmin=2, comments=None)
        if found.shape[1] == count and not np.isinf(found).any():
            return np.asarray(found)
    except ValueError:
        pass
    found = np.empty((len(lines), count))
    for row, (number, text) in enumerate(lines):
        cells = _cells(text, separator)
        cells = cells if len(cells) == count else _split(text, separator)  # of gaps at an end of the line
        if len(cells) != count:
            raise fault(f"Line {number} of {name}", f"must have {count} cells", len(cells), "Is the file cut off?")
        for column, cell in enumerate(cells):
            value = _number(cell, separator) if cell else float("nan")
            if value is None:
                raise fault(f"Line {number}, column {column + 1} of {name}", "must be a number", cell)
            found[row, column] = value
    return found


def _refuse_other_digits(name: str, lines: Sequence[tuple[int, str]], separator: str | None, count: int) -> None:
    """Refuse the only number of a column that has more decimals than all others, or fewer: some were inserted, or lost.

    More may stand for as many significant digits. Fewer are lost where zeros at the end are written elsewhere, where the last row
    has them, or where nothing follows the decimal point.
    """
    if len(lines) < FEWEST_ALIKE:
        return
    rows = [_split(text, separator) for _, text in lines]
    rows = [row if len(row) == count else _cells(text, separator) for row, (_, text) in zip(rows, lines, strict=True)]
    for column in range(count if all(len(row) == count for row in rows) else 0):
        cells = [row[column] for row in rows]
        digits = [_digits(cell) for cell in cells]
        (usual, alike), *_ = Counter(each and each[0] for each in digits).most_common(1)
        if alike != len(rows) - 1 or usual is None:
            continue
        odd = next(k for k, each in enumerate(digits) if not each or each[0] != usual)
        other, significant = digits[odd], {each[1] for k, each in enumerate(digits) if each and k != odd}
        if other is None:
            continue
        more = other[0] > usual and (len(significant) > 1 or other[1] not in significant)
        zeros = any(cell.endswith("0") for k, cell in enumerate(cells) if k != odd)
        if more or (other[0] < usual and (zeros or odd == len(rows) - 1 or cells[odd].endswith((".", ",")))):
            rule = f"must have {usual} decimals, as all others of its column"
            raise fault(f"Line {lines[odd][0]}, column {column + 1} of {name}", rule, cells[odd], "Is the file damaged?")


def _is_shorter(before: str, last: str, separator: str | None) -> bool:
    """Whether the last number of a line has fewer decimals than that of the line before."""
    one, other = (_digits(_cells(line, separator)[-1]) for line in (before, last))
    return one is not None and (other is None or other[0] < one[0])


def _digits(cell: str) -> tuple[int, int] | None:
    """Decimals and significant digits of a number without an exponent; None of anything else."""
    match = re.fullmatch(r"(?=.*\d)[+-]?0*(\d*)(?:[.,](\d*))?", cell)
    if match is None:
        return None
    return len(match[2] or ""), len((match[1] + (match[2] or "")).lstrip("0"))


def _head(
    lines: Sequence[str], separator: str | None, count: int, knows: Callable[[str], bool]
) -> tuple[tuple[str, ...] | None, tuple[str | None, ...]]:
    """Titles and units from the lines above the numbers: one of titles with or without units, and one of units alone."""
    rows = [cells for line in lines if (cells := _titles(line, separator, count))]
    if not rows:
        return None, (None,) * count
    units = next((row for row in reversed(rows) if len(rows) > 1 and _holds_units(row)), None)
    titles = max((row for row in reversed(rows) if row is not units), key=lambda row: sum(knows(bare(title)) for title in row))
    alone = [""] * count if units is None else [cell.strip("[]()- ") for cell in units]
    stated = (cell if cell not in ("", "1") else stated_unit(title) for cell, title in zip(alone, titles, strict=True))
    return tuple(bare(title) for title in titles), tuple(stated)


def _holds_units(row: Sequence[str]) -> bool:
    """Whether half of the cells or more are units or say that there is none, and more are units than the number 1."""
    cells = [cell.strip("[]() ") for cell in row]
    known = sum(_known_unit(cell) is not None for cell in cells)
    without, ones = sum(not cell.strip("- ") for cell in cells), cells.count("1")
    numbers = any(cell and cell != "1" and number_or_gap(cell) is not None for cell in cells)
    return known > ones and not numbers and 2 * (known + without + ones) >= len(row)


def _titles(line: str, separator: str | None, count: int) -> list[str]:
    """The cells of a line of titles, with or without what the line is called before them; empty unless one for each column."""
    text = line.strip("\r\n").lstrip(COMMENT + " ")
    for mark in dict.fromkeys((separator, "\t", ";", ",", None)):
        cells = _split(text, mark) if mark is not None else _WORD_AND_UNIT.findall(text)
        cells = cells[:-1] if len(cells) > count and not cells[-1] else cells
        cells = cells[1:] if len(cells) == count + 1 and (not cells[0] or LINE_NAME.match(cells[0])) else cells
        if len(cells) == count and any(re.search(r"[^\W\d]", cell) for cell in cells):
            return cells
    return []


_UNIT = r"[\[(](?:[^\[\]()]|\([^\[\]()]*\))*[\])]"  # of (m/s^2)/N, too
_WORD_AND_UNIT = re.compile(rf"[^\s\[(]+(?:\([^()\s]*\))?(?:\s*{_UNIT})?|{_UNIT}")
_IN_BRACKETS = re.compile(r"\s*[\[(]\s*((?:[^\[\]()]|\([^\[\]()]*\))*?)\s*[\])]\s*$")
_AT_END = re.compile(r"(?:\s*/\s*|\s+in\s+|_|,\s*|\s+)(\S+)\s*$")


def _known_unit(text: str) -> str | None:
    short = text in (*UNITS, "Hz", "g", "°") and text != "in"  # not "n", which ends F_n, nor the word in
    return text if short or (len(text) > 2 and response_unit(text) is not None) else None


def stated_unit(title: str) -> str | None:
    """The unit in a title: "Friction [uN]", "Force (N)", "x / mm", "force_N"; None where it has none."""
    if match := _IN_BRACKETS.search(title):
        return match.group(1) or None
    match = _AT_END.search(title)
    return _known_unit(match.group(1)) if match else None


def bare(title: str) -> str:
    """A title without its unit."""
    if _IN_BRACKETS.search(title):
        return _IN_BRACKETS.sub("", title).strip()
    match = _AT_END.search(title)
    return title[: match.start()].strip() if match and _known_unit(match.group(1)) else title.strip()


def named_column(table: NumberTable, name: str, which: str | int) -> int:
    """Index of a column that is given by its title, with its unit or without, or by its number from 1."""
    count = table.numbers.shape[1]
    titles = [title.strip() for title in table.titles or ()]
    if isinstance(which, str) and which.strip() in titles:
        return titles.index(which.strip())
    if isinstance(which, str):
        whole = [k for k, unit in enumerate(table.units) if titles and (titles[k], unit) == (bare(which), stated_unit(which))]
        if len(whole) == 1:
            return whole[0]
    if (number := place_of(which)) is not None:
        if not 1 <= number <= count:
            raise fault(f"The column of {name} in {table.name}", f"must be a number from 1 to {count}", which)
        return number - 1
    raise fault(f"The column of {name} in {table.name}", "must be one of its titles", which, nearest(str(which), titles))


def place_of(which: str | int) -> int | None:
    """The number that names a column or a function, beyond any count where it has more digits than one; None for a name."""
    if isinstance(which, int):
        return which
    text = which.strip()
    return None if not text.isdecimal() else int(text) if len(text) < DIGITS else 10**DIGITS


def matlab_tables(paths: Sequence[Path]) -> list[NumberTable]:
    """The loops of MATLAB files."""
    return [_matlab_table(path.name, arrays) for path, arrays in zip(paths, matlab_arrays(paths), strict=True)]


def matlab_arrays(paths: Sequence[Path]) -> list[dict[str, Any]]:
    """The arrays of each of several MATLAB files by name, those of structs as "FRF.f"."""
    try:
        found = arrays_of_several(paths)
    except InputError as error:
        raise InputError(f"{paths[0].name}: {error}" if len(paths) == 1 else str(error)) from None
    for path, own in zip(paths, found, strict=True):
        if (objects := list(map(str, own.pop(OBJECT_NAMES, ())))) and not own:
            remedy = "Save its numbers as arrays: save('test.mat', 'f', 'H')."
            raise fault(path.name, "must hold arrays; objects are not read", ", ".join(objects), remedy)
    return found


def _matlab_table(name: str, arrays: dict[str, Any]) -> NumberTable:
    """The matrix `hyst`, or else the only matrix of two to four columns, or else vectors of one length by their names."""
    arrays |= {
        f"{key}_{part}": getattr(np.asarray(value), part)
        for key, value in arrays.items()
        if np.iscomplexobj(value)
        for part in ("real", "imag")
    }
    numeric = {key: np.atleast_2d(np.asarray(value)) for key, value in arrays.items() if np.asarray(value).dtype.kind in "fiub"}
    upright = {key: value.T if value.shape[0] < value.shape[1] else value for key, value in numeric.items()}
    tables = {key: value for key, value in upright.items() if 2 <= value.shape[1] <= 4 and value.shape[0] > 4}
    if HYSTERESIS in tables or len(tables) == 1:
        values = np.asarray(tables.get(HYSTERESIS, next(iter(tables.values()))), dtype=float)
        return NumberTable(name, values, None, (None,) * values.shape[1])
    vectors = {key: value[:, 0] for key, value in upright.items() if value.shape[1] == 1 and value.shape[0] > 4}
    if tables or not vectors or len({value.size for value in vectors.values()}) > 1:
        shapes = {key: value.shape for key, value in numeric.items()} or "a file without arrays of numbers"
        remedy = "save('loop.mat', 'hyst') with hyst = [displacement, force] writes one."
        raise fault(f"{name}", "must hold the matrix hyst, one matrix of columns, or vectors of one length", shapes, remedy)
    values = np.stack([np.asarray(value, dtype=float) for value in vectors.values()], axis=1)
    return NumberTable(name, values, tuple(map(bare, vectors)), tuple(map(stated_unit, vectors)))


def number_or_gap(cell: str) -> float | None:
    """The number of a cell, NaN where it is empty or says so, None where it is something else."""
    if re.search(r"\.[+-]|[+-](?!30[0-8]|[0-2])\d{3}$", cell):  # 1.5-103 has lost its E, but 12.-345 something else
        return None
    return float("nan") if cell.lower() in ("", "nan") else number_of(cell)


def to_si(what: str, unit: str, wanted: str) -> float:
    """The factor of a unit to the SI unit `wanted`; refused where it is unknown or of another quantity."""
    if unit not in UNITS:
        raise fault(what, "must be a known one", unit, nearest(unit, UNITS))
    base, factor = UNITS[unit]
    if base != wanted:
        raise fault(what, f"must be one of {', '.join(key for key, (b, _) in UNITS.items() if b == wanted)}", unit)
    return factor
