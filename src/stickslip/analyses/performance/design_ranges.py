"""Sensitivity of the best design: slopes to both sides of every variable, and the range in which it may vary alone."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from stickslip.analyses.performance.design_search import Designs, Record
from stickslip.support.checks import Array

NEAR = 0.05
"""A variable may go alone to where the worst-case peak is higher by this share."""

STEP = 0.02
"""The first step to each side, which gives the slope, and the width to which ends of ranges are found, as shares of the box."""

CLOSE = 0.005
"""An end of a range is found, too, where the worst-case peak is higher by `NEAR` to within this share."""

Walk = Generator[float, float, float]


@dataclass(frozen=True, eq=False)
class DesignRanges:
    """slopes (variables, 2): relative rise of the worst-case peak per relative change of a variable that becomes less, and more;
    NaN at the end of the box and beside a design that is not allowed. low, high (variables,): how far each variable may go alone.
    """

    slopes: Array
    low: Array
    high: Array


def design_ranges(designs: Designs, best: Record) -> DesignRanges:
    """Slopes at a design and the range of each variable in which the worst-case peak is at most `NEAR` higher, the others held.

    All sides are walked together: a step of each is one batch of designs.
    """
    unit, size = designs.unit(best.point), float(best.place[0])
    sides = [(k, sign) for k in range(unit.size) for sign in (-1.0, 1.0)]
    room = [float(np.clip(unit[k] if sign < 0.0 else 1.0 - unit[k], 0.0, 1.0)) for k, sign in sides]
    walks = [_walk(end) for end in room]
    slopes, reached = np.full(len(sides), np.nan), np.zeros(len(sides))
    asked = {j: next(walk) for j, walk in enumerate(walks) if room[j] > 1e-9}
    first = dict(asked)
    while asked:
        found = designs.solved_where_possible([_moved(designs, best, *sides[j], way) for j, way in asked.items()])
        onward = {}
        for (j, way), record in zip(asked.items(), found, strict=True):
            rise = float(record.place[0]) / size - 1.0 if record is not None and record.allowed else np.inf
            k, box = sides[j][0], designs.high - designs.low
            if way == first[j] and np.isfinite(rise):
                slopes[j] = rise / (way * box[k]) * abs(best.point[k])
            try:
                onward[j] = walks[j].send(rise)
            except StopIteration as ended:
                reached[j] = ended.value
        asked = onward
    ends = [float(_moved(designs, best, *side, way)[side[0]]) for side, way in zip(sides, reached.tolist(), strict=True)]
    return DesignRanges(slopes.reshape(-1, 2), np.array(ends[::2]), np.array(ends[1::2]))


def _moved(designs: Designs, best: Record, variable: int, sign: float, way: float) -> Array:
    """A design with one variable moved by a share of the box, and within it."""
    low, high = designs.low[variable], designs.high[variable]
    point = best.point.copy()
    point[variable] = np.clip(point[variable] + sign * way * (high - low), low, high)
    return point


def _walk(end: float) -> Walk:
    """How far one may go, at most to `end`: yields ways, is sent the rise of the peak there (infinite where it is refused).

    Steps outwards as the rise predicts, at most threefold, then between the last way within `NEAR` and the first beyond.
    """
    inside, low, way = 0.0, 0.0, min(STEP, end)
    while (rise := (yield way)) <= NEAR:
        if way >= end:
            return end
        inside, low = way, rise
        predicted = 1.1 * NEAR / rise * way if rise > 0.0 else np.inf
        way = min(max(1.5 * way, min(3.0 * way, predicted)), end)
    outside, high = way, rise
    while outside - inside > STEP and min(abs(low - NEAR), abs(high - NEAR)) > CLOSE:
        # By a straight line between small rises, in the middle otherwise.
        share = float(np.clip((NEAR - low) / (high - low), 0.2, 0.8)) if high < 4.0 * NEAR else 0.5
        way = inside + share * (outside - inside)
        rise = yield way
        if rise <= NEAR:
            inside, low = way, rise
        else:
            outside, high = way, rise
    return inside + (NEAR - low) / (high - low) * (outside - inside)
