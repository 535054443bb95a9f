"""Stability of the motions that a curve is read for: its highest peaks and its end, judged with every forced response.

Every other point is judged where `with_stability`, of studies [stability], asks for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.stability import StabilityOf, flags_of
from stickslip.analyses.truncation import finer_balance, highest_points, same_motion
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem.contraction import contracts
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.continuation.more_harmonics import resolved
from stickslip.solve.continuation.truncation import enough_beyond
from stickslip.solve.curves.curve import Curve
from stickslip.solve.stability.judge import MOST_COORDINATES, Verdict
from stickslip.solve.stability.multipliers import Stability
from stickslip.support.checks import InputError, counted

MOST_ROWS = 60
"""Contact rows up to which peaks are judged where friction and damping do not decide: the time goes with their square."""

VARIABLES = {
    "highest_stability": (("case", "output"), "stability at the highest peak, or the largest point"),
    "end_stability": (("case",), "stability at the last point of the curve"),
}


class PeakStability(NamedTuple):
    """What was found of one curve. points, verdicts: by output, of its highest point; end: of the last point of the curve, None
    where it was not judged or the curve closes on itself."""

    points: Mapping[int, CurvePoint]
    verdicts: Mapping[int, Verdict]
    end: Verdict | None

    def flags(self, outputs: int) -> dict[str, NDArray[np.int8]]:
        """`highest_stability` (outputs,) and `end_stability` () of the curve, flags of `Stability`."""
        highest = [self.verdicts[k].stability if k in self.verdicts else Stability.UNKNOWN for k in range(outputs)]
        end = Stability.UNKNOWN if self.end is None else self.end.stability
        return {"highest_stability": np.array(highest, dtype=np.int8), "end_stability": np.array(end, dtype=np.int8)}


def judged(balance: HarmonicBalance, curve: Curve, measure: Measure) -> PeakStability:
    """The stability of the highest point of each output and of the last point of a curve, unless that closes on itself.

    Not judged where it would take more than about a tenth of the curve's time: of many contacts, and of tuned disks with more
    than a few coordinates, whose sectors are disturbed each by itself; and where harmonics see different structures.
    """
    highest = highest_points(balance, curve, measure)
    if not curve.points or not _few(balance):
        return PeakStability(highest, {}, None)
    judge = StabilityOf(balance, max(point.point.omega for point in curve.points), numbers=False)
    known: list[tuple[CurvePoint, Verdict]] = []

    def verdict(point: CurvePoint) -> Verdict:
        found = next((verdict for other, verdict in known if same_motion(point, other)), None)
        if found is None:
            found = _confirmed(balance, judge.verdict(point.evaluation), point)
            known.append((point, found))
        return found

    begin, end = curve.points[0], curve.points[-1]
    closed = begin is not end and begin.point.omega == end.point.omega
    try:
        verdicts = {k: verdict(point) for k, point in highest.items()}
        return PeakStability(highest, verdicts, verdict(end) if curve.holds(end.point.omega) and not closed else None)
    except InputError:
        return PeakStability(highest, {}, None)


def _few(balance: HarmonicBalance) -> bool:
    """Whether judging a point takes little, beside the curve."""
    problem = balance.problem
    if contracts(problem):
        return True
    if isinstance(problem, TunedDisk):
        return problem.sectors * problem.systems.coordinates <= MOST_COORDINATES
    return balance.rows <= MOST_ROWS


def _confirmed(balance: HarmonicBalance, found: Verdict, point: CurvePoint) -> Verdict:
    """A verdict; of an unstable solution that was disturbed itself, not the motion beside it, only if it is unstable with all
    harmonics that an estimate of their error takes: of few, a contact may slip or land where the motion itself does not."""
    if found.stability != Stability.UNSTABLE or np.isfinite(found.distance) or isinstance(balance.problem, TunedDisk):
        return found
    finer = finer_balance(balance, enough_beyond(balance.highest))
    solution = resolved(finer, point.evaluation)
    if not solution.converged:
        return found
    again = StabilityOf(finer, point.point.omega, numbers=False).verdict(solution.evaluation)
    if again.stability == Stability.UNSTABLE:
        return found
    sizes = abs(found.multiplier), abs(again.multiplier)
    words = (
        f"its largest multiplier has a size of {sizes[0]:.4g} with {balance.highest} harmonics, and of {sizes[1]:.4g} with more"
    )
    return replace(found, stability=Stability.UNDECIDED, reason=words)


def flags(curves: Sequence[Mapping[str, Any]], outputs: int) -> dict[str, Any]:
    """The variables of the flags of curves; curves kept by older versions have none."""
    found = {}
    for name, (axes, words) in VARIABLES.items():
        empty = np.zeros(outputs if "output" in axes else (), dtype=np.int8)
        found[name] = axes, np.array([curve.get(name, empty) for curve in curves]), flags_of(words, Stability)
    return found


def stability_warning(balance: HarmonicBalance, curve: Curve, judged: PeakStability) -> str:
    """What to say where a highest peak or the end of a curve is unstable, or its stability undecided; empty where neither is."""
    names, end = balance.problem.output_names, curve.points[-1].point.omega if curve.points else 0.0
    hertz = {f"{names[k]} ({balance.hertz(judged.points[k].point.omega):.6g} Hz)": each for k, each in judged.verdicts.items()}
    unstable = {name: each for name, each in hertz.items() if each.stability == Stability.UNSTABLE}
    places = [f"the highest {'points' if len(unstable) > 1 else 'point'} of {', '.join(unstable)}"] if unstable else []
    worst = max(unstable.values(), key=lambda each: abs(each.multiplier), default=None)
    if judged.end is not None and judged.end.stability == Stability.UNSTABLE:
        places.append(f"the end of the curve ({balance.hertz(end):.6g} Hz)")
        worst = worst or judged.end
    if worst is not None:
        leaves = f" and leaves it within {counted(worst.leaves, 'period')}" if worst.leaves else ""
        return (
            f"Unstable motion at {' and at '.join(places)}: the vibration grows into another one. A small disturbance grows by a "
            f"factor of {abs(worst.multiplier):.4g} per period{leaves}. Compute the stability of all points ([stability], "
            "`with_stability()`), and use `time_response` to find that motion."
        )
    undecided = {name: each for name, each in hertz.items() if each.stability == Stability.UNDECIDED}
    if not undecided:
        return ""
    each = next(iter(undecided.values()))
    return (
        f"Whether the motion at the highest point of {', '.join(undecided)} is stable is undecided: {each.reason or _near(each)}."
    )


def _near(verdict: Verdict) -> str:
    return f"its largest multiplier has a size of {abs(verdict.multiplier):.6g}, with an error of {verdict.error:.2g}"
