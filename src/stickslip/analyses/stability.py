"""Stability of the points of a forced response, and where and how it changes along the curves."""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip.analyses.solved_points import SolvedPoints
from stickslip.checks import Array, positive
from stickslip.disks.tuned import TunedDisk
from stickslip.harmonic.balance import Evaluation, HarmonicBalance, Point
from stickslip.harmonic.fourier import complex_harmonics, real_harmonics
from stickslip.outcome import Outcome
from stickslip.problem import Problem
from stickslip.results.view import measure_in, nearest_point
from stickslip.stability.multipliers import TIMES_ERROR, Multipliers, PeriodMap, Stability

if TYPE_CHECKING:
    import xarray as xr

REAL = 1e-6
"""Imaginary part of a multiplier, relative to its size, below which it is real."""


KEPT = 8.0
"""Modes up to so many times the highest harmonic of the highest frequency move by themselves, unless `highest` is given."""


class Instability(IntEnum):
    """How stability changes along a curve."""

    NONE = 0
    FOLD = 1
    BRANCH_POINT = 2
    PERIOD_DOUBLING = 3
    NEIMARK_SACKER = 4


class AllSectors:
    """The solved points of a tuned disk with all its sectors, which a disturbance need not leave alike."""

    def __init__(self, points: SolvedPoints, disk: TunedDisk) -> None:
        self.points, self.disk = points, disk
        harmonics, samples = points.balance.harmonics, points.balance.tables.E.shape[0]
        self.balance = HarmonicBalance(disk.full(reported=[1]), harmonics, samples)

    def evaluation(self, case: int, point: int) -> Evaluation:
        """A point of the full disk: sector j is late by j EO/N periods."""
        one = self.points.point(case, point)
        forces = complex_harmonics(one.forces)
        late = -2j * np.pi * self.disk.engine_order / self.disk.sectors * np.arange(forces.shape[1])
        turned = [real_harmonics(forces * np.exp(j * late)) for j in range(self.disk.sectors)]
        return self.balance.evaluate(Point(np.concatenate(turned), one.omega, one.level))


class Change(NamedTuple):
    """Where the largest multiplier crosses the unit circle: frequency [Hz] and kind."""

    frequency: float
    kind: Instability


def with_stability(dataset: xr.Dataset, problem: Problem, highest: float | None = None) -> xr.Dataset:
    """A forced response with the stability of every converged point.

    `stability`, `multiplier` (the largest, real and imaginary part), `multiplier_error`, `stuck_sliders` (case, point, ...);
    `peak_stability` (case, peak, output); `stability_change` and its frequency (case, change).

    highest: natural frequency in Hz up to which modes move by themselves. Unless it is given, those below eight times the highest
    harmonic; what the others change is found where the largest multiplier is nearest to the unit circle, and points that might
    change sides are solved with all. A tuned disk is disturbed in all its sectors.
    """
    solved = SolvedPoints(dataset, problem)
    points = AllSectors(solved, problem) if isinstance(problem, TunedDisk) else solved
    converged = [(int(case), int(point)) for case, point in np.argwhere(dataset["outcome"].values == Outcome.CONVERGED)]
    with threadpool_limits(1, user_api="blas"):
        map_ = PeriodMap(points.balance, _highest(dataset, points, highest))
        found = {place: map_.multipliers(points.evaluation(*place)) for place in converged}
        error = 0.0
        if highest is None and map_.modes.dropped and converged:
            error = _with_all_modes(points, found)
    values = _of_points(dataset, found, error)
    changes = [_changes(dataset, values, case) for case in range(dataset.sizes["case"])]
    if dataset.attrs.get("listed_frequencies"):
        changes = [[] for _ in changes]
    return dataset.assign(_variables(dataset, values, changes)).assign_attrs(
        stability_dropped_modes=map_.modes.dropped, stability_mode_error=error
    )


def _highest(dataset: xr.Dataset, points: SolvedPoints | AllSectors, highest: float | None) -> float:
    """The largest natural frequency of modes that move by themselves, rad/s."""
    if highest is None:
        return 2.0 * np.pi * KEPT * points.balance.highest * float(np.nanmax(dataset["frequency"].values, initial=0.0))
    return np.inf if highest == np.inf else 2.0 * np.pi * positive("highest", highest)


def _with_all_modes(points: SolvedPoints | AllSectors, found: dict[tuple[int, int], Multipliers]) -> float:
    """What the modes left out change of the multiplier nearest to the unit circle; points that might change sides are solved anew
    with all modes."""
    whole = PeriodMap(points.balance)
    nearest = min(found, key=lambda place: _distance(found[place]))
    again = whole.multipliers(points.evaluation(*nearest))
    error = abs(abs(again.leading) - abs(found[nearest].leading))
    for place in [place for place, each in found.items() if _distance(each) <= TIMES_ERROR * error]:
        found[place] = whole.multipliers(points.evaluation(*place))
    return float(error)


def _distance(multipliers: Multipliers) -> float:
    """Distance of the largest multiplier from the unit circle."""
    return abs(abs(multipliers.leading) - 1.0)


