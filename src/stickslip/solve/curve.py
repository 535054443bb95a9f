"""One response curve at one force level, over a band or at given frequencies, with its outcome."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from stickslip.contact.period import OFFSET
from stickslip.harmonic.balance import HarmonicBalance, Point
from stickslip.harmonic.measure import DISPLACEMENT_AMPLITUDE, Measure
from stickslip.outcome import Outcome
from stickslip.problem import Problem
from stickslip.solve.continuation import CLOSED, StepControl, first_point, solve_cold, trace
from stickslip.solve.curve_points import CurvePoint, LostCurveError, backwards, solve_at
from stickslip.solve.newton import Correction, correct, fixed
from stickslip.solve.peak import TOLERANCE, PeakSearch

RUN_UPS = (1.0, 0.8, 0.6, 0.4, 0.2)
"""Where to start, as a share of the start of the band: at it, or further out where Newton fails or the curve turns back."""

RESTARTS = 3
"""How often a list of frequencies is begun anew where a curve does not reach the rest of it."""

CAREFUL = 0.1
"""Angle aside of the curve, rad, up to which a step of it is believed once it has closed on itself: it had left its branch."""

TURNED_BACK = "The curve turned back and left the band through its start."
PASSED_BY = "The curve has no point inside the band."
ARRIVED = "The curve reached the end of the band."

TRAVEL = 0.3
"""Share of the work that is travelling along a curve, about; the rest is the search for its peaks."""

SINGULAR = 1e-13
"""Ratio of the smallest to the largest pivot below which a Newton matrix counts as singular."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Solved points in order; outcome and sentence of the end; where it was lost, in rad/s, or None.

    peaks: of `measure`, per output; steps: the step, from points[k] to the next one, that each of them lies in, until `refine`
    made them points of the curve; largest: where the same quantity is largest in time, per output, or None without a peak;
    missing: of listed frequencies, the place in the list and ω of those without a point.
    """

    level: float
    points: tuple[CurvePoint, ...]
    outcome: Outcome
    message: str
    lost_at: float | None
    peaks: tuple[tuple[CurvePoint, ...], ...] = ()
    largest: tuple[CurvePoint | None, ...] = ()
    steps: tuple[tuple[int, ...], ...] = ()
    measure: Measure = DISPLACEMENT_AMPLITUDE
    missing: tuple[tuple[int, float], ...] = ()


@dataclass(frozen=True, eq=False)
class _Travel:
    """Points inside the band, and why the curve ended before the end of the band, or None.

    from_the_end: why it was followed from the end of the band and not from its start, or None.
    """

    points: list[CurvePoint]
    lost: str | None
    from_the_end: str | None = None


def solve_curve(
    balance: HarmonicBalance,
    frequencies: Sequence[float],
    level: float,
    exactly: bool,
    progress: Callable[[float], None] = lambda fraction: None,
    control: StepControl | None = None,
    begin: Point | None = None,
    peak_tolerance: float = TOLERANCE,
    measure: Measure = DISPLACEMENT_AMPLITUDE,
) -> Curve:
    """The curve from frequencies[0] to frequencies[-1] in rad/s; `exactly`: the points at the given frequencies, in their order.

    begin: a solved point at frequencies[0], when one is known; peak_tolerance: relative amplitude by which peaks may be too low;
    measure: what they are peaks of.
    """
    if exactly:
        return _listed(balance, frequencies, level, progress, control, begin, measure)
    start, end = frequencies[0], frequencies[-1]
    travel = _best_travel(balance, start, end, level, lambda done: progress(TRAVEL * done), control, begin)
    if begin is None and isinstance(travel, _Travel) and travel.lost is not None and start != end:
        travel = _from_the_end(balance, start, end, level, control, travel.lost) or travel
    if isinstance(travel, Outcome):
        message = " ".join((travel.sentence, *balance.problem.warnings))
        return Curve(level, (), travel, message, start, measure=measure)
    return _with_peaks(balance, level, travel, progress, peak_tolerance, measure, (start, end))


def _best_travel(
    balance: HarmonicBalance,
    start: float,
    end: float,
    level: float,
    progress: Callable[[float], None],
    control: StepControl | None,
    begin: Point | None,
) -> _Travel | Outcome:
    """The curve that reaches the end, else the longest; an outcome where no point can be solved to start from."""
    travels: list[_Travel] = []
    failed: Outcome | None = None
    for run_up in RUN_UPS:
        if begin is not None and run_up == 1.0:
            first = correct(balance, begin, fixed("omega", start))
        else:
            first = first_point(balance, start * run_up if end >= start else start / run_up, level)
        if not first.converged:
            failed = failed or failure(balance, first)
            continue
        travels.append(_careful_travel(balance, first, start, end, lambda done: progress(min(done, 1.0)), control))
        if travels[-1].lost not in (TURNED_BACK, PASSED_BY):
            break
    if not travels:
        return failed or Outcome.NOT_CONVERGED
    arrived = [travel for travel in travels if travel.lost is None]
    return arrived[0] if arrived else max(travels, key=lambda travel: len(travel.points))


def _from_the_end(
    balance: HarmonicBalance, start: float, end: float, level: float, control: StepControl | None, reason: str
) -> _Travel | None:
    """The curve followed from the end of the band, in the order asked for; None where that does not succeed either."""
    travel = _best_travel(balance, end, start, level, lambda done: None, control, None)
    if isinstance(travel, Outcome) or travel.lost is not None:
        return None
    return _Travel(backwards(travel.points), None, reason)


def _listed(
    balance: HarmonicBalance,
    frequencies: Sequence[float],
    level: float,
    progress: Callable[[float], None],
    control: StepControl | None,
    begin: Point | None,
    measure: Measure,
) -> Curve:
    """Points at listed frequencies: followed upwards where the list goes up and downwards where it goes down.

    What a curve does not reach is begun anew from the next frequency, `RESTARTS` times; what is left is solved by itself.
    """
    found: dict[int, CurvePoint] = {}
    reason, outcome, anew = "", Outcome.NOT_CONVERGED, 0
    for run in _monotonic_runs(frequencies):
        left = list(run)
        known = found[run[0]].point if run[0] in found else begin if run[0] == 0 else None
        for _ in range(1 + RESTARTS):
            travel = _best_travel(balance, frequencies[left[0]], frequencies[left[-1]], level, lambda done: None, control, known)
            if isinstance(travel, Outcome):
                reason, outcome = travel.sentence, travel
            else:
                found |= _at(balance, travel.points, {k: frequencies[k] for k in left if k not in found})
                reason = travel.lost or reason
            progress((run[-1] + 1) / len(frequencies))
            left, known = [k for k in left[1:] if k not in found], None
            if not left:
                break
            anew += 1
    alone = {k: point for k, omega in enumerate(frequencies) if k not in found and (point := _alone(balance, omega, level))}
    missing = tuple((k, frequencies[k]) for k in range(len(frequencies)) if k not in found and k not in alone)
    points = tuple(point for _, point in sorted((found | alone).items()))
    if not points:
        message = " ".join((reason or outcome.sentence, *balance.problem.warnings))
        return Curve(level, (), outcome, message, frequencies[0], measure=measure)
    message, count = ARRIVED, len(frequencies)
    if missing:
        first = f"the first at {missing[0][1] / (2.0 * np.pi):g} Hz"
        unsolved = f"{len(missing)} of {count} frequencies could not be solved, {first}."
        message = " ".join((unsolved, *balance.problem.warnings))
    elif anew and not alone:
        message = f"The curve was begun anew at {anew} of {count} frequencies. {reason}".strip()
    elif alone:
        message = f"{len(alone)} of {count} frequencies were solved by themselves, since the curve does not reach them."
    outcome = Outcome.NOT_CONVERGED if missing else Outcome.CONVERGED
    return Curve(level, points, outcome, message, None, measure=measure, missing=missing)


def _monotonic_runs(frequencies: Sequence[float]) -> list[list[int]]:
    """Numbers of the frequencies in runs that go up or down; each begins where the one before it ends."""
    runs = [[0]]
    for k in range(1, len(frequencies)):
        run = runs[-1]
        if len(run) > 1 and (frequencies[k] > frequencies[run[-1]]) != (frequencies[run[1]] > frequencies[run[0]]):
            runs.append([run[-1]])
        runs[-1].append(k)
    return runs


def _alone(balance: HarmonicBalance, omega: float, level: float) -> CurvePoint | None:
    """The point at one frequency, solved without others."""
    first = first_point(balance, omega, level)
    return next(iter(trace(balance, first, "omega", 1.01 * omega))) if first.converged else None


def _careful_travel(
    balance: HarmonicBalance,
    first: Correction,
    start: float,
    end: float,
    progress: Callable[[float], None],
    control: StepControl | None,
) -> _Travel:
    """As `_travel`; a curve that closes on itself has jumped to another branch, and is traced again with steps that do not."""
    travel = _travel(balance, first, start, end, progress, control)
    if travel.lost != CLOSED:
        return travel
    usual = control or StepControl()
    again = _travel(balance, first, start, end, progress, replace(usual, sideways=CAREFUL, points=4 * usual.points))
    return again if again.lost is None else travel


def _travel(
    balance: HarmonicBalance,
    first: Correction,
    start: float,
    end: float,
    progress: Callable[[float], None],
    control: StepControl | None,
) -> _Travel:
    """The curve from a first point, at the start of the band or outside before it, to the end of the band."""
    points: list[CurvePoint] = []
    if first.evaluation.point.omega == start == end:
        return _Travel([next(iter(trace(balance, first, "omega", 1.01 * start)))], None)
    before: CurvePoint | None = None
    try:
        for point in trace(balance, first, "omega", end, control):
            omega = point.point.omega
            if before is not None and not points and (omega - start) * (before.point.omega - start) < 0.0:
                points.append(solve_at(balance, before, point, "omega", start))
            if points or omega == start:
                points.append(point)
                progress(abs(omega - start) / max(abs(end - start), np.finfo(float).tiny))
            before = point
    except LostCurveError as reason:
        return _Travel(points, str(reason))
    if not points:
        return _Travel(points, PASSED_BY)
    arrived = before is not None and before.point.omega == end
    return _Travel(points, None if arrived else TURNED_BACK)


def _with_peaks(
    balance: HarmonicBalance,
    level: float,
    travel: _Travel,
    progress: Callable[[float], None],
    tolerance: float,
    measure: Measure,
    ends: tuple[float, float],
) -> Curve:
    """The curve with its peaks."""
    points, message = travel.points, ARRIVED if travel.lost is None else _lost_message(balance.problem, travel, ends)
    if travel.from_the_end is not None:
        message = f"{ARRIVED} It was followed backwards from there, since from its start it was lost: {travel.from_the_end}"
    outcome = Outcome.CONVERGED if travel.lost is None else Outcome.NOT_CONVERGED
    lost_at = points[-1].point.omega if travel.lost is not None and points else None
    outputs = range(balance.problem.output_rows.shape[0])
    search = PeakSearch(balance, points, tolerance)
    found, largest, in_time = [], [], measure.with_kind("max_abs")
    for output in outputs:
        found.append(search.peaks(output, measure))
        largest.append(search.peaks(output, in_time, least=0.8))
        progress(TRAVEL + (1.0 - TRAVEL) * (output + 1) / len(outputs))
    unsolved = sum(peaks.unsolved for peaks in (*found, *largest))
    if unsolved:
        message += f" {unsolved} places beside peaks could not be solved; a peak there may be higher than reported."
    highest = tuple(
        _highest(in_time, balance.rows + output, peaks.points) for output, peaks in zip(outputs, largest, strict=True)
    )
    peaks, steps = tuple(each.points for each in found), tuple(each.steps for each in found)
    return Curve(level, tuple(points), outcome, message, lost_at, peaks, highest, steps, measure)


def _lost_message(problem: Problem, travel: _Travel, ends: tuple[float, float]) -> str:
    """Why a curve ended before the end of its band, how far it got, how the rest can be had, and what may be the cause."""
    rest = "from the other end of the band, in a band that starts beyond, or as a list of frequencies there"
    omegas = [point.point.omega for point in travel.points]
    if ends[0] == ends[1]:
        where = ""
    elif omegas:
        farthest = max(omegas) if ends[1] > ends[0] else min(omegas)
        where = f"It got to {farthest / (2.0 * np.pi):.6g} Hz; compute the rest {rest}."
    else:
        where = f"Compute it {rest}."
    return " ".join(filter(None, (travel.lost, where, *problem.warnings)))


def _highest(measure: Measure, row: int, points: Sequence[CurvePoint]) -> CurvePoint | None:
    """The point with the highest measure of a row."""
    return max(points, key=lambda point: measure.size(point.evaluation.w[row], point.point.omega), default=None)


def _at(balance: HarmonicBalance, points: Sequence[CurvePoint], wanted: Mapping[int, float]) -> dict[int, CurvePoint]:
    """The curve at the wanted frequencies, each solved where it is first crossed; without those not reached or not solved."""
    omegas = np.array([point.point.omega for point in points])
    found = {}
    for number, omega in wanted.items():
        exact = np.flatnonzero(omegas == omega)
        crossed = np.flatnonzero((omegas[:-1] - omega) * (omegas[1:] - omega) < 0.0)
        if exact.size:
            found[number] = points[exact[0]]
        elif crossed.size:
            k = int(crossed[0])
            with suppress(LostCurveError):
                found[number] = solve_at(balance, points[k], points[k + 1], "omega", omega)
    return found


def failure(balance: HarmonicBalance, correction: Correction) -> Outcome:
    """Why a point could not be solved: the same problem without its dynamic load shows whether the static state is found.

    Where it is not, a prescribed start state is blamed only if there is one; Newton's method may have missed what exists.
    """
    point = correction.evaluation.point
    still = solve_cold(balance, point.omega, 0.0)
    for attempt in (still, correction):
        factors = attempt.factors
        if not attempt.converged and factors is not None:
            pivots = np.abs(factors.pivots)
            if pivots.min() <= SINGULAR * pivots.max():
                return Outcome.BODY_HELD_BY_NOTHING
    if still.converged:
        return Outcome.NOT_CONVERGED
    prescribed = bool(np.any(balance.table.start_kind != OFFSET))
    return Outcome.NO_STATIC_EQUILIBRIUM if prescribed else Outcome.STATIC_NOT_FOUND
