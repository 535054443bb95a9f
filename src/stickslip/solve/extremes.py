"""The largest and smallest value of an objective over start states: at a frequency, and at the peak of the curve.

Nested: for every start state the response is solved (R = 0 holds exactly), its derivative comes from the implicit function
theorem, and a quasi-Newton method with bounds moves the start state. The extremes are multimodal: several starts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from stickslip.checks import Array
from stickslip.harmonic.balance import Evaluation, HarmonicBalance, Point
from stickslip.harmonic.cycle import contact_cycle
from stickslip.harmonic.energy import EnergyBalance
from stickslip.solve.continuation import CurvePoint, LostCurveError, StepControl, first_point, trace
from stickslip.solve.newton import correct, fixed
from stickslip.solve.peak import peaks
from stickslip.solve.sensitivity import respond, solved_factors, start_slopes
from stickslip.solve.start_space import StartSpace

Objective = Callable[[HarmonicBalance, Evaluation], tuple[float, Callable[[Array, Array], Array]]]
"""Value at a solved point, and the function that turns changes (dλ, dw) of solutions into changes of the value."""


def amplitude(output: int) -> Objective:
    """|X_1| of an output, m."""

    def objective(balance: HarmonicBalance, evaluation: Evaluation) -> tuple[float, Callable[[Array, Array], Array]]:
        row = balance.rows + output
        a, b = evaluation.w[row, 1:3]
        size = float(np.hypot(a, b))
        return size, lambda forces, motion: (a * motion[:, row, 1] + b * motion[:, row, 2]) / size

    return objective


def loss_factor(energy: EnergyBalance) -> Objective:
    """η = ΔW/(2πU), S4 equation 8."""

    def objective(balance: HarmonicBalance, evaluation: Evaluation) -> tuple[float, Callable[[Array, Array], Array]]:
        cycle = contact_cycle(evaluation.table, balance.tables, evaluation.w)
        value = energy.at(evaluation, cycle).loss_factor
        return value, lambda forces, motion: energy.loss_factor_slopes(evaluation, forces, motion)

    return objective


@dataclass(frozen=True, eq=False)
class Extreme:
    """A start state (variables) and what it gives: objective value, the solved point; solves spent on the way."""

    variables: Array
    value: float
    evaluation: Evaluation
    solves: int


class UnsolvedError(Exception):
    """No solution at a start state."""


class AtFrequency:
    """Solutions at one frequency and level as a function of the start state, each warm-started from the last one."""

    def __init__(self, balance: HarmonicBalance, space: StartSpace, objective: Objective, omega: float, level: float) -> None:
        self.balance, self.space, self.objective = balance, space, objective
        self.omega, self.level = omega, level
        self.known: list[tuple[Array, Point]] = []
        self.solves = 0

    def solve(self, variables: Array) -> tuple[HarmonicBalance, Evaluation]:
        """The solution nearest to known ones, else from the stuck state; raises `UnsolvedError`."""
        balance = self.space.balance(self.balance, variables)
        self.solves += 1
        condition = fixed("omega", self.omega)
        ranked = sorted(self.known, key=lambda item: float(np.linalg.norm(item[0] - variables)))
        for _, start in ranked[:2]:
            correction = correct(balance, Point(start.forces, self.omega, self.level), condition, iterations=25, halvings=8)
            if correction.converged:
                break
        else:
            correction = first_point(balance, self.omega, self.level)
        if not correction.converged:
            raise UnsolvedError
        self.known.append((variables.copy(), correction.evaluation.point))
        return balance, correction.evaluation

    def value(self, variables: Array) -> tuple[float, Array, Evaluation]:
        """Objective, its gradient by the variables, and the solution."""
        balance, evaluation = self.solve(variables)
        value, slope_of = self.objective(balance, evaluation)
        return value, start_gradient(balance, self.space, evaluation, slope_of), evaluation


def start_gradient(
    balance: HarmonicBalance, space: StartSpace, evaluation: Evaluation, slope_of: Callable[[Array, Array], Array]
) -> Array:
    """Gradient by the start variables of a function of a solved point."""
    elements, slopes = start_slopes(balance, evaluation)
    if not elements.size:
        return np.zeros(space.size)
    change = respond(balance, evaluation, solved_factors(balance, evaluation), slopes)
    return space.gradient(elements, slope_of(change.forces, change.motion))


class AtPeak:
    """The highest peak of the curve over a band as a function of the start state; value |X_1|, gradient by the envelope."""

    def __init__(self, balance: HarmonicBalance, space: StartSpace, output: int, band: tuple[float, float], level: float) -> None:
        self.balance, self.space, self.output, self.band, self.level = balance, space, output, band, level
        self.solves = 0

    def value(self, variables: Array) -> tuple[float, Array, Evaluation]:
        """Peak amplitude, its gradient by the variables, and the solution; raises `UnsolvedError`."""
        balance = self.space.balance(self.balance, variables)
        point = highest_peak(balance, self.output, self.band, self.level)
        self.solves += 1
        if point is None:
            raise UnsolvedError
        value, slope_of = amplitude(self.output)(balance, point.evaluation)
        return value, start_gradient(balance, self.space, point.evaluation, slope_of), point.evaluation


def highest_peak(balance: HarmonicBalance, output: int, band: tuple[float, float], level: float) -> CurvePoint | None:
    """The highest peak of |X_1| of an output over a band in rad/s, to 1e-6; None where the curve is lost or has none."""
    first = first_point(balance, band[0], level)
    if not first.converged:
        return None
    try:
        curve = list(trace(balance, first, "omega", band[1], StepControl()))
    except LostCurveError:
        return None
    row = balance.rows + output
    found = peaks(balance, curve, output, tolerance=1e-6)
    return max(found.points, key=lambda p: float(np.hypot(*p.evaluation.w[row, 1:3])), default=None)


def extreme(
    place: AtFrequency | AtPeak, sign: float, starts: Sequence[Array], iterations: int = 40, tolerance: float = 1e-7
) -> Extreme:
    """The largest (sign 1) or smallest (sign −1) value found from several starts; raises `UnsolvedError` when none solves."""
    best: list[Extreme] = []
    scale = 0.0

    def minimised(variables: Array) -> tuple[float, Array]:
        nonlocal scale
        try:
            value, gradient, evaluation = place.value(variables)
        except UnsolvedError:
            return np.inf if scale == 0.0 else 10.0, np.zeros_like(variables)
        scale = scale or abs(value)
        if not best or sign * value > sign * best[0].value:
            best[:] = [Extreme(variables.copy(), value, evaluation, place.solves)]
        return -sign * value / scale, -sign * gradient / scale

    for start in starts:
        options = {"maxiter": iterations, "ftol": tolerance, "gtol": tolerance}
        bounds = [(-1.0, 1.0)] * start.size
        minimize(minimised, np.clip(start, -1.0, 1.0), jac=True, method="L-BFGS-B", bounds=bounds, options=options)  # type: ignore[call-overload]
    if not best:
        raise UnsolvedError
    return best[0]
