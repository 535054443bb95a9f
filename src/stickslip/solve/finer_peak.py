"""A peak solved once more with a finer problem, whose resonance may lie many half-widths beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stickslip.checks import Array
from stickslip.harmonic.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.all_modes import solved_on_all_modes
from stickslip.solve.newton import fixed

BELIEVED, WIDTHS = 2.0, 2.0
"""Factor of the height, or else half-widths of the resonance, within which a solution at the phase of a peak is that peak. Beside
a resonance, where the motion of others is as large, the phase comes back at a fraction of the height."""

APART, STRIDE, REACH, MOST = 1e-3, 0.02, 0.1, 8
"""Relative distance of the first three frequencies, of two further ones at most, of all at most from the peak; and how many."""


def phase_condition(balance: HarmonicBalance, output: int, X: Array) -> PathCondition:
    """ω as an unknown where the first harmonic of an output has the phase of X, (2,): that of a peak is the same, in the first
    order, where its height is the largest, whichever way the resonance shifts."""
    weight = np.zeros((balance.rows + len(balance.problem.outputs), balance.columns))
    weight[balance.rows + output, balance.first] = np.array([-X[1], X[0]]) / float(X @ X)
    return PathCondition("omega", weight, 0.0, 0.0)


def finer_peak(whole: HarmonicBalance, few: HarmonicBalance, start: Point, output: int, X: Array) -> Evaluation | None:
    """The peak of an output, whose first harmonic is X (2,), with `whole`; few: its contacts on few coordinates.

    Solved at the phase of X from `start`, or from the solution at the same frequency, where the height is half to twice that of
    X. Else from solutions on the way to the resonance, in whose width it then must lie. None where none is found.
    """
    condition, row = phase_condition(whole, output, X), whole.rows + output
    found = solved_on_all_modes(whole, few, start, condition)
    if found is not None and _alike(found.w[row, whole.first], X):
        return found
    first = solved_on_all_modes(whole, few, start, fixed("omega", start.omega))
    if first is None:
        return None
    found = solved_on_all_modes(whole, few, first.point, condition)  # the frequency runs away unless λ is about right
    if found is not None and _alike(found.w[row, whole.first], X):
        return found
    for point, pole in _towards_the_resonance(whole, few, first, row):
        if abs(pole.real - point.omega) <= abs(pole.imag):
            found = solved_on_all_modes(whole, few, point, condition)
            if found is not None and abs(found.point.omega - pole.real) <= WIDTHS * abs(pole.imag):
                return found
    return None


def _alike(X: Array, Y: Array) -> bool:
    return bool(1.0 / BELIEVED < np.hypot(*X) / np.hypot(*Y) < BELIEVED)


def _towards_the_resonance(
    whole: HarmonicBalance, few: HarmonicBalance, first: Evaluation, row: int
) -> Iterator[tuple[Point, complex]]:
    """Solutions nearer and nearer to the resonance next to `first`, and its pole as known by then.

    Three of them give X(ω) = c + r/(ω − p), a resonance and what others move beside it; the next is at the real part of p.
    """
    omega, point = first.point.omega, first.point
    known = [(omega, _complex(first, row, whole))]
    following = omega * (1.0 + APART)
    while len(known) < MOST:
        point = replace(point, omega=following)
        if len(known) > 2:  # the motion by then: its phase turns on the way to the resonance
            point = replace(point, forces=_delayed(point.forces, _turn(known, following)))
        solution = solved_on_all_modes(whole, few, point, fixed("omega", following))
        if solution is None:
            return
        point = solution.point
        known.append((following, _complex(solution, row, whole)))
        if len(known) == 2:
            following = omega * (1.0 - APART)
            continue
        pole = _resonance(known)[0]
        yield point, pole
        following = float(np.clip(pole.real, following - STRIDE * omega, following + STRIDE * omega))
        if not abs(following / omega - 1.0) <= REACH:
            return


def _complex(evaluation: Evaluation, row: int, balance: HarmonicBalance) -> complex:
    a, b = evaluation.w[row, balance.first]
    return complex(a, -b)  # of Re X exp(iωt) = a cos ωt + b sin ωt


def _resonance(known: list[tuple[float, complex]]) -> tuple[complex, complex, complex]:
    """p, r and c of X(ω) = c + r/(ω − p) through the last three points."""
    (w1, X1), (w2, X2), (w3, X3) = known[-3:]
    # (X1 − X2)/(w2 − w1) = r/((w1 − p)(w2 − p)), and the same of 2 and 3: their ratio is (w3 − p)/(w1 − p).
    ratio = (X1 - X2) / (w2 - w1) * (w3 - w2) / (X2 - X3)
    p = (ratio * w1 - w3) / (ratio - 1.0)
    r = (X1 - X2) / (w2 - w1) * (w1 - p) * (w2 - p)
    return p, r, X1 - r / (w1 - p)


def _turn(known: list[tuple[float, complex]], omega: float) -> float:
    """By how much the phase of X grows from the last point to ω."""
    p, r, c = _resonance(known)
    return float(np.angle((c + r / (omega - p)) / known[-1][1]))


def _delayed(forces: Array, turn: float) -> Array:
    """λ (rows, 2H+1) of a motion whose first harmonic turns by an angle as a whole: harmonic h by h times as much."""
    turned = forces.copy()
    for h in range(1, (forces.shape[1] - 1) // 2 + 1):
        a, b = forces[:, 2 * h - 1], forces[:, 2 * h]
        c, s = np.cos(h * turn), np.sin(h * turn)
        turned[:, 2 * h - 1], turned[:, 2 * h] = c * a + s * b, c * b - s * a
    return turned
