"""The ring damper: closed forms of its energy against the elastic contact solved piece by piece, and the rig against both."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, fsolve

import stickslip as ss
from stickslip.model.rigs import ring_damper
from stickslip.support.checks import InputError

N, RADIUS, OFFSET, E, DENSITY, MU, SPEED = 4, 0.25, 6e-3, 2e11, 7850.0, 0.2, 600.0
INNER, AREA = RADIUS - OFFSET, 2e-4 * 5e-4
FRICTION = MU * DENSITY * AREA * INNER * SPEED**2
"""μp of a light ring, which leaves the motion of the rim harmonic, N/m."""
ONSET = FRICTION * INNER / (N * E * AREA)
"""Strain of the groove at which it begins to slip."""


FULL_SLIP = np.hypot(1.0, 0.5 * np.pi)
"""Strain over that at which slip begins where, under a travelling wave, the whole ring slips."""


def ring_energy(strain: float, waves: int, line_friction: float, stiffness: float, radius: float, wave: str) -> float:
    """Energy per cycle that a ring under a constant line load dissipates [J], on a groove strained by ε(θ, t), a wave of n.

    strain ε₀: ε = ε₀ cos(nθ − ωt), or ε₀ cos nθ cos ωt of a standing wave; line_friction μp [N/m]; stiffness EA of the ring [N];
    radius r [m]. Coulomb friction without elasticity of the contact: with k = n/r and a = EA ε₀ k/(μp) the ring sticks up to
    a = 1. The hoop force N follows EA ε with the slope μp/k at most, and W = (μp/k) Σ ∫ |N/EA − ε| d(ks) over the waves.
    Travelling wave beyond a = √(1 + π²/4): W = 4 μp (ε₀/k) √(1 − π²/(4a²)) 2πr. Standing wave: slip in |ks − π/2| < β,
    β/sin β = a, W = 16 n μp (ε₀/k²) (sin β − β cos β − β³/(3a)), and β = π/2 from a = π/2 on.
    """
    k = waves / radius
    a, unit = stiffness * strain * k / line_friction, waves * line_friction * strain / k**2
    if a <= 1.0:
        return 0.0
    if wave == "standing":
        slipping = a >= 0.5 * np.pi
        beta = 0.5 * np.pi if slipping else brentq(lambda angle: angle - a * np.sin(angle), 1e-9, 0.5 * np.pi, xtol=1e-15)
        return float(16.0 * unit * (np.sin(beta) - beta * np.cos(beta) - beta**3 / (3.0 * a)))
    if a >= FULL_SLIP:
        return float(8.0 * np.pi * unit * np.sqrt(1.0 - (0.5 * np.pi / a) ** 2))
    first = np.arcsin(1.0 / a)
    top, ends = np.cos(first), (np.pi - first, np.pi + first)
    last = brentq(lambda angle: top - (angle - first) / a - np.cos(angle), *ends, xtol=1e-15)
    width = last - first
    return float(4.0 * np.pi * unit * (top * width - width**2 / (2.0 * a) - (np.sin(last) - np.sin(first))))


def rigid(a: float, wave: str = "travelling") -> float:
    """Energy per length over μp ε₀/k at a = EA ε₀ k/(μp)."""
    return ring_energy(1.0, 1, 1.0 / a, 1.0, 1.0, wave) * a / (2.0 * np.pi)


@pytest.mark.parametrize("a", [1.05, 1.4, 1.8, FULL_SLIP, 2.5, 10.0])
def test_hoop_force_follows_the_strain_at_the_slope_that_friction_allows(a: float):
    """The closed form for a travelling wave against stepping y' = −sign(y − cos ξ)/a, y = N/(EA ε₀), round the ring."""
    steps = 40000
    xi = 2.0 * np.pi * np.arange(2 * steps) / steps
    y = np.zeros(xi.size)
    most = 2.0 * np.pi / steps / a
    for k in range(1, xi.size):
        y[k] = y[k - 1] + np.clip(np.cos(xi[k]) - y[k - 1], -most, most)
    second = slice(steps, None)
    assert np.abs(y - np.cos(xi))[second].mean() * 2.0 * np.pi == pytest.approx(rigid(a), rel=2e-3, abs=1e-4)


