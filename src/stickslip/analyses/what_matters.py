"""Which parameter matters: how much of the spread of the resonance, in amplitude and frequency, each uncertain one makes.

Variance-based indices of Sobol', with all parameters uniform in their ranges, or exact slopes at the middle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from scipy.stats import sobol_indices, uniform
from threadpoolctl import threadpool_limits

from stickslip.analyses.cases import Progress
from stickslip.checks import Array, fault, finite, positive
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.problem import Problem
from stickslip.solve.continuation import LostCurveError
from stickslip.solve.peak_sweep import swept_summits
from stickslip.solve.sensitivity import parameter_slopes, respond, solved_factors
from stickslip.solve.summit import Ascent, NoSummitError, Summit
from stickslip.units import Band

if TYPE_CHECKING:
    import xarray as xr

QUANTITIES = ("peak amplitude", "peak frequency")
STEP = 1e-5


class ProblemOf(Protocol):
    """The problem of parameter values: `problem_of(kt=1e6, mu=0.4)`."""

    def __call__(self, **parameters: float) -> Problem: ...


@dataclass(frozen=True, eq=False)
class WhatMatters:
    """`dataset`, axes (parameter, quantity): first_order and total indices of Sobol'; low_end and high_end: the quantity at both
    ends of a range, the others in the middle; slope: d ln(amplitude) over the range by the exact slope in the middle.
    """

    dataset: xr.Dataset

    def plot(self, **options: Any) -> Any:
        """The tornado plot."""
        from stickslip.plots import plot

        return plot(self, **options)


def what_matters(
    problem_of: ProblemOf,
    parameters: Mapping[str, tuple[float, float]],
    band: Band,
    force: float = 1.0,
    *,
    draws: int = 64,
    output: int = 0,
    seed: int = 0,
    harmonics: int = 3,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> WhatMatters:
    """Sobol' indices of the highest peak |X_1| and its frequency, and its slopes, by parameters in ranges.

    problem_of(**values) makes the problem; parameters: {name: (low, high)}, anything the problem depends on: kt, kn, μ, preload,
    or a start state (a slider offset in m). draws: a power of two; draws (parameters + 2) problems are solved, each from the
    nearest one known. d ln|X_1| at the middle is exact, by the implicit function theorem: at a peak the frequency drops out.
    Source: A. Saltelli et al., Computer Physics Communications 181 (2010) 259, as in `scipy.stats.sobol_indices`.
    """
    box = {name: (finite(f"{name}, low", low), finite(f"{name}, high", high)) for name, (low, high) in parameters.items()}
    if not box or any(low >= high for low, high in box.values()):
        raise fault("parameters", "must be {name: (low, high)} with low below high", dict(parameters))
    if draws < 2 or draws & (draws - 1):
        raise fault("draws", "must be a power of two, at least 2", draws)
    with threadpool_limits(1, user_api="blas"):
        peaks = _Peaks(problem_of, box, band, positive("force", force), output, (harmonics, samples))
        middle = np.array([0.5 * (low + high) for low, high in box.values()])
        peaks.first(middle)
        ends = np.array([[peaks.at(_moved(middle, k, end)) for end in pair] for k, pair in enumerate(box.values())])
        slopes = [peaks.slope(middle, k) * (high - low) for k, (low, high) in enumerate(box.values())]
        total = draws * (len(box) + 2)

        def solved(values: Array) -> Array:
            found = []
            for column in values.T:
                found.append(peaks.at(column))
                progress(min(peaks.solved / total, 1.0), "peaks of drawn parameters")
            return np.array(found).T

        laws = [uniform(low, high - low) for low, high in box.values()]
        rng = np.random.default_rng(seed)
        indices = sobol_indices(func=solved, n=draws, dists=laws, rng=rng)  # type: ignore[arg-type]
    return WhatMatters(_dataset(box, peaks, middle, (indices.first_order, indices.total_order), ends, slopes))


class _Peaks:
    """Peaks of a problem at any parameter values, each climbed to from the nearest one known, else found by a sweep."""

    def __init__(
        self,
        problem_of: ProblemOf,
        box: Mapping[str, tuple[float, float]],
        band: Band,
        force: float,
        output: int,
        fineness: tuple[int, int],
    ) -> None:
        self.problem_of, self.names, self.force, self.output, self.fineness = problem_of, tuple(box), force, output, fineness
        self.span = np.array([high - low for low, high in box.values()])
        self.band = (2.0 * np.pi * band.low, 2.0 * np.pi * band.high)
        self.known: list[tuple[Array, Summit, Array]] = []
        self.solved = 0

    def problem(self, values: Array) -> Problem:
        return self.problem_of(**dict(zip(self.names, map(float, values), strict=True)))

    def first(self, values: Array) -> None:
        """The peak from which all others are found."""
        self._keep(values, HarmonicBalance(self.problem(values), *self.fineness))

    def at(self, values: Array) -> tuple[float, float]:
        """Amplitude in m and frequency in Hz."""
        self.solved += 1
        balance = HarmonicBalance(self.problem(values), *self.fineness)
        _, near, stiffness = min(self.known, key=lambda item: float(np.linalg.norm((item[0] - values) / self.span)))
        carried = near.point.forces + (stiffness - balance.stiffness)[:, None] * near.evaluation.w[: balance.rows]
        start = type(near.point)(carried, near.omega, self.force)
        try:
            summit = Ascent(balance, self.output).from_near(start, near.plane)
            self.known = [*self.known[-200:], (np.array(values), summit, balance.stiffness)]
        except NoSummitError:
            summit = self._keep(values, balance)
        return summit.amplitude, summit.omega / (2.0 * np.pi)

    def _keep(self, values: Array, balance: HarmonicBalance) -> Summit:
        try:
            found = swept_summits(balance, self.force, self.band, self.output)[0]
        except LostCurveError as lost:
            raise fault("Every value of the parameters", "must give a solvable curve", values.tolist(), str(lost)) from None
        if not found:
            raise fault("band", "must hold a peak for every value of the parameters", values.tolist())
        summit = max(found, key=lambda peak: peak.amplitude)
        self.known.append((np.array(values), summit, balance.stiffness))
        return summit

    def slope(self, values: Array, k: int) -> float:
        """d ln|X_1|/d(parameter k) at the peak of known values."""
        summit = self.known[0][1]
        balance = HarmonicBalance(self.problem(values), *self.fineness)

        def problem(value: float) -> Problem:
            return self.problem(_moved(values, k, value))

        step = STEP * (abs(values[k]) or float(np.max(np.abs(values))))
        forces, motion = parameter_slopes(problem, float(values[k]), balance, summit.point, step)
        factors = solved_factors(balance, summit.evaluation)
        change = respond(balance, summit.evaluation, factors, forces[None], motion[None])
        row = balance.rows + self.output
        a, b = summit.evaluation.w[row, 1:3]
        return float(a * change.motion[0, row, 1] + b * change.motion[0, row, 2]) / summit.amplitude**2


def _moved(values: Array, k: int, value: float) -> Array:
    moved = values.copy()
    moved[k] = value
    return moved


def _dataset(
    box: Mapping[str, tuple[float, float]],
    peaks: _Peaks,
    middle: Array,
    orders: tuple[Array, Array],
    ends: Array,
    slopes: list[float],
) -> xr.Dataset:
    import xarray as xr

    def described(dims: Any, values: Any, unit: str, words: str) -> tuple[Any, Any, dict[str, str]]:
        return dims, values, {"units": unit, "long_name": words}

    both, summit = ("parameter", "quantity"), peaks.known[0][1]
    at_middle = np.array([summit.amplitude, summit.omega / (2.0 * np.pi)])
    data = {
        "first_order": described(both, orders[0].T, "1", "first-order index: share of the variance by this parameter alone"),
        "total": described(both, orders[1].T, "1", "total index: with its interactions"),
        "low_end": described(both, ends[:, 0], "m and Hz", "at the low end of the range, the others in the middle"),
        "high_end": described(both, ends[:, 1], "m and Hz", "at the high end of the range, the others in the middle"),
        "middle": described("quantity", at_middle, "m and Hz", "all parameters in the middle"),
        "slope": described("parameter", np.array(slopes), "1", "d ln(amplitude) over the range, by the slope in the middle"),
        "low": described("parameter", np.array([low for low, _ in box.values()]), "as given", "low end of the range"),
        "high": described("parameter", np.array([high for _, high in box.values()]), "as given", "high end of the range"),
    }
    coords = {
        "parameter": described("parameter", list(box), "1", "uncertain parameter"),
        "quantity": described("quantity", list(QUANTITIES), "1", "quantity"),
    }
    H, Nt = peaks.fineness
    attrs = {"title": "Which parameter matters", "force": peaks.force, "harmonics": H, "samples": Nt, "problems": peaks.solved}
    return xr.Dataset(data, coords, attrs)
