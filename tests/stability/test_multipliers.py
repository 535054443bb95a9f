"""Floquet's multipliers against those of SciPy's integration, known folds, and the trace of the damping."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import linear_sum_assignment
from stability.hybrid import of_problem

import stickslip as ss
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model import rigs
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.stability.multipliers import PeriodMap, Stability
from stickslip.solve.time.march import from_harmonics

EXACT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}


def solved(problem, frequencies, level, harmonics=15, samples=512):
    """Period map and evaluations at frequencies in Hz."""
    response = ss.forced_response(problem, frequencies, force=level, harmonics=harmonics, samples=samples)
    points = SolvedPoints(response.dataset, problem)
    return PeriodMap(points.balance), [points.evaluation(0, k) for k in range(len(frequencies))]


def start(map_, evaluation):
    """State (q, v, y) at t = 0 and the modes of the sliders."""
    balance, point = map_.balance, evaluation.point
    begin = from_harmonics(balance, point.forces, point.omega, point.level)
    cycle = contact_cycle(evaluation.table, balance.tables, evaluation.w, point.omega)
    y, modes, row = [], [], 0
    for contact in balance.problem.contacts:
        for d in range(len(contact.tangential)):
            traction, state = cycle.force[row + d, 0], int(cycle.state[row + d, 0])
            modes.append(int(np.sign(traction)) if state == 1 else state)
            y.append(traction - contact.law.kt * cycle.displacement[row + d, 0])
        row += len(contact.directions)
    return np.concatenate([begin.motion, begin.velocity, y]), modes


def assert_same(found, exact, count, tolerance=1e-3):
    """The largest of the exact multipliers, each beside one of its own of those that were found."""
    exact = exact[np.argsort(-np.abs(exact))][:count]
    distance = np.abs(exact[:, None] - found[None, :])
    pairs = linear_sum_assignment(distance)
    assert np.max(distance[pairs]) <= tolerance


def lifting(mu=0.5):
    """A mass in the plane, on a contact that lifts off for half of the period."""
    structure = ss.Structure(np.eye(2), np.array([[1.0, 0.1], [0.1, 1.4]]), ("1.x", "1.y"), C=0.04 * np.eye(2))
    contact = ss.Contact("c", ss.Macroslip(1.0, mu, 1.0, 0.5), (ss.between("1.x", "ground"),), ss.between("1.y", "ground"))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0), ss.Force("1.y", 0.6j)), ("1.x",), "Lifting")


# Problem, frequency [Hz], force level, how many multipliers are compared, sliders that never slip.
SLIDERS = {
    "one mass below": (rigs.single_mass(), 1.05 / (2 * np.pi), 1.0, 2, 0),
    "one mass, long slip": (rigs.single_mass(), 0.9 / (2 * np.pi), 2.0, 2, 0),
    "one mass above": (rigs.single_mass(), 1.3 / (2 * np.pi), 2.0, 2, 0),
    "wedge": (rigs.three_mass_wedge(), 84.0, 5.0, 5, 1),
    "lands and slips": (lifting(), 0.15, 1.0, 4, 0),
    "lands and sticks": (lifting(), 0.24, 1.0, 4, 0),
    "friction falls with the load": (lifting(ss.LoadDependentFriction((0.4, 2.0), (0.9, 0.5))), 0.15, 1.0, 4, 0),
}


@pytest.mark.parametrize(
    "name", [name if name.startswith("one mass") else pytest.param(name, marks=pytest.mark.slow) for name in SLIDERS]
)
def test_multipliers_of_sliders_are_those_of_integration_from_event_to_event(name):
    problem, frequency, level, count, stuck = SLIDERS[name]
    map_, (evaluation,) = solved(problem, [frequency], level)
    state, modes = start(map_, evaluation)
    exact = np.linalg.eigvals(of_problem(problem, level).periodic(state, modes, evaluation.point.omega))
    found = map_.multipliers(evaluation, 128)
    assert found.exact_ones == stuck
    assert_same(np.append(found.values, np.ones(found.exact_ones)), exact, count + stuck)


def disc():
    """A mass that circles on a friction disc."""
    structure = ss.Structure(np.eye(2), np.array([[1.0, 0.1], [0.1, 1.4]]), ("1.x", "1.y"), C=0.04 * np.eye(2))
    sides = (ss.between("1.x", "ground"), ss.between("1.y", "ground"))
    contact = ss.Contact("c", ss.FrictionDisc(1.0, 0.5, normal_load=1.0), sides)
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0), ss.Force("1.y", 0.6j)), ("1.x",), "Disc")


def disc_period(x, slips, omega, K, limit=0.5, kt=1.0, damping=0.04):
    """q, v and the traction T of the disc a period later; T' = kt v, without its part along T where the disc slips."""
    t = 0.0
    while True:

        def rate(t, x, slips=slips):
            q, v, traction = x[:2], x[2:4], x[4:]
            drift = kt * v
            if slips:
                along = traction / np.hypot(*traction)
                drift = drift - (along @ drift) * along
            load = np.array([np.cos(omega * t), -0.6 * np.sin(omega * t)])
            return np.concatenate([v, load - damping * v - K @ q - traction, drift])

        def changes(t, x, slips=slips):
            return -(x[4:] @ x[2:4]) if slips else np.hypot(*x[4:]) - limit

        changes.terminal, changes.direction = True, 1.0
        done = solve_ivp(rate, (t, 2.0 * np.pi / omega), x, events=changes, **EXACT)
        t, x = done.t[-1], done.y[:, -1]
        if done.status == 0:
            return x
        slips = not slips


