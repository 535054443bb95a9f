"""The response per force of a problem at the points of a measured test, with exact derivatives by parameters and start states.

Each point takes its own measured force, or its own measured response, and starts from the solution that was last kept there.

A measured test against the bounds of its response over all start states, with derivatives of the bounds by the parameters.

A point inside its bounds is explained by some start state and has no residual; one outside has the distance to the nearer bound.
That a point lies inside, two start states prove, one with a larger and one with a smaller response: only where the last ones do
not, the search of `response_bounds` goes on from them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.variability.bounds import LOWER, SIGNS, UPPER, BoundsSearch
from stickslip.analyses.variability.samples import search_cloud
from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.model.contact.protocol import SLIPPING
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.fourier import Harmonics
from stickslip.solve.balance.measure import Measure, quantity_named
from stickslip.solve.balance.system import Control
from stickslip.solve.continuation.continuation import solve_cold, trace
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.continuation.held_amplitude import first_held, scaled
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.solve.continuation.sensitivity import respond, solved_factors, start_slopes
from stickslip.solve.curves.curve import force_phase
from stickslip.solve.starts.extremes import AtFrequency, Effort, Extreme, extreme, size_of
from stickslip.solve.starts.states import Rules, Sharing, StartSpace, UnsolvedError, explored_space
from stickslip.support.checks import Array, InputError, fault

Complex = NDArray[np.complex128]
Values = Mapping[str, float]

RAISES = 30
"""Newton solutions on the way from a small force to the measured one, at most."""

BESIDE = 2
"""Solved points, the nearest ones, from which the curve is followed to one where Newton's method fails."""

STEP = 1e-6
"""Of the differences of the balance by a parameter, relative to its value."""


@dataclass(frozen=True, eq=False)
class ComputedResponse:
    """Response per force at the points of a test (n,), 0 where there is no solution; its derivatives by_value {name: (n,)} and
    by_start (n, variables); solved (n,); slips (n,): whether a contact slips or opens there; points (n,): the solutions, where
    the test starts from them again."""

    per_force: Complex
    by_value: Mapping[str, Complex]
    by_start: Complex
    solved: NDArray[np.bool_]
    slips: NDArray[np.bool_]
    points: list[Point | None]

    @classmethod
    def unsolved(cls, count: int, names: Sequence[str], starts: int = 0) -> ComputedResponse:
        """So many points, none of which has a solution yet."""
        by_value = {name: np.zeros(count, dtype=complex) for name in names}
        none = np.zeros(count, dtype=bool)
        by_start = np.zeros((count, starts), dtype=complex)
        return cls(np.zeros(count, dtype=complex), by_value, by_start, none, none.copy(), [None] * count)


