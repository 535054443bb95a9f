"""Automatic choice of harmonics and samples: both are raised until the truncation error of the curve is small.

Whether the samples of a period resolve contacts whose force changes within a small share of it.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace

import numpy as np

from stickslip.analyses.further_curves import SolvedCurve
from stickslip.analyses.isolated import searched
from stickslip.analyses.truncation import ALLOWED, AT_POINTS, FEW_POINTS, affordable, sampling_error
from stickslip.model.contact.point import Contact
from stickslip.model.problem import Problem
from stickslip.model.problem.contraction import contracts
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.continuation.truncation import Truncation, beside, enough_beyond, resolved, truncation_at
from stickslip.solve.curves.curve import Curve, solve_curve
from stickslip.solve.peaks.climb import plane_at
from stickslip.solve.peaks.search import TOLERANCE
from stickslip.support.checks import Array, InputError, between, fault, positive
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome

FEWEST = 1.0
"""Samples that a change of the force must spread over: peaks of one mass are off by 2e-7 at 3, 2.4e-4 at 1.2, 1.4e-3 at 0.6."""

RIPPLE, DEEPEST = 3.0, 0.2
"""Dips between maxima that samples make, as a multiple of what more samples change of their height, and the deepest that are
looked at: of two masses with ζ = 1e-4 and 256 samples, 15 maxima dip by up to 1.7 times that, and 1024 samples leave one."""

ENOUGH = 2.0
"""Samples that the advice makes of it."""


def sampling_warning(balance: HarmonicBalance, curve: Curve) -> str:
    """The contact whose force changes fastest at the highest peaks, or points, if samples are too few for it; else empty."""
    table, count = balance.table, balance.tables.E.shape[0]
    fewest, name = np.inf, ""
    for output in range(len(balance.problem.outputs)):
        points = curve.tops(output)
        if not points:
            continue
        highest = max(points, key=lambda point: float(np.hypot(*point.evaluation.w[balance.rows + output, balance.first])))
        velocity = highest.point.omega * np.hypot(*highest.evaluation.w[: balance.rows, 1:3].T)
        for number, contact in enumerate(balance.problem.contacts):
            own = velocity[table.first_row[number] : table.first_row[number] + len(contact.tangential)]
            spread = count * contact.law.passage(float(own.max(initial=0.0)))
            if spread < fewest:
                fewest, name = spread, contact.name
    if not fewest < FEWEST:
        return ""
    enough = 2 ** int(np.ceil(np.log2(count * ENOUGH / fewest)))
    return (
        f"The friction of {name} changes its sign within {fewest:.2g} of a sample: peak heights may be wrong, and false peaks "
        f"may appear. Use {enough} samples, or a law that changes more slowly."
    )


def fold_warning(balance: HarmonicBalance, curve: Curve) -> str:
    """What to say of a curve that turns back in frequency although there is one motion at each; else empty."""
    omegas = np.array([point.point.omega for point in curve.points])
    turns = np.flatnonzero(np.diff(np.sign(np.diff(omegas))) != 0.0) + 1
    if not turns.size or not contracts(balance.problem):
        return ""
    samples, hertz = balance.tables.E.shape[0], balance.hertz(float(omegas[turns[0]]))
    return (
        f"The curve turns back in frequency near {hertz:.6g} Hz, but friction under constant loads has one motion at each "
        f"frequency: {samples} samples are too few there. Take {2 * samples}."
    )


def without_ripples(balance: HarmonicBalance, curve: Curve) -> Curve:
    """The curve without the maxima that its samples make: of those between which it dips by less than a few times what more
    samples change of their height, only the highest is a peak. All stay points of the curve.

    Where friction is sampled and damping is light, a curve folds at each sample that an event passes, once on either side.
    """
    places = {id(point): k for k, point in enumerate(curve.points)}
    peaks = []
    for output, found in enumerate(curve.peaks):
        row = balance.rows + output
        sizes = np.array([curve.measure.size(point.evaluation.w[row], point.point.omega) for point in curve.points])
        kept: list[CurvePoint] = []
        for hill in _hills([places[id(peak)] for peak in found], sizes, DEEPEST):
            error = 0.0
            if len(hill) > 1:
                highest = max(hill, key=lambda k: sizes[k])
                error = sampling_error(balance, curve.points[highest], output, curve.measure)
            dip = RIPPLE * error if np.isfinite(error) else 0.0
            kept += [curve.points[max(part, key=lambda k: sizes[k])] for part in _hills(hill, sizes, dip)]
        peaks.append(tuple(kept))
    return replace(curve, peaks=tuple(peaks))


def _hills(places: Sequence[int], sizes: Array, dip: float) -> list[list[int]]:
    """Maxima, by their places along the curve in order, in groups within which it dips by no more than a share of the lower."""
    groups: list[list[int]] = []
    for k in sorted(places):
        if groups and _on_one_hill(sizes[groups[-1][-1] : k + 1], dip):
            groups[-1].append(k)
        else:
            groups.append([k])
    return groups


def _on_one_hill(sizes: Array, dip: float) -> bool:
    """Whether a curve dips by no more than a share between two maxima, its ends. A shoulder of a hill that is much higher is a
    peak of its own: no point between the two is lower, and only the search has seen the dip."""
    low, high = sorted((sizes[0], sizes[-1]))
    shoulder = sizes.min() >= low and low < (1.0 - DEEPEST) * high
    return bool(sizes.min() >= (1.0 - dip) * low and not shoulder)


def broken_warning(contacts: Sequence[Contact], samples: int, curve: Curve, open_share: Array) -> str:
    """The advice for a curve that broke off where contacts with friction, which is sampled, open and close; open_share (point,
    ...): of the period, at each."""
    if not any(contact.law.rubs for contact in contacts):
        return ""
    solved = open_share[np.isfinite(open_share).any(axis=tuple(range(1, open_share.ndim)))]
    if curve.outcome == Outcome.CONVERGED or not np.any((solved[-1:] > 0.0) & (solved[-1:] < 1.0)):
        return ""
    return (
        f"Contacts open and close where it ended: where damping is light, {samples} samples may be too few for them. Try "
        f"{4 * samples}."
    )


def samples_warning(samples: int, outputs: tuple[str, ...], errors: Array) -> str:
    """What to say where the change by more samples is not small; empty where it is."""
    if not np.any(errors > ALLOWED):
        return ""
    worst = int(np.nanargmax(errors))
    enough = 2 ** int(np.ceil(np.log2(samples * np.sqrt(errors[worst] / ALLOWED)))) if errors[worst] < 1.0 else 8 * samples
    return (
        f"More than {samples} samples would change {outputs[worst]} at its highest peak by about "
        f"{100.0 * errors[worst]:.1f} %: take {max(enough, 2 * samples)}."
    )


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
    problem: Problem,
    frequencies: Sequence[float],
    levels: Sequence[float],
    tolerance: float = 2e-3,
    samples: int = 256,
    detached: bool = False,
) -> HarmonicChoice:
    """The least number of harmonics beyond which more change the motion of contacts and outputs by less than `tolerance` along
    the curve, and the samples, doubled from `samples` on, whose error there is below it too.

    frequencies: the ends of the band, or the frequencies wanted, in Hz; levels: force levels. A curve with H = 3 finds the
    highest peak of each output and level (in a band without a peak the largest point), and of some points along it the one that
    needs the most harmonics; there H is raised, each solution padded, then Nt. The error of samples falls with their square: 4/3
    of what twice as many change. detached: whether curves that the sweep does not meet are sought, and choose, too.
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

            for balance, evaluation in _worst_points(problem, frequencies, level, lowest, samples, tolerance, detached, traced):
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
    tolerance: float,
    detached: bool = False,
    progress: Callable[[float], None] = lambda share: None,
) -> list[tuple[HarmonicBalance, Evaluation]]:
    """Of each curve at a level the highest peak of every output, or the largest point of one without a peak, and the point beside
    them that needs the most harmonics."""
    balance = HarmonicBalance(problem, harmonics, _enough(problem, samples, harmonics))
    ends = [2.0 * np.pi * min(frequencies), 2.0 * np.pi * max(frequencies)]
    swept = solve_curve(balance, ends, level, ends[0] == ends[1], progress)
    curves = [swept]
    if detached and swept.outcome == Outcome.CONVERGED:
        solved = SolvedCurve(balance, list(swept.points), level, (ends[0], ends[1]), TOLERANCE, swept.measure, 1)
        curves += searched(solved)[0]
    return [(balance, evaluation) for curve in curves for evaluation in _worst_of(balance, curve, tolerance)]


