"""Identification of a damper's contact parameters from measured cycles: initial guess, global search, gradients, intervals.

1. Friction from plateaux of T/N, stiffness from stuck slopes, as far as the loops show them: a start, not a result.
2. A search of the whole range (differential evolution), then least squares on whole loops of all cases at once.
3. Intervals from refits to resampled cycles with drawn errors of cells and lasers, with the misfit itself turned about and
   with contacts between macroslip and microslip: the formal covariance is too small by 1.5 to 20 times.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import Bounds, differential_evolution, least_squares

from stickslip.laboratory.identification.damper_fit import UNSOLVED, DamperFit, parameters
from stickslip.laboratory.identification.dataset import CERTAINTY, chain_sentences, identification_dataset, with_laws, with_slip
from stickslip.laboratory.identification.first_guess import Clues, clues
from stickslip.laboratory.identification.line_laws import LINE_LAWS
from stickslip.laboratory.identification.over_cycles import parameters_over_cycles
from stickslip.laboratory.identification.refits import ALIKE, COARSE, Refits, refits, refitted, slopes
from stickslip.laboratory.identification.result_checks import checked_cases, lag_remarks, never_sliding, remarks
from stickslip.laboratory.measurement.cycles import CycleSet
from stickslip.laboratory.measurement.load_removal import LoadRemoval, zeroed
from stickslip.laboratory.measurement.records import Record
from stickslip.laboratory.measurement.rig_errors import RigErrors
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.results.result import Result
from stickslip.runs.work import Arrays
from stickslip.support.checks import Array, InputError, between, fault, nearest, seed_of

if TYPE_CHECKING:
    import xarray as xr

NEXT_TO_NOTHING = 0.05
"""Difference of misfits, half the sum of squared residuals, from which they count as one."""

FIRST_GAPS = 0.3
"""Where the search of a microslip law begins (`line_laws.py`)."""

LAG_PRIOR = 5e-3
"""Standard deviation [s] of a lag that is looked for."""

GRADUAL = 6e-3
"""Angle of the first harmonic [rad] by which forces lag or lead where contacts slip more gradually than the law that is fitted
(0.2 ms at 5 Hz; up to half of it was measured): a lag is fitted from there on."""

CLOSE = 1.1
"""A simpler law is kept while its error on loops held out is below this times the smallest."""

STARTS = 4
"""Members of the search from which least squares begin, until the smallest misfit is found twice."""

AGAIN = 0.02
"""Relative difference of misfits from which they count as one."""


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Result):
    """values {name: SI}, intervals {name: (low, high)} at 95 %, correlation of the logarithms (unknowns, unknowns); the law they
    belong to, and the error of every law on loops held out, in standard deviations; what the start stages found (`clues`),
    relative misfit of each case and channel in `dataset`, warnings.

    Intervals are NaN where the refits that they rest on failed; a warning then has the reason. `held_out` is empty where only one
    law was asked for, since no loop was held out. `dataset` has the lag of the forces and the zeros of the cells as well, with
    their standard deviations (`lag`, `lag_error`, `zero`, `zero_error`)."""

    values: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    correlation: Array
    clues: Clues
    warnings: tuple[str, ...]
    fit: DamperFit
    replicates: Array
    dataset: xr.Dataset
    law: str = "macroslip"
    held_out: Mapping[str, float] = field(default_factory=dict)

    def over_cycles(self, points: int = 5) -> xr.Dataset:
        """The parameters in so many consecutive parts of the records, {name: (point,)}, SI, fitted again from those of all
        cycles: how friction develops in a test. Their scatter is that of the cycles; errors of gains are common to all parts.
        """
        theta = np.log([self.values[p.name] for p in self.fit.unknowns])
        return parameters_over_cycles(self.fit, theta, points)

    def __str__(self) -> str:
        rows = []
        for name, value in self.values.items():
            low, high = self.intervals[name]
            factor, unit = (1.0, "") if name.startswith(("mu", "gaps")) else (1e-6, " N/µm")
            known = f"{low * factor:.4g} to {high * factor:.4g}{unit}" if np.isfinite(low) else "no interval"
            rows.append(f"{name:<6} {value * factor:.4g}{unit}  ({known})")
        rows += [f"law    {self.law}, of {errors_by_law(self.held_out)}"] if self.held_out else []
        rows += [*chain_sentences(self.dataset), *(f"Warning: {warning}" for warning in self.warnings)]
        return "\n".join(rows)


def errors_by_law(held_out: Mapping[str, float]) -> str:
    """Laws with their errors on loops held out."""
    return ", ".join(f"{law} {error:.3g}" for law, error in held_out.items())


def usual_unknowns(damper: BetweenPlatforms) -> tuple[str, ...]:
    """kt, kn, and friction of every line at a side of one or two lines, of the whole side where there are more."""
    found = ["kt", "kn"]
    for side in ("left", "right"):
        lines = [point.name for point in damper.points if point.side == side]
        found += [f"mu_{name}" for name in (lines if len(lines) <= 2 else [side[0].upper()])]
    return tuple(found)


def identify(
    loops: Sequence[CycleSet | Record] | CycleSet | Record,
    damper: BetweenPlatforms,
    unknown: Sequence[str] | None = None,
    *,
    law: str | Sequence[str] = "macroslip",
    errors: RigErrors | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    steps: int = 500,
    resamples: int = 24,
    population: int = 6,
    generations: int = 15,
    seed: int = 0,
    progress: Callable[[float], object] | None = None,
    load_removal: LoadRemoval | Sequence[LoadRemoval] | None = None,
) -> Identification:
    """Contact parameters of a damper from measured cycles of one or several cases.

    loops: records or cycles (`whole_cycles`) with platform motion, force_x, force_y, and rotation and damper_y where they were
    measured: they choose the right one of several minima. damper: geometry, pull, and values of what is not unknown.
    unknown: kt, kn or mu of all lines, or of those whose names begin with what follows: mu_L1, mu_R, kt_L; by default those of
    `usual_unknowns`. law: of all lines, "macroslip", "iwan" or "microslip"; of several the simplest is taken whose error on cases
    held out one at a time is within 10 % of the smallest, which needs two cases. errors: of the rig, as priors of gains, zeros
    and lag and for the intervals. load_removal: readings from which the zeros of the cells follow (`read_load_removal`), one for
    all loops or one each; the records then hold raw readings. bounds: {name: (low, high)} SI. steps: of a computed cycle in the
    final fit.
    resamples: refits for the intervals; population (times unknowns), generations: of the search. progress(share): callback.
    """
    errors = RigErrors() if errors is None else errors
    several = [loops] if isinstance(loops, CycleSet | Record) else list(loops)
    raw = several if load_removal is None else zeroed(several, load_removal, errors.calibration)
    cases = checked_cases(raw, damper, errors)
    work = IdentificationWork(
        cases,
        damper,
        unknown=tuple(unknown or ()),
        errors=errors,
        resamples=resamples,
        seed=seed,
        bounds=bounds or {},
        steps=steps,
        population=population,
        generations=generations,
        laws=(law,) if isinstance(law, str) else tuple(law),
    )
    return work.identification(work.solve(0, lambda share: progress(share) if progress else None))


@dataclass(frozen=True, eq=False)
class IdentificationWork:
    """An identification as work of one case, which studies keep and resume."""

    cases: tuple[CycleSet, ...]
    damper: BetweenPlatforms
    _: KW_ONLY
    unknown: tuple[str, ...] = ()
    errors: RigErrors = field(default_factory=RigErrors)
    resamples: int = 24
    seed: int = 0
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    steps: int = 500
    population: int = 6
    generations: int = 15
    name: str = "identification"
    laws: tuple[str, ...] = ("macroslip",)

    def __post_init__(self) -> None:
        object.__setattr__(self, "unknown", self.unknown or usual_unknowns(self.damper))
        between("resamples", self.resamples, 8), seed_of(self.seed)
        object.__setattr__(self, "cases", checked_cases(self.cases, self.damper, self.errors))
        parameters(self.unknown, self.damper, self.bounds)
        for law in self.laws:
            if law not in LINE_LAWS:
                raise fault("law", "must be a known one", law, nearest(law, LINE_LAWS))
        if not self.laws or len(set(self.laws)) < len(self.laws):
            raise fault("law", "must be at least one, each once", list(self.laws))
        if len(self.laws) > 1 and len(self.cases) < 2:
            raise fault("loops", "must be at least two, to hold one out and choose a law", len(self.cases), "Name one law.")

    @property
    def names(self) -> Sequence[str]:
        how = f"{self.resamples} refits, seed {self.seed}, {self.steps} steps, search {self.population} by {self.generations}"
        return (f"{self.name}, {self.laws}, {how}",)

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

    def solve(self, case: int, report: Callable[[float], object]) -> Arrays:
        """Logarithms of the unknowns of the law that is chosen, and of their refits; errors of all laws on loops held out."""
        found = clues(self.cases, self.damper, self.errors)
        fit, seen = self.fit, np.nan
        best, others = self._searched(fit, found, lambda share: report(0.4 * share))
        if self.errors.lag is None:
            largest = GRADUAL / (2.0 * np.pi * max(case.frequency for case in self.cases))
            seen, late = _lag_seen(fit, best), fit.with_lag(LAG_PRIOR)
            if abs(seen) > largest:
                there = self._searched(late, found, lambda share: report(0.4 + 0.1 * share))
                seen = _lag_of(late, there[0])
                fit, (best, others) = (late, there) if abs(seen) > largest else (fit, (best, others))
        fits = {law: fit.with_law(law) for law in LINE_LAWS if law in self.laws}
        thetas = {law: _of_law(fit, best) for law, fit in fits.items()}
        errors = {law: held_out(fit, thetas[law]) for law, fit in fits.items()} if len(fits) > 1 else {}
        law = next(law for law in fits if not errors or errors[law] <= CLOSE * min(errors.values()))
        report(0.6)
        places = others if law == "macroslip" else thetas[law][None]
        again = refits(fits[law], thetas[law], places, self.resamples, self.seed, lambda share: report(0.6 + 0.4 * share))
        number, counts = np.array(list(LINE_LAWS).index(law)), np.array([again.lost, again.cycles, again.missing])
        held = np.array(list(errors.values()))
        again_too = {"replicates": again.values, "lags": again.lags, "zeros": again.zeros, "counts": counts}
        lag = np.array([fit.errors.lag or 0.0, seen])
        return {"theta": thetas[law], **again_too, "law": number, "held_out": held, "lag_prior": lag}

    def _searched(self, fit: DamperFit, found: Clues, report: Callable[[float], object]) -> tuple[Array, Array]:
        """The best of the whole range, and other minima that are about as good."""
        return _fitted(fit, _searched(fit.steps(COARSE), found, self.population, self.generations, self.seed, report))

    def identification(self, arrays: Arrays) -> Identification:
        """The result from the arrays of `solve`."""
        theta, replicates = np.asarray(arrays["theta"]), np.asarray(arrays["replicates"])
        law = list(LINE_LAWS)[int(arrays["law"])]
        prior, seen = map(float, arrays["lag_prior"])
        fit = self.fit.with_lag(prior).with_law(law)
        lost, cycles, missing = map(int, arrays["counts"])
        again = Refits(replicates, lost, cycles, missing, np.asarray(arrays["lags"]), np.asarray(arrays["zeros"]))
        scatter, lag_error, zero_errors = again.errors(theta)
        names = [p.name for p in fit.unknowns]
        values = dict(zip(names, map(float, np.exp(theta)), strict=True))
        ends = np.exp(np.stack([theta - CERTAINTY * scatter, theta + CERTAINTY * scatter], axis=1))
        intervals = {name: (float(low), float(high)) for name, (low, high) in zip(names, ends, strict=True)}
        of_cases = (sentence for case in self.cases for sentence in case.warnings)
        counted = (sentence for sentence in (again.refusal, again.remark) if sentence)
        late = lag_remarks(fit, theta, lag_error) if prior or self.errors.lag is not None else ()
        warnings = (*counted, *of_cases, *late, *remarks(fit, theta, scatter), *never_sliding(fit, theta, self.damper))
        with np.errstate(invalid="ignore", divide="ignore"):
            enough = len(replicates) > 1
            correlation = np.atleast_2d(np.corrcoef(replicates.T)) if enough else np.full((theta.size, theta.size), np.nan)
        dataset = identification_dataset(fit, theta, intervals, replicates, (lag_error, zero_errors), warnings)
        dataset.attrs["lag_seen"] = seen
        several = [one for one in LINE_LAWS if one in self.laws] if len(self.laws) > 1 else []
        errors = dict(zip(several, map(float, arrays["held_out"]), strict=True))
        dataset = with_slip(dataset, fit, self.damper, float(fit.values(theta)["kn"][-1]))
        if errors:
            dataset = with_laws(dataset, errors)
        found = clues(self.cases, self.damper, self.errors)
        return Identification(values, intervals, correlation, found, warnings, fit, replicates, dataset, law, errors)


def _lag_seen(fit: DamperFit, theta: Array) -> float:
    """The lag [s] that fits best with contacts fitted anew, from those without one."""
    free = fit.steps(COARSE).with_lag(LAG_PRIOR)
    return _lag_of(free, refitted(free, theta, slopes(free, theta)).theta)


def _lag_of(fit: DamperFit, theta: Array) -> float:
    """The lag [s] that fits best with given contacts."""
    computed = fit.predicted(theta)
    return 0.0 if computed is None else fit.chain(computed).lag


def _of_law(fit: DamperFit, macroslip: Array) -> Array:
    """Logarithms of the unknowns of a law, from those of macroslip."""
    if fit.law == "macroslip":
        return macroslip
    start = np.concatenate([macroslip, np.full(len(fit.unknowns) - macroslip.size, np.log(FIRST_GAPS))])
    return _polished(fit, _polished(fit.steps(COARSE), start), 8)


def held_out(fit: DamperFit, theta: Array) -> float:
    """Error of each case with unknowns and gains fitted to the others, root mean square in standard deviations."""
    coarse, numbers, squares = fit.steps(COARSE), range(len(fit.cases)), []
    for left in numbers:
        others = coarse.only([i for i in numbers if i != left])
        found = _polished(others, theta, 8, 1e-4)
        computed = others.predicted(found)
        squares.append(UNSOLVED**2 if computed is None else coarse.only([left]).misfit(found, others.chain(computed)) ** 2)
    return float(np.sqrt(np.mean(squares)))


def _searched(
    fit: DamperFit, found: Clues, population: int, generations: int, seed: int, report: Callable[[float], object]
) -> Array:
    """A population over the whole range, the best first, (members, unknowns); the clues are among its first members."""
    low, high = fit.bounds
    first = np.clip(np.log([found.guess(p.name, np.sqrt(p.low * p.high)) for p in fit.unknowns]), low, high)
    seen = 0

    def height(theta: Array) -> float:
        return float(np.log1p(fit.cost(theta)))

    def generation_done(*_: Any, **__: Any) -> None:
        nonlocal seen
        seen += 1
        report(seen / generations)

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
        callback=generation_done,
    )
    return np.asarray(result.population[np.argsort(result.population_energies)])


def _fitted(fit: DamperFit, starts: Array) -> tuple[Array, Array]:
    """The least misfit that is reached from several starts by slopes over wide differences, then by narrow ones; and all minima
    (count, unknowns) that are about as good. Near lift-off there are many, and narrow slopes alone lead to the next best."""
    reached: list[tuple[float, Array]] = []
    for start in starts[:STARTS]:
        found = refitted(fit, start, slopes(fit, start))
        reached.append((found.cost, found.theta))
        least = min(cost for cost, _ in reached)
        if sum(cost <= (1.0 + AGAIN) * least + NEXT_TO_NOTHING for cost, _ in reached) > 1:
            break
    best = min(reached, key=lambda pair: pair[0])[1]
    if fit.predicted(best) is None:
        raise InputError(
            "No steady cycle was found for any contact parameters. Check columns, units and timing of the records, and the "
            "geometry and the pull of the damper."
        )
    others = [theta for cost, theta in reached if cost <= least + ALIKE]
    return min((best, _polished(fit, best)), key=fit.cost), np.array(others)


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
    return np.asarray(result.x)
