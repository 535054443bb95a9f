"""The strip damper: closed form of its loop, the rig against it and its own first loading, stuck stiffness, full disk."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.rigs import strip_damper
from stickslip.support.checks import InputError

PULL, MU, OVERLAP, GAP, KT = 600.0, 0.3, 8e-3, 1e-3, 2e9
EA = 2e11 * 0.03 * 3e-4
MOST = 0.5 * MU * PULL
"""Friction of a strip under one platform, N."""
FRICTION = MOST / OVERLAP
WHOLE = MOST * (GAP + OVERLAP) / EA
"""Relative motion of the platforms at which the whole strip slips, without elasticity of the contact, m."""


def strip_energy(motion: float, pull: float, mu: float, stiffness: float, overlap: float, gap: float) -> float:
    """Energy per cycle that a strip dissipates [J] while the two platforms move by D cos ωt relative to each other.

    motion D [m]; pull F_C [N]; mu; stiffness EA of the strip [N]; overlap ℓ, gap g [m]. Coulomb friction q = μ F_C/(2ℓ) per
    length, without elasticity of the contact and inertia of the strip: where it pulls with F, slip reaches F/q from the gap under
    either platform, so D = F g/(EA) + F²/(q EA), and by Masing's rule W = 4 F³/(3 q EA). From F = q ℓ on, at
    D₀ = q ℓ (g + ℓ)/(EA), the whole strip slips, and W grows by 4 q ℓ (D − D₀).
    """
    q = mu * pull / (2.0 * overlap)
    most, half = q * overlap, 0.5 * q * gap
    F = min(np.sqrt(half**2 + q * stiffness * motion) - half, most)
    beyond = max(motion - most * (gap + overlap) / stiffness, 0.0)
    return float(4.0 * F**3 / (3.0 * q * stiffness) + 4.0 * most * beyond)


def loop(motion: float, D: np.ndarray, F: np.ndarray) -> float:
    """Energy of the loop whose branches are the first loading F(D), twice as large, up to a motion: 8 (∫F dD − F D/2)."""
    to = np.append(D[: np.searchsorted(D, motion)], motion)
    up = np.interp(to, D, F)
    return float(8.0 * (np.sum(0.5 * (up[1:] + up[:-1]) * np.diff(to)) - 0.5 * up[-1] * motion))


@pytest.mark.parametrize("share", [0.2, 0.7, 1.0, 1.5, 4.0])
def test_closed_form_is_the_loop_of_the_first_loading(share: float):
    """The bar stretches by the integral of its force F − q s over the slip length F/q, here summed, under either platform."""
    D, F = [0.0], [0.0]
    for pull in np.linspace(0.0, MOST, 4001)[1:]:
        along = np.linspace(0.0, pull / FRICTION, 51)
        stretch = np.sum(pull - FRICTION * 0.5 * (along[1:] + along[:-1])) * (along[1] - along[0]) / EA
        D.append(pull * GAP / EA + 2.0 * stretch)
        F.append(pull)
    D, F = np.append(D, max(share * WHOLE, D[-1]) + WHOLE), np.append(F, MOST)
    assert strip_energy(share * WHOLE, PULL, MU, EA, OVERLAP, GAP) == pytest.approx(loop(share * WHOLE, D, F), rel=1e-5)


def test_closed_form_has_no_step_at_whole_slip_and_grows_with_the_cube_before():
    below, above = (strip_energy(WHOLE * share, PULL, MU, EA, OVERLAP, GAP) for share in (1 - 1e-9, 1 + 1e-9))
    assert below == pytest.approx(above, rel=1e-6)
    assert strip_energy(0.0, PULL, MU, EA, OVERLAP, GAP) == 0.0
    small = [strip_energy(each, PULL, MU, EA, OVERLAP, GAP) for each in (1e-15, 2e-15)]
    assert small[1] / small[0] == pytest.approx(8.0, rel=1e-3)  # F ∝ D while the gap yields more than the slip


def first_loading(D: np.ndarray, points: int, kt: float) -> np.ndarray:
    """Force across the gap as one platform moves by D from rest: bars and sliders one by one, slip checked at each D."""
    count, step = 2 * points, OVERLAP / points
    bars = np.full(count - 1, EA / step)
    bars[points - 1] = EA / (step + GAP)
    K = np.diag(np.append(bars, 0.0) + np.append(0.0, bars)) - np.diag(bars, 1) - np.diag(bars, -1)
    moves = np.repeat([0.0, 1.0], points)
    slips, forces = np.zeros(count, bool), []
    for each in D:
        while True:
            pushed = np.where(slips, np.where(moves > 0, 1.0, -1.0) * MOST / points, kt / points * moves * each)
            u = np.linalg.solve(K + np.diag(np.where(slips, 0.0, kt / points)) + 1e-3 * np.eye(count), pushed + 5e-4 * each)
            more = ~slips & (np.abs(kt / points * (u - moves * each)) > MOST / points * (1 + 1e-12))
            if not more.any():
                break
            slips |= more
        forces.append(bars[points - 1] * (u[points] - u[points - 1]))
    return np.array(forces)


def driven(motion: list[float], points: int, kt: float = KT, **more: float):
    """Strips between platforms on a stiff drive that move against each other by D, slowly; energy of one strip by D."""
    shank = 1e13
    rig = strip_damper(PULL, MU, points=points, kt=kt, shank_stiffness=shank, sectors=4, engine_order=2)
    rig = replace(rig, forces=(ss.Force("platform.t", 0.5 * shank),), outputs=("platform.t",))
    response = ss.forced_response(rig, [5.0], force=motion, **{"harmonics": 15, "samples": 512, **more})
    np.testing.assert_allclose(2.0 * response.dataset.amplitude.isel(point=0, output=0), motion, rtol=1e-3)
    return response, response.dataset.dissipated.isel(point=0).sum("contact").to_numpy()


def test_the_rig_dissipates_the_loop_of_its_first_loading():
    """Masing's rule holds for any network of springs and sliders under constant normal loads."""
    motion = [0.4 * WHOLE, 0.8 * WHOLE, 2.0 * WHOLE, 6.0 * WHOLE]
    response, energy = driven(motion, points=6)
    D = np.linspace(0.0, motion[-1], 3001)
    F = first_loading(D, 6, KT)
    assert F[-1] == pytest.approx(MOST, rel=1e-9)
    np.testing.assert_allclose(energy, [loop(each, D, F) for each in motion], rtol=5e-3)
    assert float(np.abs(response.dataset.energy_residual).max()) < 1e-6
    slipping = response.dataset.share_slip.isel(point=0).sel(direction="t1").to_numpy().reshape(4, 2, 6) > 0.0
    assert 0 < np.count_nonzero(slipping[0, 0]) < 6  # microslip: from the gap on, alike under both platforms
    assert np.all(np.diff(slipping[0, 0].astype(int)) >= 0)
    np.testing.assert_array_equal(slipping[:, 1], slipping[:, 0, ::-1])
    assert np.all(slipping[-1])