@pytest.mark.parametrize("a", [1.1, 1.4, 1.57, 2.0, 8.0])
def test_standing_wave_dissipates_the_loop_of_hoop_force_over_strain(a: float):
    """The closed form for a standing wave against the loop by Masing's rule, 8 (∫P df − P(1)/2), from the first loading P(f)."""

    def half_slip(f: float) -> float:
        if a * f <= 1.0:
            return 0.0
        if a * f >= 0.5 * np.pi:
            return 0.5 * np.pi
        return float(fsolve(lambda beta: beta - a * f * np.sin(beta), 1.2)[0])

    def P(f: float) -> float:
        b = half_slip(f)
        return (np.sin(b) - b * np.cos(b)) / a + f * (0.5 * (0.5 * np.pi - b) + 0.25 * np.sin(2.0 * b))

    whole = quad(P, 0.0, 1.0, points=[1.0 / a, min(1.0, 0.5 * np.pi / a)], limit=200)[0]
    loop = 8.0 * (whole - 0.5 * P(1.0))  # of a quarter of a wave, over EA ε₀²/k
    assert 4.0 * loop * a / (2.0 * np.pi) == pytest.approx(rigid(a, "standing"), rel=1e-6)


def test_closed_forms_meet_where_slip_begins_and_where_it_is_complete():
    for wave, full in (("travelling", FULL_SLIP), ("standing", 0.5 * np.pi)):
        assert rigid(1.0, wave) == 0.0
        assert rigid(1.0 + 1e-6, wave) < 1e-4
        assert rigid(full * (1 - 1e-9), wave) == pytest.approx(rigid(full * (1 + 1e-9), wave), rel=1e-6)
    assert rigid(1e4) == pytest.approx(4.0, rel=1e-6)
    assert rigid(1e4, "standing") == pytest.approx(8.0 / np.pi, rel=1e-3)


@cache
def elastic(a: float, ratio: float) -> float:
    """∫|δ'| dξ over a wave, over ε₀/k, with a contact of stiffness kt = ratio EA k²: solved piece by piece.

    D = δ k/ε₀ as a function of ξ = ks − ωt has in half a wave one zone of stick, D'' = sin ξ − 1/a + ratio (D − D_b), and one of
    slip, D'' = sin ξ − 1/a. Time runs against ξ: stick begins at ξ_b with D' = 0 and ends at ξ_a, at the other limit of friction.
    """

    def zones(x, root, load):
        A, B, C, F, Db, xa, xb = x
        own = 1.0 + root**2

        def stick(t):
            return Db + 1 / (load * root**2) - np.sin(t) / own + A * np.exp(-root * (t - xa)) + B * np.exp(-root * (xb - t))

        def stick_slope(t):
            return -np.cos(t) / own - root * A * np.exp(-root * (t - xa)) + root * B * np.exp(-root * (xb - t))

        def slip(t):
            return -np.sin(t) - t**2 / (2 * load) + C * t + F

        return stick, stick_slope, slip, lambda t: -np.cos(t) - t / load + C

    def equations(x, root, load):
        stick, stick_slope, slip, slope = zones(x, root, load)
        Db, xa, xb = x[4:]
        end = xa + np.pi
        return [
            stick(xb) - Db,
            slip(xb) - Db,
            stick_slope(xb),
            slope(xb),
            slip(end) + stick(xa),
            slope(end) + stick_slope(xa),
            load * root**2 * (stick(xa) - Db) - 2.0,
        ]

    x = np.array([0, 0, 0, 0, -1.0, 0.5 * np.pi - 0.05, 0.5 * np.pi])
    path = [(load, 25.0) for load in np.linspace(40.0, a, 150)] + [(a, each) for each in np.geomspace(25.0, ratio, 40)[1:]]
    for load, each in path:
        known = (np.sqrt(each), load)
        x, _, _, _ = fsolve(equations, x, args=known, xtol=1e-12, full_output=True)
        assert np.abs(equations(x, *known)).max() < 1e-8
    return float(2.0 * (zones(x, np.sqrt(ratio), a)[2](x[5] + np.pi) - x[4]))


