"""Automatic choice of harmonics and samples: both are raised until the truncation error at the peaks is small."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace

import numpy as np

from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.continuation.more_harmonics import resolved
from stickslip.solve.continuation.truncation import Truncation, beside, enough_beyond, truncation_at
from stickslip.solve.curves.curve import solve_curve
from stickslip.solve.peaks.climb import plane_at
from stickslip.support.checks import InputError, between, fault, positive
from stickslip.support.machine import one_blas_thread

FIRST, MOST = 3, 63
SAMPLES_PER_HARMONIC = 8
MOVES = 1e-6
"""Amplitude of an output, relative to the largest, below which its peaks choose nothing."""

NEAR = 0.1
"""Relative distance within which a harmonic counts as near a mode."""
MOST_SAMPLES = 8192
"""Where doubling the samples ends, whatever it would still change."""


TRACING = 0.5
"""Progress at a level when its curve has been traced but its peaks are not yet solved with more harmonics."""

_WATCHED: ContextVar[Callable[[float, str], None]] = ContextVar("watched", default=lambda fraction, text: None)
"""The function that receives the progress of the choice, which is made where works are created; these take no such argument."""


@dataclass(frozen=True)
class HarmonicChoice:
    """H and Nt that suffice; truncation_error: the estimate that remains; what required H, and more samples."""

    harmonics: int
    samples: int
    truncation_error: float
    harmonic: str
    sampling: str = ""

    @property
    def sentence(self) -> str:
        """What asked for both."""
        return "; ".join(filter(None, (self.harmonic, self.sampling)))


def sufficient_harmonics(
    problem: Problem, frequencies: Sequence[float], levels: Sequence[float], tolerance: float = 2e-3, samples: int = 256
) -> HarmonicChoice:
    """The least number of harmonics beyond which more change the motion of contacts and outputs by less than `tolerance` at every
    peak, and the samples, doubled from `samples` on, whose error there is below it too.

    frequencies: the ends of the band, or the frequencies wanted, in Hz; levels: force levels. A curve with H = 3 finds the
    highest peak of each output and level (in a band without a peak the largest point); there H is raised, each solution padded,
    then Nt. The error of samples falls with their square: 4/3 of what twice as many change.
    """
    if not 0.0 < positive("tolerance", tolerance) < 0.5:
        raise fault("tolerance", "must lie between 0 and 0.5", tolerance, "It is relative; 2e-3 is usual.")
    between("samples", samples, SAMPLES_PER_HARMONIC)
    lowest = max([FIRST, *(harmonic for force in problem.forces for harmonic in force.amplitudes)])
    report, choices = _WATCHED.get(), []
    with one_blas_thread():
        for number, level in enumerate(levels):

            def traced(share: float, number: int = number, level: float = level) -> None:
                report((number + TRACING * share) / len(levels), f"force level {level:g}")

            for balance, evaluation in _worst_points(problem, frequencies, level, lowest, samples, traced):
                raised = _raised(problem, frequencies, balance, evaluation, tolerance, samples)
                choices.append(_sampled(problem, *raised, tolerance))
    if not choices:
        raise InputError(
            "A curve with few harmonics must exist to choose their number from, but none was found in the band. "
            "Give `harmonics` as a number."
        )
    choice = max(choices, key=lambda choice: (choice.harmonics, choice.truncation_error))
    finest = max(choices, key=lambda choice: (choice.samples, choice.sampling != ""))
    return replace(choice, samples=finest.samples, sampling=finest.sampling)


def _enough(problem: Problem, samples: int, harmonics: int) -> int:
    """The samples that a number of harmonics is tried with."""
    return problem.systems.enough_samples(max(samples, SAMPLES_PER_HARMONIC * harmonics))


@contextmanager
def watched(report: Callable[[float, str], None]) -> Iterator[None]:
    """Call report(fraction, text) while harmonics are chosen within the block, wherever they are."""
    token = _WATCHED.set(report)
    try:
        yield
    finally:
        _WATCHED.reset(token)


def _worst_points(
    problem: Problem,
    frequencies: Sequence[float],
    level: float,
    harmonics: int,
    samples: int,
    progress: Callable[[float], None] = lambda share: None,
) -> list[tuple[HarmonicBalance, Evaluation]]:
    """The highest peak of every output at a level, or the largest point of a curve without one."""
    balance = HarmonicBalance(problem, harmonics, _enough(problem, samples, harmonics))
    ends = [2.0 * np.pi * min(frequencies), 2.0 * np.pi * max(frequencies)]
    curve = solve_curve(balance, ends, level, ends[0] == ends[1], progress)
    found = []
    for output in range(len(problem.outputs)):
        if points := curve.tops(output):
            best = max(points, key=lambda point: _amplitude(balance, point.evaluation, output))
            found.append((_amplitude(balance, best.evaluation, output), best.evaluation))
    largest = max((amplitude for amplitude, _ in found), default=0.0)
    return [(balance, evaluation) for amplitude, evaluation in found if amplitude >= MOVES * largest]


def _amplitude(balance: HarmonicBalance, evaluation: Evaluation, output: int) -> float:
    return float(np.hypot(*evaluation.w[balance.rows + output, 1:3]))


def _raised(
    problem: Problem,
    frequencies: Sequence[float],
    balance: HarmonicBalance,
    evaluation: Evaluation,
    tolerance: float,
    samples: int,
) -> tuple[HarmonicChoice, Evaluation]:
    """H raised at one point until the estimate is below the tolerance, and the solution there; from a curve with the higher H
    where the padded solution leads to none.
    """
    reason = "no left-out harmonic matters"
    while True:
        H = balance.highest
        beyond = enough_beyond(H)
        finer = HarmonicBalance(problem, beyond, _enough(problem, samples, beyond))
        across = plane_at(balance, evaluation).at(0.0)
        estimate = truncation_at(balance, finer, evaluation, across)
        Nt = _enough(problem, samples, H)
        if estimate.total <= tolerance:
            return HarmonicChoice(H, Nt, estimate.total, f"{H} harmonics: {reason}"), evaluation
        if H >= MOST:
            text = f"{H} harmonics are the most tried; more would still change the motion by {estimate.total:.1e} of it"
            return HarmonicChoice(H, Nt, estimate.total, text), evaluation
        reason = _reason(problem, estimate, evaluation, tolerance)
        following = min(max(estimate.needed(tolerance), H + 2), MOST)
        balance = HarmonicBalance(problem, following, _enough(problem, samples, following))
        found = beside(balance, evaluation, across)
        solution = found.evaluation if found.solved else None
        if solution is None and (correction := resolved(balance, evaluation)).converged:
            solution = correction.evaluation
        if solution is not None:
            evaluation = solution
            continue
        peaks = _worst_points(problem, frequencies, evaluation.point.level, following, samples)
        if not peaks:
            text = f"{H} harmonics: the peak could not be solved with {following}; more change the motion by {estimate.total:.1e}"
            return HarmonicChoice(H, Nt, estimate.total, text), evaluation
        omega = evaluation.point.omega
        evaluation = min((peak for _, peak in peaks), key=lambda peak: abs(peak.point.omega - omega))


def _sampled(problem: Problem, choice: HarmonicChoice, evaluation: Evaluation, tolerance: float) -> HarmonicChoice:
    """Nt doubled at one point until the error of the motion of the contacts is below the tolerance.

    The error falls irregularly, as kinks lie near a sample or between two; it is not believed to fall faster than to a quarter.
    """
    error = 0.0
    while choice.samples < MOST_SAMPLES:
        twice = 2 * choice.samples
        finer = HarmonicBalance(problem, choice.harmonics, twice)
        correction = resolved(finer, evaluation)
        if not correction.converged:
            return replace(choice, sampling=f"with {twice} samples a peak could not be solved")
        before, evaluation = evaluation, correction.evaluation
        moved = evaluation.w[: finer.rows] - before.w[: finer.rows]
        size = max(float(np.linalg.norm(evaluation.w[: finer.rows])), np.finfo(float).tiny)
        error = max(4.0 / 3.0 * float(np.linalg.norm(moved)) / size, 0.25 * error)
        if error <= tolerance:
            return choice
        text = f"{twice} samples: with half as many the motion of the contacts would be {error:.1e} off"
        choice = replace(choice, samples=twice, sampling=text)
    most = f"{choice.samples} samples are the most tried; the motion of the contacts may still be {0.25 * error:.1e} off"
    return replace(choice, sampling=most) if error else choice


def _reason(problem: Problem, estimate: Truncation, evaluation: Evaluation, tolerance: float) -> str:
    """The highest harmonic that alone would miss the tolerance and what it would have done; else what fewer would have left."""
    alone = np.flatnonzero(estimate.share > tolerance)
    unit = evaluation.point.omega / (2.0 * np.pi)
    where = f"at {unit:.5g} Hz under force level {evaluation.point.level:g}"
    if not alone.size:
        return f"with fewer the motion {where} would be {estimate.total:.1e} off"
    harmonic = int(alone[-1]) + 1
    modes = problem.frequencies(stuck=True)
    nearest = float(modes[np.argmin(np.abs(modes - harmonic * unit))])
    beside = f", near the stuck mode at {nearest:.4g} Hz," if abs(nearest - harmonic * unit) <= NEAR * nearest else ""
    moved = f"{estimate.share[harmonic - 1]:.1e} of their motion {where}"
    return f"harmonic {harmonic} at {harmonic * unit:.4g} Hz{beside} would have moved the contacts by {moved}"
