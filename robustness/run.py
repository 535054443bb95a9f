"""Trace seeded random problems across their bands and print the share that arrives, by class and cause.

python -m robustness.run [CASES PER CLASS]
"""

from __future__ import annotations

import sys
import time
from collections import Counter

from threadpoolctl import threadpool_limits

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


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 25)
