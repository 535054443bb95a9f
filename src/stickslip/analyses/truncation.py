"""Errors of harmonics, samples and modes at the highest peaks of a curve: numbers for every result, and their warnings."""

from __future__ import annotations

import numpy as np

from stickslip.checks import Array
from stickslip.curves.curve import Curve
from stickslip.harmonic.balance import HarmonicBalance, PathCondition
from stickslip.harmonic.measure import Measure
from stickslip.harmonic.orders import Harmonics, in_words
from stickslip.solve.all_modes import solved_on_all_modes
from stickslip.solve.curve_points import CurvePoint
from stickslip.solve.more_harmonics import STEPS
from stickslip.solve.newton import fixed
from stickslip.solve.truncation import change_by, enough_beyond, solved_change

ALLOWED = 0.004
"""The estimate above which a curve comes with a warning: the change by many more harmonics was up to 2.3
times as large on ready rigs (docs/choose.md), so 1 % does not pass without one.
"""

TRUNCATION_ERROR = {
    "units": "1",
    "long_name": "change of the output at its highest peak by more harmonics, estimated",
}

SAMPLING_ERROR = {
    "units": "1",
    "long_name": "change of the output at its highest peak by more samples, estimated",
}

MODAL_ERROR = {
    "units": "1",
    "long_name": "relative change of the output at its highest peak when it is solved on all modes of the structure",
}

SAMPLES_PER_HARMONIC = 8

MORE_SAMPLES = 4
"""Times as many samples as the curve has show what sampling leaves, whose error falls with their square."""

SAME_PEAK = 1e-3
"""Peaks of several outputs within this relative distance in frequency are one place of the curve."""

MOST_UNKNOWNS = 3000
"""Size of the Newton matrix of the estimate: larger ones would cost as much as a curve, so that fewer harmonics are taken."""


LEAST_SPENT = 3e10
"""(Rows of the Newton matrix)³ times steps that the estimate may take, two seconds of computing or so; more where the curve took
more."""


def discretisation_errors(balance: HarmonicBalance, curve: Curve, measure: Measure) -> tuple[Array, Array]:
    """What more harmonics, and what more samples, would change of every output at its highest peak, else at the largest point:
    (outputs,) each; NaN without a point, and where the contacts that slip are so many that no harmonic beyond H can be looked at.

    Of the first harmonic where peaks are of its amplitude, else of all harmonics of the motion together.
    """
    errors, known = np.full((2, len(balance.problem.outputs)), np.nan), dict[float, Array]()
    spent = max(LEAST_SPENT, sum(float(point.iterations) * point.active**3 for point in curve.points))
    counted = balance.first if measure.kind == "amplitude" else slice(1, None)
    for output, highest in highest_points(balance, curve, measure).items():
        omega = highest.point.omega
        near = next((other for other in known if abs(other - omega) <= SAME_PEAK * omega), omega)
        if near not in known:
            known[near] = _at_point(balance, highest, counted, spent)
        errors[:, output] = known[near][:, output]
    return errors[0], errors[1]


def highest_points(balance: HarmonicBalance, curve: Curve, measure: Measure) -> dict[int, CurvePoint]:
    """The highest peak of each output, else the largest point; outputs without a point are left out."""
    found = {}
    for output in range(len(balance.problem.outputs)):
        points, row = (curve.peaks and curve.peaks[output]) or curve.points, balance.rows + output
        if points:
            found[output] = max(points, key=lambda point: measure.size(point.evaluation.w[row], point.point.omega))
    return found


