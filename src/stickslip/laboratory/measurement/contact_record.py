"""Records of one contact: displacement, friction force and, if measured, time and normal load, in SI, from text or MATLAB files.

Columns are known by the words in their titles, units by what follows the title. What the file does not state is assumed only
where the numbers leave no choice, and each assumption is a note of the record.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stickslip.laboratory.measurement.number_table import UNITS, NumberTable, matlab_tables, named_column, text_table, to_si
from stickslip.laboratory.measurement.records import LONGEST_CLIP, longest_run
from stickslip.support.checks import LARGEST, Array, counted, existing, fault, nearest, positive

QUANTITIES = {"time": "s", "displacement": "m", "force": "N", "normal": "N"}
"""Columns of a record, and the SI unit of each. `force` is the friction force, `normal` the normal load."""

TITLES = {
    "time": {"time", "t", "zeit"},
    "displacement": {"displacement", "disp", "position", "pos", "motion", "slip", "stroke", "x", "u", "d", "weg"},
    "normal": {"normal", "preload", "load", "n", "fn", "p"},
    "force": {"friction", "force", "tangential", "traction", "shear", "f", "ft", "q"},
}
"""Words by which the title of a column is recognised; the first row that holds one of its words."""

OTHER_QUANTITY = {"coefficient", "cof", "velocity", "speed", "temperature", "number", "energy", "resistance"}
"""A title with one of these is another quantity, whatever else it says."""

FEWEST_SAMPLES = 16
SMALLEST_MOTION, LARGEST_MOTION = 1e-8, 1e-2
"""Peak-to-peak displacement [m] outside which its unit is taken for wrong."""

USUAL_MOTION = (5e-7, 5e-4)
"""Peak-to-peak displacement [m] in tests of fretting contacts. It spans a factor of 1000, the step from m to mm to µm, so that
just one of the three units brings a motion of unknown unit into it."""

LARGEST_RATIO, SMALLEST_RATIO = 2.0, 3e-3
"""Half the range of the friction force over the normal load, outside which a unit is taken for wrong. A force in kN read as N
gives less than 0.0015 for any friction coefficient up to 1.5."""

LOADS_AGREE = 0.02
"""Relative difference of a normal load that is given from a measured one, from which a note says so."""

SMOOTH = 3.0
"""Median third difference of a signal, relative to that of a sine of its amplitude, up to which it is free of noise: the
flat top of a computed loop is then no sign of a clipped sensor."""


RESOLVED = 1.5
"""Median third difference of a signal in steps of its converter up to which its noise is below its resolution: rounding alone
leaves 0.9. Its extreme level then repeats without clipping."""


@dataclass(frozen=True, eq=False)
class ContactRecord:
    """Record of one contact: displacement (n,) [m], friction force (n,) [N], normal load [N], a number or (n,), and time (n,)
    [s]; without time the samples are equally spaced. name: for messages. notes: what was assumed or noticed in reading, one
    sentence each. number: that of its first cycle in the test; unless given, its cycles go on after those of the record before.
    file_number: that in the name of its file, the number of the cycle where every record holds one alone.
    units: of the columns of its file, in which messages show numbers.

    Refused: values that are not finite, signals that are constant, a clipped force, time that does not increase, and
    displacement or force of an impossible size, which wrong units give.
    """

    displacement: Array
    force: Array
    normal: Array | float
    time: Array | None = None
    name: str = "record"
    number: int | None = None
    notes: tuple[str, ...] = ()
    file_number: int | None = None
    units: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        size = np.size(self.displacement)
        if size < FEWEST_SAMPLES:
            raise fault(self.name, f"must have at least {FEWEST_SAMPLES} samples", size)
        columns = {"displacement": self.displacement, "force": self.force, "normal load": self.normal, "time": self.time}
        found: dict[str, Array] = {}
        for key, values in columns.items():
            if values is not None:
                shown = self._in_file(key)
                found[key] = _checked(f"{key.capitalize()} of {self.name}", values, size, key == "normal load", shown)
        span, load = float(np.ptp(found["displacement"])), float(np.max(found["normal load"]))
        if not SMALLEST_MOTION < span < LARGEST_MOTION:
            remedy = "Is its unit right? State it, such as units={'displacement': 'um'} (--unit displacement=um)."
            factor, unit = self._in_file("displacement")
            text = f"{span / factor:.4g}{unit}"
            raise fault(f"Displacement of {self.name}", "must vary by 10 nm to 10 mm", text, remedy)
        if load <= 0.0:
            raise fault(f"Normal load of {self.name}", "must be positive", load)
        check_ratio(self.name, found["force"], load)
        if "time" in found and np.any(np.diff(found["time"]) <= 0.0):
            row = int(np.flatnonzero(np.diff(found["time"]) <= 0.0)[0]) + 2
            raise fault(f"Time of {self.name}", "must increase", f"not so in row {row}", "Was the record cut together?")
        notes = self.notes
        for key in ("force", "displacement"):
            notes += clipped(f"{key.capitalize()} of {self.name}", found[key], self._in_file(key))
        normal = found["normal load"]
        object.__setattr__(self, "displacement", found["displacement"])
        object.__setattr__(self, "force", found["force"])
        object.__setattr__(self, "normal", float(normal) if normal.ndim == 0 else normal)
        object.__setattr__(self, "time", found.get("time"))
        object.__setattr__(self, "notes", notes)

    def _in_file(self, key: str) -> tuple[float, str]:
        """Factor to SI and unit in which a message shows a column."""
        unit = self.units.get(key.removesuffix(" load"), "")
        return (UNITS[unit][1], f" {unit}") if unit in UNITS else (1.0, f" {QUANTITIES[key.removesuffix(' load')]}")


def check_ratio(name: str, force: Array, normal: float) -> None:
    """Refuse a friction force that no contact has under its normal load."""
    ratio = 0.5 * float(np.ptp(force)) / normal
    if not SMALLEST_RATIO <= ratio <= LARGEST_RATIO:
        rule = f"must be between {SMALLEST_RATIO:g} and {LARGEST_RATIO:g}"
        raise fault(
            f"Half the range of the force over the normal load of {name}", rule, float(f"{ratio:.3g}"), _unit_remedy(ratio)
        )


def _unit_remedy(ratio: float) -> str:
    """What the ratio would be with another unit of one of the two."""
    for factor, words in ((1e3, "the force in kN"), (1e-3, "the force in mN or the load in kN"), (1e-6, "the force in uN")):
        if 0.02 <= ratio * factor <= 1.5:
            return f"Is a unit wrong? With {words} it would be {ratio * factor:.3g}: units={{'force': ...}} (--unit force=...)."
    return "Is a unit wrong?"


def _checked(what: str, values: Array | float, size: int, single: bool, shown: tuple[float, str]) -> Array:
    """A column as an array, refused unless it is of the right size, finite and, unless a single number is meant, not constant."""
    array = np.asarray(values, dtype=float)
    if single and array.ndim == 0:
        return np.asarray(positive(what, float(array)))
    if array.shape != (size,):
        raise fault(what, f"must have {size} samples, as the displacement has", array.shape)
    bad = np.flatnonzero(~(np.abs(array) < LARGEST))
    if bad.size:
        remedy = "Cut these rows out."
        raise fault(what, "must be finite", f"not so in {counted(bad.size, 'row')}, first in row {bad[0] + 1}", remedy)
    if not single and np.ptp(array) == 0.0:
        raise fault(
            what,
            "must vary",
            f"constant at {array[0] / shown[0]:g}{shown[1]}",
            "Is the channel connected, and the column the right one?",
        )
    return array


def clipped(what: str, values: Array, shown: tuple[float, str] = (1.0, "")) -> tuple[str, ...]:
    """Refuse a signal that stays at its highest or lowest value to the last digit while it is noisy elsewhere; a note where it
    is free of noise, as a computed loop is. shown: factor to SI and unit in which the values are shown."""
    longest, extreme = max((longest_run(values == extreme), extreme) for extreme in (values.max(), values.min()))
    if longest < LONGEST_CLIP:
        return ()
    inside = (values != values.max()) & (values != values.min())
    equal = np.diff(values)[inside[1:] & inside[:-1]] == 0.0
    if longest <= 2 * (longest_run(equal) + 1):
        return ()  # about as many equal samples in a row elsewhere: a coarse converter, or a pause
    third = np.abs(np.diff(values, 3))[inside[3:] & inside[2:-1] & inside[1:-2] & inside[:-3]]
    turns = max(int(np.count_nonzero(np.diff(np.sign(values - values.mean())))), 1)
    sine = 0.5 * float(np.ptp(values)) * (np.pi * turns / values.size) ** 3
    factor, unit = shown
    sentence = f"{longest} samples in a row at {extreme / factor:.6g}{unit}"
    step = float(np.min(np.diff(np.unique(values))))
    if third.size and np.median(third) <= RESOLVED * step:
        words = f"Its noise is below its resolution, {step / factor:.3g}{unit}: a plateau looks so, and a clipped sensor."
        return (f"{what}: {sentence}. {words}",)
    if third.size and np.median(third) > SMOOTH * sine:
        raise fault(what, "must not be clipped", sentence, "Choose a larger range of the sensor and measure again.")
    return (f"{what}: {sentence}. A clipped sensor looks so, and a computed loop; a clipped one gives too low a friction.",)


def read_contact_records(
    files: str | Path | Sequence[str | Path],
    normal_load: float | None = None,
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
) -> tuple[ContactRecord, ...]:
    """Records of one contact from text or MATLAB files (.mat, version 5 to 7.3), one record a file.

    files: one or several; a record may hold many cycles or one. A text file has columns separated by comma, semicolon, tab or
    blanks, with a line of titles or none; without titles two columns are displacement and force, three with an increasing first
    one time, displacement and force. A MATLAB file holds the matrix `hyst`, n × 2 (displacement, force), or one matrix of
    such columns, or vectors with the names of columns.
    normal_load: N; needed unless the files have it as a column, which it replaces. columns: {"displacement", "force", "normal"
    or "time": title or number (from 1) of the column} where the titles are not understood. units: {the same names: "um", "kN",
    ...} where the file does not state them, or states wrong ones.

    Without any unit the force is taken for N, and the displacement for that one of m, mm and µm which makes it between 0.5 µm
    and 0.5 mm peak to peak; a note says so. Several files come in the order of the last numbers in their names. Where each holds
    one cycle, that is its cycle number; else the cycles of each go on after those of the file before.
    Raises `InputError` for files that are missing, unreadable or without the columns, and what `ContactRecord` refuses.
    """
    paths = [Path(files)] if isinstance(files, str | Path) else [Path(file) for file in files]
    if not paths:
        raise fault("files", "must be at least one", 0)
    existing("A record", paths)
    if normal_load is not None:
        normal_load = positive("normal_load", normal_load)
    for what, given in (("columns", columns), ("units", units)):
        for key in given or {}:
            if key not in QUANTITIES:
                raise fault(what, f"must name {', '.join(QUANTITIES)}", key, nearest(key, QUANTITIES))
    # All MATLAB files are read in one process.
    matlab = [path for path in paths if path.suffix.lower() == ".mat"]
    read = dict(zip(matlab, matlab_tables(matlab), strict=True)) if matlab else {}
    tables = [read[path] if path in read else text_table(path, lambda title: _meant(title) is not None) for path in paths]
    numbers = _file_numbers(paths)
    places = [_places(table, columns or {}) for table in tables]
    assumed = _assumed_units(tables, places, units or {})
    order = sorted(range(len(paths)), key=lambda i: numbers[i] or i)
    return tuple(_record(tables[i], places[i], normal_load, (units or {}, assumed), numbers[i]) for i in order)


def _file_numbers(paths: Sequence[Path]) -> Sequence[int | None]:
    """The last number in the name of each of several files, where they all have one and no two the same."""
    found = [re.findall(r"\d+", path.stem) for path in paths]
    numbers = [int(one[-1]) for one in found if one]
    if len(paths) > 1 and len(numbers) == len(paths) and len(set(numbers)) == len(paths):
        return numbers
    return [None] * len(paths)


def _record(
    table: NumberTable,
    places: Mapping[str, int],
    normal_load: float | None,
    units: tuple[Mapping[str, str], Mapping[str, str]],
    number: int | None,
) -> ContactRecord:
    """The record of a table; units: those that are given, and those that are assumed where the file states none."""
    notes, (given, assumed) = list(table.notes), units
    if "normal" not in places and normal_load is None:
        remedy = "Give normal_load in N (--normal-load), or name the column: columns={'normal': ...} (--column normal=...)."
        raise fault(f"The normal load of {table.name}", "must be known", "missing", remedy)
    values: dict[str, Array] = {}
    shown: dict[str, str] = {}
    for name, index in places.items():
        stated = table.units[index]
        unit = given.get(name) or stated
        if stated is not None and UNITS.get(stated) != UNITS.get(str(unit)):
            notes.append(f"The unit of {name} in {table.name} is taken for {unit}, as given, though the file says {stated}.")
        if unit is None:
            unit = assumed[name]
            notes.append(f"The unit of {name} is not stated: {unit} is assumed.")
            in_um = name == "displacement" and unit == "um"
            if in_um and (span := float(np.ptp(table.numbers[:, index]))) < LARGEST_MOTION * 1e3:
                notes.append(
                    f"If its {span:.4g} um peak to peak are mm, as on a tribometer, kt is a thousandth of what is found: "
                    "state it, units={'displacement': 'mm'} (--unit displacement=mm)."
                )
        shown[name] = unit
        values[name] = table.numbers[:, index] * to_si(f"The unit of {name} in {table.name}", unit, QUANTITIES[name])
    normal: Array | float = values.get("normal", np.zeros(0))
    if normal_load is not None:
        middle = float(np.median(np.abs(values.get("normal", normal_load))))
        if not abs(middle - normal_load) <= LOADS_AGREE * normal_load:
            apart = f"{normal_load:g} N is given, but the column of {table.name} has {middle:.4g} N in the median."
            notes.append(f"Check the normal load: {apart}")
        normal = normal_load
    elif np.all(values["normal"] <= 0.0) and np.any(values["normal"] < 0.0):
        normal = -values["normal"]
        notes.append("The sign of the normal load is turned: pressing is positive.")
    signals = (values["displacement"], values["force"], normal, values.get("time"))
    return ContactRecord(*signals, table.name, notes=tuple(notes), file_number=number, units=shown)


def _places(table: NumberTable, columns: Mapping[str, str | int]) -> dict[str, int]:
    """Index of each column by its quantity."""
    count = table.numbers.shape[1]
    found = {name: named_column(table, name, which) for name, which in columns.items()}
    if table.titles is not None:
        for index, title in enumerate(table.titles):
            name = _meant(title)
            if name is None or name in columns or index in found.values():
                continue
            if name in found:
                remedy = f"Say which, such as columns={{'{name}': {index + 1}}} (--column {name}={index + 1})."
                raise fault(f"Columns of {table.name}", f"must hold {name} once", list(table.titles), remedy)
            found[name] = index
    elif not columns:
        increasing = bool(np.all(table.numbers[1:, 0] > table.numbers[:-1, 0]))
        if count == 2:
            found = {"displacement": 0, "force": 1}
        elif count == 3 and increasing:
            found = {"time": 0, "displacement": 1, "force": 2}
        else:
            rule = "must have titles, or be displacement and force, or time, displacement and force"
            remedy = "Say which are which, such as columns={'displacement': 3, 'force': 4} (--column displacement=3)."
            raise fault(f"The columns of {table.name}", rule, f"{count} without titles", remedy)
    missing = [name for name in ("displacement", "force") if name not in found]
    if missing:
        shown = list(table.titles) if table.titles is not None else f"{count} without titles"
        which = shown[0] if table.titles is not None else 1
        remedy = f"Name it, such as columns={{'{missing[0]}': {which!r}}} (--column {missing[0]}={which})."
        raise fault(f"Columns of {table.name}", f"must hold {' and '.join(missing)}", shown, remedy)
    if len(set(found.values())) < len(found):
        raise fault(f"Columns of {table.name}", "must differ", {name: index + 1 for name, index in found.items()})
    return found


def _meant(title: str) -> str | None:
    """The quantity that a title names, or None."""
    words = set(re.split(r"[^a-z0-9]+", title.lower()))
    if words & OTHER_QUANTITY:
        return None
    return next((name for name, own in TITLES.items() if words & own), None)


def _assumed_units(
    tables: Sequence[NumberTable], places: Sequence[Mapping[str, int]], known: Mapping[str, str]
) -> dict[str, str]:
    """Units of quantities for which a file states none: one for all files, by the largest motion among them."""
    lacking = {
        name
        for table, own in zip(tables, places, strict=True)
        for name, index in own.items()
        if name not in known and table.units[index] is None
    }
    found = {name: QUANTITIES[name] for name in QUANTITIES if name in lacking}
    if "displacement" in lacking:
        columns = (table.numbers[:, own["displacement"]] for table, own in zip(tables, places, strict=True))
        spans = [float(np.ptp(sound)) for column in columns if (sound := column[np.abs(column) < LARGEST]).size]
        span = max(spans, default=0.0)
        found["displacement"] = _unit_of_motion(tables[0].name, span)
    return found


def _unit_of_motion(file: str, span: float) -> str:
    """That one of m, mm and um in which a range of displacement is usual."""
    low, high = USUAL_MOTION
    for unit in ("m", "mm", "um"):
        if low <= span * UNITS[unit][1] < high:
            return unit
    rule = "must be stated where the motion is not between 0.5 um and 0.5 mm in any of m, mm and um"
    shown = f"missing, with a range of {span:.4g}"
    raise fault(f"The unit of displacement in {file}", rule, shown, "Give units={'displacement': 'um'} (--unit displacement=um).")
