"""Whether a solution of the harmonic balance is stable: the one judge of peaks, ends of curves and all points.

What decides, in this order: friction and damping let all motions approach each other (`model/problem/contraction.py`); the
multipliers of the true motion beside the solution, found by marching sliders and springs from event to event (`OrbitSearch`); for
laws with kernels of their own, and more coordinates than the march can take, the map of a disturbance on the solution itself
(`multipliers.py`), where its steps follow the stiffest contact and no contact lifts off.

The true periodic motion beside a solution of the harmonic balance, by Newton's method on the exact march, and its multipliers.

Of few harmonics, or where contacts are stiff or lift off, a solution of the balance is not quite a motion, and its own contact
events may say more or less than those of the motion. So stability is read from the motion itself, and only where it is near.
"""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import contact_table
from stickslip.model.problem import Problem
from stickslip.model.problem.contraction import Contraction, contraction
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.stability.event_march import EventMarch, LostMotionError, Passage, State
from stickslip.solve.stability.multipliers import ContactPeriod, PeriodMap, Stability
from stickslip.solve.time.march import CORRECTIONS, DISTURBANCE, SMALLEST_STEP, from_harmonics
from stickslip.support.checks import Array, InputError, in_percent

CLOSED = 1e-6
"""Change over a period, relative to the vibration, at which a motion is periodic."""

PUSH = 1e-3
"""Size of a disturbance that is followed, relative to the vibration."""

PERIODS = 30
"""That a disturbed motion is followed for."""

SAMPLES = 64
"""Of a period, at which the motion is compared with the solution."""


@dataclass(frozen=True, eq=False)
class Orbit:
    """begin: state at t = 0; defect: what a period changes of it, relative to the vibration; distance: from the solution, root
    mean square over the period, weighted with the masses, relative to that of the vibration.

    multipliers: largest first, without those of exactly 1 of the `exact_ones` sliders that never slip; vector (states,): a
    disturbance in the space of the largest, and adjoint (states,), which measures how much of a disturbance is, in units of
    `scale`.
    """

    begin: State
    defect: float
    distance: float
    multipliers: NDArray[np.complex128]
    exact_ones: int
    vector: Array
    adjoint: NDArray[np.complex128]
    scale: Array

    @property
    def closed(self) -> bool:
        return self.defect <= CLOSED

    @property
    def leading(self) -> complex:
        """The largest multiplier, with positive imaginary part of a pair; 0 without one."""
        values = self.multipliers
        return complex(values[0].real, abs(values[0].imag)) if values.size else 0j


