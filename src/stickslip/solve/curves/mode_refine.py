"""Refinement of a nonlinear mode: points solved where the cubic through two neighbours and their tangents is not right.

The cubics run over the arc length s of the curve in ln a, ln ω and ζ, ds² = (d ln a)² + (d ln ω)² + dζ², the length between
neighbours taken along the straight way. Peaks of force levels are read off the same cubics.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stickslip.solve.balance.balance import PathCondition
from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, Tangent, hermite, solve_at
from stickslip.support.checks import Array

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
    return balance.first_harmonic_slope(point.evaluation, forces, rate)


def directed(balance: ModeBalance, before: CurvePoint, point: CurvePoint) -> CurvePoint:
    """A solved point with the direction of the curve there and its distance from the point before."""
    factors = balance.factorise(point.evaluation, PathCondition("level", None, 1.0, 0.0))
    forces, motion, amount, _ = balance.tangent(point.evaluation, "level", factors)
    length = point.metric.length(motion, amount)
    length = -length if (point.point.level - before.point.level) * amount < 0.0 else length
    tangent = Tangent(forces / length, motion / length, amount / length)
    return replace(point, tangent=tangent, length=before.chord(point, "level"))