def _worst_of(balance: HarmonicBalance, curve: Curve, tolerance: float) -> list[Evaluation]:
    """The points of one curve that choose the harmonics."""
    found = []
    for output in range(len(balance.problem.outputs)):
        if points := curve.tops(output):
            best = max(points, key=lambda point: _amplitude(balance, point.evaluation, output))
            found.append((_amplitude(balance, best.evaluation, output), best.evaluation))
    largest = max((amplitude for amplitude, _ in found), default=0.0)
    return [
        *(evaluation for amplitude, evaluation in found if amplitude >= MOVES * largest),
        *_worst_along(balance, curve, tolerance),
    ]


def _worst_along(balance: HarmonicBalance, curve: Curve, tolerance: float) -> Iterator[Evaluation]:
    """Of points of a curve, evenly chosen, the one that needs the most harmonics; none where those of the balance suffice, or
    where so many contacts slip that this is not known."""
    inside = curve.inside
    finer = affordable(balance, inside, AT_POINTS)
    if finer is None:
        return
    worst, most = None, (0, tolerance)
    for k in np.unique(np.linspace(0, len(inside) - 1, min(FEW_POINTS, len(inside))).round().astype(int)):
        estimate = truncation_at(balance, finer, inside[k].evaluation, inside[k].across("omega"))
        if estimate.total > tolerance and (needs := (estimate.needed(tolerance), estimate.total)) > most:
            worst, most = inside[k].evaluation, needs
    if worst is not None:
        yield worst


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
    reason = "no omitted harmonic matters"
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
            text = f"{H} harmonics, the most that are tried; more would change the motion by a further {estimate.total:.1e}"
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
        peaks = _worst_points(problem, frequencies, evaluation.point.level, following, samples, tolerance)
        if not peaks:
            text = f"{H} harmonics: the peak could not be solved with {following}; more would change it by {estimate.total:.1e}"
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
        text = f"{twice} samples: half as many leave an error of {error:.1e} in the motion of the contacts"
        choice = replace(choice, samples=twice, sampling=text)
    most = f"{choice.samples} samples, the most that are tried; the error of the contact motion may be {0.25 * error:.1e}"
    return replace(choice, sampling=most) if error else choice


def _reason(problem: Problem, estimate: Truncation, evaluation: Evaluation, tolerance: float) -> str:
    """The highest harmonic that alone would miss the tolerance and what it would have done; else what fewer would have left."""
    alone = np.flatnonzero(estimate.share > tolerance)
    unit = evaluation.point.omega / (2.0 * np.pi)
    where = f"at {unit:.5g} Hz under force level {evaluation.point.level:g}"
    if not alone.size:
        return f"fewer leave an error of {estimate.total:.1e} in the motion {where}"
    harmonic = int(alone[-1]) + 1
    modes = problem.frequencies(stuck=True)
    nearest = float(modes[np.argmin(np.abs(modes - harmonic * unit))])
    beside = f", near the stuck mode at {nearest:.4g} Hz," if abs(nearest - harmonic * unit) <= NEAR * nearest else ""
    moved = f"{estimate.share[harmonic - 1]:.1e} {where}"
    return f"harmonic {harmonic} at {harmonic * unit:.4g} Hz{beside} changes the motion of the contacts by {moved}"
