"""Steps along a curve: predictor, corrector and step size, over folds and kinks and past crossing branches.

Arc length is measured in the motion of contacts and outputs, each relative to its own size, and in the parameter relative to
the band. Predictor of second order; step from the error of the prediction. Stick and slip make the curve piecewise smooth. The
sign of the bordered determinant is constant along it, which orients the tangent beyond a kink where the curve turns sharply.
Only where another branch crosses does it change: a symmetric disk may lose its symmetry there, and its own curve goes straight
on. One step is compiled: prediction, Newton's method from there, and how the solution lies to both ends.

Detection of resonances that a continuation step passes over: the balance is solved at the known ones inside it.
"""

import itertools
from dataclasses import dataclass, replace
from functools import singledispatch
from typing import NamedTuple

import numpy as np

from stickslip.solve.balance.balance import Evaluation, Factors, HarmonicBalance, Parameter, PathCondition, Point
from stickslip.solve.balance.newton_parts import AnySystem
from stickslip.solve.balance.resonances import Resonances, contacts_and_outputs
from stickslip.solve.balance.system import Border, Direction
from stickslip.solve.continuation.curve_points import (
    ROUNDING,
    CurvePoint,
    LostCurveError,
    Metric,
    Tangent,
    hermite_shares,
    moving_sizes,
    relative_metric,
    weights,
)
from stickslip.solve.continuation.newton import NEAR, Correction, Found, compile_newton, correct, fixed, moved, newton
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import boxed, inlined, inner, kernel
from stickslip.support.kernels.arrays import empty_table, moved_by, same_numbers, zero_table
from stickslip.support.kernels.views import view

NEGLIGIBLE = 1e-3
"""A resonance that could add no more than this share to the motion of any output is not looked at."""

TOLERANCE = 0.02
"""Relative difference between the motion at a resonance and the cubic through both ends, above which the step is too long."""

SAME_RESONANCE = 0.1
"""Resonances of two contact states nearer than this share of the half-width are one."""

SHORT_STEP = 1e-3
"""Arc length below which Newton's method may fail at a resonance: it does at kinks, and the curve has to go on."""


def hidden_resonance(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint, middle: bool) -> float | None:
    """The fraction of the step from one point to the next where it passes over a resonance, None where it does not.

    middle: the balance is solved in the middle of the step too. Where slip begins beside a resonance, the peak is a corner whose
    frequency is not known before.

    Motion and ω in between are cubics through both ends and their tangents. Where ω turns, the step is near a fold and short;
    where nothing slips at both ends it does not turn.
    """
    start, end = current.point.omega, following.point.omega
    inside = _inside(balance, current, following)
    if not inside and not middle:
        return None
    step = following.length
    stretch = step * following.metric.length(current.tangent.motion, current.tangent.parameter)
    slopes = step * current.tangent.parameter, stretch * following.tangent.parameter
    controls = start, start + slopes[0] / 3.0, end - slopes[1] / 3.0, end
    way = 1.0 if end > start else -1.0
    if not all(way * (after - before) > 0.0 for before, after in itertools.pairwise(controls)):
        if current.active or following.active:
            return None
        controls = start, (2.0 * start + end) / 3.0, (start + 2.0 * end) / 3.0, end
    rows, level, tangents = balance.rows, current.point.level, (current.tangent, following.tangent)
    ends = current.evaluation, following.evaluation
    motions = _knots(ends[0].w, step * tangents[0].motion, ends[1].w, stretch * tangents[1].motion)
    forces = _knots(ends[0].point.forces, step * tangents[0].forces, ends[1].point.forces, stretch * tangents[1].forces)
    carried = [balance.carried_forces(each) for each in ends]
    places: list[tuple[float, float, Resonances | None, int]] = [
        (_fraction(controls, omega), omega, one, k) for omega, one, k in (inside if end > start else inside[::-1])
    ]
    if middle:
        places.append((0.5, float(hermite_shares(0.5) @ np.array([start, slopes[0], end, slopes[1]])), None, 0))
    for fraction, omega, resonances, k in places:
        shares = hermite_shares(fraction)
        expected, applied = (shares @ motions).reshape(ends[0].w.shape), (shares @ forces).reshape(carried[0].shape)
        sizes = _sizes(expected, rows)
        if resonances is not None:
            part = resonances.columns(k)
            drive = (1.0 - fraction) * carried[0][:, part] + fraction * carried[1][:, part]
            if (resonances.motion(k, level, applied[:, part], drive) <= NEGLIGIBLE * sizes).all():
                continue
        correction = correct(balance, Point(applied, omega, level), fixed("omega", omega), 12, 6)
        if not correction.converged:
            if following.length >= SHORT_STEP:
                return fraction
            continue
        found = correction.evaluation.w
        if (_sizes(found - expected, rows) > TOLERANCE * np.maximum(sizes, _sizes(found, rows))).any():
            return fraction
    return None


