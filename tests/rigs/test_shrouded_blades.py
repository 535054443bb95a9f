"""Shrouded blades: loads of untwist and interference by hand, beam theory, one sector against all of them."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.model.rigs import shrouded_blades
from stickslip.support.checks import InputError

SECTORS, TIP, ANGLE, KT, KN = 40, 0.65, np.radians(30.0), 1.6e7, 2e7
PITCH = 2.0 * np.pi * TIP / SECTORS
TORSION = 2.1e11 / 2.6 * 0.04 * 0.008**3 / 3.0 / 0.3
"""G J/L of a blade, N m/rad."""
C, S = np.cos(ANGLE), np.sin(ANGLE)


def test_untwist_without_friction_presses_the_faces():
    """M = GJ/L ψ + N p sin α, N = kn p ψ sin α."""
    expected = 20.0 * KN * PITCH * S / (TORSION + KN * (PITCH * S) ** 2)
    assert normal_loads_at_rest(shrouded_blades(mu=0.0))["shroud"] == pytest.approx(expected, rel=1e-9)
    assert normal_loads_at_rest(shrouded_blades(2 * 20.0, mu=0.0))["shroud"] == pytest.approx(2 * expected, rel=1e-9)


@pytest.mark.parametrize("mu", [0.3, 20.0])
def test_friction_of_the_faces_bears_part_of_the_untwist(mu: float):
    """M = GJ/L ψ + p (N sin α + T cos α): T = μ N in slip, kt p ψ cos α where the faces stick."""
    psi_over_N = 1.0 / (KN * PITCH * S)
    friction = min(mu, KT * C / (KN * S))
    expected = 20.0 / (TORSION * psi_over_N + PITCH * (S + friction * C))
    assert (friction == mu) == (mu < 1.0)
    assert normal_loads_at_rest(shrouded_blades(mu=mu))["shroud"] == pytest.approx(expected, rel=1e-9)


def test_interference_turns_the_shrouds_back():
    """N p sin α = −GJ/L ψ, N = kn (δ + p ψ sin α)."""
    rig = shrouded_blades(0.0, mu=0.0, interference=2e-4)
    expected = KN * 2e-4 * TORSION / (TORSION + KN * (PITCH * S) ** 2)
    assert normal_loads_at_rest(rig)["shroud"] == pytest.approx(expected, rel=1e-9)


def test_blades_are_beams():
    """Clamped-free: 1.8751² √(EI/ρA)/(2π L²) across thickness and chord; torsion √(GJ/ρI_p)/(4L)."""
    rig = shrouded_blades(shroud_mass=1e-9, stagger=25.0)
    found = rig.modes(3, stuck=False).frequencies
    flap = 1.87510407**2 * np.sqrt(2.1e11 * 0.008**2 / 12.0 / 7850.0) / (2.0 * np.pi * 0.3**2)
    polar = 7850.0 * 0.04 * 0.008 * (0.04**2 + 0.008**2) / 12.0
    torsion = np.sqrt(2.1e11 / 2.6 * 0.04 * 0.008**3 / 3.0 / polar) / 1.2
    for expected in (flap, 5.0 * flap, 6.26689 * flap):
        assert np.abs(found / expected - 1.0).min() < 1e-3
    assert np.abs(found / torsion - 1.0).min() < 4e-3  # elements with consistent mass: π²/(24 · 6²) at four times the length


def test_a_shroud_turns_about_the_radius_as_a_plate():
    """m (c² + p²)/12."""
    turning = [shrouded_blades(shroud_mass=mass).structure for mass in (0.1, 0.3)]
    row = turning[0].index("shroud.twist")
    before, after = (each.at(0).M[row, row].real for each in turning)
    assert after - before == pytest.approx(0.2 * (0.04**2 + PITCH**2) / 12.0, rel=1e-9)


def test_shrouds_that_move_alike_touch_no_more_but_by_turning():
    """The faces of a disk whose blades all move along the axis do not move relative to each other."""
    rig = shrouded_blades(stagger=0.0)
    rows = rig.systems.relative_rows(0)
    axial = np.zeros(rows.shape[1])
    axial[rig.structure.index("shroud.edge")] = 1.0
    np.testing.assert_allclose(rows @ axial, 0.0, atol=1e-15)
    twist = np.zeros(rows.shape[1])
    twist[rig.structure.index("shroud.twist")] = 1.0
    np.testing.assert_allclose(rows @ twist, [PITCH * C, 0.0, PITCH * S], atol=1e-15)


def test_vibration_with_slip_keeps_every_balance():
    rig = shrouded_blades()
    rig = replace(rig, outputs=(*rig.outputs, "shroud.twist"))
    response = ss.forced_response(rig, [258.0, 260.0], force=[100.0, 200.0], harmonics=5, samples=160)
    data = response.dataset
    assert float(data.share_slip.sel(direction="t1").min()) > 0.05
    assert float(np.abs(data.energy_residual).max()) < 1e-5
    assert np.all(data.dissipated > 0.0)
    mean = data.contact_force.isel(contact=0, harmonic=0).sel(part="re")
    twist = data.response.sel(output="shroud.twist", part="re").isel(harmonic=0)
    carried = TORSION * twist + PITCH * (S * mean.sel(direction="n") + C * mean.sel(direction="t1"))
    np.testing.assert_allclose(carried, 20.0, rtol=1e-8)
    T1, T2, N = response.cycle(1, 0).force
    assert N.min() >= 0.0
    assert np.all(np.abs(T1) <= 0.3 * N + 1e-9 * N.max())
    assert np.all(np.abs(T2) <= 0.3 * N + 1e-9 * N.max())


def test_one_sector_gives_what_all_blades_do():
    rig = shrouded_blades(sectors=6, tip_radius=0.1, engine_order=2)
    frequency = [float(rig.frequencies(stuck=True)[0]) * 0.98]
    one = ss.forced_response(rig, frequency, force=200.0, harmonics=3, samples=96)
    whole = ss.forced_response(rig.full([1, 4]), frequency, force=200.0, harmonics=3, samples=96)
    assert float(one.dataset.share_slip.max()) > 0.1
    np.testing.assert_allclose(whole.dataset.amplitude.to_numpy().ravel(), float(one.dataset.amplitude.item()), rtol=1e-7)
    assert float(whole.dataset.dissipated.sum()) == pytest.approx(6 * float(one.dataset.dissipated.sum()), rel=1e-6)


@pytest.mark.nightly
def test_time_integration_of_all_blades_gives_the_same_vibration():
    """All sectors step by step, from the state of 9 harmonics, against one sector with 25."""
    rig = shrouded_blades(sectors=6, tip_radius=0.1, engine_order=2).with_damping(ss.RayleighDamping(0.0, 2e-5))
    frequency = [361.8]
    start = ss.forced_response(rig.full([1]), frequency, force=300.0, harmonics=9, samples=120)
    check = start.verify_in_time(0, 0, steps_per_period=1000)
    one = ss.forced_response(rig, frequency, force=300.0, harmonics=25, samples=312)
    assert float(one.dataset.share_slip.max()) > 0.1
    assert np.ravel(check.time_amplitude)[0] == pytest.approx(one.dataset.amplitude.item(), rel=1e-3)


def test_free_and_stuck_blades_bracket_the_peak():
    rig = shrouded_blades()
    stuck, free = (float(rig.frequencies(stuck=each)[0]) for each in (True, False))
    response = ss.forced_response(rig, ss.hertz(235.0, 265.0), force=[20.0, 100.0, 200.0], harmonics=3, samples=120)
    peaks = response.peaks().groupby("force_level").first()
    assert np.all(peaks.frequency > free)
    assert np.all(peaks.frequency < 1.005 * stuck)
    assert np.all(np.diff(peaks.frequency) < 0.0)


def test_untwist_goes_with_the_square_of_the_speed():
    """Along an engine order the faces carry at each frequency what those of a rig at that speed do."""
    rate = ss.Force("shroud.twist", static=2e-4)  # N m s²
    rig = replace(shrouded_blades(0.0, mu=0.0), speed=ss.SpeedDependence(4, loads=(rate,)))
    response = ss.forced_response(rig, [200.0, 240.0], force=1.0, harmonics=1, samples=80)
    mean = response.dataset.contact_force.isel(case=0, contact=0, harmonic=0).sel(direction="n", part="re").to_numpy()
    speeds = 2.0 * np.pi * np.array([200.0, 240.0]) / 4.0
    own = [normal_loads_at_rest(shrouded_blades(2e-4 * speed**2, mu=0.0))["shroud"] for speed in speeds]
    np.testing.assert_allclose(mean, own, rtol=1e-9)


def test_what_shrouds_cannot_be():
    with pytest.raises(InputError, match="face_angle must lie between"):
        shrouded_blades(face_angle=90.0)
    with pytest.raises(InputError, match="thickness must not exceed the chord"):
        shrouded_blades(thickness=0.05)
    with pytest.raises(InputError, match="interference must"):
        shrouded_blades(interference=-1e-5)


@pytest.mark.nightly
def test_truncation_is_estimated_where_many_harmonics_at_once_are_too_far():
    """At 50 N Newton's method does not reach 21 harmonics from 5 in one go; 5 harmonics are a few per cent off 21."""
    disk, band = shrouded_blades(untwist=20.0, mu=0.3), ss.hertz(257.0, 264.0)
    few, many = (
        ss.forced_response(disk, band, force=50.0, harmonics=H, samples=samples).dataset for H, samples in ((5, 160), (21, 640))
    )
    at = float(few["peak_frequency"][0, 0, 0])
    order = np.argsort(many["frequency"].values[0])
    finer = np.interp(at, many["frequency"].values[0][order], many["amplitude"].values[0, order, 0])
    change = abs(finer / float(few["peak_amplitude"][0, 0, 0]) - 1.0)
    assert 0.01 < change < 0.1
    assert float(few["truncation_error"][0, 0]) == pytest.approx(change, rel=0.2)
