"""Motions in time: the last period of an integration, stepped sines, a response before and after other cycles, free decays.

Contact motion and forces over a cycle, from bounds, samples or histories, per contact or summed over a surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.results.view import shown_unit, unit_for
from stickslip.show.plots.chart import Axis, Chart, Layer, Line, Panel, band, closed
from stickslip.show.plots.look import LOWER, SAMPLE, UPPER, Dash, Style, contact, entries, level, level_lines
from stickslip.show.plots.response_curves import HERTZ
from stickslip.support.checks import Array, Index, fault, nearest
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES
from stickslip.support.units import um


@dataclass(frozen=True, eq=False)
class Cycles:
    """Curves over one period: motion [m] and force [N], (curve, row, sample), of rows "CONTACT DIRECTION"."""

    rows: tuple[str, ...]
    motion: Array
    force: Array

    @property
    def phase(self) -> Array:
        """Share of the period of each sample."""
        return np.asarray(np.arange(self.force.shape[-1]) / self.force.shape[-1])

    @property
    def contacts(self) -> tuple[str, ...]:
        """Contacts that have both a first tangential and a normal direction."""
        return tuple(row[:-3] for row in self.rows if row.endswith(" t1") and f"{row[:-3]} n" in self.rows)

    def row(self, name: str) -> int:
        """The place of a row."""
        if name not in self.rows:
            raise fault("row", "must be a known one", name, nearest(name, self.rows))
        return self.rows.index(name)

    def summed(self) -> Cycles:
        """Forces summed and motions averaged over points of one surface, "left flat 1", "left flat 2", ...: "left flat"."""
        surfaces = tuple(dict.fromkeys(_surface(row) for row in self.rows))
        share = np.array([[float(_surface(row) == surface) for row in self.rows] for surface in surfaces])
        mean = share / share.sum(axis=1, keepdims=True)
        return Cycles(surfaces, *(np.einsum("sr,crt->cst", m, x) for m, x in ((mean, self.motion), (share, self.force))))


def bound_cycles(dataset: xr.Dataset, case: int = 0, frequency: float | None = None, summed: bool = False) -> Cycles:
    """The lower and the upper bound of one force level, at the frequency nearest to the given one."""
    k = 0 if frequency is None else int(np.nanargmin(np.abs(dataset["frequency"].values - frequency)))
    rows = tuple(str(name) for name in dataset["row"].values)
    cycles = Cycles(rows, dataset["contact_motion"].values[case, :, k], dataset["contact_force"].values[case, :, k])
    return cycles.summed() if summed else cycles


def sample_cycles(dataset: xr.Dataset, level: float, summed: bool = False) -> Cycles:
    """All samples of one force level at their highest peak, or at the one frequency that they were solved at."""
    cases = np.flatnonzero(np.isclose(dataset["force_level"].values, level))
    motion, force = dataset["loop_motion"].values[cases], dataset["loop_force"].values[cases]
    names = [f"{contact} {direction}" for contact in dataset["contact"].values for direction in dataset["direction"].values]
    flat = (motion.shape[0], len(names), motion.shape[-1])
    there = np.any(np.isfinite(force), axis=(0, 3)).ravel()
    rows = tuple(name for name, used in zip(names, there, strict=True) if used)
    cycles = Cycles(rows, motion.reshape(flat)[:, there], force.reshape(flat)[:, there])
    return cycles.summed() if summed else cycles


def _surface(row: str) -> str:
    """The row without the number of its point."""
    contact, _, direction = row.rpartition(" ")
    surface, _, number = contact.rpartition(" ")
    return f"{surface} {direction}" if surface and number.isdigit() else row


BOUNDS = (("lower", replace(LOWER, marker="")), ("upper", replace(UPPER, marker="")))
MOST_ROWS = 8
"""Contact rows in one figure."""
PERIOD = Axis("share of the period")


@FIGURES.of("ResponseBounds", "contact_forces")
def contact_forces(
    dataset: xr.Dataset,
    case: int = 0,
    frequency: float | None = None,
    rows: Sequence[str] | None = None,
    samples: xr.Dataset | None = None,
    summed: bool = False,
) -> Chart:
    """Contact forces over a cycle at both bounds, of the rows that differ most, at the frequency nearest to the given one.

    samples: of the same force level, drawn behind, best solved at that frequency alone; summed: over the points of a surface.
    """
    cycles = bound_cycles(dataset, case, frequency, summed)
    chosen = [cycles.row(name) for name in rows] if rows else most_different(cycles.force)
    labels = _labels(dataset, case, frequency)
    behind = None if samples is None else sample_cycles(samples, float(dataset["force_level"][case]), summed)
    panels = []
    for row in chosen:
        layers: list[Layer] = []
        if behind is not None:
            of_samples = behind.force[:, behind.row(cycles.rows[row])]
            layers += [Line(behind.phase, force, SAMPLE, "samples", listed=not k) for k, force in enumerate(of_samples)]
        layers += [Line(cycles.phase, cycles.force[bound, row], style, labels[bound]) for bound, (_, style) in enumerate(BOUNDS)]
        panels.append(Panel(PERIOD, Axis("contact force", "N"), layers, cycles.rows[row], 1.7))
    return Chart(f"Contact forces at the bounds, force {float(dataset['force_level'][case]):g}", panels, columns=2)


@FIGURES.of("ResponseBounds", "force_ratios")
def force_ratios(dataset: xr.Dataset, case: int = 0, frequency: float | None = None, summed: bool = False) -> Chart:
    """T/N over a cycle at both bounds, for every contact, or surface, with a tangential and a normal direction."""
    cycles = bound_cycles(dataset, case, frequency, summed)
    if not cycles.contacts:
        raise fault("The result", "must have contacts with a normal direction", list(cycles.rows))
    axis = Axis("ratio T/N along t1")
    panels = []
    for bound, (word, _) in enumerate(BOUNDS):
        ratios = ((name, ratio(cycles, name)[bound]) for name in cycles.contacts)
        lines = [Line(cycles.phase, values, contact(i, width=1.2), name) for i, (name, values) in enumerate(ratios)]
        panels.append(Panel(PERIOD, axis, lines, f"{word} bound", 2.9))
    return Chart(f"Ratio of friction to normal force, force {float(dataset['force_level'][case]):g}", panels, columns=2)


@FIGURES.of("ResponseBounds", "loops")
def loops(
    dataset: xr.Dataset,
    case: int = 0,
    frequency: float | None = None,
    rows: Sequence[str] | None = None,
    samples: xr.Dataset | None = None,
    summed: bool = False,
) -> Chart:
    """Hysteresis loops T against displacement at both bounds; arguments as of `contact_forces`. A stuck side is a line."""
    cycles = bound_cycles(dataset, case, frequency, summed)
    tangential = [k for k, name in enumerate(cycles.rows) if not name.endswith(" n")]
    chosen = [cycles.row(name) for name in rows] if rows else [tangential[k] for k in most_different(cycles.force[:, tangential])]
    behind = None if samples is None else sample_cycles(samples, float(dataset["force_level"][case]), summed)
    labels = _labels(dataset, case, frequency)
    panels = []
    for row in chosen:
        layers: list[Layer] = []
        if behind is not None:
            own, like = behind.row(cycles.rows[row]), Line([], [], SAMPLE, "samples")
            layers += [replace(_loop(behind, k, own, like), listed=not k) for k in range(len(behind.force))]
        layers += [_loop(cycles, bound, row, Line([], [], style, labels[bound])) for bound, (_, style) in enumerate(BOUNDS)]
        panels.append(Panel(Axis("displacement", "µm"), Axis("tangential force", "N"), layers, cycles.rows[row], 2.2))
    return Chart(f"Loops at the bounds, force {float(dataset['force_level'][case]):g}", panels, columns=2)


def ratio(cycles: Cycles, contact: str) -> Array:
    """T/N along t1, (curve, sample), NaN where the contact is open."""
    tangential, load = cycles.force[:, cycles.row(f"{contact} t1")], cycles.force[:, cycles.row(f"{contact} n")]
    closed_there = load > 1e-9 * np.nanmax(np.abs(load), initial=0.0)
    return np.asarray(np.where(closed_there, tangential / np.where(closed_there, load, 1.0), np.nan))


def most_different(force: Array) -> list[int]:
    """Rows of (curve, row, sample) whose force differs most between the curves, in their old order."""
    difference = np.nan_to_num(np.ptp(force, axis=0).max(axis=-1))
    return sorted(np.argsort(-difference, kind="stable")[:MOST_ROWS].tolist())


def _loop(cycles: Cycles, curve: int, row: int, like: Line) -> Line:
    """The closed loop of a row, with style and label of a line."""
    return replace(like, x=closed(cycles.motion[curve, row]) / um, y=closed(cycles.force[curve, row]))


def _labels(dataset: xr.Dataset, case: int, frequency: float | None) -> list[str]:
    """Both bounds with the frequencies that they are of."""
    k = 0 if frequency is None else int(np.nanargmin(np.abs(dataset["frequency"].values - frequency)))
    at = dataset["resonance"].values[case, :, k]
    return [f"{word} bound, {hertz:.1f} Hz" for (word, _), hertz in zip(BOUNDS, at, strict=True)]


MOST_LOOPS = 7
"""Contact directions whose loops are drawn: those of the largest area, then of the largest motion."""
HEIGHT = 2.9


@FIGURES.of("TimeResponse")
def last_period(dataset: xr.Dataset) -> Chart:
    """Displacement of the outputs against time, and contact force against displacement."""
    names, milliseconds = [str(name) for name in dataset["output"].values], 1e3 * dataset["time"].values
    motions = [
        Line(milliseconds, 1e6 * dataset["displacement"].values[k], level(k, len(names)), name) for k, name in enumerate(names)
    ]
    panels = [Panel(Axis("time", "ms"), Axis("displacement", "µm"), motions, "Outputs", HEIGHT)]
    loops = []
    for k, (at, direction) in enumerate(widest_loops(dataset)):
        motion, force = (dataset[f"{name}_history"].values[at, direction] for name in ("motion", "force"))
        label = f"{dataset['contact'].values[at]}, {dataset['direction'].values[direction]}"
        loops.append(Line(1e6 * closed(motion), closed(force), contact(k), label))
    if loops:
        panels.append(Panel(Axis("contact displacement", "µm"), Axis("contact force", "N"), loops, "Contacts", HEIGHT))
    where = f"{dataset.attrs['frequency']:.5g} Hz, force level {dataset.attrs['force_level']:g}"
    title = f"{dataset.attrs['title']} at {where}: last of {int(dataset['periods'])} periods"
    title += "" if dataset.attrs["outcome"] == "periodic" else f", {dataset.attrs['outcome'].replace('_', ' ')}"
    return Chart(title, panels, columns=len(panels))


def widest_loops(dataset: xr.Dataset) -> list[tuple[int, int]]:
    """(contact, direction) of the loops to draw, in the order of the contacts."""
    motion, force = dataset["motion_history"].values, dataset["force_history"].values
    size = np.nan_to_num(np.ptp(motion, axis=-1)) * np.nan_to_num(np.ptp(force, axis=-1))
    area = np.abs(np.nan_to_num(np.sum(force * np.roll(motion, -1, axis=-1) - np.roll(force, -1, axis=-1) * motion, axis=-1)))
    ranked = sorted(np.ndindex(size.shape), key=lambda place: (-area[place], -size[place]))
    return sorted(place for place in ranked[:MOST_LOOPS] if size[place] > 0.0)


@FIGURES.of("SteppedSine")
def stepped_sine(dataset: xr.Dataset) -> Chart:
    """Amplitude of the outputs over the frequency of the dwells, in their order, beside that of the harmonic balance (dashed)
    where there is one; and the distance from the steady motion."""
    names = [str(name) for name in dataset["output"].values]
    unit, f, listed = unit_for(float(dataset["amplitude"].values.max())), dataset["frequency"].values, entries(names)
    shown = [(k, name) for k, name in enumerate(names) if name in listed]

    def lines(key: str, **more: str | float) -> list[Line]:
        after = "" if key == "amplitude" else ", harmonic balance"
        values = dataset[key].values / unit.metres
        return [Line(f, values[:, k], level(k, len(names), **more), name + after) for k, name in shown]

    sizes = lines("balance_amplitude", dash="dash", width=1.1) if "balance_amplitude" in dataset else []
    distance = np.where(np.isfinite(dataset["distance"].values), dataset["distance"].values, np.nan)
    apart = Line(f, distance, level(0, 1, marker="circle", size=2.5))
    amplitude = Axis("amplitude at the end of the dwell", unit.name)
    panels = [
        Panel(HERTZ, amplitude, [*sizes, *lines("amplitude", marker="circle", size=2.5)], height=2.9),
        Panel(HERTZ, Axis("distance from the steady motion", log=True), [apart], height=1.9),
    ]
    return Chart(f"{dataset.attrs['title']}: stepped sine, {int(dataset.attrs['dwell'])} periods a step", panels, shared_x=True)


@FIGURES.of("ResponseHistory")
def before_and_after(dataset: xr.Dataset, level: float | None = None, summed: bool = False) -> Chart:
    """Contact forces over a cycle at the largest point of every run at a level: of the rows that change most.

    level: the one repeated level at which the mean forces change most, unless given; summed: over the points of a surface.
    """
    runs = repeated_runs(dataset, level)
    names = tuple(str(name) for name in dataset["row"].values)
    cycles = Cycles(names, *(dataset[f"largest_contact_{what}"].values[runs] for what in ("motion", "force")))
    cycles = cycles.summed() if summed else cycles
    change = np.ptp(cycles.force.mean(axis=-1), axis=0)
    rows = sorted(np.argsort(-change, kind="stable")[:MOST_ROWS].tolist())
    hertz = dataset["largest_frequency"].values[runs, 0]
    labels = [f"run {run + 1}, {at:.1f} Hz" for run, at in zip(runs, hertz, strict=True)]
    panels = []
    for row in rows:
        lines = [Line(cycles.phase, cycles.force[k, row], **look) for k, look in enumerate(level_lines(labels))]
        panels.append(Panel(PERIOD, Axis("contact force", "N"), lines, cycles.rows[row], 1.7))
    level = float(dataset["force_level"].values[runs[0]])
    return Chart(f"One force, {level:g}, before and after others: {dataset.attrs['title']}", panels, columns=2)


def repeated_runs(dataset: xr.Dataset, level: float | None = None) -> Index:
    """The runs at a level; of the repeated level at which the mean forces change most, unless given."""
    levels, forces = dataset["force_level"].values, dataset["largest_contact_force"].values
    repeated = [float(value) for value in np.unique(levels) if np.count_nonzero(levels == value) > 1]
    if level is None and repeated:
        level = max(repeated, key=lambda value: float(np.ptp(forces[levels == value].mean(axis=-1), axis=0).max()))
    runs = np.flatnonzero(np.isclose(levels, np.nan if level is None else level))
    if runs.size < 2:
        raise fault("level", f"must be run more than once, as {repeated} are", level)
    return np.asarray(runs, dtype=np.int64)


MODE_DASHES: tuple[Dash, ...] = ("dash", "dot", "dashdot")
"""Of nonlinear modes."""


@FIGURES.of("FreeDecay")
def decay(dataset: xr.Dataset) -> Chart:
    """Displacement of the outputs against time; frequency and damping ratio of each half cycle against its amplitude, beside
    those of nonlinear modes (dashed) where there are any."""
    names = [str(name) for name in dataset["output"].values]
    unit = unit_for(float(np.abs(dataset["displacement"].values).max(initial=0.0)))
    milliseconds, amplitude = 1e3 * dataset["time"].values, dataset["amplitude"].values / unit.metres

    def lines(name: str, factor: float) -> list[Line]:
        values = factor * dataset[name].values
        found = [Line(amplitude[k], values[k], level(k, len(names)), each) for k, each in enumerate(names)]
        found += _modes(dataset, name, unit.metres, factor)
        return found

    motion = [
        Line(milliseconds, dataset["displacement"].values[k] / unit.metres, level(k, len(names)), each)
        for k, each in enumerate(names)
    ]
    panels = [
        Panel(Axis("time", "ms"), Axis("displacement", unit.name), motion, "Outputs", HEIGHT),
        Panel(Axis("amplitude", unit.name), Axis("frequency", "Hz"), lines("frequency", 1.0), "Half cycles", HEIGHT),
        Panel(Axis("amplitude", unit.name), Axis("damping ratio", "%"), lines("damping_ratio", 100.0), "Half cycles", HEIGHT),
    ]
    return Chart(f"{dataset.attrs['title']}: free decay", panels, columns=3)


def _modes(dataset: xr.Dataset, name: str, metres: float, factor: float) -> list[Line]:
    """Frequency or damping ratio of the nonlinear modes beside a decay, over the amplitude of the first output, and the frequency
    of a phase resonance test."""
    lines = []
    for mode in range(dataset.sizes.get("mode", 0)):
        x = dataset["mode_amplitude"].values[mode, :, 0] / metres
        y = factor * dataset[f"mode_{name}"].values[mode].reshape(x.size, -1)[:, 0]
        look = Style("ink", MODE_DASHES[mode % len(MODE_DASHES)], 1.1)
        where = f", {dataset['output'].values[0]}" if dataset["mode_amplitude"].shape[-1] > 1 else ""
        lines.append(Line(x, y, look, f"nonlinear mode {int(dataset['mode'].values[mode])}{where}"))
    if name == "frequency" and "resonance_amplitude" in dataset:
        x, y = dataset["resonance_amplitude"].values / metres, factor * dataset["resonance_frequency"].values
        known = np.isfinite(x) & np.isfinite(y)
        lines.append(
            Line(x[known], y[known], Style("ink", "none", 1.1, marker="circle", size=3.0), "force and displacement at 90°")
        )
    return lines


@FIGURES.of("MeasuredDecay")
def measured(dataset: xr.Dataset) -> Chart:
    """The measured signal against time; frequency and damping ratio of its windows against the amplitude, with areas of two
    standard errors to either side."""
    unit = unit_for(float(dataset["amplitude"].values.max(initial=0.0)))
    quantity = str(dataset.attrs["quantity"])
    own = unit if quantity == "displacement" else shown_unit(dataset["signal"].attrs["units"], 1.0)
    amplitude, style = dataset["amplitude"].values / unit.metres, level(0, 1)

    def along(name: str, factor: float) -> list[Layer]:
        values, error = factor * dataset[name].values, 2.0 * factor * dataset[f"{name}_error"].values
        area = band(amplitude, values - error, values + error, level(0, 1, opacity=0.25), "two standard errors")
        return [area, Line(amplitude, values, style, "measured"), *_modes(dataset, name, unit.metres, factor)]

    signal = Line(1e3 * dataset["time"].values, dataset["signal"].values / own.metres, style, "measured")
    across = Axis("amplitude", unit.name)
    panels = [
        Panel(Axis("time", "ms"), Axis(quantity, own.name), [signal], "Signal", HEIGHT),
        Panel(across, Axis("frequency", "Hz"), along("frequency", 1.0), "Windows", HEIGHT),
        Panel(across, Axis("damping ratio", "%"), along("damping_ratio", 100.0), "Windows", HEIGHT),
    ]
    return Chart(str(dataset.attrs["title"]), panels, columns=3)
