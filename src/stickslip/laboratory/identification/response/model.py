"""The response per force of a problem at the points of a measured test, with exact derivatives by parameters and start states.

Each point takes its own measured force, or its own measured response, and starts from the solution that was last kept there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

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
from stickslip.solve.continuation.sensitivity import respond, solved_factors, start_slopes
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
