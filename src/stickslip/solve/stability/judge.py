"""Whether a solution of the harmonic balance is stable: the one judge of peaks, ends of curves and all points.

What decides, in this order: friction and damping let all motions approach each other (`model/problem/contraction.py`); the
multipliers of the true motion beside the solution, found by marching sliders and springs from event to event (`orbit.py`); for
laws with kernels of their own, and more coordinates than the march can take, the map of a disturbance on the solution itself
(`multipliers.py`), where its steps follow the stiffest contact and no contact lifts off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.table import contact_table
from stickslip.model.problem import Problem
from stickslip.model.problem.contraction import Contraction, contraction
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.stability.event_march import EventMarch, LostMotionError
from stickslip.solve.stability.multipliers import SOFT, ContactPeriod, PeriodMap, Stability, stiffest_mean_spring
from stickslip.solve.stability.orbit import PERIODS, Orbit, OrbitSearch
from stickslip.support.checks import InputError

MOST_COORDINATES, MOST_SLIDERS = 40, 40
"""That are followed from event to event: the time goes with the cube of the one, and every slider makes events of its own."""

KEPT = 8.0
"""Modes up to so many times the highest harmonic of the highest frequency move by themselves."""

NEAR = 0.1
"""Distance of the true motion from the solution, relative to the vibration, up to which it is that of the solution."""

CIRCLE = 1e-4
"""Distance of a multiplier from the unit circle within which no verdict is given."""

LEFT = 3.0
"""Times its first size to which a disturbance must grow for an unstable motion."""


@dataclass(frozen=True)
class Verdict:
    """Stability, with the largest multiplier and its error, the sliders that never slip, the distance of the true motion from the
    solution relative to the vibration, how many periods a disturbance takes to leave it, and why the stability is undecided or
    not judged. NaN where a number was not computed."""

    stability: Stability
    multiplier: complex = complex(np.nan, np.nan)
    error: float = np.nan
    exact_ones: int = 0
    distance: float = np.nan
    leaves: int = 0
    reason: str = ""
    resolved: bool = True


class Judge:
    """Verdicts on the solutions of one balance.

    fastest: the highest ω of them, rad/s; highest: natural frequency [rad/s] up to which modes move by themselves, `KEPT` times
    the highest harmonic of that unless given; numbers: whether multipliers are wanted where the verdict does not need them.
    """

    def __init__(self, balance: HarmonicBalance, fastest: float, highest: float | None = None, *, numbers: bool = False) -> None:
        self.balance, self.fastest, self.numbers = balance, fastest, numbers
        self.highest = KEPT * balance.highest * fastest if highest is None else highest
        self._searches: dict[float, OrbitSearch | None] = {}
        self._contractions: dict[float, Contraction] = {}
        self._maps: list[PeriodMap] = []

    @property
    def dropped(self) -> int:
        """Modes that follow at once, as far as a verdict was asked for."""
        marches = [search.march for search in self._searches.values() if search is not None]
        return max([*(march.dropped for march in marches), *(each.modes.dropped for each in self._maps)], default=0)

    def verdict(self, evaluation: Evaluation) -> Verdict:
        """Whether a solution is stable."""
        omega = evaluation.point.omega if self.balance.problem.speed is not None else 0.0
        problem = self.balance.problem.at_frequency(omega)
        if omega not in self._contractions:
            self._contractions[omega] = contraction(problem)
        certain = self._contractions[omega]
        if certain == Contraction.VANISHES and not self.numbers:
            return Verdict(Stability.STABLE)
        if omega not in self._searches:
            self._searches[omega] = self._search(problem)
        search = self._searches[omega]
        found = self._on_map(evaluation) if search is None else _of_orbit(search, search.beside(evaluation))
        if certain == Contraction.VANISHES:
            return Verdict(Stability.STABLE, found.multiplier, found.error, found.exact_ones, found.distance)
        if certain == Contraction.NEVER_GROWS and found.stability == Stability.UNSTABLE:
            reason = "a disturbance cannot grow, but nothing shows that it dies out"
            return Verdict(Stability.UNDECIDED, found.multiplier, found.error, found.exact_ones, found.distance, reason=reason)
        return found

    def _search(self, problem: Problem) -> OrbitSearch | None:
        """The search for true motions; None where they cannot be followed from event to event."""
        of_load = self.fastest * max(harmonic for force in problem.forces for harmonic in force.amplitudes)
        table = contact_table(problem.contacts)
        if (
            np.any(table.kind != SLIDERS)
            or table.stiffness.size > MOST_SLIDERS
            or problem.systems.gas
            or problem.systems.stiffens
        ):
            return None
        if problem.mean_springs and stiffest_mean_spring(problem) > SOFT:
            return None
        try:
            march = EventMarch(problem, self.highest, MOST_COORDINATES, of_load)
        except InputError:
            return None
        return OrbitSearch(march, self.balance)

    def _on_map(self, evaluation: Evaluation) -> Verdict:
        """By the map of a disturbance on the solution itself."""
        if not self._maps:
            self._maps.append(PeriodMap(self.balance, self.highest))
        period = self._maps[0]
        if ContactPeriod(evaluation, self.balance).lifts_off:
            return Verdict(Stability.UNKNOWN, reason="contacts lift off, and the motion cannot be followed from event to event")
        found = period.multipliers(evaluation)
        if not found.follows_contacts:
            return Verdict(Stability.UNDECIDED, reason="a disturbance cannot be followed through contacts as stiff as these")
        return Verdict(found.verdict, found.leading, found.error, found.exact_ones, resolved=found.resolved)


def _of_orbit(search: OrbitSearch, orbit: Orbit | None) -> Verdict:
    """By the multipliers of the true motion, where it is near."""
    if orbit is None:
        return Verdict(Stability.UNDECIDED, reason="a period of the true motion could not be followed", resolved=False)
    if not orbit.closed:
        words = f"no periodic motion was found beside it (over a period, the nearest changes by {100.0 * orbit.defect:.2g} %)"
        return Verdict(Stability.UNDECIDED, reason=words, resolved=False)
    multiplier, size = orbit.leading, abs(orbit.leading)
    error = orbit.defect / max(float(np.abs(1.0 - multiplier)), np.finfo(float).tiny)
    numbers = multiplier, error, orbit.exact_ones, orbit.distance
    if orbit.distance > NEAR:
        return Verdict(
            Stability.UNDECIDED,
            *numbers,
            reason=f"the nearest true motion differs by {100.0 * orbit.distance:.2g} %",
            resolved=False,
        )
    if abs(size - 1.0) <= max(CIRCLE, error):
        return Verdict(Stability.UNDECIDED, *numbers, reason=f"its largest multiplier has a size of {size:.6g}")
    try:
        sides = search.sides(orbit)
        grown = min(LEFT, 1.0 + 0.5 * (size**PERIODS - 1.0))
        leaves = search.periods_to_leave(orbit, grown) if size > 1.0 else 0
    except LostMotionError:
        return Verdict(Stability.UNDECIDED, *numbers, reason="a disturbed motion could not be followed")
    if any((side > 1.0) != (size > 1.0) for side in sides):
        words = (
            f"a contact only touches, and a disturbance grows by {sides[0]:.4g} to one side and by {sides[1]:.4g} to the other"
        )
        return Verdict(Stability.UNDECIDED, *numbers, reason=words)
    if leaves is None:
        words = f"its largest multiplier is {size:.4g}, but a disturbed motion stays beside it for {PERIODS} periods"
        return Verdict(Stability.UNDECIDED, *numbers, reason=words)
    return Verdict(Stability.UNSTABLE if size > 1.0 else Stability.STABLE, *numbers, leaves=leaves)
