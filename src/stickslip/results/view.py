"""Views of a dataset for figures and report: curves without padding, peaks with their points, contacts by direction.

Numbers stay in SI; only `level_text` makes words. `results_schema` says what the variables are.

Representative cases for figures, report and console: evenly spread force levels; of start states lowest, median and highest.

A figure has room for a few panels; a sentence beside it says how the cases shown were chosen.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from stickslip.results.schema import in_system, kind_words, system_of
from stickslip.solve.balance.fourier import real_harmonics
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure, Quantity, measure_of
from stickslip.support.checks import Array, Index, listed
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome
from stickslip.support.units import UnitSystem, um

ROUNDED = 4.0 * float(np.finfo(float).eps)
"""Rounding of a frequency in Hz that has been in rad/s, relative."""

SAME = 0.01
"""Share of a frequency by which a peak may lie beyond the linear resonance of its mode, from harmonics or steps of the band."""


@dataclass(frozen=True)
class Peak:
    """The highest peak of one case and output: Hz, and the point of the curve that it is.

    amplitude: by the measure of the result's peaks; max_abs: the largest value in time of the same quantity; both in its SI unit,
    never per force.
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
    """A unit to show numbers in: its size in metres (m/s, m/s²) and its name; stated: by the study, else chosen by size."""

    metres: float
    name: str
    stated: bool = False


def length_unit(*datasets: xr.Dataset) -> Length:
    """That of the study; else micrometres, or metres where amplitudes exceed a centimetre: lumped models are often stated without
    dimensions."""
    largest = max(float(np.max(np.nan_to_num(dataset.amplitude.values), initial=0.0)) for dataset in datasets)
    return shown_unit("m", largest, *datasets)


def length_text(length: float, *datasets: xr.Dataset) -> str:
    """A length with its unit, "12.3 µm"."""
    return size_text(length, "m", *datasets)


def unit_for(largest: float) -> Length:
    """Micrometres, or metres for lengths beyond a centimetre."""
    return Length(um, "µm") if largest <= 0.01 else Length(1.0, "m")


def measure_in(dataset: xr.Dataset) -> Measure:
    """What the peaks of a result are of; files that do not say are of displacement amplitudes."""
    return measure_of(*(str(dataset.attrs.get(key, default)) for key, default in DISPLACEMENT_AMPLITUDE.attributes.items()))


def periods_of(dataset: xr.Dataset) -> int:
    """Over how many periods of the excitation the motions of a result are expanded: several where subharmonics were asked for."""
    return int(dataset.attrs.get("periods", 1))


def quantity_unit(length: Length, quantity: Quantity) -> Length:
    """The unit of a quantity beside that of lengths: mm/s and m/s² beside µm, m/s and m/s² beside m, and mm/s and mm/s² where the
    study states mm."""
    if quantity.order == 0:
        return length
    if length.stated:
        return Length(length.metres, f"{length.name}/{('', 's', 's²')[quantity.order]}", True)
    small = length.metres < 1.0
    return Length(1e-3, "mm/s") if quantity.order == 1 and small else Length(1.0, ("", "m/s", "m/s²")[quantity.order])


def peak_unit(*datasets: xr.Dataset) -> Length:
    """The unit to show peaks in, of results whose peaks are of one quantity."""
    return quantity_unit(length_unit(*datasets), measure_in(datasets[0]).quantity)


def shown_unit(units: str, largest: float, *datasets: xr.Dataset) -> Length:
    """The unit to show sizes in that are kept in SI units: that of the study; else µm or m, or µm/N or m/N, by the largest, and
    others as they are."""
    return unit_in(system_of(*datasets), units, largest)


def unit_in(system: UnitSystem | None, units: str, largest: float) -> Length:
    """`shown_unit` in a system of units, or in SI without one."""
    if system is not None:
        factor, name = in_system(units.replace("s2", "s²"), system)
        return Length(1.0 / factor, name, True)
    if units.startswith(("m/s", "m/(s")):
        return Length(1.0, units.replace("s2", "s²"))
    unit = unit_for(largest)
    return Length(unit.metres, unit.name + units.removeprefix("m"))


def size_text(size: float, units: str, *datasets: xr.Dataset, digits: int = 4) -> str:
    """A size in SI with its unit, "12.3 µm", "12.3 µm/N" or "4.56 m/s²"."""
    unit = shown_unit(units, abs(size), *datasets)
    return f"{size / unit.metres:.{digits}g} {unit.name}"


