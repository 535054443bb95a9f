"""The two linear limits of every contact problem, and the equivalent stiffness of a stuck damper."""

from math import cos, radians, sin

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.cubic import Gap
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, SliderOffset, between
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs import chain, chain_of_three, single_mass, three_mass_wedge
from stickslip.model.structure.matrices import Structure
from stickslip.support.units import hertz, radians_per_second


def linear_amplitude(problem: Problem, stiffness: np.ndarray, frequency: float) -> np.ndarray:
    """|X_1| of the outputs of M q̈ + C q̇ + stiffness q = p."""
    omega, load = 2.0 * np.pi * frequency, problem.load(1)
    dynamic = stiffness + 1j * omega * problem.C - omega**2 * problem.structure.M
    return np.abs(problem.output_rows @ np.linalg.solve(dynamic, load[:, 1] - 1j * load[:, 2]))


PROBLEMS = {"one mass": single_mass(), "three masses": chain_of_three(), "twenty masses": chain(), "wedge": three_mass_wedge()}
BANDS = {"one mass": (0.1, 0.3), "three masses": (0.1, 0.3), "twenty masses": (0.02, 0.06), "wedge": (145.0, 235.0)}


@pytest.mark.parametrize("name", PROBLEMS)
def test_linear_curves_are_the_linear_responses(name):
    """`free_amplitude` is that without contacts, `stuck_amplitude` that with their springs, per force level."""
    problem = PROBLEMS[name]
    start, stop = BANDS[name]
    dataset = forced_response(problem, [start, stop], 3.0, harmonics=3).dataset
    for k in range(0, dataset.sizes["linear_point"], 37):
        frequency = float(dataset.linear_frequency[k])
        for curve, stiffness in (("free", problem.structure.K), ("stuck", problem.stuck_stiffness)):
            expected = 3.0 * linear_amplitude(problem, stiffness, frequency)
            np.testing.assert_allclose(dataset[f"{curve}_amplitude"][0, k], expected, rtol=1e-8)


@pytest.mark.parametrize("name", ["one mass", "three masses", "twenty masses"])
def test_small_forces_leave_everything_stuck(name):
    problem, band = PROBLEMS[name], hertz(*BANDS[name])
    dataset = forced_response(problem, band, 1e-4, harmonics=3).dataset
    for k in range(dataset.sizes["point"]):
        expected = 1e-4 * linear_amplitude(problem, problem.stuck_stiffness, float(dataset.frequency[0, k]))
        np.testing.assert_allclose(dataset.amplitude[0, k], expected, rtol=1e-10)
    assert float(dataset.active_rows.max()) == 0.0
    assert float(np.abs(dataset.dissipated).max()) == 0.0
    assert float(dataset.share_stick.min()) == 1.0


@pytest.mark.parametrize("name", ["one mass", "three masses", "twenty masses"])
def test_contacts_without_friction_are_not_there(name):
    problem, band = PROBLEMS[name], hertz(*BANDS[name])
    smooth = problem.with_contacts(lambda c: c.with_law(Macroslip(c.law.kt, 0.0, normal_load=1.0)))
    dataset = forced_response(smooth, band, harmonics=3).dataset
    for k in range(dataset.sizes["point"]):
        expected = linear_amplitude(problem, problem.structure.K, float(dataset.frequency[0, k]))
        np.testing.assert_allclose(dataset.amplitude[0, k], expected, rtol=1e-8)


def oscillator_with_gap(gap: float) -> Problem:
    structure = Structure(np.eye(1), np.eye(1), ("1.x",), C=np.array([[0.05]]))
    contact = Contact("stop", Gap(1.0, gap), normal=between("1.x", "ground"))
    return Problem(structure, (contact,), (Force("1.x", 1.0),), ("1.x",))


def test_an_open_gap_is_not_there_and_a_closed_one_is_a_spring():
    band = radians_per_second(0.7, 1.6)
    open_, closed = (forced_response(oscillator_with_gap(g), band, 0.01, harmonics=3).dataset for g in (9.0, -9.0))
    problem = oscillator_with_gap(0.0)
    for dataset, stiffness in ((open_, np.eye(1)), (closed, 2.0 * np.eye(1))):
        for k in range(dataset.sizes["point"]):
            expected = 0.01 * linear_amplitude(problem, stiffness, float(dataset.frequency[0, k]))
            np.testing.assert_allclose(dataset.amplitude[0, k], expected, rtol=1e-9)
    assert float(np.nanmax(open_.share_open)) == 1.0
    assert float(np.nanmax(closed.share_open)) == 0.0