class OrbitSearch:
    """Orbits beside solutions of one balance."""

    def __init__(self, march: EventMarch, balance: HarmonicBalance) -> None:
        self.march, self.balance = march, balance

    def beside(self, evaluation: Evaluation) -> Orbit | None:
        """The periodic motion beside a solution; None where a period cannot be followed."""
        point, coordinates = evaluation.point, self.march.coordinates
        rows = np.abs(evaluation.w[: self.balance.rows, 1:]).sum(axis=1)
        motions = np.abs(evaluation.w[: self.balance.rows, 0]) + rows
        self.march.at(point.omega, point.level, motions)
        start = from_harmonics(self.balance, point.forces, point.omega, point.level)
        motion = coordinates.weight @ self.balance.linear.whole_motion(point.forces, point.omega, point.level)
        size = float(np.linalg.norm(motion[:, 1:]))
        k, kt = coordinates.size, self.march.table.stiffness
        scale = np.concatenate(
            [np.full(k, size), np.full(k, size * point.omega), kt * max(float(rows.max(initial=0.0)), np.finfo(float).tiny)]
        )
        weight, sizes = self.march.coordinates.weight, (scale, motion)
        begin = State(np.concatenate([weight @ start.motion, weight @ start.velocity]), start.intercepts)
        found: Orbit | None = None
        for settled in (True, False):
            with suppress(LostMotionError):
                found = self._closed(begin, *sizes, settled=settled)
                if found.closed:
                    break
        return found

    def _closed(self, first: State, scale: Array, motion: Array, settled: bool) -> Orbit:
        """Newton's method on P(x) − x = 0 from a state on, or from that after a period in which sliders find their places."""
        x = _packed(self.march.travel(first).end if settled else first)
        passage = self._passage(x)
        left = self._defect(x, passage, scale)
        for _ in range(CORRECTIONS):
            if np.linalg.norm(left) <= 1e-3 * CLOSED:
                break
            own = self._free(passage)
            assert passage.derivative is not None
            matrix = (np.eye(x.size) - passage.derivative * scale / scale[:, None])[np.ix_(own, own)]
            change = np.zeros(x.size)
            change[own] = np.linalg.lstsq(matrix, left[own], rcond=1e-10)[0] * scale[own]
            length, better = 1.0, None
            while length >= SMALLEST_STEP:
                trial = x + length * change
                passage_there = self._passage(trial)
                there = self._defect(trial, passage_there, scale)
                if np.linalg.norm(there) < (1.0 - 0.1 * length) * np.linalg.norm(left):
                    better = trial, passage_there, there
                    break
                length *= 0.5
            if better is None:
                if np.linalg.norm(left) <= CLOSED:
                    break
                x = _packed(passage.end)
                passage = self._passage(x)
                better = x, passage, self._defect(x, passage, scale)
            x, passage, left = better
        return self._orbit(motion, x, passage, left, scale)

    def _passage(self, x: Array) -> Passage:
        return self.march.travel(self._unpacked(x), derivative=True)

    def _unpacked(self, x: Array) -> State:
        size = 2 * self.march.coordinates.size
        return State(x[:size], x[size:])

    def _free(self, passage: Passage) -> NDArray[np.bool_]:
        """The states that a period moves: not the sliders that stick all the time."""
        return np.concatenate([np.ones(2 * self.march.coordinates.size, dtype=bool), passage.moved])

    def _defect(self, x: Array, passage: Passage, scale: Array) -> Array:
        """What a period changes, in units of the vibration."""
        return np.where(self._free(passage), (_packed(passage.end) - x) / scale, 0.0)

    def _orbit(self, motion: Array, x: Array, passage: Passage, left: Array, scale: Array) -> Orbit:
        own = self._free(passage)
        assert passage.derivative is not None
        matrix = (passage.derivative * scale / scale[:, None])[np.ix_(own, own)]
        values, vectors = np.linalg.eig(matrix)
        order = np.argsort(-np.abs(values), kind="stable")
        vector, adjoint = np.zeros(x.size), np.zeros(x.size, dtype=complex)
        if order.size:
            one = vectors[:, order[0]]
            # Of a pair, the phase in which the real part is largest.
            one = one * np.exp(-0.5j * np.angle(np.sum(one * one)))
            vector[own] = one.real / np.linalg.norm(one.real)
            adjoint[own] = np.linalg.pinv(vectors)[order[0]]
            adjoint /= max(abs(adjoint @ vector), np.finfo(float).tiny)
        away = self._distance(x, motion)
        defect, ones = float(np.linalg.norm(left)), int(np.count_nonzero(~passage.moved))
        return Orbit(self._unpacked(x), defect, away, values[order].astype(complex), ones, vector, adjoint, scale)

    def _distance(self, x: Array, motion: Array) -> float:
        """Of the motion that begins at x from that of the solution, (k, 2H+1)."""
        path = self.march.travel(self._unpacked(x), samples=SAMPLES).path
        order, phase = np.arange(1, (motion.shape[1] + 1) // 2), 2.0 * np.pi * np.arange(1, SAMPLES + 1) / SAMPLES
        angles = np.outer(phase, order)
        vibration = np.cos(angles) @ motion[:, 1::2].T + np.sin(angles) @ motion[:, 2::2].T
        away = path - motion[:, 0] - vibration
        return float(np.linalg.norm(away) / max(float(np.linalg.norm(vibration)), np.finfo(float).tiny))

    def sides(self, orbit: Orbit) -> tuple[float, float]:
        """By how much a period multiplies a small disturbance along the vector of the largest multiplier, to either side.

        Where the motion has a derivative, both are the size of the multiplier; where a contact only touches, they need not be.
        """
        one, other = (self._after(orbit, side * DISTURBANCE * orbit.vector) for side in (1.0, -1.0))
        return self._share(orbit, one) / DISTURBANCE, self._share(orbit, other) / DISTURBANCE

    def periods_to_leave(self, orbit: Orbit, grown: float) -> int | None:
        """Periods after which a motion pushed along that vector is so many times as far away; None where it is not within
        `PERIODS`."""
        away = PUSH * orbit.vector
        for period in range(1, PERIODS + 1):
            away = self._after(orbit, away)
            if self._share(orbit, away) >= grown * PUSH:
                return period
        return None

    def _after(self, orbit: Orbit, away: Array) -> Array:
        """The disturbance a period later."""
        centre = _packed(orbit.begin)
        return np.asarray((_packed(self.march.travel(self._unpacked(centre + away * orbit.scale)).end) - centre) / orbit.scale)

    def _share(self, orbit: Orbit, away: Array) -> float:
        return float(abs(orbit.adjoint @ away))


def _packed(state: State) -> Array:
    return np.concatenate([state.motion, state.intercept])


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
        words = f"no periodic motion was found beside it (over a period, the nearest changes by {in_percent(orbit.defect)})"
        return Verdict(Stability.UNDECIDED, reason=words, resolved=False)
    multiplier, size = orbit.leading, abs(orbit.leading)
    error = orbit.defect / max(float(np.abs(1.0 - multiplier)), np.finfo(float).tiny)
    numbers = multiplier, error, orbit.exact_ones, orbit.distance
    if orbit.distance > NEAR:
        return Verdict(
            Stability.UNDECIDED,
            *numbers,
            reason=f"the nearest true motion differs by {in_percent(orbit.distance)}",
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
