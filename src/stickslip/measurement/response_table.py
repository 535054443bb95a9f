"""Measured frequency responses from text files: columns frequency, amplitude, force and, if there is one, phase."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stickslip.checks import Array, fault, nearest
from stickslip.measurement.measured_response import MeasuredResponse
from stickslip.measurement.number_table import NumberTable, text_table

TITLES = {
    "frequency": ("frequency", "freq", "f"),
    "amplitude": ("amplitude", "acceleration", "velocity", "displacement", "response", "a", "x", "v"),
    "force": ("force", "excitation", "level"),
    "phase": ("phase", "angle"),
}
"""Words by which a column is known, in its title; the first that fits."""

UNITS: dict[str, dict[str, float]] = {
    "frequency": {"hz": 1.0, "khz": 1e3, "rad/s": 0.5 / np.pi},
    "amplitude": {
        "m": 1.0,
        "mm": 1e-3,
        "um": 1e-6,
        "µm": 1e-6,
        "μm": 1e-6,
        "nm": 1e-9,
        "m/s": 1.0,
        "mm/s": 1e-3,
        "um/s": 1e-6,
        "µm/s": 1e-6,
        "m/s2": 1.0,
        "m/s²": 1.0,
        "m/s^2": 1.0,
        "mm/s2": 1e-3,
        "mm/s²": 1e-3,
        "g": 9.80665,
    },
    "force": {"n": 1.0, "kn": 1e3, "mn": 1e-3, "1": 1.0},
    "phase": {"rad": 1.0, "deg": np.pi / 180.0, "degree": np.pi / 180.0, "degrees": np.pi / 180.0, "°": np.pi / 180.0},
}
"""Units of a column in SI; without one it is Hz, the SI unit of the quantity, N, rad."""


def read_measured_response(path: str | Path, **about: Any) -> MeasuredResponse:
    """A test from a text file with a title for each column, `frequency [Hz], acceleration [m/s2], force [N], phase [rad]`.

    about: other arguments of `MeasuredResponse`, such as quantity, held, settings, error. Its name is that of the file.
    """
    file = Path(path)
    table = text_table(file)
    columns = {key: column for key in TITLES if (column := _column(table, key)) is not None}
    missing = [key for key in ("frequency", "amplitude", "force") if key not in columns and key not in about]
    if missing:
        found = "no titles" if table.titles is None else ", ".join(table.titles)
        remedy = "Name the columns: frequency [Hz], acceleration [m/s2], force [N], phase [rad]."
        raise fault(f"The titles of {file.name}", f"must name {', '.join(missing)}", found, remedy)
    values: dict[str, Any] = {key: _in_si(table, key, column) for key, column in columns.items()}
    return MeasuredResponse(**{"name": file.stem, **values, **about})


def _column(table: NumberTable, key: str) -> int | None:
    """The column of a quantity."""
    words = [title.lower().strip() for title in table.titles or ()]
    for known in TITLES[key]:
        for column, title in enumerate(words):
            if title == known or (len(known) > 2 and title.startswith(known)):
                return column
    return None


def _in_si(table: NumberTable, key: str, column: int) -> Array:
    """A column in SI."""
    unit = table.units[column]
    known = UNITS[key]
    if unit is not None and unit.lower() not in known:
        raise fault(f"The unit of {key} in {table.name}", f"must be one of {', '.join(known)}", unit, nearest(unit, known))
    return np.asarray(table.numbers[:, column] * (1.0 if unit is None else known[unit.lower()]))
