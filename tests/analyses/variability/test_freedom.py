"""The admissible interval of stuck elements: closed forms, and that its ends are what the response may use."""

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.variability.freedom import friction_freedom
from stickslip.model.contact.point import SliderOffset
from stickslip.model.rigs import single_mass, three_mass_wedge


def test_constant_load_interval():
    """T0 anywhere in [−μN + T̂, μN − T̂] for a stuck element with dynamic amplitude T̂; none once it slips."""
    dataset = friction_freedom(single_mass(kt=1.0, limit=1.0), [0.05, 0.1], 0.4).dataset
    amplitude = dataset.amplitude.values
    np.testing.assert_allclose(dataset.high.values[:, 0], 1.0 - amplitude, rtol=1e-3)
    np.testing.assert_allclose(dataset.low.values, -dataset.high.values, rtol=1e-3)
    slipping = friction_freedom(single_mass(kt=1.0, limit=1.0), [0.16], 2.0).dataset
    np.testing.assert_array_equal(slipping.low.values, slipping.high.values)
    assert np.all(slipping.carried.values == 0.0)


def test_slope_is_that_of_the_response():
    """The slope at any start state against differences of slider offsets: dy = −kt ds."""
    sliders, kt = np.array([1e-4, -0.5e-4]), 3e5

    def wedge(values):
        offsets = iter(values)
        return three_mass_wedge().with_contacts(lambda contact: contact.with_start(SliderOffset(float(next(offsets)))))

    freedom = friction_freedom(wedge(sliders), [222.0]).dataset
    stuck = int(np.argmax(np.abs(freedom.slope.values[0])))
    step = 1e-9 * (np.arange(2) == stuck)
    high, low = (float(forced_response(wedge(sliders + d), [222.0]).dataset.amplitude[0, 0, 0]) for d in (step, -step))
    assert freedom.slope.values[0, stuck] == pytest.approx(-(high - low) / (2.0 * kt * 1e-9), rel=1e-5)


def test_ranking_names_the_contacts_that_matter():
    ranking = friction_freedom(three_mass_wedge(0.0), [145.0, 222.0]).ranking(222.0)
    assert ranking[0][1] > 0.1
    assert {name for name, _ in ranking} == {"blade 1 t1", "blade 2 t1"}


def test_ranking_looks_along_the_whole_curve():
    """Without a frequency each row counts where it carries most, not only at the largest amplitude, where it may slip."""
    freedom = friction_freedom(three_mass_wedge(0.0), [215.0, 222.0])
    sizes = dict(zip((215.0, 222.0), freedom.dataset.amplitude.values.tolist(), strict=True))
    at = {f: dict(freedom.ranking(f)) for f in sizes}
    for name, share in freedom.ranking():
        assert share == pytest.approx(max(at[f][name] * sizes[f] for f in sizes) / max(sizes.values()))
