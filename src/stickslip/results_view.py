"""What figures and the report read from a dataset: curves without padding, peaks with their points, contacts by direction.

Numbers stay in SI; only `level_text` makes words. `results_schema` says what the variables are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.checks import Array
from stickslip.outcome import Outcome
from stickslip.units import um

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Peak:
    """The highest peak of one case and output: Hz, m, and the point of the curve that it is.

    local: a local maximum of the curve; else the largest computed amplitude, at an end of the band or of a list of frequencies.
    """

    frequency: float
    amplitude: float
    max_abs: float
    loss_factor: float
    point: int
    local: bool


@dataclass(frozen=True)
class ContactRow:
    """One direction of one contact, as indices into the dataset, with its name."""

    contact: int
    direction: int
    label: str


@dataclass(frozen=True)
class Length:
    """A unit of length to show numbers in: its size in metres and its name."""

    metres: float
    name: str


def length_unit(*datasets: xr.Dataset) -> Length:
    """Micrometres, or metres where amplitudes exceed a centimetre: lumped models are often stated without dimensions."""
    return unit_for(max(float(np.max(np.nan_to_num(dataset.amplitude.values), initial=0.0)) for dataset in datasets))


def length_text(length: float) -> str:
    """A length with its unit, "12.3 µm"."""
    unit = unit_for(abs(length))
    return f"{length / unit.metres:.4g} {unit.name}"


def unit_for(largest: float) -> Length:
    """Micrometres, or metres for lengths beyond a centimetre."""
    return Length(um, "µm") if largest <= 0.01 else Length(1.0, "m")


def level_text(dataset: xr.Dataset, case: int) -> str:
    """The force level in words, with the start state of a sample."""
    words = force_text(dataset, case)
    return f"{words}, start {int(dataset['start'][case]) + 1}" if "start" in dataset.coords else words


def force_text(dataset: xr.Dataset, case: int) -> str:
    """The force level alone: "20 N" where the dataset says that the levels are newtons, else "force × 20"."""
    level = f"{float(dataset.force_level[case]):g}"
    return f"{level} N" if levels_in_newtons(dataset) else f"force × {level}"


def levels_in_newtons(dataset: xr.Dataset) -> bool:
    return str(dataset.force_level.attrs.get("units", "1")) == "N"


def points(dataset: xr.Dataset, case: int) -> np.ndarray:
    """Indices of the points that were computed, converged or not, in the order of the curve."""
    return np.flatnonzero(dataset.outcome.values[case] != Outcome.EMPTY)


def converged_points(dataset: xr.Dataset, case: int) -> np.ndarray:
    """Indices of the converged points, in the order of the curve."""
    return np.flatnonzero(dataset.outcome.values[case] == Outcome.CONVERGED)


def failed_points(dataset: xr.Dataset, case: int) -> np.ndarray:
    """Indices of the points that did not converge."""
    return np.setdiff1d(points(dataset, case), converged_points(dataset, case))


def frequencies(dataset: xr.Dataset, case: int) -> Array:
    """Frequencies of `points`, Hz."""
    return np.asarray(dataset.frequency.values[case, points(dataset, case)])


def along_curve(dataset: xr.Dataset, name: str, case: int) -> Array:
    """A variable (case, point, ...) at `points`, NaN where the point did not converge, so that lines break there."""
    values = np.array(dataset[name].values[case], dtype=float)
    values[failed_points(dataset, case)] = np.nan
    return np.asarray(values[points(dataset, case)])


def is_folded(dataset: xr.Dataset, case: int) -> bool:
    """Whether the curve turns back in frequency."""
    steps = np.diff(frequencies(dataset, case))
    return bool(np.any(steps > 0.0) and np.any(steps < 0.0))


def highest_peak(dataset: xr.Dataset, case: int, output: int = 0) -> Peak | None:
    """The highest peak of a case; None where nothing converged."""
    candidates = converged_points(dataset, case)
    amplitudes = dataset.amplitude.values[case, candidates, output]
    if not candidates.size or not np.any(np.isfinite(amplitudes)):
        return None
    solved = dataset.sizes["peak"] > 0 and bool(np.isfinite(dataset.peak_amplitude.values[case, 0, output]))
    if not solved:
        point = int(candidates[np.nanargmax(amplitudes)])
        frequency, loss_factor = (float(dataset[name].values[case, point]) for name in ("frequency", "loss_factor"))
        amplitude, max_abs = (float(dataset[name].values[case, point, output]) for name in ("amplitude", "max_abs"))
        return Peak(frequency, amplitude, max_abs, loss_factor, point, local=False)
    names = ("peak_frequency", "peak_amplitude", "peak_max_abs", "peak_loss_factor")
    frequency, amplitude, max_abs, loss_factor = (float(dataset[name].values[case, 0, output]) for name in names)
    return Peak(
        frequency, amplitude, max_abs, loss_factor, nearest_point(dataset, case, output, frequency, amplitude), local=True
    )


def nearest_point(dataset: xr.Dataset, case: int, output: int, frequency: float, amplitude: float) -> int:
    """The converged point of a curve that stands nearest to a place on it; a peak is a point itself."""
    candidates = converged_points(dataset, case)
    amplitudes = dataset.amplitude.values[case, candidates, output]
    distance = np.abs(dataset.frequency.values[case, candidates] / frequency - 1.0) + np.abs(amplitudes / amplitude - 1.0)
    return int(candidates[np.nanargmin(distance)])


def linear_peak(dataset: xr.Dataset, which: str, case: int, output: int = 0) -> tuple[float, float] | None:
    """Frequency, Hz, and amplitude, m, of the highest maximum of the "free" or "stuck" curve; None when it is at an end."""
    amplitude = dataset[f"{which}_amplitude"].values[case, :, output]
    if amplitude.size < 3 or not np.any(np.isfinite(amplitude)):
        return None
    index = int(np.nanargmax(amplitude))
    if index in (0, amplitude.size - 1):
        return None
    return float(dataset.linear_frequency.values[index]), float(amplitude[index])


def contact_rows(dataset: xr.Dataset) -> list[ContactRow]:
    """The tangential directions in which each contact moves; the normal one where it has no other.

    A direction that moves by less than 1e-9 of the largest motion is at rest but for rounding: it is left out, unless it is
    the only one of its contact.
    """
    directions = [str(name) for name in dataset.direction.values]
    motion = _largest_motion(dataset)
    moving = motion >= 1e-9 * np.max(motion, initial=0.0)
    used = np.any(np.isfinite(dataset.share_stick.values), axis=(0, 1))
    rows = []
    for contact, name in enumerate(dataset.contact.values):
        present = np.flatnonzero(used[contact])
        tangential = [index for index in present if directions[index] != "n"] or list(present)
        kept = [index for index in tangential if moving[contact, index]] or tangential[:1]
        labels = [f"{name}, {directions[index]}" if len(kept) > 1 or directions[index] == "n" else str(name) for index in kept]
        rows += [ContactRow(contact, int(index), label) for index, label in zip(kept, labels, strict=True)]
    return rows


def largest_loops(dataset: xr.Dataset, rows: list[ContactRow], count: int) -> list[ContactRow]:
    """At most `count` rows whose loops at the peak enclose most at any force level, in their old order.

    Loops below 1e-6 of the largest are lines: they are left out where there are others.
    """
    areas = loop_areas(dataset)
    area = np.array([areas[row.contact, row.direction] for row in rows])
    order = [index for index in np.argsort(-area, kind="stable")[:count] if area[index] >= 1e-6 * area.max()]
    return [rows[index] for index in sorted(order)]


def loop_areas(dataset: xr.Dataset) -> Array:
    """Largest |∮ T du| of the loops over the force levels, (contact, direction), J; 0 where there is none."""
    motion, force = dataset.loop_motion.values, dataset.loop_force.values
    work = np.abs(np.sum(0.5 * (force + np.roll(force, -1, axis=-1)) * (np.roll(motion, -1, axis=-1) - motion), axis=-1))
    return np.asarray(np.max(np.nan_to_num(work), axis=0, initial=0.0))


def _largest_motion(dataset: xr.Dataset) -> Array:
    """Largest harmonic of the motion at any point, without the mean, (contact, direction), m; 0 where there is none."""
    parts = np.nan_to_num(dataset.contact_motion.values[:, :, :, :, 1:])
    return np.asarray(np.max(np.hypot(parts[..., 0], parts[..., 1]), axis=(0, 1, 4), initial=0.0))


def dissipated(dataset: xr.Dataset, case: int) -> Array:
    """Energy per cycle of each contact at `points`, (point, contact), J; rounding, 1e-12 of the largest, counts as nothing."""
    energy = along_curve(dataset, "dissipated", case)
    largest = np.max(np.nan_to_num(dataset.dissipated.values), initial=0.0)
    return np.asarray(np.where(np.abs(energy) < 1e-12 * largest, 0.0, energy))


def shares_at_peak(dataset: xr.Dataset, most: int) -> tuple[list[str], Array, Array]:
    """Energy per cycle at the highest peak of the first output: names, (case, name) in J, and total, (case,).

    Of more than `most` contacts the smaller ones are summed under "others". NaN where a case has no converged point.
    """
    energy = np.full((dataset.sizes["case"], dataset.sizes["contact"]), np.nan)
    for case in range(dataset.sizes["case"]):
        peak = highest_peak(dataset, case)
        if peak is not None:
            energy[case] = dissipated(dataset, case)[np.searchsorted(points(dataset, case), peak.point)]
    names = [str(name) for name in dataset.contact.values]
    if len(names) > most:
        order = np.argsort(-np.nansum(energy, axis=0), kind="stable")
        kept, rest = np.sort(order[: most - 1]), order[most - 1 :]
        names = [*(names[index] for index in kept), f"{rest.size} others"]
        energy = np.column_stack([energy[:, kept], energy[:, rest].sum(axis=1)])
    return names, energy, energy.sum(axis=1)