def disc_multipliers(x, slips, omega, K):
    """Of the periodic motion near x, found by Newton's method; while it slips, T has one direction of its own."""
    for _ in range(5):
        free = np.eye(6)
        if slips:
            side = np.array([-x[5], x[4]]) / np.hypot(*x[4:])
            free = np.column_stack([np.eye(6)[:, :4], np.concatenate([np.zeros(4), side])])
        ends = [(disc_period(x + 1e-6 * d, slips, omega, K) - disc_period(x - 1e-6 * d, slips, omega, K)) / 2e-6 for d in free.T]
        derivative = free.T @ np.array(ends).T
        x = x + free @ np.linalg.solve(np.eye(free.shape[1]) - derivative, free.T @ (disc_period(x, slips, omega, K) - x))
        if slips:
            x[4:] *= 0.5 / np.hypot(*x[4:])
    return np.linalg.eigvals(derivative)


@pytest.mark.slow
@pytest.mark.parametrize(
    "frequency", [pytest.param(0.12, marks=pytest.mark.nightly), 0.2, pytest.param(0.25, marks=pytest.mark.nightly)]
)
def test_multipliers_of_a_friction_disc_are_those_of_integration(frequency):
    problem = disc()
    map_, (evaluation,) = solved(problem, [frequency], 1.0, 21, 1024)
    balance, point = map_.balance, evaluation.point
    begin = from_harmonics(balance, point.forces, point.omega, point.level)
    cycle = contact_cycle(evaluation.table, balance.tables, evaluation.w, point.omega)
    x = np.concatenate([begin.motion, begin.velocity, cycle.force[:2, 0]])
    exact = disc_multipliers(x, bool(cycle.state[0, 0]), point.omega, problem.structure.K)
    assert_same(map_.multipliers(evaluation).values, exact, 5)


