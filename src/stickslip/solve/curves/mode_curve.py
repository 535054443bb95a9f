"""The curve of one nonlinear mode over its amplitude, from stuck contacts on, through folds, with points dense enough to draw.

Refinement of a nonlinear mode: points solved where the cubic through two neighbours and their tangents is not right.

The cubics run over the arc length s of the curve in ln a, ln ω and ζ, ds² = (d ln a)² + (d ln ω)² + dζ², the length between
neighbours taken along the straight way. Peaks of force levels are read off the same cubics.

Extremes of the damping ratio along a nonlinear mode, and the points at which it has a given value, each solved exactly.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.model.contact.protocol import SLIPPING
from stickslip.solve.balance.balance import HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.solve.continuation.continuation import solve_cold, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, Tangent, hermite, solve_at
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.curves.curve import held_by_friction
from stickslip.support.checks import Array, InputError
from stickslip.support.outcome import Outcome

TOLERANCE = 5e-5
"""Error of a cubic, at the point solved half way, above which this point is kept: in the amplitude at a force level, in ω and in
the motion at the amplitude, each relative."""

SATURATED = 0.05
"""Change of ln of the force with ln a below which an error of the force is not taken for a larger one of the amplitude."""

SMALL = 0.1
"""Share of the larger damping ratio of the ends of an interval that is the least to which an error of ζ inside is relative."""

SAMPLED = 7.0
"""Times 1/N², of N samples per period: the relative error of ω and ζ by the samples, whose sign changes from point to point
as contacts change state one sample later. No cubic follows it."""

HALVINGS = 5
"""How often an interval is halved at most."""


def refined(balance: ModeBalance, points: list[CurvePoint]) -> list[CurvePoint]:
    """The curve with points solved until its cubics are right to `TOLERANCE`.

    An interval in which ln a turns back stays as it is, and one so short that the contacts change state one sample later.
    """
    found = points[:1]
    for before, after in pairwise(points):
        found += _halved(balance, before, after, HALVINGS)
    return found


def _halved(balance: ModeBalance, before: CurvePoint, after: CurvePoint, halvings: int) -> list[CurvePoint]:
    """The points behind one, up to the next one."""
    expected = _half_way(balance, before, after)
    low, high = sorted((before.point.level, after.point.level))
    rising = before.tangent.parameter * after.tangent.parameter > 0.0 and low < expected[0] < high
    if not rising or halvings == 0 or high - low < 2.0 * np.pi / balance.tables.E.shape[0]:
        return [after]
    try:
        middle = directed(balance, before, solve_at(balance, before, after, "level", float(expected[0])))
    except LostCurveError:
        return [after]
    least = SMALL * max(abs(balance.damping_of(end.point)) for end in (before, after))
    if _error(balance, middle, expected, least) <= TOLERANCE:
        return [after]
    rest = replace(after, length=middle.chord(after, "level"))
    return _halved(balance, before, middle, halvings - 1) + _halved(balance, middle, rest, halvings - 1)


def _half_way(balance: ModeBalance, before: CurvePoint, after: CurvePoint) -> Array:
    """What `_values` are half way on the cubic between two points."""
    ends = [_values(balance, point) for point in (before, after)]
    way = float(np.linalg.norm(ends[1][:3] - ends[0][:3]))
    slopes = [way * _slopes(point) for point in (before, after)]
    return hermite(ends[0], slopes[0], ends[1], slopes[1], 0.5)


def _error(balance: ModeBalance, middle: CurvePoint, expected: Array, least: float) -> float:
    """The largest relative error of what was expected at a solved point; least: of the damping ratio to which its error counts.

    The force of phase resonance, 2ζω² m a/|f|, stands for that of a peak.
    """
    solved, (rise, bend, damped) = _values(balance, middle), pace(middle)
    missed = np.abs(expected - solved)
    ratio = max(abs(solved[2]), least, np.finfo(float).tiny)
    growth = abs(1.0 + (2.0 * bend + damped / ratio) / rise)
    force = max(2.0 * missed[1] + missed[2] / ratio - SAMPLED / balance.tables.E.shape[0] ** 2, 0.0)
    motion = np.linalg.norm(missed[3:]) / np.linalg.norm(solved[3:])
    return float(max(force / max(growth, SATURATED), missed[1], motion))


def _values(balance: ModeBalance, point: CurvePoint) -> Array:
    """ln a, ln ω, ζ and the first harmonic of contacts and outputs, (3 + 2 motion rows,)."""
    own = point.point.level, np.log(balance.omega_of(point.point)), balance.damping_of(point.point)
    return np.concatenate([own, point.evaluation.w[:, 1:3].ravel()])


def _slopes(point: CurvePoint) -> Array:
    """Derivatives of `_values` by the arc length."""
    rates = np.concatenate([_rates(point), point.tangent.motion[:, 1:3].ravel()])
    return np.asarray(rates / np.linalg.norm(_rates(point)))


def _rates(point: CurvePoint) -> Array:
    """Derivatives of ln a, ln ω and ζ along the tangent, (3,)."""
    frequency, damping = point.tangent.forces[-1, 1:3]
    return np.array([point.tangent.parameter, frequency / point.point.forces[-1, 1], damping])


def pace(point: CurvePoint) -> Array:
    """Derivatives of ln a, ln ω and ζ by the arc length, (3,)."""
    return _slopes(point)[:3]


def arc_tangent(point: CurvePoint) -> tuple[Array, Array, float]:
    """Derivatives of the forces of `Point`, of the motion and of ln a by the arc length."""
    length = np.linalg.norm(_rates(point))
    return point.tangent.forces / length, point.tangent.motion / length, float(point.tangent.parameter / length)


def first_harmonic_pace(balance: ModeBalance, point: CurvePoint) -> NDArray[np.complex128]:
    """Derivative of Q₁ of every degree of freedom by the arc length, complex (n,), m."""
    forces, _, rate = arc_tangent(point)
    slope = balance.coordinates_slope(point.evaluation, forces, rate)
    return np.asarray(balance.structures.whole[balance.structures.key[1]] @ slope[:, 1])


def directed(balance: ModeBalance, before: CurvePoint, point: CurvePoint) -> CurvePoint:
    """A solved point with the direction of the curve there and its distance from the point before."""
    factors = balance.factorise(point.evaluation, PathCondition("level", None, 1.0, 0.0))
    forces, motion, amount, _ = balance.tangent(point.evaluation, "level", factors)
    length = point.metric.length(motion, amount)
    length = -length if (point.point.level - before.point.level) * amount < 0.0 else length
    tangent = Tangent(forces / length, motion / length, amount / length)
    return replace(point, tangent=tangent, length=before.chord(point, "level"))


BEFORE_SLIP, BEYOND_SLIP = 0.5, 1000.0
"""Where a curve begins and ends, unless given, as multiples of the amplitude at which the first contact slips."""

TINY, RANGE = 1e-12, 60.0
"""Motion of the contacts, m, from which the first slip is sought, and how far, in ln a."""

NODE = 1e-9
"""Motion below this share of the largest is rounding: contacts at a node of the mode."""

APART = 0.2
"""Difference of neighbouring points in ln a, and twice that in ln ζ, above which a point is solved between them."""

FINEST, DIVISIONS = 1e-4, 6
"""Difference in ln a below which, and times after which, an interval is not divided."""

SMALLER = (0.0, 2.3, 4.6, 9.2)
"""How much smaller the amplitude is, in ln a, from which a mode is followed that is not found at the smallest one."""

POINTS = 1000


@dataclass(frozen=True, eq=False)
class ModeCurve:
    """Solved points in order, and outcome and sentence of the end."""

    points: tuple[CurvePoint, ...]
    outcome: Outcome
    message: str


def slip_level(balance: ModeBalance) -> float:
    """The path parameter at which the stuck mode makes the first contact slip or open."""
    size = float(np.max(np.abs(balance.shape[: balance.rows]), initial=0.0))
    if size <= NODE * balance.largest_motion:
        raise InputError("amplitude must be given, since no contact moves in this mode. Give it as (low, high).")
    low = high = smallest = balance.level_of(TINY / size)
    if not _stuck(balance, low):
        why = "are nonlinear, slip or are open however small it is"
        raise InputError(f"amplitude must be given, since the contacts {why}. Give it as (low, high).")
    while _stuck(balance, high):
        low, high = high, high + 1.0
        if high > smallest + RANGE:
            raise InputError("amplitude must be given, since no contact slips at any amplitude. Give it as (low, high).")
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _stuck(balance, middle) else (low, middle)
    return low


def _stuck(balance: ModeBalance, level: float) -> bool:
    evaluation = balance.evaluate(balance.linear_point(level))
    return not np.any(evaluation.unknown == SLIPPING)


def solve_mode(
    balance: ModeBalance, low: float, high: float, progress: Callable[[float], None] = lambda fraction: None
) -> ModeCurve:
    """The curve between two values of the path parameter ln a; one that is lost is traced again with reversible steps."""
    first = _first(balance, low)
    if not first.converged:
        return ModeCurve((), Outcome.NOT_CONVERGED, "No motion was found at the smallest amplitude.")
    points, lost = _traced(balance, first, high, StepControl(points=POINTS), progress)
    if lost is not None:
        again, still = _traced(balance, first, high, StepControl(points=POINTS, reversible=True), progress)
        if still is None or again[-1].point.level > points[-1].point.level:
            points, lost = again, still
    outcome = Outcome.CONVERGED if lost is None else Outcome.NOT_CONVERGED
    message = "The curve reached the largest amplitude."
    if lost is not None:
        cause = held_by_friction(balance.problem, balance.harmonics)
        message = f"The curve ended before the largest amplitude: {lost} {cause}".rstrip()
    # Points are solved between those that are far apart.
    points = points[:1] + [each for pair in pairwise(points) for each in _between(balance, *pair, DIVISIONS)]
    if len(points) > 1:  # the tangent of the last point is that of the step that passed the end
        points[-1] = directed(balance, points[-2], points[-1])
    return ModeCurve(tuple(refined(balance, points)), outcome, message)


def followed(balance: ModeBalance, low: float, high: float) -> list[CurvePoint]:
    """The points of continuation alone between two values of ln a, as far as they lead; none where no motion is found."""
    first = _first(balance, low)
    return _traced(balance, first, high, StepControl(points=POINTS), lambda share: None)[0] if first.converged else []


def _first(balance: ModeBalance, level: float) -> Correction:
    """The mode at the smallest amplitude: from the stuck mode, else from there with the forces at rest, else from a smaller one.

    Where contacts slip or are open at rest, their forces there are far from those of stuck contacts.
    """
    found = _solved(balance, balance.linear_point(level))
    if found.converged:
        return found
    rest = solve_cold(HarmonicBalance(balance.problem, balance.harmonics, balance.tables.E.shape[0]), balance.linear_omega, 0.0)
    forces = rest.evaluation.point.forces
    for lower in SMALLER:
        start = balance.linear_point(level - lower)
        start.forces[: balance.rows, 0] = forces[:, 0]
        low = _solved(balance, start)
        if low.converged:
            return _raised(balance, low, level)
    return found


def _solved(balance: ModeBalance, start: Point) -> Correction:
    """The mode at an amplitude: by descent from a start, else with the patience to cross kinks."""
    condition = fixed("level", start.level)
    found = correct(balance, start, condition, iterations=40, halvings=12)
    return found if found.converged else correct(balance, start, condition, iterations=40, patience=30)


def _raised(balance: ModeBalance, low: Correction, level: float) -> Correction:
    """The mode at an amplitude, followed from a smaller one."""
    if low.evaluation.point.level == level:
        return low
    try:
        *_, last = trace(balance, low, "level", level, StepControl(points=400))
    except LostCurveError:
        return low
    return correct(balance, last.point, fixed("level", level), iterations=40, halvings=12)


def _traced(
    balance: ModeBalance, first: Correction, high: float, control: StepControl, progress: Callable[[float], None]
) -> tuple[list[CurvePoint], str | None]:
    """The points to `high`, and why the curve ended before, or None."""
    points: list[CurvePoint] = []
    low = first.evaluation.point.level
    try:
        for point in trace(balance, first, "level", high, control):
            points.append(point)
            progress(float(np.clip((point.point.level - low) / (high - low), 0.0, 1.0)))
    except LostCurveError as reason:
        return points, str(reason)
    return points, None


def _between(balance: ModeBalance, before: CurvePoint, after: CurvePoint, divisions: int) -> list[CurvePoint]:
    """The points behind one, up to the next one."""
    a, b = before.point.level, after.point.level
    zeta = [abs(balance.damping_of(point.point)) + 1e-300 for point in (before, after)]
    far = max(abs(b - a), 0.5 * abs(np.log(zeta[1] / zeta[0]))) > APART
    if not far or divisions == 0 or abs(b - a) < FINEST:
        return [after]
    try:
        middle = directed(balance, before, solve_at(balance, before, after, "level", 0.5 * (a + b)))
    except LostCurveError:
        return [after]
    rest = replace(after, length=middle.chord(after, "level"))
    return _between(balance, before, middle, divisions - 1) + _between(balance, middle, rest, divisions - 1)


ROUNDING = 1e-10
"""Difference in ζ, relative to the largest, that is rounding: contacts that stick have the damping of the stuck mode."""


@dataclass(frozen=True, eq=False)
class DampingCurve:
    """A traced mode with the extremes of its damping among its points: between neighbours ζ rises or falls.

    extremes: which points those are.
    """

    balance: ModeBalance
    points: tuple[CurvePoint, ...]
    extremes: frozenset[int]

    @classmethod
    def of(cls, balance: ModeBalance, points: Sequence[CurvePoint]) -> "DampingCurve":
        """The curve of solved points in order, each with its tangent."""
        if len(points) > 1:  # the tangent of the last point is that of the step that passed the end
            points = [*points[:-1], directed(balance, points[-2], points[-1])]
        found, extremes = list(points[:1]), set[int]()
        for before, after in pairwise(points):
            if _rise(before) * _rise(after) < 0.0:
                extreme = _located(balance, before, after, _rise)
                if extreme is not None:
                    extremes.add(len(found))
                    found.append(extreme)
            found.append(after)
        return cls(balance, tuple(found), frozenset(extremes))

    @property
    def ratios(self) -> list[float]:
        """ζ of every point."""
        return [self.balance.damping_of(point.point) for point in self.points]

    @property
    def largest(self) -> int:
        """The point of the largest damping ratio."""
        return int(np.argmax(self.ratios))

    def slope(self, k: int) -> float:
        """dζ/d ln a at a point, zero at an extreme."""
        return 0.0 if k in self.extremes else slope(self.points[k])

    def roots(self, ratio: float) -> list[CurvePoint]:
        """The points at which the damping ratio has a value, in the order of the curve."""
        found = []
        rounding = ROUNDING * max(map(abs, self.ratios), default=0.0)
        for before, after in pairwise(self.points):
            misses = [self.balance.damping_of(point.point) - ratio for point in (before, after)]
            # A curve that leaves the value by rounding alone has not crossed it: the stuck part of one that just begins to slip.
            if misses[0] * misses[1] < 0.0 and min(map(abs, misses)) > rounding:
                root = _located(self.balance, before, after, lambda point: self.balance.damping_of(point.point) - ratio)
                found += [] if root is None else [root]
            elif abs(misses[1]) <= rounding < abs(misses[0]):
                found.append(after)
        return found


def is_stable(point: CurvePoint) -> bool:
    """Whether ζ rises with the amplitude, on a part of the curve that has not turned back: beyond a fold another motion of
    the same amplitude is the mode that vibration follows."""
    return point.tangent.parameter > 0.0 and slope(point) > 0.0


def slope(point: CurvePoint) -> float:
    """dζ/d ln a along the curve."""
    return float(point.tangent.forces[-1, 2] / point.tangent.parameter)


def _rise(point: CurvePoint) -> float:
    """dζ/ds along the curve."""
    return float(point.tangent.forces[-1, 2])


def _located(
    balance: ModeBalance, before: CurvePoint, after: CurvePoint, wanted: Callable[[CurvePoint], float]
) -> CurvePoint | None:
    """The point between two at which a function of solved points changes its sign, to rounding; None where none is solved."""
    ends = before.point.level, after.point.level
    solved = {ends[0]: before, ends[1]: after}

    def at(level: float) -> float:
        if level not in solved:
            solved[level] = directed(balance, before, solve_at(balance, before, after, "level", level))
        return wanted(solved[level])

    try:
        return solved[float(scipy.optimize.brentq(at, *ends, xtol=1e-14, rtol=1e-14))] if ends[0] != ends[1] else None
    except LostCurveError:
        return None
