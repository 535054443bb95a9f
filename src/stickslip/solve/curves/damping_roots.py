"""Extremes of the damping ratio along a nonlinear mode, and the points at which it has a given value, each solved exactly."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, solve_at
from stickslip.solve.curves.mode_refine import directed

ROUNDING = 1e-10
"""Difference in ζ, relative to the largest, that is rounding: contacts that stick have the damping of the stuck mode."""


@dataclass(frozen=True, eq=False)
class DampingCurve:
    """A traced mode with the extremes of its damping among its points: between neighbours ζ rises or falls.

    extremes: which points those are.
    """

    balance: ModeBalance
    points: tuple[CurvePoint, ...]
    extremes: frozenset[int]

    @classmethod
    def of(cls, balance: ModeBalance, points: Sequence[CurvePoint]) -> DampingCurve:
        """The curve of solved points in order, each with its tangent."""
        if len(points) > 1:  # the tangent of the last point is that of the step that passed the end
            points = [*points[:-1], directed(balance, points[-2], points[-1])]
        found, extremes = list(points[:1]), set[int]()
        for before, after in pairwise(points):
            if _rise(before) * _rise(after) < 0.0:
                extreme = _located(balance, before, after, _rise)
                if extreme is not None:
                    extremes.add(len(found))
                    found.append(extreme)
            found.append(after)
        return cls(balance, tuple(found), frozenset(extremes))

    @property
    def ratios(self) -> list[float]:
        """ζ of every point."""
        return [self.balance.damping_of(point.point) for point in self.points]

    @property
    def largest(self) -> int:
        """The point of the largest damping ratio."""
        return int(np.argmax(self.ratios))

    def slope(self, k: int) -> float:
        """dζ/d ln a at a point, zero at an extreme."""
        return 0.0 if k in self.extremes else slope(self.points[k])

    def roots(self, ratio: float) -> list[CurvePoint]:
        """The points at which the damping ratio has a value, in the order of the curve."""
        found = []
        rounding = ROUNDING * max(map(abs, self.ratios), default=0.0)
        for before, after in pairwise(self.points):
            misses = [self.balance.damping_of(point.point) - ratio for point in (before, after)]
            # A curve that leaves the value by rounding alone has not crossed it: the stuck part of one that just begins to slip.
            if misses[0] * misses[1] < 0.0 and min(map(abs, misses)) > rounding:
                root = _located(self.balance, before, after, lambda point: self.balance.damping_of(point.point) - ratio)
                found += [] if root is None else [root]
            elif abs(misses[1]) <= rounding < abs(misses[0]):
                found.append(after)
        return found


def is_stable(point: CurvePoint) -> bool:
    """Whether ζ rises with the amplitude, on a part of the curve that has not turned back: beyond a fold another motion of
    the same amplitude is the mode that vibration follows."""
    return point.tangent.parameter > 0.0 and slope(point) > 0.0


def slope(point: CurvePoint) -> float:
    """dζ/d ln a along the curve."""
    return float(point.tangent.forces[-1, 2] / point.tangent.parameter)


def _rise(point: CurvePoint) -> float:
    """dζ/ds along the curve."""
    return float(point.tangent.forces[-1, 2])


def _located(
    balance: ModeBalance, before: CurvePoint, after: CurvePoint, wanted: Callable[[CurvePoint], float]
) -> CurvePoint | None:
    """The point between two at which a function of solved points changes its sign, to rounding; None where none is solved."""
    ends = before.point.level, after.point.level
    solved = {ends[0]: before, ends[1]: after}

    def at(level: float) -> float:
        if level not in solved:
            solved[level] = directed(balance, before, solve_at(balance, before, after, "level", level))
        return wanted(solved[level])

    try:
        return solved[float(scipy.optimize.brentq(at, *ends, xtol=1e-14, rtol=1e-14))] if ends[0] != ends[1] else None
    except LostCurveError:
        return None
