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

RUN_UPS = (1.0, 0.8, 0.6, 0.4, 0.2)
"""Where to start, as a share of the start of the band: at it, or further out where Newton fails or the curve turns back."""

TURNED_BACK = "The curve turned back and left the band through its start."

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

    def watched(point: CurvePoint) -> None:
        progress(abs(point.point.omega - start) / max(abs(end - start), 1e-300))

    wanted = frequencies if exactly else None
    failed: Outcome | None = None
    lost: _Traced | None = None
    for run_up in RUN_UPS:
        omega = start * run_up if end >= start else start / run_up
        first = first_point(balance, omega, level)
        if not first.converged:
            failed = failed or failure(balance, first)
            continue
        if start == end == omega:
            return _finished(balance, level, _Traced([_only_point(balance, first)], None), wanted)
        traced = _traced(balance, first, start, end, control, watched)
        if traced.lost is None:
            return _finished(balance, level, traced, wanted)
        lost = max(lost or traced, traced, key=lambda t: len(t.points))
        if lost.points and TURNED_BACK not in str(lost.lost):
            break
    if lost is not None and lost.points:
        return _finished(balance, level, lost, wanted)
    outcome = failed or Outcome.NOT_CONVERGED
    return Curve(level, (), outcome, outcome.sentence, start)


@dataclass(frozen=True, eq=False)
class _Traced:
    """Points inside the band, and why the curve ended before the end of the band, or None."""

    points: list[CurvePoint]
    lost: str | None


def _traced(
    balance: HarmonicBalance,
    first: Correction,
    start: float,
    end: float,
    control: StepControl | None,
    watched: Callable[[CurvePoint], None],
) -> _Traced:
    """The curve from a first point, at the start of the band or outside before it, to the end of the band."""
    direction = 1.0 if end >= start else -1.0
    points: list[CurvePoint] = []
    before: CurvePoint | None = None
    try:
        if first.evaluation.point.omega != start and start == end:
            for before in trace(balance, first, "omega", start, control):
                pass
            return _Traced([] if before is None else [before], None)
        for point in trace(balance, first, "omega", end, control):
            if not points and direction * (point.point.omega - start) > 0.0 and before is not None:
                points.append(solve_at(balance, before, point, "omega", start))
            if points or point.point.omega == start:
                points.append(point)
                watched(point)
            before = point
    except Lost as reason:
        return _Traced(points, str(reason))
    if before is None or before.point.omega != end:
        return _Traced(points, TURNED_BACK)
    return _Traced(points, None)


def _finished(balance: HarmonicBalance, level: float, traced: _Traced, wanted: Sequence[float] | None) -> Curve:
    points, lost = traced.points, traced.lost
    outcome = Outcome.CONVERGED if lost is None else Outcome.NOT_CONVERGED
    message = lost or "The curve reached the end of the band."
    lost_at = points[-1].point.omega if lost is not None and points else None
    if wanted is not None:
        return Curve(level, tuple(_at(balance, points, wanted)), outcome, message, lost_at)
    outputs = range(balance.problem.output_rows.shape[0])
    found = [peaks(balance, points, output) for output in outputs]
    largest = [peaks(balance, points, output, largest_absolute, least=0.8) for output in outputs]
    unsolved = sum(search.unsolved for search in (*found, *largest))
    if unsolved:
        message += f" {unsolved} places beside peaks could not be solved; a peak there may be higher than reported."
    highest = tuple(_highest(balance.rows + output, search.points) for output, search in zip(outputs, largest, strict=True))
    return Curve(level, tuple(points), outcome, message, lost_at, tuple(search.points for search in found), highest)


def _highest(row: int, points: Sequence[CurvePoint]) -> CurvePoint | None:
    """The point with the highest max |x(t)| of a row."""
    return max(points, key=lambda point: largest_absolute(point.evaluation.w[row])[0], default=None)


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
