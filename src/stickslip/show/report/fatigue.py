"""Fatigue margins in words, and as the part of the report's section on stress."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.fatigue import EQUIVALENTS, Margin, has_fatigue, margins, smallest_margin, smallest_margins
from stickslip.results.shown_units import in_system, system_of
from stickslip.results.view import level_text, peak_unit
from stickslip.show.plots.stress import haigh_diagram
from stickslip.show.report.charts import Charts
from stickslip.show.report.markup import cell, table
from stickslip.show.report.numbers import hertz, number

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

NOTE = (
    '<p class="note">The smallest margin of each curve and place is the stress amplitude that the material withstands at the '
    "mean stress there, divided by that of the vibration. {equivalent}. Below a margin of 1 the part fails. The margin without "
    "contacts is that of the largest resonance of the structure without contacts in the band, at the same force level and mean "
    "stress. The vibration may grow by the factor of the margin if the mean stress does not change; the output then reaches the "
    "amplitude in the last column, if the motion keeps its shape.</p>"
)


def fatigue_headline(dataset: xr.Dataset) -> str:
    """The smallest margin of all force levels in a sentence; empty without a fatigue limit."""
    worst = smallest_margin(dataset) if has_fatigue(dataset) else None
    if worst is None:
        return ""
    where = f"{worst.place}, {level_text(dataset, worst.case)}, {hertz(worst.frequency)} Hz"
    sizes = f"amplitude {_pressure(dataset, worst.alternating)} at a mean of {_pressure(dataset, worst.mean)}"
    verdict = "" if worst.size >= 1.0 else " The material does not withstand it."
    if np.isfinite(worst.size_without_contacts):
        verdict += f" Without contacts the margin there is {number(worst.size_without_contacts, 3)}."
    return f"Smallest fatigue margin {number(worst.size, 3)} ({dataset.attrs['fatigue_criterion']}): {where}, {sizes}.{verdict}"


def fatigue_sentences(dataset: xr.Dataset) -> list[str]:
    """The headline, and the smallest margin of each force level."""
    lines = [fatigue_headline(dataset).replace("\xa0", " ")]
    smallest = smallest_margins(dataset)
    for case, level in enumerate(dataset["force_level"].values):
        worst = smallest.get(case)
        answer = "no point was found"
        if worst:
            answer = f"margin {worst.size:.3g} at {worst.frequency:.6g} Hz, {worst.place}"
        lines.append(f"  force {level:<8g} {answer}")
    return lines


def fatigue_table(dataset: xr.Dataset) -> pd.DataFrame:
    """`margins` as a table."""
    import pandas as pd

    rows = []
    for margin in margins(dataset):
        level, stresses = float(dataset["force_level"].values[margin.case]), (margin.alternating, margin.mean, margin.allowed)
        sizes = margin.size, allowed_amplitude(dataset, margin), margin.size_without_contacts
        rows.append((level, margin.place, margin.frequency, *stresses, *sizes))
    heads = ["frequency [Hz]", "amplitude [Pa]", "mean [Pa]", "limit [Pa]", "margin", "allowed amplitude [m]"]
    heads.append("margin without contacts")
    return pd.DataFrame(rows, columns=["force_level", "place", *heads])


def allowed_amplitude(dataset: xr.Dataset, margin: Margin) -> float:
    """The amplitude of the first output [m] at which a margin is 1, if the motion grows in its shape."""
    return margin.size * float(dataset["amplitude"].values[margin.case, margin.point, 0])


def fatigue_part(charts: Charts, name: str, label: str, dataset: xr.Dataset) -> str:
    """Diagram and table of one result; empty without a fatigue limit."""
    if not has_fatigue(dataset):
        return ""
    (pascals, pressure), length = pressure_unit(dataset), peak_unit(dataset)
    heads = ["force level", "place", "frequency in Hz", f"amplitude in {pressure}", f"mean in {pressure}", f"limit in {pressure}"]
    heads += ["margin", "margin without contacts", f"allowed amplitude of {dataset['output'].values[0]} in {length.name}"]
    figure = charts.drawn(f"chart-haigh-{name}", haigh_diagram(dataset), "Haigh diagram")
    note = NOTE.format(equivalent=EQUIVALENTS[dataset.attrs.get("fatigue_equivalent", "sines")])
    rows = []
    for margin in margins(dataset):
        cells = [cell(level_text(dataset, margin.case), float(dataset["force_level"].values[margin.case])), cell(margin.place)]
        cells.append(cell(hertz(margin.frequency), margin.frequency))
        cells += [cell(number(size / pascals), size) for size in (margin.alternating, margin.mean, margin.allowed)]
        cells.append(cell(number(margin.size, 3), margin.size, "" if margin.size >= 1.0 else "fails"))
        free, allowed = margin.size_without_contacts, allowed_amplitude(dataset, margin)
        cells.append(cell(number(free, 3) if np.isfinite(free) else "–", free))
        cells.append(cell(number(allowed / length.metres) if np.isfinite(allowed) else "–", allowed))
        rows.append(f"<tr>{''.join(cells)}</tr>")
    return note + figure + table(f"fatigue-{name}", f"{label}: smallest fatigue margins", heads, rows)


def pressure_unit(dataset: xr.Dataset) -> tuple[float, str]:
    """The size in Pa of the unit to show stress in, and its name: MPa unless the study states others."""
    factor, name = in_system("MPa", system_of(dataset))
    return 1e6 / factor, name


def _pressure(dataset: xr.Dataset, size: float) -> str:
    pascals, name = pressure_unit(dataset)
    return f"{number(size / pascals, 3)} {name}"
