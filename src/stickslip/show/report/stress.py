"""Stress in the report: the largest at every place, with its vibratory and mean parts; fatigue margins in words and in this
section."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from stickslip.analyses.stress import (
    EQUIVALENTS,
    Margin,
    has_fatigue,
    has_gauges,
    has_stress,
    margins,
    smallest_margin,
    smallest_margins,
)
from stickslip.results.schema import in_system, shown_table, system_of
from stickslip.results.view import inside_band, level_text, peak_unit
from stickslip.show.plots.response_curves import haigh_diagram, stress_curves
from stickslip.show.report.markup import Charts, cell, framed, hertz, number, section, table
from stickslip.support.late import pd, xr

OF_MARGINS = (
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
    for case in range(dataset.sizes["case"]):
        worst = smallest.get(case)
        answer = "no point was found"
        if worst:
            answer = f"margin {worst.size:.3g} at {hertz(worst.frequency)} Hz, {worst.place}"
        lines.append(f"  {level_text(dataset, case):<14} {answer}")
    return lines


def fatigue_table(dataset: xr.Dataset) -> pd.DataFrame:
    """`margins` as a table."""
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
    note = OF_MARGINS.format(equivalent=EQUIVALENTS[dataset.attrs.get("fatigue_equivalent", "sines")])
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


NOTE = (
    '<p class="note">The largest of the computed points of each curve inside the band: the stress of von Mises at the worst '
    "instant of the period, with the mean; the component is the one that vibrates most there, in the axes of the body. At "
    "clamps, sharp corners and contacts stress is singular and grows with the mesh.</p>"
)


GAUGES = (
    '<p class="note">Strain gauges: the largest strain amplitude of each curve, half the peak-to-peak value over the period. '
    "With a fatigue limit, the limit of a gauge is its strain amplitude at the point of the smallest margin, multiplied by this "
    "margin: the motion is assumed to grow without changing its shape.</p>"
)
MICRO = 1e-6


class Largest(NamedTuple):
    """The largest stress of one curve at one place: Hz, Pa; the component that vibrates most, its amplitude and mean."""

    case: int
    place: str
    frequency: float
    von_mises: float
    component: str
    amplitude: float
    mean: float


def largest_stresses(dataset: xr.Dataset) -> Iterator[Largest]:
    """Of every force level and place where a point was solved."""
    for case, curve in enumerate(inside_band(dataset, "stress_von_mises")):
        for k, place in enumerate(dataset["place"].values):
            if np.any(np.isfinite(curve[:, k])):
                point = int(np.nanargmax(curve[:, k]))
                amplitudes, means = (dataset[name].values[case, point, k] for name in ("stress_amplitude", "stress_mean"))
                most = int(np.argmax(amplitudes))
                frequency = float(dataset["frequency"].values[case, point])
                component = str(dataset["component"].values[most])
                yield Largest(case, str(place), frequency, curve[point, k], component, amplitudes[most], means[most])


def stress_table(dataset: xr.Dataset) -> pd.DataFrame:
    """`largest_stresses` as a table."""
    rows = [(float(dataset["force_level"].values[largest.case]), *largest[1:]) for largest in largest_stresses(dataset)]
    heads = ["frequency [Hz]", "von Mises [Pa]", "component", "amplitude [Pa]", "mean [Pa]"]
    return pd.DataFrame(rows, columns=["force_level", "place", *heads])


class Strain(NamedTuple):
    """The largest strain of one curve at one gauge, and that at which the smallest fatigue margin of the curve is 1 if the motion
    grows in its shape, NaN without one; amplitudes [1]; Hz."""

    case: int
    gauge: str
    frequency: float
    amplitude: float
    limit: float


def largest_strains(dataset: xr.Dataset) -> Iterator[Strain]:
    """Of every force level and gauge where a point was solved."""
    smallest = smallest_margins(dataset) if has_fatigue(dataset) else {}
    for case, curve in enumerate(inside_band(dataset, "strain_amplitude")):
        worst = smallest.get(case)
        for k, gauge in enumerate(dataset["gauge"].values):
            if np.any(np.isfinite(curve[:, k])):
                point = int(np.nanargmax(curve[:, k]))
                limit = np.nan if worst is None else worst.size * curve[worst.point, k]
                yield Strain(case, str(gauge), float(dataset["frequency"].values[case, point]), curve[point, k], limit)


def strain_table(dataset: xr.Dataset) -> pd.DataFrame:
    """`largest_strains` as a table."""
    rows = [(float(dataset["force_level"].values[largest.case]), *largest[1:]) for largest in largest_strains(dataset)]
    return pd.DataFrame(rows, columns=["force_level", "gauge", "frequency [Hz]", "strain amplitude [1]", "limit [1]"])


def strain_sentences(dataset: xr.Dataset) -> list[str]:
    """The largest strain of each gauge and force level."""
    lines, levels = ["largest strain amplitude at gauges"], dataset["force_level"].values
    for largest in largest_strains(dataset):
        limit = "" if np.isnan(largest.limit) else f"; limit {largest.limit / MICRO:.4g} µm/m"
        size = f"{largest.amplitude / MICRO:.4g} µm/m at {hertz(largest.frequency)} Hz"
        lines.append(f"  force {levels[largest.case]:<8g} {size}, {largest.gauge}{limit}")
    return lines


def stress_sentences(dataset: xr.Dataset) -> list[str]:
    """The largest stress of each force level."""
    lines, (unit, name), every = ["largest von Mises stress"], pressure_unit(dataset), list(largest_stresses(dataset))
    for case in range(dataset.sizes["case"]):
        of_case = (stress for stress in every if stress.case == case)
        worst = max(of_case, key=lambda stress: stress.von_mises, default=None)
        answer = "no point was found"
        if worst:
            answer = f"{worst.von_mises / unit:.4g} {name} at {hertz(worst.frequency)} Hz, {worst.place}"
        lines.append(f"  {level_text(dataset, case):<14} {answer}")
    return lines


def stress(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Figure and table of every result that holds stress."""
    stressed = {label: dataset for label, dataset in datasets.items() if has_stress(dataset)}
    parts = []
    for k, (label, dataset) in enumerate(stressed.items()):
        figure = charts.drawn(f"chart-stress-{k}", stress_curves(dataset), "Von Mises stress along the curves")
        parts += [fatigue_part(charts, str(k), label, dataset), _gauges(k, label, dataset), figure]
        caption, found = f"{label}: largest stress at each place", largest_stresses(dataset)
        parts.append(_for_page(f"stress-{k}", caption, stress_table(dataset), dataset, found))
    return section("stress", "Stress", NOTE, *parts)


def _gauges(k: int, label: str, dataset: xr.Dataset) -> str:
    """The table of strain gauges; empty without any."""
    if not has_gauges(dataset):
        return ""
    frame = strain_table(dataset) if has_fatigue(dataset) else strain_table(dataset).drop(columns="limit [1]")
    sizes = [head for head in frame if head.endswith(" [1]")]
    frame[sizes] /= MICRO
    frame = frame.rename(columns={head: head.replace("[1]", "[µm/m]") for head in sizes})
    return GAUGES + _for_page(f"gauges-{k}", f"{label}: largest strain at each gauge", frame, dataset, largest_strains(dataset))


def _for_page(identifier: str, caption: str, frame: pd.DataFrame, dataset: xr.Dataset, found: Iterable[Largest | Strain]) -> str:
    """A table of what was found, with force levels in words and sizes in the units of the study."""
    frame["force_level"] = [level_text(dataset, each.case) for each in found]
    return framed(identifier, caption, shown_table(frame.rename(columns={"force_level": "force level"}), dataset))
