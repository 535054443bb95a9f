"""Limit cycles of one mass and of lumped structures: closed forms at one harmonic, and free motions marched in time."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

import stickslip as ss

FINE = 65536
"""Samples at which the first slip is placed to 1e-8 of the amplitude."""


def omega_of(A: float, stiffness: float = 1.0) -> float:
    """ω of one mass m = kt = μN = 1 with a Jenkins element by the describing function (Griffin 1980)."""
    t = np.arccos(1.0 - 2.0 / A)
    return float(np.sqrt(stiffness + (t - 0.5 * np.sin(2.0 * t)) / np.pi))


def taken(A: float) -> float:
    """Energy that friction takes in a cycle, 4 μN (A − μN/kt)."""
    return 4.0 * (A - 1.0)


def exact(c: float) -> list[float]:
    """Both roots of −π c ω A² = 4 μN (A − μN/kt)."""

    def left(A: float) -> float:
        return np.pi * c * omega_of(A) * A * A + taken(A)

    return [brentq(left, 1.0 + 1e-12, 2.0, xtol=1e-14), brentq(left, 2.6, 100.0, xtol=1e-13)]


def self_excited(c: float) -> ss.Problem:
    return replace(ss.rigs.single_mass(damping=0.0), dashpots=(ss.AerodynamicDamping({"1.x": 1.0}, c),))


@pytest.mark.parametrize("c", [-0.05, -0.1, -0.2])
def test_both_limit_cycles_of_one_mass_are_those_of_the_closed_form(c):
    found = ss.limit_cycles(self_excited(c), harmonics=1, samples=FINE).dataset.isel(case=0, aerodynamic_damping=0)
    np.testing.assert_allclose(found["amplitude"].values[:, 0], exact(c), rtol=1e-7)
    np.testing.assert_allclose(2.0 * np.pi * found["frequency"].values, [omega_of(A) for A in exact(c)], rtol=1e-7)
    assert list(found["stable"].values) == [1.0, 0.0]
    np.testing.assert_allclose(found["dissipated"].values[:, 0], [taken(A) for A in exact(c)], rtol=1e-6)
    np.testing.assert_allclose(found["viscous_work"].values, -found["dissipated"].values[:, 0], rtol=1e-10)


def test_the_error_is_of_second_order_in_the_samples():
    errors = []
    for samples in (64, 4096):
        found = ss.limit_cycles(self_excited(-0.1), harmonics=1, samples=samples).dataset
        errors.append(np.abs(found["amplitude"].values[0, 0, :, 0] / exact(-0.1) - 1.0).max())
    assert np.log(errors[0] / errors[1]) / np.log(64.0) > 1.8


def test_the_largest_damping_is_that_of_the_closed_form():
    """ζ = 2 μN (A − μN/kt)/(π A² ω²) of m = 1."""
    best = minimize_scalar(
        lambda A: -taken(A) / (2.0 * np.pi * A * A * omega_of(A) ** 2), bounds=(1.1, 10.0), options={"xatol": 1e-10}
    )
    modes = ss.nonlinear_modes(ss.rigs.single_mass(damping=0.0), harmonics=1, samples=FINE)
    found = modes.limit_cycles().dataset.isel(case=0)
    assert float(found["held_damping"]) == pytest.approx(-best.fun, rel=1e-8)
    assert float(found["held_amplitude"][0]) == pytest.approx(best.x, rel=1e-5)
    assert float(found["held_inside"]) == 1.0


def test_on_a_stiff_spring_friction_holds_kt_over_pi_at_twice_the_first_slip():
    """ω is that of the spring but for 1e-8, so that the largest 2ζω²m = |c| ω is kt/π at A = 2 μN/kt."""
    rig = ss.rigs.single_mass(damping=0.0, stiffness=1e8)
    found = ss.limit_cycles(rig, harmonics=1, samples=FINE).dataset.isel(case=0)
    omega = 2.0 * np.pi * float(found["held_frequency"])
    assert 2.0 * float(found["held_damping"]) * omega**2 == pytest.approx(1.0 / np.pi, rel=1e-6)
    assert float(found["held_amplitude"][0]) == pytest.approx(2.0, rel=1e-3)


def test_a_ratio_and_a_dashpot_that_feed_as_much_have_the_same_limit_cycles():
    """One mass: −2ζωM q̇ in all harmonics is a dashpot c = 2ζmω with ω of the limit cycle."""
    rig = ss.rigs.single_mass(damping=0.0)
    found = ss.limit_cycles(rig, -0.04, extended="all").dataset.isel(case=0, aerodynamic_damping=0)
    assert found.sizes["limit_cycle"] == 2
    for k, frequency in enumerate(found["frequency"].values):
        same = ss.limit_cycles(self_excited(-2.0 * 0.04 * 2.0 * np.pi * frequency)).dataset.isel(case=0, aerodynamic_damping=0)
        np.testing.assert_allclose(same["amplitude"].values[k], found["amplitude"].values[k], rtol=1e-8)


def test_modes_from_a_dataset_have_the_limit_cycles_of_the_traced_ones():
    rig = ss.rigs.chain_of_three(damping=0.0)
    modes = ss.nonlinear_modes(rig, [1, 2], harmonics=3, samples=128, phase_at=1)
    ratios = [-0.01, -0.03]
    again, direct = modes.limit_cycles(ratios).dataset, ss.limit_cycles(rig, ratios, [1, 2], harmonics=3, samples=128).dataset
    for name in ("amplitude", "frequency", "stable", "energy", "held_damping"):
        np.testing.assert_allclose(again[name].values, direct[name].values, rtol=1e-7, err_msg=name)
    assert np.isfinite(direct["frequency"].values).any()


def test_without_enough_friction_vibration_grows_and_without_gas_forces_it_decays():
    found = ss.limit_cycles(ss.rigs.single_mass(damping=0.02), [-0.2, 0.0], harmonics=1, samples=256).dataset
    assert not np.isfinite(found["frequency"].values).any()
    grows, decays = found["limit_cycle_message"].values[0]
    missing = 0.2 - float(found["held_damping"].values[0])
    assert grows == f"Vibration grows at all amplitudes; {100.0 * missing:.3g} % of damping is missing."
    assert decays.startswith("Vibration decays at all amplitudes")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (-1.5, "aerodynamic_damping must lie between -1 and 1"),
        ([], "aerodynamic_damping must hold at least one damping ratio"),
        ([-0.01, -0.01], "aerodynamic_damping"),
        ("much", "aerodynamic_damping"),
        (np.nan, "aerodynamic_damping"),
    ],
)
def test_wrong_aerodynamic_damping_is_refused(given, words):
    with pytest.raises(ss.InputError, match=words):
        ss.limit_cycles(ss.rigs.single_mass(), given)


@pytest.mark.parametrize(("direction", "c"), [({"1.x": 1.0}, 0.0), ({"1.x": 0.0}, -1.0), ({"1.x": 1.0}, np.inf), ("1.x", -1.0)])
def test_an_aerodynamic_damping_without_effect_or_size_is_refused(direction, c):
    with pytest.raises(ss.InputError, match=r"[Aa]n? (aerodynamic damping|AerodynamicDamping)"):
        ss.AerodynamicDamping(direction, c)


# Three masses with two sliders and negative damping C = −0.008 K, marched by SciPy's RK45 with the sliders' forces as states.
FEED, KT, LIMIT = 0.008, 2.0, 1.0
K = 2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
B = np.array([[1.0, 0.0, 0.0], [1.0, -1.0, 0.0]])


def fed_chain() -> ss.Problem:
    pairs = ({"1.x": 1.0}, {"1.x": 1.0, "2.x": -1.0}, {"2.x": 1.0, "3.x": -1.0}, {"3.x": 1.0})
    rig = ss.rigs.chain_of_three(kt=KT, limit=LIMIT, damping=0.0)
    return replace(rig, dashpots=tuple(ss.AerodynamicDamping(pair, -FEED) for pair in pairs))


def rate(_: float, state: np.ndarray) -> np.ndarray:
    """State: q, q̇, forces T of the sliders, Ṫ = kt ẇ but for |T| at its limit and growing."""
    q, v, T = state[:3], state[3:6], state[6:]
    w = B @ v
    free = (np.abs(T) < LIMIT) | (w * T < 0.0)
    return np.concatenate([v, -K @ (q - FEED * v) - B.T @ np.clip(T, -LIMIT, LIMIT), np.where(free, KT * w, 0.0)])


def amplitudes(shape: np.ndarray, omega: float, factor: float, periods: int) -> np.ndarray:
    """Largest |q2| in each period, from a mode's motion enlarged by a factor, the sliders at their limits or stuck."""
    q = factor * shape.real
    start = np.concatenate([q, np.zeros(3), np.clip(KT * B @ q, -LIMIT, LIMIT)])
    period = 2.0 * np.pi / omega
    t = np.linspace(0.0, periods * period, 64 * periods)
    found = solve_ivp(rate, (0.0, t[-1]), start, "RK45", t, max_step=0.02 * period, rtol=1e-6, atol=1e-9)
    return np.abs(found.y[1]).reshape(periods, 64).max(axis=1)


@pytest.mark.nightly
def test_free_motions_come_to_the_stable_limit_cycle_and_leave_the_unstable_one():
    found = ss.limit_cycles(fed_chain(), mode=1, harmonics=5).dataset.isel(case=0, aerodynamic_damping=0)
    assert list(found["stable"].values) == [1.0, 0.0]
    omega = 2.0 * np.pi * found["frequency"].values
    shapes = found["mode_shape"].values[..., 0] + 1j * found["mode_shape"].values[..., 1]
    largest = found["max_abs"].sel(output="2.x").values
    for factor in (0.8, 1.3):
        motion = amplitudes(shapes[0], omega[0], factor, 220)
        assert motion[-1] == pytest.approx(largest[0], rel=0.01)
    assert amplitudes(shapes[1], omega[1], 0.9, 60)[-1] < 0.8 * largest[1]
    assert amplitudes(shapes[1], omega[1], 1.1, 60)[-1] > 1.2 * largest[1]
