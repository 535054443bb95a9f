"""How many harmonics are enough: H raised at the peaks until what is left out no longer matters, with the reason in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip.checks import InputError, fault, positive
from stickslip.harmonic.balance import Evaluation, HarmonicBalance
from stickslip.problem import Problem
from stickslip.solve.curve import solve_curve
from stickslip.solve.left_out import LeftOut, left_out, resolved

FIRST, MOST = 3, 63
MARGIN = 16
"""Harmonics beyond H whose left-out share is looked at, at least; twice H if that is more."""

SAMPLES_PER_HARMONIC = 8


@dataclass(frozen=True)
class HarmonicChoice:
    """H and Nt that suffice; left_out: the estimate that remains at the worst peak; sentence: which harmonic asked for it."""

    harmonics: int
    samples: int
    left_out: float
    sentence: str


def sufficient_harmonics(
    problem: Problem, frequencies: Sequence[float], levels: Sequence[float], tolerance: float = 2e-3, samples: int = 256
) -> HarmonicChoice:
    """The least number of harmonics whose left-out motion of the contacts is below `tolerance` at every peak.

    frequencies: the ends of the band, or the frequencies wanted, in Hz; levels: force levels. A curve with H = 3 finds the
    highest peak of each output and level (in a band without a peak the largest point); there H is raised, each solution padded.
    """
    if not 0.0 < positive("tolerance", tolerance) < 0.5:
        raise fault("tolerance", "must lie between 0 and 0.5", tolerance, "It is relative; 2e-3 is usual.")
    lowest = max([FIRST, *(harmonic for force in problem.forces for harmonic in force.amplitudes)])
    with threadpool_limits(1, user_api="blas"):
        choices = [
            _raised(problem, balance, evaluation, tolerance, samples)
            for level in levels
            for balance, evaluation in _worst_points(problem, frequencies, level, lowest, samples)
        ]
    if not choices:
        raise InputError(
            "A curve with few harmonics must exist to choose their number from, but none was found in the band. "
            "Give `harmonics` as a number."
        )
    return max(choices, key=lambda choice: (choice.harmonics, choice.left_out))


def _worst_points(
    problem: Problem, frequencies: Sequence[float], level: float, harmonics: int, samples: int
) -> list[tuple[HarmonicBalance, Evaluation]]:
    """The highest peak of every output at a level, or the largest point of a curve without one."""
    balance = HarmonicBalance(problem, harmonics, max(samples, SAMPLES_PER_HARMONIC * harmonics))
    ends = [2.0 * np.pi * min(frequencies), 2.0 * np.pi * max(frequencies)]
    curve = solve_curve(balance, ends, level, exactly=ends[0] == ends[1])
    found = []
    for output in range(len(problem.outputs)):
        peaks = curve.peaks[output] if curve.peaks else ()
        points = peaks or curve.points
        row = balance.rows + output
        if points:
            best = max(points, key=lambda point: float(np.hypot(*point.evaluation.w[row, 1:3])))
            found.append((balance, best.evaluation))
    return found


def _raised(problem: Problem, balance: HarmonicBalance, evaluation: Evaluation, tolerance: float, samples: int) -> HarmonicChoice:
    """H raised at one point until the estimate is below the tolerance."""
    reason = "no left-out harmonic matters"
    while True:
        H = balance.harmonics
        beyond = max(2 * H, H + MARGIN)
        finer = HarmonicBalance(problem, beyond, max(samples, SAMPLES_PER_HARMONIC * beyond))
        estimate = left_out(balance, finer, evaluation)
        Nt = max(samples, SAMPLES_PER_HARMONIC * H)
        if estimate.total <= tolerance:
            return HarmonicChoice(H, Nt, estimate.total, f"{H} harmonics: {reason}")
        if H >= MOST:
            text = f"{H} harmonics are the most tried; the left-out motion is still {estimate.total:.1e} of the whole"
            return HarmonicChoice(H, Nt, estimate.total, text)
        reason = _reason(problem, estimate, evaluation)
        following = min(max(estimate.needed(tolerance), H + 2), MOST)
        balance = HarmonicBalance(problem, following, max(samples, SAMPLES_PER_HARMONIC * following))
        correction = resolved(balance, evaluation)
        if not correction.converged:
            text = f"{H} harmonics: with {following} the peak could not be solved; left out is {estimate.total:.1e} of the whole"
            return HarmonicChoice(H, Nt, estimate.total, text)
        evaluation = correction.evaluation


def _reason(problem: Problem, estimate: LeftOut, evaluation: Evaluation) -> str:
    frequency = estimate.worst * evaluation.point.omega / (2.0 * np.pi)
    modes = problem.frequencies(stuck=True)
    nearest = float(modes[np.argmin(np.abs(modes - frequency))])
    return (
        f"harmonic {estimate.worst} at {frequency:.4g} Hz, near the stuck mode at {nearest:.4g} Hz, would have moved the "
        f"contacts by {estimate.share[estimate.worst - 1]:.1e} of their motion"
    )