def test_the_rig_tends_to_the_closed_form_with_points_and_stiffness():
    motion = [0.5 * WHOLE, 1.5 * WHOLE]
    exact = [strip_energy(each, PULL, MU, EA, OVERLAP, GAP) for each in motion]
    D = np.linspace(0.0, motion[-1], 1501)
    errors = []
    for points in (10, 20, 40):
        F = first_loading(D, points, 4e8 * points**2)
        errors.append(np.abs(np.array([loop(each, D, F) for each in motion]) / exact - 1.0))
    assert np.all(errors[0] > 1.5 * errors[1])
    assert np.all(errors[1] > 1.5 * errors[2])
    assert np.all(errors[2] < 0.03)


def test_stuck_strips_are_springs_by_shear_lag():
    """1/K = g/(EA) + 2/(EA λ tanh λℓ), λ² = kt/(ℓ EA); blades in antiphase carry 4 K at the platform."""
    rate = np.sqrt(KT / (OVERLAP * EA))
    strip = 1.0 / (GAP / EA + 2.0 / (EA * rate * np.tanh(rate * OVERLAP)))
    M, K = np.diag([0.3, 0.1]), np.array([[2.1e7 + 4.0 * strip, -1e6], [-1e6, 1e6]])
    exact = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, K)).real.max()) / (2.0 * np.pi)
    errors = []
    for points in (8, 16, 32):
        rig = strip_damper(points=points, density=1.0, sectors=4, engine_order=2)
        errors.append(rig.modes(2, stuck=True).frequencies[1] / exact - 1.0)
    assert abs(errors[2]) < 1e-3
    np.testing.assert_allclose(np.array(errors[:2]) / errors[1:], 4.0, rtol=0.05)


def test_a_strip_has_the_mass_of_its_section():
    rig = strip_damper(points=3)
    assert float(rig.structure.at(0).M[2:, 2:].real.sum()) == pytest.approx(
        7850.0 * 0.03 * 3e-4 * (2.0 * OVERLAP + GAP), rel=1e-12
    )


