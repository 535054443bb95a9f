"""Contact parameters of a damper from its measured cycles: plateaux and slopes for a start, a search, gradients, intervals.

1. Friction from plateaux of T/N, stiffness from stuck slopes, as far as the loops show them: a start, not a result.
2. A search of the whole range (differential evolution), then least squares on whole loops of all cases at once.
3. Intervals from refits to resampled cycles with drawn errors of cells and lasers, and with the misfit itself turned about:
   the formal covariance is too small by 1.5 to 20 times.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import Bounds, differential_evolution, least_squares

from stickslip.analyses.damper_fit import DamperFit, parameters
from stickslip.analyses.identification_checks import checked_cases, remarks
from stickslip.analyses.identification_dataset import identification_dataset
from stickslip.analyses.identification_start import Clues, clues
from stickslip.checks import Array, InputError, fault
from stickslip.dampers.between_platforms import BetweenPlatforms
from stickslip.measurement.cycles import CycleSet, analysis, synthesis
from stickslip.measurement.records import Record
from stickslip.measurement.rig_errors import RigErrors, distorted

if TYPE_CHECKING:
    import xarray as xr

UNKNOWN = ("kt", "kn", "mu_L1", "mu_L2", "mu_R")
COARSE = 120
"""Steps a cycle in the search; refits of resampled data take twice as many."""

CERTAINTY = 1.96
"""Standard deviations of a 95 % interval."""


@dataclass(frozen=True, eq=False)
class Identification:
    """values {name: SI}, intervals {name: (low, high)} at 95 %, correlation of the logarithms (unknowns, unknowns); what the
    start stages found (`clues`), relative misfit of each case and channel in `dataset`, warnings."""

    values: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    correlation: Array
    clues: Clues
    warnings: tuple[str, ...]
    fit: DamperFit
    replicates: Array
    dataset: xr.Dataset

    def plot(self, **options: Any) -> Any:
        """Measured against fitted loops, residuals and the posterior."""
        from stickslip.plots import plot

        return plot(self, **options)

    def __str__(self) -> str:
        rows = []
        for name, value in self.values.items():
            low, high = self.intervals[name]
            factor, unit = (1.0, "") if name.startswith("mu") else (1e-6, " N/um")
            rows.append(f"{name:<6} {value * factor:.4g}{unit}  ({low * factor:.4g} to {high * factor:.4g}{unit})")
        return "\n".join(rows)


def identify(
    loops: Sequence[CycleSet | Record] | CycleSet | Record,
    damper: BetweenPlatforms,
    unknown: Sequence[str] = UNKNOWN,
    *,
    errors: RigErrors | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    steps: int = 500,
    resamples: int = 30,
    population: int = 6,
    generations: int = 25,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Identification:
    """Contact parameters of a damper on macroslip contacts from measured cycles of one or several cases.

    loops: records or cycles (`whole_cycles`) with platform motion, force_x, force_y, and rotation and damper_y where they were
    measured: they choose the right one of several minima. damper: geometry, pull, and values of what is not unknown.
    unknown: kt, kn or mu of all lines, or of those whose names begin as said: mu_L1, mu_R, kt_L. errors: of the rig, as priors
    of gains and zeros and for the intervals. bounds: {name: (low, high)} SI. steps: of a computed cycle in the final fit.
    resamples: refits for the intervals; population (times unknowns), generations: of the search. progress: told the share done.
    """
    tell = progress or (lambda share: None)
    errors = RigErrors() if errors is None else errors
    if resamples < 8:
        raise fault("resamples", "must be at least 8", resamples)
    cases = checked_cases(loops, damper, errors)
    unknowns = parameters(unknown, damper, bounds or {})
    fit = DamperFit.of(cases, damper, unknowns, errors, steps)
    found = clues(cases, damper, errors)
    start = _searched(fit.steps(COARSE), found, population, generations, seed, lambda share: tell(0.5 * share))
    theta = _polished(fit, start)
    tell(0.6)
    replicates = _replicates(fit, theta, resamples, seed, lambda share: tell(0.6 + 0.4 * share))
    scatter = np.std(replicates, axis=0, ddof=1)
    names = [p.name for p in unknowns]
    values = dict(zip(names, map(float, np.exp(theta)), strict=True))
    intervals = {
        name: (float(np.exp(t - CERTAINTY * s)), float(np.exp(t + CERTAINTY * s)))
        for name, t, s in zip(names, theta, scatter, strict=True)
    }
    warnings = (*(sentence for case in cases for sentence in case.warnings), *remarks(fit, theta, scatter))
    with np.errstate(invalid="ignore"):
        correlation = np.atleast_2d(np.corrcoef(replicates.T))
    dataset = identification_dataset(fit, theta, intervals, replicates, warnings)
    return Identification(values, intervals, correlation, found, warnings, fit, replicates, dataset)


def _searched(fit: DamperFit, found: Clues, population: int, generations: int, seed: int, tell: Callable[[float], None]) -> Array:
    """The best of a population over the whole range, the clues among its first members."""
    low, high = fit.bounds
    first = np.clip(np.log([found.guess(p.name, np.sqrt(p.low * p.high)) for p in fit.unknowns]), low, high)
    seen = 0

    def height(theta: Array) -> float:
        return float(np.log1p(fit.cost(theta)))

    def told(*_: Any, **__: Any) -> None:
        nonlocal seen
        seen += 1
        tell(seen / generations)

    result = differential_evolution(
        height,
        Bounds(low, high),
        x0=first,
        popsize=population,
        maxiter=generations,
        tol=1e-3,
        init="sobol",
        polish=False,
        rng=seed,
        callback=told,
    )
    return np.asarray(result.x)


def _polished(fit: DamperFit, start: Array, evaluations: int = 30, exactly: float = 1e-6) -> Array:
    """Least squares from a start, in logarithms."""
    low, high = fit.bounds
    inside = np.clip(start, low + 1e-6, high - 1e-6)
    result = least_squares(
        fit.residuals,
        inside,
        bounds=(low, high),
        diff_step=np.full(inside.size, 2e-4),
        x_scale=0.1,
        max_nfev=evaluations,
        xtol=exactly,
        ftol=1e-7,
    )
    if np.max(np.abs(result.fun)) >= 1e3:
        raise InputError("No steady cycle was found for any contact parameters. Check the geometry and the pull of the damper.")
    return np.asarray(result.x)


def _replicates(fit: DamperFit, theta: Array, count: int, seed: int, tell: Callable[[float], None]) -> Array:
    """Logarithms of the unknowns refitted to perturbed data, shifted to the final fit, (count, unknowns)."""
    coarse, generator = fit.steps(2 * COARSE), np.random.default_rng(seed)
    base = _polished(coarse, theta, 8, 1e-4)
    computed = coarse.predicted(base)
    assert computed is not None
    left = fit.data - (1.0 + coarse.gains(computed)[:, None]) * computed
    left[..., 0] = 0.0
    found = []
    for number in range(count):
        cases, data = _perturbed(fit, generator)
        data += generator.normal(size=(*left.shape[:2], 1)) * left
        found.append(_polished(coarse.with_cases(cases, data), base, 8, 1e-4) - base + theta)
        tell((number + 1) / count)
    return np.asarray(found)


def _perturbed(fit: DamperFit, generator: np.random.Generator) -> tuple[list[CycleSet], Array]:
    """Resampled cycles, which also drive the model anew, and their mean harmonics with drawn systematic errors: gains and shapes
    common to all cases, zeros not."""
    count = (fit.data.shape[2] - 1) // 2
    table, shared = synthesis(4 * count + 4, count), fit.errors.draw(generator)
    cases = [case.resampled(generator) for case in fit.cases]
    found = []
    for case in cases:
        fresh, rows = fit.errors.draw(generator), []
        for name in fit.channels:
            gain, shape, _ = shared[name]
            rows.append(analysis(distorted(table @ case.channel(name), (gain, shape, fresh[name][2])), count))
        found.append(rows)
    return cases, np.asarray(found)