@dataclass(eq=False)
class FittedTest:
    """A measured test as the balance computes it; `known`: the solution of each point from which all evaluations start until
    others are kept. Beside a fold a point has several: one that a rejected step has found must not take the place of the one
    that the search has arrived at, which no shorter step would then come back to."""

    test: MeasuredResponse
    problem_of: Callable[..., Problem]
    harmonics: Harmonics
    samples: int
    known: list[Point | None]
    space: StartSpace | None = None

    @classmethod
    def of(cls, test: MeasuredResponse, problem_of: Callable[..., Problem], harmonics: Harmonics, samples: int) -> FittedTest:
        """A test before its first evaluation."""
        return cls(test, problem_of, harmonics, samples, [None] * np.size(test.frequency))

    def problem(self, values: Values) -> Problem:
        """The problem of parameter values in this test."""
        return self.problem_of(**values, **self.test.settings)

    def balance(self, values: Values, starts: Array) -> HarmonicBalance:
        """The balance of parameter values, from the start states of variables (variables,)."""
        balance = HarmonicBalance(self.problem(values), self.harmonics, self.samples)
        return balance if self.space is None else self.space.balance(balance, starts)

    def computed(self, values: Values, starts: Array, names: Sequence[str]) -> ComputedResponse:
        """The response at all points, with its derivatives by the parameters of these names and by the start variables."""
        balance = self.balance(values, starts)
        sides = {name: self.sides(values, starts, name) for name in names}
        found = ComputedResponse.unsolved(len(self.known), names, starts.size)
        for k, own, evaluation in self._solved(balance):
            found.points[k] = evaluation.point
            found.solved[k] = True
            found.slips[k] = slips(own.problem, evaluation)
            slopes = self.slopes(own, evaluation, sides)
            found.per_force[k] = self.per_force(own, evaluation)
            for j, name in enumerate(names):
                found.by_value[name][k] = slopes[j]
            if starts.size:
                found.by_start[k] = slopes[len(names) :]
        return found

    def keep(self, computed: ComputedResponse) -> None:
        """Start from these solutions from now on, where there are any."""
        self.known = [known if point is None else point for point, known in zip(computed.points, self.known, strict=True)]

    @property
    def solutions(self) -> Array:
        """What is known of the points, to begin there again: level and λ, (points, rows, 1 + 2H+1); NaN where nothing is."""
        shape = next((point.forces.shape for point in self.known if point is not None), (1, 0))
        found = np.full((len(self.known), shape[0], 1 + shape[1]), np.nan)
        for one, point in zip(found, self.known, strict=True):
            if point is not None:
                one[:, 0], one[:, 1:] = point.level, point.forces
        return found

    @solutions.setter
    def solutions(self, solutions: Array) -> None:
        """They may be padded by NaN, as those of several tests in one array are."""
        for k, (frequency, one) in enumerate(zip(np.asarray(self.test.frequency), solutions, strict=False)):
            rows, columns = np.isfinite(one[:, 0]), np.isfinite(one[0])
            known = one[rows][:, columns]
            self.known[k] = Point(known[:, 1:], 2.0 * np.pi * float(frequency), float(known[0, 0])) if known.size else None

    def sides(self, values: Values, starts: Array, name: str) -> tuple[HarmonicBalance, HarmonicBalance, float]:
        """The balances on both sides of a value, and their distance."""
        step = STEP * (abs(values[name]) or 1.0)
        high, low = (self.balance({**values, name: values[name] + side * step}, starts) for side in (1.0, -1.0))
        return high, low, 2.0 * step

    def _solved(self, balance: HarmonicBalance) -> Iterator[tuple[int, HarmonicBalance, Evaluation]]:
        """The points that have a solution: number, balance, evaluation. Each begins at what is known of it, else beside it, else
        it is reached along the curve from those beside it."""
        test, found, lost = self.test, dict[int, Evaluation](), list[int]()
        omegas = 2.0 * np.pi * np.asarray(test.frequency, dtype=float)
        row, order = balance.rows + test.output, quantity_named(test.quantity)[0].order
        before: Point | None = None
        for k, (omega, force, amplitude) in enumerate(
            zip(omegas, np.asarray(test.force), np.asarray(test.amplitude), strict=True)
        ):
            held = Control(row, order, float(amplitude)) if test.held == "response" else None
            own = balance.holding(held)
            evaluation = _solution(own, float(omega), float(force), [self.known[k], before])
            if evaluation is not None:
                before, found[k] = evaluation.point, evaluation
                yield k, own, evaluation
            elif held is None:
                lost.append(k)
        for k in lost:
            for beside in sorted(found, key=lambda other: abs(omegas[other] - omegas[k]))[:BESIDE]:
                evaluation = _followed(balance, found[beside].point, float(omegas[k]), float(np.asarray(test.force)[k]))
                if evaluation is not None:
                    yield k, balance, evaluation
                    break

    def slopes(
        self,
        balance: HarmonicBalance,
        evaluation: Evaluation,
        sides: Mapping[str, tuple[HarmonicBalance, HarmonicBalance, float]],
    ) -> Complex:
        """Derivatives of the response per force by the parameters, then by the start variables."""
        forces, motions = [], []
        for high, low, distance in sides.values():
            above, below = high.evaluate(evaluation.point), low.evaluate(evaluation.point)
            forces.append((below.residual - above.residual) / distance)
            motions.append((above.w - below.w) / distance)
        if self.space is not None:
            elements, slopes = start_slopes(balance, evaluation)
            by_start = np.zeros((self.space.size, balance.rows, balance.columns))
            for element, slope in zip(elements, slopes, strict=True):
                if self.space.varied[element]:
                    by_start[self.space.group[element]] += self.space.scale[element] * slope
            forces += list(by_start)
            motions += [np.zeros_like(evaluation.w)] * self.space.size
        if not forces:
            return np.zeros(0, dtype=complex)
        change = respond(balance, evaluation, solved_factors(balance, evaluation), np.array(forces), np.array(motions))
        row, point = balance.rows + self.test.output, evaluation.point
        moved = change.motion[:, row, 1] - 1j * change.motion[:, row, 2]
        per_force = self.per_force(balance, evaluation)
        return np.asarray(moved * self._factor(balance, point) / point.level - per_force * change.level / point.level)

    def per_force(self, balance: HarmonicBalance, evaluation: Evaluation) -> complex:
        """The response per force level at a solved point, with the phase of the displacement."""
        a, b = evaluation.w[balance.rows + self.test.output, 1:3]
        return complex(a, -b) * self._factor(balance, evaluation.point) / evaluation.point.level

    def _factor(self, balance: HarmonicBalance, point: Point) -> complex:
        """What turns X_1 into the measured quantity with the phase of the displacement against the force."""
        phase = force_phase(balance.problem, point.omega) or 0.0
        return complex(point.omega ** quantity_named(self.test.quantity)[0].order * np.exp(-1j * phase))


