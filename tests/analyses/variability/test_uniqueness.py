"""Where everything sticks and stays closed, or everything slips, the response is unique: bounds and cloud fall together."""

import numpy as np
import pytest

from stickslip.analyses.variability.bounds import response_bounds
from stickslip.analyses.variability.samples import response_samples
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.rigs import three_mass_wedge


def stuck():
    wide = Macroslip(3e5, 50.0, 3e5)
    return three_mass_wedge().with_contacts(lambda contact: contact.with_law(wide))


@pytest.mark.parametrize(("problem", "force"), [(stuck(), 0.2), (three_mass_wedge(), 8.0)], ids=["all stuck", "all slip"])
def test_bounds_fall_together(problem, force):
    """The sliders of the stuck wedge may not go so far that a contact opens: the pull holds 120 N."""
    share = 2e-4 if force < 1.0 else 1.0
    variables = share * np.random.default_rng(0).uniform(-1.0, 1.0, (6, 2))
    cloud = response_samples(problem, [222.0], force, variables).dataset.amplitude.values[:, 0, 0]
    assert np.ptp(cloud) < 1e-9 * cloud.mean()
    if force > 1.0:
        bounds = response_bounds(problem, [222.0], force).dataset.amplitude.values.ravel()
        assert np.ptp(bounds) < 1e-9 * bounds.mean()
        assert bounds.mean() == pytest.approx(cloud.mean(), rel=1e-9)
