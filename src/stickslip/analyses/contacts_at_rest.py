"""The contacts at rest under the static load: what a result keeps of each, and a table with a row for each contact surface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stickslip.model.problem import Problem
from stickslip.model.problem.at_rest import at_rest, rest_variables
from stickslip.model.problem.meshed import resting
from stickslip.results.schema import in_system, system_of
from stickslip.support.checks import Array
from stickslip.support.late import xr
from stickslip.support.units import UnitSystem

MOST = 60
"""Rows of a table on the screen: six surfaces at each of ten loads."""


def rest_of(problem: Problem) -> dict[str, Any]:
    """The variables of a problem under its static load; none without contacts or a state of rest, or with one at each speed."""
    if not problem.contacts or problem.speed is not None:
        return {}
    loaded, rest = resting(problem, at_rest)
    return {} if rest is None else rest_variables(loaded, rest)


def by_surface(found: Mapping[str, Any] | xr.Dataset, system: UnitSystem | None = None) -> list[dict[str, Any]]:
    """A record for each contact surface, and for each contact by itself, by heads with their units; sums, and largest values."""
    (newton, force), (metre, length) = in_system("N", system), in_system("m", system)
    load, friction, gap, slip, state = (np.asarray(found[f"rest_{key}"]) for key in ("load", "friction", "gap", "slip", "state"))
    names = np.asarray(found["contact_surface"])
    return [
        {
            "surface": name,
            "contacts": int(own.sum()),
            "open": int(np.sum(state[own] == 0)),
            "at friction limit": int(np.sum(state[own] == 2)),
            f"normal load [{force}]": newton * float(load[own].sum()),
            f"least [{force}]": newton * float(load[own].min()),
            f"largest [{force}]": newton * float(load[own].max()),
            f"friction [{force}]": newton * float(friction[own].max()),
            f"slip [{length}]": metre * float(slip[own].max()),
            f"gap [{length}]": metre * float(gap[own].max()),
        }
        for name in dict.fromkeys(names[np.isfinite(load)].tolist())
        for own in [names == name]
    ]


def as_lines(records: Sequence[Mapping[str, Any]]) -> list[str]:
    """Records as the lines of a table, the first of many."""
    cells = [[each if isinstance(each, str) else f"{each:.4g}" for each in record.values()] for record in records[:MOST]]
    shown = [*map(list, records[:1]), *cells]
    widths = [max(map(len, column)) for column in zip(*shown, strict=True)]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)) for line in shown]
    return [*lines, f"... ({len(records)} in all)"] if len(records) > MOST else lines


def fields_at_rest(dataset: xr.Dataset) -> dict[str, Array]:
    """The contacts at rest at each contact node, by names with the units of the study; the pressure where areas are known."""
    of_node, fields = dataset["contact_of_node"].values, {}
    known = {str(name): values[of_node] for name, values in dataset.data_vars.items() if str(name).startswith("rest_")}
    if "contact_area" in dataset and dataset["contact_area"][of_node].all():
        known["rest_pressure"] = (known["rest_load"] / dataset["contact_area"][of_node]).assign_attrs(units="Pa")
    for name, values in known.items():
        factor, unit = in_system(values.attrs["units"], system_of(dataset))
        fields[f"{name.removeprefix('rest_')} at rest{'' if unit == '1' else f' [{unit}]'}"] = factor * values.values
    return fields