def duffing(damping=0.1, k3=0.5):
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=damping * np.eye(1))
    spring = ss.Contact("spring", ss.CubicSpring(k3), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",), "Duffing")


def test_the_jacobian_agrees_with_the_multipliers_of_a_converged_motion():
    """Near the unit circle: a real multiplier beyond 1 and a negative determinant, or neither."""
    response = ss.forced_response(duffing(damping=0.02), ss.Band(0.15, 0.5), harmonics=15)
    points = SolvedPoints(response.dataset, response.problem)
    map_ = PeriodMap(points.balance)
    each = [map_.multipliers(points.evaluation(0, k)) for k in np.flatnonzero(response.dataset["outcome"].values[0] == 1)]
    near = [found for found in each if 0.01 < abs(abs(found.leading) - 1.0) <= 0.05]
    assert len(near) > 3
    assert all(found.resolved for found in near)


def test_duffings_multipliers_and_folds():
    """q̈ + 0.1 q̇ + q + q³/2 = cos ωt: the variational equation by SciPy, and instability between the folds alone."""
    problem = duffing()
    response = ss.forced_response(problem, ss.Band(0.1, 0.5), harmonics=9)
    points = SolvedPoints(response.dataset, problem)
    map_, frequency = PeriodMap(points.balance), response.dataset.frequency.to_numpy()[0]
    high, low = np.flatnonzero(np.diff(np.sign(np.diff(frequency)))) + 1
    for k in (5, high - 2, (high + low) // 2, low + 3):
        evaluation = points.evaluation(0, int(k))
        point = evaluation.point
        omega = point.omega
        begin = from_harmonics(points.balance, point.forces, point.omega, point.level)

        def rate(t, x, omega=omega):
            q, v, a, b, c, d = x
            stiffness = 1.0 + 1.5 * q * q
            return [v, np.cos(omega * t) - 0.1 * v - q - 0.5 * q**3, b, -0.1 * b - stiffness * a, d, -0.1 * d - stiffness * c]

        end = solve_ivp(rate, (0.0, 2.0 * np.pi / omega), [begin.motion[0], begin.velocity[0], 1.0, 0.0, 0.0, 1.0], **EXACT).y[
            :, -1
        ]
        exact = np.linalg.eigvals([[end[2], end[4]], [end[3], end[5]]])
        found = map_.multipliers(evaluation)
        assert_same(found.values, exact, 2)
    inside = [map_.multipliers(points.evaluation(0, k)).verdict for k in range(high + 1, low)]
    outside = [map_.multipliers(points.evaluation(0, k)).verdict for k in (*range(high - 1), *range(low + 2, frequency.size))]
    assert set(inside) == {Stability.UNSTABLE}
    assert set(outside) == {Stability.STABLE}


@pytest.mark.parametrize("C", [np.diag([0.02, 0.3]), np.array([[0.2, 0.1], [0.1, 0.06]]), np.diag([4.0, 9.0])])
def test_the_product_of_the_multipliers_of_a_linear_structure_is_that_of_liouville(C):
    """det of the period map = exp(−T tr M⁻¹C), with modal, coupled and overcritical damping."""
    M, K = np.diag([1.0, 2.0]), np.array([[2.0, -0.7], [-0.7, 1.5]])
    slider = ss.Contact("never slips", ss.Macroslip(0.5, 1.0, normal_load=1e6), (ss.between("1.x", "ground"),))
    problem = ss.Problem(ss.Structure(M, K, ("1.x", "2.x"), C=C), (slider,), (ss.Force("1.x", 1.0),), ("1.x",), "Linear")
    map_, (evaluation,) = solved(problem, [0.7], 1.0, 3, 64)
    found, period = map_.multipliers(evaluation), 1.0 / 0.7
    assert found.exact_ones == 1
    assert np.prod(found.values).real == pytest.approx(np.exp(-period * np.trace(np.linalg.solve(M, C))), rel=1e-9)


@pytest.mark.parametrize("name", ["one mass, long slip", "lands and slips", "wedge"])
def test_the_period_map_converges_with_the_square_of_the_step(name):
    problem, frequency, level, *_ = SLIDERS[name]
    map_, (evaluation,) = solved(problem, [frequency], level)
    maps = [map_.matrix(evaluation, steps) for steps in (32, 64, 128)]
    assert 3.0 < np.abs(maps[0] - maps[1]).max() / np.abs(maps[1] - maps[2]).max() < 5.0


def hill(evaluation, balance, mass, damping, stiffness):
    """Multipliers from Hill's matrix with the derivative E of the periodic force: (m (s + D)² + c (s + D) + k + E) p = 0."""
    size, omega = balance.columns, evaluation.point.omega
    D = np.zeros((size, size))
    for h in range(1, balance.highest + 1):
        D[2 * h - 1, 2 * h], D[2 * h, 2 * h - 1] = h * omega, -h * omega
    one = np.eye(size)
    last = mass * D @ D + damping * D + stiffness * one + evaluation.state.own[0]
    first = np.block([[np.zeros((size, size)), one], [-last / mass, -(2.0 * mass * D + damping * one) / mass]])
    exponents = np.linalg.eigvals(first)
    return np.exp(exponents[np.argsort(np.abs(exponents.imag))][:2] * 2.0 * np.pi / omega)


def test_hills_matrix_of_the_periodic_force_is_right_without_memory_and_wrong_with_it():
    """Under p(t) exp(st) a slider remembers its last turn, at which the perturbation was exp(s τ) times another one."""
    map_, (evaluation,) = solved(duffing(), [0.2], 1.0)
    memoryless = hill(evaluation, map_.balance, 1.0, 0.1, 1.0)
    assert_same(map_.multipliers(evaluation).values, memoryless, 2)
    map_, (evaluation,) = solved(rigs.single_mass(), [0.9 / (2.0 * np.pi)], 2.0)
    frozen, found = hill(evaluation, map_.balance, 1.0, 0.02, 2.0), map_.multipliers(evaluation).values[:2]
    assert np.abs(frozen).max() / np.abs(found).max() == pytest.approx(1.105, rel=2e-3)


def spatial(law):
    """A mass in space on one contact whose load varies with z; its law may lift off."""
    structure = ss.Structure(np.eye(3), STIFFNESS, ("1.x", "1.y", "1.z"), C=0.05 * np.eye(3))
    normal = ss.between("1.z", "ground") if law.has_normal else None
    contact = ss.Contact("c", law, (ss.between("1.x", "ground"), ss.between("1.y", "ground")), normal)
    forces = (ss.Force("1.x", 1.0), ss.Force("1.y", 0.6j), ss.Force("1.z", 0.7))
    return ss.Problem(structure, (contact,), forces, ("1.x",), "Mass in space")


STIFFNESS = np.diag([1.0, 1.4, 0.8]) + 0.1


def loaded(omega, t, q, v, friction, normal):
    """Acceleration of the mass in space."""
    load = np.array([np.cos(omega * t), -0.6 * np.sin(omega * t), 0.7 * np.cos(omega * t)])
    return load - 0.05 * v - STIFFNESS @ q - np.array([*friction, normal])


def shot(travel, x, free, step=1e-6):
    """Multipliers of the periodic motion near x by Newton's method on differences, of the states that are free."""
    for _ in range(3):
        ends = [(travel(x + step * d) - travel(x - step * d)) / (2.0 * step) for d in np.eye(x.size)[free]]
        derivative = np.array(ends).T[free]
        x = x.copy()
        x[free] += np.linalg.solve(np.eye(len(free)) - derivative, (travel(x) - x)[free])
    return np.linalg.eigvals(derivative)


@pytest.mark.nightly
@pytest.mark.parametrize(("frequency", "preload"), [(0.12, 1.5), (0.2, 0.3)], ids=["closed", "lifts off"])
def test_multipliers_of_smoothed_coulomb_friction_are_those_of_integration(frequency, preload):
    """Steps are short where the velocity passes zero, and the friction of a landing contact knows when it landed."""
    problem = spatial(ss.TanhCoulomb(0.4, 0.2, kn=1.0, preload=preload))
    map_, (evaluation,) = solved(problem, [frequency], 1.0, 31, 2048)
    omega = evaluation.point.omega

    def travel(x):
        def rate(t, x):
            normal = max(x[2] + preload, 0.0)
            return np.concatenate([x[3:], loaded(omega, t, x[:3], x[3:], 0.4 * normal * np.tanh(x[3:5] / 0.2), normal)])

        return solve_ivp(rate, (0.0, 2.0 * np.pi / omega), x, max_step=0.02, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]

    begin = from_harmonics(map_.balance, evaluation.point.forces, omega, 1.0)
    exact = shot(travel, np.concatenate([begin.motion, begin.velocity]), list(range(6)))
    assert_same(map_.multipliers(evaluation).values, exact, 6)


@pytest.mark.nightly
def test_multipliers_of_the_lugre_law_are_those_of_integration():
    """The bristles of both directions are states of their own; the force depends on the velocity too."""
    law = ss.LuGre(1.0, 0.4, 0.5, 0.6, 0.15, 0.1, kn=1.0, preload=2.5)
    map_, (evaluation,) = solved(spatial(law), [0.12], 1.0, 21, 1024)
    omega, point = evaluation.point.omega, evaluation.point

    def travel(x):
        def rate(t, x):
            normal, v = x[2] + 2.5, x[3:5]
            g = 0.4 + 0.1 * np.exp(-((v / 0.6) ** 2))
            drift = v - np.abs(v) * x[6:] / (normal * g)
            friction = x[6:] + normal * (0.15 * drift + 0.1 * v)
            return np.concatenate([x[3:6], loaded(omega, t, x[:3], x[3:6], friction, normal), drift])

        return solve_ivp(rate, (0.0, 2.0 * np.pi / omega), x, max_step=0.05, rtol=1e-9, atol=1e-11).y[:, -1]

    begin = from_harmonics(map_.balance, point.forces, omega, 1.0)
    bristles = begin.intercepts + map_.balance.problem.B[:2] @ begin.motion
    exact = shot(travel, np.concatenate([begin.motion, begin.velocity, bristles]), list(range(8)), 1e-4)
    assert exact.size == 8
    assert_same(map_.multipliers(evaluation).values, exact, 2, 2e-3)


@pytest.mark.nightly
@pytest.mark.parametrize("kappa", [None, 0.6], ids=["Dahl", "Valanis"])
@pytest.mark.parametrize(("varies", "count"), [(0.0, 6), (1.0, 2)], ids=["constant", "varying"])
def test_multipliers_of_dahls_and_valanis_laws_are_those_of_integration(varies, count, kappa):
    """dT/du = kt (1 − sgn(u̇) T/L)/(1 − κ sgn(u̇) T/L); T is a state of its own, and follows L where L falls below it: of first
    order in the steps."""
    load = {"kn": 1.0, "preload": 2.5} if varies else {"normal_load": 2.5}
    problem = spatial(ss.Dahl(1.0, 0.4, **load) if kappa is None else ss.Valanis(1.0, 0.4, kappa, **load))
    late = kappa or 0.0
    map_, (evaluation,) = solved(problem, [0.12], 1.0, 21, 1024)
    omega, point = evaluation.point.omega, evaluation.point

    def travel(x):
        def rate(t, x):
            normal = varies * x[2] + 2.5
            share, side = np.sign(x[3:5]) * x[6:] / (0.4 * normal), np.sign(x[6:])
            drift = x[3:5] * (1.0 - share) / (1.0 - late * share)
            follows = np.abs(x[6:]) >= 0.4 * normal
            drift = np.where(follows, side * np.minimum(side * drift, 0.4 * varies * x[5]), drift)
            return np.concatenate([x[3:6], loaded(omega, t, x[:3], x[3:6], x[6:], varies * normal), drift])

        return solve_ivp(rate, (0.0, 2.0 * np.pi / omega), x, max_step=0.05, rtol=1e-9, atol=1e-11).y[:, -1]

    begin = from_harmonics(map_.balance, point.forces, omega, 1.0)
    cycle = contact_cycle(evaluation.table, map_.balance.tables, evaluation.w, omega)
    exact = shot(travel, np.concatenate([begin.motion, begin.velocity, cycle.force[:2, 0]]), list(range(8)), 1e-4)
    assert exact.size == 8
    assert_same(map_.multipliers(evaluation).values, exact, count, 3e-3 if varies else 1e-3)
