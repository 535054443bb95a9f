"""Units of measured responses: frequency, force, phase, and motions, by themselves or per force."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.support.checks import fault, nearest

DEGREE = np.pi / 180.0
INCH, FOOT, POUND, GRAVITY = 0.0254, 0.3048, 4.4482216152605, 9.80665
"""In m, N and m/s², exactly, by the international yard and pound of 1959 and the standard gravity of 1901."""

LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "cm": 1e-2}
LENGTHS |= {"in": INCH, "inch": INCH, "ft": FOOT, "mil": 1e-3 * INCH}
FORCES = {"n": 1.0, "kn": 1e3, "mN": 1e-3, "MN": 1e6, "dan": 10.0, "lbf": POUND, "kgf": GRAVITY}
UNITS: dict[str, dict[str, float]] = {
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
        known = [name for kind in kinds for name in UNITS[kind]]
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
        for kind, known in UNITS.items():
            if spelling in known:
                return kind, known[spelling]
    return None
