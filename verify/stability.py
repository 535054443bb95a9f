"""Stability of solved points against time integration from their own state: random problems, several kinds of instability."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from robustness.problems import random_case
from stickslip.analyses.forced_response import ForcedResponse, forced_response
from stickslip.analyses.time_check import TimeCheck
from stickslip.checks import InputError
from stickslip.contact.cubic import CubicSpring
from stickslip.contact.point import Contact, between
from stickslip.loads import Force
from stickslip.problem import Problem
from stickslip.stability.multipliers import Stability
from stickslip.structure.matrices import Structure
from stickslip.units import Band
from verify.row import INDEPENDENT, Row, at_most

TITLE = "Stability of periodic motions"
ABOUT = (
    "Random problems of `robustness/problems.py` with lift-off and barely pressed contacts, gaps and start states, and masses on "
    "cubic springs: of every curve one stable point and up to two unstable ones, integrated in time from their own state with "
    "600 steps a period. A point counts as unstable in time where the motion leaves the periodic one."
)
POINTS = 200
UNSTABLE_POINTS = 80
KINDS = ("lift-off", "barely pressed", "cubic", "start state", "constant load", "varying load")
NEAR = 0.02
"""Largest multipliers this near to the unit circle would take hundreds of periods to show themselves in time."""


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
    """The curve of a case with its stability; None where it could not be traced."""
    if kind == "cubic":
        problem, band, level = cubic_case(seed)
    else:
        case = random_case(kind, seed)
        problem, band, level = case.problem, case.band, case.level
    try:
        return forced_response(problem, band, level, harmonics=11, samples=512).with_stability()
    except InputError:
        return None


def compared(kind: str, seed: int, rng: np.random.Generator) -> Iterator[Compared]:
    """The chosen points of a case."""
    response = response_of(kind, seed)
    if response is None:
        return
    flags, multipliers = response.dataset["stability"].values[0], response.dataset["multiplier"].values[0]
    for wanted, count in ((Stability.STABLE, 1), (Stability.UNSTABLE, 2), (Stability.UNDECIDED, 1)):
        chosen = np.flatnonzero(flags == wanted)
        for point in rng.permutation(chosen)[:count]:
            check = response.verify_in_time(0, int(point), steps_per_period=600, periods=400)
            yield Compared(f"{kind} {seed}", int(point), complex(*multipliers[point]), Stability(wanted), has_left(check))


def has_left(check: TimeCheck) -> bool | None:
    """Whether the motion in time left the periodic one, ten times as far as the error of the first period."""
    first, last = (float(each.max()) for each in (check.first_period_difference, check.period_difference))
    if check.unstable or (last > 0.02 and last > 10.0 * first):
        return True
    return False if last + min(check.distance, 1.0) <= max(0.05, 10.0 * first) else None


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
