"""A sweep: the curve from one end of a band to the other at one force level, whatever it takes to begin it and to arrive.

A curve over ω followed both ways from a point on it, until it leaves a band or closes on itself.

Branches and isolas begin inside the band, where a sweep, which begins at an end of it, does not meet them.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace

import numpy as np

from stickslip.model.contact.protocol import OFFSET
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.continuation.continuation import FOLDS, TURNED_BACK, first_point, solve_cold, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, Tangent, backwards, between, solve_at
from stickslip.solve.continuation.interpolation import with_own_tangent
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.solve.continuation.steps import StepControl, Steps
from stickslip.support.outcome import Outcome

RUN_UPS = (1.0, 0.8, 0.6, 0.4, 0.2)
"""Where to start, as a share of the start of the band: at it, or further out where Newton fails or the curve turns back."""

CAREFUL_POINTS = 2
"""Most points of a curve that is traced again with reversible steps, as a multiple of those of the first attempt."""

PASSED_BY = "The curve has no point inside the band."

SINGULAR = 1e-13
"""Ratio of the smallest to the largest pivot below which a Newton matrix counts as singular."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """The solved points in order, from the first inside the band on, and why the curve ended before the end of the band, or None.

    A curve that turns back may leave the band through its start and return: the points outside stand between two at the start.
    from_the_end: why it was followed from the end of the band and not from its start, or None.
    """

    points: list[CurvePoint]
    lost: str | None
    from_the_end: str | None = None


class SweepStopped(KeyboardInterrupt):
    """Ctrl-C in a sweep, with the points that are solved."""

    @property
    def points(self) -> tuple[CurvePoint, ...]:
        return self.args[0]  # type: ignore[no-any-return]


def sweep(
    balance: HarmonicBalance,
    start: float,
    end: float,
    level: float,
    progress: Callable[[float], None] = lambda fraction: None,
    control: StepControl | None = None,
    begin: Point | None = None,
) -> Sweep | Outcome:
    """The curve from start to end in rad/s: the one that arrives, else the longest; an outcome where no point could be solved.

    begin: a solved point at the start, when one is known. A curve that is lost on its way is also followed from the end.
    """
    found = from_start(balance, start, end, level, progress, control, begin)
    if begin is not None or isinstance(found, Outcome) or found.lost is None or start == end:
        return found
    back = from_start(balance, end, start, level, control=control)
    if isinstance(back, Outcome) or back.lost is not None:
        return found
    return Sweep(backwards(back.points), None, found.lost)


def swept_curve(
    balance: HarmonicBalance, level: float, band: tuple[float, float], progress: Callable[[float], None] = lambda fraction: None
) -> list[CurvePoint]:
    """The points from one end of a band in rad/s to the other; raises `LostCurveError` where the curve does not arrive."""
    found = sweep(balance, *band, level, progress)
    if isinstance(found, Outcome):
        raise LostCurveError("No point could be solved at the start of the band.")
    if found.lost is not None:
        raise LostCurveError(found.lost)
    return found.points


def from_start(
    balance: HarmonicBalance,
    start: float,
    end: float,
    level: float,
    progress: Callable[[float], None] = lambda fraction: None,
    control: StepControl | None = None,
    begin: Point | None = None,
) -> Sweep | Outcome:
    """As `sweep`, from the start alone. A curve that is lost has often jumped to another branch: it is traced again with steps
    that do not, except where it folds for ever, as they follow every fold."""
    plain = control or StepControl()
    found = _begun(balance, start, end, level, progress, plain, begin)
    if isinstance(found, Outcome) or found.lost in (None, FOLDS):
        return found
    careful = replace(plain, reversible=True, points=CAREFUL_POINTS * plain.points)
    again = _begun(balance, start, end, level, progress, careful, begin)
    return found if isinstance(again, Outcome) or again.lost is not None else again


def _begun(
    balance: HarmonicBalance,
    start: float,
    end: float,
    level: float,
    progress: Callable[[float], None],
    control: StepControl,
    begin: Point | None,
) -> Sweep | Outcome:
    """The curve that arrives, begun at the start or further out, else the longest."""
    sweeps: list[Sweep] = []
    failed: Outcome | None = None
    for run_up in RUN_UPS:
        if begin is not None and run_up == 1.0:
            first = correct(balance, begin, fixed("omega", start))
        else:
            first = first_point(balance, start * run_up if end >= start else start / run_up, level)
        if not first.converged:
            failed = failed or failure(balance, first)
            continue
        sweeps.append(_traced(balance, first, start, end, lambda done: progress(min(done, 1.0)), control))
        if sweeps[-1].lost not in (TURNED_BACK, PASSED_BY):
            break
    if not sweeps:
        return failed or Outcome.NOT_CONVERGED
    arrived = [found for found in sweeps if found.lost is None]
    return arrived[0] if arrived else max(sweeps, key=lambda found: len(found.points))


def _traced(
    balance: HarmonicBalance, first: Correction, start: float, end: float, progress: Callable[[float], None], control: StepControl
) -> Sweep:
    """The curve from a first point, at the start of the band or outside before it, to the end of the band."""
    points: list[CurvePoint] = []
    if first.evaluation.point.omega == start == end:
        return Sweep([next(iter(trace(balance, first, "omega", 1.01 * start)))], None)
    before: CurvePoint | None = None
    try:
        for point in trace(balance, first, "omega", end, control):
            omega = point.point.omega
            if before is not None and (omega - start) * (before.point.omega - start) < 0.0:
                with nullcontext() if not points else suppress(LostCurveError):
                    edge, point = _divided(balance, before, point, start)
                    points.append(edge)
            if points or omega == start:
                points.append(point)
                progress(abs(omega - start) / max(abs(end - start), np.finfo(float).tiny))
            before = point
    except KeyboardInterrupt as stop:
        raise SweepStopped(tuple(points)) from stop
    except LostCurveError as reason:
        passed_by = not points and str(reason) == TURNED_BACK
        return Sweep(points, PASSED_BY if passed_by else str(reason))
    return Sweep(points, None)


def _divided(balance: HarmonicBalance, before: CurvePoint, point: CurvePoint, omega: float) -> tuple[CurvePoint, CurvePoint]:
    """A step as two: the point at a frequency that it crosses, solved exactly, and the point behind it."""
    edge = replace(solve_at(balance, before, point, "omega", omega), metric=before.metric)
    lengths = before.chord(edge, "omega"), edge.chord(point, "omega")
    share = lengths[0] / sum(lengths)
    edge = with_own_tangent(balance, edge, before.evaluation, point.evaluation)
    return replace(edge, length=share * point.length), replace(point, length=(1.0 - share) * point.length)


def points_at(balance: HarmonicBalance, points: Sequence[CurvePoint], wanted: Mapping[int, float]) -> dict[int, CurvePoint]:
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
    still = solve_cold(balance.holding(None), point.omega, 0.0)
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


CONTROL = StepControl(first=0.02, branching=True, points=3000)

SAME = 1e-4
"""Arc length within which a curve is back at the point where it began."""

NEAR_STEPS = 2.0
"""Steps from the point where a curve began within which it is looked for there."""


@dataclass(frozen=True, eq=False)
class Followed:
    """Solved points in order; closed: whether the last one is the first one; lost: why an end was lost, or None; joins: whether
    an end lies on the curve from which this one was followed."""

    points: list[CurvePoint]
    closed: bool
    lost: str | None
    joins: bool = False

    @property
    def ending(self) -> str:
        """How the curve ended, as the end of a sentence."""
        if self.lost is not None:
            return f"of which an end was lost: {self.lost}"
        if self.closed:
            return "which closes on itself."
        return "which joins the curve again." if self.joins else "which leaves the band."


def followed_both_ways(
    balance: HarmonicBalance, evaluation: Evaluation, along: Tangent, band: tuple[float, float], control: StepControl = CONTROL
) -> Followed:
    """The curve through a solved point, first the way that goes with `along`; band: ω in rad/s, low and high."""
    onwards = one_way(balance, evaluation, along, band, control)
    if onwards.closed:
        return onwards
    return joined(one_way(balance, evaluation, along.turned(), band, control), onwards)


def joined(back: Followed, onwards: Followed) -> Followed:
    """Two ways from one point as one curve."""
    lost = " ".join(filter(None, (back.lost, onwards.lost))) or None
    return Followed([*backwards(back.points), *onwards.points[1:]], back.closed, lost, back.joins or onwards.joins)


def one_way(
    balance: HarmonicBalance, evaluation: Evaluation, along: Tangent, band: tuple[float, float], control: StepControl = CONTROL
) -> Followed:
    """The curve from a solved point on, in the direction that goes with `along`."""
    steps = Steps(balance, "omega", (band[1] - band[0]) / 10.0, control)
    points = [steps.begun_along(evaluation, along)]
    before: CurvePoint | None = None
    for _ in range(control.points):
        current = points[-1]
        try:
            following = steps.advance(current, before)
            end = min(max(following.point.omega, band[0]), band[1])
            if end != following.point.omega:
                inside = band[0] < current.point.omega < band[1]
                last = [solve_at(balance, current, following, "omega", end)] if inside else []
                return Followed([*points, *last], False, None)
        except LostCurveError as reason:
            return Followed(points, False, str(reason))
        if len(points) > 1 and comes_back(balance, points[0], current, following):
            closing = replace(points[0], length=current.chord(points[0], "omega"))
            return Followed([*points, closing], True, None)
        before = current
        points.append(following)
    return Followed(points, False, f"It was not finished within {control.points} points.")


def comes_back(balance: HarmonicBalance, first: CurvePoint, current: CurvePoint, following: CurvePoint) -> bool:
    """Whether the step from one point to the next passes the first point of the curve, in the direction in which it began."""
    plane = first.across("omega")
    plane = replace(plane, target=plane.gap(first.evaluation))
    before, after = plane.gap(current.evaluation), plane.gap(following.evaluation)
    change = following.point.omega - current.point.omega
    step = first.metric.length(following.evaluation.w - current.evaluation.w, change)
    if not before < 0.0 <= after or first.chord(current, "omega") > NEAR_STEPS * step:
        return False
    share = -before / (after - before)
    start = Point(between(current, following, share), current.point.omega + share * change, first.point.level)
    found = correct(balance, start, plane, iterations=15, halvings=6)
    if not found.converged:
        return False
    change = found.evaluation.point.omega - first.point.omega
    return first.metric.length(found.evaluation.w - first.evaluation.w, change) < SAME
