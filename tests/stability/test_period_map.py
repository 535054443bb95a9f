"""The parts of the period map: exact steps of modes, instants at which contacts change, and perturbations of motions that SciPy
has found, without a solution of the harmonic balance."""

from types import SimpleNamespace

import numba
import numpy as np
import pytest
from laws.kernel import contact_of
from laws.samples import KERNEL_SAMPLES
from scipy.linalg import block_diag, expm
from scipy.optimize import brentq, linear_sum_assignment
from stability.hybrid import DOWN, OPEN, STICK, UP, of_problem
from stability.test_multipliers import SLIDERS

import stickslip as ss
from stickslip.model.contact.point import SliderOffset, contact_table
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.fourier import fourier
from stickslip.solve.balance.linear_part import states
from stickslip.solve.stability.multipliers import ContactPeriod, PeriodMap, _size_change
from stickslip.solve.stability.period_map import Tangent, _block_step, block_modes, landing_rates, law_tangent
from stickslip.solve.time.contact_law import Earlier, contact_law, no_slopes
from stickslip.support.kernels import uncompiled

TURN = 2.0 * np.pi


@pytest.mark.parametrize("h", [0.01, 0.7, 4.0])
@pytest.mark.parametrize(
    "A", [[[0.0, 1.0], [-1.0, -0.1]], [[-0.3, 0.8], [-0.5, -0.2]], [[0.0, 1.0], [-1.0, -3.0]], [[-0.4, 0.0], [0.0, -2.0]]]
)
def test_a_step_of_a_block_is_its_exponential_and_two_integrals(A, h):
    """exp(Ah), h φ1 and h φ2 as blocks of the exponential of a larger matrix; by series, of complex poles and of real ones."""
    A, found = np.array(A), np.empty((3, 2, 2))
    uncompiled(_block_step)(A, h, found)
    one, nothing = np.eye(2), np.zeros((2, 2))
    whole = expm(np.block([[A * h, one, nothing], [nothing, nothing, one], [nothing, nothing, nothing]]))
    np.testing.assert_allclose(found[0], whole[:2, :2], atol=1e-12)
    np.testing.assert_allclose(found[1], h * whole[:2, 2:4], atol=1e-12)
    np.testing.assert_allclose(found[2], h * whole[:2, 4:], atol=1e-12)


DAMPING = {
    "modal": np.diag([0.1, 0.2]),
    "coupled": np.diag([0.02, 0.3]),
    "of both masses": np.array([[0.2, 0.1], [0.1, 0.06]]),
    "overcritical": np.diag([4.0, 9.0]),
}


@pytest.mark.parametrize("C", DAMPING.values(), ids=DAMPING)
def test_blocks_have_the_receptance_and_the_mobility_of_the_structure(C):
    """R (s − A)⁻¹ J + S = B (K' + sC + s²M)⁻¹ Bᵀ, with modal, coupled and overcritical damping."""
    M, K = np.diag([1.0, 2.0]), np.array([[2.0, -0.7], [-0.7, 1.5]])
    sliders = [ss.Contact(f"{n}", ss.Macroslip(0.5, 1.0, normal_load=1.0), (ss.between(f"{n}.x", "ground"),)) for n in (1, 2)]
    problem = ss.Problem(ss.Structure(M, K, ("1.x", "2.x"), C=C), sliders, (ss.Force("1.x", 1.0),), ("1.x",))
    modes, few = (block_modes(states(problem.systems.at(1)), 2, highest) for highest in (np.inf, 1.2))
    A, B = block_diag(*modes.blocks), problem.B
    for s in (0.3j, 1.1j - 0.05, 2.0):
        exact = B @ np.linalg.solve(problem.stuck_stiffness + s * C + s * s * M, B.T)
        x = np.linalg.solve(s * np.eye(len(A)) - A, modes.force)
        np.testing.assert_allclose(modes.motion @ x + modes.static, exact, atol=1e-9)
        np.testing.assert_allclose(modes.velocity @ x, s * exact, atol=1e-9)
    at_once = B @ np.linalg.solve(problem.stuck_stiffness, B.T)
    kept = few.motion @ np.linalg.solve(block_diag(*few.blocks), few.force)
    np.testing.assert_allclose(few.static - kept, at_once, atol=1e-9)


