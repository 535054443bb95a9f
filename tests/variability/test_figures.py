"""Every figure of response variability draws what it says, from small results."""

import pytest

from stickslip.analyses.friction_freedom import friction_freedom
from stickslip.analyses.response_bounds import response_bounds
from stickslip.analyses.response_history import response_history
from stickslip.analyses.response_samples import response_samples
from stickslip.checks import InputError
from stickslip.plots.response_bounds import contact_forces, force_ratios, loss_factors, start_states
from stickslip.plots.response_samples import response_cloud
from stickslip.rigs import three_mass_wedge
from stickslip.units import hertz


@pytest.fixture(scope="module")
def bounds():
    return response_bounds(three_mass_wedge(), [215.0, 222.0], [0.5, 1.0], cloud=4)


def test_bounds(bounds):
    figure = bounds.plot()
    assert len(figure.axes) == 2
    upper = figure.axes[1].lines[2]
    assert upper.get_ydata()[-1] == pytest.approx(62.28618, rel=1e-5)


def test_peaks_and_loss_factors(bounds):
    peak = response_bounds(three_mass_wedge(), hertz(200.0, 235.0), [0.5, 1.0], "peak", cloud=2, starts=1)
    amplitude, frequency = peak.plot().axes
    assert amplitude.get_ylabel().startswith("peak amplitude")
    assert frequency.lines[0].get_xdata().tolist() == [0.5, 1.0]
    assert len(loss_factors(bounds.dataset).axes[0].lines) == 4


def test_forces_and_start_states(bounds):
    chosen = contact_forces(bounds.dataset, 1, 222.0, ["blade 1 n"])
    assert chosen.axes[0].get_title(loc="left") == "blade 1 n"
    assert len(contact_forces(bounds.dataset, 1, 222.0).axes) == 4
    ratios = force_ratios(bounds.dataset, 1, 222.0).axes[0].lines
    assert max(abs(line.get_ydata()).max() for line in ratios) <= 0.5 * (1.0 + 1e-9)
    assert len(start_states(bounds.dataset).axes) == 3
    with pytest.raises(InputError, match="row must be one of"):
        contact_forces(bounds.dataset, rows=["blade 3 n"])


def test_cloud_with_bounds(bounds):
    samples = response_samples(three_mass_wedge(), hertz(210.0, 230.0), 1.0, 3)
    assert len(samples.plot(bounds=bounds.dataset).axes[0].lines) == 5
    assert len(response_cloud(samples.dataset).axes[0].lines) == 3


def test_history_and_freedom():
    history = response_history(three_mass_wedge(), [215.0, 222.0], [0.3, 2.0, 0.3])
    assert history.plot().axes[0].lines
    with pytest.raises(InputError, match="more than once"):
        history.plot(level=2.0)
    above, below = friction_freedom(three_mass_wedge(), [215.0, 222.0]).plot().axes
    assert above.get_ylabel() == "N"
    assert below.lines
