"""Stability of the points of a forced response, and where and how it changes along the curves.

Stability of the motions that a curve is read for: its highest peaks and its end, judged with every forced response.

Every other point is judged where `with_stability`, of studies [stability], asks for it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from enum import IntEnum
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.solved_points import SolvedPoints
from stickslip.analyses.truncation import finer_balance, highest_points, same_motion
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.problem.contraction import contracts
from stickslip.results.schema import described, stacked
from stickslip.results.view import measure_in, nearest_point
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.fourier import complex_harmonics, real_harmonics
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.continuation.interpolation import Interpolation
from stickslip.solve.continuation.truncation import enough_beyond, resolved
from stickslip.solve.curves.curve import Curve
from stickslip.solve.stability.judge import MOST_COORDINATES, Judge, Verdict
from stickslip.solve.stability.multipliers import ROUNDING, TIMES_ERROR, Stability
from stickslip.support.checks import Array, InputError, counted, positive
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome

REAL = 1e-6
"""Imaginary part of a multiplier, relative to its size, below which it is real."""


class Instability(IntEnum):
    """How stability changes along a curve."""

    NONE = 0
    FOLD = 1
    BRANCH_POINT = 2
    PERIOD_DOUBLING = 3
    NEIMARK_SACKER = 4


LOCATED = 1e-6
"""Distance from the unit circle at which a change of stability is located."""

MOST_SOLVED = 30
"""Points solved to locate a change."""

AT_FOLD = 0.01
"""Distance from 1 of a multiplier that contradicts the Jacobian beside a fold, and is no sign of too few harmonics: the fold of
the motion and that of its multipliers differ by the error of the harmonics, however small."""


class AllSectors:
    """The solved points of a tuned disk with all its sectors, which a disturbance need not leave alike."""

    def __init__(self, sector: HarmonicBalance, disk: TunedDisk) -> None:
        self.disk = disk
        self.balance = HarmonicBalance(disk.full(reported=[1]), sector.harmonics, sector.tables.E.shape[0])

    def evaluation(self, sector: Evaluation) -> Evaluation:
        """The point of the full disk whose first sector moves as given: sector j is late by j EO/N periods."""
        one = sector.point
        forces = complex_harmonics(one.forces)
        late = -2j * np.pi * self.disk.engine_order / self.disk.sectors * np.arange(forces.shape[1])
        turned = [real_harmonics(forces * np.exp(j * late)) for j in range(self.disk.sectors)]
        return self.balance.evaluate(Point(np.concatenate(turned), one.omega, one.level))


class Change(NamedTuple):
    """Where the largest multiplier crosses the unit circle: frequency [Hz] and kind."""

    frequency: float
    kind: Instability


def with_stability(dataset: "xr.Dataset", problem: Problem, highest: float | None = None) -> "xr.Dataset":
    """A forced response with the stability of every converged point.

    `stability`, `multiplier` (the largest, real and imaginary part), `multiplier_error`, `multiplier_resolved`, `stuck_sliders`
    (case, point, ...);
    `peak_stability` (case, peak, output); `stability_change` and its frequency (case, change).

    highest: natural frequency in Hz up to which modes move by themselves. Unless it is given, those below eight times the highest
    harmonic; what the others change is found where the largest multiplier is nearest to the unit circle, and points that might
    change sides are solved with all. A tuned disk is disturbed in all its sectors.
    """
    solved = SolvedPoints(dataset, problem)
    converged = [(int(case), int(point)) for case, point in np.argwhere(dataset["outcome"].values == Outcome.CONVERGED)]
    fastest = 2.0 * np.pi * float(np.nanmax(dataset["frequency"].values, initial=0.0)) / solved.balance.periods
    with one_blas_thread():
        until = highest if highest in (None, np.inf) else 2.0 * np.pi * positive("highest", highest)
        judge = StabilityOf(solved.balance, fastest, until)
        found = {place: judge.verdict(solved.evaluation(*place)) for place in converged}
        error = 0.0
        if highest is None and judge.dropped and converged:
            # What the modes left out change of the multiplier nearest to the unit circle; points that might change sides are
            # judged anew with all modes.
            whole = StabilityOf(solved.balance, fastest, np.inf)
            nearest = min(found, key=lambda place: _distance(found[place]))
            again = whole.verdict(solved.evaluation(*nearest))
            error = float(abs(abs(again.multiplier) - abs(found[nearest].multiplier)))
            for place in [place for place, each in found.items() if _distance(each) <= TIMES_ERROR * error]:
                found[place] = whole.verdict(solved.evaluation(*place))
        values = _of_points(dataset, found, error)
        changes: list[list[Change]] = [[] for _ in range(dataset.sizes["case"])]
        if not dataset.attrs.get("listed_frequencies"):
            changes = [_changes(dataset, values, case, solved, judge.leading) for case in range(len(changes))]
    return dataset.assign(_variables(dataset, values, changes)).assign_attrs(
        stability_dropped_modes=judge.dropped, stability_mode_error=error
    )


class StabilityOf:
    """The judge of the solved points of a balance; of a tuned disk that of all its sectors, where friction and damping do not
    decide."""

    def __init__(self, balance: HarmonicBalance, fastest: float, highest: float | None = None, *, numbers: bool = True) -> None:
        problem = balance.problem
        self._sectors = None
        if isinstance(problem, TunedDisk) and (numbers or not contracts(problem)):
            self._sectors = AllSectors(balance, problem)
        one = balance if self._sectors is None else self._sectors.balance
        self._judge = Judge(one, fastest, highest, numbers=numbers)

    def verdict(self, evaluation: Evaluation) -> Verdict:
        """Whether a solved point is stable."""
        return self._judge.verdict(evaluation if self._sectors is None else self._sectors.evaluation(evaluation))

    def leading(self, evaluation: Evaluation) -> complex:
        """The largest multiplier of a point; NaN where it is not known."""
        return self.verdict(evaluation).multiplier

    @property
    def dropped(self) -> int:
        """Modes that follow at once."""
        return self._judge.dropped


def _distance(verdict: Verdict) -> float:
    """Distance of the largest multiplier from the unit circle; infinite where it is not known."""
    distance = abs(abs(verdict.multiplier) - 1.0)
    return distance if np.isfinite(distance) else np.inf


def _of_points(dataset: "xr.Dataset", verdicts: dict[tuple[int, int], Verdict], error: float) -> dict[str, Any]:
    """Arrays (case, point); error: of the modes left out."""
    shape = dataset["outcome"].shape
    found: dict[str, Any] = {
        "stability": np.zeros(shape, dtype=np.int8),
        "multiplier": np.full(shape, np.nan, dtype=complex),
        "multiplier_error": np.full(shape, np.nan),
        "multiplier_resolved": np.ones(shape, dtype=np.int8),
        "stuck_sliders": np.zeros(shape, dtype=np.int64),
        "motion_distance": np.full(shape, np.nan),
        "stability_reason": np.full(shape, "", dtype=object),
    }
    for place, each in verdicts.items():
        found["stability"][place], found["multiplier"][place] = each.stability, each.multiplier
        found["multiplier_error"][place] = max(each.error, error)
        found["multiplier_resolved"][place] = each.resolved or abs(each.multiplier - 1.0) <= AT_FOLD
        found["stuck_sliders"][place] = each.exact_ones
        found["motion_distance"][place], found["stability_reason"][place] = each.distance, each.reason
    return found


def _changes(
    dataset: "xr.Dataset", values: dict[str, Any], case: int, points: SolvedPoints, leading: Callable[[Evaluation], complex]
) -> list[Change]:
    """The changes along a curve, in the order of travel: between each stable and unstable point with none but undecided ones
    between them, in the step nearest to the unstable one that crosses the unit circle."""
    converged = np.flatnonzero(dataset["outcome"].values[case] == Outcome.CONVERGED)
    frequency, multiplier = dataset["frequency"].values[case, converged], values["multiplier"][case, converged]
    verdict = values["stability"][case, converged]
    for k in range(1, multiplier.size):  # one that is not known is taken from the point before
        multiplier[k] = multiplier[k] if np.isfinite(multiplier[k]) else multiplier[k - 1]
    decided = np.flatnonzero((verdict == Stability.STABLE) | (verdict == Stability.UNSTABLE))
    crossings = []
    for first, last in pairwise(decided):
        if verdict[first] != verdict[last]:
            steps = first + np.flatnonzero(np.diff(_excess(multiplier[first : last + 1]) > 0.0))
            crossings.append(steps[0] if verdict[first] == Stability.UNSTABLE else steps[-1])
    if not crossings:
        return []
    curve = Interpolation(points.balance, points.converged(case), LOCATED)
    found = []
    for k in map(int, crossings):
        place, outside = _located(curve, k, complex(multiplier[k]), complex(multiplier[k + 1]), leading)
        steps = np.diff(frequency[max(k - 1, 0) : k + 3])
        turns = bool(np.any(steps > 0.0) and np.any(steps < 0.0))  # the frequency, near the step from point k to the next
        found.append(Change(place, _kind(outside, turns)))
    return found


def _excess(multipliers: NDArray[np.complex128]) -> Array:
    """How far multipliers lie outside the unit circle, beyond what rounding makes of those of modes without damping."""
    return np.asarray(np.abs(multipliers) - 1.0 - ROUNDING)


def _located(
    curve: Interpolation, k: int, first: complex, last: complex, leading: Callable[[Evaluation], complex]
) -> tuple[float, complex]:
    """Frequency [Hz] between point k and the next where the size of the largest multiplier passes 1, and a multiplier beside it,
    outside the unit circle.

    By bisection and false position in turn, since the size may jump where a contact just touches. Where a point cannot be solved,
    the frequency is that of a straight line between the last two.
    """
    ends, multipliers, omegas = [0.0, 1.0], [first, last], list(curve.omegas[k : k + 2])
    for count in range(MOST_SOLVED):
        a, b = _excess(np.array(multipliers))
        if min(abs(a), abs(b)) <= LOCATED or ends[1] - ends[0] <= LOCATED:
            break
        share = 0.5 if count % 3 == 2 else min(max(a / (a - b), 0.05), 0.95)
        fraction = ends[0] + share * (ends[1] - ends[0])
        evaluation = curve.between(k, fraction)
        if evaluation is None:
            break
        found = leading(evaluation)
        if not np.isfinite(found):
            break
        side = 0 if (_excess(np.array(found)) > 0.0) == (a > 0.0) else 1
        ends[side], multipliers[side], omegas[side] = fraction, found, evaluation.point.omega
    a, b = _excess(np.array(multipliers))
    omega = omegas[0] + a / (a - b) * (omegas[1] - omegas[0])
    return curve.balance.hertz(float(omega)), multipliers[0] if a > 0.0 else multipliers[1]


def _kind(multiplier: complex, turns: bool) -> Instability:
    """Kind of the loss of stability by a multiplier just outside the unit circle."""
    if abs(multiplier.imag) > REAL * abs(multiplier):
        return Instability.NEIMARK_SACKER
    if multiplier.real < 0.0:
        return Instability.PERIOD_DOUBLING
    return Instability.FOLD if turns else Instability.BRANCH_POINT


def _variables(dataset: "xr.Dataset", values: dict[str, Any], changes: list[list[Change]]) -> dict[str, Any]:
    """The variables, with units and meanings."""
    multiplier = values["multiplier"]
    frequency = stacked([[change.frequency for change in found] for found in changes])
    kind = stacked([[change.kind for change in found] for found in changes], 0, np.int8)
    return {
        "stability": (("case", "point"), values["stability"], flags_of("stability of the periodic motion", Stability)),
        **described(
            "stability",
            {
                "multiplier": np.stack([multiplier.real, multiplier.imag], axis=-1),
                **{
                    name: values[name] for name in ("multiplier_error", "multiplier_resolved", "stuck_sliders", "motion_distance")
                },
            },
        ),
        "stability_reason": (
            ("case", "point"),
            values["stability_reason"].astype(str),
            {"long_name": "why the stability is undecided or not judged"},
        ),
        "peak_stability": (
            ("case", "peak", "output"),
            _of_peaks(dataset, values["stability"]),
            flags_of("stability at the peak", Stability),
        ),
        **described("stability", {"stability_change_frequency": frequency}),
        "stability_change": (("case", "change"), kind, flags_of("how the stability changes", Instability)),
    }


def flags_of(words: str, kinds: type[IntEnum]) -> dict[str, Any]:
    values, names = np.array([int(kind) for kind in kinds], dtype=np.int8), " ".join(kind.name.lower() for kind in kinds)
    return {"units": "1", "long_name": words, "flag_values": values, "flag_meanings": names}


def _of_peaks(dataset: "xr.Dataset", stability: Any) -> Any:
    """Stability of the point at every peak."""
    frequencies, sizes = dataset["peak_frequency"].values, dataset["peak_amplitude"].values
    found = np.zeros(frequencies.shape, dtype=np.int8)
    for case, peak, output in np.argwhere(np.isfinite(frequencies)):
        per = measure_in(dataset).per(float(dataset["force_level"].values[case]))
        place = (case, peak, output)
        found[place] = stability[case, nearest_point(dataset, int(case), int(output), frequencies[place], sizes[place] * per)]
    return found


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
    near = f"its largest multiplier has a size of {abs(each.multiplier):.6g}, with an error of {each.error:.2g}"
    return f"Whether the motion at the highest point of {', '.join(undecided)} is stable is undecided: {each.reason or near}."
