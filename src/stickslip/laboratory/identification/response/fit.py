"""The response per force of a problem at the points of a measured test, with exact derivatives by parameters and start states.

Each point takes its own measured force, or its own measured response, and starts from the solution that was last kept there.

Least squares of measured against computed responses: variables, and residuals with exact derivatives.

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
from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.model.contact.protocol import SLIPPING
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.fourier import Harmonics
from stickslip.solve.balance.measure import quantity_named
from stickslip.solve.balance.system import Control
from stickslip.solve.continuation.continuation import first_held, scaled, solve_cold, trace
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.solve.continuation.sensitivity import mean_slopes, respond, solved_factors
from stickslip.solve.curves.curve import force_phase
from stickslip.solve.starts.states import StartSpace
from stickslip.support.checks import Array

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
    def unsolved(cls, count: int, names: Sequence[str], starts: int = 0) -> "ComputedResponse":
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
    def of(cls, test: MeasuredResponse, problem_of: Callable[..., Problem], harmonics: Harmonics, samples: int) -> "FittedTest":
        """A test before its first evaluation."""
        return cls(test, problem_of, harmonics, samples, [None] * np.size(test.frequency))

    def problem(self, values: Values) -> Problem:
        """The problem of parameter values in this test."""
        return self.problem_of(**values, **self.test.settings)

    def balance(self, values: Values, starts: Array) -> HarmonicBalance:
        """The balance of parameter values, from the start states of variables (variables,)."""
        balance = HarmonicBalance(self.problem(values), self.harmonics, self.samples)
        return balance if self.space is None else self.space.balance(balance, starts)

    def computed(self, values: Values, starts: Array, names: Sequence[str]) -> "ComputedResponse":
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

    def keep(self, computed: "ComputedResponse") -> None:
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
            by_start = np.zeros((self.space.size, balance.rows, balance.columns))
            for element, row, slope in zip(*mean_slopes(balance, evaluation), strict=True):
                if self.space.varied[element]:
                    by_start[self.space.group[element], row, 0] += self.space.scale[element] * slope
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

    tests: "Sequence[FittedTest]"
    free: Mapping[str, FreeParameter]
    start_deviation: float = 0.5
    _last: dict[bytes, tuple[Array, Array]] = field(default_factory=dict)
    computed: "list[ComputedResponse]" = field(default_factory=list)
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


def _compared(model: "FittedTest", shown: Any, slopes: Any) -> tuple[Array, Array]:
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
