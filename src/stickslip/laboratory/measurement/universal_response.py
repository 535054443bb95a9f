"""Frequency responses in universal files as tables of numbers: which function is meant, of what, in which units."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip.laboratory.measurement.number_table import (
    MOTIONS,
    NumberTable,
    contradicted,
    known_unit,
    per_force_unit,
    place_of,
    response_unit,
)
from stickslip.laboratory.measurement.universal_file import (
    DIRECTIONS,
    Axis,
    FileUnits,
    Freedom,
    UniversalFile,
    UniversalFunction,
    read_universal,
)
from stickslip.support.checks import LARGEST, Array, InputError, fault, nearest

BY_FUNCTION = "function"
"""Value of `by` that takes each function for a test."""

GENERAL, HISTORY, RESPONSE, SPECTRUM = 0, 1, 4, 12
KINDS = (
    "a function of unknown type",
    "a time history",
    "an auto spectrum",
    "a cross spectrum",
    "a frequency response function",
    "a transmissibility",
    "a coherence",
    "an auto correlation",
    "a cross correlation",
    "a power spectral density",
    "an energy spectral density",
    "a probability density",
    "a spectrum",
)
"""Types of functions, by their numbers; others follow."""

MOTION = {8: "displacement", 11: "velocity", 12: "acceleration"}
FORCE = (9, 13)
TIME, FREQUENCY = 17, 18
UNSTATED = (0, 1)
"""Specific data types."""

SI = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s2", "force": "N"}
TITLES = {"displacement": "receptance", "velocity": "mobility", "acceleration": "accelerance"}

SYSTEMS = {
    1: (1.0, 1.0),
    2: (3.28083989501312, 0.224808943099711),
    3: (1.0, 0.101971621297793),
    4: (3.28083989501312, 7.23301385120989),
    5: (1e3, 1e3),
    6: (1e2, 1e2),
    7: (39.3700787401575, 0.224808943099711),
    8: (1e3, 0.101971621297793),
}
"""Factors of length and force that go with the codes of data set 164: SI, foot, kgf, poundal, mm, cm, inch, mm with kgf."""

AGREE = 1e-3
"""Relative difference up to which factors and frequencies are the same."""

TRANSLATIONS = 3
"""Directions up to it are along an axis; rotations follow."""
HOW_TO_SAY = "(if only the file does not say it: units={'amplitude': '(m/s2)/N'}, --unit 'amplitude=(m/s2)/N')"

AGAINST = ('outputs = [{ name = "NAME", direction = { PLACE } }] in [sweep]', "direction = { PLACE } in [[force]]")
"""How a study turns an output and a force against an axis."""

LISTED = 12
"""Functions that a message lists."""


@dataclass(frozen=True)
class Wanted:
    """What a caller asks for: names or numbers of the functions of response and force, the quantity, and units.

    force_given: whether the force level is.
    """

    path: Path
    response: str | int | None
    force: str | int | None
    quantity: str | None
    units: Mapping[str, str]
    force_given: bool

    @property
    def unit(self) -> str:
        """The unit of the response that is given, or ""."""
        return self.units.get("amplitude", self.units.get("real", ""))


def universal_tables(wanted: Wanted, each: bool) -> list[tuple[str, NumberTable]]:
    """The table of the response that is meant, or with `each` of every function of that name, with the name of each.

    Columns: frequency, real and imaginary part or amplitude, and the force where a spectrum of it is in the file.
    """
    file = read_universal(wanted.path)
    fitting = _fitting(file, wanted)
    if len(fitting) > 1 and (not each or len({one.name for one in fitting}) > 1):
        columns = f"columns={{'amplitude': '{fitting[0].name}'}} (--column 'amplitude={fitting[0].name}')"
        if len({one.name for one in fitting}) > 1:
            remedy = f"Say which, by its name or number: {columns}."
        else:
            remedy = f"Say which, columns={{'amplitude': {fitting[0].number}}} (--column amplitude={fitting[0].number})"
            remedy += f", or take each for a test, by='{BY_FUNCTION}' (--by {BY_FUNCTION})."
        raise InputError(f"One response of {file.name} must be chosen. It holds {_listed(file, fitting)}. {remedy}")
    return [
        (one.name if len(fitting) == 1 else f"{one.name} ({one.number})", _table(file, one, wanted, (k, len(fitting))))
        for k, one in enumerate(fitting)
    ]


def time_history(path: Path, which: str | int | None, quantity: str | None, unit: str | None) -> NumberTable:
    """The columns time and motion of the time history that is meant, the motion in SI where its unit is stated.

    which: name or number of the function, where several are histories of motion; quantity, unit: where the file states none.
    """
    file, wanted = read_universal(path), Wanted(path, which, None, quantity, {"amplitude": unit or ""}, True)
    named = [*file.functions] if which is None else _named(file, "signal", which)
    fitting = [
        one
        for one in named
        if one.kind in (GENERAL, HISTORY)
        and (one.abscissa.kind == TIME or (one.kind == HISTORY and one.abscissa.kind in UNSTATED))
        and _motion(one, wanted) in MOTIONS
        and not np.iscomplexobj(one.y)
    ]
    if len(fitting) != 1:
        number = fitting[0].number if fitting else 1
        remedy = f"Say which: columns={{'signal': {number}}} (--column signal={number})." if fitting else ""
        if not fitting and which is None and quantity is None:
            remedy = (
                "Give the quantity where the file does not say it, such as quantity='acceleration' (--quantity acceleration)."
            )
        shown = _listed(file, fitting or named) or "no functions"
        raise fault(f"The time histories of motion in {file.name}", "must be one", shown, remedy)
    (one,), motion = fitting, str(_motion(fitting[0], wanted))
    factor, stated = _factor(file, one.ordinate, motion, unit, one.units, [])
    units = one.abscissa.unit or "s", SI[motion] if stated else None
    return NumberTable(file.name, np.column_stack([one.x, factor * one.y]), ("time", motion), units, file.notes)


def _fitting(file: UniversalFile, wanted: Wanted) -> list[UniversalFunction]:
    """The functions that are meant: those named, or all that can be read as responses, of the quantity that is asked for."""
    if not file.functions:
        raise fault(f"The functions of {file.name}", "must be data sets 58 or 58b", "none", " ".join(file.notes))
    named = [*file.functions] if wanted.response is None else _named(file, "amplitude", wanted.response)
    against = {one.number: _against(one, wanted) for one in named}
    fitting = [one for one in named if not against[one.number]]
    if any(one.kind != SPECTRUM for one in fitting):
        fitting = [one for one in fitting if one.kind != SPECTRUM]  # spectra are then those from which responses were made
    if not fitting:
        reasons = list(dict.fromkeys(against.values()))
        remedy = f"Not read: {'; '.join(reasons)}."
        raise fault(f"{file.name}", "must hold a response that can be read", _listed(file, named), remedy)
    return fitting


def _named(file: UniversalFile, what: str, which: str | int) -> list[UniversalFunction]:
    """The functions of a name, whole, without its entities or of its response alone, or that of a number from 1."""
    if (number := place_of(which)) is not None:
        if not 1 <= number <= len(file.functions):
            raise fault(f"The function of {what} in {file.name}", f"must be a number from 1 to {len(file.functions)}", which)
        return [file.functions[number - 1]]
    ends = {one: [str(Freedom("", end.node, end.direction)) for end in (one.response, one.reference)] for one in file.functions}
    for spelled in (lambda one: one.name, lambda one: " / ".join(ends[one]), lambda one: ends[one][0]):
        if found := [one for one in file.functions if _plain(spelled(one)) == _plain(str(which))]:
            return found
    remedy = nearest(str(which), dict.fromkeys(one.name for one in file.functions))
    raise fault(f"The function of {what} in {file.name}", "must be one of its functions", which, remedy)


def _plain(name: str) -> str:
    return re.sub(r"[\s+]", "", name).upper()


def _listed(file: UniversalFile, functions: Sequence[UniversalFunction]) -> str:
    """Functions by number and name, with what they are and where their response is."""
    texts = []
    for one in functions[:LISTED]:
        place = file.nodes.get(one.response.node)
        at = "" if place is None else f", node {one.response.node} at " + ", ".join(f"{x:.4g}" for x in place)
        words = f", {one.ids[0]}" if one.ids and one.ids[0] != one.name else ""
        kind = KINDS[one.kind] if one.kind < len(KINDS) else f"a function of type {one.kind}"
        texts.append(f"{one.number} = {one.name} ({kind} of {_of(one.ordinate) or 'what is not stated'}{words}{at})")
    return "; ".join(texts) + (f"; and {len(functions) - LISTED} more" if len(functions) > LISTED else "")


def _of(axis: Axis) -> str | None:
    """Quantity of an axis, by its type or else by the label of its unit."""
    if axis.kind in MOTION:
        return MOTION[axis.kind]
    if axis.kind in FORCE:
        return "force"
    unit = response_unit(axis.unit) if axis.kind in UNSTATED else None
    return unit.kind if unit else None


def _against(one: UniversalFunction, wanted: Wanted) -> str:
    """Why a function is not read as a response; empty where it is."""
    motion = _motion(one, wanted)
    if one.kind not in (GENERAL, RESPONSE, SPECTRUM):
        return "what is no frequency response function and no spectrum of motion and force"
    if one.abscissa.kind not in (*UNSTATED, FREQUENCY):
        return "what is not over the frequency"
    ends = (one.response, one.reference) if one.kind != SPECTRUM else (one.response,)
    if any(abs(end.direction) > TRANSLATIONS for end in ends):
        return "rotations and moments"
    if motion == "force":
        return "a force alone" if one.kind == SPECTRUM else "forces per motion (export motion per force)"
    if motion not in MOTIONS:
        return f"what is no displacement, velocity or acceleration {HOW_TO_SAY}"
    if wanted.quantity not in (None, motion):
        return f"what is no {wanted.quantity}, as is asked for"
    units = [response_unit(text) for text in (one.ordinate.unit, wanted.unit)]
    per_force = _of(one.denominator) == "force" or any(unit is not None and unit.per_force for unit in units)
    if one.kind != SPECTRUM and not per_force:
        silent = one.denominator.kind == 0 and not one.denominator.unit
        return f"what is not said to be per force {HOW_TO_SAY}" if silent else "motions per motion"
    return ""


def _motion(one: UniversalFunction, wanted: Wanted) -> str | None:
    """The quantity of a function: as the file says, or else as is asked for, or as the unit that is given says."""
    given = response_unit(wanted.unit)
    return _of(one.ordinate) or wanted.quantity or (given.kind if given else None)


def _table(file: UniversalFile, one: UniversalFunction, wanted: Wanted, place: tuple[int, int]) -> NumberTable:
    """Frequency, response and force of a function, in SI; place: among so many of its name."""
    motion, per_force = str(_motion(one, wanted)), one.kind != SPECTRUM
    notes = [*file.notes, *_said(file, one)]
    spectrum = _force_spectrum(file, one, wanted, place)
    for used in (one, spectrum) if spectrum is not None else (one,):
        sizes = np.maximum(np.abs(used.x), np.abs(used.y))
        if not np.all(sizes <= LARGEST):  # NaN too
            shown = float(sizes[np.argmin(sizes <= LARGEST)])
            raise fault(f"Function {used.number} of {file.name}", f"must hold finite numbers up to {LARGEST:g}", shown)
    frequency = _frequency(file, one, wanted, notes)
    factor, stated = _response_factor(file, one, motion, wanted, notes)
    response, force = factor * one.y, None
    if spectrum is not None:
        force_factor, force_stated = _factor(file, spectrum.ordinate, "force", wanted.units.get("force"), spectrum.units, notes)
        force = force_factor * spectrum.y
        at_rest = np.flatnonzero((force == 0.0) & (one.x != 0.0))
        if at_rest.size:
            raise fault(f"The force {spectrum.name} in {file.name}", "must not be zero", f"zero at {one.x[at_rest[0]]:g}")
        notes.append(
            f"The force levels of {file.name} are its function {spectrum.number}, {spectrum.name}, taken for amplitudes. "
            "If it holds RMS values, multiply them by √2."
        )
        if one.kind == SPECTRUM and np.iscomplexobj(response) and np.iscomplexobj(force):
            response = np.divide(response, force, out=np.zeros_like(response), where=force != 0.0)
            per_force, stated = True, stated and force_stated
    if one.kind == SPECTRUM and not per_force and np.iscomplexobj(response):
        notes.append(f"The phase of {one.name} in {file.name} is not used: it is not that against a force.")
        response = np.abs(response)
    if not np.iscomplexobj(response) and np.any(response < 0.0):
        remedy = "These are real parts: export complex values."
        raise fault(f"{one.name} in {file.name}", "must be complex, or hold amplitudes", "real, with negative values", remedy)
    name, unit = (TITLES[motion], f"({SI[motion]})/N") if per_force else (motion, SI[motion])
    parts: dict[str, Array] = {f"{name} real": response.real, f"{name} imag": response.imag}
    if not np.iscomplexobj(response):
        parts = {name: np.asarray(response, dtype=float)}
    columns = {
        "frequency": (frequency, "Hz" if one.abscissa.kind == FREQUENCY or one.abscissa.unit else wanted.units.get("frequency"))
    }
    columns |= {title: (values, unit if stated else None) for title, values in parts.items()}
    columns |= {} if force is None else {"force": (np.abs(force), "N" if force_stated else None)}
    numbers = np.stack([values for values, _ in columns.values()], axis=1)
    return NumberTable(file.name, numbers, tuple(columns), tuple(unit for _, unit in columns.values()), tuple(notes))


def _said(file: UniversalFile, one: UniversalFunction) -> list[str]:
    """Sentences on which function is read, and on directions against the axes."""
    about = ", ".join(text for text in one.ids if text != one.name)
    found = [f"Function {one.number} of {file.name} is read, {one.name}{': ' * bool(about)}{about}."]
    ways = [
        (str(end), form.replace("PLACE", f'"{end.node}.{DIRECTIONS[-end.direction].lower()}" = -1.0').replace("NAME", str(end)))
        for end, form in zip((one.response, one.reference), AGAINST, strict=True)
        if end.direction < 0
    ]
    if ways and np.iscomplexobj(one.y):
        along, inputs = (" and ".join(texts) for texts in zip(*ways, strict=True))
        found.append(f"Phases of {file.name} are those along {along}, where the study must point too: {inputs}.")
    return found


def _frequency(file: UniversalFile, one: UniversalFunction, wanted: Wanted, notes: list[str]) -> Array:
    stated, given = one.abscissa.unit or ("Hz" if one.abscissa.kind == FREQUENCY else ""), wanted.units.get("frequency")
    notes += contradicted(file.name, "frequency", stated or None, given) if given else []
    text = given or stated
    return one.x * known_unit(f"The unit of frequency in {file.name}", text, ("frequency",)).factor if text else one.x


def _response_factor(
    file: UniversalFile, one: UniversalFunction, motion: str, wanted: Wanted, notes: list[str]
) -> tuple[float, bool]:
    """Factor of a response to SI, and whether the file or the caller states the unit."""
    what, stated = f"The unit of {motion} in {file.name}", response_unit(one.ordinate.unit)
    if one.kind == SPECTRUM:
        return _factor(file, one.ordinate, motion, wanted.unit or None, one.units, notes)
    if wanted.unit or (stated is not None and stated.per_force):
        text = wanted.unit or one.ordinate.unit
        unit = per_force_unit(what, text, (motion,))
        both = f"({one.ordinate.unit})/{one.denominator.unit}" if one.denominator.unit else None
        notes += contradicted(file.name, "amplitude", one.ordinate.unit if stated and stated.per_force else both, text)
        return unit.factor, True
    above, stated_above = _factor(file, one.ordinate, motion, None, one.units, notes)
    below, stated_below = _factor(file, one.denominator, "force", wanted.units.get("force"), one.units, notes)
    return above / below, stated_above and stated_below


def _factor(
    file: UniversalFile, axis: Axis, quantity: str, given: str | None, units: FileUnits | None, notes: list[str]
) -> tuple[float, bool]:
    """Factor of an ordinate or a denominator to SI, and whether it is stated: by the caller, its label, or data set 164.

    By the format a label takes precedence over data set 164.
    """
    what, of_file = f"The unit of {quantity} in {file.name}", None
    if units is not None:
        of_file = 1.0 / (units.force if quantity == "force" else units.length)
    if given or axis.unit:
        text = given or axis.unit
        factor = known_unit(what, text, (quantity,)).factor
        if given:
            notes += contradicted(file.name, quantity, axis.unit or None, given)
        elif of_file is not None and not np.isclose(factor, of_file, rtol=AGREE):
            notes.append(f"{what} is taken for {text}, its label, though data set 164 says {of_file:.6g} {SI[quantity]}.")
        return factor, True
    if units is None or of_file is None:
        return 1.0, False
    usual = SYSTEMS.get(units.code)
    if usual is not None and not np.allclose((units.length, units.force), usual, rtol=AGREE):
        remedy = f"Say the unit: units={{'{'force' if quantity == 'force' else 'amplitude'}': ...}} (--unit)."
        rule = f"must go with its code {units.code}, {usual[0]:.6g} and {usual[1]:.6g} for length and force"
        raise fault(f"Data set 164 of {file.name}", rule, f"{units.length:.6g} and {units.force:.6g}", remedy)
    return of_file, True


def _force_spectrum(
    file: UniversalFile, one: UniversalFunction, wanted: Wanted, place: tuple[int, int]
) -> UniversalFunction | None:
    """The spectrum of the force of a response, or None where a force level is given.

    place: of the response among so many of its name; as many spectra belong to them in turn.
    """
    forces = [other for other in file.functions if other.kind == SPECTRUM and _of(other.ordinate) == "force"]
    if wanted.force is not None:
        named = _named(file, "force", wanted.force)
        if len(named) > 1 or named[0] not in forces:
            raise fault(f"The function of force in {file.name}", "must be one spectrum of a force", _listed(file, named))
        if not _same(named[0].x, one.x):
            raise fault(f"The function of force in {file.name}", "must have the frequencies of the response", named[0].name)
        return named[0]
    if wanted.force_given:
        return None
    fitting = [other for other in forces if _same(other.x, one.x)]
    if str(one.reference):
        fitting = [other for other in fitting if other.response == one.reference] or (fitting if one.kind == SPECTRUM else [])
    if not fitting:
        rule = "must be known, since friction depends on it"
        remedy = (
            "Give the level at which the response was measured, force=2.0 (--force 2.0, in `predict` --compare-force 2.0), or a "
            "spectrum of the force in the file."
        )
        raise fault(f"The force of {file.name}", rule, "missing", remedy)
    turn, count = place
    if len(fitting) == count:
        return fitting[turn]
    if len(fitting) > 1:
        remedy = f"Say which, columns={{'force': {fitting[0].number}}} (--column force={fitting[0].number})."
        raise InputError(f"One spectrum of the force in {file.name} must be chosen. It holds {_listed(file, fitting)}. {remedy}")
    return fitting[0]


def _same(one: Array, other: Array) -> bool:
    """Whether two functions have the same abscissas."""
    return one.size == other.size and bool(np.allclose(one, other, rtol=AGREE, atol=0.0))
