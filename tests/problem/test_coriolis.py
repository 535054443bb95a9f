"""Coriolis forces: rigid bodies against their particles, whirling masses, beams and rings in closed form, friction in time."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg

import stickslip as ss
from stickslip.model.problem.speed import SpeedDependence
from stickslip.model.problem.systems import truncated
from stickslip.model.structure.assembly import assemble
from stickslip.model.structure.centrifugal import RotationAxis, coriolis, cross
from stickslip.model.structure.modes import Modes, gyroscopic_modes, natural_modes
from stickslip.solve.balance.resonances import Resonances

SPEED = 7.0
"""rad/s"""


def turns(omega):
    """rev/min."""
    return 60.0 * omega / (2.0 * np.pi)


def test_of_bodies_and_nodes_they_are_those_of_their_particles():
    """2 Σ m Aᵀ [Ω]ₓ A over the particles, A their motion; the nodes of a solid share mass, and rows stand in any order."""
    rng = np.random.default_rng(5)
    axis = RotationAxis.of(((0.3, -0.2, 0.5), rng.normal(size=3)))
    E = cross(np.array(axis.direction))
    M, G = np.zeros((12, 12)), np.zeros((12, 12))
    for mass, place in zip(rng.uniform(0.1, 1.0, 7), rng.normal(size=(7, 3)), strict=True):
        A = np.hstack([np.eye(3), -cross(place)])
        M[:6, :6] += mass * A.T @ A
        G[:6, :6] += 2.0 * mass * A.T @ E @ A
    shared = np.array([[2.0, 0.7], [0.7, 1.0]])
    M[6:, 6:], G[6:, 6:] = np.kron(shared, np.eye(3)), 2.0 * np.kron(shared, E)
    dofs = [f"1.{d}" for d in ("x", "y", "z", "rx", "ry", "rz")] + [f"{node}.{d}" for node in (2, 3) for d in "xyz"]
    order = rng.permutation(12)
    found = coriolis(M[np.ix_(order, order)], [dofs[k] for k in order], axis).toarray()
    np.testing.assert_allclose(found, G[np.ix_(order, order)], atol=1e-13 * np.abs(G).max())
    with pytest.raises(ss.InputError, match="rotations of rigid bodies, alone, but is"):
        coriolis(np.eye(4), ["1.x", "1.y", "1.z", "1.rz"], axis)


def whirling(friction=(), speed=SPEED):
    """A mass that is held alike in both directions across its axis: ω₀ = 20 rad/s, whose spin softening K has."""
    mass, k = 2.0, 800.0
    K = np.diag([k - mass * speed**2, k - mass * speed**2])
    structure = ss.Structure(mass * np.eye(2), K, ("1.x", "1.y"), damping=ss.ModalDamping(5e-3), nodes={"1": (0.0, 0.0, 0.0)})
    turning, _ = ss.in_rotation(structure, turns(speed), "z", with_coriolis=True)
    return ss.Problem(turning, friction, (ss.Force("1.x", 1.0),), ("1.x", "1.y"))


def test_a_whirling_mass_has_two_frequencies():
    """ω₀ − Ω and ω₀ + Ω in the rotating frame, and the response that the equations give."""
    problem = whirling()
    np.testing.assert_allclose(2.0 * np.pi * problem.frequencies(stuck=True), [20.0 - SPEED, 20.0 + SPEED], rtol=1e-12)
    response = ss.forced_response(problem, ss.radians_per_second(6.0, 37.0), 1.0, harmonics=1, samples=16)
    for output in ("1.x", "1.y"):
        peaks = response.peaks().query(f"output == '{output}'")
        np.testing.assert_allclose(np.sort(2.0 * np.pi * peaks["frequency"]), [20.0 - SPEED, 20.0 + SPEED], rtol=1e-3)
    structure, dataset = problem.structure, response.dataset
    point = response.peak_point()
    omega = 2.0 * np.pi * float(dataset.frequency[0, point])
    G = 2.0 * SPEED * 2.0 * np.array([[0.0, -1.0], [1.0, 0.0]])
    X = np.linalg.solve(structure.K + 1j * omega * (problem.structural_damping + G) - omega**2 * structure.M, [1.0, 0.0])
    found = dataset.response.values[0, point, :, 1]
    np.testing.assert_allclose(found[:, 0] + 1j * found[:, 1], X, rtol=1e-6)
    turned, _ = ss.in_rotation(structure, turns(SPEED), ((0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), with_coriolis=True)
    np.testing.assert_array_equal(turned.coriolis, -structure.coriolis)
    assert problem.fingerprint != problem.with_structure(turned).fingerprint


def test_resonances_are_those_with_them_and_real_without():
    """Rounding leaves a skew part in matrices of modal damping, which is none of them."""
    turning = Resonances(whirling(), 1)
    np.testing.assert_allclose(np.unique(turning.omega.round(6)), [20.0 - SPEED, 20.0 + SPEED], rtol=1e-6)
    half = np.random.default_rng(0).normal(size=(12, 12))
    dofs = tuple(f"{k}.x" for k in range(12))
    K = half @ half.T + np.eye(12)
    C = 0.01 * K
    C[0, 1] *= 1.0 + 1e-14
    structure = ss.Structure(np.eye(12), K, dofs, C=C)
    still = Resonances(ss.Problem(structure, (), (ss.Force("1.x", 1.0),), ("1.x",)), 1)
    assert np.isrealobj(still.limits[0].sizes)
    assert np.isrealobj(still.limits[0].shapes)


def test_with_friction_harmonic_balance_and_time_agree():
    rubbing = ss.Contact("rub", ss.Macroslip(400.0, 0.3, normal_load=2.0), (ss.between("1.x", "ground"),))
    response = ss.forced_response(whirling((rubbing,)), ss.radians_per_second(10.0, 36.0), 1.0, harmonics=9, samples=512)
    assert response.verify_in_time(0, response.peak_point(), steps_per_period=1000).agrees(3e-3)
    with pytest.raises(ss.InputError, match="must be of a problem without Coriolis forces"):
        ss.nonlinear_modes(response.problem, 1)
    assert float(np.nanmax(np.abs(response.dataset.energy_residual))) < 1e-6


def ring(count=60, radius=1.0):
    """A thin inextensible ring in its plane."""
    angles = 2.0 * np.pi * np.arange(count) / count
    points = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    K = np.zeros((2 * count, 2 * count))
    for k in range(count):
        before, own, after = (k - 1) % count, k, (k + 1) % count
        along = (points[after] - points[own]) / np.linalg.norm(points[after] - points[own])
        stretch = np.zeros((count, 2))
        stretch[after], stretch[own] = along, -along
        K += 1e6 * np.outer(stretch, stretch)
        bent = np.zeros((count, 2))
        bent[before], bent[own], bent[after] = points[own], -2.0 * points[own], points[own]
        K += 1.0 * np.outer(bent, bent)
    dofs = tuple(f"{k}.{d}" for k in range(count) for d in "xy")
    nodes = {str(k): (x, y, 0.0) for k, (x, y) in enumerate(points.tolist())}
    return ss.Structure(np.eye(2 * count) / count, K, dofs, nodes=nodes)


def test_a_ring_has_two_travelling_waves():
    """Of n waves round a thin ring, both frequencies are 4 n Ω/(n² + 1) apart in the rotating frame (G. H. Bryan, 1890)."""
    still = natural_modes(ring().M, ring().K)
    rate = 1e-3 * np.sqrt(still.squares[3])
    turning, _ = ss.in_rotation(ring(), turns(rate), "z", with_coriolis=True)
    omega = np.sqrt(gyroscopic_modes(still, turning.coriolis).squares)
    for first, waves in ((3, 2), (5, 3)):
        apart = (omega[first + 1] - omega[first]) / rate
        assert apart == pytest.approx(4.0 * waves / (waves**2 + 1.0), rel=0.01)


def test_a_campbell_diagram_of_a_ring_has_both_waves_and_says_which_way_each_circles():
    """Radial and tangential motion are as 1 to 1/n: a wave circles by 2/n over 1 + 1/n², the slower one with the rotation."""
    rate = 1e-3 * np.sqrt(natural_modes(ring().M, ring().K).squares[3])
    held = replace(ring(), K=ring().K + (100.0 * rate) ** 2 * ring().M)
    turning, _ = ss.in_rotation(held, turns(rate), "z", with_coriolis=True)
    models = [ss.Problem(structure, (), (ss.Force("0.x", 1.0),), ("0.x",)) for structure in (held, turning)]
    found = ss.campbell({0.0: models[0], turns(rate): models[1]}, (0.0, turns(4.0 * rate)), [1], mode=[4, 5, 6, 7], points=5)
    omega = 2.0 * np.pi * found.dataset["frequency"].sel(state="stuck", engine_order=1).values
    circling = found.dataset["whirl"].sel(state="stuck", engine_order=1).values
    for first, waves in ((0, 2), (2, 3)):
        apart = 4.0 * waves / (waves**2 + 1.0) * np.arange(5) * rate
        np.testing.assert_allclose(omega[first + 1] - omega[first], apart, rtol=0.01, atol=1e-6 * omega[first, 0])
        np.testing.assert_allclose(circling[first, 1:], 2.0 * waves / (waves**2 + 1.0), rtol=0.01)
        np.testing.assert_allclose(circling[first + 1, 1:], -2.0 * waves / (waves**2 + 1.0), rtol=0.01)


def test_engine_orders_meet_both_whirls_where_the_closed_form_says():
    """EO Ω = ω₀ − Ω, the motion with the rotation, and EO Ω = ω₀ + Ω against it; K and G from one speed serve all others."""
    models = {turns(speed): whirling(speed=speed) for speed in (3.0, SPEED)}
    found = ss.campbell(models, (0.0, turns(18.0)), [1, 2, 4]).dataset.sel(state="stuck")
    omega = found["speed"].values * np.pi / 30.0
    for order in (1, 2, 4):
        one = found.sel(engine_order=order)
        np.testing.assert_allclose(2.0 * np.pi * one["frequency"].values, [20.0 - omega, 20.0 + omega], rtol=1e-9)
        np.testing.assert_allclose(one["whirl"].values[:, 1:], [[1.0] * 10, [-1.0] * 10], rtol=1e-9)
        met = [turns(20.0 / (order + 1.0)), turns(20.0 / (order - 1.0)) if order > 2 else np.nan]
        np.testing.assert_allclose(one["crossing_speed"].values, met, rtol=1e-7)
    slow = whirling(speed=3.0)
    wrong = slow.with_structure(replace(slow.structure, coriolis=2.0 * slow.structure.coriolis))
    with pytest.raises(ss.InputError, match="differ in Coriolis forces per speed"):
        ss.campbell({turns(3.0): wrong, turns(SPEED): models[turns(SPEED)]}, (60.0, 90.0), [2])


def test_gyroscopic_modes_solve_their_equation():
    """(−ω² M + i ω G + K) φ = 0, also with a free motion; φ has the energy of a mode of unit mass, φᴴ(K + ω² M)φ = 2 ω²."""
    rng = np.random.default_rng(2)
    M, half, wide = np.diag(rng.uniform(0.5, 2.0, 4)), rng.normal(size=(4, 3)), rng.normal(size=(4, 4))
    K, G = half @ half.T, wide - wide.T
    modes = gyroscopic_modes(natural_modes(M, K), G)
    for omega, shape in zip(np.sqrt(modes.squares), modes.shapes.T, strict=True):
        error = (-(omega**2) * M + 1j * omega * G + K) @ shape
        assert np.linalg.norm(error) < 1e-6 * np.linalg.norm(G @ shape) + 1e-7
        assert (shape.conj() @ (K + omega**2 * M) @ shape).real == pytest.approx(2.0 * omega**2, rel=1e-6, abs=1e-6)
    same = gyroscopic_modes(Modes(*linalg.eigh(K + np.eye(4), M)), np.zeros((4, 4)))
    np.testing.assert_allclose(same.squares, linalg.eigvalsh(K + np.eye(4), M), rtol=1e-9)


def test_over_the_speed_and_on_a_moving_base_they_are_refused():
    """They belong to one speed, and would act on the velocity of the base, too."""
    problem = whirling()
    for use in (
        lambda: replace(problem, speed=SpeedDependence(2)),
        lambda: replace(problem, forces=(ss.BaseMotion({"1.x": 1.0, "1.y": 0.0}, 1.0),)),
        lambda: ss.speed_sweep({50.0: problem, 100.0: problem}, (60.0, 90.0), [2]),
    ):
        with pytest.raises(ss.InputError, match="Coriolis forces"):
            use()


def test_they_follow_assemblies_and_few_coordinates():
    turning = whirling().structure
    pair = assemble({name: turning.with_damping(None) for name in ("a", "b")})
    np.testing.assert_array_equal(pair.coriolis, linalg.block_diag(turning.coriolis, turning.coriolis))
    springs = [ss.Contact(f"{name}", ss.CubicSpring(1.0), ({f"{name}/1.x": 1.0},)) for name in ("a", "b")]
    problem = ss.Problem(pair.with_damping(ss.ModalDamping(5e-3)), springs, (ss.Force("a/1.x", 1.0),), ("a/1.y",))
    few = truncated(problem, 100.0)
    np.testing.assert_allclose(few.frequencies(stuck=True)[:4], np.repeat([13.0, 27.0], 2) / (2.0 * np.pi), rtol=1e-9)
