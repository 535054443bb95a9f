"""Nonlinear modes satisfy their equation of motion, evaluated anew with full matrices and contacts marched in plain Python."""

import numpy as np
import pytest
from balance.full_balance import marched_forces

import stickslip as ss
from robustness.problems import CLASSES, random_case
from stickslip.solve.balance.fourier import complex_harmonics
from stickslip.solve.balance.mode_balance import ModeBalance, mode_energy
from stickslip.solve.continuation.newton import fixed
from stickslip.solve.curves.mode_curve import solve_mode
from stickslip.support.outcome import Outcome

PROBLEMS = {
    **{f"{kind}, {seed}": random_case(kind, seed).problem for kind in CLASSES[:4] for seed in range(3)},
    "wedge": ss.rigs.three_mass_wedge(),
    "wedge, ratio": ss.rigs.three_mass_wedge(0.5),
    "chain": ss.rigs.chain(6, sliders=(4, 5, 6), forced=3),
}


def curve_of(problem: ss.Problem, extended: int, mode: int = 0):
    """A curve over two decades of the modal amplitude, whatever contacts do at its start."""
    balance = ModeBalance(problem, 3, 64, mode, extended)
    size = np.max(np.abs(balance.shape[: balance.rows]))
    return balance, solve_mode(balance, balance.level_of(0.1 / size), balance.level_of(10.0 / size))


@pytest.mark.parametrize("extended", [1, 3])
@pytest.mark.parametrize("name", PROBLEMS)
def test_points_solve_the_extended_equation(name, extended):
    """−(hω)²M Q + ihω(C − 2ζωM) Q + K Q + BᵀF = static loads; the second term of ζ up to harmonic `extended`."""
    problem = PROBLEMS[name]
    balance, curve = curve_of(problem, extended)
    assert len(curve.points) >= 2 or curve.outcome != Outcome.CONVERGED
    for point in curve.points[:: max(len(curve.points) // 3, 1)]:
        omega, zeta = balance.omega_of(point.point), balance.damping_of(point.point)
        q = balance.whole_motion(point.evaluation)
        forces = complex_harmonics(problem.B.T @ marched_forces(problem, problem.B @ q, 64)).T
        static, scale, gaps = problem.static_load, 0.0, []
        for h, (q_h, f_h) in enumerate(zip(complex_harmonics(q).T, forces, strict=True)):
            C = problem.C - (2.0 * zeta * omega * problem.structure.M if 1 <= h <= extended else 0.0)
            terms = -((h * omega) ** 2) * problem.structure.M @ q_h, 1j * h * omega * C @ q_h, problem.structure.K @ q_h, f_h
            scale = max(scale, *(np.abs(term).max() for term in terms), np.abs(static).max())
            gaps.append(np.abs(sum(terms) - (static if h == 0 else 0.0)).max())
        assert max(gaps) < 1e-8 * scale


@pytest.mark.parametrize("extended", [1, 3])
@pytest.mark.parametrize("name", ["varying load, 0", "lift-off, 2", "wedge", "chain"])
def test_the_damping_ratio_is_the_dissipated_energy(name, extended):
    """Work of friction along its hysteresis loops and of C over a period equals what −2ζωM feeds in."""
    problem = PROBLEMS[name]
    balance, curve = curve_of(problem, extended)
    for point in curve.points[:: max(len(curve.points) // 5, 1)]:
        omega, zeta = balance.omega_of(point.point), balance.damping_of(point.point)
        q = complex_harmonics(balance.whole_motion(point.evaluation))
        order = np.arange(q.shape[1])
        speed = 1j * order * omega * q
        quadratic = [np.real(np.einsum("nh,nm,mh->h", speed.conj(), A, speed)) for A in (problem.C, problem.structure.M)]
        period = 2.0 * np.pi / omega
        lost = 0.5 * period * quadratic[0].sum() + mode_energy(balance, point.evaluation).dissipated.sum()
        fed = 0.5 * period * 2.0 * zeta * omega * quadratic[1][1 : extended + 1].sum()
        assert lost == pytest.approx(fed, rel=1e-7, abs=1e-14)


@pytest.mark.parametrize("name", ["varying load, 1", "wedge, ratio", "chain"])
def test_the_newton_matrix_is_the_derivative(name):
    """Newton's step from a solved point that is moved a little leads back by the whole of the way: quadratic convergence."""
    balance, curve = curve_of(PROBLEMS[name], 1)
    rng = np.random.default_rng(1)
    for point in curve.points[:: max(len(curve.points) // 4, 1)]:
        place = point.point
        distances = []
        for size in (1e-5, 1e-6):
            change = size * place.forces * rng.standard_normal(place.forces.shape)
            evaluation = balance.evaluate(place.moved(change, "level", 0.0))
            condition = fixed("level", place.level)
            step, amount = balance.newton_step(evaluation, condition, balance.factorise(evaluation, condition))
            assert amount == 0.0
            left = evaluation.point.forces + step - place.forces
            distances.append(np.abs(left).max() / np.abs(change).max())
        assert min(distances) < 1e-3
