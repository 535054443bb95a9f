"""Contact parameters that loops show directly: the stiffness from slopes while every contact sticks, and friction coefficients
from plateaus of T/N, where the ratio stays constant while the contact slides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.model.dampers.between_platforms import BetweenPlatforms, PlanePoint
from stickslip.support.checks import Array, InputError, fault, positive

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


WORST_CONDITION = 100.0
"""Condition number from which the inversion is refused."""


@dataclass(frozen=True)
class StuckStiffness:
    """kt, kn of every line of contact [N/m]; condition: by what the relative error of the slopes is multiplied at worst, over
    by what it is at best."""

    kt: float
    kn: float
    condition: float


def compliance_parts(rig: BetweenPlatforms) -> tuple[Array, Array]:
    """(2, 2) matrices A, B of C = A/kt + B/kn for a damper on two lines at the left and one at the right."""
    first, second, right = _three(rig.points)
    feet = np.subtract(second.arm, first.arm)
    across = np.subtract(right.arm, 0.5 * np.add(first.arm, second.arm))
    a = np.array([-across[1], across[0]])
    left_t, left_n = np.outer(first.tangent, first.tangent), np.outer(first.normal, first.normal)
    right_t, right_n = np.outer(right.tangent, right.tangent), np.outer(right.normal, right.normal)
    return 0.5 * left_t + right_t, 0.5 * left_n + right_n + 2.0 * np.outer(a, a) / float(feet @ feet)


def _three(points: tuple[PlanePoint, ...]) -> tuple[PlanePoint, PlanePoint, PlanePoint]:
    left, right = [p for p in points if p.side == "left"], [p for p in points if p.side == "right"]
    if len(left) != 2 or len(right) != 1:
        found = ", ".join(p.name for p in points)
        raise fault("Stuck slopes", "must come from a damper on two lines at the left and one at the right", found)
    feet = np.subtract(left[1].arm, left[0].arm)
    if abs(float(feet @ np.array(left[0].normal))) > 1e-9:
        raise fault("The left lines of contact", "must lie on one platform", (left[0].arm, left[1].arm))
    return left[0], left[1], right[0]


def stuck_slopes(rig: BetweenPlatforms, kt: float, kn: float) -> tuple[float, float]:
    """kH and kV [N/m]: H per horizontal and V per vertical relative motion of the platforms while every contact sticks."""
    A, B = compliance_parts(rig)
    K = np.linalg.inv(A / positive("kt", kt) + B / positive("kn", kn))
    return float(K[0, 0]), float(K[1, 1])


def stiffness_from_slopes(rig: BetweenPlatforms, kH: float, kV: float) -> StuckStiffness:
    """kt and kn, equal at all lines, from the slopes kH (platforms out of phase) and kV (in phase) [N/m], without iteration.

    ρ = (B_VV − φ B_HH)/(φ A_HH − A_VV), φ = kH/kV. Refused near the angle at which A_HH B_VV = B_HH A_VV (57° for the
    laboratory damper, 45° when its rotation is blocked), and where no positive stiffness gives these slopes.
    """
    A, B = compliance_parts(rig)
    phi = positive("kH", kH) / positive("kV", kV)
    singular = abs(A[0, 0] * B[1, 1] - B[0, 0] * A[1, 1]) / (A[0, 0] * B[1, 1] + B[0, 0] * A[1, 1])
    remedy = "Identify from whole loops instead, which also see the rotation."
    if singular < 1.0 / WORST_CONDITION:
        raise InputError(
            f"The slopes do not separate kt from kn: this geometry is within {singular:.1%} of a singular one. {remedy}"
        )
    above, below = B[1, 1] - phi * B[0, 0], phi * A[0, 0] - A[1, 1]
    if above * below <= 0.0:
        low, high = sorted((A[1, 1] / A[0, 0], B[1, 1] / B[0, 0]))
        rule = f"must lie between {low:.4g} and {high:.4g} for this geometry"
        raise fault("kH/kV", rule, float(f"{phi:.5g}"), f"A slope is not one of all contacts stuck. {remedy}")
    rho = above / below
    C = A + B / rho
    kt = kH * float(np.linalg.det(C)) / C[1, 1]
    kn = rho * kt
    K = np.linalg.inv(A / kt + B / kn)
    slopes = np.diag(K)
    by_kt, by_kn = np.diag(K @ (A / kt) @ K) / slopes, np.diag(K @ (B / kn) @ K) / slopes
    # of d(ln kH, ln kV)/d(ln kt, ln kn)
    condition = float(np.linalg.cond(np.stack([by_kt, by_kn], axis=1)))
    if condition > WORST_CONDITION:
        raise InputError(f"The slopes do not separate kt from kn here: condition number {condition:.3g}. {remedy}")
    return StuckStiffness(float(kt), float(kn), condition)


@dataclass(frozen=True)
class StuckStretch:
    """A straight stretch of a loop: its slope [N/m], standard error, first and last sample (may wrap), share of the range."""

    slope: float
    error: float
    first: int
    last: int
    share: float


def stuck_stretch(displacement: ArrayLike, force: ArrayLike, tolerance: float = 0.01, shortest: float = 0.05) -> StuckStretch:
    """The all-stuck stretch of one mean cycle (n,): after each reversal of the motion the longest one that stays straight.

    A stretch ends where the force leaves the line through it by more than `tolerance` of its range over the loop. Both
    reversals are tried and the longer stretch is taken; below `shortest` of the displacement's range it is refused. A loop
    in gross slip from the reversal on has none; contacts that slip early make the slope too small.
    """
    u, f = np.asarray(displacement, dtype=float), np.asarray(force, dtype=float)
    if u.ndim != 1 or u.shape != f.shape or u.size < 40:
        raise fault("Displacement and force of a loop", "must be one cycle of at least 40 samples each", (u.shape, f.shape))
    found = [_after(u, f, start, tolerance) for start in (int(u.argmax()), int(u.argmin()))]
    best = max(found, key=lambda stretch: stretch.share)
    if best.share < shortest or best.slope <= 0.0:
        rule = f"must have a straight rising stretch of at least {shortest:.0%} of the motion after a reversal"
        raise fault("The loop", rule, f"{best.share:.1%}", "Take larger pull or smaller motion, or fit whole loops.")
    return best


def _after(u: Array, f: Array, start: int, tolerance: float) -> StuckStretch:
    order = (start + np.arange(u.size // 2)) % u.size
    x, y, allowed = u[order] - u[start], f[order], tolerance * float(np.ptp(f))
    fewest, last, line = max(6, u.size // 50), 0, (0.0, 0.0)
    for end in range(fewest, x.size):
        slope, offset = np.polyfit(x[:end], y[:end], 1)
        if np.max(np.abs(y[:end] - slope * x[:end] - offset)) > allowed:
            break
        last, line = end, (float(slope), float(offset))
    if last == 0:
        return StuckStretch(0.0, np.inf, start, start, 0.0)
    left = y[:last] - line[0] * x[:last] - line[1]
    error = float(np.sqrt(np.sum(left**2) / max(last - 2, 1) / np.sum((x[:last] - x[:last].mean()) ** 2)))
    share = float(np.ptp(x[:last]) / np.ptp(u))
    return StuckStretch(line[0], error, start, int(order[last - 1]), share)