def test_a_point_keeps_the_balances_and_the_limit_of_friction():
    rig = strip_damper(points=4)
    response = ss.forced_response(rig, [499.5], force=1.0, harmonics=9, samples=256)
    data = response.dataset
    assert float(data.share_slip.max()) > 0.1
    assert float(np.abs(data.energy_residual).max()) < 1e-6
    assert np.all(data.dissipated >= -1e-12 * float(data.dissipated.max()))
    T = response.cycle(0, 0).force
    assert T.shape[0] == 8
    assert np.all(np.abs(T) <= 0.5 * MU * PULL / 4 * (1 + 1e-9))


@pytest.mark.slow
def test_one_sector_gives_what_all_blades_do():
    rig = strip_damper(points=2, sectors=6, engine_order=2)
    frequency = [float(rig.frequencies(stuck=True)[0]) * 0.995]
    one = ss.forced_response(rig, frequency, force=2.0, harmonics=3, samples=96)
    whole = ss.forced_response(rig.full([1, 4]), frequency, force=2.0, harmonics=3, samples=96)
    assert float(one.dataset.share_slip.max()) > 0.1
    np.testing.assert_allclose(whole.dataset.amplitude.to_numpy().ravel(), float(one.dataset.amplitude.item()), rtol=1e-7)
    assert float(whole.dataset.dissipated.sum()) == pytest.approx(6 * float(one.dataset.dissipated.sum()), rel=1e-6)


@pytest.mark.nightly
def test_time_integration_of_all_blades_gives_the_same_vibration():
    """Without the pins: the stuck ends of a strip in microslip hold it."""
    rig = replace(strip_damper(points=2, sectors=4, engine_order=1, damping=0.02), mean_springs=())
    frequency = [float(rig.frequencies(stuck=True)[0]) * 0.99]
    response = ss.forced_response(rig.full([1]), frequency, force=4.5, harmonics=15, samples=256)
    assert float(response.dataset.share_slip.max()) > 0.1
    check = response.verify_in_time(0, 0, steps_per_period=1000)
    np.testing.assert_allclose(check.harmonic_amplitude, check.time_amplitude, rtol=2e-3)


@pytest.mark.slow
def test_free_and_stuck_strips_bracket_the_peak():
    rig = strip_damper(points=4)
    stuck = float(rig.frequencies(stuck=True)[0])
    M, K = np.diag([0.3, 0.1]), np.array([[2.1e7, -1e6], [-1e6, 1e6]])
    alone = float(np.sqrt(np.linalg.eigvals(np.linalg.solve(M, K)).real.min())) / (2.0 * np.pi)
    response = ss.forced_response(rig, ss.hertz(0.99 * alone, 1.005 * stuck), force=[0.005, 1.0, 30.0], harmonics=5, samples=160)
    peaks = response.peaks().groupby("force_level").first()
    assert peaks.frequency.iloc[0] == pytest.approx(stuck, rel=1e-5)
    assert peaks.frequency.iloc[2] == pytest.approx(alone, rel=1e-3)
    assert np.all(np.diff(peaks.frequency) < 0.0)
    per_force = peaks.amplitude / peaks.index
    assert per_force.iloc[1] < 0.3 * min(per_force.iloc[0], per_force.iloc[2])


def test_what_a_strip_cannot_be():
    with pytest.raises(InputError, match="points must be at least 1"):
        strip_damper(points=0)
    with pytest.raises(InputError, match="points must be at most 200"):
        strip_damper(points=10**30)
    with pytest.raises(InputError, match="gap must not be negative"):
        strip_damper(gap=-1e-3)
    with pytest.raises(InputError, match="pull must"):
        strip_damper(-1.0)
    with pytest.raises(InputError, match="overlap must"):
        strip_damper(overlap=0.0)


def test_platforms_may_touch():
    """Without a gap slip reaches F/q from the middle, D = F²/(q EA), W = 4/3 √(q EA) D^1.5, and D₀ = q ℓ²/EA."""
    q, motion = MU * PULL / (2.0 * OVERLAP), 0.3 * MOST * OVERLAP / EA
    assert strip_energy(motion, PULL, MU, EA, OVERLAP, 0.0) == pytest.approx(4.0 / 3.0 * np.sqrt(q * EA) * motion**1.5, rel=1e-12)
    near, touching = (strip_damper(gap=gap, points=2, sectors=4, engine_order=2) for gap in (1e-9, 0.0))
    np.testing.assert_allclose(touching.frequencies(stuck=True), near.frequencies(stuck=True), rtol=1e-5)
