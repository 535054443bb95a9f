"""One response curve at one force level: over a band, or at given frequencies reached by continuation. Says how it ended."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.trigonometric import largest_absolute
from stickslip.outcome import Outcome
from stickslip.solve.continuation import CurvePoint, Lost, StepControl, first_point, solve_at, trace
from stickslip.solve.newton import Correction, correct, fixed
from stickslip.solve.peak import peaks

SINGULAR = 1e-13
"""Ratio of the smallest to the largest pivot below which a Newton matrix counts as singular."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Solved points in order; outcome and sentence of the end; where it was lost, in rad/s, or None.

    peaks: of the first harmonic, per output; largest: where max |x(t)| is highest, per output, or None without a peak.
    """

    level: float
    points: tuple[CurvePoint, ...]
    outcome: Outcome
    message: str
    lost_at: float | None
    peaks: tuple[tuple[CurvePoint, ...], ...] = ()
    largest: tuple[CurvePoint | None, ...] = ()


def solve_curve(
    balance: HarmonicBalance,
    frequencies: tuple[float, float] | Sequence[float],
    level: float,
    exactly: bool,
    progress: Callable[[float], None] = lambda fraction: None,
    control: StepControl | None = None,
) -> Curve:
    """The curve from frequencies[0] to frequencies[-1] in rad/s; `exactly`: only the points at the given frequencies."""
    start, end = frequencies[0], frequencies[-1]
    first = first_point(balance, start, level)
    if not first.converged:
        outcome = failure(balance, first)
        return Curve(level, (), outcome, outcome.sentence, start)
    points: list[CurvePoint] = []
    lost: str | None = None
    try:
        if start == end:
            points.append(_only_point(balance, first))
        else:
            for point in trace(balance, first, "omega", end, control):
                points.append(point)
                progress(abs(point.point.omega - start) / abs(end - start))
    except Lost as reason:
        lost = str(reason)
    if lost is None and start != end and points[-1].point.omega != end:
        lost = "The curve turned back and left the band through its start."
    return _finished(balance, level, points, lost, frequencies if exactly else None)


def _finished(
    balance: HarmonicBalance, level: float, points: list[CurvePoint], lost: str | None, wanted: Sequence[float] | None
) -> Curve:
    outcome = Outcome.CONVERGED if lost is None else Outcome.NOT_CONVERGED
    message = lost or "The curve reached the end of the band."
    lost_at = points[-1].point.omega if lost is not None and points else None
    if wanted is not None:
        return Curve(level, tuple(_at(balance, points, wanted)), outcome, message, lost_at)
    outputs = range(balance.problem.output_rows.shape[0])
    found = tuple(tuple(peaks(balance, points, output)) for output in outputs)
    largest = tuple(_largest(balance, points, output) for output in outputs)
    return Curve(level, tuple(points), outcome, message, lost_at, found, largest)


def _largest(balance: HarmonicBalance, points: Sequence[CurvePoint], output: int) -> CurvePoint | None:
    """The highest peak of max |x(t)|."""
    row = balance.rows + output
    found = peaks(balance, points, output, largest_absolute)
    return max(found, key=lambda point: largest_absolute(point.evaluation.w[row])[0], default=None)


def _only_point(balance: HarmonicBalance, first: Correction) -> CurvePoint:
    """A single solved frequency as a curve of one point, the way `trace` would start."""
    omega = first.evaluation.point.omega
    return next(iter(trace(balance, first, "omega", 1.01 * omega)))


def _at(balance: HarmonicBalance, points: Sequence[CurvePoint], wanted: Sequence[float]) -> list[CurvePoint]:
    """The curve at the wanted frequencies, each solved exactly where it is first crossed; frequencies not reached are left out."""
    omegas = np.array([point.point.omega for point in points])
    found = []
    for omega in wanted:
        exact = np.flatnonzero(omegas == omega)
        crossed = np.flatnonzero((omegas[:-1] - omega) * (omegas[1:] - omega) < 0.0)
        if exact.size:
            found.append(points[exact[0]])
        elif crossed.size:
            k = int(crossed[0])
            found.append(solve_at(balance, points[k], points[k + 1], "omega", omega))
    return found


def failure(balance: HarmonicBalance, correction: Correction) -> Outcome:
    """Why a point could not be solved: the same problem without its dynamic load tells whether the static state exists."""
    point = correction.evaluation.point
    still = correct(balance, balance.stuck_point(point.omega, 0.0), fixed("omega", point.omega), iterations=60, halvings=12)
    for attempt in (still, correction):
        factors = attempt.factors
        if not attempt.converged and factors is not None:
            pivots = np.abs(np.diag(factors.lu))
            if pivots.min() <= SINGULAR * pivots.max():
                return Outcome.BODY_HELD_BY_NOTHING
    return Outcome.NOT_CONVERGED if still.converged else Outcome.NO_STATIC_EQUILIBRIUM
