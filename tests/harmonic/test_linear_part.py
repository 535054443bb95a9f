"""The linear part: modal sums against the dynamic stiffness solved directly, for every kind of damping."""

from dataclasses import replace

import numpy as np
import pytest
from harmonic.problems import everything, structure

from stickslip.harmonic.fourier import complex_harmonics
from stickslip.harmonic.linear_part import DirectPart, LinearPart, ModalPart, linear_part
from stickslip.problem import Problem
from stickslip.rigs import three_mass_wedge

H = 4


def massless(problem: Problem) -> Problem:
    M = problem.structure.M.copy()
    M[4:, 4:] = 0.0
    return problem.with_structure(replace(problem.structure, M=M))


def symmetric_damping(size: float, seed: int = 0) -> np.ndarray:
    root = np.random.default_rng(seed).standard_normal((6, 6))
    return size * root @ root.T


CASES = {
    "proportional": everything(),
    "undamped": everything(C=np.zeros((6, 6))),
    "general": everything(C=symmetric_damping(0.05)),
    "overdamped": everything(C=symmetric_damping(3.0)),
    "some overdamped": everything(C=np.diag([20.0, 0.01, 0.02, 15.0, 0.1, 0.0])),
    "gyroscopic": everything(C=symmetric_damping(0.05) + 0.3 * np.triu(np.ones((6, 6)), 1) - 0.3 * np.tril(np.ones((6, 6)), -1)),
    "massless": massless(everything()),
    "massless, general": massless(everything(C=symmetric_damping(0.05))),
    "wedge": three_mass_wedge(),
}
OMEGAS = {name: (0.05, 0.9, 1.7, 6.0) if name != "wedge" else (600.0, 1020.0, 1400.0) for name in CASES}


def both(name: str) -> tuple[LinearPart, LinearPart]:
    problem = CASES[name]
    return linear_part(problem, H), DirectPart(problem, H)


def close(found, expected) -> None:
    np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())


def motions(part: LinearPart, problem: Problem, omega: float, level: float = 2.0) -> list[np.ndarray]:
    rows = problem.B.shape[0]
    forces = np.random.default_rng(3).standard_normal((rows, 2 * H + 1))
    w, by_omega, by_level = (np.empty((rows + problem.output_rows.shape[0], 2 * H + 1)) for _ in range(3))
    part.motion(forces, omega, level, w, by_omega, by_level)
    return [w, by_omega, by_level, part.change(forces, omega), part.whole_motion(forces, omega, level)]


@pytest.mark.parametrize("name", CASES)
def test_modal_sums_equal_direct_solutions(name):
    modal, direct = both(name)
    assert isinstance(modal, ModalPart)
    for omega in OMEGAS[name]:
        for found, expected in zip(*(motions(part, CASES[name], omega) for part in (modal, direct)), strict=True):
            close(found, expected)


@pytest.mark.parametrize("name", CASES)
def test_receptance_and_its_transpose_equal_direct_solutions(name):
    modal, direct = both(name)
    problem = CASES[name]
    rows = problem.B.shape[0] + problem.output_rows.shape[0]
    some, columns = np.array([0, 2, rows - 1]), np.array([1, 3])
    weights = np.random.default_rng(5).standard_normal((rows, 2 * H + 1))
    for omega in OMEGAS[name]:
        close(modal.receptance(omega, H, some, columns), direct.receptance(omega, H, some, columns))
        close(modal.pulled(omega, weights, columns), direct.pulled(omega, weights, columns))


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("which", [0, 1], ids=["chosen", "direct"])
def test_motion_solves_the_equations_of_motion(name, which):
    """(K' + i h ω C − h²ω² M) q_h = p_h − Bᵀλ_h for the whole motion; contact rows and outputs are B q and rows of q."""
    part, problem = both(name)[which], CASES[name]
    for omega in OMEGAS[name]:
        w, *_, q = motions(part, problem, omega)
        forces = np.random.default_rng(3).standard_normal((problem.B.shape[0], 2 * H + 1))
        right = complex_harmonics(problem.load(H, 2.0) - problem.B.T @ forces)
        for h, (q_h, p_h) in enumerate(zip(complex_harmonics(q).T, right.T, strict=True)):
            dynamic = problem.stuck_stiffness + 1j * h * omega * problem.C - (h * omega) ** 2 * problem.structure.M
            np.testing.assert_allclose(dynamic @ q_h, p_h, atol=1e-9 * np.abs(right).max())
        close(w, np.vstack([problem.B, problem.output_rows]) @ q)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("which", [0, 1], ids=["chosen", "direct"])
