"""Growth of the time of a point with one variable, and the slope that the largest values should approach."""

from __future__ import annotations

from typing import Any

import numpy as np
from channel import Side

VALUES = {
    "contacts": (4, 10, 20, 40, 100, 200, 400),
    "harmonics": (1, 2, 3, 5, 7, 11, 15, 21, 31),
    "samples": (64, 128, 256, 512, 1024, 2048, 4096),
    "size": (10, 20, 40, 100, 200, 400, 1000, 2000),
}

EXPECTED = {
    "contacts": (3.0, "dense factorisation of the slipping rows, count³"),
    "harmonics": (3.0, "dense factorisation, (2H + 1)³; assembly and the contact's derivative grow as H²"),
    "samples": (1.0, "one pass over the samples of each contact"),
    "size": (1.0, "modal sums, one term a mode"),
}
"""Slope on logarithmic axes where this part dominates, and why."""

SECONDS = 25.0


def grow(side: Side) -> dict[str, Any]:
    """A table for each variable: value, CPU seconds a point, unknown rows, iterations; the observed slope of the last two."""
    found = {}
    for kind, values in VALUES.items():
        side.ask("growth", kind=kind, value=values[0], seconds=SECONDS)
        rows = [{"value": value} | side.ask("growth", kind=kind, value=value, seconds=SECONDS) for value in values]
        measured = [row for row in rows if "per_point" in row]
        (x0, y0), (x1, y1) = [(row["value"], row["per_point"]) for row in measured[-2:]]
        slope, why = EXPECTED[kind]
        observed = float(np.log(y1 / y0) / np.log(x1 / x0))
        found[kind] = {"rows": rows, "expected_slope": slope, "because": why, "observed_slope_at_the_end": observed}
    return found
