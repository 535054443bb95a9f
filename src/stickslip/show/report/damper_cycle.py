"""Presentation of a damper cycle: energy, rotation, states; a figure; tables of contacts and of equivalent harmonic forces."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from stickslip.analyses.damper_alone.cycle import LARGEST_ROTATION
from stickslip.results.shown_units import in_system, system_of
from stickslip.show.plots.damper_cycle import damper_cycle
from stickslip.show.report.presentation import Presentation, presents
from stickslip.support.checks import Array, rounded

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.show.plots.files import Figures

ROUNDING = 1e-9
"""Energy over largest force times motion below which a cycle counts as without dissipation."""

STILL = 1e-9
"""Rotation in mrad below which it is rounding."""


def sentences(dataset: xr.Dataset) -> list[str]:
    """What came out."""
    factor, unit = in_system("µJ", system_of(dataset))
    energy, rotation = factor * float(microjoules(dataset, dataset.loop_energy.values)), 1e3 * float(dataset.rotation)
    rotation = 0.0 if rotation < STILL else rotation
    first = f"{rounded(energy, 6)} {unit} a cycle, rotation {rounded(rotation, 4)} mrad peak to peak"
    lines = [first, str(dataset.attrs["message"])]
    for contact in dataset.contact.values:
        stick, slip, open_ = 100.0 * dataset.share.sel(contact=contact).values
        lines.append(f"{contact}: stick {stick:.1f} %, slip {slip:.1f} %, open {open_:.1f} % of the cycle")
    return lines


def failures(dataset: xr.Dataset) -> list[str]:
    """The outcome, where there is no steady sliding cycle, or one beyond the theory of small motions."""
    failed = dataset.attrs["outcome"] in ("not_steady", "not_converged", "jammed") or float(dataset.rotation) > LARGEST_ROTATION
    return [str(dataset.attrs["message"])] if failed else []


def figures(dataset: xr.Dataset) -> Figures:
    """The cycle."""
    return {"damper_cycle": damper_cycle}


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


PRESENTATION = presents("damper_cycle", Presentation("Damper cycle", sentences, failures, figures, tables, answer="contacts"))
