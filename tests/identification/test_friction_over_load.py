"""Friction over the normal load from loops: the table and the power that were put in, from several loads and one that varies."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.laboratory.identification.contact_law.work import sentences
from stickslip.show.report.identification import law_tables as tables
from stickslip.support.checks import InputError
from verify.identification import loop_of

KT, LOADS = 20e6, np.array([20.0, 60.0, 180.0])
FALLING = np.array([0.6, 0.45, 0.33])


def records(mu, seed=0, law=(1.0,), loads=LOADS):
    """A record of four cycles at each load, 400 samples a cycle, noise of 0.03 µm and 0.1 N."""
    generator, found = np.random.default_rng(seed), []
    for load, one in zip(loads, mu, strict=True):
        loops = [loop_of(np.array(law), KT, one, load, 3.0 * one * load / KT) for _ in range(4)]
        u, force = (np.concatenate(signals) for signals in zip(*loops, strict=True))
        u, force = u + 0.03e-6 * generator.standard_normal(u.size), force + 0.1 * generator.standard_normal(u.size)
        found.append(ss.ContactRecord(u, force, load, np.arange(u.size) / 4000.0))
    return found


def varying(mu, samples=800):
    """A loop under N = 100 + 80 sin θ and u = 20 µm cos θ, marched in fine steps to the end of its second cycle."""
    angle = 2.0 * np.pi * np.arange(samples) / samples
    u, load = 20e-6 * np.cos(angle), 100.0 + 80.0 * np.sin(angle)
    limit, tension, force = mu(load) * load, 0.0, np.zeros(samples)
    for n in range(2 * samples):
        k = n % samples
        tension = float(np.clip(tension + KT * (u[k] - u[k - 1]), -limit[k], limit[k]))
        force[k] = tension
    return ss.ContactLoop(u, force, load, "varying")


@pytest.mark.parametrize("seed", range(3))
def test_the_table_is_found_from_loops_at_several_loads(seed):
    found = ss.contact_law(records(FALLING, seed), laws=["jenkins", "dahl"], friction_over=LOADS)
    assert found.best == "jenkins"
    assert found.kt == pytest.approx(KT, rel=0.03)
    np.testing.assert_allclose(found.friction.values, FALLING, rtol=0.01)
    assert found.friction.over == tuple(LOADS)
    for truth, (low, high) in zip(FALLING, found.dataset["friction_interval"].values, strict=True):
        assert low < truth < high < 1.1 * low
    said = " ".join(sentences(found.dataset))
    assert "mu over the normal load: " in said
    assert " at 180 N; about as N to the -0.2" in said
    assert "one value for all" not in said
    assert list(tables(found.dataset)["friction"]["normal load in N"]) == list(LOADS)


def test_a_law_is_chosen_that_one_coefficient_for_all_loads_would_hide():
    smooth = (1.6, 1.3, 1.0, 0.7, 0.4)
    found = ss.contact_law(records(FALLING, 4, smooth), laws=["jenkins", "array"], friction_over=LOADS)
    assert found.best == "array"
    np.testing.assert_allclose(found.friction.values, FALLING, rtol=0.02)
    assert found.fits["array"].misfit < 0.02


def test_the_exponent_of_a_power_is_found():
    loads = np.geomspace(15.0, 200.0, 5)
    found = ss.contact_law(records(0.5 * (loads / 50.0) ** -0.25, 1, loads=loads), laws="jenkins", friction_over=loads)
    low, high = found.dataset["exponent_interval"].values
    assert low < -0.25 < high
    assert float(found.dataset["exponent"]) == pytest.approx(-0.25, abs=0.005)


def test_the_table_is_found_from_one_loop_under_a_load_that_varies():
    truth = ss.LoadDependentFriction((20.0, 60.0, 180.0), tuple(FALLING))
    found = ss.contact_law(varying(truth.coefficient), laws="jenkins", friction_over=LOADS)
    np.testing.assert_allclose(found.friction.values, FALLING, rtol=5e-3)
    assert found.kt == pytest.approx(KT, rel=2e-2)
    law = ss.Macroslip(found.kt, found.friction, normal_load=60.0)
    assert law.elements(1, False).friction[0].constant_limit[0] == pytest.approx(27.0, rel=5e-3)


@pytest.mark.parametrize(
    ("friction_over", "words"),
    [
        ([20.0], "two or more positive loads"),
        ([60.0, 20.0], "ascending order"),
        ([-1.0, 20.0], "positive loads"),
        ([20.0, 500.0], "must lie within the loads of the loops, 20 to 180 N"),
        (["a", 2.0], "must hold numbers"),
    ],
)
def test_loads_that_cannot_be_found_are_refused(friction_over, words):
    with pytest.raises(InputError, match=words):
        ss.contact_law(records(FALLING), laws="jenkins", friction_over=friction_over)


def test_a_force_that_falls_with_the_load_is_refused():
    with pytest.raises(InputError, match="The friction force mu N must not fall as the load grows"):
        ss.contact_law(records(np.array([0.9, 0.2, 0.3])), laws="jenkins", friction_over=LOADS)


def test_one_coefficient_for_several_loads_is_warned_of():
    found = ss.contact_law(records(FALLING), laws="jenkins")
    assert any("friction_over finds mu over the load" in said for said in found.warnings)


def test_friction_that_was_not_asked_for_is_refused():
    with pytest.raises(InputError, match="friction_over"):
        _ = ss.contact_law(records(FALLING), laws="jenkins").friction
