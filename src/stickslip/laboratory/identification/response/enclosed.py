"""A measured test against the bounds of its response over all start states, with derivatives of the bounds by the parameters.

A point inside its bounds is explained by some start state and has no residual; one outside has the distance to the nearer bound.
That a point lies inside, two start states prove, one with a larger and one with a smaller response: only where the last ones do
not, the search of `response_bounds` goes on from them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.variability.bounds_search import LOWER, SIGNS, UPPER, BoundsSearch
from stickslip.analyses.variability.samples import search_cloud
from stickslip.laboratory.identification.response.model import ComputedResponse, FittedTest, Values, slips
from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.balance.measure import Measure, quantity_named
from stickslip.solve.balance.orders import Harmonics
from stickslip.solve.starts.extremes import AtFrequency, Effort, Extreme, extreme, size_of
from stickslip.solve.starts.states import Rules, Sharing, StartSpace, UnsolvedError, explored_space
from stickslip.support.checks import Array, InputError, fault

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


def padded(parts: Sequence[Array]) -> Array:
    """Arrays of several tests as one, (tests, ...), NaN behind the shorter ones."""
    found = np.full((len(parts), *np.max([part.shape for part in parts], axis=0)), np.nan)
    for one, part in zip(found, parts, strict=True):
        one[tuple(slice(size) for size in part.shape)] = part
    return found
