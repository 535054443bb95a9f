"""Stability of solved points against time integration: random problems of every law, several kinds of instability."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from robustness.problems import random_case
from stickslip.analyses.forced_response import ForcedResponse, forced_response
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.analyses.time_response import TimeCheck
from stickslip.model.contact.cubic import CubicSpring
from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.friction_disc import FrictionDisc
from stickslip.model.contact.law import Law
from stickslip.model.contact.microslip import Iwan
from stickslip.model.contact.point import Contact, between
from stickslip.model.contact.tanh_coulomb import TanhCoulomb
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.solve.stability.multipliers import Multipliers, PeriodMap, Stability
from stickslip.support.checks import InputError
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band
from verify.row import INDEPENDENT, Row, at_most

TITLE = "Stability of periodic motions"
ABOUT = (
    "Random problems: those of `robustness/problems.py` with lift-off, barely pressed contacts, loads and start states, also "
    "with modal damping ratios of 1e-4 to 1e-2; masses on cubic springs; masses on a friction disc, on Dahl's law, on smoothed "
    "Coulomb friction and on Iwan contacts. Each is traced over a part of its band, with 21 harmonics; of 16 points, drawn "
    "blindly, one stable one and one of each kind of instability are compared with `verify_in_time`: the periodic motion found "
    "by shooting, its multipliers by differences of marched periods of 1000 steps, of 4000 where they contradict, where there "
    "are none, where the size is within 3e-3 of 1 or the two differ by 1e-2; without multipliers it is marched on until it "
    "leaves or settles. Points whose motion in time differs by more than 0.5 % have too few harmonics and do not count."
)
POINTS = 200
UNSTABLE_POINTS = 60
KINDS = ("lift-off", "cubic", "barely pressed", "light damping", "laws", "start state", "varying load", "constant load")
MOST_SEEDS = 60
FEW_SEEDS = 5
"""Of barely pressed contacts, whose curves have thousands of points."""

TRIED = 16
"""Points of a curve whose multipliers are computed."""

PART = 0.2
"""Part of a band that is traced."""

RESOLVED = 5e-3
"""Difference of harmonic balance and time beyond which the harmonics are too few: their motion is not the periodic one."""

NEAR, APART = 3e-3, 1e-2
"""Distance from the unit circle, and difference of the two multipliers, from which that in time is computed with more steps."""

STEPS, MORE_STEPS = 1000, 4000
PERIODS = 500, 2000
"""Periods marched where shooting finds no periodic motion."""


class Compared(NamedTuple):
    """A point: its multipliers, and what time integration says of it."""

    name: str
    point: int
    found: Multipliers
    check: TimeCheck

    @property
    def kind(self) -> str:
        """Stable, or the kind of instability by the largest multiplier."""
        return kind_of(self.found)

    @property
    def judged(self) -> bool:
        """Whether time integration says anything: it has a multiplier, leaves the motion, or settles on it."""
        return bool(np.isfinite(self.check.multiplier)) or self.check.unstable or self.check.periodic

    @property
    def contradicted(self) -> bool:
        """Whether time integration says the opposite of the verdict."""
        decided = self.found.verdict in (Stability.STABLE, Stability.UNSTABLE)
        return decided and self.judged and self.check.unstable != (self.found.verdict == Stability.UNSTABLE)

    @property
    def difference(self) -> float:
        """Of the sizes of the largest multipliers, relative where they are above 1; NaN without one in time."""
        size = abs(self.check.multiplier)
        return abs(abs(self.found.leading) - size) / max(size, 1.0)


def kind_of(found: Multipliers) -> str:
    """The verdict; for an unstable point how, by its largest multiplier."""
    if found.verdict != Stability.UNSTABLE:
        return found.verdict.name.lower()
    if abs(found.leading.imag) > 1e-6 * abs(found.leading):
        return "complex pair"
    return "positive multiplier" if found.leading.real > 0.0 else "negative multiplier"


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


def law_case(seed: int) -> tuple[Problem, Band, float]:
    """A mass in space on one contact whose load varies, or lifts off; all laws with kernels of their own, and Iwan's."""
    rng = np.random.default_rng([78, seed])
    K = np.diag(rng.uniform(0.5, 2.0, 3)) + 0.2 * np.ones((3, 3))
    structure = Structure(np.eye(3), K, ("1.x", "1.y", "1.z"), damping=ModalDamping(float(10.0 ** rng.uniform(-3.0, -1.5))))
    kt, mu, kn = (float(value) for value in rng.uniform((0.3, 0.2, 0.3), (2.0, 0.8, 3.0)))
    load = {"kn": kn, "preload": float(rng.uniform(0.0, 2.0))}
    law: Law
    match seed % 4:
        case 0:
            law = FrictionDisc(kt, mu, **load)
        case 1:
            law = Dahl(kt, mu, **load)
        case 2:
            law = TanhCoulomb(mu, 0.2, **load)
        case _:
            law = Iwan(kt, mu, **load, count=8)
    contact = Contact("contact", law, (between("1.x", "ground"), between("1.y", "ground")), between("1.z", "ground"))
    forces = (Force("1.x", 1.0), Force("1.y", 0.6j), Force("1.z", float(rng.uniform(0.3, 1.5))))
    return Problem(structure, (contact,), forces, ("1.x", "1.z"), f"laws {seed}"), Band(0.08, 0.4), float(rng.uniform(0.5, 3.0))


