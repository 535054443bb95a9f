"""Largest and smallest value of an objective over start states, at a frequency or at the peak of the curve.

Nested: for every start state the response is solved (R = 0 holds exactly), its derivative comes from the implicit function
theorem, and a quasi-Newton method with bounds moves the start state. The extremes are multimodal: several starts. Beyond its
interval a start state is clipped and has no slope: every search goes on from the sliders that it ended with.

The highest resonance peak over a band as a function of the start state, for the search of its extremes.

From one start state to the next the peak moves a little: it is climbed to from the nearest one known. Whole curves are traced for
the start states that searches begin from and for what they find: far-off start states have curves a hundred times dearer.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import scipy

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.energy import EnergyBalance
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.continuation import trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.sensitivity import mean_slopes, solved_factors, weights_of_contact_forces
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.peaks.climb import NoPeakError, PeakSolver, Plane, plane_at
from stickslip.solve.peaks.search import SAME_PEAK, PeakSearch
from stickslip.solve.starts.states import StartSolutions, StartSpace, UnsolvedError, settled
from stickslip.support.checks import Array
from stickslip.support.outcome import Outcome

Weights = Callable[[], tuple[Array, Array]]
"""Derivatives of a value by λ (rows, 2H+1) and by w (motion rows, 2H+1)."""
Objective = Callable[[HarmonicBalance, Evaluation], tuple[float, Weights]]
"""Value at a solved point, and how it changes."""
LEAPS, TRIES, SHARE = 2, 12, 0.2
"""Leaps away from an extreme, start states tried in each, and the share of the variables that leap."""


@dataclass(frozen=True)
class Effort:
    """How far a search goes: iterations of each, their relative tolerance, searches in a row, each from the sliders of the last,
    and the relative gain below which there is no other.
    """

    iterations: int = 40
    tolerance: float = 1e-7
    rounds: int = 4
    gain: float = 1e-5


def size_of(output: int, measure: Measure) -> Objective:
    """A measure of an output, at the frequency of the point."""

    def objective(balance: HarmonicBalance, evaluation: Evaluation) -> tuple[float, Weights]:
        row, motion = balance.rows + output, np.zeros_like(evaluation.w)
        size, motion[row], _ = measure.gradient(evaluation.w[row], evaluation.point.omega)
        return size, lambda: (np.zeros_like(evaluation.point.forces), motion)

    return objective


def loss_factor(energy: EnergyBalance) -> Objective:
    """η = ΔW/(2πU), equation 8 of "An Experimental and Computational Comparison of the Dynamic Response Variability in a Turbine
    Blade with Under-Platform Dampers".
    """

    def objective(balance: HarmonicBalance, evaluation: Evaluation) -> tuple[float, Weights]:
        return energy.loss_factor(evaluation), lambda: energy.loss_factor_weights(evaluation)

    return objective


def start_gradient(balance: HarmonicBalance, space: StartSpace, evaluation: Evaluation, weights: Weights) -> Array:
    """Gradient by the start variables of a function of a solved point."""
    elements, rows, slopes = mean_slopes(balance, evaluation)
    if not elements.size:
        return np.zeros(space.size)
    factors = solved_factors(balance, evaluation)
    return space.gradient(elements, slopes * weights_of_contact_forces(balance, evaluation, factors, *weights())[rows, 0])


@dataclass(frozen=True, eq=False)
class Extreme:
    """A start state (variables) and what it gives: objective value, the balance and the solved point."""

    variables: Array
    value: float
    balance: HarmonicBalance
    evaluation: Evaluation


Place: TypeAlias = "AtFrequency | AtPeak"
"""Where an objective is searched; raises `UnsolvedError` of start states without a solution."""


class AtFrequency:
    """An objective at one frequency in rad/s and one level."""

    def __init__(self, balance: HarmonicBalance, space: StartSpace, objective: Objective, omega: float, level: float) -> None:
        self.space, self.objective = space, objective
        self.solutions = StartSolutions(balance, space, omega, level)

    @property
    def solves(self) -> int:
        """Solutions computed so far."""
        return self.solutions.solves

    def point(self, variables: Array) -> Extreme:
        """What a start state gives, without the gradient."""
        balance, evaluation = self.solutions.solve(variables)
        return Extreme(variables.copy(), self.objective(balance, evaluation)[0], balance, evaluation)

    sample = point

    def confirmed(self, found: Extreme, sign: float) -> Extreme:
        """A solution here stands for itself."""
        return found

    def value(self, variables: Array) -> tuple[Extreme, Array]:
        """What a start state gives, and the gradient."""
        balance, evaluation = self.solutions.solve(variables)
        value, weights = self.objective(balance, evaluation)
        gradient = start_gradient(balance, self.space, evaluation, weights)
        return Extreme(variables.copy(), value, balance, evaluation), gradient


def extreme(place: Place, sign: float, starts: Sequence[Array], effort: Effort | None = None) -> Extreme:
    """The largest (sign 1) or smallest (sign −1) value found from several starts; raises `UnsolvedError` when none solves."""
    found = [_from_start(place, sign, np.clip(start, -1.0, 1.0), effort or Effort()) for start in starts]
    solved = [result for result in found if result is not None]
    if not solved:
        raise UnsolvedError
    return max(solved, key=lambda result: sign * result.value)


def leapt(place: Place, sign: float, best: Extreme, rng: np.random.Generator, effort: Effort | None = None) -> Extreme:
    """The better one of an extreme and what is found beyond the valleys around it: some of its variables leap to ±1."""
    effort = effort or Effort()
    for _ in range(LEAPS):
        origin = settled(place.space, best.balance, best.evaluation)
        landed: list[Extreme] = []
        for _ in range(TRIES):
            leaping = rng.random(origin.size) < SHARE
            leaping[rng.integers(origin.size)] = True
            with suppress(UnsolvedError):
                landed.append(place.point(np.where(leaping, rng.choice([-1.0, 1.0], origin.size), origin)))
        if landed:
            start = max(landed, key=lambda there: sign * there.value)
            found = _from_start(place, sign, start.variables, effort)
            best = found if found is not None and sign * found.value > sign * best.value else best
    return best


def _from_start(place: Place, sign: float, start: Array, effort: Effort) -> Extreme | None:
    """The best of several searches, each from the sliders of the one before."""
    best: Extreme | None = None
    for _ in range(effort.rounds):
        found = _climb(place, sign, start, effort)
        if found is None:
            break
        gain = np.inf if best is None else sign * (found.value - best.value)
        best = found if best is None or gain > 0.0 else best
        if gain <= effort.gain * abs(best.value):
            break
        start = settled(place.space, best.balance, best.evaluation)
    return best


def _climb(place: Place, sign: float, start: Array, effort: Effort) -> Extreme | None:
    """One search with L-BFGS-B in the cube [−1, 1]ⁿ; the best point on its way, None when the start does not solve."""
    try:
        best, _ = place.value(start)
    except UnsolvedError:
        return None
    scale = abs(best.value) or 1.0

    def minimised(variables: Array) -> tuple[float, Array]:
        nonlocal best
        try:
            found, gradient = place.value(variables)
        except UnsolvedError:
            return 10.0, np.zeros_like(variables)
        if sign * found.value > sign * best.value:
            best = found
        return -sign * found.value / scale, -sign * gradient / scale

    options = {"maxiter": effort.iterations, "ftol": effort.tolerance, "gtol": effort.tolerance}
    bounds = [(-1.0, 1.0)] * start.size
    scipy.optimize.minimize(minimised, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)  # type: ignore[call-overload]
    return best


TOLERANCE = 1e-6
"""Relative amplitude to which a peak is found."""

LONGEST = 300
"""Points of the longest curve that is traced for its peak; a virgin one takes about forty."""

KNOWN = 30
"""Peaks remembered to climb from."""


def highest_peak(
    curve_start: Evaluation, balance: HarmonicBalance, output: int, end: float, measure: Measure
) -> CurvePoint | None:
    """The highest peak from a solved point to the frequency `end` in rad/s; None where the curve is lost or has none."""
    first = correct(balance, curve_start.point, fixed("omega", curve_start.point.omega))
    if not first.converged:
        return None
    try:
        curve = list(trace(balance, first, "omega", end, StepControl(points=LONGEST)))
    except LostCurveError:
        return None
    row = balance.rows + output
    found = PeakSearch(balance, curve, TOLERANCE).peaks(output, measure)
    return max(found.points, key=lambda p: measure.size(p.evaluation.w[row], p.point.omega), default=None)


class AtPeak:
    """A measure of an output at its highest peak over a band in rad/s; the gradient at the peak is the one at fixed frequency,
    since along the curve the measure is stationary there.
    """

    def __init__(
        self, balance: HarmonicBalance, space: StartSpace, output: int, measure: Measure, band: tuple[float, float], level: float
    ) -> None:
        self.space, self.output, self.measure, self.band = space, output, measure, band
        self.begin = StartSolutions(balance, space, band[0], level)
        self.known: list[tuple[Array, Point, Plane]] = []
        self.solves = self.traces = 0

    def point(self, variables: Array) -> Extreme:
        """What a start state gives near the peak of a known one."""
        return self.value(variables)[0]

    def value(self, variables: Array) -> tuple[Extreme, Array]:
        """What a start state gives near the peak of a known one, and the gradient; where none is known its curve is traced."""
        if not self.known:
            return self.traced(variables)
        balance = self.space.balance(self.begin.balance, variables)
        solver = PeakSolver(balance, self.output, self.measure, TOLERANCE)
        try:
            evaluation = self._climbed(solver, variables)
        except NoPeakError:
            raise UnsolvedError from None
        finally:
            self.solves += solver.solves
        if not self.band[0] < evaluation.point.omega < self.band[1]:
            raise UnsolvedError
        return self._at(balance, variables, evaluation)

    def sample(self, variables: Array) -> Extreme:
        """What a start state gives on its whole curve."""
        return self.traced(variables)[0]

    def confirmed(self, found: Extreme, sign: float) -> Extreme | None:
        """The highest peak of the whole curve: the one that was followed may not be it. Then that one is climbed to from now on.

        Where the curve is lost, its highest peak is at least the followed one: a search of the largest takes that, one of the
        smallest nothing.
        """
        try:
            highest = self.sample(found.variables)
        except UnsolvedError:
            return found if sign > 0.0 else None
        if abs(highest.evaluation.point.omega - found.evaluation.point.omega) > SAME_PEAK * found.evaluation.point.omega:
            self.known = self.known[-1:]
        return highest

    def traced(self, variables: Array) -> tuple[Extreme, Array]:
        """The same by tracing the whole curve; raises `UnsolvedError`."""
        self.traces += 1
        balance, first = self.begin.solve(variables)
        peak = highest_peak(first, balance, self.output, self.band[1], self.measure)
        if peak is None:
            raise UnsolvedError(Outcome.NO_PEAK)
        return self._at(balance, variables, peak.evaluation)

    def _at(self, balance: HarmonicBalance, variables: Array, evaluation: Evaluation) -> tuple[Extreme, Array]:
        known = (variables.copy(), evaluation.point, plane_at(balance, evaluation))
        self.known = [*self.known[-KNOWN:], known]
        value, weights = size_of(self.output, self.measure)(balance, evaluation)
        return Extreme(variables.copy(), value, balance, evaluation), start_gradient(balance, self.space, evaluation, weights)

    def _climbed(self, solver: PeakSolver, variables: Array) -> Evaluation:
        """The peak near that of the nearest known start state: at once, else by way of start states between its own and this."""
        origin, point, plane = min(self.known, key=lambda item: float(np.linalg.norm(item[0] - variables)))
        try:
            return solver.from_near(point, plane).evaluation
        except NoPeakError:
            way = StartSolutions(self.begin.balance, self.space, point.omega, point.level)
            way.remember(origin, point.forces)
            return solver.from_solved(way.solve(variables)[1]).evaluation
