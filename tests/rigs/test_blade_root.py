"""The blade root: loads of the flanks by hand, the clamped beam, convergence over the contact points, time integration."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

import stickslip as ss
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.model.rigs import blade_root
from stickslip.support.checks import InputError

KT, KN = 8e8, 1e9


@pytest.mark.parametrize("angle", [30.0, 45.0, 60.0])
@pytest.mark.parametrize("mu", [0.0, 0.2, 10.0])
def test_flanks_bear_the_centrifugal_load(angle: float, mu: float):
    """2 (N cos a + T sin a) = F, with T = μN where the root slips outwards, N kt sin a/(kn cos a) where it sticks."""
    a = np.radians(angle)
    friction = min(mu, KT * np.sin(a) / (KN * np.cos(a)))
    assert (friction == mu) == (mu < 1.0)
    loads = normal_loads_at_rest(blade_root(5e3, angle, mu))
    flanks = [sum(load for name, load in loads.items() if name.startswith(side)) for side in ("left", "right")]
    np.testing.assert_allclose(flanks, 5e3 / (2.0 * (np.cos(a) + friction * np.sin(a))), rtol=1e-9)
    assert min(loads.values()) == pytest.approx(max(loads.values()), rel=1e-9)


def test_a_stiff_root_clamps_the_blade():
    """1.8751² √(EI/ρA)/(2π L²)."""
    clamped = 1.87510407**2 * np.sqrt(2.1e11 * 6e-3**2 / 12.0 / 7850.0) / (2.0 * np.pi * 0.2**2)
    found = [blade_root(kt=k, kn=k).frequencies(stuck=True)[0] for k in (1e9, 1e10, 1e11)]
    assert np.all(np.diff(found) > 0.0)
    assert found[-1] == pytest.approx(clamped, rel=5e-4)


def test_rocking_stiffness_of_the_flanks():
    """A turn about the point where the normals of the flanks' middles meet leaves these alone: kn b²/12 of each flank, kt r²."""
    rig, length, a = blade_root(points=40), 8e-3, np.radians(45.0)
    x = 0.006 + 0.5 * length * np.cos(a)
    y = -0.01 - 0.5 * length * np.sin(a)
    centre, arm = y - x / np.tan(a), x / np.sin(a)
    row = np.zeros(rig.structure.size)
    row[[rig.structure.index("root.x"), rig.structure.index("root.rz")]] = centre, 1.0
    energy = row @ (rig.stuck_stiffness - rig.structure.K) @ row
    discrete = 1.0 - 1.0 / 40**2
    assert energy == pytest.approx(2.0 * (KN * length**2 / 12.0 * discrete + KT * arm**2), rel=1e-9)


def test_vibration_with_slip_keeps_every_balance():
    rig = blade_root()
    rig = replace(rig, outputs=("tip.x", "root.x", "root.y"))
    response = ss.forced_response(rig, [118.0, 121.0], force=[2.0, 8.0], harmonics=7)
    data = response.dataset
    assert np.all(data.outcome == 1)
    assert float(data.share_slip.max()) > 0.05
    assert float(np.abs(data.energy_residual).max()) < 1e-5
    mean = data.contact_force.isel(harmonic=0).sel(part="re")
    a = np.radians(45.0)
    side = data.contact.str.startswith("right") * 2.0 - 1.0
    upwards = (np.cos(a) * mean.sel(direction="n") - np.sin(a) * mean.sel(direction="t1")).sum("contact")
    across = (side * (np.sin(a) * mean.sel(direction="n") + np.cos(a) * mean.sel(direction="t1"))).sum("contact")
    np.testing.assert_allclose(upwards, 5e3, rtol=1e-9)
    np.testing.assert_allclose(across, 0.0, atol=1e-6)
    force = response.cycle(1, 1).force
    T, normal = force[0::2], force[1::2]
    assert normal.min() >= 0.0
    assert np.all(np.abs(T) <= 0.3 * normal + 1e-9 * normal.max())


@pytest.mark.slow
def test_peaks_settle_with_the_number_of_contact_points():
    """Each flank as a line: the error of midpoints falls as 1/points² where all stick, and stays small where they slip."""
    stuck = np.array([blade_root(points=k).frequencies(stuck=True)[0] for k in (4, 8, 16, 64)])
    errors = np.abs(stuck[:3] - stuck[3])
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    amplitude = []
    for points in (4, 8, 16):
        response = ss.forced_response(blade_root(points=points), ss.hertz(116.0, 124.0), force=6.0, harmonics=3, samples=128)
        amplitude.append(float(response.peaks().amplitude.iloc[0]))
    assert abs(amplitude[2] / amplitude[1] - 1.0) < abs(amplitude[1] / amplitude[0] - 1.0) < 0.05


def test_the_root_is_a_plate_below_the_foot_of_the_blade():
    """Its middle, at (0, −d/2), moves by x + d/2 rz and y; inertia m (w² + d²)/12 about it."""
    light, heavy = (blade_root(root_mass=mass).structure.M[:3, :3] for mass in (0.1, 0.3))
    d, w = 0.01 + 8e-3 * np.sqrt(0.5), 0.012 + 2.0 * 8e-3 * np.sqrt(0.5)
    turning = (0.5 * d) ** 2 + (w**2 + d**2) / 12.0
    np.testing.assert_allclose((heavy - light) / 0.2, [[1.0, 0.0, 0.5 * d], [0.0, 1.0, 0.0], [0.5 * d, 0.0, turning]], atol=1e-12)


def test_the_clamped_blade_has_the_damping_ratio():
    rig = blade_root(damping=2e-3)
    clamped = slice(3, None)
    squares, shapes = eigh(rig.structure.K[clamped, clamped], rig.structure.M[clamped, clamped])
    first = shapes[:, 0]
    assert first @ rig.C[clamped, clamped] @ first == pytest.approx(2.0 * 2e-3 * np.sqrt(squares[0]), rel=1e-9)


@pytest.mark.nightly
def test_time_integration_gives_the_same_vibration():
    rig = blade_root(damping=0.02, points=4)
    response = ss.forced_response(rig, [118.0], force=60.0, harmonics=15)
    assert float(response.dataset.share_slip.max()) > 0.1
    check = response.verify_in_time(0, 0, steps_per_period=1000)
    np.testing.assert_allclose(check.harmonic_amplitude, check.time_amplitude, rtol=2e-3)


def test_less_load_slips_sooner_and_lowers_the_resonance():
    peaks = [
        ss.forced_response(blade_root(pull), ss.hertz(112.0, 124.5), force=5.0, harmonics=3, samples=128).peaks().iloc[0]
        for pull in (2e3, 5e3, 2e4)
    ]
    assert np.all(np.diff([peak.frequency for peak in peaks]) > 0.0)
    assert peaks[2].frequency < blade_root().frequencies(stuck=True)[0]
    assert peaks[0].loss_factor > peaks[1].loss_factor > peaks[2].loss_factor > 0.002


def test_what_a_root_cannot_be():
    with pytest.raises(InputError, match="flank_angle must lie between"):
        blade_root(flank_angle=0.0)
    with pytest.raises(InputError, match="points must be at least 2"):
        blade_root(points=1)
    with pytest.raises(InputError, match="points must be at most 1000"):
        blade_root(points=1001)
    with pytest.raises(InputError, match="pull must be positive"):
        blade_root(0.0)
