"""Measured frequency responses from text files: columns frequency, amplitude, force and, if there is one, phase."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stickslip.checks import Array, among, fault, nearest
from stickslip.measurement.measured_response import MeasuredResponse
from stickslip.measurement.number_table import NumberTable, text_table

TITLES = {
    "frequency": ("frequency", "freq", "f"),
    "amplitude": ("amplitude", "response"),
    "force": ("force", "excitation", "level"),
    "phase": ("phase", "angle"),
}
"""Words by which a column is known, in its title; the first that fits."""

QUANTITY_TITLES = {
    "acceleration": ("acceleration", "acc", "a"),
    "velocity": ("velocity", "vel", "v"),
    "displacement": ("displacement", "disp", "x"),
}
"""Words for the amplitude of each quantity."""

UNITS: dict[str, dict[str, float]] = {
    "frequency": {"hz": 1.0, "khz": 1e3, "rad/s": 0.5 / np.pi},
    "displacement": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9},
    "velocity": {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6, "µm/s": 1e-6},
    "acceleration": {"m/s2": 1.0, "m/s²": 1.0, "m/s^2": 1.0, "mm/s2": 1e-3, "mm/s²": 1e-3, "g": 9.80665},
    "force": {"n": 1.0, "kn": 1e3, "mN": 1e-3, "MN": 1e6, "1": 1.0},
    "phase": {"rad": 1.0, "deg": np.pi / 180.0, "degree": np.pi / 180.0, "degrees": np.pi / 180.0, "°": np.pi / 180.0},
}
"""Units of a column in SI; without one it is Hz, the SI unit of the quantity, N, rad."""


def read_measured_response(path: str | Path, **about: Any) -> MeasuredResponse:
    """A test from a text file with a title for each column, `frequency [Hz], acceleration [m/s2], force [N], phase [rad]`.

    The amplitude is the column of the quantity, or one that is titled amplitude or response, in a unit of the quantity; which
    quantity, the titles say unless it is given (acceleration for a column of amplitudes).
    about: other arguments of `MeasuredResponse`, such as quantity, held, settings, error. Its name is that of the file.
    """
    file = Path(path)
    table = text_table(file)
    if about.get("quantity") is None:
        titled = (name for name, words in QUANTITY_TITLES.items() if _column(table, words) is not None)
        about["quantity"] = next(titled, "acceleration")
    quantity = among("quantity", about["quantity"], tuple(QUANTITY_TITLES))
    titles = {**TITLES, "amplitude": (*QUANTITY_TITLES[quantity], *TITLES["amplitude"])}
    columns = {key: column for key, words in titles.items() if (column := _column(table, words)) is not None}
    missing = [key for key in ("frequency", "amplitude", "force") if key not in columns and key not in about]
    if missing:
        found = "no titles" if table.titles is None else ", ".join(table.titles)
        remedy = "Name the columns: frequency [Hz], acceleration [m/s2], force [N], phase [rad]."
        raise fault(f"The titles of {file.name}", f"must name {', '.join(missing)}", found, remedy)
    values: dict[str, Any] = {
        key: _in_si(table, quantity if key == "amplitude" else key, column) for key, column in columns.items()
    }
    return MeasuredResponse(**{"name": file.stem, **values, **about})


def _column(table: NumberTable, titles: tuple[str, ...]) -> int | None:
    """The column with one of these titles, the first that there is."""
    words = [title.lower().strip() for title in table.titles or ()]
    for known in titles:
        for column, title in enumerate(words):
            if title == known or (len(known) > 2 and title.startswith(known)):
                return column
    return None


def _in_si(table: NumberTable, key: str, column: int) -> Array:
    """A column in SI."""
    unit = table.units[column]
    known = UNITS[key]
    factor = 1.0 if unit is None else known.get(unit, known.get(unit.lower()))  # mN is not MN
    if factor is None:
        raise fault(f"The unit of {key} in {table.name}", f"must be one of {', '.join(known)}", unit, nearest(str(unit), known))
    return np.asarray(table.numbers[:, column] * factor)
