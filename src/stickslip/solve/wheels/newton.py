"""Newton's method for wheels."""
from dataclasses import replace
import numpy as np
from stickslip.solve.balance.balance import Evaluation, PathCondition, Point
from stickslip.solve.continuation.newton import Correction, correct
from stickslip.solve.wheels.balance import WheelBalance, WheelFactors
from stickslip.support.checks import Array

TOLERANCE = 1e-7


def newton_change(balance, factors, evaluation, condition, solve):
    a = solve(-evaluation.residual)
    da = balance.change(a, evaluation.point.omega)
    missed = condition.gap(evaluation)
    if condition.weight is None:
        amount = -missed / condition.slope
    else:
        t, dt = factors.tangent()
        amount = -(missed + condition.rate(da, 0.0)) / condition.rate(dt, 1.0)
    if amount:
        t, dt = factors.tangent()
        a, da = a + amount * t, da + amount * dt
    return a, da, amount


@correct.register
def correct_wheel(
    balance: WheelBalance, start: Point, condition: PathCondition, iterations: int = 10, halvings: int = 4, patience: int = 0,
    direction: float | None = None,
) -> Correction:
    iterations = max(iterations, 12)
    if condition.weight is None:
        start = replace(start, omega=condition.target / condition.slope)
    evaluation = first = balance.evaluate(start)
    history, factors, converged = [[evaluation.error, 0.0]], None, False
    size = lambda ev: float(np.linalg.norm(ev.w[: balance.rows]))
    for _ in range(iterations):
        factors = balance.factorise(evaluation, condition)
        step, dw, amount = newton_change(balance, factors, evaluation, condition, factors.solve)
        before = float(np.linalg.norm(dw[: balance.rows]))
        length, found = 1.0, None
        for _ in range(halvings + 1):
            trial_omega = evaluation.point.omega + length * amount
            if trial_omega > 0.0:
                trial = balance.evaluate(Point(evaluation.point.forces + length * step, trial_omega, evaluation.point.level))
                more, dmore, extra = newton_change(balance, factors, trial, condition, factors.precondition)
                after = float(np.linalg.norm(dmore[: balance.rows]))
                if length == 1.0 and after <= TOLERANCE * size(trial):
                    converged, found = True, trial
                    break
                if after < (1.0 - 0.3 * length) * before:
                    found = trial
                    break
            length *= 0.5
        if found is None:
            history.append([evaluation.error, 0.0])
            break
        evaluation = found
        history.append([evaluation.error, length])
        if converged:
            break
    along = None
    if converged and direction is not None:
        factors = balance.factorise(evaluation, condition)
        along = balance.tangent(evaluation, "omega", factors)
    return Correction(first.w, evaluation, factors, along, np.array(history), converged, False)
