"""The highest peak alone against all peaks of the same curve, each searched by itself."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.rigs import chain
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.sweep import swept_curve
from stickslip.solve.peaks.search import PeakSearch


@pytest.mark.parametrize("kind", ["amplitude", "max_abs"])
def test_the_highest_peak_is_found_with_fewer_solutions_than_all(kind):
    """A chain of twenty masses with three peaks: the highest is that of all, and lower hills are left as soon as they are."""
    balance, measure = HarmonicBalance(chain(), 3, 64), Measure(kind=kind)
    curve = swept_curve(balance, 1.0, (0.05, 0.35))
    every, alone = PeakSearch(balance, curve), PeakSearch(balance, curve)
    peaks, highest = every.peaks(0, measure), alone.highest(0, measure, 0.0)
    sizes = [measure.size(point.evaluation.w[balance.rows], point.point.omega) for point in peaks.points]
    assert len(sizes) > 1
    best = peaks.points[int(np.argmax(sizes))]
    (point,) = highest.points
    assert measure.size(point.evaluation.w[balance.rows], point.point.omega) == pytest.approx(max(sizes), rel=1e-8)
    assert point.point.omega == pytest.approx(best.point.omega, rel=1e-5)
    assert highest.unproven == ()
    assert alone.solves < 0.8 * every.solves


def test_rounding_of_an_output_that_rests_has_no_peaks():
    """Two equal masses with a gap between them: the second moves where the gap closes, at the resonances of both, and rests to
    1e-17 m elsewhere, where nine peaks of rounding were found."""
    structure = ss.Structure(M=np.eye(2), K=np.eye(2), C=0.02 * np.eye(2), dofs=("a.x", "b.x"))
    gap = ss.Contact("gap", ss.Gap(kn=1.0, gap=0.5), normal={"a.x": 1.0, "b.x": -1.0})
    problem = ss.Problem(structure, contacts=(gap,), forces=(ss.Force("a.x", 0.3),), outputs=("a.x", "b.x"))
    balance = HarmonicBalance(problem, 3, 256)
    curve = swept_curve(balance, 1.0, (0.5, 2.5))
    search = PeakSearch(balance, curve)
    sizes = [abs(point.evaluation.w[balance.rows + 1, 1:3]).max() for point in search.peaks(1).points]
    assert len(sizes) >= 2
    assert min(sizes) > 0.1