def slips(problem: Problem, evaluation: Evaluation) -> bool:
    """Whether a contact slips or opens at a solved point; a spring, whose force is unknown at all times, does neither."""
    could = [c.law.rubs or c.normal is not None for c in problem.contacts for _ in c.direction_names]
    return bool(np.any((evaluation.unknown == SLIPPING) & np.array(could, dtype=bool)))


def _solution(balance: HarmonicBalance, omega: float, force: float, known: Sequence[Point | None]) -> Evaluation | None:
    """The solution at a point, from known ones near it, else from the stuck contacts."""
    held = balance.control is not None
    for near in known:
        if near is not None:
            start = replace(near, omega=omega, level=near.level if held else force)
            correction = correct(balance, start, fixed("omega", omega), iterations=15, halvings=6)
            if correction.converged:
                return correction.evaluation
    correction = first_held(balance, omega) if held else solve_cold(balance, omega, force)
    if not correction.converged and not held:
        correction = _raised(balance, omega, force)
    return correction.evaluation if correction.converged else None


def _followed(balance: HarmonicBalance, beside: Point, omega: float, force: float) -> Evaluation | None:
    """The solution at a point by the curve from one beside it: where a fold has passed over a point, the other branch is far."""
    first = correct(balance, replace(beside, level=force), fixed("omega", beside.omega), iterations=15, halvings=6)
    if not first.converged or beside.omega == omega:
        return first.evaluation if first.converged else None
    try:
        *_, last = trace(balance, first, "omega", omega)
    except LostCurveError:
        return None
    return last.evaluation


def _raised(balance: HarmonicBalance, omega: float, force: float) -> Correction:
    """The solution at a force, by few steps from smaller forces: a fit meets parameters where there is none."""
    found, condition = solve_cold(balance, omega, 1e-3 * force), fixed("omega", omega)
    level, growth = 1e-3 * force, 3.0
    for _ in range(RAISES):
        if not found.converged or level == force:
            break
        wanted = min(growth * level, force)
        start = scaled(found.evaluation.point, wanted / level)
        following = correct(balance, start, condition, iterations=15, halvings=6)
        if not following.converged:
            following = correct(balance, replace(start, forces=found.evaluation.point.forces), condition, 30, patience=20)
        if following.converged:
            found, level = following, wanted
        else:
            growth = float(np.sqrt(growth))
    return found if level == force else replace(found, converged=False)


CLOUD, STARTS = 20, 2
"""Start states sampled at a point, and how many of them begin a search there, as `response_bounds` has them."""

FIRST_CLOUD = 6
"""Start states tried at a point where nothing is known yet."""

EFFORT = Effort(iterations=15, tolerance=1e-6, rounds=2, gain=1e-5)
"""Of a search from start states that were extremes for other parameters."""


EDGE, FLAT = 1e-3, 1e-6
"""A step of the start variables beyond the edge of what contacts hold, and the relative slope up to which a response is flat."""


@dataclass(frozen=True, eq=False)
class Bound:
    """A start state (variables) whose response is the least or the largest one known at a point, and its forces λ, if known."""

    variables: Array
    forces: Array | None = None


Bounds = tuple[Bound, Bound]
"""The lower and the upper one of a point."""


