"""Curves of a forced response that its sweeps do not meet: branches, and isolas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.problem import Problem
from stickslip.model.problem.contraction import contracts
from stickslip.results.view import measure_in, periods_of
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.fourier import complex_harmonics, of_attribute
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.branch_points import BranchPoint, branch_points, determinant_jumps, starts
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.continuation.interpolation import Interpolation
from stickslip.solve.continuation.sweep import Followed, joined, one_way
from stickslip.solve.curves.curve import Curve, with_peaks
from stickslip.support.checks import Array, InputError, fault, first_of, positive, whole
from stickslip.support.late import pd, xr
from stickslip.support.outcome import Outcome

NEAR, JOINED, EXACT = 1e-2, 1e-4, 1e-6
"""Relative distance of two motions at one frequency below which they are one; where a branch goes over into the curve it came
from; beside a branch point."""

BESIDE = 0.5
"""Arc length on either side of a branch point over which a curve is compared with what leads away."""

AGAIN = 1e-3
"""Arc length between two branch points below which they are one, met twice."""

FINE = 1e-3
"""Tolerance with which points of a result become a curve again."""


@dataclass(frozen=True, eq=False)
class SolvedCurve:
    """A curve of a result as a continuation has it, over `periods` periods of the excitation; band: ends in rad/s of the balance;
    tolerance, measure: of peaks; longer: how many times as long as in the result the expansion is."""

    balance: HarmonicBalance
    points: list[CurvePoint]
    level: float
    band: tuple[float, float]
    tolerance: float
    measure: Measure
    longer: int

    @classmethod
    def of(cls, dataset: xr.Dataset, problem: Problem, case: int, longer: int, tolerance: float) -> SolvedCurve:
        """The curve of a case, its motions expanded over `longer` times the periods that those of the dataset are."""
        if dataset.attrs.get("listed_frequencies"):
            raise InputError("Branches and isolated curves must be asked for a response over a band, not at listed frequencies.")
        solved = SolvedPoints(dataset, problem)
        if not 0 <= whole("case", case) < dataset.sizes["case"]:
            raise fault("case", f"must be a whole number from 0 to {dataset.sizes['case'] - 1}", case)
        balance, points = solved.balance, solved.converged(int(case))
        if whole("periods", longer) != 1:
            periods = periods_of(dataset) * longer
            harmonics, samples = of_attribute(dataset.attrs["harmonics"]), int(dataset.attrs["samples"])
            balance = HarmonicBalance(solved.problem, harmonics, samples, periods)
            points = [expanded(point, longer, balance.columns) for point in points]
        hertz = dataset["linear_frequency"].values[[0, -1]]
        low, high = 2.0 * np.pi * hertz / balance.periods
        curve = Interpolation(balance, points, FINE).curve() if points else []
        level, measure = float(dataset["force_level"].values[case]), measure_in(dataset).over(balance.periods)
        return cls(balance, curve, level, (float(low), float(high)), tolerance, measure, int(longer))

    def branch_points(self) -> list[BranchPoint]:
        """Where other curves cross, in the order of travel; of motions over more periods those that need them."""
        # A curve may go through a branch point again.
        different: list[BranchPoint] = []
        if contracts(self.balance.problem):
            return different
        for point in branch_points(self.balance, self.points):
            here = point.evaluation
            if not any(
                point.metric.length(here.w - other.evaluation.w, here.point.omega - other.evaluation.point.omega) < AGAIN
                for other in different
            ):
                different.append(point)
        found = [
            point for point in different if any(self.leads_away(point, start.evaluation) for start in starts(self.balance, point))
        ]
        if self.longer == 1:
            return found
        breaks = _columns_that_break(self)

        def size(point: BranchPoint, columns: NDArray[np.bool_]) -> float:
            return float(np.linalg.norm(point.directions[0].motion[:, columns]))

        return [point for point in found if size(point, breaks) > size(point, ~breaks)]

    def leads_away(self, point: BranchPoint, evaluation: Evaluation) -> bool:
        """Whether a solved point beside a branch point is not one of this curve."""
        near = np.flatnonzero(np.abs(self._along - self._along[point.place]) <= BESIDE)
        beside = self.points[max(int(near[0]) - 3, 0) : int(near[-1]) + 5]
        # The whole curve is compared only with what is not beside it, since each comparison evaluates all its points.
        return not any(passes(self.balance, points, evaluation, EXACT) for points in (beside, self.points))

    def followed(self, followed: Followed, begin: str) -> Curve:
        """A curve with its peaks; begin: of a sentence, what it is."""
        outcome = Outcome.CONVERGED if followed.lost is None else Outcome.NOT_CONVERGED
        lost_at = None if followed.lost is None else followed.points[-1].point.omega
        message = f"{begin}, {followed.ending}"
        curve = Curve(self.level, tuple(followed.points), outcome, message, lost_at, measure=self.measure)
        return with_peaks(self.balance, curve, lambda done: None, self.tolerance)

    @cached_property
    def _along(self) -> Array:
        """Arc length of every point."""
        return np.cumsum([point.length for point in self.points])

    @cached_property
    def _interpolation(self) -> Interpolation:
        return Interpolation(self.balance, [point.point for point in self.points], 0.1 * JOINED)

    def meets(self, evaluation: Evaluation, tolerance: float = NEAR) -> bool:
        """Whether the curve goes through a solved point, by motions that differ by a relative tolerance."""
        return bool(self.points) and _at_once(self.balance, self._interpolation, evaluation, tolerance)


def expanded(point: Point, longer: int, columns: int) -> Point:
    """A point with its motion expanded over several of its periods: harmonic h becomes longer·h, what is between is zero."""
    return Point(expanded_columns(point.forces, longer, columns), point.omega / longer, point.level)


def expanded_columns(values: Array, longer: int, columns: int) -> Array:
    """Real storage (..., 2H+1) of a motion over several of its periods, (..., columns)."""
    found = np.zeros((*values.shape[:-1], columns))
    found[..., 0] = values[..., 0]
    harmonics = np.arange(1, (values.shape[-1] + 1) // 2)
    for part in (0, 1):
        found[..., 2 * longer * harmonics - 1 + part] = values[..., 2 * harmonics - 1 + part]
    return found


def passes(balance: HarmonicBalance, points: Sequence[CurvePoint], evaluation: Evaluation, tolerance: float = NEAR) -> bool:
    """Whether a curve goes through a solved point: whether one of its motions at that frequency is that one, or the same some
    periods of the excitation later."""
    if not points:
        return False
    return _at_once(balance, Interpolation(balance, [point.point for point in points], 0.1 * tolerance), evaluation, tolerance)


def _at_once(balance: HarmonicBalance, curve: Interpolation, evaluation: Evaluation, tolerance: float) -> bool:
    values = curve.values(np.array([evaluation.point.omega]))[0]
    found = [complex_harmonics(value.evaluation.w)[:, 1:] for value in values if value.evaluation is not None]
    motion = complex_harmonics(evaluation.w)[:, 1:]
    turn = np.exp(2j * np.pi * np.arange(1, motion.shape[1] + 1) / balance.periods)
    near = tolerance * float(np.linalg.norm(motion))
    return any(float(np.linalg.norm(other - motion * turn**k)) <= near for other in found for k in range(balance.periods))


def branch_point_table(curve: SolvedCurve) -> pd.DataFrame:
    """The branch points of a curve: frequency [Hz], amplitude of the first output [m], and how many directions lead away."""
    balance = curve.balance
    rows = [
        {
            "frequency": balance.hertz(point.evaluation.point.omega),
            "amplitude": float(np.hypot(*point.evaluation.w[balance.rows, balance.first])),
            "directions": len(point.directions),
        }
        for point in curve.branch_points()
    ]
    return pd.DataFrame(rows, columns=["frequency", "amplitude", "directions"])


def branches(curve: SolvedCurve, at: float | None) -> list[Curve]:
    """The curves that cross at the branch point nearest to a frequency in Hz, or at the first one, each followed both ways."""
    wanted = None if at is None else positive("at", at)
    known = curve.branch_points()
    if not known:
        raise InputError(_no_branch_point(curve))
    balance = curve.balance
    chosen = known[0]
    if wanted is not None:
        chosen = min(known, key=lambda point: abs(balance.hertz(point.evaluation.point.omega) - wanted))
    found = _followed(curve, chosen, ())
    if not found:
        hertz = balance.hertz(chosen.evaluation.point.omega)
        raise InputError(f"No other curve could be found at the branch point at {hertz:.6g} Hz: Newton's method fails beside it.")
    return [curve.followed(each, _begin(curve, chosen)) for each in found]


def _no_branch_point(curve: SolvedCurve) -> str:
    """What is said of a curve without branch points."""
    longer, balance = curve.longer, curve.balance
    of = f" to motions that repeat after {longer} of its periods" if longer > 1 else ""
    if contracts(balance.problem):
        return f"The curve has no branch point{of}: friction under constant loads and damping leave one motion at each frequency."
    jumps = determinant_jumps(balance, curve.points)
    if not jumps:
        about = f"The curve has no branch point{of}: its Jacobian{' over them' if of else ''} is regular all along it."
        return about if of else f"{about} Motions over two periods branch off where periods=2 is given."
    listed = first_of([f"{balance.hertz(omega):.6g}" for omega in jumps])
    return (
        f"The curve has no branch point{of} that can be located: its Jacobian jumps over singularity near {listed} Hz, as "
        f"friction changes between stick and slip at samples. With more samples it may pass through it; there are "
        f"{balance.tables.E.shape[0] // balance.periods} a period."
    )


def all_branches(curve: SolvedCurve) -> list[Curve]:
    """The curves that cross at all branch points, each once."""
    known: list[Followed] = []
    curves: list[Curve] = []
    for point in curve.branch_points():
        found = _followed(curve, point, known)
        known += found
        curves += [curve.followed(each, _begin(curve, point)) for each in found]
    return curves


def _begin(curve: SolvedCurve, point: BranchPoint) -> str:
    return f"A branch from {curve.balance.hertz(point.evaluation.point.omega):.6g} Hz"


def _until_joined(curve: SolvedCurve, branch: Followed) -> Followed:
    """A branch up to where it goes over into the curve that it came from: Newton's method may go on along either."""
    points = branch.points
    if branch.closed or not curve.meets(points[-1].evaluation, JOINED):
        return branch
    low, high = 0, len(points) - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if curve.meets(points[middle].evaluation, JOINED) else (middle, high)
    return Followed(points[: high + 1], False, None, True)


