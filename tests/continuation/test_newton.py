"""What Newton's method reports of its way to a solution."""

import numpy as np

from stickslip.model.rigs import single_mass
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.newton import TOLERANCE, correct, fixed


def test_the_history_shows_each_error_and_step():
    """Shortened steps first; none increases the error; full steps at the end. A solved point has its start alone."""
    balance = HarmonicBalance(single_mass(), 7, 128)
    found = correct(balance, balance.stuck_point(1.0, 3.0), fixed("omega", 1.0), iterations=20, halvings=8)
    errors, lengths = found.history.T
    assert found.converged
    assert found.iterations == len(errors) - 1 > 2
    assert errors[-1] == found.evaluation.error < TOLERANCE
    assert np.all(np.diff(errors) < 0.0)
    assert lengths[0] == 0.0
    assert lengths[-1] == 1.0
    assert set(lengths[1:]) <= {2.0**-k for k in range(9)}
    again = correct(balance, found.evaluation.point, fixed("omega", 1.0))
    assert again.iterations == 0
    assert again.history.tolist() == [[again.evaluation.error, 0.0]]
