"""Whether another motion enters the band of a curve from outside: the band then decides which of the two a sweep follows.

Where a resonance leans over the band, a curve that begins inside stays below it, and one that begins outside climbs it. Newton's
method from other starts at the same frequencies finds neither more often than the curve itself; a curve from beyond an end does.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import chain, pairwise

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.continuation import solve_cold, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, solve_at
from stickslip.solve.continuation.newton import Correction
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
    own = _sizes(balance, curve.inside, measure)
    upwards, downwards = [1.0 / factor for factor in BEYOND], BEYOND
    for begin, points in chain(_entering(balance, curve, *ends[::-1], downwards), _entering(balance, curve, *ends, upwards)):
        sizes = _sizes(balance, points, measure)
        ratios = sizes.max(axis=0) / np.maximum(own.max(axis=0), np.finfo(float).tiny)
        output = int(np.argmax(np.where(own.max(axis=0) > 0.0, ratios, 0.0)))
        if ratios[output] > HIGHER:
            highest = balance.hertz(points[int(np.argmax(sizes[:, output]))].point.omega)
            enters, begins = (balance.hertz(omega) for omega in (points[0].point.omega, begin))
            return (
                f"Another motion enters the band at {enters:.6g} Hz, with {ratios[output]:.3g} times the highest "
                f"{balance.problem.output_names[output]} of this curve, at {highest:.6g} Hz. Which one occurs depends on "
                f"how the vibration starts: repeat the run with a band that starts at {begins:.4g} Hz."
            )
    return ""


def _entering(
    balance: HarmonicBalance, curve: Curve, edge: CurvePoint, far: CurvePoint, beyond: Sequence[float]
) -> Iterator[tuple[float, list[CurvePoint]]]:
    """The curves that enter the band through an edge: ω in rad/s at which each begins, and its points inside, that at the edge
    first. The one from nearby is not followed where that from farther away leads through its first point."""
    near, away = (solve_cold(balance, factor * edge.point.omega, curve.level) for factor in beyond)
    farther, through = _inside(balance, curve, edge, far, away, near)
    found = [(near, farther)] if through else [(near, _inside(balance, curve, edge, far, near)[0]), (away, farther)]
    yield from ((first.evaluation.point.omega, points) for first, points in found if points)


def _inside(
    balance: HarmonicBalance,
    curve: Curve,
    edge: CurvePoint,
    far: CurvePoint,
    first: Correction,
    between: Correction | None = None,
) -> tuple[list[CurvePoint], bool]:
    """The points inside the band of the curve from a motion outside, and whether it led through another motion to the edge.

    None where it is the curve itself that it meets at the edge, which it may pass several times, and where it cannot be followed
    with what may be spent.
    """
    if not first.converged:
        return [], False
    left = max(LEAST_SPENT, SHARE * sum(float(point.iterations) * point.active**3 for point in curve.points))
    inside: list[CurvePoint] = []
    through, omega = False, edge.point.omega
    low, high = sorted((omega, far.point.omega))
    try:
        for before, point in pairwise(trace(balance, first, "omega", far.point.omega, StepControl(points=MOST_POINTS))):
            left -= max(point.iterations, 1.0) * float(point.active) ** 3
            if between is not None and between.converged and not inside:
                through = through or _passes(balance, before, point, between.evaluation)
            if not inside and (before.point.omega - omega) * (point.point.omega - omega) < 0.0:
                inside.append(solve_at(balance, before, point, "omega", omega))
                if any(_same(inside[0].evaluation, each.evaluation) for each in curve.points if each.point.omega == omega):
                    return [], through
            if inside and low <= point.point.omega <= high:
                inside.append(point)
            if left < 0.0:
                break
    except LostCurveError:
        pass
    return inside, through and len(inside) > 0


def _passes(balance: HarmonicBalance, before: CurvePoint, point: CurvePoint, motion: Evaluation) -> bool:
    """Whether a step passes a motion."""
    omega = motion.point.omega
    if (before.point.omega - omega) * (point.point.omega - omega) >= 0.0:
        return False
    with suppress(LostCurveError):
        return _same(solve_at(balance, before, point, "omega", omega).evaluation, motion)
    return False


def _same(one: Evaluation, other: Evaluation) -> bool:
    """Whether two solutions at one frequency are one motion."""
    a, b = one.w[:, 1:], other.w[:, 1:]
    return float(np.linalg.norm(a - b)) <= SAME * float(np.linalg.norm(b))


def _sizes(balance: HarmonicBalance, points: tuple[CurvePoint, ...] | list[CurvePoint], measure: Measure) -> Array:
    """The measure of every output, (points, outputs)."""
    outputs = range(balance.rows, balance.rows + len(balance.problem.outputs))
    return np.array([[measure.size(point.evaluation.w[row], point.point.omega) for row in outputs] for point in points])