def _until_repeated(curve: SolvedCurve, branch: Followed) -> Followed:
    """A branch of twice the period up to its first point behind another period doubling, where what breaks the period changes its
    sign: beyond, the same motions come again, one period of the excitation later."""
    if curve.longer != 2:
        return branch
    breaks = _columns_that_break(curve)
    motions = [point.evaluation.w[:, breaks] for point in branch.points]
    for k in range(1, len(motions)):
        if np.vdot(motions[k - 1], motions[k]) < 0.0:
            return Followed(branch.points[: k + 1], False, None, True)
    return branch


def _columns_that_break(curve: SolvedCurve) -> NDArray[np.bool_]:
    """The columns of harmonics that a motion of the shorter period does not have."""
    columns = curve.balance.columns
    return np.asarray(expanded_columns(np.ones(columns // curve.longer + 1), curve.longer, columns) == 0.0)


def _followed(curve: SolvedCurve, point: BranchPoint, known: Sequence[Followed]) -> list[Followed]:
    """The curves that cross at a branch point; one that a known one goes through is not followed again."""
    found: list[Followed] = []
    for start in starts(curve.balance, point):
        others = (*known, *found)
        same = not curve.leads_away(point, start.evaluation)
        if same or any(passes(curve.balance, each.points, start.evaluation) for each in others):
            continue
        onwards = _until_joined(curve, one_way(curve.balance, start.evaluation, start.along, curve.band))
        # The other way from a period doubling leads to the same motions, one period of the excitation later.
        if onwards.closed or curve.longer > 1:
            found.append(_until_repeated(curve, onwards))
            continue
        back = one_way(curve.balance, start.evaluation, start.along.turned(), curve.band)
        found.append(joined(_until_joined(curve, back), onwards))
    return found
