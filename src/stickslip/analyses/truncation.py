"""Errors of truncation and sampling at the highest peaks of a curve: estimates for every result, and the warning of the first."""

from __future__ import annotations

import numpy as np

from stickslip.checks import Array
from stickslip.curves.curve import Curve
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.measure import Measure
from stickslip.harmonic.orders import Harmonics, in_words
from stickslip.problem import Problem
from stickslip.solve.curve_points import CurvePoint
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

SAMPLES_PER_HARMONIC = 8

MORE_SAMPLES = 4
"""Times as many samples as the curve has show what sampling leaves, whose error falls with their square."""

SAME_PEAK = 1e-3
"""Peaks of several outputs within this relative distance in frequency are one place of the curve."""

MOST_UNKNOWNS = 3000
"""Size of the Newton matrix of the estimate: larger ones would cost as much as a curve, so that fewer harmonics are taken."""


def discretisation_errors(balance: HarmonicBalance, curve: Curve, measure: Measure) -> tuple[Array, Array]:
    """What more harmonics, and what more samples, would change of every output at its highest peak, else at the largest point:
    (outputs,) each; NaN without a point, and where the contacts that slip are so many that no harmonic beyond H can be looked at.

    Of the first harmonic where peaks are of its amplitude, else of all harmonics of the motion together.
    """
    outputs = range(len(balance.problem.outputs))
    errors, known = np.full((2, len(outputs)), np.nan), dict[float, Array]()
    for output in outputs:
        points = (curve.peaks and curve.peaks[output]) or curve.points
        if not points:
            continue
        row = balance.rows + output
        highest = max(points, key=lambda point: measure.size(point.evaluation.w[row], point.point.omega))
        omega = highest.point.omega
        near = next((other for other in known if abs(other - omega) <= SAME_PEAK * omega), omega)
        if near not in known:
            known[near] = _at_point(balance, highest, balance.first if measure.kind == "amplitude" else slice(1, None))
        errors[:, output] = known[near][:, output]
    return errors[0], errors[1]


def _at_point(balance: HarmonicBalance, point: CurvePoint, counted: slice) -> Array:
    """By harmonics and by samples, (2, outputs), with the same many samples, so that neither counts the other."""
    rows = max(point.active / balance.kept.size, 1.0)
    beyond = min(enough_beyond(balance.highest), int((MOST_UNKNOWNS / rows - 1.0) / 2.0))
    if beyond < balance.highest + 2:
        return np.full((2, len(balance.problem.outputs)), np.nan)
    finer = finer_balance(balance.problem, beyond, MORE_SAMPLES * balance.tables.E.shape[0])
    sampled = HarmonicBalance(balance.problem, balance.harmonics, finer.tables.E.shape[0])
    by_samples = change_by(sampled, balance, point.evaluation, counted)
    by_harmonics = change_by(finer, balance, point.evaluation, counted)
    by_harmonics[:, : by_samples.shape[1]] -= by_samples
    errors = np.array([np.linalg.norm(by_harmonics, axis=1), np.linalg.norm(by_samples, axis=1)])
    for k, (more, before) in enumerate([(finer, by_samples), (sampled, np.zeros_like(by_samples))]):
        large = errors[k] > ALLOWED
        if large.any():
            solved = solved_change(more, balance, point.evaluation, counted, before)
            errors[k] = np.where(large & np.isfinite(solved), solved, errors[k])
    return errors


def finer_balance(problem: Problem, harmonics: int, samples: int) -> HarmonicBalance:
    """The balance with more harmonics; samples: of the coarse one, at least."""
    enough = max(samples, SAMPLES_PER_HARMONIC * harmonics)
    return HarmonicBalance(problem, harmonics, enough + -enough % problem.systems.sample_multiple)


def truncation_warning(harmonics: Harmonics, outputs: tuple[str, ...], errors: Array) -> str:
    """What to say where the largest of the errors is not small; empty where it is."""
    if not np.any(errors > ALLOWED):
        return ""
    worst = int(np.nanargmax(errors))
    more = f"{'More' if isinstance(harmonics, int) else 'Others'} than {in_words(harmonics)}"
    much = f"by about {100.0 * errors[worst]:.1f} %" if errors[worst] < 1.0 else "by more than can be estimated"
    return f'{more} would change {outputs[worst]} at its highest peak {much}: take more, or harmonics = "auto".'
