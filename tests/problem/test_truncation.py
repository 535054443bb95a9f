"""A problem on few coordinates against itself on all: matrices, curves, peaks, energies, what results remember.

Two rows of masses beside each other, each node moving along x, y and z, pressed together at every node: 18 contacts, 54 rows of
contacts, 108 degrees of freedom. It is small enough for Newton's method on all of them.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg

import stickslip as ss
from stickslip.analyses.truncation import ALL_MODES, ALLOWED, finer_balance
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact
from stickslip.model.problem import Problem
from stickslip.model.problem.systems import LEAST_SHARE, on_few_coordinates
from stickslip.model.structure.matrices import Dashpot, ModalDamping, Structure
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.linear_response import WithoutContacts, linear_amplitudes
from stickslip.solve.balance.receptance import REAL_MODE
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.continuation.finer_peak import solved_on_all_modes
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.truncation import beside
from stickslip.solve.curves.curve import solve_curve

NODES, AXES = 18, "xyz"
HERTZ, FORCE = (0.12, 0.3), 60.0
"""A band around the first mode, and a force under which about half of the contacts slip and some open."""


def two_rows(damping=None, **more):
    """Rows "a" and "b" of masses on springs: held at the left end, the right end pushed along x and z."""
    names = tuple(f"{row}{k}.{axis}" for row in "ab" for k in range(NODES) for axis in AXES)
    chain = 2.0 * np.eye(NODES) - np.eye(NODES, k=1) - np.eye(NODES, k=-1)
    chain[-1, -1] = 1.0
    K = np.kron(np.diag([150.0, 340.0]), np.kron(chain, np.diag([1.0, 1.3, 0.8])))
    contacts = tuple(
        Contact(
            str(k),
            Macroslip(kt=0.9, mu=0.4, kn=1.6, preload=0.3 + 0.2 * np.sin(k)),
            ({f"a{k}.x": 1.0, f"b{k}.x": -1.0}, {f"a{k}.y": 1.0, f"b{k}.y": -1.0}),
            {f"a{k}.z": 1.0, f"b{k}.z": -1.0},
            balanced=True,
        )
        for k in range(NODES)
    )
    structure = Structure(np.eye(len(names)), K, names, damping=damping or ModalDamping(0.01))
    forces = (ss.Force(f"a{NODES - 1}.x", 0.05), ss.Force(f"a{NODES - 1}.z", 0.03j))
    return Problem(structure, contacts, forces, (f"a{NODES - 1}.x", f"b{NODES - 1}.z"), **more)


@pytest.fixture(scope="module")
def whole():
    return two_rows()


@pytest.fixture(scope="module")
def few(whole):
    return whole.truncated(1.0)


@pytest.fixture(scope="module")
def balances(whole, few):
    return HarmonicBalance(whole, 3, 128), HarmonicBalance(few, 3, 128)


def curve_of(balance):
    return solve_curve(balance, [2.0 * np.pi * f for f in HERTZ], FORCE, exactly=False)


@pytest.fixture(scope="module")
def few_curve(balances):
    return curve_of(balances[1])


@pytest.fixture(scope="module")
def curves(balances, few_curve):
    return [curve_of(balances[0]), few_curve]


def peak_of(balance, curve, output=0):
    return max(np.hypot(*point.evaluation.w[balance.rows + output, 1:3]) for point in curve.peaks[output])


def test_the_coordinates_are_far_fewer_and_hold_the_low_modes(whole, few):
    assert few.structure.size < 0.5 * whole.structure.size
    low = whole.frequencies(stuck=True)
    low = low[low <= 1.0]
    assert len(low) > 5
    np.testing.assert_allclose(few.frequencies(stuck=True)[: len(low)], low, rtol=1e-9)
    np.testing.assert_allclose(few.frequencies(stuck=False)[:6], whole.frequencies(stuck=False)[:6], rtol=1e-4)


def test_shapes_above_the_stated_share_are_kept_and_no_others(whole, few):
    """σ² by the residual flexibility K'⁻¹ − Φ Φᵀ of the modes kept, φᵀK'φ = 1; two loads and two outputs add a shape each."""
    stuck = whole.stuck_stiffness
    squares, modes = linalg.eigh(stuck, np.eye(len(stuck)))
    low = squares <= (2.0 * np.pi * 1.0) ** 2
    residual = np.linalg.inv(stuck) - (modes[:, low] / squares[low]) @ modes[:, low].T
    root = np.sqrt(whole.contact_stiffness)[:, None] * whole.B
    shares = np.linalg.eigvalsh(root @ residual @ root.T)
    count = np.count_nonzero(shares > LEAST_SHARE)
    assert count > 5
    assert low.sum() + count <= few.structure.size <= low.sum() + count + 4
    # Motions that are K'-orthogonal to all shapes kept deform the contacts by less than the share.
    left_out = np.linalg.svd((stuck @ few.structure.shapes).T)[2][few.structure.size :].T
    below = linalg.eigh(left_out.T @ root.T @ root @ left_out, left_out.T @ stuck @ left_out, eigvals_only=True)
    assert below.max() <= LEAST_SHARE * (1.0 + 1e-6)


@pytest.mark.slow
def test_all_modes_give_the_problem_itself(whole):
    same = whole.truncated(1e3)
    frequencies = [0.1, 0.15, 0.3]
    one, other = (ss.forced_response(p, frequencies, FORCE, harmonics=3, samples=128).dataset for p in (whole, same))
    np.testing.assert_allclose(one["response"], other["response"], rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(one["loss_factor"], other["loss_factor"], rtol=1e-7)
    assert other["energy_residual"].max() < 1e-8


def test_the_motion_of_every_degree_of_freedom_comes_back(whole, few):
    y = np.linspace(1.0, 2.0, few.structure.size)
    motion = few.structure.motion(y)
    np.testing.assert_allclose(whole.B @ motion, few.B @ y, rtol=1e-12)
    np.testing.assert_allclose(whole.output_rows @ motion, few.output_rows @ y, rtol=1e-12)
    assert motion @ whole.stuck_stiffness @ motion == pytest.approx(y @ few.stuck_stiffness @ y)


def test_errors_of_harmonics_take_one_matrix_where_contacts_are_many(balances, few_curve):
    """They are those of Newton's method to a thousandth or two; at one point only that finds a way."""
    finer, ways = finer_balance(balances[1], 9, 1), []
    for point in few_curve.points[::4]:
        found = beside(finer, point.evaluation, point.across("omega"))
        assert found.solved
        ways.append(found)
    matrices = int(finer.system.effort[1])
    for found in ways:
        solution = correct(finer, found.padded.point, found.condition, 30, 10)
        assert solution.converged
        whole = np.linalg.norm(solution.evaluation.w - found.padded.w)
        assert np.linalg.norm(found.evaluation.w - solution.evaluation.w) <= 2.5e-3 * whole
    assert matrices < 0.6 * (finer.system.effort[1] - matrices)