def test_elastic_contact_tends_to_the_closed_form():
    """An elastic contact lets strain escape in a layer of 1/√ratio of a wave beside the turn of a ring in full slip."""
    full, partial = ([1.0 - elastic(a, ratio) / rigid(a) for ratio in (100.0, 400.0)] for a in (3.0, 1.5))
    assert 0.0 < full[1] == pytest.approx(0.5 * full[0], rel=0.05)
    assert 0.0 < partial[1] == pytest.approx(0.25 * partial[0], rel=0.05)
    assert full[1] < 0.02


def light(points: int, ratio: float):
    """A ring too light to change the motion of the rim, driven slowly, and the groove's motion among the outputs."""
    kt = ratio * E * AREA * (N / INNER) ** 2
    rig = ring_damper(N, SPEED, MU, points=points, ring_height=2e-4, ring_width=5e-4, offset=OFFSET, kt=kt)
    return replace(rig, outputs=("rim.r", ss.Output("groove", {"rim.t": 1.0, "rim.rz": OFFSET})))


def strain_of(response, points: int, outputs=(0, 1)) -> np.ndarray:
    """ε₀ of the groove between contact points, from its motion (r, t) = (w, g) exp(−i n θ), by case."""
    amplitude = response.dataset.response.isel(point=0, harmonic=1)
    both = amplitude.sel(part="re") + 1j * amplitude.sel(part="im")
    w, g = (both.isel(output=each).to_numpy() for each in outputs)
    half = np.pi / points
    return np.abs(-1j * g * np.sin(N * half) / np.tan(half) + w * np.cos(N * half)) / INNER


@pytest.mark.parametrize(("points", "harmonics", "tolerance"), [(64, 15, 0.05), (128, 31, 0.012)])
def test_the_rig_dissipates_what_the_ring_on_an_elastic_contact_does(points: int, harmonics: int, tolerance: float):
    ratio = 400.0
    rig = light(points, ratio)
    response = ss.forced_response(rig, [30.0], force=[112.5, 135.0, 180.0, 270.0], harmonics=harmonics, samples=512)
    a = strain_of(response, points) / ONSET
    assert a[0] > 1.2
    assert a[-1] > 3.0
    energy = response.dataset.dissipated.isel(point=0, contact=0).to_numpy() * points
    expected = [elastic(float(each), ratio) * each * ONSET * FRICTION * 2.0 * np.pi * INNER**2 / N for each in a]
    np.testing.assert_allclose(energy, expected, rtol=tolerance)
    closed = [ring_energy(each * ONSET, N, FRICTION, E * AREA, INNER, "travelling") for each in a]
    assert np.all(energy[2:] < closed[2:])
    np.testing.assert_allclose(energy, closed, rtol=0.04 if harmonics > 15 else 0.08)
    assert np.all(np.abs(response.dataset.energy_residual) < 1e-6)


@pytest.mark.nightly
def test_a_standing_wave_on_all_sectors_dissipates_its_closed_form():
    points = 64
    disk = light(points, 400.0).full([1])
    in_phase = [replace(force, amplitude=np.cos(N * 2.0 * np.pi * j / points)) for j, force in enumerate(disk.forces)]
    scale = abs(disk.forces[0].amplitudes[1])
    disk = replace(disk, forces=tuple(replace(force, amplitude=scale * force.amplitude) for force in in_phase))
    response = ss.forced_response(disk, [30.0], force=[200.0], harmonics=9, samples=128)
    # At θ = 0 of a standing wave r is an antinode and t a node: ε₀ = e (n² − 1) W/(R (R − e)) of an inextensible rim
    w = float(response.dataset.amplitude.isel(case=0, point=0).to_numpy()[0])
    strain = OFFSET * (N**2 - 1) * w / (RADIUS * INNER)
    assert strain / ONSET > 1.6
    energy = float(response.dataset.dissipated.sum())
    assert energy == pytest.approx(ring_energy(strain, N, FRICTION, E * AREA, INNER, "standing"), rel=0.06)