def test_the_change_of_the_size_of_an_eigenvalue_is_that_of_differences():
    rng = np.random.default_rng(3)
    matrix, change = rng.standard_normal((2, 6, 6))
    values = np.linalg.eigvals(matrix)
    largest = values[np.argmax(np.abs(values))]
    sizes = [np.abs(np.linalg.eigvals(matrix + step * change)).max() for step in (1e-6, -1e-6)]
    assert _size_change(matrix, largest, change) == pytest.approx(abs(sizes[0] - sizes[1]) / 2e-6, rel=1e-5)


def period_of(contact, w, samples=64):
    """What a contact does over a period of motion w (rows, 2H+1)."""
    names = ("1.x", "1.y", "1.z")
    structure = ss.Structure(np.eye(3), np.eye(3), names, C=0.1 * np.eye(3))
    balance = HarmonicBalance(
        ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",)), (w.shape[1] - 1) // 2, samples
    )
    return ContactPeriod(SimpleNamespace(table=balance.table, point=SimpleNamespace(omega=1.0), w=w), balance)


def instants_of(varies):
    """Angles and new states of a slider with kt = 2 and L = 1 + varies cos(θ − 0.9), of which u = cos(θ − 0.3).

    It sticks again where L − s kt u stands still, and yields where y + kt u has come to the other limit.
    """

    def limit(angle):
        return 1.0 + varies * np.cos(angle - 0.9)

    def spring(angle):
        return 2.0 * np.cos(angle - 0.3)

    found = []
    for side, turning in ((UP, 0.3), (DOWN, 0.3 + np.pi)):
        sticks = brentq(lambda t: 2.0 * np.sin(t - 0.3) - side * varies * np.sin(t - 0.9), turning - 0.7, turning + 0.7)  # noqa: B023
        held = side * limit(sticks) - spring(sticks)
        yields = brentq(lambda t: side * (held + spring(t)) + limit(t), sticks + 0.1, sticks + np.pi - 0.8)  # noqa: B023
        found += [(sticks, STICK), (yields, -side)]
    return sorted((angle % TURN, state) for angle, state in found)


@pytest.mark.parametrize("varies", [0.0, 0.4])
def test_a_slider_yields_and_sticks_at_the_instants_of_its_motion(varies):
    """Between the samples, to the fourth order; of constant and of varying load."""
    law = ss.Macroslip(2.0, 1.0, 1.0, 1.0) if varies else ss.Macroslip(2.0, 1.0, normal_load=1.0)
    normal = ss.between("1.z", "ground") if varies else None
    contact = ss.Contact("c", law, (ss.between("1.x", "ground"),), normal)
    rows = [[0.0, np.cos(0.3), np.sin(0.3)], [0.0, varies * np.cos(0.9), varies * np.sin(0.9)]]
    period = period_of(contact, np.array(rows[: 2 if varies else 1]))
    expected = instants_of(varies)
    np.testing.assert_allclose(TURN / 64 * period.instants, [angle for angle, _ in expected], atol=2e-5)
    assert period.new.tolist() == [state for _, state in expected]


@pytest.mark.parametrize("varies", [0.0, 0.4])
def test_a_disc_along_a_line_yields_and_sticks_as_a_slider_does(varies):
    """At an angle of 0.6 to its directions; each instant of yielding comes twice, just before and just after. Where the load
    varies, what the disc holds when it sticks is that of the samples, to the second order."""
    law = ss.FrictionDisc(2.0, 1.0, 1.0, 1.0) if varies else ss.FrictionDisc(2.0, 1.0, normal_load=1.0)
    normal = ss.between("1.z", "ground") if varies else None
    contact = ss.Contact("c", law, (ss.between("1.x", "ground"), ss.between("1.y", "ground")), normal)
    line, load = np.array([0.0, np.cos(0.3), np.sin(0.3)]), varies * np.array([0.0, np.cos(0.9), np.sin(0.9)])
    w = np.stack([np.cos(0.6) * line, np.sin(0.6) * line, load])[: 3 if varies else 2]
    angles = [angle for angle, state in instants_of(varies) for _ in range(1 + (state != STICK))]
    period = period_of(contact, w)
    np.testing.assert_allclose(TURN / 64 * period.instants, angles, atol=5e-4 if varies else 2e-5)
    path, _ = period.path(10)
    known = np.flatnonzero(np.isfinite(path.intercept[:, 0]))[1:]  # besides the start: where it begins to yield, at its limit
    held = np.hypot(*(path.intercept[known].T + 2.0 * path.u[:2, known]))
    assert len(known) == sum(state != STICK for _, state in instants_of(varies))
    if not varies:
        np.testing.assert_allclose(held, 1.0, atol=1e-3)


