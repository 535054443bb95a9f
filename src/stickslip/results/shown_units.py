"""The units that results are shown in: those that the study states, or SI with a prefix by size where it states none.

Datasets are in SI, whatever the study states. Its lengths and forces stand in the attribute `unit_system` of the results, and
console, report, figures and exported files convert by `in_system` when they show a number. Times and frequencies stay
in s and Hz.
"""

from __future__ import annotations

import re
from math import log10

import numpy as np

from stickslip.support.late import pd, xr
from stickslip.support.units import FORCES, LENGTHS, MASSES, UnitSystem

ATTRIBUTE = "unit_system"
"""Of a dataset: the units of length, force, mass and time of its study; absent for SI."""
PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}
PREFIXED = {"Pa": (1, -2), "J": (1, 1)}
"""Units that are shown with a prefix, and their powers of force and length."""
OWN = {
    **{name: ("length", size) for name, size in {**LENGTHS, "µm": 1e-6, "nm": 1e-9}.items()},
    **{name: ("force", size) for name, size in FORCES.items()},
    **{name: ("mass", size) for name, size in MASSES.items()},
    **{f"{prefix}{name}": (name, 10.0**power) for name in PREFIXED for power, prefix in PREFIXES.items()},
}
"""What each unit that results use is of, and its size in SI."""
FACTOR = re.compile(r"([A-Za-zµ]+)(\^?-?[\d.]+|²|³)?")
"""A unit with its power inside of a compound one, as in m/(s2 N)."""
HEAD = re.compile(r"(.* \[)([^\]]+)(\])|(.* in )(\S+)()")
"""The head of a column with its unit, "amplitude [m]" or "kt in N/µm"."""
UNITS = r"m kg\^0\.5|N/m|m/\(s[2²]? N\)|m/s[2²]?|m/N|[µn]?m|N(?! m\b)"
SIZE = re.compile(rf"(?<![\w.])(?:(\d[\d.]*(?:e[+-]?\d+)?) to )?(\d[\d.]*(?:e[+-]?\d+)?) ({UNITS})(?![\w/^²])")
"""A length, a motion, also per force, a modal amplitude, a force or a stiffness in a sentence, or a range of them whose unit
stands after its upper end."""


def attributes_of(system: UnitSystem) -> dict[str, str]:
    """What a result keeps of the units of its study; nothing for SI."""
    names = (system.length, system.force, system.mass, system.time)
    return {} if system == UnitSystem() else {ATTRIBUTE: " ".join(names)}


def system_of(*datasets: xr.Dataset) -> UnitSystem | None:
    """The units of the study that computed results; None for SI, and for results of different units."""
    names = {str(dataset.attrs.get(ATTRIBUTE, "")) for dataset in datasets}
    only = names.pop() if len(names) == 1 else ""
    return UnitSystem(*only.split()) if only else None


def in_system(unit: str, system: UnitSystem | None) -> tuple[float, str]:
    """The factor from a unit to that of a system for the same quantity, and its name; without a system 1 and the unit.

    >>> in_system("m/(s2 N)", UnitSystem("mm", "kN", "kg", "ms"))
    (1000000.0, 'mm/(s2 kN)')
    """
    if system is None:
        return 1.0, unit
    above, slash, below = unit.partition("/")
    total, names = 1.0, []
    for part, sign in ((above, 1), (below, -1)):
        name = part
        for match in reversed(list(FACTOR.finditer(part))):
            factor, own = _single(match[1], system)
            total *= factor ** (sign * _power(match[2]))
            name = name[: match.start(1)] + own + name[match.end(1) :]
        names.append(name)
    return total, slash.join(names) if slash else names[0]


def _single(unit: str, system: UnitSystem) -> tuple[float, str]:
    """The same of a unit by itself; seconds, hertz and words stay."""
    if unit not in OWN:
        return 1.0, unit
    quantity, size = OWN[unit]
    if quantity in PREFIXED:
        force, length = PREFIXED[quantity]
        own = system.newtons**force * system.metres**length
        return size / own, f"{PREFIXES[round(log10(own))]}{quantity}"
    own = {"length": system.metres, "force": system.newtons, "mass": system.kilograms}[quantity]
    return size / own, {"length": system.length.replace("um", "µm"), "force": system.force, "mass": system.mass}[quantity]


def _power(text: str | None) -> float:
    return 1.0 if not text else {"²": 2.0, "³": 3.0}.get(text) or float(text.removeprefix("^"))


def shown_table(table: pd.DataFrame, dataset: xr.Dataset) -> pd.DataFrame:
    """A table whose heads name SI units, "amplitude [m]", in the units of the study."""
    system = system_of(dataset)
    columns = {}
    for head, column in table.items():
        match = HEAD.fullmatch(str(head))
        words, unit, end = (part for part in match.groups() if part is not None) if match else (str(head), "", "")
        factor, own = in_system(unit, system)
        columns[head] = (f"{words}{own}{end}", column * factor) if factor != 1.0 else (head, column)
    return table.assign(**{str(head): column for head, (_, column) in columns.items()}).rename(
        columns={head: name for head, (name, _) in columns.items()}
    )


def shown_sentence(sentence: str, *datasets: xr.Dataset) -> str:
    """A sentence that a result keeps, with its sizes in the units of the study; those that are in them already stay."""
    return sentence_in(sentence, system_of(*datasets))


def sentence_in(sentence: str, system: UnitSystem | None) -> str:
    """A sentence in SI with its sizes in a system of units."""

    def converted(size: re.Match[str]) -> str:
        factor, unit = in_system(size[3], system)
        if system is None and unit in ("m", "m/N") and 0.0 < float(size[2]) < 1e-4:  # "g" writes an exponent
            factor, unit = 1e6, f"µ{unit}"
        ends = [f"{factor * float(end):.4g}" for end in size.group(1, 2) if end]
        return size[0] if factor == 1.0 else f"{' to '.join(ends)} {unit.replace('s2', 's²')}"

    return SIZE.sub(converted, sentence)


def shown_dataset(dataset: xr.Dataset) -> xr.Dataset:
    """A dataset with every variable in the units of its study, for files of other programs."""
    system, found = system_of(dataset), dataset.copy()
    for name, variable in dataset.variables.items():
        if str(name).endswith(("_message", "_warning")):
            sentences = [shown_sentence(str(each), dataset) for each in variable.values.flat]
            found[name] = (variable.dims, np.reshape(np.array(sentences), variable.shape), variable.attrs)
            continue
        factor, unit = in_system(str(variable.attrs.get("units", "1")), system)
        if factor != 1.0 and np.issubdtype(variable.dtype, np.floating):
            found[name] = (variable.dims, variable.values * factor, {**variable.attrs, "units": unit})
    return found
