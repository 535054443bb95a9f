"""The linear part: modal sums against the dynamic stiffness solved directly, for every kind of damping."""

from dataclasses import replace

import numpy as np
import pytest
from balance.compiled_parts import pulled_of, receptance_of
from balance.direct_part import DirectPart
from balance.problems import everything, structure

from stickslip.model.loads import BaseMotion, Force
from stickslip.model.problem import Problem
from stickslip.model.rigs import lumped_blisk, three_mass_wedge
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.matrices import Structure
from stickslip.solve.balance.fourier import complex_harmonics
from stickslip.solve.balance.linear_part import LinearPart, schur_states, states, stuck_modes
from stickslip.solve.balance.receptance import BLOCK_FIRST

H = 4


def massless(problem: Problem) -> Problem:
    M = problem.structure.M.copy()
    M[4:, 4:] = 0.0
    return problem.with_structure(replace(problem.structure, M=M))


def shaken(problem: Problem) -> Problem:
    """With an unbalance and a base whose displacement is given, beside constant forces."""
    base = BaseMotion({"1.x": 1.0, "2.x": 1.0}, {1: 0.2 - 0.1j, 3: 0.02j}, of="displacement")
    return problem.with_forces((*problem.forces, Force("2.x", 0.3j, omega_power=2), base, Force("3.y", 0.2, omega_power=1)))


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
    "held mean": replace(everything(), mean_springs=(Spring({everything().structure.dofs[0]: 1.0}, 0.7),)),
    "loads by the frequency": shaken(everything()),
    "wedge": three_mass_wedge(),
    "disk": lumped_blisk(),
    "whole disk": lumped_blisk(sectors=6).full(),
}
FAST = {"wedge": (600.0, 1020.0, 1400.0), "disk": (400.0, 935.0, 1400.0), "whole disk": (400.0, 935.0)}
OMEGAS = {name: FAST.get(name, (0.05, 0.9, 1.7, 6.0)) for name in CASES}


def both(name: str) -> tuple[LinearPart, DirectPart]:
    problem = CASES[name]
    return LinearPart(problem, H), DirectPart(problem, H)


def assert_close(found, expected) -> None:
    np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())


def motions(part: LinearPart | DirectPart, problem: Problem, omega: float, level: float = 2.0) -> list[np.ndarray]:
    rows = problem.B.shape[0]
    forces = np.random.default_rng(3).standard_normal((rows, 2 * H + 1))
    w = part.motion(forces, omega, level)
    by_omega, by_level = (part.slope(forces, omega, level, by_level) for by_level in (False, True))
    return [w, by_omega, by_level, part.change(forces, omega), part.whole_motion(forces, omega, level)]


@pytest.mark.parametrize("name", CASES)
def test_modal_sums_equal_direct_solutions(name):
    modal, direct = both(name)
    for omega in OMEGAS[name]:
        for found, expected in zip(*(motions(part, CASES[name], omega) for part in (modal, direct)), strict=True):
            assert_close(found, expected)


@pytest.mark.parametrize("name", CASES)
def test_receptance_and_its_transpose_equal_direct_solutions(name):
    modal, direct = both(name)
    problem = CASES[name]
    rows = problem.B.shape[0] + problem.output_rows.shape[0]
    some, columns = np.array([0, 2, rows - 1]), np.array([1, 3])
    weights = np.random.default_rng(5).standard_normal((rows, 2 * H + 1))
    for omega in OMEGAS[name]:
        assert_close(receptance_of(modal, omega, H, some, columns), direct.receptance(omega, H, some, columns))
        assert_close(pulled_of(modal, omega, weights, columns), direct.pulled(omega, weights, columns))


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("which", [0, 1], ids=["chosen", "direct"])
def test_motion_solves_the_equations_of_motion(name, which):
    """(K' + i h ω C − h²ω² M) q_h = p_h − Bᵀλ_h for the whole motion; contact rows and outputs are B q and rows of q."""
    part, problem = both(name)[which], CASES[name]
    for omega in OMEGAS[name]:
        w, *_, q = motions(part, problem, omega)
        forces = np.random.default_rng(3).standard_normal((problem.B.shape[0], 2 * H + 1))
        given, pushed = complex_harmonics(problem.load(H, 2.0, omega)), complex_harmonics(forces)
        for h, q_h in enumerate(complex_harmonics(q).T):
            system = problem.systems.at(h)
            dynamic = system.K + 1j * h * omega * system.C - (h * omega) ** 2 * system.M
            right = given[:, h] - system.B.conj().T @ pushed[:, h]
            np.testing.assert_allclose(dynamic @ q_h, right, atol=1e-9 * np.abs(pushed).max())
            seen = np.vstack([system.B, system.outputs]) @ q_h
            # Of harmonic 0 only the real part is kept.
            assert_close(complex_harmonics(w)[:, h], seen.real if h == 0 else seen)


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
    modal, direct = both(name)
    for omega in OMEGAS[name]:
        by_modes, by_solving = (np.vdot(weights, part.change(forces, omega)) for part in (modal, direct))
        assert np.vdot(pulled_of(modal, omega, weights, np.arange(rows)), forces) == pytest.approx(by_modes, rel=1e-9)
        assert np.vdot(direct.pulled(omega, weights, np.arange(rows)), forces) == pytest.approx(by_solving, rel=1e-9)


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