def energy_unit(largest: float) -> tuple[float, str]:
    """J, mJ, µJ or nJ, the unit in which an energy has digits before the point: its size in J and its name."""
    return next((unit for unit in ((1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ")) if abs(largest) >= unit[0]), (1e-9, "nJ"))


def energy_text(value: float, *datasets: xr.Dataset) -> str:
    """An energy in the unit of the study, or with a prefix."""
    if not np.isfinite(value):
        return "–"
    factor, unit = energy_unit(value)
    if system := system_of(*datasets):
        share, unit = in_system("J", system)
        factor = 1.0 / share
    return f"{value / factor:.3g} {unit}" if value else "0 J"


def level_text(dataset: xr.Dataset, case: int) -> str:
    """The force level in words, with the kind of a curve that no sweep found, or the start state of a sample."""
    words = ", ".join(filter(None, (force_text(dataset, case), kind_words(dataset, case))))
    return f"{words}, start {int(dataset['start'][case]) + 1}" if "start" in dataset.coords else words


def force_text(dataset: xr.Dataset, case: int) -> str:
    """The force level alone: "20 N" where the dataset says that the levels are newtons, else "force × 20"."""
    level = float(dataset.force_level[case])
    factor, unit = in_system("N", system_of(dataset))
    return f"{factor * level:g} {unit}" if levels_in_newtons(dataset) else f"force × {level:g}"


def level_head(dataset: xr.Dataset) -> str:
    """The head of a column of force levels, with their unit where they are forces."""
    return "force level [N]" if levels_in_newtons(dataset) else "force level"


def levels_in_newtons(dataset: xr.Dataset) -> bool:
    return str(dataset.force_level.attrs.get("units", "1")) == "N"


def per_force_unit(dataset: xr.Dataset, otherwise: str = "") -> tuple[float, str]:
    """What a size per force level is multiplied by, and what its unit adds to that of the size: "/N"; `otherwise` where levels
    are no forces."""
    if not levels_in_newtons(dataset):
        return 1.0, otherwise
    factor, unit = in_system("1/N", system_of(dataset))
    return factor, unit.removeprefix("1")


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


def sizes(dataset: xr.Dataset, case: int, output: int, measure: Measure, at: np.ndarray) -> Array:
    """A measure of an output at points of a curve, by their indices."""
    if measure.order == 0:
        return np.asarray(dataset[measure.kind].values[case, at, output])
    omegas = 2.0 * np.pi * dataset.frequency.values[case, at]
    if measure.kind == "amplitude":
        return measure.of_harmonic(dataset.amplitude.values[case, at, output], omegas)
    parts = dataset.response.values[case, at, output]
    rows, periods = real_harmonics(parts[..., 0] + 1j * parts[..., 1]), periods_of(dataset)
    own = measure.over(periods)
    pairs = zip(rows, omegas / periods, strict=True)
    return np.array([own.size(row, omega) if np.isfinite(omega) else np.nan for row, omega in pairs])


def along_curve_as(dataset: xr.Dataset, measure: Measure, case: int, output: int) -> Array:
    """A measure of an output at `points`, NaN where the point did not converge, so that lines break there."""
    values = np.full(dataset.sizes["point"], np.nan)
    good = converged_points(dataset, case)
    values[good] = sizes(dataset, case, output, measure, good)
    return np.asarray(values[points(dataset, case)])


def in_band(dataset: xr.Dataset, case: int, points: Index) -> Index:
    """Those of some points that lie inside the band, its ends included; all of them at listed frequencies.

    A curve that folds may leave the band through its start and return: what lies outside is drawn, but is no answer.
    """
    low, high = band_of(dataset)
    hertz = dataset["frequency"].values[case, points]
    return np.asarray(points[(hertz >= (1.0 - ROUNDED) * low) & (hertz <= (1.0 + ROUNDED) * high)])


def inside_band(dataset: xr.Dataset, name: str) -> Array:
    """A variable (case, point, ...) with NaN where the point lies outside the band."""
    values = np.array(dataset[name].values, dtype=float)
    every = np.arange(values.shape[1])
    for case in range(len(values)):
        values[case, np.setdiff1d(every, in_band(dataset, case, every))] = np.nan
    return values


def outside_steps(dataset: xr.Dataset, case: int) -> np.ndarray:
    """Which steps from one of `points` to the next have an end outside the band, (points − 1,)."""
    outside = ~np.isin(points(dataset, case), in_band(dataset, case, points(dataset, case)))
    return np.asarray(outside[1:] | outside[:-1])


def split(values: Array, chosen: np.ndarray) -> tuple[Array, Array]:
    """A curve as the steps that are not chosen and those that are, NaN at points that no step of the kind reaches."""
    kept = []
    for wanted in (~chosen, chosen):
        reached = np.append(wanted, False) | np.append(False, wanted)
        kept.append(np.where(reached, values, np.nan))
    return kept[0], kept[1]


def band_of(dataset: xr.Dataset) -> tuple[float, float]:
    """The ends of the band of a response, Hz; of one at listed frequencies all there are."""
    if is_listed(dataset) or "linear_frequency" not in dataset.variables:
        return 0.0, np.inf
    hertz = dataset["linear_frequency"].values
    return float(hertz[0]), float(hertz[-1])


def highest_peak(dataset: xr.Dataset, case: int, output: int = 0) -> Peak | None:
    """The highest peak of a case; None where nothing converged."""
    candidates, measure = in_band(dataset, case, converged_points(dataset, case)), measure_in(dataset)
    amplitudes = sizes(dataset, case, output, measure, candidates)
    if not candidates.size or not np.any(np.isfinite(amplitudes)):
        return None
    solved = dataset.sizes["peak"] > 0 and bool(np.isfinite(dataset.peak_amplitude.values[case, 0, output]))
    if not solved:
        point = int(candidates[np.nanargmax(amplitudes)])
        frequency, loss_factor = (float(dataset[name].values[case, point]) for name in ("frequency", "loss_factor"))
        max_abs = float(sizes(dataset, case, output, measure.with_kind("max_abs"), np.array([point]))[0])
        return Peak(frequency, float(np.nanmax(amplitudes)), max_abs, loss_factor, point, local=False)
    names = ("peak_frequency", "peak_amplitude", "peak_max_abs", "peak_loss_factor")
    frequency, amplitude, max_abs, loss_factor = (float(dataset[name].values[case, 0, output]) for name in names)
    amplitude, max_abs = (size * measure.per(float(dataset.force_level[case])) for size in (amplitude, max_abs))
    return Peak(
        frequency, amplitude, max_abs, loss_factor, nearest_point(dataset, case, output, frequency, amplitude), local=True
    )


def peaks_outside(dataset: xr.Dataset, case: int, output: int) -> list[Peak]:
    """The peaks of a case outside its band, which do not count, highest first: points of the curve that are higher than those
    beside them, as solved peaks are."""
    solved, measure = converged_points(dataset, case), measure_in(dataset)
    size = sizes(dataset, case, output, measure, solved)
    tops = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
    tops = tops[~np.isin(solved[tops], in_band(dataset, case, solved))]
    largest = sizes(dataset, case, output, measure.with_kind("max_abs"), solved[tops])
    found = []
    for k, most in zip(tops, largest, strict=True):
        frequency, loss_factor = (float(dataset[name].values[case, solved[k]]) for name in ("frequency", "loss_factor"))
        found.append(Peak(frequency, float(size[k]), float(most), loss_factor, int(solved[k]), local=True))
    return sorted(found, key=lambda peak: -peak.amplitude)


HIGHER = 1.001
"""Ratio to the highest peak from which the end of a curve is higher."""


def is_listed(dataset: xr.Dataset) -> bool:
    """Whether responses are those at listed frequencies, without peaks between them."""
    return bool(dataset.attrs.get("listed_frequencies")) or "wanted" in dataset.variables


def higher_end(dataset: xr.Dataset, case: int, output: int = 0) -> Peak | None:
    """An end of a curve inside its band, or where it leaves that or returns, if it is higher there than its highest peak: a
    higher peak may lie beyond. None without a peak, at which `highest_peak` is the largest point already."""
    peak = highest_peak(dataset, case, output)
    if peak is None or not peak.local:
        return None
    measure, solved = measure_in(dataset), converged_points(dataset, case)
    inside = np.flatnonzero(np.isin(solved, in_band(dataset, case, solved)))
    runs = np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1)
    ends = solved[[end for run in runs for end in (run[0], run[-1])]]
    amplitudes = sizes(dataset, case, output, measure, ends)
    best = int(np.argmax(amplitudes))
    if not amplitudes[best] > HIGHER * peak.amplitude:
        return None
    point = int(ends[best])
    frequency, loss_factor = (float(dataset[name].values[case, point]) for name in ("frequency", "loss_factor"))
    max_abs = float(sizes(dataset, case, output, measure.with_kind("max_abs"), ends[[best]])[0])
    return Peak(frequency, float(amplitudes[best]), max_abs, loss_factor, point, local=False)


def highest_maximum(dataset: xr.Dataset, case: int, output: int, measure: Measure) -> tuple[float, float] | None:
    """Frequency, Hz, and size at the highest maximum of a measure: a peak where the peaks are of it, else a point of the curve
    whose neighbours are lower. None without one.
    """
    known = measure_in(dataset)
    if (measure.quantity, measure.kind) == (known.quantity, known.kind):
        peak = highest_peak(dataset, case, output)
        return (peak.frequency, peak.amplitude) if peak is not None and peak.local else None
    values = along_curve_as(dataset, measure, case, output)
    computed = points(dataset, case)
    maxima = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1
    inside = maxima[np.isin(computed[maxima], in_band(dataset, case, computed))]
    if not inside.size:
        return None
    best = int(inside[np.argmax(values[inside])])
    return float(frequencies(dataset, case)[best]), float(values[best])


def nearest_point(dataset: xr.Dataset, case: int, output: int, frequency: float, amplitude: float) -> int:
    """The converged point of a curve that stands nearest to a place on it, by the measure of its peaks (not per force); a peak
    is a point itself.
    """
    candidates = converged_points(dataset, case)
    amplitudes = sizes(dataset, case, output, measure_in(dataset), candidates)
    distance = np.abs(dataset.frequency.values[case, candidates] / frequency - 1.0) + np.abs(amplitudes / amplitude - 1.0)
    return int(candidates[np.nanargmin(distance)])


def has_linear_curves(dataset: xr.Dataset) -> bool:
    """Whether the curves without contacts and with stuck ones are known: not where loads excite several harmonics and peaks are
    not of the first one."""
    return any(bool(dataset[f"{which}_amplitude"].notnull().any()) for which in ("free", "stuck"))


def linear_peak(
    dataset: xr.Dataset, which: str, case: int, frequency: float, output: int = 0, amplitude: float = 0.0
) -> tuple[float, float] | None:
    """Frequency, Hz, and size of the resonance of the "free" or "stuck" curve that belongs to a peak at a frequency, as the peaks
    are measured but of the first harmonic alone; None where the band holds none.

    A contact that slips is softer than a stuck one and stiffer than none: the peak lies below its resonance with stuck contacts
    and above the one without. Of several maxima it is the next one on that side, or the nearest where that side has none.
    Friction takes energy, so the resonance is hardly lower than the peak: maxima below half of its amplitude, of modes that the
    forces hardly excite, count only where there are no others, nor natural frequencies beyond the band on that side.
    """
    hertz = dataset.linear_frequency.values
    size = measure_in(dataset).of_harmonic(dataset[f"{which}_amplitude"].values[case, :, output], 2.0 * np.pi * hertz)
    maxima = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
    if not maxima.size:
        return None
    side = 1.0 if which == "stuck" else -1.0
    beyond = maxima[side * (hertz[maxima] - frequency) > -SAME * frequency]
    candidates = beyond if beyond.size else maxima
    high = [maxima[size[maxima] >= 0.5 * amplitude] for maxima in (candidates, maxima)]
    candidates = next((maxima for maxima in high if maxima.size), candidates)
    name, low = f"natural_frequency_{which}", 0.0 if which == "free" else hertz.max()
    natural = dataset[name].values if name in dataset else np.zeros(0)
    outside = (natural > low) & ((natural < hertz.min()) | (which == "stuck"))
    if not any(some.size for some in high) and np.any(outside):
        return None  # its resonance is one of these
    best = int(candidates[np.argmin(np.abs(hertz[candidates] - frequency))])
    return float(hertz[best]), float(size[best])


def contact_rows(dataset: xr.Dataset) -> list[ContactRow]:
    """The tangential directions in which each contact moves; the normal one where it has no other.

    A direction that moves by less than 1e-9 of the largest motion is at rest but for rounding: it is left out, unless it is
    the only one of its contact.
    """
    directions = [str(name) for name in dataset.direction.values]
    parts = np.nan_to_num(dataset.contact_motion.values[:, :, :, :, 1:])  # without the mean
    motion = np.max(np.hypot(parts[..., 0], parts[..., 1]), axis=(0, 1, 4), initial=0.0)
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


def dissipated(dataset: xr.Dataset, case: int) -> Array:
    """Energy per period of each contact at `points`, (point, contact), J; rounding, 1e-12 of the largest, counts as nothing."""
    energy = along_curve(dataset, "dissipated", case)
    largest = np.max(np.nan_to_num(dataset.dissipated.values), initial=0.0)
    return np.asarray(np.where(np.abs(energy) < 1e-12 * largest, 0.0, energy))


def shares_at_peak(dataset: xr.Dataset, most: int) -> tuple[list[str], Array, Array]:
    """Energy per period at the highest peak of the first output: names, (case, name) in J, and total, (case,).

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


REPRESENTATIVE = ("lowest", "median", "highest")
"""Start states of one force level that stand for all, by their highest peaks."""


@dataclass(frozen=True, eq=False)
class Representatives:
    """The cases to show, also as a dataset of their own, and a sentence about the others; empty where there are none."""

    dataset: xr.Dataset
    cases: list[int]
    words: str


def spread(count: int, most: int) -> list[int]:
    """At most `most` places of `count`, evenly spread from the first to the last; a single one is the last."""
    return sorted({round(place) for place in np.linspace(count - 1, 0, min(count, most)).tolist()})


def is_cloud(dataset: xr.Dataset) -> bool:
    """Whether the cases are start states, several to a force level."""
    return "start" in dataset.coords


def levels_of(dataset: xr.Dataset) -> list[list[int]]:
    """The cases of each force level of a cloud; otherwise every case is a level of its own."""
    if not is_cloud(dataset):
        return [[case] for case in range(dataset.sizes["case"])]
    values = dataset["force_level"].values.tolist()
    return [[case for case, value in enumerate(values) if value == level] for level in dict.fromkeys(values)]


def ranked(dataset: xr.Dataset, cases: list[int], output: int = 0) -> list[int]:
    """Those of the cases that have a solution, by their highest peak, lowest first."""
    peaks = {case: highest_peak(dataset, case, output) for case in cases}
    sizes = {case: peak.amplitude for case, peak in peaks.items() if peak is not None}
    return sorted(sizes, key=lambda case: sizes[case])


def representative_starts(dataset: xr.Dataset, cases: list[int], most: int = len(REPRESENTATIVE)) -> list[int]:
    """Of start states of one level those of lowest, median and highest peak, in this order."""
    order = ranked(dataset, cases) or cases[:1]
    return [order[place] for place in spread(len(order), min(most, len(REPRESENTATIVE)))]


def words_of(chosen: list[int]) -> list[str]:
    """What each of the cases that `representative_starts` gives is."""
    return [REPRESENTATIVE[place] for place in spread(len(REPRESENTATIVE), len(chosen))]


def chosen_levels(dataset: xr.Dataset, most: int) -> list[int]:
    """At most `most` places of `levels_of`, evenly spread, and among them that of the largest response."""
    groups = levels_of(dataset)
    places = spread(len(groups), most)
    sizes = [np.nan_to_num(dataset["amplitude"].values[cases]).max(initial=0.0) for cases in groups]
    highest = int(np.argmax(sizes))
    nearest = min(places, key=lambda place: abs(place - highest))
    return sorted({*places} - {nearest} | {highest})


def representatives(dataset: xr.Dataset, most: int) -> Representatives:
    """At most `most` cases: all, or those of `chosen_levels`, of a cloud three start states of each."""
    groups = levels_of(dataset)
    if dataset.sizes["case"] <= most:
        return Representatives(dataset, list(range(dataset.sizes["case"])), "")
    cloud = is_cloud(dataset)
    levels = chosen_levels(dataset, max(1, most // len(REPRESENTATIVE)) if cloud else most)
    chosen = partial(representative_starts, dataset, most=most) if cloud else list
    kept = [case for level in levels for case in chosen(groups[level])]
    fewer = f"{len(levels)} of {len(groups)} force levels" if len(levels) < len(groups) else ""
    return Representatives(dataset.isel(case=kept), kept, "; ".join(filter(None, (cloud_words(dataset, most), fewer))))


def cloud_words(dataset: xr.Dataset, most: int = len(REPRESENTATIVE)) -> str:
    """What `representative_starts` takes, in words; empty without start states."""
    if not is_cloud(dataset):
        return ""
    names = words_of(list(range(min(most, len(REPRESENTATIVE)))))
    starts = max(len(cases) for cases in levels_of(dataset))
    return f"of {starts} start states those with the {listed(names)} response"
