"""Branch points of a curve: where its bordered Jacobian is singular, and where the other curves lead that cross it there.

With the tangent of the curve as its last row the matrix is regular along a curve and over its folds. Where it is singular another
curve crosses; the directions that it takes to zero lead on to that. A single one shows as a change of the determinant's sign, two
at once, as on a disk of equal sectors, only as a zero of the smallest singular value.
Where contacts begin to slip it may also jump over zero or touch it: mostly nothing crosses there, which the search for
another curve shows.
Source: for both, E. L. Allgower and K. Georg, Introduction to Numerical Continuation Methods (1990), chapter 8.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stickslip.solve.balance.balance import Evaluation, Factors, HarmonicBalance, PathCondition, Point
from stickslip.solve.continuation.curve_points import CurvePoint, Metric, Tangent, between
from stickslip.solve.continuation.newton import correct
from stickslip.support.checks import SMALLEST, Array

BISECTIONS = 30
"""Halvings of the step that holds a branch point."""

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)

SMALL = 0.5
"""A least singular value below this share of the median is looked at, if its neighbours are larger."""

ZERO = 1e-3
"""Share of the singular value at the ends of a step below which it is zero inside."""

JUMP = 0.05
"""Share of the singular value at the ends of a step up to which a determinant that jumps over zero, between two samples of a
contact, counts: where it jumps farther nothing crosses. Two arms of a lightly damped resonance gave such places by the dozen."""

MOST_DIRECTIONS = 4
"""Directions that the matrix of a branch point may take to zero at once."""

DISTANCES = (1e-2, 3e-2, 1e-3, 0.1)
"""Arc lengths from a branch point at which the other curve is sought."""

FARTHEST = 3.0
"""How many times that far the point found there may lie."""

TURNS = 12
"""Directions tried between two that are taken to zero."""

SAME_DIRECTION = 0.98


@dataclass(frozen=True, eq=False)
class BranchPoint:
    """A solved point; place: of the curve point before it; metric of the arc length there; directions: unit vectors that the
    bordered Jacobian takes to zero, across the curve."""

    evaluation: Evaluation
    place: int
    metric: Metric
    directions: tuple[Tangent, ...]


@dataclass(frozen=True, eq=False)
class Start:
    """A solved point of a curve that crosses another at a branch point, and the direction away from there."""

    evaluation: Evaluation
    along: Tangent


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """The least singular values of a scaled bordered matrix, ascending, and the right vectors, columns."""

    values: Array
    vectors: Array


def branch_points(balance: HarmonicBalance, curve: Sequence[CurvePoint]) -> list[BranchPoint]:
    """Where the bordered Jacobian of a curve over ω is singular, in its order; `starts` says whether another curve crosses."""
    found = []
    least = np.array([_least(balance, point) for point in curve])
    crossed = [_changes(balance, a, b) for a, b in pairwise(curve)]
    for k in range(len(curve) - 1):
        share = _bisected(balance, curve[k], curve[k + 1]) if crossed[k] else _lowest(balance, curve, least, crossed, k)
        if share is not None:
            around = max(least[k], least[k + 1])
            found.append(_at(balance, curve, k, share, around))
    return [point for point in found if point is not None]


def determinant_jumps(balance: HarmonicBalance, curve: Sequence[CurvePoint]) -> list[float]:
    """ω [rad/s] where the bordered determinant jumps over zero between two samples of a contact, too far for a branch point."""
    found = []
    for k, (current, following) in enumerate(pairwise(curve)):
        if not _changes(balance, current, following):
            continue
        share = _bisected(balance, current, following)
        evaluation = None if share is None else _inside(balance, current, following, share)
        if evaluation is None:
            continue
        least = float(_spectrum(balance, evaluation, _plane(current, following), current.metric).values[0])
        if least > JUMP * max(_least(balance, point) for point in curve[k : k + 2]):
            found.append(evaluation.point.omega)
    return found


def _plane(current: CurvePoint, following: CurvePoint) -> PathCondition:
    """Planes across the straight way between two points, 0 at the first and 1 at the second."""
    motion = current.metric.weight * (following.evaluation.w - current.evaluation.w)
    slope = current.metric.parameter * (following.point.omega - current.point.omega)
    square = current.chord(following, "omega") ** 2
    plane = PathCondition("omega", motion / square, slope / square, 0.0)
    return replace(plane, target=plane.gap(current.evaluation))


def _inside(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint, share: float) -> Evaluation | None:
    """The solved point on the plane at a share of a step; None where Newton's method fails."""
    plane = _plane(current, following)
    omega = current.point.omega + share * (following.point.omega - current.point.omega)
    start = Point(between(current, following, share), omega, current.point.level)
    found = correct(balance, start, replace(plane, target=plane.target + share), iterations=15, halvings=6)
    return found.evaluation if found.converged else None


