"""Intervals from refits: cycles resampled, errors of the rig drawn, the misfit turned about, contacts with and without gaps.

Each refit begins where the loops themselves led, in turn where they led to several minima. Refits that find no way down although
they see one, and cycles that are missing, are counted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from stickslip.laboratory.identification.damper.fit import ALIKE, COARSE, EVALUATIONS, DamperFit
from stickslip.laboratory.measurement.cycles import CycleSet, analysis, synthesis
from stickslip.laboratory.measurement.reconstruction import distorted
from stickslip.support.checks import Array

COST = 2.0
"""By how much coarser steps may raise the sum of squares of the final fit; refits take twice as many where they do more."""

LAW_GAPS = 0.6
"""Refits of macroslip take contacts with gaps up to this: the true law is not known to be it (`DamperFit.gaps`)."""

GAP_STEPS = 5
"""Gaps with which the loops themselves are fitted, to know how likely each is."""

LOST = 0.25
"""Share of refits that found no way down from which no interval is given."""

MISSING = 0.05
"""Share of cycles without a steady state in the refits from which no interval is given."""


@dataclass(frozen=True, eq=False)
class Refits:
    """Logarithms of the unknowns (refits, unknowns), shifted to the final fit; how many more refits found no way down, and the
    cycles that were computed and those of them that are missing. Changes of the lag (refits,) [s] and of the zeros of the cells
    (refits, cases, forces) [N] from the final fit, less what was drawn of them."""

    values: Array
    lost: int
    cycles: int
    missing: int
    lags: Array
    zeros: Array

    def errors(self, theta: Array) -> tuple[Array, float, Array]:
        """Standard deviations of the unknowns (unknowns,), of the lag [s] and of the zeros (cases, forces) [N] about the final
        fit; NaN where intervals are refused."""
        if self.refusal:
            return np.full(theta.size, np.nan), float("nan"), np.full(self.zeros.shape[1:], np.nan)
        values, lag, zeros = (np.sqrt(np.mean(x**2, axis=0)) for x in (self.values - theta, self.lags, self.zeros))
        return values, float(lag), zeros

    @property
    def refusal(self) -> str:
        """Why no interval is given, a sentence; empty where intervals may be given."""
        count = len(self.values) + self.lost
        if self.lost > LOST * count:
            return (
                f"No intervals are given: {self.lost} of {count} refits to resampled cycles found no way down from where they "
                "began. The misfit is not smooth there; measure other amplitudes or pulls as well."
            )
        if self.missing > MISSING * self.cycles:
            return (
                f"No intervals are given: {self.missing} of {self.cycles} cycles in the refits never became steady. Narrow "
                "`bounds`, or measure where the damper settles."
            )
        return ""

    @property
    def remark(self) -> str:
        """The note on failed refits beside the intervals."""
        if not self.lost or self.refusal:
            return ""
        return f"{self.lost} of {len(self.values) + self.lost} refits found no way down and are left out of the intervals."


def enough_steps(fit: DamperFit, theta: Array) -> DamperFit:
    """The fit with as few steps a cycle as its cost at theta allows, at most its own."""
    own, cost, count = fit.drives[0].shape[0], fit.cost(theta), COARSE
    while count < own and fit.steps(count).cost(theta) > cost + COST:
        count *= 2
    return fit.steps(count) if count < own else fit


def refits(fit: DamperFit, theta: Array, minima: Array, count: int, seed: int, report: Callable[[float], object]) -> Refits:
    """Refits to perturbed data of a final fit theta; minima (count, unknowns): others that are about as good, to begin there."""
    coarse, generator = enough_steps(fit, theta), np.random.default_rng(seed)
    base = coarse.solved(theta, evaluations=EVALUATIONS).x
    computed = coarse.predicted(base)
    assert computed is not None
    chain = coarse.chain(computed)
    zeros, left = coarse.zeros(computed, chain), fit.data - coarse.recorded(computed, chain)
    left[..., 0] = 0.0
    gaps, weights, places = likely_gaps(coarse, base)
    before, found, lags, shifts = tuple(coarse.tally), [], [], []
    for number in range(count):
        cases, data, drawn_lag, drawn_zeros = _perturbed(fit, generator)
        data += generator.normal(size=(*left.shape[:2], 1)) * left
        gap = float(generator.choice(gaps, p=weights))
        start = np.array([np.interp(gap, places[0], values) for values in places[1].T])
        start = np.clip(start + minima[number % len(minima)] - theta, *fit.bounds)
        drawn = replace(coarse.with_cases(cases, data), gaps=gap)
        one = drawn.solved(start, evaluations=EVALUATIONS)
        computed = drawn.predicted(one.x) if one.moved else None
        if computed is not None:
            again = drawn.chain(computed)
            found.append(one.x - base + theta)
            lags.append(again.lag - drawn_lag - chain.lag)
            shifts.append(drawn.zeros(computed, again) - drawn_zeros - zeros)
        report((number + 1) / count)
    values = np.array(found).reshape(-1, theta.size)
    cycles, missing = np.subtract(coarse.tally, before).tolist()
    return Refits(values, count - len(found), cycles, missing, np.array(lags), np.array(shifts).reshape(-1, *zeros.shape))


def likely_gaps(fit: DamperFit, base: Array) -> tuple[Array, Array, tuple[Array, Array]]:
    """Gaps of the contacts and how likely each is by the loops themselves; some gaps and the unknowns fitted with them.

    A law other than macroslip stays as it is."""
    if fit.law != "macroslip":
        return np.zeros(1), np.ones(1), (np.zeros(1), base[None])
    some, places, costs = np.linspace(0.0, LAW_GAPS, GAP_STEPS), [base], [fit.cost(base)]
    for gap in some[1:]:
        one = replace(fit, gaps=float(gap)).solved(places[-1], evaluations=EVALUATIONS)
        places.append(one.x)
        costs.append(one.cost)
    gaps = np.linspace(0.0, LAW_GAPS, 12 * GAP_STEPS + 1)
    cost = np.interp(gaps, some, costs)
    weights = np.exp((cost.min() - cost) / ALIKE)
    return gaps, weights / weights.sum(), (some, np.array(places))


def _perturbed(fit: DamperFit, generator: np.random.Generator) -> tuple[list[CycleSet], Array, float, Array]:
    """Resampled cycles, which also drive the model anew, and their mean harmonics with drawn systematic errors: gains, shapes and
    the lag common to all cases, zeros not. The lag and the zeros (cases, forces) that were drawn."""
    count = (fit.data.shape[2] - 1) // 2
    table, shared = synthesis(4 * count + 4, count), fit.errors.draw(generator)
    cases = [case.resampled(generator) for case in fit.cases]
    found, zeros, lag = [], [], fit.errors.lag * float(generator.normal()) if fit.errors.lag else 0.0
    for case in cases:
        fresh, rows = fit.errors.with_zeros(case.zero_errors).draw(generator), []
        for name in fit.channels:
            gain, shape, _ = shared[name]
            rows.append(analysis(distorted(table @ case.channel(name), (gain, shape, fresh[name][2])), count))
        found.append(rows)
        zeros.append([fresh[fit.channels[c]][2] for c in fit.forces])
    return cases, fit.late(np.asarray(found), lag), lag, np.array(zeros)
