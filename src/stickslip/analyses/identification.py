"""Contact parameters of a damper from its measured cycles: plateaux and slopes for a start, a search, gradients, intervals.

1. Friction from plateaux of T/N, stiffness from stuck slopes, as far as the loops show them: a start, not a result.
2. A search of the whole range (differential evolution), then least squares on whole loops of all cases at once.
3. Intervals from refits to resampled cycles with drawn errors of cells and lasers, with the misfit itself turned about and
   with contacts between macroslip and microslip: the formal covariance is too small by 1.5 to 20 times.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import Bounds, differential_evolution, least_squares

from stickslip.analyses.cases import Arrays
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
"""Steps a cycle in the search and in refits of resampled data."""

LAW_GAPS = 0.6
"""Refits take contacts with gaps drawn up to this: the true law is not known to be macroslip (`DamperFit.gaps`)."""

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
    resamples: int = 24,
    population: int = 6,
    generations: int = 25,
    seed: int = 0,
    progress: Callable[[float], object] | None = None,
) -> Identification:
    """Contact parameters of a damper on macroslip contacts from measured cycles of one or several cases.

    loops: records or cycles (`whole_cycles`) with platform motion, force_x, force_y, and rotation and damper_y where they were
    measured: they choose the right one of several minima. damper: geometry, pull, and values of what is not unknown.
    unknown: kt, kn or mu of all lines, or of those whose names begin as said: mu_L1, mu_R, kt_L. errors: of the rig, as priors
    of gains and zeros and for the intervals. bounds: {name: (low, high)} SI. steps: of a computed cycle in the final fit.
    resamples: refits for the intervals; population (times unknowns), generations: of the search. progress: told the share done.
    """
    errors = RigErrors() if errors is None else errors
    cases = checked_cases(loops, damper, errors)
    settings = (tuple(unknown), errors, resamples, seed, bounds or {}, steps, population, generations)
    work = IdentificationWork(cases, damper, *settings)
    return work.identification(work.solve(0, lambda share: progress(share) if progress else None))


@dataclass(frozen=True, eq=False)
class IdentificationWork:
    """An identification as work of one case, which studies keep and resume."""

    cases: tuple[CycleSet, ...]
    damper: BetweenPlatforms
    unknown: tuple[str, ...] = UNKNOWN
    errors: RigErrors = field(default_factory=RigErrors)
    resamples: int = 24
    seed: int = 0
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    steps: int = 500
    population: int = 6
    generations: int = 25
    name: str = "identification"

    def __post_init__(self) -> None:
        if self.resamples < 8:
            raise fault("resamples", "must be at least 8", self.resamples)
        object.__setattr__(self, "cases", checked_cases(self.cases, self.damper, self.errors))
        parameters(self.unknown, self.damper, self.bounds)

    @property
    def names(self) -> Sequence[str]:
        return (self.name,)

    @property
    def words(self) -> Sequence[str]:
        return (f"{len(self.unknown)} parameters",)

    def prepare(self) -> None:
        """Compile the cycle."""
        self.fit.steps(COARSE).predicted(np.mean(self.fit.bounds, axis=0))

    @cached_property
    def fit(self) -> DamperFit:
        """Loops and model."""
        unknowns = parameters(self.unknown, self.damper, self.bounds)
        return DamperFit.of(self.cases, self.damper, unknowns, self.errors, self.steps)

    def solve(self, case: int, tell: Callable[[float], object]) -> Arrays:
        """Logarithms of the unknowns and of their refits."""
        found = clues(self.cases, self.damper, self.errors)
        coarse = self.fit.steps(COARSE)
        start = _searched(coarse, found, self.population, self.generations, self.seed, lambda share: tell(0.5 * share))
        theta = _polished(self.fit, start)
        tell(0.6)
        replicates = _replicates(self.fit, theta, self.resamples, self.seed, lambda share: tell(0.6 + 0.4 * share))
        return {"theta": theta, "replicates": replicates}

    def identification(self, arrays: Arrays) -> Identification:
        """The result from the arrays of `solve`."""
        fit, theta, replicates = self.fit, np.asarray(arrays["theta"]), np.asarray(arrays["replicates"])
        scatter = np.sqrt(np.mean((replicates - theta) ** 2, axis=0))
        names = [p.name for p in fit.unknowns]
        values = dict(zip(names, map(float, np.exp(theta)), strict=True))
        ends = np.exp(np.stack([theta - CERTAINTY * scatter, theta + CERTAINTY * scatter], axis=1))
        intervals = {name: (float(low), float(high)) for name, (low, high) in zip(names, ends, strict=True)}
        warnings = (*(said for case in self.cases for said in case.warnings), *remarks(fit, theta, scatter))
        with np.errstate(invalid="ignore", divide="ignore"):
            correlation = np.atleast_2d(np.corrcoef(replicates.T))
        dataset = identification_dataset(fit, theta, intervals, replicates, warnings)
        found = clues(self.cases, self.damper, self.errors)
        return Identification(values, intervals, correlation, found, warnings, fit, replicates, dataset)


def _searched(
    fit: DamperFit, found: Clues, population: int, generations: int, seed: int, tell: Callable[[float], object]
) -> Array:
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


def _replicates(fit: DamperFit, theta: Array, count: int, seed: int, tell: Callable[[float], object]) -> Array:
    """Logarithms of the unknowns refitted to perturbed data, shifted to the final fit, (count, unknowns)."""
    coarse, generator = fit.steps(COARSE), np.random.default_rng(seed)
    base = _polished(coarse, theta, 8, 1e-4)
    computed = coarse.predicted(base)
    assert computed is not None
    left = fit.data - (1.0 + coarse.gains(computed)[:, None]) * computed
    left[..., 0] = 0.0
    found = []
    for number in range(count):
        cases, data = _perturbed(fit, generator)
        data += generator.normal(size=(*left.shape[:2], 1)) * left
        other = replace(coarse.with_cases(cases, data), gaps=float(generator.uniform(0.0, LAW_GAPS)))
        found.append(_polished(other, base, 8, 1e-4) - base + theta)
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
