"""Controlled response against closed forms of one harmonic, and against forced responses at the forces that it found.

One mass on a spring and a Jenkins element at amplitude A (A_c = L/kt, cos θ = 1 − 2 A_c/A): the element acts as the stiffness
kt (θ − ½ sin 2θ)/π and dissipates 4 L (A − A_c) a cycle, so that the force is |k + k_eq − m ω² + i(c ω + k_loss)| A. A cubic
spring α u³ acts as ¾ α A², and at 90° ω² = (k + ¾ α A²)/m with the force c ω A.
"""

import numpy as np
import pytest

import stickslip as ss

K, KT, MU, C, M = 1.0, 0.5, 1.0, 0.02, 1.0


def jenkins_force(amplitude, omega):
    """Force level of the closed form."""
    critical = MU / KT
    angle = np.arccos(np.clip(1.0 - 2.0 * critical / amplitude, -1.0, 1.0))
    stiffness = KT / np.pi * (angle - 0.5 * np.sin(2.0 * angle))
    loss = 4.0 * MU * max(amplitude - critical, 0.0) / (np.pi * amplitude**2)
    return np.abs(K + stiffness - M * omega**2 + 1j * (C * omega + loss)) * amplitude


def one_mass():
    structure = ss.Structure(np.array([[M]]), np.array([[K]]), ("1.x",), C=np.array([[C]]))
    contact = ss.Contact("slider", ss.Macroslip(KT, MU, normal_load=1.0), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",))


def duffing(alpha=0.3):
    structure = ss.Structure(np.array([[M]]), np.array([[K]]), ("1.x",), C=np.array([[C]]))
    contact = ss.Contact("spring", ss.CubicSpring(alpha), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",))


@pytest.mark.parametrize(("quantity", "order"), [("displacement", 0), ("velocity", 1), ("acceleration", 2)])
def test_the_force_of_one_mass_with_a_slider(quantity, order):
    """Sampled friction is off the closed form by about 1/samples²."""
    frequencies = np.linspace(0.12, 0.28, 9)
    for held in (1.0, 4.0, 20.0):
        found = ss.controlled_response(one_mass(), frequencies, held, quantity=quantity, harmonics=1, samples=2048).dataset
        for k, omega in enumerate(2.0 * np.pi * frequencies):
            expected = jenkins_force(held / omega**order, omega)
            assert float(found["force_level"][0, k]) == pytest.approx(expected, rel=1e-4)
            assert float(found["amplitude"][0, k, 0]) * omega**order == pytest.approx(held, rel=1e-9)


def test_a_hardening_spring_does_not_fold_where_the_amplitude_is_held():
    """At a given force the same oscillator folds; the held curve has one force at each frequency, and each solves it."""
    problem, held = duffing(), 2.0
    found = ss.controlled_response(problem, ss.hertz(0.1, 0.4), held, quantity="displacement", harmonics=1, samples=64).dataset
    omega = 2.0 * np.pi * found["frequency"].values[0]
    expected = np.abs(K + 0.75 * 0.3 * held**2 - M * omega**2 + 1j * C * omega) * held
    assert found["force_level"].values[0] == pytest.approx(expected, rel=1e-9)
    assert np.all(np.diff(omega) > 0.0)
    assert float(found["resonance_frequency"][0, 0]) == pytest.approx(np.sqrt(1.9) / (2.0 * np.pi), rel=1e-9)
    force = float(found["resonance_force_level"][0, 0])
    at_that_force = ss.forced_response(problem, ss.hertz(0.1, 0.4), force, harmonics=1, samples=64).dataset
    assert np.any(np.diff(at_that_force["frequency"].values[0]) < 0.0)


def test_phase_resonance_of_a_cubic_spring():
    amplitudes = [0.1, 0.5, 1.0, 3.0, 10.0]
    found = ss.phase_resonance(
        duffing(), ss.hertz(0.1, 0.3), amplitudes, quantity="displacement", harmonics=1, samples=64
    ).dataset
    omega = np.sqrt(K + 0.75 * 0.3 * np.array(amplitudes) ** 2)
    assert found["frequency"].values == pytest.approx(omega / (2.0 * np.pi), rel=1e-9)
    assert found["force_level"].values == pytest.approx(C * omega * amplitudes, rel=1e-8)


def test_phase_resonance_of_a_slider_and_of_the_curves():
    """Both ways to it agree, and with the closed form: p = (c ω + k_loss) A."""
    amplitudes = [1.0, 2.5, 6.0, 30.0]
    fine = {"quantity": "displacement", "harmonics": 1, "samples": 2048}
    followed = ss.phase_resonance(one_mass(), ss.hertz(0.12, 0.28), amplitudes, **fine).dataset
    curves = ss.controlled_response(one_mass(), ss.hertz(0.12, 0.28), amplitudes, **fine).resonances()
    assert followed["frequency"].values == pytest.approx(curves["frequency"], rel=1e-6)
    assert followed["force_level"].values == pytest.approx(curves["force_level"], rel=1e-6)
    for amplitude, f, force in zip(amplitudes, followed["frequency"].values, followed["force_level"].values, strict=True):
        assert force == pytest.approx(jenkins_force(amplitude, 2.0 * np.pi * f), rel=1e-4)


def test_forced_responses_at_the_found_forces_return_the_amplitude():
    """A blade on a wedge that slips and lifts off: the first points of the way up, before anything folds."""
    problem, held = ss.rigs.blade_and_wedge(pull=60.0), 1000.0
    found = ss.controlled_response(problem, [300.0, 310.0, 325.0, 345.0, 360.0], held, harmonics=5).dataset
    assert float(found["share_slip"].max()) > 0.2
    for k, frequency in enumerate(found["frequency"].values[0]):
        forced = ss.forced_response(problem, [frequency], float(found["force_level"][0, k]), harmonics=5).dataset
        acceleration = (2.0 * np.pi * frequency) ** 2 * float(forced["amplitude"][0, 0, 0])
        assert acceleration == pytest.approx(held, rel=1e-9)


def test_folds_that_remain_are_followed():
    """Lift-off folds the held curve of the blade on a wedge; every point of it solves the balance with the amplitude held."""
    found = ss.controlled_response(ss.rigs.blade_and_wedge(pull=60.0), ss.hertz(300, 330), 2000.0, harmonics=3).dataset
    here = found["outcome"].values[0] == ss.Outcome.CONVERGED
    frequency = found["frequency"].values[0][here]
    assert np.any(np.diff(frequency) < 0.0)
    assert np.any(np.diff(frequency) > 0.0)
    sizes = (2.0 * np.pi * frequency) ** 2 * found["amplitude"].values[0, here, 0]
    assert sizes == pytest.approx(2000.0, rel=1e-7)
    assert found["residual"].values[0, here].max() < 1e-9


def test_a_moving_base():
    """m ẍ + c ẋ + k x = −m a_b: the held relative motion needs a_b = |k − m ω² + i c ω| A/m."""
    structure = ss.Structure(np.array([[M]]), np.array([[K]]), ("1.x",), C=np.array([[C]]))
    problem = ss.Problem(structure, (), (ss.BaseMotion({"1.x": 1.0}, 1.0),), ("1.x",))
    found = ss.controlled_response(problem, ss.hertz(0.1, 0.2), 0.7, quantity="velocity", harmonics=1, samples=16).dataset
    omega = 2.0 * np.pi * found["frequency"].values[0]
    assert found["force_level"].values[0] == pytest.approx(np.abs(K - M * omega**2 + 1j * C * omega) * 0.7 / omega / M, rel=1e-9)
    assert float(found["resonance_frequency"][0, 0]) == pytest.approx(1.0 / (2.0 * np.pi), rel=1e-9)


def test_wrong_arguments():
    problem = one_mass()
    for amplitude in ([], [1.0, 1.0], -1.0, 0.0, np.nan):
        with pytest.raises(ss.InputError, match="amplitude"):
            ss.controlled_response(problem, [0.1], amplitude)
    with pytest.raises(ss.InputError, match="quantity must be displacement, velocity, acceleration"):
        ss.controlled_response(problem, [0.1], 1.0, quantity="inertance")
    with pytest.raises(ss.InputError, match="must hold a natural frequency of the stuck structure"):
        ss.phase_resonance(problem, ss.hertz(0.3, 0.4), [1.0])
    silent = problem.with_forces([ss.Force("1.x", {2: 1.0})])
    with pytest.raises(ss.InputError, match="must have a force with a first harmonic"):
        ss.controlled_response(silent, [0.1], 1.0)


def test_forces_with_two_phases_have_no_phase_resonance():
    structure = ss.Structure(np.eye(2), np.array([[2.0, -1.0], [-1.0, 2.0]]), ("1.x", "2.x"), C=0.02 * np.eye(2))
    problem = ss.Problem(structure, (), (ss.Force("1.x", 1.0), ss.Force("2.x", 1.0j)), ("1.x",))
    with pytest.raises(ss.InputError, match="must have one phase"):
        ss.phase_resonance(problem, ss.hertz(0.1, 0.4), [1.0])
    held = ss.controlled_response(problem, ss.hertz(0.1, 0.2), 1.0, quantity="displacement")
    assert held.resonances().empty
    frequency, level = (float(held.dataset[name][0, 4]) for name in ("frequency", "force_level"))
    forced = ss.forced_response(problem, [frequency], level).dataset
    assert float(forced["amplitude"][0, 0, 0]) == pytest.approx(1.0, rel=1e-9)


def test_phase_resonances_without_viscous_damping_are_those_of_the_slider():
    """One mass, k = kt = limit = 1, closed describing function: 2 m at 0.194924 Hz and 0.63662, 50 m at 0.159534 Hz and 1.24777;
    at 0.5 m the slider sticks and nothing takes energy out, so that there is none."""
    structure = ss.Structure(np.eye(1), np.eye(1), ["1.x"])
    slider = ss.Contact("slider", ss.Macroslip(kt=1.0, mu=1.0, normal_load=1.0), [ss.between("1.x", "ground")])
    problem = ss.Problem(structure, [slider], [ss.Force("1.x", 1.0)], ["1.x"])
    band = ss.radians_per_second(0.1, 2.0)
    found = ss.phase_resonance(problem, band, [0.5, 2.0, 50.0], quantity="displacement", harmonics=1)
    np.testing.assert_allclose(found.dataset.frequency[1:], [0.194924, 0.159534], rtol=2e-4)
    np.testing.assert_allclose(found.dataset.force_level[1:], [0.63662, 1.24777], rtol=2e-4)
    assert found.dataset.outcome.values[0] == ss.Outcome.NOT_CONVERGED
    assert "No phase resonance was found at 0.5 m" in str(found)