def _orientation(balance: HarmonicBalance, evaluation: Evaluation, plane: PathCondition) -> float:
    return balance.factorise(evaluation, plane).orientation


def _changes(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint) -> bool:
    """Whether the bordered determinant changes its sign along a step."""
    if current.chord(following, "omega") == 0.0:
        return False
    plane = _plane(current, following)
    signs = [
        _orientation(balance, point.evaluation, plane) * np.sign(plane.rate(point.tangent.motion, point.tangent.parameter))
        for point in (current, following)
    ]
    return bool(signs[0] * signs[1] < 0.0)


def _bisected(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint) -> float | None:
    """The share of a step at which the determinant changes its sign."""
    plane, low, high = _plane(current, following), 0.0, 1.0
    sign = _orientation(balance, current.evaluation, plane)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        evaluation = _inside(balance, current, following, middle)
        if evaluation is None:
            return None
        low, high = (middle, high) if _orientation(balance, evaluation, plane) == sign else (low, middle)
    return 0.5 * (low + high)


def _lowest(balance: HarmonicBalance, curve: Sequence[CurvePoint], least: Array, crossed: Sequence[bool], k: int) -> float | None:
    """The share of step k at which the smallest singular value vanishes without a change of sign; None where it does not."""
    beside = [place for place in (k - 1, k + 1) if 0 <= place < len(crossed) and crossed[place]]
    ends = least[k : k + 2]
    hollow = any(0 < p < least.size - 1 and least[p] <= min(least[p - 1], least[p + 1]) for p in (k, k + 1))
    if beside or not hollow or ends.min() > SMALL * float(np.median(least)) or curve[k].chord(curve[k + 1], "omega") == 0.0:
        return None
    low, high, scale = 0.0, 1.0, ends.max()
    shares = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)]
    values = [_value(balance, curve[k], curve[k + 1], share) for share in shares]
    for _ in range(BISECTIONS):
        if values[0] < values[1]:
            high, shares, values = shares[1], [0.0, shares[0]], [0.0, values[0]]
            shares[0] = high - GOLDEN * (high - low)
            values[0] = _value(balance, curve[k], curve[k + 1], shares[0])
        else:
            low, shares, values = shares[0], [shares[1], 0.0], [values[1], 0.0]
            shares[1] = low + GOLDEN * (high - low)
            values[1] = _value(balance, curve[k], curve[k + 1], shares[1])
    best = int(np.argmin(values))
    return shares[best] if values[best] < ZERO * scale else None


def _value(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint, share: float) -> float:
    """The smallest singular value at a share of a step; infinite where it cannot be solved."""
    evaluation = _inside(balance, current, following, share)
    if evaluation is None:
        return np.inf
    return float(_spectrum(balance, evaluation, _plane(current, following), current.metric).values[0])


def _least(balance: HarmonicBalance, point: CurvePoint) -> float:
    return float(_spectrum(balance, point.evaluation, point.across("omega"), point.metric).values[0])


def _scales(evaluation: Evaluation, metric: Metric) -> tuple[float, float]:
    """Sizes of a change of λ [N] and of ω [rad/s] that count as one."""
    forces = float(np.linalg.norm(evaluation.point.forces[:, 1:]))
    carried = float(np.linalg.norm(evaluation.state.residual - evaluation.point.forces))
    return max(forces, carried, SMALLEST), 1.0 / float(np.sqrt(metric.parameter))


def _spectrum(balance: HarmonicBalance, evaluation: Evaluation, plane: PathCondition, metric: Metric) -> _Spectrum:
    """The least singular values of the bordered matrix, its unknowns and equations scaled, by inverse iteration of a block."""
    weight = plane.weight
    assert weight is not None
    length = float(np.sqrt(np.sum(weight**2 / np.maximum(metric.weight, SMALLEST)) + plane.slope**2 / metric.parameter))
    plane = replace(plane, weight=weight / length, slope=plane.slope / length)
    factors = balance.factorise(evaluation, plane)
    size, (force, rate) = factors.rows, _scales(evaluation, metric)
    rows, columns = np.append(np.full(size - 1, force), 1.0), np.append(np.full(size - 1, force), rate)
    if factors.orientation == 0.0:
        return _Spectrum(np.zeros(1), np.zeros((size, 1)))
    block = np.linalg.qr(np.random.default_rng(0).standard_normal((size, min(MOST_DIRECTIONS, size))))[0]
    for _ in range(6):
        block = np.linalg.qr(_solved(factors, _transposed(factors, block, rows, columns), rows, columns))[0]
    _, values, turn = np.linalg.svd(_transposed(factors, block, rows, columns), full_matrices=False)
    return _Spectrum(1.0 / np.maximum(values, SMALLEST), block @ turn.T)