def case_of(kind: str, seed: int) -> tuple[Problem, Band, float]:
    """Problem, band and force level of a case."""
    if kind == "cubic":
        return cubic_case(seed)
    if kind == "laws":
        return law_case(seed)
    light = kind == "light damping"
    case = random_case("lift-off" if light else kind, seed + 1000 * light)
    if light:
        ratio = float(10.0 ** np.random.default_rng([79, seed]).uniform(-4.0, -2.0))
        structure = replace(case.problem.structure, damping=ModalDamping(ratio))
        return replace(case.problem, structure=structure), case.band, case.level
    return case.problem, case.band, case.level


def response_of(kind: str, seed: int) -> ForcedResponse | None:
    """The curve of a case over a part of its band; None where it could not be traced."""
    problem, band, level = case_of(kind, seed)
    low = band.start + (1.0 - PART) * (band.stop - band.start) * float(np.random.default_rng([80, seed]).random())
    try:
        return forced_response(problem, Band(low, low + PART * (band.stop - band.start)), level, harmonics=21, samples=512)
    except InputError:
        return None


def compared(kind: str, seed: int) -> list[Compared]:
    """One point of each kind of stability that the points drawn of a case have."""
    response = response_of(kind, seed)
    if response is None:
        return []
    points, chosen = SolvedPoints(response.dataset, response.problem), dict[str, tuple[int, Multipliers]]()
    map_ = PeriodMap(points.balance)
    converged = np.flatnonzero(response.dataset["outcome"].values[0] == Outcome.CONVERGED)
    for point in map(int, np.random.default_rng([81, seed]).permutation(converged)[:TRIED]):
        found = map_.multipliers(points.evaluation(0, point))
        chosen.setdefault(kind_of(found), (point, found))
    checks = [response.verify_in_time(0, point, steps_per_period=STEPS, periods=2) for point, _ in chosen.values()]
    found = [Compared(f"{kind} {seed}", *of_kind, check) for of_kind, check in zip(chosen.values(), checks, strict=True)]
    return [judged(one, response) for one in found]


def judged(one: Compared, response: ForcedResponse) -> Compared:
    """The point with more steps where they are needed, and with more periods where shooting finds no periodic motion."""
    size = abs(one.check.multiplier)
    if not one.contradicted and abs(size - 1.0) > NEAR and one.difference <= APART:
        return one
    again = one._replace(check=response.verify_in_time(0, one.point, steps_per_period=MORE_STEPS, periods=2))
    if np.isfinite(again.check.multiplier):
        return again
    # The march starts beside the periodic motion, by what the harmonics leave out: only if that falls to a tenth is it stable.
    error = max(0.1 * float(np.max(one.check.first_period_difference)), 1e-8)
    for periods in PERIODS:
        check = response.verify_in_time(0, one.point, steps_per_period=STEPS, periods=periods, tolerance=error)
        marched = one._replace(check=check)
        if marched.judged:
            break
    return marched