def _inside(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint) -> list[tuple[float, Resonances, int]]:
    """The resonances inside a step that is longer than their half-width: ω, ascending, where they are known from, and number."""
    low, high = sorted((current.point.omega, following.point.omega))
    limits = balance.linear.resonances
    known = {id(one): one for one in (limits, *(limits.where_stuck(point.evaluation.unknown) for point in (current, following)))}
    found = [(float(one.omega[k]), one, k) for one in known.values() if one is not None for k in one.between(low, high)]
    if not found:
        return []
    found.sort(key=lambda each: each[0])
    kept: list[tuple[float, Resonances, int]] = []
    for omega, one, k in found:
        nearer = omega - SAME_RESONANCE * one.width[k]
        if not any(w > nearer and other.harmonic[m] == one.harmonic[k] for w, other, m in kept[-4:]):
            kept.append((omega, one, k))
    return kept


def _fraction(controls: tuple[float, float, float, float], omega: float) -> float:
    """Where the monotonic cubic with these control points passes a value, by Newton's method inside a bracket."""
    a, b, c, d = controls
    low, high, fraction = 0.0, 1.0, (omega - a) / (d - a)
    for _ in range(60):
        rest = 1.0 - fraction
        beyond = rest**3 * a + 3.0 * rest**2 * fraction * b + 3.0 * rest * fraction**2 * c + fraction**3 * d - omega
        if abs(beyond) <= 1e-6 * abs(d - a):
            break
        low, high = (low, fraction) if (beyond > 0.0) == (d > a) else (fraction, high)
        rate = 3.0 * (rest**2 * (b - a) + 2.0 * rest * fraction * (c - b) + fraction**2 * (d - c))
        fraction -= beyond / rate if rate else 0.0
        if not low < fraction < high:
            fraction = 0.5 * (low + high)
    return fraction


def _knots(*values: Array) -> Array:
    """Values and slopes at both ends, as `hermite_shares` counts them (4, ...), each flat."""
    return np.array([each.ravel() for each in values])


def _sizes(w: Array, rows: int) -> Array:
    """Dynamic motion of the contacts together and of each output, (1 + outputs,)."""
    moving = w[:, 1:]
    sizes = contacts_and_outputs(np.einsum("ri,ri->r", moving, moving), rows)
    return np.asarray(np.maximum(sizes, ROUNDING * sizes.max()))


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


@singledispatch
def stepped(balance: HarmonicBalance, place: Place, along: Tangent, distance: float, solver: Solver) -> Stepped:
    """`step` for a balance; one that stands in Python registers its own."""
    compile_newton(balance.system)
    return step(balance.placed_system, balance.rows, place, along, distance, solver)


BEYOND = (1e-3, 1e-2, 1e-4)
SHORT = (1e-4, 1e-3, 1e-5, 1e-2)
"""Steps along the tangent from beyond a kink, in the order in which they are tried; `SHORT` where each must be reversible."""

SAME = 0.999
"""Cosine of the angle between tangents above which no kink lies between their places."""

RETURN = 0.03
"""Share of a step by which the step back may miss the point that it came from."""


@dataclass(frozen=True)
class StepControl:
    """Steps in arc length: first, smallest, largest; one may exceed the last `growth` times, below `short` `recovery` times.

    iterations: of Newton's method before a step is shortened; error: the prediction error aimed at; cosine: the sharpest turn
    accepted in one step; straight: prediction error relative to the step up to which a curve goes straight on over a branch
    point, where the cosine is below `reversed`; reversible: believe a step only if the step back leads to where it came from,
    which costs a second solution but keeps to one branch in a cascade of folds; branching: branch points are met where the
    parameter turns too, as the branches of a symmetric structure meet each other; points: the most of them.
    """

    first: float = 0.1
    smallest: float = 1e-6
    largest: float = 0.6
    growth: float = 2.0
    short: float = 0.1
    recovery: float = 5.0
    iterations: int = 7
    error: float = 0.03
    cosine: float = 0.1
    straight: float = 0.05
    reversed: float = -0.95
    reversible: bool = False
    branching: bool = False
    points: int = 8000