def test_the_peak_on_few_coordinates_is_close_and_its_error_is_known(balances, curves):
    """On all modes from the peak of the few: what Newton's method on all modes traced as a curve."""
    peaks = [peak_of(*pair) for pair in zip(balances, curves, strict=True)]
    assert abs(peaks[1] / peaks[0] - 1.0) < 0.01
    whole, few = balances
    top = max(curves[1].peaks[0], key=lambda point: np.hypot(*point.evaluation.w[few.rows, 1:3]))
    assert np.count_nonzero(top.evaluation.unknown) > 15  # many contacts slip
    solution = solved_on_all_modes(whole, few, top.point, fixed("omega", top.point.omega))
    direct = correct(whole, top.point, fixed("omega", top.point.omega), iterations=30)
    assert direct.converged
    np.testing.assert_allclose(solution.w, direct.evaluation.w, rtol=1e-6, atol=1e-9 * np.abs(direct.evaluation.w).max())


@pytest.mark.slow
def test_the_response_reports_the_error_of_its_coordinates(whole, curves, balances, monkeypatch):
    monkeypatch.setattr("stickslip.model.problem.systems.MANY_ROWS", 50)
    monkeypatch.setattr("stickslip.model.problem.systems.REACH", 1.0 / (3.0 * HERTZ[1]))
    response = ss.forced_response(whole, ss.hertz(*HERTZ), FORCE, harmonics=3, samples=128)
    data = response.dataset
    assert data.attrs["coordinates"] == response.problem.structure.size < whole.structure.size
    peaks = [float(data["peak_amplitude"][0, 0, output]) for output in range(2)]
    true = [peak_of(balances[0], curves[0], output) for output in range(2)]
    np.testing.assert_allclose(data["modal_error"][0], np.array(true) / peaks - 1.0, atol=2e-4)
    assert np.abs(data["modal_error"]).max() > 1e-6
    # Results speak with the problem on all modes too, from which a study makes it again.
    again = ss.ForcedResponse(data, whole)
    place = response.peak_point()
    np.testing.assert_allclose(again.cycle(0, place).force, response.cycle(0, place).force, rtol=1e-9, atol=1e-12)
    assert again.at([0.15])["amplitude"].shape == response.at([0.15])["amplitude"].shape


def test_warnings_name_the_output_that_all_modes_change_most():
    assert not ALL_MODES.warning(("a", "b"), np.array([0.5 * ALLOWED, -0.9 * ALLOWED]))
    assert "b changes at its highest peak by -3.0 %" in ALL_MODES.warning(("a", "b"), np.array([0.01, -0.03]))
    assert "could not be solved" in ALL_MODES.warning(("a",), np.array([np.nan]))


def test_coordinates_are_uncoupled_by_modal_damping(balances):
    assert all(np.all(balance.linear.modes.kind == REAL_MODE) for balance in balances)


