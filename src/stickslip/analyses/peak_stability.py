"""Stability of the motions that a curve is read for: its highest peaks and its end, judged with every forced response.

Every other point is judged where `with_stability`, of studies [stability], asks for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.stability import KEPT, flags_of
from stickslip.analyses.truncation import SAME_PEAK, finer_balance, highest_points
from stickslip.model.disks.tuned import TunedDisk
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.continuation.more_harmonics import resolved
from stickslip.solve.continuation.truncation import enough_beyond
from stickslip.solve.curves.curve import Curve
from stickslip.solve.stability.multipliers import MOST_STEPS, TIMES_ERROR, Multipliers, PeriodMap, Stability
from stickslip.support.checks import InputError

MOST_MODES = 60
"""Modes that move by themselves, and contact rows, up to which peaks are judged: the time goes with the square of both."""

STEPS, MOST_OF_SHORT = 16, 64
"""Steps of a period to begin with, and the most of a curve of fewer than `LONG` points: `with_stability` takes more where the
largest multiplier is near to 1."""

LONG = 150

VARIABLES = {
    "highest_stability": (("case", "output"), "stability at the highest peak, or the largest point"),
    "end_stability": (("case",), "stability at the last point of the curve"),
}


def judged(balance: HarmonicBalance, curve: Curve, measure: Measure) -> dict[str, NDArray[np.int8]]:
    """`highest_stability` (outputs,) and `end_stability` () of a curve, flags of `Stability`.

    Unknown where judging would take more than about a tenth of the curve's time: of tuned disks, whose sectors are disturbed each
    by itself, and many modes or contacts; and where harmonics see different structures. Of a single frequency, as of long curves,
    it takes 5 to 8 % of the time.
    """
    highest = highest_points(balance, curve, measure)
    flags: dict[str, NDArray[np.int8]] = {
        "highest_stability": np.zeros(len(balance.problem.outputs), dtype=np.int8),
        "end_stability": np.zeros((), dtype=np.int8),
    }
    if not curve.points or balance.rows > MOST_MODES or isinstance(balance.problem, TunedDisk):
        return flags
    fastest = max(point.point.omega for point in curve.points)
    try:
        period = PeriodMap(balance, KEPT * balance.highest * fastest)
    except InputError:
        return flags
    if period.modes.real.size > 2 * MOST_MODES:
        return flags
    known: dict[float, Stability] = {}

    def verdict(point: CurvePoint) -> Stability:
        omega = point.point.omega
        near = next((other for other in known if abs(other - omega) <= SAME_PEAK * omega), omega)
        if near not in known:
            most = MOST_STEPS if len(curve.points) >= LONG else MOST_OF_SHORT
            found = clear_verdict(period.multipliers(point.evaluation, STEPS, most))
            known[near] = _confirmed(balance, point, most) if found == Stability.UNSTABLE else found
        return known[near]

    for output, point in highest.items():
        flags["highest_stability"][output] = verdict(point)
    flags["end_stability"][...] = verdict(curve.points[-1])
    return flags


def _confirmed(balance: HarmonicBalance, point: CurvePoint, most: int) -> Stability:
    """Unstable where the motion with all harmonics that an estimate of their error takes is unstable too, or is not found; else
    undecided: of few harmonics a contact may slip or land at instants at which the motion itself has it do nothing."""
    finer = finer_balance(balance, enough_beyond(balance.highest))
    solution = resolved(finer, point.evaluation)
    if not solution.converged:
        return Stability.UNSTABLE
    period = PeriodMap(finer, KEPT * finer.highest * point.point.omega)
    found = clear_verdict(period.multipliers(solution.evaluation, STEPS, most))
    return found if found == Stability.UNSTABLE else Stability.UNDECIDED


def clear_verdict(multipliers: Multipliers) -> Stability:
    """The verdict; undecided where the error of the largest multiplier, few steps leaving a large one, may turn it."""
    unclear = abs(abs(multipliers.leading) - 1.0) <= TIMES_ERROR * multipliers.error
    return Stability.UNDECIDED if unclear else multipliers.verdict


def flags(curves: Sequence[Mapping[str, Any]], outputs: int) -> dict[str, Any]:
    """The variables of the flags of curves; curves kept by older versions have none."""
    found = {}
    for name, (axes, words) in VARIABLES.items():
        empty = np.zeros(outputs if "output" in axes else (), dtype=np.int8)
        found[name] = axes, np.array([curve.get(name, empty) for curve in curves]), flags_of(words, Stability)
    return found


def instability_warning(balance: HarmonicBalance, curve: Curve, measure: Measure, flags: Mapping[str, NDArray[np.int8]]) -> str:
    """What to say where a highest peak or the end of a curve is unstable; empty where none is known to be."""
    highest, names = highest_points(balance, curve, measure), balance.problem.output_names
    unstable = [k for k, flag in enumerate(flags["highest_stability"]) if flag == Stability.UNSTABLE]
    peaks = [f"{names[k]} ({balance.hertz(highest[k].point.omega):.6g} Hz)" for k in unstable]
    places = [f"the highest {'points' if len(peaks) > 1 else 'point'} of {', '.join(peaks)}"] if peaks else []
    if flags["end_stability"] == Stability.UNSTABLE:
        places.append(f"the end of the curve ({balance.hertz(curve.points[-1].point.omega):.6g} Hz)")
    if not places:
        return ""
    return (
        f"Unstable motion at {' and at '.join(places)}: the vibration grows into another one. Compute the stability of all "
        "points ([stability], `with_stability()`), and use `time_response` to find that motion."
    )
