"""A curve over ω followed both ways from a point on it, until it leaves a band or closes on itself.

Branches and isolas begin inside the band, where a sweep, which begins at an end of it, does not meet them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, Tangent, backwards, between, solve_at
from stickslip.solve.continuation.newton import correct
from stickslip.solve.continuation.steps import StepControl, Steps

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
    balance: HarmonicBalance,
    evaluation: Evaluation,
    along: Tangent,
    band: tuple[float, float],
    control: StepControl = CONTROL,
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