def test_dahls_law_turns_round_where_its_motion_does():
    contact = ss.Contact("c", ss.Dahl(2.0, 1.0, normal_load=1.0), (ss.between("1.x", "ground"),))
    period = period_of(contact, np.array([[0.0, np.cos(0.3), np.sin(0.3)]]))
    np.testing.assert_allclose(TURN / 64 * period.instants, [0.3, 0.3 + np.pi], atol=2e-5)


@pytest.mark.parametrize(("amplitude", "lands"), [(0.2, STICK), (2.0, UP)])
def test_a_contact_lifts_off_and_lands_where_its_load_passes_zero(amplitude, lands):
    """N = 0.3 + cos θ. It lands and sticks if its spring loads more slowly than its limit rises, kt |u̇| < μ Ṅ."""
    contact = ss.Contact("c", ss.Macroslip(1.0, 0.5, 1.0, 0.3), (ss.between("1.x", "ground"),), ss.between("1.z", "ground"))
    period = period_of(contact, np.array([[0.0, 0.0, -amplitude], [0.0, 1.0, 0.0]]))
    lift = np.arccos(-0.3)
    normal = TURN / 64 * period.instants[period.elements == -1]
    np.testing.assert_allclose(normal, [lift, TURN - lift], atol=2e-5)
    angles, new = TURN / 64 * period.instants[period.elements == 0], period.new[period.elements == 0]
    assert new[np.argmin(np.abs(angles - lift))] == OPEN
    landed = np.argmin(np.abs(angles - TURN + lift))
    np.testing.assert_allclose(angles[landed], TURN - lift, atol=2e-5)
    assert new[landed] == lands


# State of the periodic motion at t = 0 by `test_multipliers`, to three decimals: q, q̇, y, and what the slider does there.
STATES = {
    "one mass, long slip": ([4.151, 2.667, -3.151], [UP]),
    "lands and slips": ([6.496, -0.915, 4.145, -0.627, -6.496], [OPEN]),
    "lands and sticks": ([-1.033, -0.377, 0.851, 2.867, 1.068], [STICK]),
    "friction falls with the load": ([5.85, -0.86, 4.043, -0.632, -5.85], [OPEN]),
}


def settled(name, samples):
    """Problem, angular frequency, harmonics of the contacts' motion (rows, 2H+1), and the exact multipliers."""
    problem, frequency, level, *_ = SLIDERS[name]
    (state, modes), omega, hybrid = STATES[name], TURN * frequency, of_problem(problem, level)
    derivative, state = hybrid.settled(np.array(state), modes, omega)
    w = problem.B @ hybrid.motion(state, modes, omega, samples) @ fourier(81, samples).P.T
    return problem, omega, w, np.linalg.eigvals(derivative)


def assert_found(problem, omega, w, samples, steps, exact, tolerance):
    """The exact multipliers are among those of the motion, each with one of its own."""
    balance = HarmonicBalance(problem, 81, samples)
    evaluation = SimpleNamespace(table=balance.table, point=SimpleNamespace(omega=omega), w=w)
    found = PeriodMap(balance).multipliers(evaluation, steps).values
    distance = np.abs(exact[:, None] - np.append(found, np.zeros(exact.size))[None, :])
    assert np.max(distance[linear_sum_assignment(distance)]) < tolerance


@pytest.mark.parametrize("name", STATES)
def test_perturbations_of_a_motion_are_those_of_integration_from_event_to_event(name):
    problem, omega, w, exact = settled(name, 1024)
    assert_found(problem, omega, w, 1024, 64, exact, 1e-4)


@pytest.mark.parametrize("name", STATES)
def test_a_disc_along_a_line_answers_perturbations_as_a_slider_does(name):
    """Across the line nothing moves; a perturbation across it has multipliers of its own."""
    problem, omega, w, exact = settled(name, 1024)
    (contact,), structure = problem.contacts, problem.structure
    law = contact.law
    disc = ss.FrictionDisc(law.kt, law.mu, law.kn, law.preload, law.gap, law.normal_load)
    sides = (*contact.tangential, ss.between("1.w", "ground"))
    M, C, K = (block_diag(matrix, own) for matrix, own in ((structure.M, 1.0), (problem.C, 0.05), (structure.K, 1.3)))
    whole = ss.Structure(M, K, (*structure.dofs, "1.w"), C=C)
    both = ss.Problem(whole, (ss.Contact("c", disc, sides, contact.normal),), problem.forces, problem.outputs)
    bound = 2.0 / 1024.0  # it lands at a sample: an error of one
    assert_found(both, omega, np.insert(w, 1, 0.0, axis=0), 1024, 128, exact, bound)


