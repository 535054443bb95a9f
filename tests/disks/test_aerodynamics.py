"""Gas forces of bladed disks against whole disks with unsymmetric matrices, closed forms of one mass a sector, and in time."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import stickslip as ss
from stickslip.model.structure.cyclic import circulant

INFLUENCE = {0: 4e3 + 900j, 1: -1.5e3 - 800j, -1: -400 + 900j, 2: 300 + 200j}
REFERENCE = 149.0


def lumped(engine_order: int = 2) -> ss.TunedDisk:
    disk = ss.rigs.lumped_blisk("W", engine_order=engine_order, sectors=6)
    return disk.with_aerodynamics(ss.Aerodynamics(influence=INFLUENCE, frequency=REFERENCE, direction="tip.t"))


def between_blades(sectors: int) -> np.ndarray:
    """L of the whole disk: row j, column j + k holds L_k."""
    L = np.zeros((sectors, sectors), dtype=complex)
    for j in range(sectors):
        for k, value in INFLUENCE.items():
            L[j, (j + k) % sectors] += value
    return L


def test_influence_coefficients_become_hermitian_matrices_between_the_sectors():
    gas = lumped().wave_stiffnesses[0]
    stiffness, damping = gas.between_sectors()
    np.testing.assert_allclose(stiffness + 1j * gas.omega * damping, between_blades(6), atol=1e-9)
    for matrix in (stiffness, damping):
        np.testing.assert_allclose(matrix, matrix.conj().T, atol=1e-12 * np.abs(matrix).max())


def direct(full: ss.FullDisk, force: float) -> np.ndarray:
    """Amplitudes of the outputs of all sectors with stuck contacts at the reference frequency, with L as it is."""
    omega, structure = 2.0 * np.pi * REFERENCE, full.structure
    tips = [structure.index(f"{j}/tip.t") for j in range(1, 7)]
    D = full.stuck_stiffness + 1j * omega * full.C - omega**2 * structure.M
    D[np.ix_(tips, tips)] += between_blades(6)
    load = full.load(1, force)
    return np.linalg.solve(D, load[:, 1] - 1j * load[:, 2])[tips]


@pytest.mark.parametrize("engine_order", [1, 2, 3, 5])
def test_the_waves_of_a_tuned_disk_are_those_of_the_whole_unsymmetric_one(engine_order):
    disk = lumped(engine_order)
    found = ss.forced_response(disk, [REFERENCE], force=[1e-3], harmonics=1, samples=48).dataset
    assert float(found["amplitude"].item()) == pytest.approx(abs(direct(disk.full(), 1e-3)[0]), rel=1e-9)


def test_a_mistuned_disk_is_the_whole_unsymmetric_one():
    full = ss.mistuned_disk(lumped(), ss.Mistuning(blade=[0.01, -0.02, 0.005, 0.0, 0.015, -0.01]))
    assert not full.tuned
    found = ss.forced_response(full, [REFERENCE], force=[1e-3], harmonics=1, samples=48).dataset
    np.testing.assert_allclose(found["amplitude"].values.ravel(), np.abs(direct(full, 1e-3)), rtol=1e-8)


def test_one_sector_slips_as_the_whole_disk_does():
    disk = lumped()
    one = ss.forced_response(disk, [152.6, 152.9], force=[1.0], harmonics=3, samples=96).dataset
    whole = ss.forced_response(disk.full([1, 2]), [152.6, 152.9], force=[1.0], harmonics=3, samples=96).dataset
    assert float(one["share_slip"].max()) > 0.05
    np.testing.assert_allclose(whole["amplitude"].values, np.broadcast_to(one["amplitude"].values, (1, 2, 2)), rtol=1e-8)
    assert float(one["energy_residual"].max()) < 1e-8


def test_gas_forces_do_not_act_on_the_mean():
    disk = ss.rigs.lumped_blisk("W", engine_order=2, sectors=6)
    loaded = replace(disk, forces=(*disk.forces, ss.Force("tip.t", static=5.0, name="steady")))
    gas = ss.Aerodynamics(influence={0: 1e5}, frequency=REFERENCE, direction="tip.t")
    mean = [
        ss.forced_response(one, [120.0], force=[1e-3], harmonics=1, samples=48)
        .dataset["response"]
        .sel(harmonic=0, part="re")
        .item()
        for one in (loaded, loaded.with_aerodynamics(gas))
    ]
    assert mean[0] > 1e-6
    assert mean[1] == pytest.approx(mean[0], rel=1e-12)


# One mass a sector, springs to the ground and to the neighbours, a Jenkins element to the ground; all in units of one.
SECTORS, GROUND, RING = 4, 10.0, 0.5


def ring(nodal_diameter: int, gas: ss.Aerodynamics, sectors: int = SECTORS, joint: float = RING) -> ss.TunedDisk:
    sector = ss.Structure(np.eye(1), np.array([[GROUND + 2.0 * joint]]), ("1.x",))
    structure = ss.sector_chain(sector, sectors, np.array([[-joint]]))
    contact = ss.Contact("slider", ss.Macroslip(1.0, 1.0, normal_load=1.0), ({"1.x": 1.0},))
    disk = ss.TunedDisk(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",), engine_order=nodal_diameter)
    return disk.with_aerodynamics(gas)


def of_wave(nodal_diameter: int, gas: ss.Aerodynamics) -> complex:
    assert gas.influence is not None
    return sum(L * np.exp(-2j * np.pi * nodal_diameter * k / SECTORS) for k, L in gas.influence.items())


FEEDING = ss.Aerodynamics(influence={0: 0.05 + 0.1j, 1: 0.1 - 0.06j, -1: -0.15 + 0.05j}, frequency=0.53, direction="1.x")


def test_damping_by_nodal_diameter_is_the_root_of_each_wave():
    found = ss.damping_by_nodal_diameter(ring(1, FEEDING)).dataset
    assert list(found["nodal_diameter"].values) == [-1, 0, 1, 2]
    for n in found["nodal_diameter"].values:
        A, stiffness = of_wave(int(n), FEEDING), GROUND + 1.0 + 2.0 * RING * (1.0 - np.cos(2.0 * np.pi * n / SECTORS))
        s = np.roots([1.0, A.imag / (2.0 * np.pi * 0.53), stiffness + A.real])[0]
        one = found.sel(nodal_diameter=n)
        assert float(one["damping_ratio"]) == pytest.approx(-s.real / abs(s), rel=1e-10)
        assert float(one["aerodynamic_damping"]) == pytest.approx(-s.real / abs(s), rel=1e-10)
        assert float(one["frequency_shift"]) == pytest.approx(abs(s) / np.sqrt(stiffness) - 1.0, rel=1e-6)
    free = ss.damping_by_nodal_diameter(ring(1, FEEDING), stuck=False).dataset
    assert float(free["frequency"].sel(nodal_diameter=0)) < float(found["frequency"].sel(nodal_diameter=0))


def closed(nodal_diameter: int, gas: ss.Aerodynamics) -> list[tuple[float, float]]:
    """A and ω of −π c ω A² = 4 (A − 1) with c = Im A_n/ω_ref, ω² = k_n + Re A_n + k_eq(A)."""
    A_n = of_wave(nodal_diameter, gas)
    stiffness = GROUND + 2.0 * RING * (1.0 - np.cos(2.0 * np.pi * nodal_diameter / SECTORS)) + A_n.real
    assert gas.frequency is not None
    c = A_n.imag / (2.0 * np.pi * gas.frequency)

    def omega(A: float) -> float:
        t = np.arccos(1.0 - 2.0 / A)
        return float(np.sqrt(stiffness + (t - 0.5 * np.sin(2.0 * t)) / np.pi))

    roots = [
        brentq(lambda A: np.pi * c * omega(A) * A * A + 4.0 * (A - 1.0), *ends) for ends in ((1.0 + 1e-12, 2.0), (2.0, 500.0))
    ]
    return [(A, omega(A)) for A in roots]


def test_limit_cycles_of_a_travelling_wave_are_those_of_the_closed_form():
    found = ss.limit_cycles(ring(1, FEEDING), harmonics=1, samples=65536).dataset.isel(case=0, aerodynamic_damping=0)
    exact = np.array(closed(1, FEEDING))
    np.testing.assert_allclose(found["amplitude"].values[:, 0], exact[:, 0], rtol=1e-7)
    np.testing.assert_allclose(2.0 * np.pi * found["frequency"].values, exact[:, 1], rtol=1e-7)
    assert list(found["stable"].values) == [1.0, 0.0]


def test_the_other_waves_decay():
    for n in (0, 2, 3):
        assert of_wave(n, FEEDING).imag > 0.0
        found = ss.limit_cycles(ring(n, FEEDING), harmonics=1).dataset
        assert not np.isfinite(found["frequency"].values).any()


def test_a_mode_of_the_whole_disk_has_the_limit_cycles_of_the_travelling_wave():
    """Gas forces split the pairs of a tuned disk: the waves of nodal diameter 1 and −1 have frequencies of their own."""
    one = ss.limit_cycles(ring(1, FEEDING), harmonics=3, samples=256).dataset.isel(case=0, aerodynamic_damping=0)
    full = ring(1, FEEDING).full()
    # Stuck modes ascending: n = 0, then 1 and −1 by the real part of A_n, then 2.
    number = 2 if of_wave(1, FEEDING).real < of_wave(-1, FEEDING).real else 3
    whole = ss.limit_cycles(full, mode=number, harmonics=3, samples=256).dataset.isel(case=0, aerodynamic_damping=0)
    np.testing.assert_allclose(whole["amplitude"].values, np.repeat(one["amplitude"].values, SECTORS, axis=1), rtol=1e-6)


def march(start: np.ndarray, velocity: np.ndarray, gas: ss.Aerodynamics, periods: int) -> np.ndarray:
    """Largest motion of the first sector in each period: four masses with Re L as springs and Im L/ω as dampers between them."""
    assert gas.influence is not None
    assert gas.frequency is not None
    L = np.zeros((SECTORS, SECTORS), dtype=complex)
    for j in range(SECTORS):
        for k, value in gas.influence.items():
            L[j, (j + k) % SECTORS] += value
    own = (GROUND + 2.0 * RING) * np.eye(SECTORS) - RING * (np.roll(np.eye(SECTORS), 1, 0) + np.roll(np.eye(SECTORS), -1, 0))
    K, C = own + L.real, L.imag / (2.0 * np.pi * gas.frequency)

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        q, v, T = np.split(state, 3)
        free = (np.abs(T) < 1.0) | (v * T < 0.0)
        return np.concatenate([v, -K @ q - C @ v - np.clip(T, -1.0, 1.0), np.where(free, v, 0.0)])

    period = 1.0 / gas.frequency
    t = np.linspace(0.0, periods * period, 64 * periods)
    first = np.concatenate([start, velocity, np.clip(start, -1.0, 1.0)])
    found = solve_ivp(rate, (0.0, t[-1]), first, "RK45", t, max_step=0.02 * period, rtol=1e-6, atol=1e-9)
    return np.abs(found.y[0]).reshape(periods, 64).max(axis=1)


@pytest.mark.nightly
def test_free_waves_marched_in_time_come_to_the_stable_limit_cycle_and_leave_the_unstable_one():
    """The coefficients hold at the frequency of the limit cycle: unsymmetric real matrices are then the same forces."""
    for k, (factors, periods) in enumerate((((0.9, 1.2), 80), ((0.95, 1.05), 40))):
        gas = FEEDING
        for _ in range(4):
            found = ss.limit_cycles(ring(1, gas), harmonics=5).dataset.isel(case=0, aerodynamic_damping=0)
            gas = replace(gas, frequency=float(found["frequency"][k]))
        amplitude, omega = float(found["max_abs"][k, 0]), 2.0 * np.pi * float(found["frequency"][k])
        wave = np.exp(-2j * np.pi * np.arange(SECTORS) / SECTORS)
        below, above = (march(f * amplitude * wave.real, -f * amplitude * omega * wave.imag, gas, periods)[-1] for f in factors)
        if k == 0:
            assert [below, above] == pytest.approx([amplitude] * 2, rel=0.01)
        else:
            assert below < 0.85 * amplitude < 1.15 * amplitude < above


def test_per_cent_of_the_blade_alone_are_those_of_blades_that_nothing_else_couples():
    ratio, shift = [0.001, 0.002, -0.003, 0.004, 0.0, 0.01], [0.0, 0.001, -0.002, 0.0, 0.003, 0.0]
    gas = ss.Aerodynamics(damping_ratio=ratio, frequency_shift=shift)
    disk = ring(1, gas, sectors=6, joint=0.0)
    alone = ss.blade_alone(disk.disk)
    assert alone.direction == {"1.x": 1.0}
    assert alone.frequency == pytest.approx(np.sqrt(GROUND) / (2.0 * np.pi), rel=1e-12)
    found = ss.damping_by_nodal_diameter(disk, stuck=False).dataset
    for n in found["nodal_diameter"].values:
        one = found.sel(nodal_diameter=n)
        assert float(one["frequency_shift"]) == pytest.approx(shift[n % 6], rel=1e-9, abs=1e-12)
        assert float(one["aerodynamic_damping"]) == pytest.approx(ratio[n % 6] / (1.0 + shift[n % 6]), rel=1e-9, abs=1e-12)


def test_a_blade_alone_has_its_neighbours_at_rest():
    disk = ss.rigs.lumped_blisk("R", sectors=7)
    assert disk.disk.masses is not None
    K = circulant(disk.disk.stiffnesses, 7)[:3, :3]
    M = circulant(disk.disk.masses, 7)[:3, :3]
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    for mode in (1, 2, 3):
        assert ss.blade_alone(disk.disk, mode).frequency == pytest.approx(np.sqrt(squares[mode - 1]) / (2.0 * np.pi), rel=1e-10)


def test_stiffnesses_by_nodal_diameter_and_influence_coefficients_say_the_same():
    waves = {n: of_wave(n, FEEDING) for n in (-1, 0, 1, 2)}
    same = ss.Aerodynamics(stiffness=waves, frequency=0.53, direction="1.x")
    listed = ss.Aerodynamics(stiffness=[waves[0], waves[1], waves[2], waves[-1]], frequency=0.53, direction={"1.x": 1.0})
    expected = FEEDING.on(ring(1, FEEDING).disk).waves
    for gas in (same, listed):
        np.testing.assert_allclose(gas.on(ring(1, FEEDING).disk).waves, expected, rtol=1e-14)


def test_a_disk_with_other_gas_forces_is_another_problem():
    prints = {
        disk.fingerprint
        for disk in (lumped(), lumped().with_aerodynamics(), lumped().full(), lumped().with_aerodynamics().full())
    }
    assert len(prints) == 4


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "one of influence, stiffness and damping_ratio, but is 'none'"),
        ({"influence": {0: 1j}, "stiffness": [1j] * 6}, "but is 'influence and stiffness'"),
        ({"stiffness": [1j] * 5}, "one value for each of the 6 nodal diameters"),
        ({"damping_ratio": {0: 0.1, 1: 0.1, 7: 0.1}}, "one value for each of the 6 nodal diameters"),
        ({"influence": {6: 1j}}, "numbers between -5 and 5 on a disk of 6 sectors"),
        ({"influence": {2: 1j, -4: 1j}}, "every blade or wave once"),
        ({"influence": {}}, "at least one value"),
        ({"influence": {0: np.nan}}, "real part"),
        ({"influence": {0: 1j}, "direction": "tip.t"}, "frequency must be given with a direction"),
        ({"influence": {0: 1j}, "direction": "tip.x", "frequency": 150.0}, "tip.x"),
        ({"influence": {0: 1j}, "direction": {"next/tip.t": 1.0}, "frequency": 150.0}, "of the sector itself"),
        ({"influence": {0: 1j}, "frequency": -1.0}, "frequency must be positive"),
        ({"influence": {0: 1j}, "frequency_shift": [0.0] * 6}, "frequency_shift must go with damping_ratio"),
        ({"damping_ratio": [0.5] * 6, "direction": "tip.t", "frequency": 150.0}, "modal_mass must be given"),
        ({"damping_ratio": [1.5] * 6}, "damping_ratio must lie between -1 and 1"),
        ({"damping_ratio": [0.1j] * 6}, "damping_ratio must be real"),
        ({"damping_ratio": [0.1] * 6, "frequency_shift": [2.0] * 6}, "frequency_shift must lie between -0.5 and 0.5"),
        ({"damping_ratio": "much"}, "must be a list"),
    ],
)
def test_wrong_aerodynamics_are_refused(given, words):
    with pytest.raises(ss.InputError, match=words):
        ss.rigs.lumped_blisk("W", sectors=6).with_aerodynamics(ss.Aerodynamics(**given))


def test_what_needs_one_real_system_says_so():
    with pytest.raises(ss.InputError, match="aerodynamics of a disk"):
        ss.time_response(lumped().full([1]), 149.0, 1e-3)
    with pytest.raises(ss.InputError, match="must have aerodynamics"):
        ss.damping_by_nodal_diameter(ss.rigs.lumped_blisk("W", sectors=6))