def test_derivatives_of_the_motion(name, which):
    part, problem = both(name)[which], CASES[name]
    for omega in OMEGAS[name]:
        step = 1e-6 * omega
        _, by_omega, by_level, *_ = motions(part, problem, omega)
        ahead, behind = (motions(part, problem, omega + s * step)[0] for s in (1.0, -1.0))
        np.testing.assert_allclose(by_omega, (ahead - behind) / (2.0 * step), atol=1e-5 * np.abs(by_omega).max())
        more, less = (motions(part, problem, omega, level)[0] for level in (3.0, 1.0))
        np.testing.assert_allclose(by_level, 0.5 * (more - less), atol=1e-9 * np.abs(more).max())


@pytest.mark.parametrize("name", CASES)
def test_pulled_is_the_transpose_of_the_change(name):
    """weights · (−G'δλ) = pulled · δλ."""
    problem = CASES[name]
    rng, rows = np.random.default_rng(6), problem.B.shape[0]
    weights = rng.standard_normal((rows + problem.output_rows.shape[0], 2 * H + 1))
    forces = rng.standard_normal((rows, 2 * H + 1))
    for part in both(name):
        for omega in OMEGAS[name]:
            along = np.vdot(weights, part.change(forces, omega))
            assert np.vdot(part.pulled(omega, weights, np.arange(rows)), forces) == pytest.approx(along, rel=1e-9)


def critically_damped() -> Problem:
    """One motion with a double pole of a single eigenvector, fed by another through an unsymmetric C."""
    plain = structure()
    stuck = everything().stuck_stiffness
    squares, shapes = np.linalg.eigh(np.linalg.solve(np.diag(np.sqrt(np.diag(plain.M))), stuck) / np.sqrt(np.diag(plain.M)))
    modes = shapes / np.sqrt(np.diag(plain.M))[:, None]
    damping = np.diag(0.02 * np.sqrt(squares))
    damping[0, 0] = 2.0 * np.sqrt(squares[0])
    damping[0, 1] = 0.3
    inverse = np.linalg.inv(modes)
    return everything(C=inverse.T @ damping @ inverse)


def test_critical_damping_falls_back_to_direct_solutions():
    """Coalescing poles have dependent eigenvectors; the fall-back is right, as the test of its equations of motion shows."""
    problem = critically_damped()
    part = linear_part(problem, H)
    assert isinstance(part, DirectPart)
    for omega in (0.3, 1.0, 2.0):
        q = motions(part, problem, omega)[-1]
        forces = np.random.default_rng(3).standard_normal((problem.B.shape[0], 2 * H + 1))
        right = complex_harmonics(problem.load(H, 2.0) - problem.B.T @ forces)
        dynamic = problem.stuck_stiffness + 2j * omega * problem.C - (2.0 * omega) ** 2 * problem.structure.M
        np.testing.assert_allclose(dynamic @ complex_harmonics(q)[:, 2], right[:, 2], atol=1e-12)


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-9, 1e-12, 0.0])
def test_close_to_critical_damping_is_right_too(distance):
    """Whatever part is chosen near coalescence, it solves the equations of motion."""
    critical = critically_damped()
    problem = critical.with_damping(critical.C + distance * np.diag(np.diag(critical.C)))
    part = linear_part(problem, H)
    q = motions(part, problem, 1.0)[-1]
    direct = motions(DirectPart(problem, H), problem, 1.0)[-1]
    np.testing.assert_allclose(q, direct, atol=1e-8 * np.abs(direct).max())
