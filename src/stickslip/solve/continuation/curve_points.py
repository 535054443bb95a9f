"""Points of a curve with their tangents, and interpolation between two of them."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Parameter, PathCondition, Point
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.support.checks import Array
from stickslip.support.kernels import boxed, inlined, kernel
from stickslip.support.kernels.arrays import zero_table

ROUNDING = 1e-9
"""Motion below this share of the largest is rounding: an output at a node."""

MEAN = 0.002
"""A change of the mean is measured by this share of the mean, where that is more than the vibration: the mean of a lightly
pressed body may drift by many thousand times its vibration, and steps would be as short."""


class Metric(NamedTuple):
    """Squared scales of arc length: weight (motion rows, 2H+1) = 1/σ², parameter = 1/σ_p²."""

    weight: Array
    parameter: float

    def length(self, dw: Array, dp: float) -> float:
        """Length of a change of motion and parameter."""
        return float(np.sqrt(np.vdot(self.weight * dw, dw) + self.parameter * dp * dp))


@kernel
def moving_sizes(w: Array, rows: int) -> tuple[float, float]:
    """Root sums of squares of the motion of contacts and of outputs, without their means."""
    squares = [0.0, 0.0]
    for r in range(w.shape[0]):
        for i in range(1, w.shape[1]):
            squares[0 if r < rows else 1] += w[r, i] ** 2
    return np.sqrt(squares[0]), np.sqrt(squares[1])


@inlined
def weights(w: Array, rows: int, contacts: float, outputs: float) -> Array:
    """Squared reciprocal scales (motion rows, 2H+1) of the motion of contacts and of outputs, whose sizes are given; what moves
    by rounding alone does not count."""
    found, largest = zero_table(w.shape[0], w.shape[1]), max(contacts, outputs)
    for scale, first, last in ((contacts, 0, rows), (outputs, rows, w.shape[0])):
        if scale > ROUNDING * largest:
            mean = 0.0
            for r in range(first, last):
                mean += w[r, 0] * w[r, 0]
            for r in range(first, last):
                found[r, 0] = 1.0 / (scale * scale + MEAN * MEAN * mean)
                for i in range(1, w.shape[1]):
                    found[r, i] = 1.0 / (scale * scale)
    return found


@kernel
def _weights_called(w: Array, rows: int, contacts: float, outputs: float) -> Array:
    """`weights` for calls from Python."""
    return boxed(weights(w, rows, contacts, outputs))


def relative_metric(w: Array, rows: int, scales: Sequence[float], parameter_scale: float) -> Metric:
    """Motion w of contacts and of outputs relative to the two scales; what moves by rounding alone does not count."""
    contacts, outputs = map(float, scales)
    return Metric(_weights_called(np.ascontiguousarray(w), rows, contacts, outputs), 1.0 / parameter_scale**2)


class Tangent(NamedTuple):
    """Unit direction along the curve: dλ/ds, dw/ds, dp/ds; level: of the force level where it holds an amplitude, else 0."""

    forces: Array
    motion: Array
    parameter: float
    level: float = 0.0

    def turned(self) -> "Tangent":
        """The opposite direction."""
        return Tangent(-self.forces, -self.motion, -self.parameter, -self.level)


@dataclass(frozen=True, slots=True, eq=False)
class CurvePoint:
    """A solved point without its derivatives, its tangent and metric; `length`: arc length stepped from the point before."""

    evaluation: Evaluation
    tangent: Tangent
    metric: Metric
    iterations: int
    active: int
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "evaluation", self.evaluation.without_derivatives())

    @property
    def point(self) -> Point:
        return self.evaluation.point

    def across(self, parameter: Parameter) -> PathCondition:
        """Planes across the tangent here; their targets number them along the curve."""
        return PathCondition(
            parameter, self.metric.weight * self.tangent.motion, self.metric.parameter * self.tangent.parameter, 0.0
        )

    def chord(self, following: "CurvePoint", parameter: Parameter) -> float:
        """Length of the straight way to another point, in the metric of this one; much more than the step after a jump."""
        change = following.point.value(parameter) - self.point.value(parameter)
        return self.metric.length(following.evaluation.w - self.evaluation.w, change)

    def leads_away_from(self, before: "CurvePoint", parameter: Parameter) -> bool:
        """Whether the curve goes on from here, and not back to another point, in the metric of that one."""
        motion, metric = self.evaluation.w - before.evaluation.w, before.metric
        change = self.point.value(parameter) - before.point.value(parameter)
        along = float(np.vdot(metric.weight * self.tangent.motion, motion))
        return along + metric.parameter * self.tangent.parameter * change > 0.0

    def turn(self, following: "CurvePoint") -> float:
        """Cosine of the angle between the tangents here and at another point, in the metric of this one."""
        return self.cosine(following.tangent)

    def cosine(self, tangent: Tangent) -> float:
        """Cosine of the angle between the tangent here and another one, in the metric of this point."""
        a, b, metric = self.tangent, tangent, self.metric
        dot = float(np.vdot(metric.weight * a.motion, b.motion)) + metric.parameter * a.parameter * b.parameter
        return dot / metric.length(b.motion, b.parameter)


def backwards(points: Sequence[CurvePoint]) -> list[CurvePoint]:
    """A curve over ω followed from its last point to its first: each step is measured at the point that it now starts from.

    The last point was solved at the end of the band and has no step of its own: its chord stands for it.
    """
    turned = [replace(point, tangent=point.tangent.turned(), length=0.0) for point in reversed(points)]
    for k, (before, after) in enumerate(itertools.pairwise(reversed(points)), 1):
        ratio = before.metric.length(after.tangent.motion, after.tangent.parameter)
        turned[k] = replace(turned[k], length=before.length * ratio or before.chord(after, "omega"))
    return turned


class LostCurveError(Exception):
    """The curve could not be continued; the argument says where."""


def hermite(a: Array, da: Array, b: Array, db: Array, f: float) -> Array:
    """The cubic through a and b with slopes da and db over the whole interval, at fraction f."""
    shares = hermite_shares(f)
    return np.asarray(shares[0] * a + shares[1] * da + shares[2] * b + shares[3] * db)


def hermite_shares(f: float) -> Array:
    """What a, da, b and db count for at fraction f of the cubic through a and b with slopes da and db over the whole interval."""
    return np.array([(1 + 2 * f) * (1 - f) ** 2, f * (1 - f) ** 2, f * f * (3 - 2 * f), f * f * (f - 1)])


def between(current: CurvePoint, following: CurvePoint, fraction: float) -> Array:
    """λ on the cubic Hermite curve through two points and their tangents."""
    step = following.length
    scale = following.metric.length(current.tangent.motion, current.tangent.parameter)
    da, db = step * current.tangent.forces, step * scale * following.tangent.forces
    return hermite(current.point.forces, da, following.point.forces, db, fraction)


def solve_at(
    balance: HarmonicBalance, current: CurvePoint, following: CurvePoint, parameter: Parameter, value: float
) -> CurvePoint:
    """The solved point at an exact parameter value between two points of a curve; raises `LostCurveError`."""
    low, high = current.point.value(parameter), following.point.value(parameter)
    fraction = (value - low) / (high - low)
    for place in (fraction, 0.0, 1.0, 0.5 * fraction, 0.5 * (1.0 + fraction)):
        level = current.point.level + place * (following.point.level - current.point.level)
        point = replace(current.point, forces=between(current, following, place), level=level)
        point = replace(point, omega=value) if parameter == "omega" else replace(point, level=value)
        correction = correct(balance, point, fixed(parameter, value), iterations=20, halvings=8)
        if correction.converged:
            size = 0 if correction.factors is None else correction.factors.size
            return CurvePoint(correction.evaluation, following.tangent, following.metric, correction.iterations, size, 0.0)
    where = f"{balance.hertz(value):g} Hz" if parameter == "omega" else f"force level {value:g}"
    raise LostCurveError(f"Newton's method failed at {where}.")
