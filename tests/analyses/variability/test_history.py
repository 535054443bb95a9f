"""A loading history leaves its traces in the sliders, and only there where something has stuck since."""

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.variability.samples import response_history
from stickslip.model.contact.point import SliderOffset
from stickslip.model.rigs import single_blade, single_mass, three_mass_wedge
from stickslip.support.checks import InputError
from stickslip.support.units import hertz


@pytest.fixture(scope="module")
def history():
    """The published procedure on the rig: increasing forces, then back; 20 N before and after 100 N."""
    return response_history(single_blade(4.6), hertz(520.0, 575.0), (1.0, 5.0, 20.0, 100.0, 20.0, 5.0, 1.0), points=56)


@pytest.mark.slow
def test_a_passage_through_a_high_force_changes_what_follows(history):
    """The response at 20 N is another one after 100 N, with other mean contact forces, all inputs alike."""
    changed = history.change(20.0)
    assert abs(changed["amplitude"]) > 1e-3
    assert changed["frequency"] >= 1.0
    assert changed["mean_force"] > 0.2
    low = history.change(5.0)
    assert low["frequency"] > changed["frequency"]
    assert low["mean_force"] > changed["mean_force"]


def test_everything_converged_and_is_labelled(history):
    dataset = history.dataset
    assert np.all(dataset.outcome == 1)
    assert dataset.sizes["run"] == 7
    assert dataset.amplitude.attrs["units"] == "m"
    assert np.all(np.isfinite(dataset.slider))


def test_one_slipping_mass_forgets():
    """A single slider that slips has no memory: up and down are the same."""
    history = response_history(single_mass(), [0.15, 0.16, 0.17, 0.18], (0.5, 1.0, 2.0, 1.0, 0.5)).dataset
    np.testing.assert_allclose(history.amplitude[1], history.amplitude[3], rtol=1e-9)


def test_carried_sliders_start_the_same_solution():
    """A forced response that starts from the sliders of a point gives that point again."""
    wedge = three_mass_wedge(SliderOffset(1e-4))
    history = response_history(wedge, [222.0], [1.0]).dataset
    sliders = history.slider.values[0]
    starts = iter(sliders)
    again = wedge.with_contacts(lambda contact: contact.with_start(SliderOffset(float(next(starts)))))
    found = forced_response(again, [222.0]).dataset
    assert float(found.amplitude[0, 0, 0]) == pytest.approx(float(history.amplitude[0, 0, 0]), rel=1e-9)


def test_wrong_input_is_refused(history):
    with pytest.raises(InputError, match="level must be one of"):
        history.change(7.0)
    with pytest.raises(InputError, match="force must hold at least one level"):
        response_history(single_mass(), [0.1], [])
