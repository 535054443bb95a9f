"""The blade with two semi-cylinders: the trends of "Effect of Variation in Contact
Friction on the Performance of the Under-Platform Dampers" (sections 2 and 3), and the band over start states.
"""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.performance.curve import performance_band
from stickslip.model.rigs.single_blade import DRY, OILED

RATIOS = (1.0, 2.0, 4.0, 8.0, 15.0, 170.0)
STICK_SIDE = slice(1, 5)


@pytest.fixture(scope="module")
def curves():
    def curve(pull, mu):
        rig = ss.rigs.two_semi_cylinders(pull, mu)
        return ss.performance_curve(rig, RATIOS, harmonics=3, check_every=9, quantity="inertance").dataset.isel(case=0)

    return {(pull, mu): curve(pull, mu) for pull, mu in ((56.0, DRY), (56.0, OILED), (206.0, DRY))}


@pytest.mark.slow
def test_less_friction_lowers_amplitude_and_frequency_on_the_stick_side(curves):
    dry, oiled = curves[56.0, DRY], curves[56.0, OILED]
    assert np.all(oiled.normalised_amplitude.values[STICK_SIDE] < dry.normalised_amplitude.values[STICK_SIDE])
    beyond_flat_tops = slice(2, 5)
    assert np.all(oiled.frequency.values[beyond_flat_tops] < dry.frequency.values[beyond_flat_tops])


def test_less_friction_shrinks_the_stick_region(curves):
    """At F_C/F_E = 170 the dry contacts stick, those oiled do not yet: they do from 210 on."""
    assert float(curves[56.0, DRY].region[-1]) == 0.0
    assert float(curves[56.0, OILED].region[-1]) > 0.0


def test_more_excitation_lowers_the_inertance_until_the_optimum(curves):
    for dataset in curves.values():
        assert np.all(np.diff(dataset.normalised_amplitude.values[STICK_SIDE]) > 0.0)


def test_more_load_lowers_the_amplitude_and_raises_the_frequency(curves):
    light, heavy = curves[56.0, DRY], curves[206.0, DRY]
    assert np.all(heavy.normalised_amplitude.values[STICK_SIDE] < light.normalised_amplitude.values[STICK_SIDE])
    assert np.all(heavy.frequency.values > light.frequency.values)


def test_what_rubs_dissipates_and_energy_balances(curves):
    for dataset in curves.values():
        assert float(dataset.energy_residual.max()) < 1e-8
        assert float(dataset.slip_work_error.max()) < 1e-3
        assert np.all(dataset.dissipated.values[dataset.contact_region.values == 0] == 0.0)


@pytest.mark.slow
def test_band_over_start_states_holds_the_virgin_peak():
    """The wedge whose first peak is practically unique in the start state, and whose second is not."""
    rig = ss.rigs.three_mass_wedge(ss.SliderOffset())
    band = performance_band(rig, [4.0, 8.0], band=ss.hertz(200.0, 235.0), cloud=6, starts=1, harmonics=3, samples=128)
    found = band.dataset
    assert band.plot().axes
    low, high = found.amplitude_per_force.values.T
    assert np.all(low <= found.virgin_amplitude_per_force.values * (1 + 1e-6))
    assert np.all(high >= found.virgin_amplitude_per_force.values * (1 - 1e-6))
    assert np.all(high > 1.2 * low)
    with pytest.raises(ss.InputError, match="force_ratio must be positive"):
        performance_band(rig, [0.0])


@pytest.mark.parametrize("pull", [26.0, 56.0])
def test_oil_lowers_the_response_curves_at_both_preloads(pull):
    """Section 3 and figure 7 of the paper: with oil, amplitude and frequency of the resonance are lower at both static loads."""
    peaks = []
    for mu in (DRY, OILED):
        table = ss.forced_response(
            ss.rigs.two_semi_cylinders(pull, mu), ss.hertz(400, 500), 5.0, harmonics=1, samples=128
        ).peaks()
        peaks.append(table.loc[table.amplitude.idxmax()])
    dry, oiled = peaks
    assert oiled.amplitude * oiled.frequency**2 < 0.8 * dry.amplitude * dry.frequency**2
    assert oiled.frequency < dry.frequency
