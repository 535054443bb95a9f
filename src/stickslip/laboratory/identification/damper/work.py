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

import numpy as np

from stickslip.laboratory.identification.damper.clues import Clues, clues
from stickslip.laboratory.identification.damper.diagnosis import checked_cases, lag_remarks, never_sliding, remarks
from stickslip.laboratory.identification.damper.fit import (
    COARSE,
    EVALUATIONS,
    DamperFit,
    fitted,
    fitted_with_law,
    held_out,
    population,
)
from stickslip.laboratory.identification.damper.intervals import Refits, refits
from stickslip.laboratory.identification.damper.model import LINE_LAWS, parameters, usual_unknowns
from stickslip.laboratory.identification.damper.result import CERTAINTY, Identification, identification_dataset, with_slip
from stickslip.laboratory.measurement.cycles import CycleSet
from stickslip.laboratory.measurement.load_removal import LoadRemoval, zeroed
from stickslip.laboratory.measurement.records import Record
from stickslip.laboratory.measurement.rig_errors import RigErrors
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.runs.work import Arrays
from stickslip.support.checks import Array, between, fault, nearest, seed_of

LAG_PRIOR = 5e-3
"""Standard deviation [s] of a lag that is looked for."""

GRADUAL = 6e-3
"""Angle of the first harmonic [rad] by which forces lag or lead where contacts slip more gradually than the law that is fitted
(0.2 ms at 5 Hz; up to half of it was measured): a lag is fitted from there on."""

CLOSE = 1.1
"""A simpler law is kept while its error on loops held out is below this times the smallest."""


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
            largest, late = GRADUAL / (2.0 * np.pi * max(case.frequency for case in self.cases)), fit.with_lag(LAG_PRIOR)
            coarse = late.steps(COARSE)
            seen = coarse.lag_at(coarse.solved(best, evaluations=EVALUATIONS).x)
            if abs(seen) > largest:
                there = self._searched(late, found, lambda share: report(0.4 + 0.1 * share))
                seen = late.lag_at(there[0])
                # A lag that another minimum seemed to show is none, but has led to a better one.
                fit, (best, others) = (late, there) if abs(seen) > largest else (fit, fitted(fit, np.array([best, there[0]])))
        fits = {law: fit.with_law(law) for law in LINE_LAWS if law in self.laws}
        thetas = {law: fitted_with_law(fit, best) for law, fit in fits.items()}
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
        return fitted(fit, population(fit.steps(COARSE), found, self.population, self.generations, self.seed, report))

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
        dataset = identification_dataset(fit, theta, intervals, replicates, (lag_error, zero_errors))
        dataset.attrs |= {"warnings": "\n".join(warnings), "lag_seen": seen}
        dataset = with_slip(dataset, fit, self.damper, float(fit.values(theta)["kn"][-1]))
        several = [one for one in LINE_LAWS if one in self.laws] if len(self.laws) > 1 else []
        errors = dict(zip(several, map(float, arrays["held_out"]), strict=True))
        if errors:
            words = {"units": "1", "long_name": "error on loops held out, in standard deviations"}
            names_of_laws = ("law", several, {"units": "1", "long_name": "law of the lines of contact"})
            dataset = dataset.assign(held_out=("law", list(errors.values()), words)).assign_coords(law=names_of_laws)
        found = clues(self.cases, self.damper, self.errors)
        return Identification(values, intervals, correlation, found, warnings, fit, replicates, dataset, law, errors)


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
    `usual_unknowns`. With "tenfold" among them, all friction coefficients follow a power e of the normal load N of their
    line, μ (N/N0)^e with tenfold = 10^e; mu is that at N0, the geometric mean of the pulls divided by the number of lines.
    law: of all lines, "macroslip", "iwan" or "microslip"; of several the simplest is taken whose error on cases held out one at
    a time is within 10 % of the smallest, which needs two cases. errors: of the rig, as priors of gains, zeros and lag and for
    the intervals. load_removal: readings from which the zeros of the cells follow (`read_load_removal`), one for all loops or one
    each; the records then hold raw readings. bounds: {name: (low, high)} SI. steps: of a computed cycle in the final fit.
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