def _of_points(dataset: xr.Dataset, multipliers: dict[tuple[int, int], Multipliers], error: float) -> dict[str, Any]:
    """Arrays (case, point); error: of the modes left out."""
    shape = dataset["outcome"].shape
    found: dict[str, Any] = {
        "stability": np.zeros(shape, dtype=np.int8),
        "multiplier": np.full(shape, np.nan, dtype=complex),
        "multiplier_error": np.full(shape, np.nan),
        "stuck_sliders": np.zeros(shape, dtype=np.int64),
    }
    for place, each in multipliers.items():
        found["stability"][place], found["multiplier"][place] = each.verdict, each.leading
        found["multiplier_error"][place], found["stuck_sliders"][place] = max(each.error, error), each.exact_ones
    return found


def _changes(dataset: xr.Dataset, values: dict[str, Any], case: int) -> list[Change]:
    """The changes along a curve, in the order of travel."""
    converged = np.flatnonzero(dataset["outcome"].values[case] == Outcome.CONVERGED)
    frequency, multiplier = dataset["frequency"].values[case, converged], values["multiplier"][case, converged]
    return [Change(*change) for change in _crossings(frequency, multiplier)]


def _crossings(frequency: Array, multiplier: Any) -> Iterator[tuple[float, Instability]]:
    """Between each two points on different sides of the unit circle: where their sizes, taken as linear, are 1, and the kind."""
    size = np.abs(multiplier)
    for k in np.flatnonzero((size[1:] > 1.0) != (size[:-1] > 1.0)):
        share = (1.0 - size[k]) / (size[k + 1] - size[k])
        outside = multiplier[k + 1] if size[k + 1] > 1.0 else multiplier[k]
        yield float(frequency[k] + share * (frequency[k + 1] - frequency[k])), _kind(complex(outside), _turns(frequency, int(k)))


def _turns(frequency: Array, k: int) -> bool:
    """Whether the frequency turns back near the step from point k to the next."""
    near = np.diff(frequency[max(k - 1, 0) : k + 3])
    return bool(np.any(near > 0.0) and np.any(near < 0.0))


def _kind(multiplier: complex, turns: bool) -> Instability:
    """Kind of the loss of stability by a multiplier just outside the unit circle."""
    if abs(multiplier.imag) > REAL * abs(multiplier):
        return Instability.NEIMARK_SACKER
    if multiplier.real < 0.0:
        return Instability.PERIOD_DOUBLING
    return Instability.FOLD if turns else Instability.BRANCH_POINT


def _variables(dataset: xr.Dataset, values: dict[str, Any], changes: list[list[Change]]) -> dict[str, Any]:
    """The variables, with units and meanings."""
    multiplier, longest = values["multiplier"], max((len(each) for each in changes), default=0)
    frequency, kind = np.full((len(changes), longest), np.nan), np.zeros((len(changes), longest), dtype=np.int8)
    for case, found in enumerate(changes):
        frequency[case, : len(found)] = [change.frequency for change in found]
        kind[case, : len(found)] = [change.kind for change in found]
    return {
        "stability": (("case", "point"), values["stability"], _flags("stability of the periodic motion", Stability)),
        "multiplier": (
            ("case", "point", "part"),
            np.stack([multiplier.real, multiplier.imag], axis=-1),
            {"units": "1", "long_name": "largest Floquet multiplier"},
        ),
        "multiplier_error": (
            ("case", "point"),
            values["multiplier_error"],
            {"units": "1", "long_name": "estimated error of the size of the largest Floquet multiplier"},
        ),
        "stuck_sliders": (
            ("case", "point"),
            values["stuck_sliders"],
            {"units": "1", "long_name": "sliders that never slip, each with a multiplier of exactly 1"},
        ),
        "peak_stability": (
            ("case", "peak", "output"),
            _of_peaks(dataset, values["stability"]),
            _flags("stability at the peak", Stability),
        ),
        "stability_change_frequency": (
            ("case", "change"),
            frequency,
            {"units": "Hz", "long_name": "frequency at which the stability changes"},
        ),
        "stability_change": (("case", "change"), kind, _flags("how the stability changes", Instability)),
    }


def _flags(words: str, kinds: type[IntEnum]) -> dict[str, Any]:
    values, names = np.array([int(kind) for kind in kinds], dtype=np.int8), " ".join(kind.name.lower() for kind in kinds)
    return {"units": "1", "long_name": words, "flag_values": values, "flag_meanings": names}


def _of_peaks(dataset: xr.Dataset, stability: Any) -> Any:
    """Stability of the point at every peak."""
    frequencies, sizes = dataset["peak_frequency"].values, dataset["peak_amplitude"].values
    found = np.zeros(frequencies.shape, dtype=np.int8)
    for case, peak, output in np.argwhere(np.isfinite(frequencies)):
        per = measure_in(dataset).per(float(dataset["force_level"].values[case]))
        place = (case, peak, output)
        found[place] = stability[case, nearest_point(dataset, int(case), int(output), frequencies[place], sizes[place] * per)]
    return found
