"""A march period by period: its start, its energies, how contacts are solved, and the map of a period by its differences."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_domain.systems import orbiting_mass, rubbing_mass, three_masses

import stickslip as ss
from stickslip.analyses.time_response import time_response
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.time.contact_law import solve_in_place
from stickslip.solve.time.march import (
    Differences,
    March,
    MarchOutcome,
    PeriodMarch,
    Repetition,
    TimeStart,
    _correction,
    from_harmonics,
    from_rest,
    loads_of_steps,
    march,
    no_history,
    state_at,
)
from stickslip.solve.time.period import march_period, settle, time_model
from stickslip.support.kernels import uncompiled

OMEGA = 0.9


def begun(problem, steps, start):
    """Model, matrices, loads and the settled state of a start."""
    model = time_model(problem)
    matrices = model.step_matrices(March().method.coefficients, 2.0 * np.pi / OMEGA / steps)
    loads, state = loads_of_steps(model, OMEGA, 1.0, steps), state_at(model, start)
    settle(model.table, matrices, loads, state)
    return model, matrices, loads, state


def test_a_start_obeys_the_equation_of_motion():
    """M q̈ + C q̇ + K q + Bᵀ f = p at t = 0, without the massless node; the sliders stick, T = y + kt u."""
    rng, problem = np.random.default_rng(2), three_masses(limit=100.0)
    start = TimeStart(rng.standard_normal(3), rng.standard_normal(3), np.array([0.7]))
    model, _, _, state = begun(problem, 200, start)
    q, v, a = start.motion, start.velocity, model.shapes @ state.acceleration
    M, K = problem.structure.M, problem.structure.K
    traction = 0.7 + problem.contact_stiffness * (problem.B @ q)
    load = problem.static_load + problem.load(3)[:, 1::2].sum(axis=1)
    left = load - M @ a - problem.C @ v - K @ q - problem.B.T @ traction
    np.testing.assert_allclose((model.shapes.T @ left)[model.mass > 0.0], 0.0, atol=1e-12)


def test_energy_in_is_energy_out_where_friction_slips_and_contacts_land():
    """Input less friction less viscous work, all of which count, and all relative to the input."""
    for problem, least in ((three_masses(limit=0.4), 0.05), (rubbing_mass(), 0.02)):
        found = time_response(problem, OMEGA / (2.0 * np.pi), harmonics=3, steps_per_period=1000).cycle
        assert found.energy_residual < 5e-4
        assert found.friction_work.sum() > least * found.given
        assert found.viscous > least * found.given


def test_a_stuck_contact_carries_what_its_spring_does():
    problem = three_masses(limit=100.0)
    found = march(problem, OMEGA, 1.0, from_rest(problem), March(200, periods=2))
    np.testing.assert_allclose(found.contact_force, 2.0 * found.contact_motion, rtol=1e-12)
    assert np.ptp(found.contact_motion) > 0.1


def tilted_mass():
    """A mass that rubs and lifts off, on springs that join both directions: friction moves it off the ground."""
    structure = ss.Structure(np.eye(2), np.array([[2.0, -1.0], [-1.0, 2.0]]), ("1.x", "1.y"), C=0.05 * np.eye(2))
    law = ss.Macroslip(kt=3.0, mu=0.5, kn=4.0, preload=1.0)
    contact = ss.Contact("ground", law, (ss.between("1.x", "ground"),), ss.between("1.y", "ground"))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0), ss.Force("1.y", 0.9 - 0.6j)), ("1.x", "1.y"))


def test_contacts_move_as_their_nodes_do():
    """w = B q at the end of every step, also where the slider slips: the compliance of the step is that of its equations."""
    problem = three_masses(limit=0.4)
    found = march(problem, OMEGA, 1.0, from_rest(problem), March(200, periods=2))
    np.testing.assert_allclose(found.contact_motion[0], found.outputs[0] - found.outputs[1], atol=1e-12)
    assert found.friction_work[0] > 0.1


@pytest.mark.parametrize(("problem", "most"), [(tilted_mass(), 1.2), (orbiting_mass(varying=True), 2.4)], ids=["slider", "disc"])
def test_contacts_of_a_step_are_solved_in_newtons_few_iterations(problem, most):
    """Sliders are piecewise linear, one iteration a step; a disc takes two. With a wrong derivative they take twice as many."""
    model, matrices, loads, state = begun(problem, 24, from_rest(problem))
    history = no_history(model, 24)
    works = [march_period(model.table, matrices, loads, state, history) for _ in range(8)]
    assert all(work.failed < 0 for work in works)
    assert np.mean([work.iterations for work in works]) < most * 24


@pytest.mark.parametrize("law", ["sliders", "disc"])
def test_more_contact_rows_than_modes_are_solved_on_the_modes(law):
    """The same motion by as many iterations as with the compliance of all rows; a disc couples its two directions."""
    K = np.array([[3.0, -1.0, 0.2], [-1.0, 3.0, 0.1], [0.2, 0.1, 3.0]])
    structure = ss.Structure(np.eye(3), K, ("1.x", "1.y", "1.z"), C=0.05 * np.eye(3))
    disc = ss.FrictionDisc(kt=2.0, mu=0.5, kn=3.0, preload=0.5)
    laws = [disc, disc] if law == "disc" else [ss.Macroslip(kt=2.0 + k, mu=0.4, kn=3.0, preload=0.3 + 0.2 * k) for k in range(2)]
    tangential = (ss.between("1.x", "ground"), ss.between("1.y", "ground"))
    contacts = tuple(ss.Contact(str(k), each, tangential, ss.between("1.z", "ground")) for k, each in enumerate(laws))
    forces = (ss.Force("1.x", 1.0), ss.Force("1.y", 0.9 - 0.6j), ss.Force("1.z", 0.8))
    problem, found = ss.Problem(structure, contacts, forces, ("1.x", "1.y", "1.z")), []
    for whole in (False, True):
        model, matrices, loads, state = begun(problem, 100, from_rest(problem))
        assert matrices.compliance.size == 0
        if whole:
            matrices = matrices._replace(compliance=matrices.shape @ matrices.driven.T)
        history = no_history(model, 100)
        work = [march_period(model.table, matrices, loads, state, history) for _ in range(3)][-1]
        found.append((work.iterations, history))
    (few, one), (all_rows, other) = found
    assert few == all_rows > 50
    np.testing.assert_allclose(one.outputs, other.outputs, rtol=1e-9, atol=1e-12)
    assert one.friction_work.sum() > 0.1


def test_elimination_solves_and_names_a_singular_matrix():
    rng, solved = np.random.default_rng(6), uncompiled(solve_in_place)
    for size in (1, 2, 5):
        matrix, x = rng.standard_normal((size, size)), rng.standard_normal(size)
        matrix[0, 0] = 0.0 if size > 1 else 1.0  # rows must change places
        right = matrix @ x
        assert solved(matrix.copy(), right)
        np.testing.assert_allclose(right, x, rtol=1e-9)
    assert not solved(np.ones((2, 2)), np.ones(2))


def test_states_of_shooting_have_the_size_of_their_energy():
    """‖x‖² = qᵀK'q + vᵀMv + Σ y²/kt, K' with stuck contacts; back from x the state is the same."""
    rng, problem = np.random.default_rng(3), rubbing_mass()
    march_ = PeriodMarch(problem, OMEGA, 1.0, March(200))
    start = TimeStart(rng.standard_normal(2), rng.standard_normal(2), rng.standard_normal(1))
    x = march_.packed(start)
    q, v, y = start.motion, start.velocity, start.intercepts
    energy = q @ problem.stuck_stiffness @ q + v @ problem.structure.M @ v + np.sum(y**2) / 3.0
    assert x @ x == pytest.approx(energy, rel=1e-12)
    back = march_.start(x)
    for found, given in ((back.motion, q), (back.velocity, v), (back.intercepts, y)):
        np.testing.assert_allclose(found, given, rtol=1e-12)


def test_a_correction_solves_the_linear_system_of_a_map_by_its_differences():
    """Of a map with a known derivative: x + Φ x + 0.1 x³."""
    rng = np.random.default_rng(8)
    derivative, x, vector = 0.3 * rng.standard_normal((6, 6)), rng.standard_normal(6), rng.standard_normal(6)

    def travelled(x):
        return derivative @ x + 0.1 * x**3

    map_ = Differences(travelled, x, travelled(x), 1.0)
    exact = derivative + np.diag(0.3 * x**2)
    np.testing.assert_allclose(map_(vector), exact @ vector, atol=1e-9)
    assert map_.kink < 1e-3
    found = _correction(map_, vector)
    assert np.linalg.norm(vector - found + exact @ found) < 1.1e-2 * np.linalg.norm(vector)


def test_a_kink_of_a_map_is_seen_in_its_differences():
    x, away = np.zeros(2), np.array([1.0, 0.0])
    map_ = Differences(lambda x: 1.0 + np.maximum(x, 0.0), x, x + 1.0, 1.0)
    np.testing.assert_allclose(map_(away), 0.5 * away)
    assert map_.kink == pytest.approx(1.0)


def test_the_state_of_a_harmonic_solution_is_that_of_its_motion_at_t_0():
    """Of stuck contacts in closed form, X_h of the stuck structure; a slider that starts at s has y = −kt s."""
    problem = three_masses(limit=100.0)
    problem = problem.with_contacts(lambda contact: contact.with_start((ss.SliderOffset(0.4),)))
    balance = HarmonicBalance(problem, 3, 32)
    forces = np.zeros((1, 7))
    forces[0, 0] = -2.0 * 0.4
    found, load = from_harmonics(balance, forces, OMEGA, 1.0), problem.load(3)
    q, v = np.linalg.solve(problem.stuck_stiffness, load[:, 0] + problem.B.T @ [0.8]), np.zeros(3)
    for h in (1, 3):
        s = 1j * h * OMEGA
        dynamic = problem.stuck_stiffness + s * problem.C + s * s * problem.structure.M
        X = np.linalg.solve(dynamic, load[:, 2 * h - 1] - 1j * load[:, 2 * h])
        q, v = q + X.real, v + (s * X).real
    np.testing.assert_allclose(found.motion, q, rtol=1e-9)
    np.testing.assert_allclose(found.velocity, v, rtol=1e-9)
    for start in (found, from_rest(problem)):
        np.testing.assert_allclose(start.intercepts, [-0.8], rtol=1e-12)


@pytest.mark.parametrize(("frequency", "repeats"), [(1.5, 1), (3.0, 2), (4.5, 3), (5.8, 4)])
def test_a_motion_over_several_periods_is_recognised(frequency, repeats):
    """A mass against a stop: SciPy goes on from where the march ends, and comes back after as many periods as are said, and not
    before."""
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=np.array([[0.05]]))
    stop = ss.Contact("stop", ss.Gap(8.0, 0.0), (), {"1.x": 1.0})
    problem = ss.Problem(structure, (stop,), (ss.Force("1.x", 1.0),), ("1.x",))
    cycle = march(problem, frequency, 1.0, from_rest(problem), March(400, tolerance=1e-4))
    assert (cycle.repeats, cycle.outcome) == (repeats, MarchOutcome.PERIODIC if repeats == 1 else MarchOutcome.SUBHARMONIC)
    assert repeats == 1 or f"after {repeats} periods of the excitation" in cycle.sentence

    def rates(t, y):
        return [y[1], np.cos(frequency * t) - 0.05 * y[1] - y[0] - 8.0 * max(y[0], 0.0)]

    state = np.array([cycle.end.motion[0], cycle.end.velocity[0]])
    period = 2.0 * np.pi / frequency
    found = solve_ivp(rates, (0.0, 4.0 * period), state, rtol=1e-9, atol=1e-12, t_eval=period * np.arange(5)).y
    away = np.linalg.norm(found - state[:, None], axis=0) / np.linalg.norm(state)
    assert away[repeats] < 0.02
    assert np.all(away[1:repeats] > 0.2)


@pytest.mark.parametrize("part", [2, 3, 4])
def test_a_slow_transient_at_a_fraction_of_the_frequency_is_no_motion_over_several_periods(part):
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=np.array([[2e-4]]))
    problem = ss.Problem(structure, (), (ss.Force("1.x", 1.0),), ("1.x",))
    cycle = march(problem, float(part), 1.0, from_rest(problem), March(100, tolerance=1e-2, periods=300))
    assert (cycle.repeats, cycle.outcome) == (0, MarchOutcome.NOT_PERIODIC)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-6, 1e-7])
def test_a_motion_over_two_periods_is_not_called_one_over_four(tolerance):
    """States that come near a motion over two periods from both sides in turn: over four they are next to each other first."""
    k = np.arange(1000)
    spiral = np.exp((1.0j * np.pi - 0.05) * (k // 2)) * 0.3
    states = np.column_stack([(-1.0) ** k + spiral.real, 0.5 + spiral.imag])
    repetition = Repetition(tolerance)
    place = next(n for n, state in enumerate(states) if repetition.found(state))
    assert repetition.periods == 2
    assert abs(spiral[place]) < 10.0 * tolerance


def test_a_weak_motion_over_four_periods_is_one():
    """The change over two periods is small beside that over one, but stays."""
    k = np.arange(400)
    states = np.column_stack([(-1.0) ** k + 1e-2 * np.cos(0.5 * np.pi * k), 0.5 + 0.8**k])
    repetition = Repetition(1e-6)
    assert any(repetition.found(state) for state in states)
    assert repetition.periods == 4