def test_the_path_has_the_motion_and_the_velocity_of_its_harmonics():
    contact = ss.Contact("c", ss.Macroslip(2.0, 1.0, normal_load=1.0), (ss.between("1.x", "ground"),))
    period = period_of(contact, np.array([[0.2, np.cos(0.3), np.sin(0.3)]]))
    path, _ = period.path(10)
    angles = path.instants + TURN / 64 * period.start - 0.3
    np.testing.assert_allclose(path.u[0], 0.2 + np.cos(angles), atol=1e-6)
    np.testing.assert_allclose(path.v[0], -np.sin(angles), atol=1e-5)


TIME = 0.8
"""Of a step."""


@numba.njit
def _moved(table, c, u, v, inside, intercept, w, memory, kept, tangent):
    law_tangent(table, c, u, v, TIME, inside, intercept, w, memory, kept, tangent)


def moved(table, u, v, intercept):
    """Intercepts after a step, and their derivatives and those of y, (k + rows, columns): by intercept, motion and velocity
    before it (zero by the velocity), then by motion and velocity after it."""
    k, rows, intercept = table.stiffness.size, table.rows, intercept.copy()
    tangent = Tangent(*(np.zeros(k if name.startswith("state") else rows) for name in Tangent._fields))
    memory, w, kept = np.eye(k, k + rows), np.eye(rows, k + rows, k), np.zeros((rows, k + rows))
    inside = float(u[table.normal_row[0]].mean()) if table.normal_row[0] >= 0 else 0.0
    _moved(table, 0, u, v, inside, intercept, w, memory, kept, tangent)
    after, by_rate = np.zeros((k + rows, rows)), np.zeros((k + rows, rows))
    sides = [("own", range(rows)), ("normal", table.loading_row), ("cross", table.partner_row)]
    for name, of in sides:
        for r in range(rows):
            if of[r] >= 0:
                after[k + r, of[r]] += getattr(tangent, name)[r]
                by_rate[k + r, of[r]] += getattr(tangent, f"{name}_rate")[r] if name != "normal" else 0.0
                for e in range(table.friction_first[r], table.friction_first[r + 1]):
                    after[e, of[r]] += getattr(tangent, f"state_{name}")[e]
    return intercept, np.hstack([np.vstack([memory, kept]), after, by_rate])


@pytest.mark.parametrize("sample", KERNEL_SAMPLES, ids=lambda sample: sample.name)
def test_the_answer_to_a_perturbation_is_that_of_differences_of_steps(sample):
    """By motion and velocity after a step and by states and motion before it, of closed contacts within their limits: of the
    states, and of y by the steps of time integration."""
    table, rng, kinks, compared = contact_table([contact_of(sample, SliderOffset())]), np.random.default_rng(7), 0, 0
    normal, k, rows = table.normal_row[0], table.stiffness.size, table.rows
    spring, elements = table.stiffness, contact_of(sample, SliderOffset()).elements

    def after(intercept, u, v):
        """Intercepts and y after a step of time integration."""
        slopes, found, limit = uncompiled(no_slopes)(rows), intercept.copy(), np.zeros(k)
        loads = elements.normal.forces(u[normal, 0]) if elements.normal else np.zeros(0)
        bounds = np.concatenate([group.limits(loads) for group in elements.friction])
        contact_law(
            table,
            u[:, 1].copy(),
            Earlier(intercept, u[:, 0].copy(), bounds, v[:, 1].copy(), 0.0, True, TIME),
            found,
            limit,
            slopes,
        )
        return np.concatenate([found, slopes.target])

    of = np.repeat(np.arange(rows), np.diff(table.friction_first))
    for _ in range(40):
        u, v = rng.standard_normal((2, rows, 2))
        if normal >= 0:
            u[normal] = rng.uniform(0.5, 2.0, 2)
        intercept = after(np.zeros(k), u[:, ::-1].copy(), v)[:k]
        intercept = 0.9 * (intercept + spring * u[of, 0]) - spring * u[of, 0]
        moved_to, slopes = moved(table, u, v, intercept)
        here = after(intercept, u, v)
        np.testing.assert_allclose(moved_to, here[:k], atol=1e-12)
        rubbing = [r for r in range(k + rows) if r < k or r - k != normal]
        for column in range(slopes.shape[1]):
            change = np.zeros(k + 3 * rows)
            change[column] = 1e-6
            parts = np.split(change, [k, k + rows, k + 2 * rows])
            moves = parts[0], np.stack(parts[1:3], 1), np.stack([0.0 * parts[3], parts[3]], 1)
            ends = [after(intercept + s * moves[0], u + s * moves[1], v + s * moves[2]) for s in (1.0, -1.0)]
            for r in rubbing:
                kinks += _same(slopes[r, column], [end[r] for end in ends], here[r], 1e-6)
                compared += 1
    assert compared > 100
    assert kinks < 0.05 * compared