def test_the_rim_has_the_frequency_of_a_ring_on_an_elastic_foundation():
    """ω² = (EI n²(n² − 1)²/R⁴ + k (n² + 1))/(ρA (n² + 1)), inextensible."""
    rig = ring_damper(N, points=128, kn=5e10)  # so that no mass of the ring moves with the rim
    stiffness = E * 0.03 * 0.01**3 / 12 * N**2 * (N**2 - 1) ** 2 / RADIUS**4 + 2e6 * (N**2 + 1)
    exact = np.sqrt(stiffness / (DENSITY * 3e-4 * (N**2 + 1))) / (2.0 * np.pi)
    assert rig.modes(N, stuck=False).frequencies[1] == pytest.approx(exact, rel=1.5e-3)


def test_normal_load_carries_the_hoop_force_and_the_inertia():
    """Equilibrium along r: the mean presses with p; the first harmonic follows the hoop force and the inertia of the ring."""
    points, harmonics = 64, 15
    rig = replace(ring_damper(N, points=points, kn=5e10), outputs=("rim.r", "ring.r", "ring.t"))
    frequency = float(rig.frequencies(stuck=True)[0]) * 0.995
    response = ss.forced_response(rig, [frequency], force=[3.0], harmonics=harmonics)
    force = response.dataset.contact_force.isel(case=0, point=0, contact=0, harmonic=1)
    T, normal = ((force.sel(direction=d, part="re") + 1j * force.sel(direction=d, part="im")).item() for d in ("t1", "n"))
    inner, area, half, omega = RADIUS - OFFSET, 8e-6, np.pi / points, 2.0 * np.pi * frequency
    step = 2.0 * half * inner
    found = response.dataset.response.isel(case=0, point=0, harmonic=1)
    _, r, t = (found.sel(part="re") + 1j * found.sel(part="im")).to_numpy()
    mass = DENSITY * area * step
    hoop = E * area / inner * (-1j * t * np.sin(N * half) / np.tan(half) + r * np.cos(N * half))
    along, across = 2j * np.sin(N * half) * np.cos(half), 2.0 * np.cos(N * half) * np.sin(half)
    np.testing.assert_allclose(T, mass * omega**2 * t - hoop * along, rtol=1e-6)
    np.testing.assert_allclose(normal, mass * omega**2 * r - hoop * across, rtol=1e-6)
    mean = response.dataset.contact_force.isel(case=0, point=0, contact=0, harmonic=0)
    assert float(mean.sel(direction="n", part="re")) == pytest.approx(DENSITY * area * inner * SPEED**2 * step, rel=1e-9)
    assert float(response.dataset.share_open.max()) == 0.0
    assert float(response.dataset.share_slip.max()) > 0.1


def test_a_pin_in_the_groove_bears_the_drag_of_the_wave():
    """Its spring times the mean slip is the mean friction; the ring barely turns, so that a curve takes few points."""
    slip = ss.Output("slip", {"ring.t": 1.0, "rim.t": -1.0, "rim.rz": -OFFSET})
    rig = replace(ring_damper(N, kn=5e10), outputs=("rim.r", slip))
    response = ss.forced_response(rig, ss.hertz(575.0, 583.0), force=2.0, harmonics=3, samples=128)
    data = response.dataset.isel(case=0)
    mean = data.response.sel(part="re").isel(output=1, harmonic=0).to_numpy()
    drag = data.contact_force.sel(part="re", direction="t1").isel(contact=0, harmonic=0).to_numpy()
    assert np.abs(drag).max() > 0.05  # N, where friction may carry 26
    np.testing.assert_allclose(drag, -1e9 * 2.0 * np.pi * INNER / 64 * mean, atol=1e-6 * np.abs(drag).max())
    assert np.abs(mean).max() < 0.02 * float(data.amplitude.isel(output=1).max())
    assert data.sizes["point"] < 400


