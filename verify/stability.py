"""Stability of solved points against time integration from their own state: random problems, several kinds of instability."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from robustness.problems import random_case
from stickslip.analyses.forced_response import ForcedResponse, forced_response
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.checks import InputError
from stickslip.contact.cubic import CubicSpring
from stickslip.contact.point import Contact, between
from stickslip.loads import Force
from stickslip.outcome import Outcome
from stickslip.problem import Problem
from stickslip.stability.multipliers import PeriodMap, Stability
from stickslip.structure.matrices import Structure
from stickslip.units import Band
from verify.row import INDEPENDENT, Row, at_most

TITLE = "Stability of periodic motions"
ABOUT = (
    "Random problems of `robustness/problems.py` with lift-off and barely pressed contacts, gaps and start states, and masses on "
    "cubic springs: of eight points of a curve one stable and up to three unstable ones, integrated in time from their own "
    "state. A point is unstable in time where the motion ends four times farther from the periodic one than the error of its "
    "first period lets a stable one go, and than half the steps change it. Points whose first period errs by 0.5 % have too few "
    "harmonics (21) and do not count."
)
POINTS = 200
UNSTABLE_POINTS = 80
KINDS = ("lift-off", "barely pressed", "cubic", "start state", "constant load", "varying load")
TRIED = 8
"""Points of a curve whose multipliers are computed."""


RESOLVED = 5e-3
"""Error of the first period beyond which the harmonics are too few: their motion is not the periodic one."""


class Compared(NamedTuple):
    """A point, its largest multiplier, verdict, and what time integration saw: True left, False stayed, None not settled."""

    name: str
    point: int
    multiplier: complex
    verdict: Stability
    left: bool | None


def cubic_case(seed: int) -> tuple[Problem, Band, float]:
    """Two masses on springs, one of them hardening or softening with the cube."""
    rng = np.random.default_rng([77, seed])
    K = np.array([[rng.uniform(1.0, 2.0), -0.5], [-0.5, rng.uniform(1.0, 9.0)]])
    structure = Structure(np.eye(2), K, ("1.x", "2.x"), C=float(rng.uniform(0.01, 0.05)) * np.eye(2))
    spring = Contact(
        "spring", CubicSpring(float(rng.uniform(0.2, 1.0))), (between("1.x", "2.x" if rng.integers(2) else "ground"),)
    )
    problem = Problem(structure, (spring,), (Force("1.x", 1.0),), ("1.x",), f"cubic {seed}")
    return problem, Band(0.1, 0.7), float(rng.uniform(0.1, 1.0))


def response_of(kind: str, seed: int) -> ForcedResponse | None:
    """The curve of a case; None where it could not be traced."""
    if kind == "cubic":
        problem, band, level = cubic_case(seed)
    else:
        case = random_case(kind, seed)
        problem, band, level = case.problem, case.band, case.level
    try:
        return forced_response(problem, band, level, harmonics=21, samples=512)
    except InputError:
        return None


def compared(kind: str, seed: int, rng: np.random.Generator) -> Iterator[Compared]:
    """The chosen points of a case, out of some of its curve."""
    response = response_of(kind, seed)
    if response is None:
        return
    points, taken = SolvedPoints(response.dataset, response.problem), {Stability.STABLE: 1, Stability.UNSTABLE: 3}
    map_ = PeriodMap(points.balance)
    converged = np.flatnonzero(response.dataset["outcome"].values[0] == Outcome.CONVERGED)
    for point in map(int, rng.permutation(converged)[:TRIED]):
        found = map_.multipliers(points.evaluation(0, point))
        if taken.get(found.verdict, 1) > 0:
            taken[found.verdict] = taken.get(found.verdict, 1) - 1
            first, left = has_left(response, point, found.leading, 400, 150)
            if left is None or left != (found.verdict == Stability.UNSTABLE):
                first, left = has_left(response, point, found.leading, 1000, 300)
            if first > RESOLVED:
                continue
            yield Compared(f"{kind} {seed}", point, found.leading, found.verdict, left)


def has_left(response: ForcedResponse, point: int, multiplier: complex, steps: int, periods: int) -> tuple[float, bool | None]:
    """How far the first period in time is from the harmonics, and whether the motion left the periodic one: it ends farther away
    than that error, which a stable motion multiplies by 1/(1 − |μ|) at most, and than its steps err. None where that many periods
    do not say."""
    check = response.verify_in_time(0, point, steps_per_period=steps, periods=periods, tolerance=1e-4)
    first, last, step = (float(each.max()) for each in (check.first_period_difference, check.period_difference, check.step_error))
    kept = first / max(abs(1.0 - abs(multiplier)), 1e-3)
    allowed = 4.0 * max(kept, step if np.isfinite(step) else 0.0, 1e-3)
    if check.unstable or last > allowed:
        return first, True
    return first, False if check.distance <= allowed else None


def all_compared() -> list[Compared]:
    """The first points of all kinds, in turn, until there are enough."""
    rng, found = np.random.default_rng(5), []
    for seed in range(200):
        for kind in KINDS:
            found += list(compared(kind, seed, rng))
        if len(found) >= POINTS and sum(each.verdict == Stability.UNSTABLE for each in found) >= UNSTABLE_POINTS:
            break
    return found


def rows() -> Iterator[Row]:
    """The rows of this page."""
    found = all_compared()
    unstable = sum(each.verdict == Stability.UNSTABLE for each in found)
    wrong = [each for each in found if each.left is not None and each.left != (each.verdict == Stability.UNSTABLE)]
    wrong = [each for each in wrong if each.verdict != Stability.UNDECIDED]
    undecided = sum(each.verdict == Stability.UNDECIDED for each in found)
    yield Row(
        "points compared, fewer than 200 as a share", max(1.0 - len(found) / POINTS, 0.0), 0.0, 1e-9, INDEPENDENT, "absolute"
    )
    yield Row(
        "unstable among them, fewer than 60 as a share", max(1.0 - unstable / 60.0, 0.0), 0.0, 1e-9, INDEPENDENT, "absolute"
    )
    yield at_most("contradictions, share of the points", len(wrong) / len(found), 0.01, INDEPENDENT)
    yield at_most("undecided, share of the points", undecided / len(found), 0.02, INDEPENDENT)
