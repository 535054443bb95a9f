"""Trace seeded random problems across their bands and print the share that arrives, by class and cause; then the ill-posed ones.

python -m robustness.run [CASES PER CLASS]; a run of at least 250 writes docs/robustness.md. Each class is kept in
results/robustness.json as it is finished: an interrupted run of the same commit goes on after it.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from datetime import UTC, datetime
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from robustness.ill_posed import ILL_POSED
from robustness.one_slider import RATIOS as SLIDER_RATIOS
from robustness.one_slider import HighestResult, drawn
from robustness.page import ClassResult, ResonanceResult, page
from robustness.problems import CLASSES, random_case
from robustness.resonances import RATIOS, STUCK, Tally, linear_peaks, solved_peaks
from robustness.resonances import random_case as resonance_case
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.curves.curve import Curve, solve_curve
from stickslip.support.files import write_text
from stickslip.support.outcome import Outcome
from tools.commits import commit, settled

HARMONICS, SAMPLES = 5, 256
ENOUGH = 250
SHARES = {"chain": 2.5, "beam": 25.0, "partly stuck chain": 25.0}
"""Of the cases of a class: beside 250, 100 chains, 10 beams and 10 chains with a slider that always sticks a damping ratio."""

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "results" / "robustness.json"


def traced(kind: str, seed: int) -> Curve:
    """The curve of one case."""
    case = random_case(kind, seed)
    balance = HarmonicBalance(case.problem, HARMONICS, SAMPLES)
    omegas = [6.283185307179586 * f for f in (case.band.start, case.band.stop)]
    return solve_curve(balance, omegas, case.level, exactly=False)


def main(count: int) -> None:
    """Run `count` cases of every class and print the table."""
    with threadpool_limits(1, user_api="blas"):
        results = [
            kept(f"{kind}, {count}", partial(of_class, kind, count), lambda stored: ClassResult(**stored)) for kind in CLASSES
        ]
        resonances = []
        for (kind, share), ratio in product(SHARES.items(), RATIOS):
            cases = max(round(count / share), 1)
            compute = partial(of_ratio, kind, ratio, cases)
            resonances.append(kept(f"{kind}, {ratio:g}, {cases}", compute, ResonanceResult.restored))
        highest = [
            kept(f"one slider, {ratio:g}, {count}", partial(of_slider, ratio, count), lambda stored: HighestResult(**stored))
            for ratio in SLIDER_RATIOS
        ]
        ill_posed = tell_ill_posed()
    if count >= ENOUGH:
        write_text(ROOT / "docs" / "robustness.md", page(results, resonances, highest, ill_posed, when()))


Result = TypeVar("Result", ClassResult, ResonanceResult, HighestResult)


def kept(name: str, compute: Callable[[], Result], restored: Callable[[dict[str, Any]], Result]) -> Result:
    """What an earlier run of this very commit computed under a name, else computed and kept."""
    now, stored = commit("src", "robustness"), _stored()
    if name in stored and stored[name]["commit"] == now and settled(now):
        print(f"{name}: kept from an earlier run", flush=True)
        return restored(stored[name]["result"])
    result = compute()
    write_text(KEPT, json.dumps({**_stored(), name: {"commit": now, "result": asdict(result)}}, indent=1) + "\n")
    return result


def _stored() -> dict[str, Any]:
    """What is kept now: two runs beside each other share it."""
    stored: dict[str, Any] = json.loads(KEPT.read_text()) if KEPT.is_file() else {}
    return stored


def of_class(kind: str, count: int) -> ClassResult:
    """Trace the cases of a class and print what came of them."""
    failed: dict[str, list[int]] = {}
    started = time.process_time()
    for seed in range(count):
        curve = traced(kind, seed)
        if curve.outcome != Outcome.CONVERGED:
            failed.setdefault(cause_of(curve.message), []).append(seed)
    result = ClassResult(kind, count, (time.process_time() - started) / count, failed)
    print(f"{kind:15s} {result.traced:5d} of {count} traced, {result.seconds:.3f} CPU s each", flush=True)
    for cause in result.causes:
        print(f"    {cause}")
    return result


def of_ratio(kind: str, ratio: float, count: int) -> ResonanceResult:
    """Compare the peaks of cases of one kind and damping ratio: stuck with exact peaks, slipping with listed solutions."""
    stuck, slipping = Tally(), Tally()
    for seed in range(count):
        case = resonance_case(kind, ratio, seed)
        stuck.add(case, STUCK * case.level, linear_peaks(case), exact=True)
        slipping.add(case, case.level, solved_peaks(case), exact=False)
    print(f"{kind}, damping ratio {ratio:g}: {stuck.words} stuck; {slipping.words} slipping", flush=True)
    for cause in (*stuck.wrong, *slipping.wrong):
        print(f"    {cause}")
    return ResonanceResult(kind, ratio, stuck, slipping)


def of_slider(ratio: float, count: int) -> HighestResult:
    """Compare the highest responses of those among the first `count` cases of one slider on modes that have a damping ratio."""
    result = HighestResult(ratio)
    for seed in range(count):
        if drawn(seed).ratio == ratio:
            result.add(seed)
    words = f"{result.cases} cases, {result.arrived} arrived, {len(result.wrong)} with another highest response"
    print(f"one slider, damping ratio {ratio:g}: {words}", flush=True)
    for cause in result.wrong:
        print(f"    {cause}")
    return result


def cause_of(message: str) -> str:
    """The first sentence: those that follow name the frequency where the curve ended, and its peaks."""
    return message.partition(". ")[0].removesuffix(".") + "."


def tell_ill_posed() -> str:
    """Print how many ill-posed problems are recognised, and what the others were taken for; returns the count in words."""
    started = time.process_time()
    mistakes = {case.name: mistake for case in ILL_POSED if (mistake := case.mistaken_for())}
    seconds = (time.process_time() - started) / len(ILL_POSED)
    words = f"{len(ILL_POSED) - len(mistakes)} of {len(ILL_POSED)} recognised"
    print(f"{'ill-posed':15s} {words}, {seconds:.3f} CPU s each")
    for name, mistake in mistakes.items():
        print(f"          {name}: {mistake}")
    return words


def when() -> str:
    """Date and commit of the run."""
    return f"Measured on {datetime.now(UTC):%Y-%m-%d} at commit `{commit('src', 'robustness')}`, in one process"


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 25)
