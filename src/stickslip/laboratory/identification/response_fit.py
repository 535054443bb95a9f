"""Least squares of measured against computed responses: variables, residuals with exact derivatives, covariance.

Variables are those of all tests (parameters), then for each test its own parameters, gain, phase and start state. A parameter
whose bounds are positive is fitted by its logarithm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import special
from scipy.optimize import least_squares

from stickslip.laboratory.identification.computed_response import ComputedResponse, FittedTest
from stickslip.laboratory.identification.enclosed_test import EnclosedTest
from stickslip.laboratory.identification.model_error import FEWEST_TESTS, error_between_tests, independent_one_in
from stickslip.support.checks import Array, Index, fault, finite, positive, truth

TINY = 1e-10
"""Share of the largest curvature below which the data say nothing of a direction."""

MISSED = -2.0
"""Logarithm of computed over measured that a point without a solution counts as."""

GAIN, PHASE = "gain", "phase offset"
"""Names of the variables of a measuring chain."""

UNFINISHED = 0.02
"""Share of the sum of squares, and of that of the stated errors, that a fit which has ended no longer gains by a step."""

MOST_STARTS, EXPLAINED = 4, 3.0
"""Starts that are fitted at most, and the residual in standard errors, root mean square, from which on another one is."""

BROAD = 10.0
"""Limit of ln gain, of a phase offset and of start variables that no other bound holds."""


@dataclass(frozen=True)
class FreeParameter:
    """A parameter to identify: where it starts and its bounds, in the units of the problem's argument.

    each_test: it has a value of its own in every test. deviation: standard deviation of what is known of it beforehand about
    `start` (a prior), or None for nothing.
    """

    start: float
    low: float
    high: float
    each_test: bool = False
    deviation: float | None = None

    def __post_init__(self) -> None:
        for name in ("start", "low", "high"):
            finite(name, getattr(self, name))
        if not self.low <= self.start <= self.high or self.low == self.high:
            raise fault("start", "must lie between low and high, which differ", (self.start, self.low, self.high))
        truth("each_test", self.each_test)
        if self.deviation is not None:
            positive("deviation", self.deviation)

    @property
    def logarithmic(self) -> bool:
        return self.low > 0.0

    def variable(self, value: float) -> float:
        """The variable of a value: its logarithm, or its place between the bounds."""
        return float(np.log(value)) if self.logarithmic else (value - self.low) / (self.high - self.low)

    def value(self, variable: float) -> float:
        """The value of a variable."""
        return float(np.exp(variable)) if self.logarithmic else self.low + (self.high - self.low) * variable

    def slope(self, value: float) -> float:
        """d value/d variable."""
        return value if self.logarithmic else self.high - self.low


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
class ResponseFit:
    """The least squares of several tests; `start_deviation`: of the start variables' prior; `evaluated`: called with the number
    of each evaluation; `excluded`: of each test, points (n,) whose residuals count as zero."""

    tests: Sequence[FittedTest | EnclosedTest]
    free: Mapping[str, FreeParameter]
    start_deviation: float = 0.5
    _last: dict[bytes, tuple[Array, Array]] = field(default_factory=dict)
    computed: list[ComputedResponse | None] = field(default_factory=list)
    evaluations: int = 0
    evaluated: Callable[[int], object] = lambda count: None
    excluded: Sequence[NDArray[np.bool_]] = ()

    @cached_property
    def variables(self) -> list[Variable]:
        """All variables in order."""
        shared = [self._variable(name, -1) for name, free in self.free.items() if not free.each_test]
        return shared + [variable for t in range(len(self.tests)) for variable in self._own(t)]

    def _variable(self, name: str, test: int) -> Variable:
        free = self.free[name]
        low, start, high = (free.variable(value) for value in (free.low, free.start, free.high))
        deviation = None if free.deviation is None else free.deviation / free.slope(free.start)
        return Variable(name, test, start, low, high, deviation)

    def _own(self, t: int) -> list[Variable]:
        """The variables of one test."""
        test, space = self.tests[t].test, self.tests[t].space
        own = [self._variable(name, t) for name, free in self.free.items() if free.each_test]
        own += [
            Variable(name, t, 0.0, -BROAD, BROAD) for name, free in ((GAIN, test.free_gain), (PHASE, test.free_phase)) if free
        ]
        return own + [Variable("start", t, 0.0, -1.0, 1.0, self.start_deviation) for _ in range(space.size if space else 0)]

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

    def jacobian(self, x: Array) -> Array:
        """Their derivatives by the variables."""
        return self._at(x)[1]

    def _at(self, x: Array) -> tuple[Array, Array]:
        key = x.tobytes()
        if key not in self._last:
            self.evaluations += 1
            self.evaluated(self.evaluations)
            parts = [self._of_test(x, t) for t in range(len(self.tests))]
            parts.append(self._priors(x))
            self._last = {key: (np.concatenate([r for r, _ in parts]), np.concatenate([J for _, J in parts]))}
        return self._last[key]

    def _priors(self, x: Array) -> tuple[Array, Array]:
        known = [(k, v) for k, v in enumerate(self.variables) if v.deviation is not None]
        J = np.zeros((len(known), x.size))
        for row, (k, variable) in enumerate(known):
            J[row, k] = 1.0 / (variable.deviation or 1.0)
        return np.array([(x[k] - v.start) / (v.deviation or 1.0) for k, v in known]), J

    def _of_test(self, x: Array, t: int) -> tuple[Array, Array]:
        """Residuals and derivatives of one test."""
        model, places = self.tests[t], self.places[t]
        values = self.values(x, t)
        found = model.computed(values, self.starts(x, t), list(self.free))
        self.computed = (self.computed or [None] * len(self.tests))[: len(self.tests)]
        self.computed[t] = found
        chain = self.chain(x, t)
        shown = chain * found.per_force
        slopes = np.zeros((shown.size, x.size), dtype=complex)
        for name, free in self.free.items():
            slopes[:, places[name][0]] = chain * found.by_value[name] * free.slope(values[name])
        for name, factor in ((GAIN, 1.0), (PHASE, 1.0j)):
            if name in places:
                slopes[:, places[name][0]] = factor * shown
        if "start" in places:
            slopes[:, places["start"]] = chain * found.by_start
        apart, rows = _compared(model, shown, slopes)
        if self.excluded:
            kept = np.tile(~self.excluded[t], apart.size // self.excluded[t].size)
            apart, rows = apart * kept, rows * kept[:, None]
        return apart, rows

    def found(self, t: int) -> ComputedResponse:
        """The computed response of a test where residuals were last evaluated."""
        found = self.computed[t]
        if found is None:
            raise AssertionError("residuals are evaluated first")
        return found

    def shown(self, x: Array, t: int) -> Any:
        """The computed response of a test as its measuring chain shows it, where residuals were last evaluated."""
        return self.chain(x, t) * self.found(t).per_force

    def solved_others(self, x: Array, held: Sequence[int], evaluations: int) -> Array:
        """The variables of the least squares in which those of these numbers stay."""
        others: Index = np.delete(np.arange(x.size), held)
        if not others.size:
            return x
        low, high = (ends[others] for ends in self.bounds)
        inside = np.clip(x[others], low + 1e-9 * (high - low), high - 1e-9 * (high - low))

        def whole(own: Array) -> Array:
            found = x.copy()
            found[others] = own
            return found

        def residuals(own: Array) -> Array:
            return self.residuals(whole(own))

        def jacobian(own: Array) -> Array:
            return self.jacobian(whole(own))[:, others]

        settings: dict[str, Any] = {"bounds": (low, high), "x_scale": "jac", "max_nfev": evaluations}
        return whole(least_squares(residuals, inside, jacobian, **settings).x)

    def solved(self, x: Array, evaluations: int) -> Array:
        """The variables of the least squares from a start."""
        low, high = self.bounds
        inside = np.clip(x, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
        settings: dict[str, Any] = {"bounds": (low, high), "method": "trf", "x_scale": "jac", "max_nfev": evaluations}
        return np.asarray(least_squares(self.residuals, inside, self.jacobian, ftol=1e-10, xtol=1e-9, gtol=1e-10, **settings).x)

    def best(
        self,
        tries: int,
        seed: int,
        evaluations: int,
        most: int = MOST_STARTS,
        begun: Callable[[Array], Array] = lambda start: start,
    ) -> Array:
        """The least squares from the start of the lowest cost: the given one, or one of `tries` more between the bounds.

        Where it explains the tests worse than `EXPLAINED`, further starts are taken in the order of their cost, `most` in all.
        begun: what each start becomes first.
        """
        from scipy.stats import qmc  # takes half a second, which only those who draw shall wait for

        low, high = self.bounds
        shared = [k for k, v in enumerate(self.variables) if v.test < 0]
        starts = [self.start]
        for share in qmc.Sobol(len(shared), seed=seed).random(tries) if tries else []:
            starts.append(self.start)
            starts[-1][shared] = low[shared] + share * (high[shared] - low[shared])
        starts = sorted(map(begun, starts), key=self.cost)
        found: list[tuple[float, Array]] = []
        for x in starts[:most]:
            self.forget()
            solved = self.solved(x, evaluations)
            found.append((self.cost(solved), solved))
            if found[-1][0] < EXPLAINED**2 * self.residuals(solved).size:
                break
        return min(found, key=lambda each: each[0])[1]

    def unfinished(self, x: Array) -> bool:
        """Whether a Gauss-Newton step inside the bounds would still lower the sum of squares by a part of it, beyond rounding."""
        residuals, J = self._at(x)
        low, high = self.bounds
        inside = (x > low + 1e-6 * (high - low)) & (x < high - 1e-6 * (high - low))
        step = np.linalg.lstsq(J[:, inside], -residuals, rcond=1e-10)[0]
        gained = float(np.sum((J[:, inside] @ step) ** 2))
        return gained > max(UNFINISHED * float(np.sum(residuals**2)), UNFINISHED * residuals.size)

    def cost(self, x: Array) -> float:
        """Sum of the squares of the residuals."""
        return float(np.sum(self.residuals(x) ** 2))

    def forget(self) -> None:
        """Forget the solutions known so far: after far jumps they may lie on other branches."""
        for model in self.tests:
            model.forget()
        self._last = {}

    def searched(self, x: Array) -> list[Array]:
        """Bounds (2, n) of the response per force of each test, searched anew; residuals then start from them."""
        self._last = {}
        tests = enumerate(self.tests)
        return [model.searched(self.values(x, t)) for t, model in tests if isinstance(model, EnclosedTest)]

    def widened(self, x: Array) -> bool:
        """Search for wider bounds at the points that lie outside by a standard error; whether there are any."""
        apart, first, found = np.abs(self.residuals(x)) > 1.0, 0, False
        for t, model in enumerate(self.tests):
            own = apart[first : first + len(model.known)]
            first += len(model.known)
            if isinstance(model, EnclosedTest) and np.any(own):
                model.searched(self.values(x, t), own)
                found = True
        self._last = {}
        return found

    def series(self, x: Array) -> list[Array]:
        """The residuals of the tests in the order of their frequencies, real and imaginary ones apart."""
        found, first, residuals = [], 0, self.residuals(x)
        for model in self.tests:
            order = np.argsort(np.asarray(model.test.frequency), kind="stable")
            for _ in range(_rows(model) // order.size):
                found.append(residuals[first : first + order.size][order])
                first += order.size
        return found

    def parted(self, residuals: Array) -> list[Array]:
        """Residuals of each test, (1, points), or where phases are known (2, points) of real and imaginary parts."""
        ends = np.cumsum([0, *map(_rows, self.tests)])
        return [
            residuals[first:last].reshape(-1, np.size(model.test.frequency))
            for model, first, last in zip(self.tests, ends[:-1], ends[1:], strict=True)
        ]

    @property
    def rows(self) -> list[int]:
        """How many residuals a point of each test has."""
        return [1 if model.test.phase is None else 2 for model in self.tests]

    def without(self, marks: Sequence[NDArray[np.bool_]]) -> ResponseFit:
        """The fit without marked points of each test."""
        return replace(self, excluded=marks, _last={})

    def _between_tests(self, residuals: Array, J: Array) -> Array:
        """Standard errors of the shared variables by the disagreement of the tests."""
        ends = np.cumsum([0, *map(_rows, self.tests)])
        shared = sum(variable.test < 0 for variable in self.variables)
        held = [v.test for v in self.variables if v.deviation is not None]
        priors = ends[-1] + np.arange(len(held))
        parts = []
        for t in range(len(self.tests)):
            rows = np.concatenate([np.arange(ends[t], ends[t + 1]), priors[np.array(held, dtype=int) == t]])
            own = np.array([k for k, variable in enumerate(self.variables) if variable.test == t], dtype=np.int64)
            parts.append((residuals[rows], J[rows], own))
        known = J[priors[np.array(held, dtype=int) < 0], :shared]
        return error_between_tests(parts, known.T @ known, shared)

    def statistics(self, x: Array) -> FitStatistics:
        """Standard errors and correlations at a solution.

        Residuals that go together along the curves count by the number of independent ones, and errors are then not smaller than
        those by the disagreement of the tests.
        """
        residuals, J = self._at(x)
        priors = sum(v.deviation is not None for v in self.variables)
        data = residuals[: residuals.size - priors]
        own = J[: data.size]
        curvature = J.T @ J
        scale = np.sqrt(np.maximum(np.diag(curvature), 1e-300))
        values, vectors = np.linalg.eigh(curvature / np.outer(scale, scale))
        known = values > TINY * values.max(initial=1.0)
        inverse = (vectors[:, known] / values[known]) @ vectors[:, known].T
        covariance = inverse / np.outer(scale, scale)
        # Variables that a prior holds count by the share of them that the data determine.
        determined = float(np.trace(covariance @ own.T @ own))
        freedom = max(data.size - determined, 1.0)
        noise = float(np.sum(data**2) / freedom)
        blind = np.sum(vectors[:, ~known] ** 2, axis=1) > 0.1
        one_in = independent_one_in(self.series(x))
        quantile = float(special.stdtrit(max(data.size / one_in - determined, 1.0), 0.975))
        error = np.sqrt(noise * one_in * np.diag(covariance))
        if one_in > 1.0 and len(self.tests) >= FEWEST_TESTS:
            between = self._between_tests(residuals, J) * float(special.stdtrit(len(self.tests) - 1, 0.975)) / quantile
            error[: between.size] = np.maximum(error[: between.size], between)
        return FitStatistics(np.where(blind, np.inf, error), covariance, noise, quantile, blind, one_in)


@dataclass(frozen=True, eq=False)
class FitStatistics:
    """Standard errors and covariance of the variables; noise: residual variance over that of the stated errors; quantile: of a
    95 % interval in standard errors; blind: variables that the data say nothing of; one_in: of so many residuals one is
    independent."""

    error: Array
    covariance: Array
    noise: float
    quantile: float
    blind: np.ndarray[Any, np.dtype[np.bool_]]
    one_in: float = 1.0

    @property
    def without_curvature(self) -> FitStatistics:
        """A copy that calls no variable blind, where intervals do not come from the curvature."""
        return replace(self, blind=np.zeros_like(self.blind))

    @property
    def correlation(self) -> Array:
        size = np.sqrt(np.maximum(np.diag(self.covariance), 1e-300))
        return np.asarray(self.covariance / np.outer(size, size))


def _rows(model: FittedTest | EnclosedTest) -> int:
    """How many residuals a test has."""
    return int(np.size(model.test.frequency)) * (1 if model.test.phase is None else 2)


def _compared(model: FittedTest | EnclosedTest, shown: Any, slopes: Any) -> tuple[Array, Array]:
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
