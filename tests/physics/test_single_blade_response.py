"""Response of the single blade with two dampers, virgin start, 5 harmonics: the case the package is built for.

80 N at 4.6 kg: 528.7 Hz, from the calibration of the rig by an independent script of this project (published: 529 Hz).
"""

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.model.rigs import single_blade
from stickslip.support.outcome import Outcome
from stickslip.support.units import hertz

LEVELS = [1.0, 5.0, 20.0, 50.0, 80.0, 100.0]


@pytest.fixture(
    scope="module", params=[pytest.param(2.6, marks=pytest.mark.nightly), 4.6, pytest.param(6.6, marks=pytest.mark.nightly)]
)
def response(request):
    return request.param, forced_response(single_blade(request.param), hertz(480.0, 600.0), LEVELS, harmonics=5)


def test_every_point_converged(response):
    dataset = response[1].dataset
    assert np.all(dataset.case_outcome == Outcome.CONVERGED)
    assert np.all(dataset.outcome.where(dataset.outcome != Outcome.EMPTY, Outcome.CONVERGED) == Outcome.CONVERGED)
    last = dataset.frequency.max("point")
    np.testing.assert_allclose(last, 600.0, rtol=1e-12)
    assert float(dataset.residual.max()) < 1e-10


def test_energy_numbers(response):
    dataset = response[1].dataset
    assert float(dataset.energy_residual.max()) < 1e-8
    assert float(dataset.slip_work_error.max()) < 1e-3
    assert float(dataset.dissipated.min()) > -1e-6 * float(dataset.dissipated.max())


def test_friction_softens_and_limits(response):
    """The resonance falls from the stuck frequency with the force and stays above the free one."""
    mass, found = response
    peaks, dataset = found.peaks(), found.dataset
    frequencies = peaks[peaks.peak == 0].frequency.to_numpy()
    stuck = float(dataset.natural_frequency_stuck[0])
    assert np.all(np.diff(frequencies) < 0.0)
    assert np.all((frequencies < stuck * 1.001) & (frequencies > 410.0))
    if mass == 4.6:
        assert stuck == pytest.approx(561.1, rel=2e-3)
        assert frequencies[LEVELS.index(80.0)] == pytest.approx(528.7, rel=3e-3)


def test_dampers_that_are_seated_before_friction_acts(response):
    """All elements of the cylinders close, so that the stuck frequency is that of small forces."""
    mass, found = response
    if mass == 4.6:
        change = found.dataset.history_change.sel(output="blade/tip.x").values
        assert change[[LEVELS.index(force) for force in (1.0, 80.0)]] == pytest.approx([-0.22, 0.025], abs=2e-3)
        other = str(found.dataset.case_message.values[0]).partition("(as computed), ")[2]
        assert float(other.split(" at ")[1].split(" Hz")[0]) == pytest.approx(560.8, abs=0.05)
        assert "551.68 Hz instead of 561.09 Hz" in found.dataset.attrs["static_history"]