class Steps:
    """State of one continuation: what changes along the curve, kept in one place. scale: of the parameter in arc length."""

    def __init__(self, balance: HarmonicBalance, parameter: Parameter, scale: float, control: StepControl) -> None:
        self.balance, self.parameter, self.scale, self.control = balance, parameter, scale, control
        self.largest = [0.0, 0.0]
        self.orientation = 0.0
        self.step = control.first

    def metric(self, evaluation: Evaluation) -> Metric:
        """Scales of the motion at a point: its own size, but no less than `LEAST` of the largest so far."""
        sizes = moving_sizes(evaluation.w, self.balance.rows)
        self.largest = [max(pair) for pair in zip(self.largest, sizes, strict=True)]
        scales = [max(size, LEAST * largest) for size, largest in zip(sizes, self.largest, strict=True)]
        return relative_metric(evaluation.w, self.balance.rows, scales, self.scale)

    def starting_point(self, first: Correction, direction: float) -> CurvePoint:
        """A solved point with the direction of the curve, in which the parameter grows (1) or falls (−1)."""
        evaluation = first.evaluation
        along = PathCondition(self.parameter, None, direction, 0.0)
        return self._begun(evaluation, along, self.metric(evaluation), first.iterations)

    def begun_along(self, evaluation: Evaluation, wanted: Tangent) -> CurvePoint:
        """A solved point with the direction of the curve that goes with a wanted one."""
        metric = self.metric(evaluation)
        return self._begun(evaluation, self._condition(evaluation, wanted, metric, 0.0), metric, 0)

    def _begun(self, evaluation: Evaluation, along: PathCondition, metric: Metric, iterations: int) -> CurvePoint:
        """The first point; its direction is that in which a condition grows."""
        factors = self.balance.factorise(evaluation, along)
        tangent = self._tangent(self.balance.tangent(evaluation, self.parameter, factors), factors, metric)
        factors = self.balance.factorise(evaluation, self._condition(evaluation, tangent, metric, 0.0))
        self.orientation = factors.orientation
        return CurvePoint(evaluation, tangent, metric, iterations, factors.size, 0.0)

    def _tangent(self, direction: Direction, factors: Factors, metric: Metric) -> Tangent:
        """The unit tangent, turned so that the sign of the bordered determinant stays."""
        forces, motion, amount, level = direction
        length = metric.length(motion, amount)
        if self.orientation * factors.orientation < 0.0:
            length = -length
        return Tangent(forces / length, motion / length, amount / length, level / length)

    def _condition(self, evaluation: Evaluation, tangent: Tangent, metric: Metric, distance: float) -> PathCondition:
        """The plane at `distance` along a tangent, normal to it in the metric."""
        weight, slope = metric.weight * tangent.motion, metric.parameter * tangent.parameter
        reached = float(np.vdot(weight, evaluation.w)) + slope * evaluation.point.value(self.parameter)
        return PathCondition(self.parameter, weight, slope, reached + distance)

    def _along(self, current: CurvePoint, tangent: Tangent, distance: float) -> Point:
        """The place at a distance along a tangent."""
        changes = distance * tangent.forces, self.parameter, distance * tangent.parameter, distance * tangent.level
        return current.point.moved(*changes)

    def _stepped(
        self,
        current: CurvePoint,
        tangent: Tangent,
        distance: float,
        before: CurvePoint | None = None,
        iterations: int = 7,
        halvings: int = 4,
    ) -> Stepped:
        """A step along a tangent; before: the point that the curve comes from, for a prediction of second order."""
        point, state, length = current.point, current.evaluation.state, current.length
        if before is None:
            before, length = current, 0.0
        metric, behind, unknown = current.metric, before.tangent, before.evaluation.unknown
        place = Place(point.forces, state.w, state.unknown, point.omega, point.level, metric, behind, unknown, length)
        by_level = self.parameter == "level"
        solver = Solver(iterations, halvings, self.scale, by_level, self.orientation, *self.largest)
        found = stepped(self.balance, place, tangent, distance, solver)
        self.largest = [found.contacts, found.outputs]
        return found

    def _solved(self, stepped: Stepped, distance: float) -> CurvePoint:
        """The point that a step led to."""
        found = stepped.found
        evaluation = Evaluation(Point(found.state.forces, found.omega, found.level), self.balance.table, found.state)
        size = int(found.bordered.offsets[-1])
        return CurvePoint(evaluation, stepped.tangent, stepped.metric, found.iterations, size, distance)

    def advance(self, current: CurvePoint, before: CurvePoint | None) -> CurvePoint:
        """The next point, with smaller steps until one is right; at a kink, along the tangent from beyond it."""
        distance, orientation = self.step, self.orientation
        passing: CurvePoint | None = None
        while distance > self.control.smallest:
            found = self._try(current, distance, before)
            if isinstance(found, CurvePoint):
                hidden = self._hidden(current, found)
                if hidden is None:
                    return found
                # No kink: the step is only too long. It is shortened as far as it takes, down to the smallest.
                self.orientation, passing = orientation, found
                distance *= 0.6 * hidden if hidden > 0.3 else 0.4
                continue
            distance *= found
            if distance < 1e-3:
                before = None
            if distance < 1e-3 and distance / found >= 1e-3:
                beyond = self._beyond_kink(current)
                if beyond is not None:
                    return beyond
        beyond = self._beyond_kink(current) or passing
        if beyond is None:
            raise LostCurveError("Newton's method failed at the smallest step.")
        return beyond

    def _hidden(self, current: CurvePoint, following: CurvePoint) -> float | None:
        """The fraction of a step where it passes over a resonance, if it does."""
        if self.parameter != "omega":
            return None
        return hidden_resonance(self.balance, current, following, self._loose(current, following))

    def _loose(self, current: CurvePoint, following: CurvePoint) -> bool:
        """Whether contacts change their state in a step whose motion is so small beside the largest that the metric hardly sees
        it."""
        ends = current.evaluation, following.evaluation
        if np.array_equal(ends[0].unknown, ends[1].unknown):
            return False
        sizes = zip(*(moving_sizes(each.w, self.balance.rows) for each in ends), self.largest, strict=True)
        return any(min(first, last) < LEAST * largest for first, last, largest in sizes)

    def _try(self, current: CurvePoint, distance: float, before: CurvePoint | None) -> CurvePoint | float:
        """One step; a point, or the factor by which to shorten the step."""
        stepped = self._stepped(current, current.tangent, distance, before, self.control.iterations)
        if stepped.outside:
            return 0.5
        if not stepped.found.converged:
            return 0.3
        following, error, turn = self._solved(stepped, distance), stepped.error, stepped.turn
        backwards = self.control.branching or following.tangent.parameter * current.tangent.parameter < 0.0
        crossed = backwards and turn < self.control.reversed and error < self.control.straight * distance
        if crossed:
            # Another branch crosses: the determinant has changed its sign, not the curve its direction.
            following, turn = replace(following, tangent=following.tangent.turned()), -turn
            if not self._goes_on(following, 0.5 * distance):
                return 0.5
        elif backwards and turn < self.control.reversed and self._kinked(following, distance, error, turn):
            crossed, following, turn = True, replace(following, tangent=following.tangent.turned()), -turn
        if self._turns_back(current, following):
            return 0.5
        close = error < 8.0 * self.control.error and turn > self.control.cosine
        if distance >= 1e-3 and not (close and stepped.chord <= 1.5 * distance and self._beside(current, following)):
            return 0.5
        if crossed:
            self.orientation = -self.orientation
        self.step = self._next_step(distance, error, stepped.found.iterations)
        return following

    def _turns_back(self, current: CurvePoint, following: CurvePoint) -> bool:
        """Whether a step leads back although nothing slips at its ends: a linear response has one motion at each frequency."""
        if current.active or following.active:
            return False
        change = following.point.value(self.parameter) - current.point.value(self.parameter)
        return change * current.tangent.parameter < 0.0

    def _beside(self, current: CurvePoint, following: CurvePoint) -> bool:
        """Whether the point that a step led to is on the same branch, as far as the step shows."""
        change = following.point.value(self.parameter) - current.point.value(self.parameter)
        if max(change * current.tangent.parameter, change * following.tangent.parameter) < 0.0:
            return False
        return not self.control.reversible or self._returns(current, following)

    def _returns(self, current: CurvePoint, following: CurvePoint) -> bool:
        """Whether the step back from a point leads to where the step came from; from another branch it does not."""
        across = following.across(self.parameter)
        condition = replace(across, target=across.gap(current.evaluation))
        distance = across.gap(following.evaluation) - condition.target
        tangent = following.tangent
        start = self._along(following, tangent, -distance)
        if start.omega <= 0.0:
            return False
        correction = correct(self.balance, start, condition, iterations=15, halvings=8)
        if not correction.converged:
            return False
        change = correction.evaluation.point.value(self.parameter) - current.point.value(self.parameter)
        missed = current.metric.length(correction.evaluation.w - current.evaluation.w, change)
        return missed < RETURN * current.chord(following, self.parameter)

    def _kinked(self, following: CurvePoint, distance: float, error: float, turn: float) -> bool:
        """Whether a step that seems to reverse went over a kink at which the determinant changes its sign.

        It does where several contacts change their state at once, as on a symmetric structure. A kink explains no larger error
        than its angle does. At the tip of a sharp fold the error says how far ahead the tip is: beyond it there is no curve.
        """
        slope = float(np.tan(np.pi - np.arccos(max(turn, -1.0))))
        if error > 1.2 * slope * distance:
            return False
        turned = replace(following, tangent=following.tangent.turned())
        return self._goes_on(turned, max(0.5 * distance, 2.0 * error / slope))

    def _goes_on(self, current: CurvePoint, distance: float) -> bool:
        """Whether the curve goes straight on beyond a point; at the tip of a sharp fold, which looks the same, it ends."""
        stepped = self._stepped(current, current.tangent, distance, None, self.control.iterations)
        return stepped.found.converged and stepped.error < self.control.cosine * distance

    def _next_step(self, distance: float, error: float, iterations: int) -> float:
        """From the error of the prediction, of third order; a step made short by a kink recovers faster than others grow."""
        growth = float((self.control.error / max(error, 1e-12)) ** (1.0 / 3.0))
        effort = 1.0 if iterations <= 5 else 0.6
        most = self.control.recovery if distance < self.control.short else self.control.growth
        return min(distance * min(max(growth * effort, 0.3), most), self.control.largest)

    def _beyond_kink(self, current: CurvePoint) -> CurvePoint | None:
        """Along tangents taken a little ahead and a little behind the point, where the state is already the other one; where the
        tangent is the same still, the kink lies further ahead, and one short step towards it is tried last."""
        towards: list[Tangent] = []
        for ahead in (1e-4, 1e-3, 1e-2, -1e-4, -1e-3):
            tangent = current.tangent
            place = self._along(current, tangent, ahead)
            evaluation = self.balance.evaluate(place)
            condition = self._condition(evaluation, tangent, current.metric, 0.0)
            factors = self.balance.factorise(evaluation, condition)
            if factors.orientation == 0.0:
                continue
            turned = self._tangent(self.balance.tangent(evaluation, self.parameter, factors), factors, current.metric)
            if current.cosine(turned) > SAME:
                towards.append(turned)
                continue
            found = self._turned_step(current, turned)
            if found is not None:
                return found
        return self._turned_step(current, towards[0]) if towards else None

    def _turned_step(self, current: CurvePoint, tangent: Tangent) -> CurvePoint | None:
        for distance in SHORT if self.control.reversible else BEYOND:
            found = self._try_turned(current, tangent, distance)
            if found is not None:
                self.step = max(distance, 1e-3)
                return found
        return None

    def _try_turned(self, current: CurvePoint, tangent: Tangent, distance: float) -> CurvePoint | None:
        stepped = self._stepped(current, tangent, distance, None, iterations=15, halvings=8)
        if not stepped.found.converged:
            return None
        found = self._solved(stepped, distance)
        if self._turns_back(current, found):
            return None
        near = stepped.chord <= 1.5 * distance and self._hidden(current, found) is None
        if self.control.reversible and not self._returns(current, found):
            return None
        return found if near and found.leads_away_from(current, self.parameter) else None
