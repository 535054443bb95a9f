"""Dashpots and moving bases, against closed forms, against a base that is a degree of freedom, and in time."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.study import job

M, K, C = np.diag([1.0, 0.5]), np.array([[3.0, -1.0], [-1.0, 1.0]]), np.array([[0.05, -0.01], [-0.01, 0.01]])
ALL = {"1.x": 1.0, "2.x": 1.0}


def test_a_dashpot_equals_its_matrix():
    structure = ss.Structure(M, K, ("1.x", "2.x"), damping=ss.ModalDamping(0.01))
    plain = ss.Problem(structure, (), (ss.Force("2.x", 1.0),), ("2.x",))
    damped = ss.Problem(structure, (), plain.forces, ("2.x",), dashpots=(ss.Dashpot(ss.between("2.x", "1.x"), 0.3),))
    np.testing.assert_allclose(damped.C, plain.C + 0.3 * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    assert damped.fingerprint != plain.fingerprint
    with pytest.raises(ss.InputError, match="c of a dashpot must be positive"):
        ss.Dashpot({"1.x": 1.0}, -1.0)
    with pytest.raises(ss.InputError, match="does not exist"):
        ss.Problem(structure, (), plain.forces, ("2.x",), dashpots=(ss.Dashpot({"9.x": 1.0}, 1.0),))


def test_a_mass_on_a_moving_base():
    """Absolute over base displacement |x/x_b| = √((1 + (2ζr)²)/((1 − r²)² + (2ζr)²)), relative r²/√(...), r = ω/ω_n."""
    ratio, zeta = np.array([0.3, 0.8, 1.0, 1.4, 3.0]), 0.05
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), 2.0 * zeta * np.eye(1))
    problem = ss.Problem(structure, (), (ss.BaseMotion({"1.x": 1.0}, 1.0),), ("1.x",))
    response = ss.forced_response(problem, (ratio / (2.0 * np.pi)).tolist(), force=2.0, harmonics=1)
    size = np.hypot(1.0 - ratio**2, 2.0 * zeta * ratio)
    base = 2.0 / ratio**2
    np.testing.assert_allclose(response.dataset.amplitude.values[0, :, 0], base * ratio**2 / size, rtol=1e-12)
    found = response.absolute().amplitude.values[0, :, 0]
    np.testing.assert_allclose(found, base * np.hypot(1.0, 2.0 * zeta * ratio) / size, rtol=1e-12)
    assert response.dataset.force_level.attrs["units"] == "1", "a level of base motion is no force"


def test_an_unbalance():
    """m e ω² on a mass m_s: X = (m e/m_s) r²/√((1 − r²)² + (2ζr)²)."""
    ratio, zeta, unbalance = np.array([0.3, 0.8, 1.0, 1.4, 3.0]), 0.05, 0.02
    structure = ss.Structure(2.0 * np.eye(1), 2.0 * np.eye(1), ("1.x",), 4.0 * zeta * np.eye(1))
    problem = ss.Problem(structure, (), (ss.Force("1.x", unbalance, omega_power=2),), ("1.x",))
    response = ss.forced_response(problem, (ratio / (2.0 * np.pi)).tolist(), force=3.0, harmonics=1)
    expected = 3.0 * unbalance / 2.0 * ratio**2 / np.hypot(1.0 - ratio**2, 2.0 * zeta * ratio)
    np.testing.assert_allclose(response.dataset.amplitude.values[0, :, 0], expected, rtol=1e-12)
    assert response.dataset.force_level.attrs["units"] == "1", "the force has another size at every frequency"
    with pytest.raises(ss.InputError, match="omega must be given"):
        problem.load(1)


@pytest.mark.parametrize(("of", "order"), [("velocity", 1), ("displacement", 2)])
def test_a_given_displacement_or_velocity_is_the_acceleration_it_means(of, order):
    """With rubbing and harmonics 1 and 2, point by point and over a band with its peak."""
    slider = ss.Contact("slider", ss.Macroslip(0.8, 0.4, normal_load=1.0), (ss.between("2.x", "ground"),))
    given = {1: 0.3 - 0.2j, 2: 0.05j}
    structure = ss.Structure(M, K, ("1.x", "2.x"), C)
    moved = rubbing(structure, (ss.BaseMotion(ALL, given, of=of),), slider)
    frequencies = [0.1, 0.15, 0.2]
    response = ss.forced_response(moved, frequencies, force=2.0, harmonics=5)
    for k, frequency in enumerate(frequencies):
        acceleration = {h: (2j * np.pi * h * frequency) ** order * a for h, a in given.items()}
        plain = rubbing(structure, (ss.BaseMotion(ALL, acceleration),), slider)
        alone = ss.forced_response(plain, [frequency], force=2.0, harmonics=5)
        assert float(response.dataset.amplitude[0, k, 0]) == pytest.approx(float(alone.dataset.amplitude[0, 0, 0]), rel=1e-8)
        absolute = [float(found.absolute().amplitude[0, j, 0]) for found, j in ((response, k), (alone, 0))]
        assert absolute[0] == pytest.approx(absolute[1], rel=1e-8)
    finer = ss.forced_response(moved, [0.15], force=2.0, harmonics=15)
    assert finer.verify_in_time(0, 0, steps_per_period=1000).agrees(1e-3)
    swept = ss.forced_response(moved, ss.hertz(0.08, 0.25), force=2.0, harmonics=5).dataset
    assert int(swept.case_outcome[0]) == 1
    assert float(swept.energy_residual.max()) < 1e-8
    peak = float(swept.peak_frequency[0, 0, 0])
    near = ss.forced_response(moved, [0.999 * peak, peak, 1.001 * peak], force=2.0, harmonics=5).dataset.amplitude[0, :, 0]
    assert float(near[1]) == pytest.approx(float(swept.peak_amplitude[0, 0, 0]), rel=1e-6)
    assert float(near[1]) > float(near[0])
    assert float(near[1]) > float(near[2])


def test_faults_of_loads_that_go_by_the_frequency():
    for power in (-1, 5, 0.5, "2"):
        with pytest.raises(ss.InputError, match="omega_power must be a whole number from 0 to 4"):
            ss.Force("1.x", 1.0, omega_power=power)
    assert repr(ss.Force("1.x", 1.0, omega_power=2.0).power) == "2"
    with pytest.raises(ss.InputError, match="of must be a known motion, but is 'jerk'"):
        ss.BaseMotion(ALL, 1.0, of="jerk")
    structure = ss.Structure(M, K, ("1.x", "2.x"), C)
    slider = ss.Contact("slider", ss.Macroslip(0.8, 0.4, normal_load=1.0), (ss.between("2.x", "ground"),))
    for force in (ss.BaseMotion(ALL, 1.0), ss.Force("2.x", 1.0, omega_power=2)):
        with pytest.raises(ss.InputError, match="F_E must be a force of one amplitude"):
            ss.performance_curve(rubbing(structure, (force,), slider), [1.0, 10.0])


def rubbing(structure, forces, contact):
    return ss.Problem(structure, (contact,), forces, ("2.x",))


@pytest.mark.slow
def test_a_moving_base_equals_a_heavy_base_that_is_shaken():
    """The base as a degree of freedom b of 1e7 kg, driven by the force that accelerates it: an independent description.

    It is less exact: Newton's method judges its residual by that force, which is 1e7 times the contact force.
    """
    slider = ss.Contact("slider", ss.Macroslip(0.8, 0.4, normal_load=1.0), (ss.between("2.x", "ground"),))
    moving = rubbing(ss.Structure(M, K, ("1.x", "2.x"), C), (ss.BaseMotion(ALL, 0.4),), slider)
    relative = np.array([[1.0, 0.0, -1.0], [0.0, 1.0, -1.0]])
    heavy, soft = np.zeros((3, 3)), np.zeros((3, 3))
    heavy[:2, :2], heavy[2, 2], soft[2, 2] = M, 1e7, 1.0
    structure = ss.Structure(heavy, relative.T @ K @ relative + soft, ("1.x", "2.x", "b.x"), relative.T @ C @ relative)
    on_base = ss.Contact("slider", ss.Macroslip(0.8, 0.4, normal_load=1.0), (ss.between("2.x", "b.x"),))
    shaken = rubbing(structure, (ss.Force("b.x", 0.4e7),), on_base)
    frequencies = [0.1, 0.15, 0.2]
    ours = ss.forced_response(moving, frequencies, force=3.0, harmonics=5)
    theirs = ss.forced_response(shaken, frequencies, force=3.0, harmonics=5)
    np.testing.assert_allclose(ours.absolute().amplitude, theirs.dataset.amplitude, rtol=2e-4)
    assert float(ours.dataset.share_slip.max()) > 0.1
    assert ours.verify_in_time(0, 1, steps_per_period=1000).agrees(2e-3)


STUDY = """
units = "mm-t-s"
[study]
analysis = "forced_response"
[structure]
matrices = { M = [[0.001]], K = [[1.0]] }
dofs = ["1.x"]
[[contact]]
law = "cubic_spring"
between = ["1.x", "ground"]
k3 = 2.0
[[dashpot]]
between = ["1.x", "ground"]
c = 0.01
[base]
direction = "x"
acceleration = [0.0, -9810.0]
[sweep]
frequency = [1.0, 10.0]
outputs = ["1.x"]
"""


def test_a_study_with_cubic_spring_dashpot_and_base(tmp_path):
    problem = job(STUDY, tmp_path, "study").sweep.problem
    assert problem.contacts[0].law.k3 == pytest.approx(2.0e9)  # 2 N/mm³
    assert problem.C[0, 0] == pytest.approx(10.0)  # 0.01 N s/mm
    assert problem.structure.M[0, 0] == pytest.approx(1.0)
    np.testing.assert_allclose(problem.load(1)[0], [0.0, 0.0, -9.81])  # −M a, sine


def test_a_study_with_an_unbalance_and_a_given_displacement(tmp_path):
    text = STUDY.replace("acceleration = [0.0, -9810.0]", "displacement = 2.0")
    problem = job(text + "[[force]]\ndirection = '1.x'\namplitude = 3.0\nomega_power = 2\n", tmp_path, "study").sweep.problem
    np.testing.assert_allclose(problem.load(1, 1.0, 10.0)[0], [0.0, 0.002 * 100.0 + 3.0 * 100.0, 0.0])  # m ω² X + m e ω²


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("k3 = 2.0", "k3 = 0.0", "k3 must not be zero"),
        ('direction = "x"', 'direction = "y"', "[base]: direction must be that of some degree of freedom, but is 'y'"),
        ('direction = "x"', 'direction = { "2.x" = 1.0 }', "[base]: direction: degree of freedom '2.x' does not exist"),
        ("acceleration = [", "velocity = 1.0\nacceleration = [", "[base]: acceleration and velocity must not be given together"),
        ("acceleration = [0.0, -9810.0]", "", "[base]: acceleration or velocity or displacement must be given"),
        ("c = 0.01", "c = -0.01", "[[dashpot]] 1: c must be above 0"),
        ("\nc = 0.01", "", "[[dashpot]] 1: c must be given"),
    ],
)
def test_faults_are_named(tmp_path, old, new, said):
    assert old in STUDY
    with pytest.raises(ss.InputError) as raised:
        job(STUDY.replace(old, new, 1), tmp_path, "study")
    assert said in str(raised.value)
