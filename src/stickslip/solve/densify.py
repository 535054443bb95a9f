"""Points between the points of a continuation, so that straight lines between them draw the curve; every one of them solved.

Continuation takes steps as long as its predictor allows, tens of points a curve. Between two of them the cubic through points and
tangents is a start so good that Newton's method needs a step or two, on planes across the curve: folds are no obstacle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stickslip.checks import Array
from stickslip.harmonic.balance import HarmonicBalance, PathCondition, Point
from stickslip.solve.curve import Curve
from stickslip.solve.curve_points import CurvePoint, between, hermite
from stickslip.solve.newton import correct

MOST = 18
"""Into how many pieces a step is divided at most."""


def densified(balance: HarmonicBalance, curve: Curve, tolerance: float = 5e-3) -> Curve:
    """The curve with points between its own where straight lines would miss an amplitude by more than `tolerance` of it."""
    points: list[CurvePoint] = list(curve.points[:1])
    for current, following in zip(curve.points[:-1], curve.points[1:], strict=True):
        points += _inside(balance, current, following, tolerance)
        points.append(following)
    return replace(curve, points=tuple(points))


def _inside(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint, tolerance: float) -> list[CurvePoint]:
    """Solved points inside one step: none, or so many that the error of straight lines, of second order, is below tolerance."""
    if following.length <= 0.0:
        return []
    thirds = [_solved(balance, current, following, fraction) for fraction in (1.0 / 3.0, 2.0 / 3.0)]
    known = [point for point in thirds if point is not None]
    error = max((_chord_error(balance, current, following, point) for point in known), default=0.0)
    if error <= tolerance:
        return []
    pieces = min(3 * int(np.ceil(np.sqrt(error / tolerance) / 3.0)), MOST)
    found = [_solved(balance, current, following, k / pieces) for k in range(1, pieces)] if pieces > 3 else thirds
    return [point for point in found if point is not None]


def _chord_error(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint, inside: CurvePoint) -> float:
    """Relative error of the straight line over frequency between two points, at a point of the curve inside."""
    low, high, omega = current.point.omega, following.point.omega, inside.point.omega
    share = (omega - low) / (high - low) if min(low, high) < omega < max(low, high) else 0.5
    ends, amplitude = [_amplitudes(balance, p) for p in (current, following)], _amplitudes(balance, inside)
    line = (1.0 - share) * ends[0] + share * ends[1]
    return float(np.max(np.abs(line - amplitude) / np.maximum(amplitude, np.finfo(float).tiny)))


def _amplitudes(balance: HarmonicBalance, point: CurvePoint) -> Array:
    """|X_1| of every output, m."""
    return np.asarray(np.hypot(*point.evaluation.w[balance.rows :, 1:3].T))


def _solved(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint, fraction: float) -> CurvePoint | None:
    """The point at a fraction of the step, on the plane across the tangent of its first end; None where Newton fails."""
    tangent, metric = current.tangent, current.metric
    plane = PathCondition("omega", metric.weight * tangent.motion, metric.parameter * tangent.parameter, 0.0)
    reached = [plane.rate(p.evaluation.w, p.point.omega) for p in (current, following)]
    condition = replace(plane, target=reached[0] + fraction * (reached[1] - reached[0]))
    step = following.length
    scale = following.metric.length(tangent.motion, tangent.parameter)
    slopes = [step * tangent.parameter, step * scale * following.tangent.parameter]
    a, da, b, db = (np.array(value) for value in (current.point.omega, slopes[0], following.point.omega, slopes[1]))
    omega = float(hermite(a, da, b, db, fraction))
    start = Point(between(current, following, fraction), omega, current.point.level)
    correction = correct(balance, start, condition, iterations=8)
    if not correction.converged:
        return None
    size = 0 if correction.factors is None else correction.factors.size
    return CurvePoint(correction.evaluation, tangent, metric, correction.iterations, size, 0.0)
