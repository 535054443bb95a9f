"""The curve of one nonlinear mode over its amplitude, from stuck contacts on, through folds, with points dense enough to draw."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stickslip.model.contact.period import SLIPPING
from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.solve.continuation.continuation import solve_cold, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, solve_at
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.curves.curve import held_by_friction
from stickslip.solve.curves.mode_refine import directed, refined
from stickslip.support.checks import InputError
from stickslip.support.outcome import Outcome

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
    points = _dense(balance, points)
    if len(points) > 1:  # the tangent of the last point is that of the step that passed the end
        points[-1] = directed(balance, points[-2], points[-1])
    return ModeCurve(tuple(refined(balance, points)), outcome, message)


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


def _dense(balance: ModeBalance, points: list[CurvePoint]) -> list[CurvePoint]:
    """The curve with points solved between those that are far apart."""
    found = points[:1]
    for before, after in pairwise(points):
        found += _between(balance, before, after, DIVISIONS)
    return found


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
