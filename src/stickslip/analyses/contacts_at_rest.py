"""The contacts at rest under the static load: what a result keeps of each, and a table with a row for each contact surface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stickslip.model.contact.point import OnSurface
from stickslip.model.problem import Problem
from stickslip.model.problem.at_rest import ContactsAtRest, Rest, at_rest, contacts_at_rest
from stickslip.model.problem.meshed import resting
from stickslip.results.schema import in_system, system_of
from stickslip.support.checks import Array
from stickslip.support.late import xr
from stickslip.support.units import UnitSystem

MOST = 24
"""Rows of a table on the screen."""


def rest_of(problem: Problem) -> dict[str, Any]:
    """The variables of a problem under its static load; none without contacts or a state of rest, or with one at each speed."""
    if not problem.contacts or problem.speed is not None:
        return {}
    loaded, rest = resting(problem, at_rest)
    return {} if rest is None else rest_variables(loaded, rest)


def rest_variables(problem: Problem, rest: Rest) -> dict[str, Any]:
    """The variables of the table `contacts_at_rest` by name."""
    parts = [contact.surface or OnSurface(contact.name) for contact in problem.contacts]
    found = {f"rest_{key}": value for key, value in contacts_at_rest(problem, rest)._asdict().items()}
    found["contact_surface"] = np.array([part.name for part in parts])
    found["contact_node_place"] = np.concatenate([part.places for part in parts])
    return found | {"contact_of_node": np.repeat(np.arange(len(parts)), [len(part.places) for part in parts])}


def by_surface(found: Mapping[str, Any] | xr.Dataset, system: UnitSystem | None = None) -> list[dict[str, Any]]:
    """A record for each contact surface, and for each contact by itself, by heads with their units; sums, and largest values."""
    (newton, force), (metre, length) = in_system("N", system), in_system("m", system)
    load, friction, gap, slip, state = (np.asarray(found[f"rest_{key}"]) for key in ("load", "friction", "gap", "slip", "state"))
    names, records = np.asarray(found["contact_surface"]), []
    for name in dict.fromkeys(names[np.isfinite(load)].tolist()):
        own = names == name
        counts = {"contacts": own, "open": own & (state == 0), "at friction limit": own & (state == 2)}
        forces = {
            "normal load": load[own].sum(),
            "least": load[own].min(),
            "largest": load[own].max(),
            "friction": friction[own].max(),
        }
        records.append(
            {"surface": name}
            | {key: int(np.sum(each)) for key, each in counts.items()}
            | {f"{key} [{force}]": newton * float(value) for key, value in forces.items()}
            | {f"slip [{length}]": metre * float(slip[own].max()), f"gap [{length}]": metre * float(gap[own].max())}
        )
    return records


def as_lines(records: Sequence[Mapping[str, Any]]) -> list[str]:
    """Records as the lines of a table, the first of many."""
    cells = [[each if isinstance(each, str) else f"{each:.4g}" for each in record.values()] for record in records[:MOST]]
    shown = [*map(list, records[:1]), *cells]
    widths = [max(map(len, column)) for column in zip(*shown, strict=True)]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)) for line in shown]
    return [*lines, f"... ({len(records)} in all)"] if len(records) > MOST else lines


def fields_at_rest(dataset: xr.Dataset) -> dict[str, Array]:
    """The contacts at rest at each contact node, by names with the units of the study; the pressure where areas are known."""
    known = {key: dataset[f"rest_{key}"] for key in ContactsAtRest._fields}
    if "contact_area" in dataset and dataset["contact_area"].values[dataset["contact_of_node"].values].all():
        known["pressure"] = (known["load"] / dataset["contact_area"]).assign_attrs(units="Pa")
    sizes = {key: in_system(values.attrs["units"], system_of(dataset)) for key, values in known.items()}
    heads = {key: f"{key} at rest{'' if unit == '1' else f' [{unit}]'}" for key, (_, unit) in sizes.items()}
    of_node = dataset["contact_of_node"].values
    return {heads[key]: sizes[key][0] * values.values[of_node] for key, values in known.items()}
