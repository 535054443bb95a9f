"""Whether another motion enters the band of a curve from outside: the band then decides which of the two a sweep follows.

Where a resonance leans over the band, a curve that begins inside stays below it, and one that begins outside climbs it. Newton's
method from other starts at the same frequencies finds neither more often than the curve itself; a curve from beyond an end does.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.continuation import solve_cold, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, solve_at
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.curves.curve import Curve
from stickslip.support.checks import Array
from stickslip.support.outcome import Outcome

BEYOND = (1.25, 2.0)
"""How many times beyond an end of the band, in frequency, other curves begin: a resonance may lean farther than the first."""

MOST_POINTS = 600

SAME = 1e-2
"""Relative difference of two motions at one frequency up to which they are one."""

HIGHER = 1.1
"""How many times as high as the curve another one must rise inside the band for a warning."""

LEAST_SPENT, SHARE = 3e9, 0.1
"""(Rows of the Newton matrix)³ times steps that may be taken, a fifth of a second or so, or this share of what the curve took."""


def other_motion_warning(balance: HarmonicBalance, curve: Curve, measure: Measure) -> str:
    """What to say where a higher motion enters the band through one of its ends; empty where none is met."""
    if curve.outcome != Outcome.CONVERGED or len(curve.points) < 2:
        return ""
    ends = curve.points[0], curve.points[-1]
    if ends[0].point.omega > ends[1].point.omega:
        ends = ends[1], ends[0]
    own = _sizes(balance, curve.points, measure)
    upwards, downwards = [(*ends, 1.0 / beyond) for beyond in BEYOND], [(*ends[::-1], beyond) for beyond in BEYOND]
    for edge, other, outside in (*downwards, *upwards):
        points = _entering(balance, curve, edge, outside * edge.point.omega, other.point.omega)
        if not points:
            continue
        sizes = _sizes(balance, points, measure)
        ratios = sizes.max(axis=0) / np.maximum(own.max(axis=0), np.finfo(float).tiny)
        output = int(np.argmax(np.where(own.max(axis=0) > 0.0, ratios, 0.0)))
        if ratios[output] > HIGHER:
            highest = balance.hertz(points[int(np.argmax(sizes[:, output]))].point.omega)
            enters, begins = (balance.hertz(omega) for omega in (edge.point.omega, outside * edge.point.omega))
            return (
                f"Another motion enters the band at {enters:.6g} Hz, with {ratios[output]:.3g} times the highest "
                f"{balance.problem.output_names[output]} of this curve, at {highest:.6g} Hz. Which of them a vibration takes "
                f"depends on how it begins: compute a band that begins at {begins:.4g} Hz."
            )
    return ""


def _entering(balance: HarmonicBalance, curve: Curve, edge: CurvePoint, outside: float, far: float) -> list[CurvePoint]:
    """The points inside the band of the curve that comes from outside through an edge, ω in rad/s; none where it is the curve
    itself that it meets there, and where it cannot be followed with what may be spent."""
    left = max(LEAST_SPENT, SHARE * sum(float(point.iterations) * point.active**3 for point in curve.points))
    first = solve_cold(balance, outside, curve.level)
    if not first.converged:
        return []
    inside: list[CurvePoint] = []
    omega, low, high = edge.point.omega, *sorted((edge.point.omega, far))
    try:
        for before, point in pairwise(trace(balance, first, "omega", far, StepControl(points=MOST_POINTS))):
            left -= max(point.iterations, 1.0) * float(point.active) ** 3
            if not inside and (before.point.omega - omega) * (point.point.omega - omega) < 0.0:
                crossing = solve_at(balance, before, point, "omega", omega)
                if _same(crossing, edge):
                    return []
                inside.append(crossing)
            if inside and low <= point.point.omega <= high:
                inside.append(point)
            if left < 0.0:
                break
    except LostCurveError:
        pass
    return inside


def _same(one: CurvePoint, other: CurvePoint) -> bool:
    """Whether two points at one frequency are one motion."""
    a, b = one.evaluation.w[:, 1:], other.evaluation.w[:, 1:]
    return float(np.linalg.norm(a - b)) <= SAME * float(np.linalg.norm(b))


def _sizes(balance: HarmonicBalance, points: tuple[CurvePoint, ...] | list[CurvePoint], measure: Measure) -> Array:
    """The measure of every output, (points, outputs)."""
    outputs = range(balance.rows, balance.rows + len(balance.problem.outputs))
    return np.array([[measure.size(point.evaluation.w[row], point.point.omega) for row in outputs] for point in points])