def modal_errors(whole: HarmonicBalance, few: HarmonicBalance, curve: Curve, measure: Measure) -> Array:
    """The relative change of each output (outputs,) at its highest peak on all modes; few: the balance of the curve.

    The peak of all modes is a little beside that of the few. There the phase of the output is the same in the first order, while
    its amplitude is at its maximum; so the output is solved at the phase it had, with the frequency as an unknown. Outputs whose
    curve has no peak are solved at the frequency of their largest point. NaN where Newton's method does not arrive.
    """
    errors = np.full(len(few.problem.outputs), np.nan)
    for output, highest in highest_points(few, curve, measure).items():
        point, w, row = highest.point, highest.evaluation.w, few.rows + output
        condition = fixed("omega", point.omega)
        if curve.peaks and curve.peaks[output]:
            weight, (a, b) = np.zeros_like(w), w[row, few.first]
            weight[row, few.first] = np.array([-b, a]) / (a * a + b * b)
            condition = PathCondition("omega", weight, 0.0, 0.0)
        solution = solved_on_all_modes(whole, few, point, condition)
        if solution is not None:
            errors[output] = measure.size(solution.w[row], solution.point.omega) / measure.size(w[row], point.omega) - 1.0
    return errors


def _at_point(balance: HarmonicBalance, point: CurvePoint, counted: slice, spent: float) -> Array:
    """By harmonics and by samples, (2, outputs), with the same many samples, so that neither counts the other; spent: as
    `LEAST_SPENT`."""
    rows = min(max(point.active / balance.kept.size, 1.0), balance.problem.structure.size)
    beyond = min(enough_beyond(balance.highest), int((MOST_UNKNOWNS / rows - 1.0) / 2.0))
    if beyond < balance.highest + 2:
        return np.full((2, len(balance.problem.outputs)), np.nan)
    finer = finer_balance(balance, beyond)
    sampled = HarmonicBalance(balance.problem, balance.harmonics, finer.tables.E.shape[0])
    by_samples = change_by(sampled, balance, point.evaluation, counted)
    by_harmonics = change_by(finer, balance, point.evaluation, counted)
    by_harmonics[:, : by_samples.shape[1]] -= by_samples
    errors = np.array([np.linalg.norm(by_harmonics, axis=1), np.linalg.norm(by_samples, axis=1)])
    for k, (more, before) in enumerate([(finer, by_samples), (sampled, np.zeros_like(by_samples))]):
        large = errors[k] > ALLOWED
        if large.any():
            steps = min(STEPS, int(spent / (rows * more.kept.size) ** 3))
            solved = solved_change(more, balance, point.evaluation, counted, before, steps)
            errors[k] = np.where(large & np.isfinite(solved), solved, errors[k])
    return errors


def finer_balance(balance: HarmonicBalance, beyond: int) -> HarmonicBalance:
    """The balance with all harmonics up to `beyond` and more samples. The mean stays out where a list leaves it out: it is zero
    there, and where friction alone holds a body it would make the matrix singular."""
    harmonics = beyond if balance.kept[0] == 0 else tuple(range(1, beyond + 1))
    samples = max(MORE_SAMPLES * balance.tables.E.shape[0], SAMPLES_PER_HARMONIC * beyond)
    return HarmonicBalance(balance.problem, harmonics, samples + -samples % balance.problem.systems.sample_multiple)


def truncation_warning(harmonics: Harmonics, outputs: tuple[str, ...], errors: Array) -> str:
    """What to say where the largest of the errors is not small; empty where it is."""
    if not np.any(errors > ALLOWED):
        return ""
    worst = int(np.nanargmax(errors))
    more = f"{'More' if isinstance(harmonics, int) else 'Others'} than {in_words(harmonics)}"
    much = f"by about {100.0 * errors[worst]:.1f} %" if errors[worst] < 1.0 else "by more than can be estimated"
    return f'{more} would change {outputs[worst]} at its highest peak {much}: take more, or harmonics = "auto".'


def modal_warning(outputs: tuple[str, ...], errors: Array) -> str:
    """What to say where all modes change a highest peak, or where it was not solved on them; empty where neither is so."""
    if np.isnan(errors).all():
        return "The highest peak could not be solved on all modes of the structure: the effect of those left out is unknown."
    worst = int(np.nanargmax(np.abs(errors)))
    if not abs(errors[worst]) > ALLOWED:
        return ""
    return f"All modes of the structure change {outputs[worst]} at its highest peak by {100.0 * errors[worst]:.1f} %."
