"""Resonance peaks along any parameter of a problem: force, preload, friction, stiffness, or several scaled together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.response_dataset import levels_are_newtons
from stickslip.analyses.settings import ends_of, fineness_of, made, maker, output_of
from stickslip.model.problem import Problem
from stickslip.runs.work import Progress
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import measure_of
from stickslip.solve.peaks.continuation import ContinuedPeaks, Event, PeakContinuation
from stickslip.support.checks import between, fault, positive, vector
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.units import Band


@dataclass(frozen=True, eq=False)
class PeakPath:
    """`dataset`: frequency and frequency_width (middle and half of the band within 0.1 % of the peak), amplitude and on_kink of
    every peak, axes (value, branch), NaN where a peak is not there; highest (value,); events: what happened to peaks, each with
    the values between which it did. The attributes quantity and measure say what `amplitude` is of.
    """

    dataset: xr.Dataset
    events: tuple[Event, ...]


def follow_peaks(
    problem_of: Callable[[float], Problem],
    values: ArrayLike,
    band: Band,
    force: float | Callable[[float], float] = 1.0,
    *,
    output: int = 0,
    quantity: str = "displacement",
    measure: str = "amplitude",
    check_every: int = 10,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> PeakPath:
    """All peaks over a band as a parameter goes through `values`, in this order; begin where contacts stick.

    problem_of(value) is the problem of a value: one function may change several things at once. force: its force level, or
    force(value). quantity, measure: what they are peaks of, as for `forced_response`. Every `check_every` values a full sweep
    looks for peaks born on the way. Peaks are solved as R = 0 with a stationary amplitude along the curve; one on a kink has
    one-sided slopes only and is marked.
    """
    chosen = vector("values", values)
    if chosen.size == 0 or np.unique(chosen).size < chosen.size:
        raise fault("values", "must be different and at least one", chosen.tolist())
    every, (low, high), fineness = between("check_every", check_every, 1), ends_of(band), fineness_of(harmonics, samples)
    make = maker("problem_of", problem_of)
    row, size = output_of(made(make, float(chosen[0])), output), measure_of(quantity, measure)
    known: dict[float, tuple[HarmonicBalance, float]] = {}

    def balance_and_level(value: float) -> tuple[HarmonicBalance, float]:
        if value not in known:
            level = force(value) if callable(force) else force
            known[value] = HarmonicBalance(made(make, value), *fineness), positive("force", level)
        return known[value]

    with one_blas_thread():
        continuation = PeakContinuation(balance_and_level, (2.0 * np.pi * low, 2.0 * np.pi * high), row, size)
        found = continuation.follow(chosen.tolist(), every, lambda fraction: progress(fraction, "following peaks"))
        dataset = _dataset(continuation, found)
    return PeakPath(dataset, tuple(found.events))


def _dataset(continuation: PeakContinuation, found: ContinuedPeaks) -> xr.Dataset:
    shape, measure = (len(found.values), len(found.branches)), continuation.measure
    arrays = {name: np.full(shape, np.nan) for name in ("frequency", "amplitude", "frequency_width", "on_kink")}
    for b, branch in enumerate(found.branches):
        for k, value in enumerate(found.values):
            if value in branch.places:
                branch.places[value], peak_band = continuation.settled(branch.places[value])
                peak = branch.places[value].peak
                amplitude = peak.amplitude / measure.per(peak.point.level)
                row = (peak_band.omega / (2.0 * np.pi), amplitude, peak_band.width / (2.0 * np.pi), float(peak.on_kink))
                for name, number in zip(arrays, row, strict=True):
                    arrays[name][k, b] = number
    newtons = levels_are_newtons(continuation.problem_of(found.values[0])[0].problem)
    units = {"frequency": "Hz", "amplitude": measure.reported_units(newtons), "frequency_width": "Hz", "on_kink": "1"}
    data = {name: (("value", "branch"), array, {"units": units[name]}) for name, array in arrays.items()}
    highest = [place[0] if (place := found.highest(value)) is not None else -1 for value in found.values]
    attrs: dict[str, Any] = {"solves": found.solves, "iterations": found.iterations}
    attrs |= {"check_points": sum(c.points for c in found.checks), **measure.attributes}
    return xr.Dataset(data | {"highest": ("value", highest)}, {"value": list(found.values)}, attrs)