def _solved(factors: Factors, right: Array, rows: Array, columns: Array) -> Array:
    """Â⁻¹ right, Â the matrix with its equations over `rows` and its unknowns over `columns`."""
    return np.asarray(factors.solve_many((right * rows[:, None]).T).T / columns[:, None])


def _transposed(factors: Factors, right: Array, rows: Array, columns: Array) -> Array:
    """Â⁻ᵀ right."""
    return np.asarray(factors.solve_transposed((right / columns[:, None]).T).T * rows[:, None])


def _at(balance: HarmonicBalance, curve: Sequence[CurvePoint], k: int, share: float, around: float) -> BranchPoint | None:
    """The branch point at a share of step k; around: the singular value at its ends."""
    current, following = curve[k : k + 2]
    evaluation = _inside(balance, current, following, share)
    if evaluation is None:
        return None
    spectrum = _spectrum(balance, evaluation, _plane(current, following), current.metric)
    if spectrum.values[0] > JUMP * around:
        return None
    count = max(int(np.count_nonzero(spectrum.values < ZERO * around)), 1)
    directions = tuple(_direction(balance, evaluation, current.metric, spectrum.vectors[:, i]) for i in range(count))
    return BranchPoint(evaluation, k, current.metric, directions)


def _direction(balance: HarmonicBalance, evaluation: Evaluation, metric: Metric, vector: Array) -> Tangent:
    """The unit direction of scaled unknowns."""
    force, rate = _scales(evaluation, metric)
    factors = balance.factorise(evaluation, PathCondition("omega", None, 1.0, 0.0))
    forces, point = np.zeros(evaluation.point.forces.shape), evaluation.point
    forces[factors.mask] = force * vector[:-1]
    amount = rate * float(vector[-1])
    motion = balance.linear.change(forces, point.omega)
    motion += amount * balance.linear.slope(point.forces, point.omega, point.level, by_level=False)
    return _unit(metric, forces, motion, amount)


def _unit(metric: Metric, forces: Array, motion: Array, amount: float) -> Tangent:
    length = metric.length(motion, amount)
    return Tangent(forces / length, motion / length, amount / length)


def starts(balance: HarmonicBalance, point: BranchPoint) -> list[Start]:
    """Points of the curves that cross at a branch point, one of each beside it."""
    found: list[Start] = []
    for wanted in _tried(point):
        start = _start(balance, point, wanted)
        if start is None:
            continue
        weight, slope = point.metric.weight * start.along.motion, point.metric.parameter * start.along.parameter
        cosines = [np.vdot(weight, other.along.motion) + slope * other.along.parameter for other in found]
        if not np.any(np.abs(cosines) > SAME_DIRECTION):  # or of the opposite one, which the same curve has
            found.append(start)
    return found


def _tried(point: BranchPoint) -> Iterator[Tangent]:
    """The directions themselves, and of every two those between."""
    yield from point.directions
    for k, one in enumerate(point.directions):
        for other in point.directions[k + 1 :]:
            for angle in np.pi * np.arange(1, TURNS) / TURNS:
                a, b = np.cos(angle), np.sin(angle)
                motion, amount = a * one.motion + b * other.motion, a * one.parameter + b * other.parameter
                yield _unit(point.metric, a * one.forces + b * other.forces, motion, amount)


def _start(balance: HarmonicBalance, point: BranchPoint, wanted: Tangent) -> Start | None:
    """The curve beside a branch point in a wanted direction; None where it is not found."""
    origin, metric = point.evaluation, point.metric
    plane = PathCondition("omega", metric.weight * wanted.motion, metric.parameter * wanted.parameter, 0.0)
    reached = plane.gap(origin)
    for distance in DISTANCES:
        start = origin.point.moved(distance * wanted.forces, "omega", distance * wanted.parameter)
        if start.omega <= 0.0:
            continue
        found = correct(balance, start, replace(plane, target=reached + distance), iterations=25, halvings=8)
        if not found.converged:
            continue
        evaluation = found.evaluation
        forces, motion = evaluation.point.forces - origin.point.forces, evaluation.w - origin.w
        amount = evaluation.point.omega - origin.point.omega
        if metric.length(motion, amount) <= FARTHEST * distance:
            return Start(evaluation, _unit(metric, forces, motion, amount))
    return None
