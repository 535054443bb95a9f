"""The coordinates of a finite-element model that its solutions need: shapes of the contact forces at the highest peaks.

Contacts deform a mesh beyond its low modes by what they carry. The peaks of all force levels are first solved without these
deformations, on curves with the harmonics of the loads alone where these have a peak. Then they are solved with all harmonics and
the shapes of their own contact forces, until no output changes by more than `SETTLED`. One round leaves the square of what it
changes, where contacts are not far stiffer than what they join.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.analyses.truncation import errors_by, highest_points, solved_again
from stickslip.model.problem import Problem
from stickslip.model.problem.meshed import finer, with_forces
from stickslip.model.structure.stuck_mesh import NEGLIGIBLE
from stickslip.runs.cases import Progress
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.truncation import pad
from stickslip.solve.curves.curve import Curve
from stickslip.support.checks import Array

SETTLED = 1e-3
"""Relative change of the outputs at their highest peaks at which shapes are enough; a curve says what is left."""

ROUNDS = 8
"""Rounds at most; what they leave is said of each curve."""


@dataclass(frozen=True, eq=False)
class Highest:
    """The highest point of an output: its forces, frequency and level, its first harmonic (2,) where it is a peak, its size."""

    output: int
    point: Point
    peak: Array | None
    size: float


def with_loaded_harmonics(balance: HarmonicBalance) -> HarmonicBalance:
    """The balance with the harmonics up to the highest of the loads alone, and as many samples for each."""
    loaded = max([1, *(harmonic for force in balance.problem.forces for harmonic in force.factors)]) * balance.periods
    if loaded >= balance.highest:
        return balance
    samples = balance.tables.E.shape[0] * loaded // balance.highest
    few = balance.with_harmonics(loaded)
    return few.with_samples(balance.problem.systems.enough_samples(max(samples, 4 * loaded + 2)))


def with_shapes_of_peaks(
    rough: HarmonicBalance,
    balance_of: Callable[[Problem], HarmonicBalance],
    highest: Sequence[Highest],
    measure: Measure,
    progress: Progress,
    share: float = NEGLIGIBLE,
) -> Problem:
    """A problem of a mesh with the shapes of the contact forces at the highest points of its curves; rough: their balance; share:
    as in `with_forces`."""
    problem = rough.problem
    few = balance_of(problem)
    for _ in range(ROUNDS if highest else 0):
        forces = np.hstack([scaled(each.point.forces) for each in highest])
        more = with_forces(problem, forces, share)
        if more.structure.size == problem.structure.size:
            break
        progress(0.0, f"highest peaks on {more.structure.size} coordinates")
        problem, balance = more, balance_of(more)
        again = [_again(balance, few, each, measure) for each in highest]
        change = max(abs(new.size / old.size - 1.0) for new, old in zip(again, highest, strict=True))
        few, highest = balance, again
        if change <= SETTLED:
            break
    return problem


def own_shapes_error(
    balance: HarmonicBalance,
    curve: Curve,
    measure: Measure,
    started: Callable[[HarmonicBalance], HarmonicBalance] = lambda whole: whole,
) -> Array:
    """The relative change of each output (outputs,) at its highest peak by all shapes of the contact forces there, and by what
    the inertia of all shapes deforms; started: puts the sliders where those of the balance start."""
    points = list(highest_points(balance, curve, measure).values())
    if not points:
        return np.full(len(balance.problem.outputs), np.nan)
    all_shapes = _with_all_shapes(balance, np.hstack([scaled(point.point.forces) for point in points]))
    return errors_by(started(all_shapes), balance, balance, curve, measure)


def own_shapes_change(
    balance: HarmonicBalance,
    solved: Evaluation,
    output: int,
    measure: Measure,
    started: Callable[[HarmonicBalance], HarmonicBalance] = lambda whole: whole,
    at_peak: bool = True,
) -> float:
    """The same of one output at one of its peaks, or else at a frequency; NaN where that cannot be solved on these shapes."""
    row = balance.rows + output
    all_shapes = started(_with_all_shapes(balance, scaled(solved.point.forces)))
    solution = solved_again(all_shapes, balance, solved.point, output, solved.w[row][balance.first] if at_peak else None)
    if solution is None:
        return np.nan
    return measure.size(solution.w[row], solution.point.omega) / measure.size(solved.w[row], solved.point.omega) - 1.0


def _with_all_shapes(balance: HarmonicBalance, forces: Array) -> HarmonicBalance:
    """The balance on all shapes of these contact forces (rows, k), and on what the inertia of its own deforms."""
    return HarmonicBalance(finer(balance.problem, forces), balance.harmonics, balance.tables.E.shape[0], balance.periods)


def highest_of(balance: HarmonicBalance, curve: Curve, measure: Measure) -> Iterator[Highest]:
    """The highest point of each output of a curve."""
    for output, highest in highest_points(balance, curve, measure).items():
        X = highest.evaluation.w[balance.rows + output]
        peak = X[balance.first] if curve.peaks and curve.peaks[output] else None
        yield Highest(output, highest.point, peak, measure.size(X, highest.point.omega))


def _again(balance: HarmonicBalance, few: HarmonicBalance, highest: Highest, measure: Measure) -> Highest:
    """The point with more shapes; where a peak is not found at its phase, at its frequency, and as it is where there is none."""
    start = replace(highest.point, forces=pad(highest.point.forces, balance.columns))
    solution = solved_again(balance, few, start, highest.output, highest.peak)
    at_peak = solution is not None and highest.peak is not None
    if solution is None and highest.peak is not None:  # the forces beside a peak have the shapes of those there
        solution = solved_again(balance, few, start, highest.output, None)
    if solution is None:
        return highest
    X = solution.w[balance.rows + highest.output]
    peak = X[balance.first] if at_peak else None
    return replace(highest, point=solution.point, peak=peak, size=measure.size(X, solution.point.omega))


def scaled(forces: Array) -> Array:
    """Forces λ (rows, 2H+1) at a point, the mean and the vibration each of unit size: neither hides the other."""
    sizes = [np.linalg.norm(part) or 1.0 for part in (forces[:, :1], forces[:, 1:])]
    return np.hstack([forces[:, :1] / sizes[0], forces[:, 1:] / sizes[1]])


def few_combinations(forces: Array, share: float) -> Array:
    """Combinations of forces (rows, k) of which all are, but for a share of the squares of the largest."""
    directions, sizes, _ = np.linalg.svd(forces, full_matrices=False)
    return np.asarray((directions * sizes)[:, sizes**2 > share * sizes[0] ** 2])
