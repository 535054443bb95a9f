"""Least squares of measured against computed responses: variables, and residuals with exact derivatives.

Variables are those of all tests (parameters), then for each test its own parameters, gain, phase and start state.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.laboratory.identification.least_squares import FreeParameter, LeastSquares, Solution
from stickslip.laboratory.identification.response.model import ComputedResponse, FittedTest
from stickslip.support.checks import Array

MISSED = -2.0
"""Logarithm of computed over measured that a point without a solution counts as."""

GAIN, PHASE = "gain", "phase offset"
"""Names of the variables of a measuring chain."""

UNFINISHED = 0.02
"""Share of the sum of squares, and of that of the stated errors, that a fit which has ended no longer gains by a step."""

MOST_STARTS, EXPLAINED = 4, 3.0
"""Starts that are fitted at most, and the residual in standard errors, root mean square, from which on another one is."""

AGREE = 1e-3
"""Relative distance of the sums of squares of two starts up to which both have ended in the same minimum."""

RESTARTS, TRIED = 4, 15
"""Other start states from which a test that is not explained is fitted alone, and evaluations of each such fit, at most."""

BROAD = 10.0
"""Limit of ln gain, of a phase offset and of start variables that no other bound holds."""


@dataclass(frozen=True)
class Variable:
    """One variable of the fit: its name, test (−1: all), start and bounds; mean and deviation of a prior."""

    name: str
    test: int
    start: float
    low: float
    high: float
    deviation: float | None = None


@dataclass(eq=False)
class ResponseFit(LeastSquares):
    """The least squares of several tests; `start_deviation`: of the start variables' prior; `evaluated`: called with the number
    of each evaluation; `excluded`: of each test, points (n,) whose residuals count as zero; `computed`: the responses of the
    tests where residuals were last evaluated."""

    stops = MappingProxyType({"x_scale": "jac", "ftol": 1e-10, "xtol": 1e-9, "gtol": 1e-10})

    tests: Sequence[FittedTest]
    free: Mapping[str, FreeParameter]
    start_deviation: float = 0.5
    _last: dict[bytes, tuple[Array, Array]] = field(default_factory=dict)
    computed: list[ComputedResponse] = field(default_factory=list)
    evaluations: int = 0
    evaluated: Callable[[int], object] = lambda count: None
    excluded: Sequence[NDArray[np.bool_]] = ()

    @cached_property
    def variables(self) -> list[Variable]:
        """All variables in order."""

        def of(name: str, test: int) -> Variable:
            free = self.free[name]
            low, start, high = (free.variable(value) for value in (free.low, free.start, free.high))
            deviation = None if free.deviation is None else free.deviation / free.slope(free.start)
            return Variable(name, test, start, low, high, deviation)

        found = [of(name, -1) for name, free in self.free.items() if not free.each_test]
        for t, model in enumerate(self.tests):
            chain = ((GAIN, model.test.free_gain), (PHASE, model.test.free_phase))
            found += [of(name, t) for name, free in self.free.items() if free.each_test]
            found += [Variable(name, t, 0.0, -BROAD, BROAD) for name, free in chain if free]
            found += [Variable("start", t, 0.0, -1.0, 1.0, self.start_deviation)] * (model.space.size if model.space else 0)
        return found

    @cached_property
    def shared(self) -> list[int]:
        """The numbers of the variables that all tests have in common, which are the first ones."""
        return [k for k, variable in enumerate(self.variables) if variable.test < 0]

    @cached_property
    def places(self) -> list[dict[str, list[int]]]:
        """For each test, the numbers of the variables that act on it, by name."""
        found: list[dict[str, list[int]]] = [{} for _ in self.tests]
        for k, variable in enumerate(self.variables):
            for t in range(len(self.tests)) if variable.test < 0 else [variable.test]:
                found[t].setdefault(variable.name, []).append(k)
        return found

    @property
    def start(self) -> Array:
        return np.array([variable.start for variable in self.variables])

    @property
    def bounds(self) -> tuple[Array, Array]:
        return np.array([v.low for v in self.variables]), np.array([v.high for v in self.variables])

    def values(self, x: Array, t: int) -> dict[str, float]:
        """The parameters of a test at the variables."""
        return {name: free.value(float(x[self.places[t][name][0]])) for name, free in self.free.items()}

    def starts(self, x: Array, t: int) -> Array:
        """The start variables of a test."""
        return np.asarray(x[self.places[t].get("start", [])])

    def chain(self, x: Array, t: int) -> complex:
        """Gain and phase of the measuring chain of a test."""
        gain, phase = (float(x[self.places[t][name][0]]) if name in self.places[t] else 0.0 for name in (GAIN, PHASE))
        return complex(np.exp(complex(gain, phase)))

    def residuals(self, x: Array) -> Array:
        """Residuals of all tests, (computed − measured)/standard error, and of the priors."""
        return self._at(x)[0]

    def jacobian(self, x: Array, here: Array | None = None) -> Array:
        """Their derivatives by the variables, exact. A search wants them where it has arrived: from here all then starts."""
        slopes = self._at(x)[1]
        for model, computed in zip(self.tests, self.computed, strict=True):
            model.keep(computed)
        return slopes

    def _at(self, x: Array) -> tuple[Array, Array]:
        key = x.tobytes()
        if key not in self._last:
            self.evaluations += 1
            self.evaluated(self.evaluations)
            tests, names = enumerate(self.tests), list(self.free)
            self.computed = [model.computed(self.values(x, t), self.starts(x, t), names) for t, model in tests]
            known = [(k, v.start, 1.0 / v.deviation) for k, v in enumerate(self.variables) if v.deviation is not None]
            priors = np.array([weight * (x[k] - start) for k, start, weight in known])
            slopes = np.zeros((len(known), x.size))
            for row, (k, _, weight) in zip(slopes, known, strict=True):
                row[k] = weight
            parts = [*(self._of_test(x, t) for t in range(len(self.tests))), (priors, slopes)]
            self._last = {key: (np.concatenate([r for r, _ in parts]), np.concatenate([J for _, J in parts]))}
        return self._last[key]

    def _of_test(self, x: Array, t: int) -> tuple[Array, Array]:
        """Residuals and derivatives of one test."""
        found, places, values, chain = self.computed[t], self.places[t], self.values(x, t), self.chain(x, t)
        shown = chain * found.per_force
        slopes = np.zeros((shown.size, x.size), dtype=complex)
        for name, free in self.free.items():
            slopes[:, places[name][0]] = chain * found.by_value[name] * free.slope(values[name])
        for name, factor in ((GAIN, 1.0), (PHASE, 1.0j)):
            if name in places:
                slopes[:, places[name][0]] = factor * shown
        if "start" in places:
            slopes[:, places["start"]] = chain * found.by_start
        apart, rows = _compared(self.tests[t], shown, slopes)
        if self.excluded:
            kept = np.tile(~self.excluded[t], apart.size // self.excluded[t].size)
            apart, rows = apart * kept, rows * kept[:, None]
        return apart, rows

    def shown(self, x: Array, t: int) -> Any:
        """The computed response of a test as its measuring chain shows it, where residuals were last evaluated."""
        return self.chain(x, t) * self.computed[t].per_force

    def misfit(self, x: Array, t: int) -> float:
        """Root mean square of computed − measured response per force of a test, relative to the largest measured one."""
        self.residuals(x)
        shown, test = self.shown(x, t), self.tests[t].test
        apart = shown - test.per_force if test.phase is not None else np.abs(shown) - test.per_force
        return float(np.sqrt(np.mean(np.abs(apart) ** 2)) / np.abs(test.per_force).max())

    def best(
        self,
        tries: int,
        seed: int,
        evaluations: int,
        most: int = MOST_STARTS,
        begun: Callable[[Array], Array] = lambda start: start,
    ) -> Array:
        """The least squares from the start of the lowest cost: the given one, or one of `tries` more between the bounds.

        Where it explains the tests worse than `EXPLAINED`, further starts are taken in the order of their cost, `most` in all,
        until two end in the same minimum.
        begun: what each start becomes first.
        """
        from scipy.stats import qmc  # takes half a second, which only those who draw shall wait for

        low, high = (ends[self.shared] for ends in self.bounds)
        starts = [self.start]
        for share in qmc.Sobol(len(self.shared), seed=seed).random(tries) if tries else []:
            starts.append(self.start)
            starts[-1][self.shared] = low + share * (high - low)

        def in_turn() -> Iterator[Array]:
            for x in sorted(map(begun, starts), key=self.cost)[:most]:
                self.forget()
                yield x

        best = self.solutions(in_turn(), enough, evaluations=evaluations)[0].x
        return self.with_other_starts(best, seed, evaluations)

    def with_other_starts(self, x: Array, seed: int, evaluations: int) -> Array:
        """The least squares from x, where tests that are not explained there begin with other start states, if these fit better.

        Over the start states of a test there are several minima, which differ by much: a search ends where a test is missed by
        far although others explain it. These are drawn from their prior, and fitted with the parameters of all tests held.
        """
        cost, rng, others = self.cost(x), np.random.default_rng(seed), x.copy()
        self.jacobian(x)
        started = {t: model for t, model in enumerate(self.tests) if "start" in self.places[t]}
        before, parts = {t: model.known for t, model in started.items()}, self.parted(self.residuals(x))
        for t, model in started.items():
            if np.mean(parts[t] ** 2) < EXPLAINED**2:
                continue
            numbers = [*self.shared, *(k for k, variable in enumerate(self.variables) if variable.test == t)]
            least = ResponseFit([model], self.free, self.start_deviation).cost(x[numbers])
            for _ in range(RESTARTS):
                own, start = replace(model, known=[None] * len(model.known)), x.copy()
                starts = self.places[t]["start"]
                start[starts] = np.clip(rng.normal(0.0, self.start_deviation, len(starts)), -1.0, 1.0)
                alone = ResponseFit([own], self.free, self.start_deviation)
                other = alone.solved(start[numbers], alone.shared, TRIED)
                if other.cost < least:
                    least, others[numbers], model.known = other.cost, other.x, own.known
                if least < EXPLAINED**2 * parts[t].size:
                    break
        if np.array_equal(others, x):
            return x
        self._last = {}
        solution = self.solved(others, evaluations=evaluations)
        if solution.cost < cost:
            return solution.x
        for t, model in started.items():
            model.known = before[t]
        self._last = {}
        return x

    def unfinished(self, x: Array) -> bool:
        """Whether a Gauss-Newton step inside the bounds would still lower the sum of squares by a part of it, beyond rounding."""
        residuals, J = self._at(x)
        low, high = self.bounds
        inside = (x > low + 1e-6 * (high - low)) & (x < high - 1e-6 * (high - low))
        step = np.linalg.lstsq(J[:, inside], -residuals, rcond=1e-10)[0]
        gained = float(np.sum((J[:, inside] @ step) ** 2))
        return gained > max(UNFINISHED * float(np.sum(residuals**2)), UNFINISHED * residuals.size)

    def forget(self) -> None:
        """Forget the solutions known so far: after far jumps they may lie on other branches."""
        for model in self.tests:
            for k in range(len(model.known)):
                model.known[k] = None
        self._last = {}

    @property
    def rows(self) -> list[int]:
        """How many residuals a point of each test has: two of real and imaginary parts where phases are known."""
        return [1 if model.test.phase is None else 2 for model in self.tests]

    def parted(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """What belongs to the residuals of each test, (rows of a point, points, ...), from that of all."""
        found, first = [], 0
        for model, rows in zip(self.tests, self.rows, strict=True):
            points = np.size(model.test.frequency)
            found.append(values[first : first + rows * points].reshape(rows, points, *values.shape[1:]))
            first += rows * points
        return found

    def series(self, x: Array) -> list[Array]:
        """The residuals of the tests in the order of their frequencies, real and imaginary ones apart."""
        orders = [np.argsort(np.asarray(model.test.frequency), kind="stable") for model in self.tests]
        return [row[order] for part, order in zip(self.parted(self.residuals(x)), orders, strict=True) for row in part]

    def without(self, marks: Sequence[NDArray[np.bool_]]) -> Self:
        """The fit without marked points of each test."""
        return replace(self, excluded=marks, _last={})


def enough(found: Sequence[Solution]) -> bool:
    """Whether the last start explains the tests, or has ended where the best one before it has."""
    *before, last = found
    if last.cost < EXPLAINED**2 * last.residuals.size:
        return True
    least = min((one.cost for one in before), default=0.0)
    return bool(before) and abs(last.cost - least) <= AGREE * least


def _compared(model: FittedTest, shown: Any, slopes: Any) -> tuple[Array, Array]:
    """Residuals and derivatives, complex where the phase is measured, else of sizes.

    Where errors are relative to each point, of the logarithm: a peak in the wrong place then counts no more than a missing one.
    """
    test, solved = model.test, np.abs(shown) > 0.0
    if test.phase is None:
        slopes = np.real(np.conj(shown)[:, None] * slopes) / np.maximum(np.abs(shown), 1e-300)[:, None]
        shown = np.abs(shown)
    if test.of_largest:
        apart, rows = (shown - test.per_force) / test.deviation, slopes / test.deviation[:, None]
    else:
        apart = np.where(solved, np.log(np.where(solved, shown, 1.0) / test.per_force), MISSED) / test.error
        rows = np.where(solved[:, None], slopes / np.where(solved, shown, 1.0)[:, None], 0.0) / test.error
    if test.phase is None:
        return np.asarray(apart), np.asarray(rows)
    return np.concatenate([apart.real, apart.imag]), np.concatenate([rows.real, rows.imag])