def test_a_gap_of_zero_is_a_bilinear_oscillator():
    """Free on one side, spring 2 on the other: resonance at ω = 2ω₁ω₂/(ω₁ + ω₂) (slightly damped), whatever the amplitude."""
    structure = Structure(np.eye(1), np.eye(1), ("1.x",), C=np.array([[0.01]]))
    contact = Contact("stop", Gap(1.0), normal=between("1.x", "ground"))
    problem = Problem(structure, (contact,), (Force("1.x", 1.0),), ("1.x",))
    small, large = (forced_response(problem, radians_per_second(1.05, 1.3), f, 15).peaks().iloc[0] for f in (0.01, 5.0))
    exact = 2.0 * np.sqrt(2.0) / (1.0 + np.sqrt(2.0))
    assert 2.0 * np.pi * small.frequency == pytest.approx(exact, rel=1e-3)
    assert large.frequency == pytest.approx(small.frequency, rel=1e-8)
    assert large.amplitude == pytest.approx(500.0 * small.amplitude, rel=1e-8)


@pytest.mark.parametrize("level", [0.05, 0.3, 1.0, 3.0, 10.0])
def test_resonance_lies_between_free_and_stuck(level):
    peak = forced_response(single_mass(), radians_per_second(0.8, 1.6), level, harmonics=5).peaks().iloc[0]
    assert 0.999 / (2.0 * np.pi) < peak.frequency < 1.4143 / (2.0 * np.pi)


def test_an_undamped_resonance_is_no_fault():
    """The linear curves pass over a resonance without viscous damping; the frictional one is finite."""
    response = forced_response(single_mass(damping=0.0, kt=0.5, limit=1.3), radians_per_second(0.8, 1.4), harmonics=1)
    assert np.isfinite(response.peaks().amplitude[0])
    assert float(response.dataset.stuck_amplitude.max()) > 100.0


KT, KN, ANGLE = 56e6, 84e6, radians(37.0)


def damper_between_platforms() -> Problem:
    """A massless damper D, free in x and y, on two platforms L and R inclined at ±37°; R is held, L is on a weak spring."""
    dofs = ("L.x", "L.y", "D.x", "D.y")
    structure = Structure(np.diag([1.0, 1.0, 0.0, 0.0]), np.diag([1e6, 1e6, 0.0, 0.0]), dofs, C=np.diag([10.0, 10.0, 0, 0]))
    c, s = cos(ANGLE), sin(ANGLE)
    law = Macroslip(KT, 0.8, KN)
    left = Contact("L", law, ({"D.x": c, "D.y": s, "L.x": -c, "L.y": -s},), {"D.x": -s, "D.y": c, "L.x": s, "L.y": -c})
    right = Contact("R", law, ({"D.x": c, "D.y": -s},), {"D.x": s, "D.y": c})
    loads = (Force("L.x", 1.0), Force("L.y", -0.5j), Force("D.y", static=80.0))
    return Problem(structure, (left, right), loads, ("L.x", "L.y"), "Damper between platforms")


def test_stiffness_of_a_stuck_damper():
    """k_H = kt kn/(2(kt sin²α + kn cos²α)), k_V with sin and cos exchanged, no cross term; 31.8444936, 35.5603523 N/µm."""
    c2, s2 = cos(ANGLE) ** 2, sin(ANGLE) ** 2
    horizontal, vertical = KT * KN / (2.0 * (KT * s2 + KN * c2)), KT * KN / (2.0 * (KT * c2 + KN * s2))
    assert (horizontal, vertical) == pytest.approx((31.8444936e6, 35.5603523e6), rel=1e-8)
    K = damper_between_platforms().stuck_stiffness
    condensed = K[:2, :2] - K[:2, 2:] @ np.linalg.solve(K[2:, 2:], K[2:, :2])
    np.testing.assert_allclose(condensed - 1e6 * np.eye(2), np.diag([horizontal, vertical]), atol=1e-3)


def test_small_vibration_sees_the_stuck_damper():
    """Massless degrees of freedom, static pull and dynamics together: L vibrates as on the springs k_H, k_V."""
    problem = damper_between_platforms()
    response = forced_response(problem, hertz(800.0, 1100.0), 1e-3, harmonics=3)
    dataset = response.dataset
    for k in range(0, dataset.sizes["point"], 5):
        omega = 2.0 * np.pi * float(dataset.frequency[0, k])
        dynamic = np.array([31.8444936e6, 35.5603523e6]) + 1e6 - omega**2 + 10j * omega
        np.testing.assert_allclose(dataset.amplitude[0, k], np.abs(1e-3 * np.array([1.0, 0.5]) / dynamic), rtol=1e-6)
    static = dataset.contact_force[0, 0, :, :, 0, 0].sel(direction=["t1", "n"]).to_numpy()
    pushed = static[:, 1] * cos(ANGLE) + static[:, 0] * np.array([1.0, -1.0]) * sin(ANGLE)
    assert pushed.sum() == pytest.approx(80.0, rel=1e-9), "the contacts carry the pull"


def test_slider_offset_moves_the_mean_and_nothing_else_while_stuck():
    problem = damper_between_platforms()
    moved = problem.with_start(SliderOffset(1e-8))
    plain, other = (forced_response(p, [900.0], 1e-3, harmonics=3).dataset for p in (problem, moved))
    np.testing.assert_allclose(other.amplitude, plain.amplitude, rtol=1e-12)
    shift = (other.response - plain.response)[0, 0, :, 0, 0]
    assert float(np.abs(shift).max()) > 1e-10
