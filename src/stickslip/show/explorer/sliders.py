"""What of a study can vary: numbers of its document with the range of a slider each."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stickslip.model import rigs
from stickslip.results.shown_units import in_system
from stickslip.support.units import UnitSystem

FACTOR = 4.0
"""A slider reaches from the value of the study divided by this to the value times this, on a logarithmic scale."""
LEVELS = 100.0
"""The same of force levels, unless the study's reach further."""
ANGLES = (5.0, 85.0)
"""Ends of a slider for an angle in degrees."""
MOST = 24
"""Sliders of one page."""
UNITS = {
    "pull": "N",
    "limit": "N",
    "angle": "°",
    "stagger": "°",
    "mass": "kg",
    "length": "m",
    "offset": "m",
    "kt": "N/m",
    "kn": "N/m",
}
UNITS |= {"stiffness": "N/m", "ktx": "N/m", "kty": "N/m"}
"""Of arguments of rigs, by the last word of their names; others are numbers, or have none here."""
OWN_UNITS = {"kt": "N/m", "kn": "N/m", "normal_load": "N", "preload": "N", "static": "N", "pull": "N"}
"""Of numbers of a study's own tables, in SI, by their key."""

Path = tuple[str | int, ...]
"""Keys and places in a list that lead to a value of the document."""


@dataclass(frozen=True)
class Slider:
    """A number that can vary: its name in the address and on the page, value in the study, ends, scale, and the places of the
    document that hold it."""

    name: str
    value: float
    low: float
    high: float
    logarithmic: bool
    paths: tuple[Path, ...]
    unit: str = ""


def sliders_of(document: Mapping[str, Any], units: UnitSystem | None = None) -> tuple[Slider, ...]:
    """The sliders of a study with [sweep]: force level first, then the parameters of its rig, or damping, contacts and forces.
    units: those of the study's numbers, SI unless given.
    """
    levels = [float(level) for level in document.get("sweep", {}).get("force_levels") or [1.0]]
    middle = levels[len(levels) // 2]
    low, high = min(middle / LEVELS**0.5, *levels), max(middle * LEVELS**0.5, *levels)
    sliders = [Slider("force_level", middle, low, high, True, (("sweep", "force_levels"),)), *_rig(document)]
    damping = document.get("damping")
    if isinstance(damping, Mapping) and isinstance(damping.get("modal"), float):
        sliders.append(_slider("damping", damping["modal"], (("damping", "modal"),)))
    sliders += [*_contacts(document), *_forces(document)]
    return tuple(replace(slider, unit=_unit_of(slider, units)) for slider in sliders[:MOST])


def _unit_of(slider: Slider, units: UnitSystem | None) -> str:
    """The unit of a slider's number: of rigs, which are in SI, and of the study's own tables."""
    first = slider.paths[0]
    if first[0] == "structure":
        return UNITS.get(slider.name.rpartition("_")[2], "")
    key = next((str(part) for part in reversed(first) if isinstance(part, str)), "")
    return in_system(OWN_UNITS.get(key, ""), units)[1]


def varied(document: Mapping[str, Any], sliders: Sequence[Slider], values: Mapping[str, float]) -> dict[str, Any]:
    """The document with the values of sliders by name; force levels become the one of its slider."""
    changed: dict[str, Any] = deepcopy(dict(document))
    for slider in sliders:
        value = float(values.get(slider.name, slider.value))
        if slider.name == "force_level":
            changed.setdefault("sweep", {})["force_levels"] = [value]
        elif value != slider.value:
            for path in slider.paths:
                _put(changed, path, value)
    return changed


def _put(document: dict[str, Any], path: Path, value: float) -> None:
    """Set a value of the document, making the tables on the way to it."""
    place: Any = document
    for key in path[:-1]:
        place = place.setdefault(key, {}) if isinstance(place, dict) else place[key]
    place[path[-1]] = value


def _rig(document: Mapping[str, Any]) -> Iterator[Slider]:
    """Arguments of a ready rig that are numbers, given or by default; not the force, as the force level does the same."""
    structure = document.get("structure")
    maker = rigs.RIGS.get(str(structure.get("rig"))) if isinstance(structure, Mapping) else None
    if not isinstance(structure, Mapping) or maker is None:
        return
    given = structure.get("parameters", {})
    for name, argument in inspect.signature(maker).parameters.items():
        value = given.get(name, argument.default)
        varies = isinstance(argument.default, float) or (name in given and isinstance(value, float))
        if varies and isinstance(value, int | float) and not isinstance(value, bool) and name != "force":
            yield _slider(name, float(value), (("structure", "parameters", name),))


def _contacts(document: Mapping[str, Any]) -> Iterator[Slider]:
    """kt, kn, mu, ... of all contacts together where they are alike, else of each."""
    tables = document.get("contact", [])
    for key in ("kt", "kn", "mu", "normal_load", "preload"):
        places = [(k, table[key]) for k, table in enumerate(tables) if isinstance(table.get(key), int | float)]
        alike = len({value for _, value in places}) == 1
        if places and alike:
            yield _slider(key, float(places[0][1]), tuple(("contact", k, key) for k, _ in places))
        elif places:
            for k, value in places:
                yield _slider(f"{tables[k].get('name', f'contact {k + 1}')} {key}", float(value), (("contact", k, key),))


def _forces(document: Mapping[str, Any]) -> Iterator[Slider]:
    """Static forces, the pulls on dampers."""
    for k, table in enumerate(document.get("force", [])):
        if isinstance(table.get("static"), int | float) and table["static"]:
            place = table.get("direction") if isinstance(table.get("direction"), str) else f"force {k + 1}"
            yield _slider(f"static force {place}", float(table["static"]), (("force", k, "static"),))
    for k, table in enumerate(document.get("body", [])):
        for axis, value in enumerate(table.get("pull", [])):
            if value:
                yield _slider(f"pull on {table.get('name', k + 1)} {'xyz'[axis]}", float(value), (("body", k, "pull", axis),))


def _slider(name: str, value: float, paths: tuple[Path, ...]) -> Slider:
    """Ranges by the kind of number: angles, positive ones on a logarithmic scale, zero and negative ones about themselves."""
    if name.endswith(("angle", "stagger")):
        return Slider(name, value, min(ANGLES[0], value), max(ANGLES[1], value), False, paths)
    if value > 0.0:
        return Slider(name, value, _rounded(value / FACTOR), _rounded(value * FACTOR), True, paths)
    reach = abs(value) * FACTOR or 1.0
    return Slider(name, value, -reach, reach, False, paths)


def _rounded(value: float) -> float:
    return float(f"{value:.3g}") if np.isfinite(value) else value