@dataclass(eq=False)
class EnclosedTest:
    """A test whose amplitudes are compared with their bounds; `known`: start states of the bounds of each point, by the last
    evaluation."""

    model: FittedTest
    rule: Rules
    share: Sharing
    seed: int
    known: list[Bounds | None] = field(default_factory=list)
    space: None = None

    @classmethod
    def of(
        cls,
        test: MeasuredResponse,
        problem_of: Callable[..., Problem],
        fineness: tuple[Harmonics, int],
        starts: tuple[Rules, Sharing, int],
    ) -> EnclosedTest:
        """A test before its first evaluation; starts: rule, share and seed of the search."""
        for key, wrong in (("held", test.held == "response"), ("free_gain", test.free_gain)):
            if wrong:
                rule = "must be left out with start_states = 'bounds', which holds the force and has no free gain"
                raise fault(f"{key} of {test.name}", rule, getattr(test, key))
        amplitudes = replace(test, phase=None, free_phase=False)
        return cls(FittedTest.of(amplitudes, problem_of, *fineness), *starts, [None] * np.size(test.frequency))

    @property
    def test(self) -> MeasuredResponse:
        """The measured amplitudes."""
        return self.model.test

    @property
    def starts(self) -> Array:
        """Start variables of the bounds, (2, points, start variables), to begin there again; NaN where none are known."""
        size = max((known[0].variables.size for known in self.known if known is not None), default=0)
        found = np.full((2, len(self.known), size), np.nan)
        for k, known in enumerate(self.known):
            if known is not None:
                found[:, k] = [bound.variables for bound in known]
        return found

    @starts.setter
    def starts(self, starts: Array) -> None:
        for k, (low, high) in enumerate(np.moveaxis(starts, 0, 1)):
            self.known[k] = (Bound(low[np.isfinite(low)]), Bound(high[np.isfinite(high)])) if np.any(np.isfinite(low)) else None

    def problem(self, values: Values) -> Problem:
        """The problem of parameter values in this test."""
        return self.model.problem(values)

    def computed(self, values: Values, starts: Array, names: Sequence[str]) -> ComputedResponse:
        """At each point the response nearest to the measured one that some start state has, with its derivatives.

        They are those of the bound at its start state (the derivative of an extreme by a parameter is that at the place of the
        extreme), and zero inside.
        """
        found = ComputedResponse.unsolved(len(self.known), names)
        base = self.model.balance(values, np.zeros(0))
        sides = {name: self.model.sides(values, np.zeros(0), name) for name in names}
        for k, place, amplitude in self._places(base):
            low, high = self._bounds(k, place, amplitude)
            if low is None or high is None:
                continue
            found.solved[k], found.slips[k] = True, any(slips(base.problem, end.evaluation) for end in (low, high))
            nearest = low if amplitude < low.value else high if amplitude > high.value else None
            if nearest is None:
                found.per_force[k] = amplitude / place.level
                continue
            nearest = place.beyond_the_edge(SIGNS[LOWER if nearest is low else UPPER], nearest)
            found.per_force[k] = self.model.per_force(nearest.balance, nearest.evaluation)
            at = {name: [place.space.balance(side, nearest.variables) for side in both] for name, (*both, _) in sides.items()}
            there = {name: (high, low, sides[name][2]) for name, (high, low) in at.items()}
            for name, slope in zip(names, self.model.slopes(nearest.balance, nearest.evaluation, there), strict=True):
                found.by_value[name][k] = slope
        return found

    def _places(self, base: HarmonicBalance) -> Iterator[tuple[int, Place, float]]:
        """The points of the test: number, where the response is searched, and the measured amplitude; none where the virgin
        contacts have no solution."""
        test = self.test
        omega, force = 2.0 * np.pi * np.asarray(test.frequency), np.asarray(test.force)
        ends = np.unique([omega.min(), np.median(omega), omega.max()])
        measure = Measure(quantity_named(test.quantity)[0])
        with suppress(InputError):
            space = explored_space(base, ends.tolist(), float(force.max()), self.rule, self.share)
            for k in range(omega.size):
                yield (
                    k,
                    Place(base, space, measure, test.output, float(omega[k]), float(force[k])),
                    float(np.asarray(test.amplitude)[k]),
                )

    def _bounds(self, k: int, place: Place, amplitude: float) -> tuple[Extreme | None, Extreme | None]:
        """Start states with a response below and above the measured one, or those that come nearest to it."""
        found: list[Extreme | None] = []
        for bound in (LOWER, UPPER):
            begins = [known[bound] for known in (self.known[k], self.known[k - 1] if k else None) if known is not None]
            if self.known[k] is None:
                begins += [Bound(x) for x in search_cloud(place.space.size, FIRST_CLOUD, self.seed)]
            found.append(place.toward(SIGNS[bound], amplitude, begins))
        low, high = found
        if low is not None and high is not None:
            self.known[k] = _bound(low), _bound(high)
        return low, high

    def searched(self, values: Values, wanted: NDArray[np.bool_] | None = None) -> Array:
        """Lower and upper bound (2, n) of the response per force at every point, or where it is wanted (n,); NaN elsewhere.

        By the whole search of `response_bounds`, and by that from the start states known before.
        """
        found = np.full((2, len(self.known)), np.nan)
        chosen = np.ones(len(self.known), dtype=bool) if wanted is None else wanted
        places = [one for one in self._places(self.model.balance(values, np.zeros(0))) if chosen[one[0]]]
        if not places:
            return found
        cloud = search_cloud(places[0][1].space.size, CLOUD, self.seed)
        search = BoundsSearch([place for _, place, _ in places], cloud, STARTS, None, self.seed)
        search.run(lambda share: None)
        for number, (k, place, _) in enumerate(places):
            lower, upper = (place.better(search.best[bound][number], self.known[k], bound) for bound in (LOWER, UPPER))
            if lower is not None and upper is not None:
                found[:, k] = lower.value / place.level, upper.value / place.level
                self.known[k] = _bound(lower), _bound(upper)
        return found


