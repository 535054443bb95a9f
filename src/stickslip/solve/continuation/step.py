"""One step of a continuation, compiled: prediction, Newton's method from there, and how the solution lies to both ends."""

from typing import NamedTuple

import numpy as np

from stickslip.solve.balance.newton_parts import AnySystem
from stickslip.solve.balance.system import Border
from stickslip.solve.continuation.curve_points import Metric, Tangent, moving_sizes, weights
from stickslip.solve.continuation.newton import NEAR, Found, moved, newton
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import boxed, inlined, inner, kernel
from stickslip.support.kernels.arrays import empty_table, moved_by, same_numbers, zero_table
from stickslip.support.kernels.views import view

LEAST = 0.02
"""Share of the largest size so far that is the least scale of the motion at a point."""


class Place(NamedTuple):
    """A point that a step begins at, as the kernels read it: forces λ, motion w, unknown rows, ω, level; metric: its scales.

    length: of the step that led here, from a point with the tangent `before` and the rows `unknown_before`; 0 where that is not
    known, or not to be used.
    """

    forces: Array
    w: Array
    unknown: Index
    omega: float
    level: float
    metric: Metric
    before: Tangent
    unknown_before: Index
    length: float


class Solver(NamedTuple):
    """How a step is solved: iterations and halvings of Newton's method.

    scale: of the parameter in arc length; by_level: the parameter is the level; orientation: sign of the bordered determinant
    along the curve, 0 for any; contacts, outputs: the largest sizes of their motion so far.
    """

    iterations: int
    halvings: int
    scale: float
    by_level: bool
    orientation: float
    contacts: float
    outputs: float


class Stepped(NamedTuple):
    """Where a step led: the solution, its tangent and metric, the largest sizes with it.

    error: of the prediction; turn: cosine of the angle between both tangents; chord: length of the straight way; each in the
    metric of the start. outside: the prediction has no positive frequency.
    """

    found: Found
    tangent: Tangent
    metric: Metric
    contacts: float
    outputs: float
    error: float
    turn: float
    chord: float
    outside: bool


@inner
def _dot(weight: Array, a: Array, b: Array) -> float:
    total = 0.0
    for r in range(a.shape[0]):
        for i in range(a.shape[1]):
            total += weight[r, i] * a[r, i] * b[r, i]
    return total


@inner
def _length(metric: Metric, dw: Array, dp: float) -> float:
    return float(np.sqrt(_dot(metric.weight, dw, dw) + metric.parameter * dp * dp))


@inlined
def _predicted(place: Place, along: Tangent, distance: float) -> tuple[Array, float, float]:
    """λ at a distance along the curve, and the changes of its parameter and of a level that holds an amplitude.

    The second derivative is that of the tangents at both ends of the last step, where the same rows were unknown at both.
    """
    forces = moved_by(place.forces, distance, along.forces)
    amount, raised = distance * along.parameter, distance * along.level
    if place.length > 0.0 and same_numbers(place.unknown, place.unknown_before):
        before = place.before
        ratio = _length(place.metric, before.motion, before.parameter)
        bend = 0.5 * distance * distance / (place.length * ratio)
        for r in range(forces.shape[0]):
            for i in range(forces.shape[1]):
                forces[r, i] += bend * (along.forces[r, i] - before.forces[r, i] / ratio)
        amount += bend * (along.parameter - before.parameter / ratio)
        raised += bend * (along.level - before.level / ratio)
    return forces, amount, raised


@inlined
def across(place: Place, along: Tangent, distance: float, by_level: bool) -> Border:
    """The plane at a distance along a tangent, normal to it in the metric."""
    metric, w = place.metric, place.w
    weight = zero_table(w.shape[0], w.shape[1])
    for r in range(w.shape[0]):
        for i in range(w.shape[1]):
            weight[r, i] = metric.weight[r, i] * along.motion[r, i]
    slope = metric.parameter * along.parameter
    reached = _dot(metric.weight, along.motion, w) + slope * (place.level if by_level else place.omega)
    return Border(weight, slope, reached + distance, by_level)


@inner
def _unit(metric: Metric, found: Found, orientation: float) -> Tangent:
    """The unit tangent at a solution, turned so that the sign of the bordered determinant stays."""
    direction = found.direction
    length = _length(metric, direction.motion, direction.rate)
    if orientation * found.bordered.sign < 0.0:
        length = -length
    forces = zero_table(direction.forces.shape[0], direction.forces.shape[1])
    motion = zero_table(direction.motion.shape[0], direction.motion.shape[1])
    forces, motion = moved_by(forces, 1.0 / length, direction.forces), moved_by(motion, 1.0 / length, direction.motion)
    return Tangent(forces, motion, direction.rate / length, direction.level / length)


@kernel
def step(given: AnySystem, rows: int, place: Place, along: Tangent, distance: float, solver: Solver) -> Stepped:
    """A step of some arc length along a tangent; rows: of contacts. Where Newton's method fails, tangent and metric are empty."""
    system = view(given)
    border = across(place, along, distance, solver.by_level)
    start, amount, raised = _predicted(place, along, distance)
    omega, level = moved(border, place.omega, place.level, amount, raised)
    outside = omega <= 0.0
    if outside:
        start, omega, level = place.forces.copy(), place.omega, place.level
    iterations = 0 if outside else solver.iterations
    found = newton(system, start, omega, level, border, iterations, solver.halvings, 0, NEAR)
    contacts, outputs = solver.contacts, solver.outputs
    if outside or not found.converged:
        nothing = empty_table(0, 0)
        tangent, metric = Tangent(nothing, nothing, 0.0, 0.0), Metric(nothing, 0.0)
        return boxed(Stepped(found, tangent, metric, contacts, outputs, 0.0, 0.0, 0.0, outside))
    w = found.state.w
    sizes = moving_sizes(w, rows)
    contacts, outputs = max(contacts, sizes[0]), max(outputs, sizes[1])
    weight = weights(w, rows, max(sizes[0], LEAST * contacts), max(sizes[1], LEAST * outputs))
    metric = Metric(weight, 1.0 / (solver.scale * solver.scale))
    tangent = _unit(metric, found, solver.orientation)
    by_level, own = solver.by_level, place.metric
    value = found.level if by_level else found.omega
    error = _length(own, moved_by(w, -1.0, found.start_motion), value - (level if by_level else omega))
    chord = _length(own, moved_by(w, -1.0, place.w), value - (place.level if by_level else place.omega))
    turn = _dot(own.weight, along.motion, tangent.motion) + own.parameter * along.parameter * tangent.parameter
    turn /= _length(own, tangent.motion, tangent.parameter)
    return boxed(Stepped(found, tangent, metric, contacts, outputs, error, turn, chord, False))