def takes_the_triangular_form(problem: Problem) -> bool:
    return bool(LinearPart(problem, H).modes.above.any())


def test_critical_damping_takes_the_triangular_form():
    """Coalescing poles have dependent eigenvectors; the Schur form needs none."""
    problem = critically_damped()
    part, direct = LinearPart(problem, H), DirectPart(problem, H)
    assert takes_the_triangular_form(problem)
    rows = np.arange(problem.B.shape[0])
    for omega in (0.3, 1.0, 2.0):
        for found, expected in zip(motions(part, problem, omega), motions(direct, problem, omega), strict=True):
            assert_close(found, expected)
        assert_close(receptance_of(part, omega, H, rows, rows), direct.receptance(omega, H, rows, rows))


def test_the_choice_of_the_form_does_not_depend_on_rounding():
    """Other last bits of C, as another processor has them: critical damping keeps the triangular form, any other its modes."""
    rng, critical = np.random.default_rng(1), critically_damped()
    beside = critical.with_damping(critical.C + 1e-6 * np.diag(np.diag(critical.C)))
    for _ in range(20):
        rounding = 1.0 + 4e-16 * rng.standard_normal((6, 6))
        assert takes_the_triangular_form(critical.with_damping(critical.C * rounding))
        for plain in (beside, CASES["general"], CASES["overdamped"], CASES["gyroscopic"], CASES["massless, general"]):
            assert not takes_the_triangular_form(plain.with_damping(plain.C * rounding))


def test_an_undamped_motion_beside_damped_ones_keeps_its_modes():
    """Its pole lies exactly on the imaginary axis, at a frequency 1 that has no rounding; its neighbours are damped together."""
    M, K = np.eye(3), np.array([[1.0, 0.0, 0.0], [0.0, 3.0, -1.0], [0.0, -1.0, 2.0]])
    C = np.array([[0.0, 0.0, 0.0], [0.0, 0.2, 0.05], [0.0, 0.05, 0.1]])
    dofs = ("1.x", "1.y", "1.z")
    problem = Problem(Structure(M, K, dofs, C), (), (Force("1.x", 1.0), Force("1.z", 1.0)), dofs)
    part, direct = LinearPart(problem, H), DirectPart(problem, H)
    assert not part.modes.above.any()
    for omega in (0.9, 1.1, 2.0):
        none = np.zeros((0, 2 * H + 1))
        assert_close(part.motion(none, omega, 2.0), direct.motion(none, omega, 2.0))


@pytest.mark.parametrize("name", ["general", "overdamped", "some overdamped", "gyroscopic", "massless, general"])
def test_the_triangular_form_equals_direct_solutions_for_any_damping(name, monkeypatch):
    monkeypatch.setattr("stickslip.solve.balance.linear_part._complex_states", lambda *whatever: None)
    problem = CASES[name]
    part, direct = LinearPart(problem, H), DirectPart(problem, H)
    modes = stuck_modes(problem.structure.M, problem.stuck_stiffness)
    blocks = schur_states(problem.systems.at(0), modes, modes.shapes.T @ problem.C @ modes.shapes).kind == BLOCK_FIRST
    assert blocks.any() or name == "overdamped"
    for omega in OMEGAS[name]:
        for found, expected in zip(*(motions(one, problem, omega) for one in (part, direct)), strict=True):
            assert_close(found, expected)


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-9, 1e-12, 0.0])
def test_close_to_critical_damping_is_right_too(distance):
    """Whatever form is chosen near coalescence, it solves the equations of motion."""
    critical = critically_damped()
    problem = critical.with_damping(critical.C + distance * np.diag(np.diag(critical.C)))
    q = motions(LinearPart(problem, H), problem, 1.0)[-1]
    direct = motions(DirectPart(problem, H), problem, 1.0)[-1]
    np.testing.assert_allclose(q, direct, atol=1e-8 * np.abs(direct).max())


def test_a_problem_is_decoupled_once_for_balances_of_any_harmonics(monkeypatch):
    seen = []
    monkeypatch.setattr("stickslip.solve.balance.linear_part.states", lambda system: seen.append(system) or states(system))
    problem = three_mass_wedge()
    for one, harmonics in ((problem, 1), (problem, 5), (three_mass_wedge(), 1)):
        LinearPart(one, harmonics)
    assert len(seen) == 2
