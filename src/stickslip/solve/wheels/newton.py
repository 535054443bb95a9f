"""Newton's method and steps along a curve for a wheel, in place of the compiled ones.

A step counts by the change of the motion that it leads to, ‖R M⁻¹ F‖ (the natural monitor of Deuflhard): beside a resonance the
residual itself stalls Newton's method.
"""

from dataclasses import replace

import numpy as np
from numpy.linalg import LinAlgError

from stickslip.solve.balance.balance import Evaluation, PathCondition, Point
from stickslip.solve.balance.system import BORDERED, DIRECTION
from stickslip.solve.continuation.curve_points import Metric, Tangent, moving_sizes, relative_metric
from stickslip.solve.continuation.newton import NEAR, Correction, Found, correct
from stickslip.solve.continuation.steps import LEAST, Place, Solver, Stepped, stepped
from stickslip.solve.wheels.balance import WheelBalance
from stickslip.solve.wheels.factors import WheelFactors

TOLERANCE = 1e-5
"""Relative change of the motion of the contacts by a further step, up to which a point counts as solved."""

INNER = 1e-3
"""Relative accuracy of Newton's steps, with which he gains three digits each."""

STALE = 6
"""Products of GMRES beyond which another preconditioner pays."""

LEAST_GAIN = 0.3
"""Share of a step by which it must reduce the next one."""


@correct.register
@np.errstate(over="ignore", invalid="ignore")  # trials far away, which the search of a step refuses
def correct_wheel(
    balance: WheelBalance,
    start: Point,
    condition: PathCondition,
    iterations: int = 10,
    halvings: int = 4,
    patience: int = 0,
    direction: float | None = None,
) -> Correction:
    """`correct` for a wheel; without patience."""
    if condition.weight is None:
        start = replace(start, omega=condition.target / condition.slope)
    evaluation = first = balance.evaluate(start)
    factors: WheelFactors | None = None
    history, converged, singular, along = [(evaluation.error, 0.0)], False, False, None
    try:
        for _ in range(iterations if np.isfinite(evaluation.error) else 0):
            if factors is None or factors.products > STALE:
                factors = WheelFactors.of(balance, evaluation, condition)
            else:
                factors = factors.at(evaluation)
            length, following, converged = _search(balance, factors, evaluation, halvings)
            history.append((evaluation.error if following is None else following.error, length))
            if following is None:
                break
            evaluation = following
            if converged:
                break
        if converged and factors is not None and direction is not None:
            factors = factors.at(evaluation)
            along = balance.tangent(evaluation, "omega", factors)
    except LinAlgError:
        converged, singular, along = False, True, None
    return Correction(first.w, evaluation, factors, along, np.array(history), converged, singular)  # type: ignore[arg-type]


def _search(
    balance: WheelBalance, factors: WheelFactors, evaluation: Evaluation, halvings: int
) -> tuple[float, Evaluation | None, bool]:
    """The longest of Newton's steps 1, 1/2, 1/4, ... after which the next one is shorter, the evaluation there, and whether it is
    solved; None for none."""
    condition, point = factors.condition, evaluation.point
    step = factors.solve(-evaluation.residual, -condition.gap(evaluation), INNER)
    before, length = float(np.linalg.norm(step.motion[: balance.rows])), 1.0
    for _ in range(halvings + 1 if np.isfinite(before) else 0):
        trial = balance.evaluate(point.moved(length * step.forces, "omega", length * step.omega))
        if trial.point.omega > 0.0 and np.isfinite(trial.error):
            after = factors.estimate(-trial.residual, -condition.gap(trial)).motion[: balance.rows]
            size = float(np.linalg.norm(after))
            if length == 1.0 and size <= TOLERANCE * float(np.linalg.norm(trial.w[: balance.rows])):
                return length, trial, True
            if size < (1.0 - LEAST_GAIN * length) * before or trial.error < (1.0 - LEAST_GAIN * length) * evaluation.error:
                return length, trial, False
        length *= 0.5
    return 0.0, None, False


@stepped.register
def step_wheel(balance: WheelBalance, place: Place, along: Tangent, distance: float, solver: Solver) -> Stepped:
    """`step` for a wheel over ω."""
    metric = place.metric
    plane = PathCondition("omega", metric.weight * along.motion, metric.parameter * along.parameter, 0.0)
    plane = replace(plane, target=plane.rate(place.w, place.omega) + distance)
    forces, amount = place.forces + distance * along.forces, distance * along.parameter
    if place.length > 0.0 and np.array_equal(place.unknown, place.unknown_before):
        ratio = metric.length(place.before.motion, place.before.parameter)
        bend = 0.5 * distance**2 / (place.length * ratio)
        forces = forces + bend * (along.forces - place.before.forces / ratio)
        amount += bend * (along.parameter - place.before.parameter / ratio)
    start = Point(forces, place.omega + amount, place.level)
    found = correct(balance, start, plane, solver.iterations, solver.halvings, 0, NEAR)
    evaluation, direction = found.evaluation, found.direction or DIRECTION
    active = np.array([np.count_nonzero(evaluation.unknown)])
    point, state = evaluation.point, evaluation.without_derivatives().state
    sign = found.factors.orientation if found.converged and found.factors is not None else 1.0
    bordered = BORDERED._replace(offsets=active, sign=sign)
    ended = found.converged, found.singular
    done = Found(found.start_motion, state, point.omega, point.level, bordered, direction, found.history, *ended)
    if not found.converged:
        none = np.empty((0, 0))
        return Stepped(done, Tangent(none, none, 0.0), Metric(none, 0.0), solver.contacts, solver.outputs, 0.0, 0.0, 0.0, False)
    sizes = moving_sizes(state.w, balance.rows)
    most = [max(pair) for pair in zip(sizes, (solver.contacts, solver.outputs), strict=True)]
    scales = [max(size, LEAST * largest) for size, largest in zip(sizes, most, strict=True)]
    own = relative_metric(state.w, balance.rows, scales, solver.scale)
    length = own.length(direction.motion, direction.rate) * np.sign(solver.orientation * sign)
    tangent = Tangent(direction.forces / length, direction.motion / length, direction.rate / length)
    error = metric.length(state.w - found.start_motion, point.omega - start.omega)
    chord = metric.length(state.w - place.w, point.omega - place.omega)
    turn = float(np.vdot(metric.weight * along.motion, tangent.motion)) + metric.parameter * along.parameter * tangent.parameter
    turn /= metric.length(tangent.motion, tangent.parameter)
    return Stepped(done, tangent, own, most[0], most[1], error, turn, chord, False)