class Place(AtFrequency):
    """A point of a test, where the response is searched for start states with a larger and with a smaller one."""

    def __init__(
        self, balance: HarmonicBalance, space: StartSpace, measure: Measure, output: int, omega: float, level: float
    ) -> None:
        super().__init__(balance, space, size_of(output, measure), omega, level)
        self.level = level

    def toward(self, sign: float, amplitude: float, begins: Sequence[Bound]) -> Extreme | None:
        """The first of some start states whose response is beyond an amplitude (above it: sign 1), else the extreme that the
        search from the best of them finds; None where none has a solution."""
        best: Extreme | None = None
        for begin in begins:
            one = self._solved(begin)
            if one is None:
                continue
            best = one if best is None or sign * one.value > sign * best.value else best
            if sign * (best.value - amplitude) >= 0.0:
                return best
        if best is None:
            return None
        with suppress(UnsolvedError):
            found = extreme(self, sign, [best.variables], EFFORT)
            best = found if sign * found.value > sign * best.value else best
        return best

    def better(self, found: Extreme | None, known: Bounds | None, bound: int) -> Extreme | None:
        """The farther one of what a search found and what the search from the known start state finds."""
        sign = SIGNS[bound]
        other = None if known is None else self.toward(sign, sign * np.inf, [known[bound]])
        both = [one for one in (found, other) if one is not None]
        return max(both, key=lambda one: sign * one.value, default=None)

    def beyond_the_edge(self, sign: float, one: Extreme) -> Extreme:
        """The extreme from a start state a little further the way in which the response still grows (sign 1) or falls.

        At the edge of what a contact can hold nothing changes beyond it, but only there the start state moves with the edge when
        parameters change, as the bound does.
        """
        for variable in range(one.variables.size):
            values = [self._beside(one, variable, change) for change in (-EDGE, EDGE)]
            level = [abs(each.value - one.value) <= FLAT * abs(one.value) for each in values]
            if level[0] != level[1]:
                one = values[level.index(True)]
            elif not any(level):
                best = max(values, key=lambda each: sign * each.value)
                one = best if sign * (best.value - one.value) > 0.0 else one
        return one

    def _beside(self, one: Extreme, variable: int, change: float) -> Extreme:
        """The response of a start state with one variable changed; itself where it has none, or is at the end of the range."""
        moved = one.variables.copy()
        moved[variable] = np.clip(moved[variable] + change, -1.0, 1.0)
        with suppress(UnsolvedError):
            return self.point(moved)
        return one

    def _solved(self, begin: Bound) -> Extreme | None:
        """What a start state gives, from its known forces, else from the stuck contacts."""
        if begin.forces is not None:
            self.solutions.known = [(begin.variables, begin.forces)]
            with suppress(UnsolvedError):
                return self.point(begin.variables)
            self.solutions.known = []
        with suppress(UnsolvedError):
            return self.point(begin.variables)
        return None


def _bound(one: Extreme) -> Bound:
    point: Point = one.evaluation.point
    return Bound(one.variables, point.forces)
