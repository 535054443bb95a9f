"""Forced motions solved at the peaks that a nonlinear mode synthesises: what the synthesis misses is known, not estimated."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.isolated import ModeMotions
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition
from stickslip.solve.balance.orders import of_attribute
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.support.units import um

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

ITERATIONS, HALVINGS = 30, 8

LEAST_RATIO, FINEST, MOST_STEPS = 1e-5, 1e-5, 40
"""Of a climb: the damping ratio that its first step has at least, its last step relative to the frequency, and steps at most."""

FARTHEST = 0.2
"""Relative distance in frequency beyond which a solution is that of another peak."""


def with_solved(table: pd.DataFrame, modes: xr.Dataset, problem: Problem, case: int, output: int) -> pd.DataFrame:
    """Peaks of `Synthesis.peaks` with solved_frequency [Hz] and solved_amplitude [m] of the first harmonic of the output; NaN
    where Newton's method does not arrive.

    The harmonic balance of the forced motion is solved from the motion of the mode, with the phase of the synthesis and the
    frequency as an unknown, and then beside it, upwards, until no frequency at either side has a larger amplitude.
    """
    balance = HarmonicBalance(problem, of_attribute(modes.attrs["harmonics"]), int(modes.attrs["samples"]))
    motions = ModeMotions.of(balance, modes, case)
    columns = ["force_level", "frequency", "modal_amplitude", "phase", "damping_ratio"]
    solved = [_solved(balance, motions, output, *row) for row in table[columns].to_numpy()]
    frequencies, amplitudes = np.array(solved).reshape(-1, 2).T
    return table.assign(solved_frequency=frequencies, solved_amplitude=amplitudes)


def _solved(
    balance: HarmonicBalance,
    motions: ModeMotions,
    output: int,
    level: float,
    hertz: float,
    amplitude: float,
    phase: float,
    ratio: float,
) -> tuple[float, float]:
    """Frequency [Hz] and amplitude [m] of one peak."""
    omega = 2.0 * np.pi * hertz
    place = float(np.interp(amplitude, motions.amplitude, np.arange(motions.amplitude.size)))
    start = motions.start(balance, place, float(motions.phase[int(place)]), level).point
    near = correct(balance, start, fixed("omega", omega), ITERATIONS, HALVINGS)
    for begin in (*((near.evaluation.point,) if near.converged else ()), start):
        solution = correct(balance, begin, _phase_of(balance, phase, output), ITERATIONS, HALVINGS)
        found = solution.evaluation.point.omega
        if solution.converged and abs(found / omega - 1.0) < FARTHEST:
            return _climbed(balance, solution.evaluation, output, abs(ratio))
    return np.nan, np.nan


def _climbed(balance: HarmonicBalance, begin: Evaluation, output: int, ratio: float) -> tuple[float, float]:
    """The peak above a point: steps in frequency from the half-power width on, shortened where neither side is higher, there from
    the top of the parabola through all three."""

    def size(evaluation: Evaluation) -> float:
        return float(np.hypot(*evaluation.w[balance.rows + output, balance.first]))

    def beside(change: float) -> Evaluation | None:
        solution = correct(balance, best.point, fixed("omega", best.point.omega + change))
        return solution.evaluation if solution.converged else None

    best, step = begin, max(ratio, LEAST_RATIO) * begin.point.omega
    sides: dict[float, Evaluation | None] = {}
    for _ in range(MOST_STEPS):
        if step < FINEST * best.point.omega:
            break
        sides |= {way: beside(way * step) for way in (-1.0, 1.0) if way not in sides}
        solved = {way: each for way, each in sides.items() if each is not None}
        higher = max(solved, key=lambda way: size(solved[way]), default=0.0)
        if solved and size(solved[higher]) > size(best):
            sides, best = {-higher: best}, solved[higher]
            continue
        if len(solved) == 2:
            low, middle, high = size(solved[-1.0]), size(best), size(solved[1.0])
            bend = 2.0 * middle - low - high
            top = beside(0.5 * step * (high - low) / bend) if bend > 0.0 else None
            best = best if top is None else max(best, top, key=size)
        sides, step = {}, (0.2 if len(solved) == 2 else 0.5) * step
    return best.point.omega / (2.0 * np.pi), size(best)


def _phase_of(balance: HarmonicBalance, phase: float, output: int) -> PathCondition:
    """The first harmonic x of an output, a real and a imaginary part a − ib, has a phase: Im(x exp(−i phase)) = 0, relative to
    the motion of a micrometre.
    """
    weight = np.zeros((balance.rows + len(balance.problem.outputs), balance.columns))
    weight[balance.rows + output, balance.first] = -np.sin(phase) / um, -np.cos(phase) / um
    return PathCondition("omega", weight, 0.0, 0.0)
