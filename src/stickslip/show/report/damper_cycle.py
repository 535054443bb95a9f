"""Presentation of a damper cycle: energy, rotation, states; a figure; tables of contacts and of equivalent harmonic forces.

Presentation of several cycles of one damper, for sampled initial states or for changing friction.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np

from stickslip.analyses.damper_alone.cycle import LARGEST_ROTATION
from stickslip.results.schema import Row, in_system, system_of
from stickslip.show.plots.damper_cycle import cycle_names, damper_cycle, damper_cycles
from stickslip.show.report.markup import presents
from stickslip.support.checks import Array, counted, rounded
from stickslip.support.late import pd, xr

ROUNDING = 1e-9
"""Energy over largest force times motion below which a cycle counts as without dissipation."""

STILL = 1e-9
"""Rotation in mrad below which it is rounding."""


def sentences(dataset: xr.Dataset) -> list[str]:
    """What came out."""
    factor, unit = in_system("µJ", system_of(dataset))
    energy, rotation = factor * float(microjoules(dataset, dataset.loop_energy.values)), 1e3 * float(dataset.rotation)
    rotation = 0.0 if rotation < STILL else rotation
    first = f"{rounded(energy, 4)} {unit} a cycle, rotation {rounded(rotation, 4)} mrad peak to peak"
    lines = [first, str(dataset.attrs["message"])]
    for contact in dataset.contact.values:
        stick, slip, open_ = 100.0 * dataset.share.sel(contact=contact).values
        lines.append(Row(f"{contact}: stick {stick:.1f} %, slip {slip:.1f} %, open {open_:.1f} % of the cycle"))
    return lines


def failures(dataset: xr.Dataset) -> list[str]:
    """The outcome, where there is no steady sliding cycle, or one beyond the theory of small motions."""
    failed = dataset.attrs["outcome"] in ("not_steady", "not_converged", "jammed") or float(dataset.rotation) > LARGEST_ROTATION
    return [str(dataset.attrs["message"])] if failed else []


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """By contact, by harmonic, and the cycle itself sample by sample."""
    shares = {f"{kind} [%]": 100.0 * dataset.share.sel(kind=kind).values for kind in dataset.kind.values}
    contacts = {
        "contact": [str(name) for name in dataset.contact.values],
        "energy [µJ]": microjoules(dataset, dataset.friction_work.values),
        **shares,
        "largest normal force [N]": dataset.normal_force.max("sample").values,
        "smallest normal force [N]": dataset.normal_force.min("sample").values,
    }

    # Complex amplitudes of the forces on the platforms, F(t) = Re Σ F_h exp(ihωt).
    harmonics: dict[str, np.ndarray] = {"harmonic": np.arange(dataset.sizes["harmonic"])}
    for platform, axis, part in product(dataset.platform.values, dataset.axis.values, dataset.part.values):
        column = dataset.force_harmonics.sel(platform=platform, axis=axis, part=part).values
        harmonics[f"{platform} {axis} {part} [N]"] = column

    cycle = {"phase [1]": dataset.phase.values}
    for name, words in (("platform_motion", "platform {} [m]"), ("force_on_right", "force on right {} [N]")):
        cycle |= {words.format(axis): dataset[name].sel(axis=axis).values for axis in dataset.axis.values}
    for contact in dataset.contact.values:
        of_contact = dataset.sel(contact=contact)
        cycle |= {f"T {contact} [N]": of_contact.friction_force.values, f"N {contact} [N]": of_contact.normal_force.values}
        cycle[f"state {contact} [1]"] = of_contact.state.values
    columns = {"contacts": contacts, "harmonics": harmonics, "cycle": cycle}
    return {caption: pd.DataFrame(table) for caption, table in columns.items()}


def microjoules(dataset: xr.Dataset, energy: Array) -> Array:
    """Energies [J], one of each cycle where there are several, in µJ; 0 for what is rounding of force times motion."""
    moved = float(np.ptp(dataset.platform_motion.values, axis=dataset.platform_motion.get_axis_num("sample")).max())
    largest = float(np.abs(dataset.force_on_right.values).max()) * moved
    return np.where(np.abs(energy) < ROUNDING * largest, 0.0, 1e6 * energy)


presents("damper_cycle", "Damper cycle", sentences, {"damper_cycle": damper_cycle}, tables, failures=failures, answer="contacts")


def several_sentences(dataset: xr.Dataset) -> list[str]:
    """How many cycles, and each of them."""
    factor, unit = in_system("µJ", system_of(dataset))
    energies, rotations = factor * microjoules(dataset, dataset.loop_energy.values), 1e3 * dataset.rotation.values
    low, high = rounded(energies.min(), 4), rounded(energies.max(), 4)
    ends = f"{high} {unit}" if low == high else f"{low} to {high} {unit}"
    if "starts" in dataset:
        total = int(dataset.starts.sum()) + int(dataset.attrs["failed"])
        lines = [f"{counted(energies.size, 'steady cycle')} from {counted(total, 'initial state')}, {ends} a cycle"]
    else:
        jammed = [name for name, outcome in zip(cycle_names(dataset), dataset.outcome.values, strict=True) if outcome == "jammed"]
        which = f"; {len(jammed)} of them jammed ({', '.join(jammed)})" if jammed else ""
        lines = [f"{counted(energies.size, 'cycle')}, {ends} a cycle{which}"]
    for cycle, name, energy, rotation, ended in zip(
        dataset.cycle.values, cycle_names(dataset), energies, rotations, _ended(dataset), strict=True
    ):
        row = f"cycle {cycle}, {name}: {rounded(energy, 4)} {unit}, rotation {rounded(rotation, 4)} mrad, {ended}"
        lines.append(Row(row))
    return lines


def _ended(dataset: xr.Dataset) -> list[str]:
    """How each cycle ended, in words; an evolution goes on after as many cycles as were asked for, steady or not."""
    asked = f"after {counted(int(dataset.attrs['cycles']), 'cycle')}" if "starts" not in dataset else ""
    return [asked if asked and outcome == "not_steady" else str(outcome).replace("_", " ") for outcome in dataset.outcome.values]


def several_failures(dataset: xr.Dataset) -> list[str]:
    """Starts that led nowhere; cycles of an evolution with steps that were not solved (one need not be steady: friction goes on
    changing; that it jams is a finding)."""
    names, messages, far = cycle_names(dataset), dataset.message.values, dataset.rotation.values > LARGEST_ROTATION
    if "starts" in dataset:
        failed = int(dataset.attrs["failed"])
        lost = [f"{counted(failed, 'initial state')} led to no steady cycle."] if failed else []
        return lost + [f"{name}: {message}" for name, bad, message in zip(names, far, messages, strict=True) if bad]
    failing = far | (dataset.iterations.values < 0).any(axis=-1)
    return [f"{name}: {message}" for name, bad, message in zip(names, failing, messages, strict=True) if bad]


def several_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
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
            "outcome": _ended(dataset),
        }
    )
    work = dataset.friction_work.transpose("cycle", "contact").values
    shares = 100.0 * dataset.share.transpose("cycle", "contact", "kind").values
    contacts = {
        "cycle": np.repeat(dataset.cycle.values, work.shape[1]),
        "contact": np.tile(dataset.contact.values.astype(object), len(work)),
        "energy [µJ]": microjoules(dataset, work).ravel(),
        **{f"{kind} [%]": shares[..., k].ravel() for k, kind in enumerate(dataset.kind.values)},
    }
    return {"cycles": cycles, "contacts": pd.DataFrame(contacts)}


presents(
    ("steady_cycles", "damper_evolution"),
    "Cycles of a damper",
    several_sentences,
    {"damper_cycles": damper_cycles},
    several_tables,
    failures=several_failures,
    answer="cycles",
)