def test_linear_curves_of_many_contact_rows_are_those_by_rows(balances, monkeypatch):
    frequencies = np.linspace(0.4, 1.3, 450) / (2.0 * np.pi)
    for balance in balances:
        curves = []
        for by_rows in (0, balance.rows):
            monkeypatch.setattr("stickslip.solve.balance.linear_response.BY_ROWS", by_rows)
            curves.append(linear_amplitudes(balance, frequencies))
        np.testing.assert_allclose(*curves, rtol=1e-8)


def test_linear_curves_of_a_travelling_wave_are_those_by_rows(monkeypatch):
    """Of one sector, whose system is complex, of the whole wheel, and at light damping with a resonance inside."""
    disk = ss.rigs.lumped_blisk()
    for problem in (disk, disk.full()):
        balance = HarmonicBalance(problem, 1, 48)
        curves = []
        for by_rows in (0, balance.rows):
            monkeypatch.setattr("stickslip.solve.balance.linear_response.BY_ROWS", by_rows)
            curves.append(linear_amplitudes(balance, np.linspace(125.0, 160.0, 450))[0])
        np.testing.assert_allclose(*curves, rtol=1e-7)


def test_the_structure_without_contacts_is_solved_exactly_at_few_frequencies(balances, monkeypatch):
    alone = WithoutContacts.of(balances[0])
    solved, solve = [], WithoutContacts._at
    monkeypatch.setattr(WithoutContacts, "_at", lambda self, omega: (solved.append(omega), solve(self, omega))[1])
    omegas = np.linspace(0.4, 1.3, 450)
    found = alone.outputs_at(omegas)
    assert len(solved) < 20
    np.testing.assert_allclose(found[::50], [alone.outputs @ solve(alone, omega) for omega in omegas[::50]], rtol=1e-8)


def test_an_undamped_resonance_met_exactly_has_no_size():
    one = np.eye(1)
    alone = WithoutContacts(one, 0.0 * one, one, np.ones((1, 1)), one, None)
    assert np.isnan(alone.outputs_at(np.array([1.0]))).all()
    np.testing.assert_allclose(alone.outputs_at(np.array([0.5, 2.0])), [[4.0 / 3.0], [-1.0 / 3.0]], rtol=1e-12)


def test_dashpots_and_rayleigh_damping_are_projected(whole):
    damped = two_rows(
        ss.RayleighDamping(0.02, 0.001), dashpots=(Dashpot({f"a{NODES - 1}.x": 1.0, f"b{NODES - 1}.x": -1.0}, 0.3),)
    )
    few = damped.truncated(1.0)
    for problem in (damped, few):
        balance = HarmonicBalance(problem, 1, 64)
        point = first_point(balance, 0.9, 0.01)
        assert point.converged
        if problem is damped:
            known = point.evaluation.w
    np.testing.assert_allclose(point.evaluation.w[-2:], known[-2:], rtol=5e-3, atol=5e-3 * np.abs(known[-2:]).max())


def test_damping_that_couples_modes_with_the_shapes_beyond_stays_whole(monkeypatch):
    """βK alone, and a damper in C: without a part of it, C would feed energy in."""
    monkeypatch.setattr("stickslip.model.problem.systems.MANY_ROWS", 50)
    across = np.random.default_rng(2).standard_normal(6 * NODES)
    plain = two_rows()
    damper = plain.structure.K * 1e-3 + 0.02 * np.outer(across, across) / (across @ across)
    for damping in (ss.RayleighDamping(0.0, 0.02), damper):
        structure = replace(plain.structure, **({"C": damping, "damping": None} if damping is damper else {"damping": damping}))
        problem = plain.with_structure(structure)
        few = on_few_coordinates(problem, 1.0)
        assert few.structure.size < problem.structure.size
        assert np.linalg.eigvalsh(few.structure.C)[0] > -1e-12 * np.abs(few.structure.C).max()
        amplitudes = []
        for many in (50, 10**9):
            monkeypatch.setattr("stickslip.model.problem.systems.MANY_ROWS", many)
            data = ss.forced_response(problem, [0.2], 20.0, harmonics=1, samples=64).dataset
            amplitudes.append(float(data.amplitude[0, 0, 0]))
            monkeypatch.setattr("stickslip.model.problem.systems.MANY_ROWS", 50)
        assert amplitudes[0] == pytest.approx(amplitudes[1], rel=5e-3)


def test_small_problems_disks_and_moving_bases_stay_as_they_are(whole):
    small = ss.rigs.blade_and_wedge()
    assert on_few_coordinates(small, 1.0) is small
    disk = ss.rigs.lumped_blisk()
    assert on_few_coordinates(disk, 1.0) is disk
    with pytest.raises(ss.InputError, match="A full disk"):
        disk.full().truncated(1.0)
    moved = whole.with_forces([ss.BaseMotion({f"{row}{k}.x": 1.0 for row in "ab" for k in range(NODES)}, 1e-3)])
    with pytest.raises(ss.InputError, match="no base motion"):
        moved.truncated(1.0)
    with pytest.raises(ss.InputError, match="all its degrees of freedom"):
        whole.truncated(1.0).truncated(0.5)
