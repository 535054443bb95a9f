"""Measured frequency responses from text, MATLAB and universal files: which column holds what, in which unit."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.laboratory.measurement.matlab_columns import response_columns
from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.laboratory.measurement.number_table import (
    FEWEST_ROWS,
    MOTIONS,
    RESPONSE_UNITS,
    FileUnit,
    NumberTable,
    ResponseUnit,
    contradicted,
    known_unit,
    matlab_arrays,
    named_column,
    per_force_unit,
    per_newton,
    response_unit,
    text_table,
)
from stickslip.laboratory.measurement.universal_file import is_universal
from stickslip.laboratory.measurement.universal_response import BY_FUNCTION, Wanted, universal_tables
from stickslip.support.checks import Array, among, counted, existing, fault, nearest, vector

PhaseOf = Literal["displacement", "quantity"]

TITLES = {
    "real": ("real", "re"),
    "imaginary": ("imag", "im"),
    "phase": ("phase", "angle", "arg", "lag"),
    "frequency": ("frequency", "freq", "f", "omega", "ω"),
    "force": ("force", "excitation", "level"),
    "amplitude": ("amplitude", "response", "magnitude", "mag", "abs", "frf", "h"),
}
"""Words by which a column is known, in its title, the best first; longer ones may go on. Of several keys that a title fits, the
first one counts."""

QUANTITY_TITLES = {
    "acceleration": ("acceleration", "accelerance", "inertance", "acc", "a"),
    "velocity": ("velocity", "mobility", "vel", "v"),
    "displacement": ("displacement", "receptance", "compliance", "disp", "x"),
}
"""Words for the amplitude of each quantity."""

PER_FORCE = ("accelerance", "inertance", "mobility", "receptance", "compliance", "frf", "transfer", "per")
"""Words of a response per force."""

ANGULAR = ("omega", "ω", "angular")
"""Words of a frequency in rad/s, unless its unit is stated."""

SEVERAL = ("curve", "test", "run", "sweep", "case")
"""Words of a column that numbers the curves of a file."""

FUNCTION = re.compile(r"(h\d*|frf|tf|x|y)(\(.*\))?", re.IGNORECASE)
"""What stands in the brackets of Re(H), Im(H) and arg(H): no unit."""

LARGEST_PHASE = 2.0 * np.pi
"""rad; phases beyond it in a column without a unit may be degrees."""

SI = {"frequency": "Hz", "displacement": "m", "velocity": "m/s", "acceleration": "m/s2", "force": "N", "phase": "rad"}
"""What a column is taken for whose unit is not stated."""

FUNCTION_UNITS = ("frequency", "amplitude", "real", "force")
"""What may be given a unit in a universal file."""

AHEAD = {"displacement": 0.0, "velocity": 0.5 * np.pi, "acceleration": np.pi}
"""rad by which a quantity is ahead of the displacement."""


class Stated(NamedTuple):
    """What a caller says of a file: its columns, their units, whose phase it holds, and other arguments of its tests."""

    columns: Mapping[str, str | int]
    units: Mapping[str, str]
    phase_of: PhaseOf | None
    about: dict[str, Any]


def read_measured_response(
    path: str | Path,
    *,
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
    phase_of: PhaseOf | None = None,
    **about: Any,
) -> MeasuredResponse:
    """A test from a text or MATLAB file with a title for each column, in one of three forms, or from a universal file:

    frequency [Hz], acceleration [m/s2], force [N], phase [rad]     amplitudes; the phase may be missing
    frequency [Hz], accelerance [(m/s^2)/N], phase [deg]            amplitudes per force
    frequency [Hz], Re(H) [mm/N], Im(H) [mm/N]                      complex responses, here per force

    Title or unit name the quantity unless it is given. A response per force needs the force level at which it was measured as
    well, as a column or as `force`, since friction depends on it.
    columns: {"frequency", "amplitude", "real", "imaginary", "phase" or "force": title or number (from 1) of the column} where the
    titles are not understood. units: {the same names: unit} where the file states none, or a wrong one.
    phase_of: what a column of phases is of: the "displacement" (unless given for amplitudes) or the measured "quantity", which
    is 90° ahead of it as a velocity and 180° as an acceleration (unless given for responses per force). Complex responses are
    those of the quantity, with exp(+iωt). A title with the word lag turns the sign. Rows at 0 Hz are left out.
    A file holds one curve; one with several, which a column titled curve, test or run numbers, is refused:
    `read_measured_responses` reads it.
    Of a MATLAB file the vectors of one struct, or those beside all structs, are the columns; where several would do,
    columns={"amplitude": "Signal_1"} or "run.H" says which, and "H(:,2)" a column of a matrix.
    Of a universal file (UFF, UNV; data sets 58 and 58b) that holds several functions, columns={"amplitude": "12:+Z / 1:+X"} says
    which response against which reference is meant, or its number in the file. A spectrum of the force at the reference gives
    the force levels unless `force` does; columns={"force": ...} names another. units: of "frequency", "amplitude" or "force".
    about: other arguments of `MeasuredResponse`, such as quantity, force, held, settings, error. Its name is that of the file.
    """
    (test,) = _read(Path(path), None, Stated(columns or {}, units or {}, phase_of, about))
    return test


def read_measured_responses(
    path: str | Path,
    by: str | int,
    *,
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
    phase_of: PhaseOf | None = None,
    **about: Any,
) -> list[MeasuredResponse]:
    """The tests of a file of several curves, which the values of a column distinguish.

    by: title or number (from 1) of that column, such as "curve"; the curves come in the order of their first rows. "function" for
    universal files: each function of one response and reference is a test. Other arguments as for `read_measured_response`. The
    name of each is that of the file, the column and its value.
    """
    return _read(Path(path), by, Stated(columns or {}, units or {}, phase_of, about))


def _read(file: Path, by: str | int | None, said: Stated) -> list[MeasuredResponse]:
    """The test of a file, or those that a column distinguishes."""
    existing("A measured response", [file])
    columns, units, phase_of, about = said
    for what, given in (("columns", columns), ("units", units)):
        for key in given:
            if key not in TITLES:
                raise fault(what, f"must name {', '.join(TITLES)}", key, nearest(key, TITLES))
    if phase_of is not None:
        among("phase_of", phase_of, ("displacement", "quantity"))
    asked = about.pop("quantity", None)
    if asked is not None:
        among("quantity", asked, MOTIONS)
    about = {"name": file.stem, **about}
    if is_universal(file):
        return _of_universal_file(file, by, asked, said._replace(about=about))
    named: dict[str, str | int] = dict(columns)
    if file.suffix.lower() == ".mat":
        table, named = response_columns(file.name, matlab_arrays([file])[0], named)
    else:
        table = text_table(file, _is_known)
    found = _chosen(table, named, asked, "force" in about)
    number = None if by is None else named_column(table, "the curves", by)
    if number is not None and number in {column.index for column in found.values()}:
        raise fault("by", "must be a column that holds nothing else", by)
    notes = [*table.notes, *_not_used(table, found, number)]
    stated = {"real" if key == "amplitude" and "real" in found else key: unit for key, unit in units.items()}
    for key, other in (("real", "imaginary"), ("imaginary", "real")):
        if key in stated:
            stated.setdefault(other, stated[key])
    for key, text in stated.items():
        if key not in found:
            raise fault("units", f"must be of columns of {table.name}: {', '.join(found)}", key)
        notes += contradicted(table.name, key, found[key].unit, text)
        of_file = response_unit(found[key].unit or "")
        found[key] = replace(found[key], unit=text, per_force=found[key].per_force or (of_file is not None and of_file.per_force))
    about = {"notes": notes, **about}
    if number is None:
        return [_response(table, found, asked, phase_of, about)]
    return [
        _response(part, found, asked, phase_of, {**about, "name": f"{about['name']} {words}", "notes": [*notes]})
        for words, part in _parts(table, number)
    ]


def _of_universal_file(file: Path, by: str | int | None, asked: str | None, said: Stated) -> list[MeasuredResponse]:
    """The test of a universal file, or one of each function of the same response; asked: its quantity."""
    columns, units, phase_of, about = said
    if by not in (None, BY_FUNCTION):
        raise fault("by", f"must be {BY_FUNCTION!r} for a universal file, each function being a test", by)
    for what, given, known in (("columns", columns, ("amplitude", "force")), ("units", units, FUNCTION_UNITS)):
        if other := next((key for key in given if key not in known), None):
            raise fault(what, f"must name {' or '.join(known)} for a universal file", other, "Its columns are its functions.")
    wanted = Wanted(file, columns.get("amplitude"), columns.get("force"), asked, units, about.get("force") is not None)
    tests = []
    for name, table in universal_tables(wanted, by is not None):
        found = _chosen(table, {}, asked, "force" in about)
        own = about["name"] if by is None else f"{about['name']} {name}"
        tests.append(_response(table, found, asked, phase_of, {**about, "name": own, "notes": [*table.notes]}))
    return tests


def _parts(table: NumberTable, number: int) -> list[tuple[str, NumberTable]]:
    """The rows of each value of a column, and what they are called."""
    values, title = table.numbers[:, number], (table.titles or ())[number] if table.titles else ""
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise fault(f"The column of the curves in {table.name}", "must be finite", f"{values[bad[0]]} in row {bad[0] + 1}")
    every = list(dict.fromkeys(values.tolist()))
    if len(every) > len(values) // FEWEST_ROWS:
        rule = f"must distinguish curves of {FEWEST_ROWS} rows or more"
        raise fault(f"The column {title or number + 1} of {table.name}", rule, f"{len(every)} values in {len(values)} rows")
    return [(f"{title} {value:g}".strip(), replace(table, numbers=table.numbers[values == value])) for value in every]


@dataclass(frozen=True)
class _Column:
    """A column and what its title says: what it holds, of which motion, whether per force; rank: how well it fits, 0 the best."""

    index: int
    words: tuple[str, ...]
    key: str | None
    motion: str | None
    per_force: bool
    rank: int
    unit: str | None


def _column(table: NumberTable, index: int) -> _Column:
    unit = table.units[index]
    of = unit if unit is not None and FUNCTION.fullmatch(unit) and response_unit(unit) is None else ""
    words = tuple(re.findall(r"[^\W\d_]+", table.titles[index].lower() if table.titles else ""))
    motion = next((name for name, known in QUANTITY_TITLES.items() if _place(words, known) is not None), None)
    per_force = bool({*PER_FORCE} & {*words}) or words == ("h",) or of[:1].lower() in ("h", "f", "t")
    places = {key: place for key, known in TITLES.items() if (place := _place(words, known)) is not None}
    key = next(iter(places), None)
    if key not in ("real", "imaginary", "phase") and (motion or per_force or {"frequency", "amplitude"} <= {*places}):
        key = "amplitude"
    end = response_unit(table.titles[index].rsplit("_", 1)[-1].strip()) if table.titles and unit is None else None
    if end is not None and "_" in (table.titles or ())[index] and end.kind in (key, motion):  # force_n, frequency_hz
        unit = (table.titles or ())[index].rsplit("_", 1)[-1].strip()
    rank = 10 * [*QUANTITY_TITLES, None].index(motion) if key == "amplitude" else 0
    return _Column(index, words, key, motion, per_force, rank + places.get(key or "", 0), None if of else unit)


def _is_known(title: str) -> bool:
    """Whether a title says what a column holds."""
    words = tuple(re.findall(r"[^\W\d_]+", title.lower()))
    return any(_place(words, known) is not None for known in (*TITLES.values(), *QUANTITY_TITLES.values()))


def _place(words: Sequence[str], known: Sequence[str]) -> int | None:
    """Which of the known words a title has, the first that there is; a letter counts only where it is the whole title."""

    def is_word(word: str, known: str) -> bool:
        return (
            words == (word,)
            if word == known and len(known) == 1
            else word == known or (len(known) > 2 and word.startswith(known))
        )

    return next((k for k, one in enumerate(known) if any(is_word(word, one) for word in words)), None)


def _chosen(table: NumberTable, named: Mapping[str, str | int], asked: str | None, force_given: bool) -> dict[str, _Column]:
    """The columns by what they hold: those that are named, then the one whose title fits best."""
    every = [_column(table, index) for index in range(len(table.units))]
    found = {key: replace(every[named_column(table, key, which)], key=key) for key, which in named.items()}
    taken = {column.index for column in found.values()}
    for key in [key for key in TITLES if key not in named]:
        fitting = [c for c in every if c.key == key and c.index not in taken and asked in (None, c.motion or asked)]
        best = [c for c in fitting if c.rank == min(one.rank for one in fitting)]
        if len(best) > 1:
            remedy = f"Say which, such as columns={{'{key}': {best[0].index + 1}}} (--column {key}={best[0].index + 1})."
            raise fault(f"The titles of {table.name}", f"must name {key} once", ", ".join(table.titles or ()), remedy)
        if best:
            found[key] = best[0]
    parts = "real" in found or "imaginary" in found
    if parts:
        found = {key: column for key, column in found.items() if key not in ("amplitude", "phase") or key in named}
    needed = ["frequency", *(("real", "imaginary") if parts else ("amplitude",)), *(() if force_given else ("force",))]
    if missing := [key for key in needed if key not in found]:
        titles = "no titles" if table.titles is None else ", ".join(table.titles)
        raise fault(f"The titles of {table.name}", f"must name {', '.join(missing)}", titles, _how_to_name(missing))
    if parts and {"amplitude", "phase"} & {*found}:
        raise fault("columns", "must name real and imaginary parts, or amplitude and phase", list(named))
    return found


def _not_used(table: NumberTable, found: Mapping[str, _Column], by: int | None) -> list[str]:
    """The note on columns that are not used; a file of several curves, which one of them numbers, is refused."""
    used = {*(column.index for column in found.values()), by}
    left = [] if table.titles is None else [index for index in range(len(table.titles)) if index not in used]
    titles = [str((table.titles or ())[index]) for index in left]
    for index, title in zip(left, titles, strict=True):
        count = np.unique(table.numbers[:, index]).size
        if (
            by is None
            and 1 < count <= table.numbers.shape[0] // 2
            and _place(tuple(re.findall(r"[^\W\d_]+", title.lower())), SEVERAL) is not None
        ):
            remedy = f"Split it, by={title!r} (--by {title!r}), or leave one curve: gain and error count for each."
            raise fault(f"The number of curves in {table.name}, by its column {title!r},", "must be 1", count, remedy)
    return [f"Columns of {table.name} that are not used: {', '.join(titles)}."] if titles else []


def _how_to_name(missing: Sequence[str]) -> str:
    if missing == ["force"]:
        return (
            "Name its column, force [N], or give the level at which the response was measured: force=2.0 (--force 2.0), or "
            "--compare-force 2.0 in `predict`."
        )
    return (
        "Name the columns: frequency [Hz], acceleration [m/s2], force [N], phase [rad]; or say which they are, such as "
        f"columns={{'{missing[0]}': 1}} (--column {missing[0]}=1)."
    )


def _response(
    table: NumberTable, found: Mapping[str, _Column], asked: str | None, phase_of: PhaseOf | None, about: dict[str, Any]
) -> MeasuredResponse:
    """The response of the columns."""
    first, notes = found["real" if "real" in found else "amplitude"], about.pop("notes")
    unit, quantity = _quantity(table, first, asked)
    per_force = unit.per_force if unit else first.per_force
    if unit is None and (asked or first.motion) is None:
        notes.append(f"The quantity of {table.name} is not stated: acceleration is assumed.")
    units = _units_of_file(table, found, quantity, unit, per_force)
    frequency = units["frequency"].factor * table.numbers[:, found["frequency"].index]
    used = frequency != 0.0
    if not np.all(used):
        notes.append(f"{table.name}: {counted(int(np.sum(~used)), 'row')} at 0 Hz left out.")
    notes += _order_notes(table.name, frequency[used])
    values, level = _values(table, found, unit), _level(table, found, about.pop("force", None), units)
    size = np.abs(values) if "real" in found else values.real
    for key, column in {"frequency": frequency, quantity: size, "force": level}.items():
        shown = column / units[key].factor if key in units else column
        _check(table, key, shown, used & ~(np.isfinite(column) & (column > 0.0)), "must be finite and positive")
    phase, of = (np.angle(values), "quantity") if "real" in found else (None, phase_of)
    if "phase" in found:
        phase = _phase(table, found["phase"], used, units["phase"])
        if of is None and (per_force or found["phase"].per_force):
            of = "quantity"
            if AHEAD[quantity]:
                remedy = "If it is that of the displacement, say phase_of='displacement' (--phase-of displacement)."
                notes.append(f"The phase in {table.name} is taken for that of the {quantity} against the force. {remedy}")
    if phase is not None and of == "quantity" and AHEAD[quantity]:
        phase = np.angle(np.exp(1j * (phase - AHEAD[quantity])))
    amplitude = size * (level if per_force else 1.0)
    phase = None if phase is None else phase[used]
    about |= {"notes": tuple(notes), "units": units}
    return MeasuredResponse(frequency[used], amplitude[used], level[used], phase, quantity, **about)


def _order_notes(name: str, frequency: Array) -> list[str]:
    """What is said of frequencies that occur more than once or neither rise nor fall throughout."""
    steps, notes = np.diff(frequency), []
    again = frequency.size - np.unique(frequency).size
    if again:
        values, counts = np.unique(frequency, return_counts=True)
        example = f"{values[np.argmax(counts > 1)]:.6g} Hz"
        notes.append(
            f"{name}: {counted(again, 'frequency is', 'frequencies are')} given again, the first at {example}; all count."
        )
    if np.any(steps > 0.0) and np.any(steps < 0.0):
        turn = int(np.flatnonzero(np.sign(steps[1:]) * np.sign(steps[:-1]) < 0.0)[0]) if np.all(steps) else 0
        row = f"from row {turn + 3} on" if np.all(steps) else "throughout"
        notes.append(f"{name}: the frequencies are not in order {row}. If two curves are in one file, split it.")
    return notes


def _units_of_file(
    table: NumberTable, found: Mapping[str, _Column], quantity: str, unit: ResponseUnit | None, per_force: bool
) -> dict[str, FileUnit]:
    """Units of the columns by what they hold, the responses by their quantity."""
    first = found["real" if "real" in found else "amplitude"]
    whole = f"({SI[quantity]})/N" if per_force else SI[quantity]
    units = {}
    for key in ("frequency", quantity, "force", "phase"):
        if key == quantity:
            units[key] = FileUnit(first.unit or whole, unit.factor if unit else 1.0, unit is None)
        elif key in found:
            stated = _unit(table, found[key], key, (key,))
            angular = key == "frequency" and {*ANGULAR} & {*found[key].words}
            text = found[key].unit or ("rad/s" if angular else SI[key])
            units[key] = FileUnit(text, RESPONSE_UNITS[key][text.lower()] if stated is None else stated.factor, stated is None)
    return units


def _quantity(table: NumberTable, first: _Column, asked: str | None) -> tuple[ResponseUnit | None, str]:
    """Unit and quantity of the responses."""
    titled = asked or first.motion
    kinds = (titled,) if titled else MOTIONS
    unit = _unit(table, first, titled or "response", kinds)
    quantity = titled or (unit.kind if unit else "acceleration")
    if first.unit is not None and first.per_force:
        unit = per_force_unit(f"The unit of {quantity} in {table.name}", first.unit, kinds, str(first.key))
    if unit is None and first.key == "real" and not first.per_force:
        usual = per_newton(SI[quantity])
        remedy = (
            f"Name the columns such as Re(H) [{usual}], or give units={{'amplitude': '{usual}'}} (--unit 'amplitude={usual}')."
        )
        raise fault(f"The unit of the real part in {table.name}", "must be stated", "missing", remedy)
    return unit, quantity


def _unit(table: NumberTable, column: _Column, what: str, kinds: Sequence[str]) -> ResponseUnit | None:
    """The unit of a column, None where none is stated."""
    if column.unit is None:
        return None
    return known_unit(f"The unit of {what} in {table.name}", column.unit, kinds)


def _values(table: NumberTable, found: Mapping[str, _Column], unit: ResponseUnit | None) -> NDArray[np.complex128]:
    """The responses (n,) in SI, complex where their parts are known."""
    factor = unit.factor if unit else 1.0
    if "real" not in found:
        return np.asarray(factor * table.numbers[:, found["amplitude"].index], dtype=complex)
    other = _unit(table, found["imaginary"], "imaginary", MOTIONS)
    if unit is not None and other is not None and other != unit:
        texts = f"{found['real'].unit} and {found['imaginary'].unit}"
        raise fault(f"The units of real and imaginary parts in {table.name}", "must be equal", texts)
    real, imaginary = (table.numbers[:, found[key].index] for key in ("real", "imaginary"))
    return np.asarray(factor * (real + 1j * imaginary))


def _level(table: NumberTable, found: Mapping[str, _Column], given: Any, units: Mapping[str, FileUnit]) -> Array:
    """The force level at each row (n,) [N], of a column or as given."""
    if "force" not in found:
        return vector(f"force of {table.name}", given, len(table.numbers))
    if given is not None:
        remedy = "Leave out one of the two."
        raise fault(f"The force of {table.name}", "must be given once", "a column of the file, and given too", remedy)
    return np.asarray(table.numbers[:, found["force"].index] * units["force"].factor)


def _phase(table: NumberTable, column: _Column, used: NDArray[np.bool_], unit: FileUnit) -> Array:
    """Phases (n,) in rad, ahead of the force."""
    values = table.numbers[:, column.index]
    _check(table, "phase", values, used & ~np.isfinite(values), "must be finite")
    largest = float(np.max(np.abs(values), where=used, initial=0.0))
    if unit.assumed and largest > LARGEST_PHASE:
        remedy = "Name the column phase [deg], or give units={'phase': 'deg'} (--unit phase=deg)."
        raise fault(f"The unit of phase in {table.name}", "must be stated", f"missing, with values to {largest:g}", remedy)
    return np.asarray(values * unit.factor * (-1.0 if "lag" in column.words else 1.0))


def _check(table: NumberTable, key: str, values: Array, wrong: NDArray[np.bool_], rule: str) -> None:
    """Refuse wrong rows of a column."""
    bad = np.flatnonzero(wrong)
    if bad.size:
        found = f"{values[bad[0]]:g} in row {bad[0] + 1} of the numbers" + (
            f" and so in {bad.size - 1} more" if bad.size > 1 else ""
        )
        raise fault(f"The column of {key} in {table.name}", rule, found, "Correct these rows or cut them out.")
