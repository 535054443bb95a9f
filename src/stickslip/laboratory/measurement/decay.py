"""Measured decays: amplitude, frequency and damping ratio along a ring-down test, each with its standard error.

Record and file are checked here; `decay_windows.py` fits the windows.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.signal import fftconvolve

from stickslip.analyses.controlled_response import PhaseResonance
from stickslip.analyses.free_decay import beside_modes, beside_phase_resonance
from stickslip.analyses.modes.nonlinear_modes import NonlinearModes
from stickslip.analyses.settings import output_of
from stickslip.laboratory.measurement import number_table
from stickslip.laboratory.measurement.decay_windows import Record, Window, fitted_windows
from stickslip.laboratory.measurement.matlab_columns import response_columns
from stickslip.laboratory.measurement.records import LONGEST_CLIP, longest_run
from stickslip.laboratory.measurement.sensors import summed
from stickslip.laboratory.measurement.universal_file import is_universal
from stickslip.laboratory.measurement.universal_response import time_history
from stickslip.results.files import SavedResult
from stickslip.results.schema import named, tabulated
from stickslip.support.checks import Array, InputError, among, existing, fault, finite, listed, of_kind, positive, vector
from stickslip.support.late import xr
from stickslip.support.units import Band

FEWEST = 8
"""Samples of a cycle at least."""

LEAST = 3.0
"""Cycles from the beginning of a decay on, of which two windows need as many at least."""

EVEN = 1e-3
"""Relative deviation of the time steps up to which a record counts as evenly sampled."""

WORDS = {
    "time": ("time", "t"),
    "signal": (
        "signal",
        "displacement",
        "velocity",
        "acceleration",
        "response",
        "amplitude",
        "disp",
        "vel",
        "acc",
        "x",
        "a",
        "v",
    ),
}
"""Titles of columns, in lower case."""


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredDecay(SavedResult):
    """`dataset`: signal (time) in m, m/s or m/s² by the attribute `quantity`; along `window`, at its middle window_time [s]:
    amplitude [m] of the displacement, frequency [Hz] and damping_ratio, each with its standard error `_error`; nonlinear modes
    beside it as of `FreeDecay`."""

    dataset: "xr.Dataset"

    def with_modes(self, modes: NonlinearModes, output: int = 0) -> "MeasuredDecay":
        """A copy that holds computed nonlinear modes too, at the output that was measured, for its figure."""
        of_kind("modes", modes, NonlinearModes)
        number = output_of(modes.problem, output)
        return replace(self, dataset=beside_modes(self.dataset, modes.with_decays().dataset.isel(output=[number])))

    def with_phase_resonance(self, test: PhaseResonance) -> "MeasuredDecay":
        """A copy that holds the frequencies of a computed phase resonance test too, for its figure."""
        return replace(self, dataset=beside_phase_resonance(self.dataset, of_kind("test", test, PhaseResonance).dataset))


def measured_decay(
    time: ArrayLike,
    signal: ArrayLike,
    quantity: str = "displacement",
    *,
    band: tuple[float, float] | Band | None = None,
    cycles: float | None = None,
    begin: float | None = None,
    name: str = "",
) -> "MeasuredDecay":
    """Amplitude, frequency and damping of a measured decay, (n,) samples at even times, s, of a displacement, velocity or
    acceleration in m, m/s or m/s²; (n, sensors) of several, evaluated together with the amplitude at the first.

    The decay begins at the largest motion near its frequency from the time `begin` [s] on, a motion that grows at `begin`; use it
    to exclude a blow. Damped sines
    are fitted to windows of `cycles`, unless given of the length whose errors are smallest, until the amplitude is below five
    standard errors, or friction stops the motion. band [Hz]: in which the frequency is looked for. The standard errors count all
    that else is in the record, noise, hum, a suspension and other modes, by its spectrum and by what the fit lets through; a
    second mode in the band is fitted too. Amplitude and damping ratio are those of the displacement, whatever was measured: A/ω
    of a velocity, A/ω² of an acceleration, ζ = δ/√(δ² + ω²) with the decay δ of this amplitude.
    """
    among("quantity", quantity, number_table.MOTIONS)
    t = vector("time", time)
    each = np.transpose(signal) if np.ndim(signal) == 2 else [signal]
    signals = np.column_stack([vector("signal", one, t.size) for one in each])
    x, step = signals[:, 0], _step(t)
    low, high = (0.0, 0.5 / step) if band is None else _ends(band)
    if cycles is not None and not 0.5 <= positive("cycles", cycles) <= 200.0:
        raise fault("cycles", "must be from 0.5 to 200", cycles)
    after = 0 if begin is None else int(np.searchsorted(t, finite("begin", begin)))
    if t.size - after < 4 * FEWEST:
        raise fault("begin", f"must leave {4 * FEWEST} samples at least", begin, f"The record ends at {t[-1]:g} s.")
    hertz = _dominant(x[after:] - x[after:].mean(), step, (low, high))
    first = after + _largest(x[after:], step, hertz)
    if begin is not None and (t.size - first) * step * hertz < LEAST:  # a motion that grows
        first = after
    if (t.size - first) * step * hertz < LEAST:
        where, remedy = f"{t.size - first} samples from its end on", "Is it a free decay, in the order of time?"
        raise fault(f"The largest motion of the {quantity}", f"must have {LEAST:g} cycles after it", where, remedy)
    omega = 2.0 * np.pi * _dominant(x[first:] - x[first:].mean(), step, (low, high))
    if 2.0 * np.pi / (omega * step) < FEWEST:
        raise fault("The samples of a cycle", f"must be {FEWEST} at least", 2.0 * np.pi / (omega * step), "Sample faster.")
    for one in signals.T:
        _refuse_plateau(t[after:], one[after:], 2.0 * np.pi / (omega * step))
    ends = 2.0 * np.pi * low, 2.0 * np.pi * high
    levels = np.unique(x)
    resolution = float(np.diff(levels).min()) if 1 < levels.size < 0.5 * x.size else 0.0  # of samples that are quantised
    record = Record(t, x, number_table.MOTIONS.index(quantity), first, ends, resolution)
    record, sensors = (record, None) if signals.shape[1] == 1 else summed(signals, record, omega)
    windows = fitted_windows(record, omega, cycles)
    if len(windows) < 2:
        remedy = (
            "Leave out a blow at the beginning (begin, --begin), give the band of one mode (band, --band), or take longer "
            "windows (cycles=10, --cycles 10)."
        )
        what = f"A decay near {omega / (2.0 * np.pi):.4g} Hz"
        of = "" if cycles is None else f" of {cycles:g} cycles"
        raise fault(what, f"must have two windows{of} that a damped sine fits", len(windows), remedy)
    dataset = _dataset(record, windows, quantity, name)
    if sensors is not None:
        share = max(sensors.error[0], sensors.change[0] if sensors.change[0] > 6.0 * sensors.error[0] else 0.0)
        dataset["amplitude_error"][:] = np.hypot(dataset["amplitude_error"], share * dataset["amplitude"])
        dataset.attrs["sensors"] = sensors.sentence()
    return MeasuredDecay(dataset)


def _largest(x: Array, step: float, hertz: float) -> int:
    """The sample with which a decay at a frequency begins: the largest of all, or where that is not near the largest motion at
    this frequency, as a blow is not, the sample where three cycles move most."""
    count = min(round(3.0 / (hertz * step)), x.size)
    moving = x - x.mean()
    around = np.hanning(count + 2)[1:-1] * np.exp(2j * np.pi * hertz * step * np.arange(count))
    best, largest = int(np.argmax(np.abs(fftconvolve(moving, around, "same")))), int(np.argmax(np.abs(moving)))
    return largest if best - count <= largest <= best else best


def _refuse_plateau(t: Array, x: Array, cycle: float) -> None:
    """A signal that is clipped, or held before its release, keeps its extreme value for more samples than the top of a sine of
    `cycle` samples does at its resolution: there A (1 − cos φ) is below one step of the resolution along 2 φ."""
    levels = np.unique(x)
    half = 0.5 * (levels[-1] - levels[0])
    top = cycle / np.pi * np.arccos(1.0 - min(np.diff(levels).min() / half, 2.0)) if levels.size > 1 else np.inf
    at_ends = [x == extreme for extreme in (levels[0], levels[-1])]
    longest = max(map(longest_run, at_ends))
    if longest >= LONGEST_CLIP and longest > 2.0 * top + 1.0:
        last = t[np.flatnonzero(at_ends[0] | at_ends[1])[-1]]
        remedy = f"If it is clipped, choose a larger range; the decay after {last:.6g} s can be evaluated (begin, --begin)."
        raise fault("The signal", "must not stay at its extreme value", f"{longest} samples in a row", remedy)


def read_decay(
    path: str | Path,
    *,
    columns: Mapping[str, str | int | Sequence[str | int]] | None = None,
    units: Mapping[str, str] | None = None,
    quantity: str | None = None,
    **settings: Any,
) -> "MeasuredDecay":
    """A decay from a text file with a title for each column, "time [s], acceleration [m/s2]", from vectors or structs of a MATLAB
    file (.mat), or from a time history of a universal file (58, 58b).

    columns: {"time" or "signal": title or number (from 1) of the column} where titles are not understood; in the other files
    "signal" is the name or number of a vector or function. Several signals, "signal": [2, 3], are sensors of one quantity that
    are evaluated together. units: {the same names: unit} where the file states none; default: s, and m, m/s or m/s² for the
    quantity. quantity: by default as title or unit state. Further arguments are those of `measured_decay`.
    """
    if not isinstance(path, str | Path):
        raise fault("path", "must be the name of a file", path)
    path = Path(path)
    columns, units = (dict(of_kind(what, given or {}, Mapping)) for what, given in (("columns", columns), ("units", units)))  # type: ignore[type-abstract]
    for name in settings:
        among("A setting", name, ("band", "cycles", "begin", "name"))
    existing("path", [path])
    for what, given in (("columns", columns), ("units", units)):
        for key in given:
            among(what, key, WORDS)
    if quantity is not None:
        among("quantity", quantity, number_table.MOTIONS)
    which = columns.get("signal")
    signals = [which] if which is None or isinstance(which, str | int) else list(which)
    if not signals:
        raise fault("columns", "must name a signal", columns)
    found = [_sampled(path, columns | ({} if one is None else {"signal": one}), dict(units), quantity) for one in signals]
    for t, _, moved in found[1:]:
        if moved != found[0][2] or not np.array_equal(t, found[0][0]):
            quantities = listed([each[2] for each in found])
            raise fault(f"The sensors of {path.name}", "must have one quantity and the same times", quantities)
    return measured_decay(found[0][0], np.column_stack([x for _, x, _ in found]), found[0][2], **{"name": path.stem, **settings})


def _sampled(path: Path, columns: dict[str, Any], units: dict[str, str], quantity: str | None) -> tuple[Array, Array, str]:
    """Times, s, samples in SI and the quantity of one signal of a file."""
    if is_universal(path):
        table, columns = time_history(path, columns.get("signal"), quantity, units.pop("signal", None)), {}
    elif path.suffix.lower() == ".mat":
        table, columns = response_columns(path.name, number_table.matlab_arrays([path])[0], columns, "signal")
    else:
        table = number_table.text_table(path, lambda title: any(title.lower() in words for words in WORDS.values()))
    at = _columns(table, columns)
    title = (table.titles[at["signal"]] if table.titles else "").lower()
    stated = units.get("signal") or table.units[at["signal"]] or ""
    unit = number_table.response_unit(stated) if stated else None
    if quantity is None:
        named = [motion for motion in number_table.MOTIONS if title and motion.startswith(title[:3]) and len(title) > 2]
        quantity = unit.kind if unit is not None and unit.kind in number_table.MOTIONS else named[0] if named else None
    if quantity is None:
        remedy = "Give it: quantity='acceleration' (--quantity acceleration)."
        raise fault(f"The quantity of {path.name}", "must be stated by title or unit", title or "none", remedy)
    factor = number_table.known_unit(f"The unit of the signal in {path.name}", stated, (quantity,)).factor if stated else 1.0
    if unit is not None and unit.per_force:
        raise fault(f"The unit of the signal in {path.name}", "must be that of a motion, not of a motion per force", stated)
    text = units.get("time") or table.units[at["time"]] or "s"
    if text not in number_table.UNITS or number_table.UNITS[text][0] != "s":
        raise fault(f"The unit of time in {path.name}", "must be one of s, ms, us, min", text)
    t, x = number_table.UNITS[text][1] * table.numbers[:, at["time"]], factor * table.numbers[:, at["signal"]]
    return t, x, quantity


def _ends(band: tuple[float, float] | Band) -> tuple[float, float]:
    """The ends of a band, Hz."""
    low, high = (band.low, band.high) if isinstance(band, Band) else vector("band", band, 2)
    if not 0.0 <= low < high:
        raise fault("band", "must be (low, high) in Hz with low below high", band)
    return float(low), float(high)


def _columns(table: number_table.NumberTable, chosen: Mapping[str, str | int]) -> dict[str, int]:
    """The numbers of the columns of time and signal: as chosen, by their titles, or the first and the second of two."""
    found: dict[str, int] = {}
    titles = [title.strip().lower() for title in table.titles or ()]
    for key, words in WORDS.items():
        fitting = [k for k, title in enumerate(titles) if title in words]
        if key in chosen:
            found[key] = number_table.named_column(table, key, chosen[key])
        elif len(fitting) == 1:
            found[key] = fitting[0]
    if len(found) < 2 and table.numbers.shape[1] == 2:
        found = {"time": 1 - found["signal"] if "signal" in found else 0} | found
        found = {"signal": 1 - found["time"]} | found
    for key in WORDS:
        if key not in found:
            remedy = f"Give it: columns={{'{key}': 2}} (--column {key}=2)"
            remedy += ", or several for several sensors." if key == "signal" else "."
            raise fault(
                f"The column of the {key} in {table.name}", "must be known", ", ".join(table.titles or ()) or "none", remedy
            )
    if found["time"] == found["signal"]:
        raise fault(f"Time and signal in {table.name}", "must be two columns", found["time"] + 1)
    return found


def _step(t: Array) -> float:
    """The even step of a time."""
    if t.size < 4 * FEWEST:
        raise fault("time", f"must hold {4 * FEWEST} samples at least", t.size)
    steps = np.diff(t)
    step = float(t[-1] - t[0]) / (t.size - 1)
    last = _last_digits(t)
    rounded = np.abs(t - t[0] - step * np.arange(t.size)) <= 0.5 * (last + last[0] + last[-1])
    uneven = np.std(steps) > EVEN * step and not np.all(rounded)
    if not step > 0.0 or np.abs(steps - step).max() > 0.5 * step or uneven:
        worst = float(steps[np.argmax(np.abs(steps - step))])
        raise fault("The steps of time", "must be even and positive", worst, "Resample the record.")
    return step


def _last_digits(t: Array) -> Array:
    """The units (n,) of the last digits of times as they were printed, with some significant digits or some decimals, or stored
    in single precision; 0 where they are none of these."""
    powers = np.floor(np.log10(np.abs(t), where=t != 0.0, out=np.zeros_like(t))) + 1.0
    units = np.zeros_like(t)
    for exponents in ((powers - digits for digits in range(3, 13)), (np.full_like(t, -digits) for digits in range(1, 10))):
        for exponent in exponents:
            unit = 10.0**exponent
            if np.all(np.abs(t - unit * np.round(t / unit)) <= 1e-3 * unit + 4.0 * np.spacing(np.abs(t))):
                units = np.maximum(units, unit)
                break
    with np.errstate(over="ignore"):
        single = t.astype(np.float32)
    return np.maximum(units, np.abs(np.spacing(single))) if np.all(single == t) else units


def _dominant(x: Array, step: float, band: tuple[float, float]) -> float:
    """The frequency of the largest line of the spectrum in a band, Hz."""
    size = 2 * x.size
    spectrum = np.abs(np.fft.rfft(x * np.hanning(2 * x.size)[x.size :], size))
    hertz = np.fft.rfftfreq(size, step)
    inside = np.flatnonzero((hertz >= band[0]) & (hertz <= band[1]) & (hertz > 0.0))
    if not inside.size or not spectrum[inside].max() > 0.0:
        raise InputError(f"The signal must move between {band[0]:g} and {band[1]:g} Hz, but does not. Widen the band.")
    return float(hertz[inside[np.argmax(spectrum[inside])]])


def _dataset(record: Record, windows: Sequence[Window], quantity: str, name: str) -> "xr.Dataset":
    order = record.order
    middle, size, omega, delta = (
        np.array([getattr(each, key) for each in windows]) for key in ("middle", "amplitude", "omega", "delta")
    )
    size_error, omega_error, delta_error = np.array([each.errors for each in windows]).T
    data = {
        "window_time": middle,
        "amplitude": size / omega**order,
        "amplitude_error": size_error / omega**order,
        "frequency": omega / (2.0 * np.pi),
        "frequency_error": omega_error / (2.0 * np.pi),
        "damping_ratio": delta / np.hypot(delta, omega),
        "damping_ratio_error": delta_error / np.hypot(delta, omega),
    }
    signal = named("time", record.x, f"measured {quantity}", ("m", "m/s", "m/s2")[order])
    length = float(windows[0].motion.size * record.step * omega[0] / (2.0 * np.pi))
    others = {"window_cycles": length, "second_mode": float(windows[0].second / (2.0 * np.pi))}
    about = {"title": name or "Measured decay", "quantity": quantity, **others}
    return tabulated("measured_decay", data, {"time": record.t}, about).assign(signal=signal)
