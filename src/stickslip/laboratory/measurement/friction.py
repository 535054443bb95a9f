"""Friction coefficients from plateaus of T/N, where the ratio stays constant while the contact slides.

A ratio stands still as well while the damper rolls on a contact that does not slide: a plateau of exact forces is a lower bound
of mu, and a start for a fit of whole loops. Zeros of the cells that are off lift it, since the higher of both senses counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.support.checks import Array, fault

Marks = NDArray[np.bool_]

FLAT = 0.04
"""Share of the largest ratio within which a plateau stays."""

ALONE = 0.04
"""A foot touches alone where the load on the other is less than this share of the whole."""


@dataclass(frozen=True)
class Plateau:
    """A plateau of |T/N|: its level, standard deviation over the plateau, its share of the cycle, and the standard deviation of
    the level by errors of the rig (NaN where they were not drawn, or where most draws have no plateau)."""

    level: float
    scatter: float
    share: float
    error: float = np.nan


def plateau(ratio: ArrayLike, where: ArrayLike | None = None, shortest: float = 0.04) -> Plateau:
    """The highest level of |T/N| (n,) that holds for at least `shortest` of the cycle among the samples `where` (all).

    A ratio that touches its largest value only in passing has no plateau, and is refused: that contact never slides.
    """
    values = np.abs(np.asarray(ratio, dtype=float))
    allowed = np.isfinite(values) if where is None else np.isfinite(values) & np.asarray(where, dtype=bool)
    if np.count_nonzero(allowed) < shortest * values.size:
        raise fault("The stage of a plateau", f"must last {shortest:.0%} of the cycle", f"{np.mean(allowed):.1%}")
    chosen = values[allowed]
    bins = np.sort(chosen)
    width = FLAT * bins[-1]
    counts = np.searchsorted(bins, bins + width, side="right") - np.arange(bins.size)
    long = counts >= shortest * values.size
    mostly = counts >= 0.5 * counts.max()
    candidates = np.flatnonzero(long & mostly)
    if not candidates.size:
        raise fault("T/N", "must stand still where the contact slides", "no plateau", "The contact may never slide.")
    first = int(candidates[-1])
    inside = bins[first : first + counts[first]]
    return Plateau(float(np.median(inside)), float(inside.std()), float(inside.size / values.size))


def one_foot_alone(lower: Array, upper: Array) -> tuple[Marks, Marks]:
    """Where only the lower and where only the upper foot touches, (n,) each, from their normal loads [N]."""
    whole = lower + upper
    pressed = whole > 0.0
    return np.asarray((upper < ALONE * whole) & pressed), np.asarray((lower < ALONE * whole) & pressed)


def friction_from_ratios(left_ratio: Array, right_ratio: Array, feet: tuple[Array, Array] | None) -> dict[str, Plateau]:
    """Plateaux of {"R", "L1", "L2", "L"}, as far as they exist: R and L (all lines of a side together, a load-weighted mean) from
    the whole cycle, L1 and L2 from the stages in which that foot touches alone (feet: their loads, None where unknown)."""
    stages: dict[str, tuple[Array, Marks | None]] = {"R": (right_ratio, None), "L": (left_ratio, None)}
    if feet is not None:
        stages |= {name: (left_ratio, alone) for name, alone in zip(("L1", "L2"), one_foot_alone(*feet), strict=True)}
    found = {}
    for name, (ratio, where) in stages.items():
        try:
            found[name] = plateau(ratio, where)
        except ValueError:
            continue
    return found