def test_the_spring_of_the_ring_presses_beside_its_centrifugal_load():
    loads = [
        ring_damper(N, speed, line_load=each).contacts[0].law.normal_load
        for speed, each in ((SPEED, 0.0), (0.0, 300.0), (SPEED, 300.0))
    ]
    step = 2.0 * np.pi * INNER / 64
    expected = np.array([DENSITY * 8e-6 * INNER * SPEED**2, 300.0])
    np.testing.assert_allclose(loads, np.append(expected, expected.sum()) * step, rtol=1e-12)


def test_one_sector_gives_what_all_contact_points_do():
    rig = ring_damper(2, points=12, kt=2e9, kn=2e9, mu=0.05)
    frequency = [float(rig.frequencies(stuck=True)[0]) * 0.99]
    one = ss.forced_response(rig, frequency, force=2.0, harmonics=3, samples=48)
    whole = ss.forced_response(rig.full([1, 4]), frequency, force=2.0, harmonics=3, samples=48)
    assert float(one.dataset.share_slip.max()) > 0.1
    np.testing.assert_allclose(whole.dataset.amplitude.to_numpy().ravel(), float(one.dataset.amplitude.item()), rtol=1e-7)
    assert float(whole.dataset.dissipated.sum()) == pytest.approx(12 * float(one.dataset.dissipated.sum()), rel=1e-6)


def test_stuck_and_sliding_rings_bracket_the_peak():
    """A ring that slides freely still moves with the rim along r."""
    rig = ring_damper(points=32)
    stuck, sliding = (float(rig.frequencies(stuck=each)[0]) for each in (True, False))
    response = ss.forced_response(rig, ss.hertz(0.99 * sliding, 1.01 * stuck), force=[0.1, 3.0, 60.0], harmonics=1, samples=64)
    peaks = response.peaks().groupby("force_level").first()
    assert peaks.frequency.iloc[0] == pytest.approx(stuck, rel=1e-4)
    assert (1.0 - 1e-5) * sliding < peaks.frequency.iloc[2] < peaks.frequency.iloc[1] < stuck
    per_force = peaks.amplitude / peaks.index
    assert per_force.iloc[1] < 0.5 * min(per_force.iloc[0], per_force.iloc[2])


def test_what_a_ring_damper_cannot_be():
    with pytest.raises(InputError, match="at least four to a wave"):
        ring_damper(8, points=16)
    with pytest.raises(InputError, match="points must be at most 1000"):
        ring_damper(points=1001)
    with pytest.raises(InputError, match="mu must"):
        ring_damper(mu=-0.1)


def test_a_ring_with_its_pressure_is_swept_over_the_speed():
    """Its pressure goes with the square of the speed, and a sweep has it at every point."""
    models = {rpm: ring_damper(nodal_diameter=4, speed=rpm * np.pi / 30.0, kn=5e10) for rpm in (3000.0, 9000.0)}
    sweep = ss.speed_sweep(models, (8650.0, 8760.0), [4], force=1.0, harmonics=3, samples=96)
    top = sweep.peaks().iloc[0]
    alone = ring_damper(nodal_diameter=4, speed=float(top["speed"]) * np.pi / 30.0, kn=5e10)
    known = ss.forced_response(alone, [float(top["frequency"])], force=1.0, harmonics=3, samples=96).dataset
    assert float(known["amplitude"][0, 0, 0]) == pytest.approx(float(top["amplitude"]), rel=1e-6)