@pytest.mark.parametrize("sample", KERNEL_SAMPLES, ids=lambda sample: sample.name)
def test_the_last_of_three_contacts_answers_as_it_does_alone(sample):
    """Its rows and its elements are not the first ones of the table, as they are where it is alone."""
    contact, rng, found = contact_of(sample, SliderOffset()), np.random.default_rng(3), []
    alone = contact_table([contact])
    k, rows = alone.stiffness.size, alone.rows
    u, v = rng.uniform(0.5, 2.0, (2, 3 * rows, 2))
    intercept, memory, w = 0.1 * rng.standard_normal(3 * k), rng.standard_normal((3 * k, 4)), rng.standard_normal((3 * rows, 4))
    for table, c in ((alone, 0), (contact_table([contact] * 3), 2)):
        elements, of_rows = slice(3 * k - table.stiffness.size, None), slice(3 * rows - table.rows, None)
        states, remembered, kept = intercept[elements].copy(), memory[elements].copy(), np.zeros((table.rows, 4))
        tangent = Tangent(*(np.zeros(states.size if name.startswith("state") else table.rows) for name in Tangent._fields))
        _moved(table, c, u[of_rows], v[of_rows], 1.2, states, w[of_rows], remembered, kept, tangent)
        sizes = (k, k, rows, *(k if name.startswith("state") else rows for name in Tangent._fields))
        found.append([part[part.shape[0] - n :] for part, n in zip((states, remembered, kept, *tangent), sizes, strict=True)])
        assert np.array_equal(states[:-k], intercept[elements][:-k])
        assert np.array_equal(remembered[:-k], memory[elements][:-k])
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)


def _same(found, ends, here, step):
    """Asserts that a derivative is that of differences; whether a kink lies between them instead."""
    up, down = (ends[0] - here) / step, (here - ends[1]) / step
    if abs(up - down) > 1e-3 * (1.0 + abs(up)):
        return True
    assert found == pytest.approx(0.5 * (up + down), abs=5e-5 * (1.0 + abs(up)))
    return False


@numba.njit
def _rates(table, u, v, h, rates, state_rates):
    landing_rates(table, 0, u, v, h, rates, state_rates)


@pytest.mark.parametrize("speed", [-0.1, 0.8])
def test_friction_of_a_contact_that_lands_builds_up_at_the_rate_of_its_law(speed):
    """kt = 2, μ Ṅ = 0.5 · 3 · 0.2. A disc: that of its spring or of its limit; tanh: that of its limit alone."""
    limit, spring = 0.5 * 3.0 * 0.2, 2.0 * speed
    exact = {
        ss.FrictionDisc(2.0, 0.5, 3.0, 0.0): np.sign(speed) * min(abs(spring), limit),
        ss.TanhCoulomb(0.5, 0.4, 3.0, 0.0): limit * np.tanh(speed / 0.4),
    }
    for law, rate in exact.items():
        sides, found = (ss.between("1.x", "ground"), ss.between("1.y", "ground")), np.zeros(3)
        table = contact_table([ss.Contact("c", law, sides, ss.between("1.z", "ground"))])
        _rates(table, np.array([0.3, -0.2, 0.0]), np.array([speed, 0.0, 0.2]), 0.1, found, np.zeros(2))
        assert found[0] == pytest.approx(rate, rel=2e-2)
