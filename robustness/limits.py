"""From which stiffness and friction of the contacts on random problems are lost: the limits of warnings of `model/problem`.

python -m robustness.limits [CASES PER CLASS], 25 unless given: the table in docs/choose.md.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from dataclasses import replace
from math import floor, log10, pi

import numpy as np
from threadpoolctl import threadpool_limits

from robustness.problems import Case, random_case
from robustness.run import HARMONICS, SAMPLES
from stickslip.model.contact.law import Law
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.curves.curve import solve_curve
from stickslip.support.outcome import Outcome

STIFFER = (1.0, 30.0, 1e3, 1e4, 1e5, 1e6, 1e7)
FRICTION = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 1e3, 1e5)
PATIENCE = 12.0
"""CPU seconds after which a curve counts as lost; the usual ones take 0.3."""


class TooLongError(Exception):
    """Patience is at its end."""


def stiffer(problem: Problem, factor: float) -> Problem:
    """The problem with kt and kn of every contact times a factor; loads and gaps stay."""

    def changed(law: Law) -> Law:
        given = {name: getattr(law, name) for name in ("kt", "kn") if getattr(law, name, None) is not None}
        changes = {name: tuple(factor * np.array(k)) if np.ndim(k) else factor * k for name, k in given.items()}
        return replace(law, **changes)  # type: ignore[type-var]

    return problem.with_contacts(lambda contact: contact.with_law(changed(contact.law)))


def of_friction(problem: Problem, mu: float) -> Problem:
    """The problem with another friction coefficient of every contact that has one."""

    def changed(law: Law) -> Law:
        return replace(law, mu=mu) if hasattr(law, "mu") else law  # type: ignore[type-var]

    return problem.with_contacts(lambda contact: contact.with_law(changed(contact.law)))


def is_lost(case: Case, problem: Problem) -> bool:
    """Whether the changed problem is not traced over the band of the case."""
    begun = time.process_time()

    def watch(fraction: float) -> None:
        if time.process_time() - begun > PATIENCE:
            raise TooLongError

    try:
        ends = [2.0 * pi * case.band.start, 2.0 * pi * case.band.stop]
        curve = solve_curve(HarmonicBalance(problem, HARMONICS, SAMPLES), ends, case.level, exactly=False, progress=watch)
    except TooLongError:
        return True
    return curve.outcome != Outcome.CONVERGED


def main(count: int) -> None:
    """Print lost and all problems, by decades of the stiffness ratio and by friction coefficient."""
    for kind in ("constant load", "varying load", "lift-off"):
        lost, tried = Counter[int](), Counter[int]()
        for case in (random_case(kind, seed) for seed in range(count)):
            for problem in (stiffer(case.problem, factor) for factor in STIFFER):
                decade = floor(log10(problem.stiffness_ratios.max()))
                tried[decade] += 1
                lost[decade] += is_lost(case, problem)
        for decade in sorted(tried):
            print(f"{kind:15s} ratio 1e{decade} to 1e{decade + 1}: {lost[decade]} of {tried[decade]} lost", flush=True)
    for mu in FRICTION:
        cases = [random_case("lift-off", seed) for seed in range(count)]
        lost_here = sum(is_lost(case, of_friction(case.problem, mu)) for case in cases)
        print(f"lift-off        mu = {mu:g}: {lost_here} of {count} lost", flush=True)


if __name__ == "__main__":
    with threadpool_limits(1, user_api="blas"):
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 25)
