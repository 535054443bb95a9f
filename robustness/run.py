"""Trace seeded random problems across their bands and print the share that arrives, by class and cause; then the ill-posed ones.

python -m robustness.run [CASES PER CLASS]
"""

from __future__ import annotations

import sys
import time
from collections import Counter

from threadpoolctl import threadpool_limits

from robustness.ill_posed import ILL_POSED
from robustness.problems import CLASSES, random_case
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.outcome import Outcome
from stickslip.solve.curve import Curve, solve_curve

HARMONICS, SAMPLES = 5, 256


def traced(kind: str, seed: int) -> Curve:
    """The curve of one case."""
    case = random_case(kind, seed)
    balance = HarmonicBalance(case.problem, HARMONICS, SAMPLES)
    omegas = [6.283185307179586 * f for f in (case.band.start, case.band.stop)]
    return solve_curve(balance, omegas, case.level, exactly=False)


def main(count: int) -> None:
    """Run `count` cases of every class and print the table."""
    with threadpool_limits(1, user_api="blas"):
        for kind in CLASSES:
            causes: Counter[str] = Counter()
            failed, started = [], time.process_time()
            for seed in range(count):
                curve = traced(kind, seed)
                if curve.outcome != Outcome.CONVERGED:
                    causes[curve.message] += 1
                    failed.append(seed)
            seconds = (time.process_time() - started) / count
            print(f"{kind:15s} {count - len(failed):5d} of {count} traced, {seconds:.3f} CPU s each")
            for cause, number in causes.most_common():
                print(f"    {number:4d}  {cause}")
            if failed:
                print(f"          seeds {failed}")
        tell_ill_posed()


def tell_ill_posed() -> None:
    """How many ill-posed problems are recognised as such, and what the others were taken for."""
    started = time.process_time()
    mistakes = {case.name: mistake for case in ILL_POSED if (mistake := case.mistaken_for())}
    seconds = (time.process_time() - started) / len(ILL_POSED)
    recognised = len(ILL_POSED) - len(mistakes)
    print(f"{'ill-posed':15s} {recognised:5d} of {len(ILL_POSED)} recognised, {seconds:.3f} CPU s each")
    for name, mistake in mistakes.items():
        print(f"          {name}: {mistake}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 25)
