"""The single blade at its peaks, harmonic balance against time integration; the table in the documentation is measured here."""

import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.model.rigs import single_blade

MEASURED = {
    (20.0, 543.77): {3: 2.1e-2, 5: 2.0e-2, 7: 2.2e-2, 11: 2.7e-3, 21: 1.1e-3, 41: 4e-5},
    (80.0, 534.56): {3: 1.7e-3, 5: 6.8e-4, 7: 1.5e-3, 11: 7.9e-4, 21: 3.0e-4, 41: 1e-5},
}
"""Force [N] and frequency [Hz]: relative difference of the first harmonic of the tip by number of harmonics."""


def difference(force, frequency, harmonics, samples, **options):
    response = forced_response(single_blade(4.6), [480.0, frequency], force, harmonics=harmonics, samples=samples)
    check = response.verify_in_time(0, 1, **options)
    assert check.periodic, check.sentence
    assert float(check.time.dataset.energy_residual) < 5e-5
    return abs(float(check.amplitude_difference[0]))


@pytest.mark.nightly
def test_five_harmonics_at_80_newton():
    """The cheap witness."""
    assert difference(80.0, 534.56, 5, 512, steps_per_period=1000, tolerance=1e-4) == pytest.approx(6.8e-4, rel=0.2)


@pytest.mark.verify
@pytest.mark.parametrize(("force", "frequency"), MEASURED)
def test_refined_harmonics_agree_with_time_integration(force, frequency):
    found = {
        h: difference(force, frequency, h, 4096 if h > 21 else 1024, steps_per_period=4000) for h in MEASURED[force, frequency]
    }
    for harmonics, expected in MEASURED[force, frequency].items():
        assert found[harmonics] == pytest.approx(expected, rel=0.2, abs=2e-5)
    assert found[41] < 1e-3
