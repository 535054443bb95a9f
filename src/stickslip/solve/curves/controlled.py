"""A controlled response curve: the force level that holds the amplitude of an output, along frequency, and phase resonances.

The unknown force level makes the balance one equation longer; the continuation of forced responses follows it as it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.continuation.curve_points import CurvePoint, between
from stickslip.solve.continuation.held_amplitude import at_right_angle, control_size, ramped, scaled, stuck_held
from stickslip.solve.continuation.newton import Correction, correct
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.continuation.sweep import sweep
from stickslip.solve.curves.curve import Curve, ended, solve_curve
from stickslip.support.checks import Array
from stickslip.support.outcome import Outcome

LARGEST = 0.15
"""Longest step in arc length: with the amplitude held, motion turns by 180° through a resonance, in some twenty points."""

SAME_PHASE = 1e-9
"""Relative part of a load at 90° to the rest of it up to which all of it has one phase."""

APART = 1e-6
"""Relative difference in frequency below which two phase resonances are one."""


def controlled_curve(
    balance: HarmonicBalance,
    frequencies: Sequence[float],
    exactly: bool,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Curve:
    """The curve of a balance that holds an amplitude, from frequencies[0] to frequencies[-1] in rad/s, or exactly there.

    `level` of each point is the force level that holds the amplitude; that of the curve is not a number.
    """
    if exactly:
        return solve_curve(balance, frequencies, math.nan, exactly=True, progress=progress)
    start, end = frequencies[0], frequencies[-1]
    found = sweep(balance, start, end, math.nan, progress, StepControl(largest=LARGEST))
    if isinstance(found, Outcome):
        return Curve(math.nan, (), found, " ".join((found.sentence, *balance.problem.warnings)), start)
    return ended(balance, math.nan, found, (start, end))


def force_phase(problem: Problem, omega: float) -> float | None:
    """Phase in rad of the first harmonic of the loads, or None where they have none, or several."""
    powers = problem.load_powers(max([1, *(h for force in problem.forces for h in force.amplitudes)]))
    load = np.einsum("k,knh->nh", omega ** np.arange(len(powers)), powers)[:, 1:3] @ np.array([1.0, -1.0j])
    largest = load[int(np.argmax(np.abs(load)))] if load.size else 0.0
    if not abs(largest) > 0.0:
        return None
    turned = load * np.conj(largest) / abs(largest)
    return float(np.angle(largest)) if np.abs(turned.imag).max() <= SAME_PHASE * abs(largest) else None


def turned_motion(balance: HarmonicBalance, evaluation: Evaluation, row: int, phase: float) -> complex:
    """X_1 e^{−iφ} of a row of motion: real where it is in phase with a force of phase φ and a positive level."""
    a, b = evaluation.w[row, 1:3]
    sign = math.copysign(1.0, evaluation.point.level)
    return complex(a, -b) * complex(math.cos(phase), -math.sin(phase)) * sign


def phase_resonances(balance: HarmonicBalance, points: Sequence[CurvePoint], phase: float) -> list[Correction]:
    """The points of a controlled curve where force and held motion are at 90°, the lowest force level first."""
    row = balance.system.control.row
    parts = [turned_motion(balance, point.evaluation, row, phase).real for point in points]
    found: list[Correction] = []
    for (low, high), (a, b) in zip(pairwise(points), pairwise(parts), strict=True):
        if a * b > 0.0:
            continue
        solved = _between(balance, low, high, a / (a - b) if a != b else 0.5, phase)
        if solved.converged and not any(_same(solved, other) for other in found):
            found.append(solved)
    return sorted(found, key=lambda each: abs(each.evaluation.point.level))


def _between(balance: HarmonicBalance, low: CurvePoint, high: CurvePoint, fraction: float, phase: float) -> Correction:
    """The phase resonance between two points of a curve."""
    ends = low.point, high.point
    omega, level = ((1.0 - fraction) * a + fraction * b for a, b in zip(*((e.omega, e.level) for e in ends), strict=True))
    start = Point(between(low, high, fraction), omega, level)
    return correct(balance, start, at_right_angle(balance, omega, phase), iterations=20, halvings=8)


def _same(one: Correction, other: Correction) -> bool:
    a, b = one.evaluation.point, other.evaluation.point
    return abs(a.omega / b.omega - 1.0) < APART and abs(a.level / b.level - 1.0) < APART


def followed_resonances(
    balance: HarmonicBalance, amplitudes: Array, omega: float, phase: float, ends: tuple[float, float]
) -> list[Correction]:
    """Phase resonances at ascending amplitudes, each from the one before; the first from that of the stuck structure near ω.

    Without viscous damping the stuck structure needs no force, and nothing begins there: then, and wherever Newton's method
    fails, the controlled curve between the ends of the band [rad/s] is searched. Where one is not found stands what Newton's
    method left.
    """
    found: list[Correction] = []
    for amplitude in amplitudes.tolist():
        one = balance.holding(balance.system.control._replace(amplitude=amplitude))
        before = found[-1].evaluation if found and found[-1].converged else None
        solved = _followed(one, before, omega, phase)
        found.append(solved if solved.converged else _on_curve(one, ends, phase) or solved)
    return found


def _on_curve(balance: HarmonicBalance, ends: tuple[float, float], phase: float) -> Correction | None:
    """The phase resonance of the least force on the controlled curve; None where it has none."""
    found = phase_resonances(balance, controlled_curve(balance, ends, exactly=False).points, phase)
    return found[0] if found else None


def _followed(balance: HarmonicBalance, before: Evaluation | None, omega: float, phase: float) -> Correction:
    """The phase resonance at the held amplitude, from that of a smaller one, or from the stuck structure near ω."""
    condition, control = at_right_angle(balance, omega, phase), balance.system.control

    def begun(one: HarmonicBalance) -> Correction:
        return correct(one, stuck_held(one, omega), condition, iterations=30, halvings=10)

    if before is None:
        solved = begun(balance)
    else:
        ratio = control.amplitude / control_size(control, before)
        solved = correct(balance, scaled(before.point, ratio), condition, iterations=30, halvings=10)
    return solved if solved.converged else ramped(balance, begun, condition) or solved
