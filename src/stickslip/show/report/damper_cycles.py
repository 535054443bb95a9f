"""Presentation of several cycles of one damper, for sampled initial states or for changing friction."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from stickslip.analyses.damper_alone.cycle import LARGEST_ROTATION
from stickslip.results.shown_units import in_system, system_of
from stickslip.show.plots.damper_cycle import cycle_names, damper_cycles
from stickslip.show.report.damper_cycle import microjoules
from stickslip.show.report.presentation import Presentation, presents
from stickslip.support.checks import counted, rounded

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.show.plots.files import Figures


def sentences(dataset: xr.Dataset) -> list[str]:
    """How many cycles, and each of them."""
    factor, unit = in_system("µJ", system_of(dataset))
    energies, rotations = factor * microjoules(dataset, dataset.loop_energy.values), 1e3 * dataset.rotation.values
    low, high = rounded(energies.min(), 4), rounded(energies.max(), 4)
    ends = f"{high} {unit}" if low == high else f"{low} to {high} {unit}"
    if "starts" in dataset:
        total = int(dataset.starts.sum()) + int(dataset.attrs["failed"])
        lines = [f"{counted(energies.size, 'steady cycle')} from {counted(total, 'initial state')}, {ends} a cycle"]
    else:
        jammed = int(np.count_nonzero(dataset.outcome.values == "jammed"))
        lines = [f"{counted(energies.size, 'cycle')}, {ends} a cycle" + (f"; {jammed} of them jammed" if jammed else "")]
    cycles = zip(dataset.cycle.values, cycle_names(dataset), energies, rotations, dataset.outcome.values, strict=True)
    for cycle, name, energy, rotation, outcome in cycles:
        ended = str(outcome).replace("_", " ")
        lines.append(f"cycle {cycle}, {name}: {rounded(energy, 6)} {unit}, rotation {rounded(rotation, 4)} mrad, {ended}")
    return lines


def failures(dataset: xr.Dataset) -> list[str]:
    """Starts that led nowhere; cycles of an evolution with steps that were not solved (one need not be steady: friction goes on
    changing; that it jams is a finding)."""
    names, messages, far = cycle_names(dataset), dataset.message.values, dataset.rotation.values > LARGEST_ROTATION
    if "starts" in dataset:
        failed = int(dataset.attrs["failed"])
        lost = [f"{counted(failed, 'initial state')} led to no steady cycle."] if failed else []
        return lost + [f"{name}: {message}" for name, bad, message in zip(names, far, messages, strict=True) if bad]
    failing = far | (dataset.iterations.values < 0).any(axis=-1)
    return [f"{name}: {message}" for name, bad, message in zip(names, failing, messages, strict=True) if bad]


def figures(dataset: xr.Dataset) -> Figures:
    """The cycles side by side."""
    return {"damper_cycles": damper_cycles}


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """A row for each cycle, and for each contact in it."""
    cycles = pd.DataFrame(
        {
            "cycle": dataset.cycle.values,
            "starts" if "starts" in dataset else "friction": [name.removeprefix("µ = ") for name in cycle_names(dataset)],
            "energy [µJ]": microjoules(dataset, dataset.loop_energy.values),
            "friction work [µJ]": microjoules(dataset, dataset.friction_work.sum("contact").values),
            "stored [µJ]": microjoules(dataset, dataset.stored_energy.values),
            "rotation [mrad]": 1e3 * dataset.rotation.values,
            "largest normal force [N]": dataset.normal_force.max(["sample", "contact"]).values,
            "outcome": [str(outcome).replace("_", " ") for outcome in dataset.outcome.values],
        }
    )
    contacts = [
        {
            "cycle": int(cycle),
            "contact": str(contact),
            "energy [µJ]": float(microjoules(dataset, dataset.friction_work.sel(cycle=cycle, contact=contact).values)),
            **{
                f"{kind} [%]": 100.0 * float(dataset.share.sel(cycle=cycle, contact=contact, kind=kind))
                for kind in dataset.kind.values
            },
        }
        for cycle in dataset.cycle.values
        for contact in dataset.contact.values
    ]
    return {"cycles": cycles, "contacts": pd.DataFrame(contacts)}


PRESENTATION = presents(
    ("steady_cycles", "damper_evolution"),
    Presentation("Cycles of a damper", sentences, failures, figures, tables, answer="cycles"),
)