def all_compared() -> tuple[list[Compared], int]:
    """The points of all kinds, in turn, until there are enough; and how many had too few harmonics."""
    found: list[Compared] = []
    unresolved = 0
    cases = [(kind, seed) for seed in range(MOST_SEEDS) for kind in KINDS if kind != "barely pressed" or seed < FEW_SEEDS]
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        for (kind, _), of_case in zip(cases, pool.map(compared, *zip(*cases, strict=True)), strict=True):
            for one in of_case:
                error = distance(one)
                unresolved += bool(error > RESOLVED)
                found += [one] if error <= RESOLVED else []
                print(line(one, error), flush=True)
            enough = len(found) >= POINTS and sum(one.found.verdict == Stability.UNSTABLE for one in found) >= UNSTABLE_POINTS
            if enough and kind == KINDS[-1]:
                pool.shutdown(cancel_futures=True)
                break
    return found, unresolved


def distance(one: Compared) -> float:
    """Of the solution from the motion in time, relative."""
    return float(np.nanmax([*one.check.motion_difference, *one.check.first_period_difference]))


def one_seed() -> Iterator[Row]:
    """A case of each kind, but for the curves of thousands of points, against time integration."""
    found = [one for kind in KINDS if kind != "barely pressed" for one in compared(kind, 0) if distance(one) <= RESOLVED]
    decided = [one for one in found if one.judged and one.found.verdict in (Stability.STABLE, Stability.UNSTABLE)]
    lost = len(KINDS) - 1 - len({one.name for one in decided})
    yield at_most("one case of each kind: kinds without a verdict", float(lost), 0.0, INDEPENDENT)
    yield from agreement(found)


def line(one: Compared, error: float) -> str:
    """A point in one line."""
    sizes = f"{abs(one.found.leading):.5f} +- {one.found.error:.0e}, in time {abs(one.check.multiplier):.5f}"
    said = "CONTRADICTED" if one.contradicted else "" if one.judged else "NOT JUDGED"
    return f"    {one.name}, point {one.point}: {one.kind}, {sizes}; motions differ by {error:.0e} {said}"


def rows() -> Iterator[Row]:
    """The rows of this page."""
    found, unresolved = all_compared()
    unstable = [one for one in found if one.found.verdict == Stability.UNSTABLE]
    yield Row("points compared, as a share of 200 at most", min(len(found) / POINTS, 1.0), 1.0, 1e-9, INDEPENDENT, "absolute")
    yield Row("unstable among them, as a share of 60 at most", min(len(unstable) / 60.0, 1.0), 1.0, 1e-9, INDEPENDENT, "absolute")
    for kind in ("positive multiplier", "negative multiplier", "complex pair"):
        share = sum(one.kind == kind for one in unstable) / max(len(unstable), 1)
        yield Row(f"unstable by a {kind}, share of the unstable points", share, 0.5, 0.45, INDEPENDENT, "absolute")
    yield from agreement(found)
    count = max(len(found), 1)
    yield at_most("not judged by time integration, share", sum(not one.judged for one in found) / count, 0.02, INDEPENDENT)
    undecided = [one for one in found if one.found.verdict == Stability.UNDECIDED]
    yield at_most("undecided, share of the points", len(undecided) / count, 0.02, INDEPENDENT)
    farthest = max((abs(abs(one.found.leading) - 1.0) for one in undecided if one.found.resolved), default=0.0)
    yield at_most("undecided for its error: distance of the size from 1, largest", farthest, 1e-3, INDEPENDENT)
    wrong = sum(not one.found.resolved for one in found)
    yield at_most("undecided, multipliers contradict the Jacobian, share of the points", wrong / count, 0.02, INDEPENDENT)
    yield at_most("points with too few harmonics, left out, share", unresolved / (count + unresolved), 0.3, INDEPENDENT)


def agreement(found: list[Compared]) -> Iterator[Row]:
    """Verdicts and multipliers of points beside those of time integration."""
    wrong = sum(one.contradicted for one in found) / max(len(found), 1)
    yield at_most("contradictions, share of the points", wrong, 0.01, INDEPENDENT)
    differences = [one.difference for one in found if np.isfinite(one.difference)]
    yield at_most("size of the largest multiplier against time, median difference", np.median(differences), 1e-3, INDEPENDENT)
