"""Sliders after steps of the static load, beside closed forms and a program that follows the load in small increments."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.contact.point import OnSurface
from stickslip.model.problem.at_rest import at_rest
from stickslip.model.problem.load_steps import load_history


def mass(load, limit=2.0, kt=3.0):
    structure = ss.Structure(np.eye(1), np.eye(1), ("m.x",), damping=ss.ModalDamping(0.02))
    slider = ss.Contact("slider", ss.Macroslip(kt=kt, mu=0.5, normal_load=2.0 * limit), (ss.between("m.x", "ground"),))
    return ss.Problem(structure, (slider,), (ss.Force("m.x", 1.0, static=load, name="pull"),), ("m.x",))


def place(problem, number=0, direction=0):
    return problem.contacts[number].starts[direction].values(1)[0]


def test_a_slider_stays_where_the_larger_load_before_has_left_it():
    """Under 6 N it slips until 4 N go into the spring of 1 N/m, u = 4 m, s = u − 2/3 m; back to 3 N it sticks, and under −2 N it
    slips the other way."""
    assert place(ss.after_load_steps(mass(3.0), [2.0])) == pytest.approx(4.0 - 2.0 / 3.0)
    back = ss.after_load_steps(mass(3.0), np.array([2.0, -2.0 / 3.0]))
    assert place(back) == pytest.approx(-2.0 + 2.0 + 2.0 / 3.0)
    _, found = load_history(mass(3.0), [2.0, -2.0 / 3.0])
    np.testing.assert_allclose([rest.forces[0] for _, rest in found], [2.0, -2.0, 3.0 * (5.0 / 4.0 - 2.0 / 3.0)])


def test_a_named_force_is_changed_alone():
    problem = mass(3.0).with_forces([ss.Force("m.x", static=3.0, name="pull"), ss.Force("m.x", 1.0, static=1.0)])
    assert place(ss.after_load_steps(problem, [ss.LoadStep(static={"pull": 5.0})])) == pytest.approx(4.0 - 2.0 / 3.0)


def blocks(rng):
    """Two blocks on springs that couple all directions, each pressed on the ground by the load."""
    root = rng.standard_normal((4, 4))
    K = root @ root.T + 2.0 * np.eye(4)
    load = np.array([*rng.uniform(-2.0, 2.0, 2), *rng.uniform(2.0, 6.0, 2)])
    names = ("a.x", "b.x", "a.z", "b.z")
    contacts = tuple(
        ss.Contact(name, ss.Macroslip(kt=kt, mu=mu, kn=kn), (ss.between(f"{name}.x", "ground"),), {f"{name}.z": 1.0})
        for name, kt, kn, mu in zip(
            "ab", rng.uniform(1.0, 9.0, 2), rng.uniform(1.0, 9.0, 2), rng.uniform(0.1, 0.9, 2), strict=True
        )
    )
    forces = tuple(ss.Force(name, static=float(size)) for name, size in zip(names, load, strict=True))
    return (
        ss.Problem(ss.Structure(np.eye(4), K, names, C=np.eye(4)), contacts, (*forces, ss.Force("a.x", 1.0)), ("a.x",)),
        K,
        load,
    )


def followed(problem, K, load, factors, increments, preloads=None):
    """The places of both sliders: in small increments of the load and of the preloads, each state tried that a block may have."""
    law = [contact.law for contact in problem.contacts]
    kt, kn, mu = (np.array([getattr(each, name) for each in law]) for name in ("kt", "kn", "mu"))
    s, pressed = np.zeros(2), np.zeros((len(factors), 2)) if preloads is None else preloads
    ends = zip(pairwise([0.0, *factors, 1.0]), pairwise([pressed[0], *pressed, np.zeros(2)]), strict=True)
    for (before, after), (pressed_before, pressed_after) in ends:
        for share in np.linspace(0.0, 1.0, increments + 1)[1:]:
            p = ((1.0 - share) * before + share * after) * load
            P = (1.0 - share) * pressed_before + share * pressed_after
            for state in np.ndindex(4, 4):  # sticks, slips either way, is open
                A, b = K.copy(), p.copy()
                for k, own in enumerate(state):
                    if own == 0:
                        A[k, k] += kt[k]
                        b[k] += kt[k] * s[k]
                    elif own < 3:
                        A[k, 2 + k] += (1.0 if own == 1 else -1.0) * mu[k] * kn[k]
                        b[k] -= (1.0 if own == 1 else -1.0) * mu[k] * P[k]
                    if own < 3:
                        A[2 + k, 2 + k] += kn[k]
                        b[2 + k] -= P[k]
                q = np.linalg.solve(A, b)
                x, pressing = q[:2], kn * q[2:] + P
                N = np.maximum(pressing, 0.0)
                T = kt * (x - s)
                slides = np.array([1.0 if own == 1 else -1.0 for own in state])
                good = [
                    abs(T[k]) <= mu[k] * N[k] * (1.0 + 1e-9) and pressing[k] >= 0.0
                    if own == 0
                    else (
                        pressing[k] >= 0.0 and T[k] * slides[k] >= mu[k] * N[k] * (1.0 - 1e-9) if own < 3 else pressing[k] <= 0.0
                    )
                    for k, own in enumerate(state)
                ]
                if all(good):
                    s = x - np.clip(T, -mu * N, mu * N) / kt
                    break
            else:
                raise AssertionError("no state of rest")
    return s


@pytest.mark.parametrize("seed", range(6))
def test_sliders_are_where_small_increments_of_the_load_leave_them(seed):
    """Load and normal load go together, also through zero, where blocks lift off and their sliders follow them."""
    rng = np.random.default_rng(seed)
    problem, K, load = blocks(rng)
    factors = rng.uniform(-0.5, 2.5, 3).tolist()
    moved = ss.after_load_steps(problem, factors)
    found = np.array([place(moved, k) for k in range(2)])
    expected = followed(problem, K, load, factors, 2048)
    rest = at_rest(moved)
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(rest.motion).max())
    np.testing.assert_allclose(rest.sliders, found, atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_sliders_are_where_small_increments_of_preloads_leave_them(seed):
    """Preloads that change with the load, also so that a block lifts off: no tension and no more than μN after each step."""
    rng = np.random.default_rng(100 + seed)
    problem, K, load = blocks(rng)
    factors, preloads = rng.uniform(0.2, 2.0, 3), rng.uniform(-3.0, 6.0, (3, 2))
    pairs = zip(factors.tolist(), preloads.tolist(), strict=True)
    steps = [ss.LoadStep(factor, preload=dict(zip("ab", own, strict=True))) for factor, own in pairs]
    _, found = load_history(problem, steps)
    rests = [rest for _, rest in found]
    expected = followed(problem, K, load, factors, 2048, preloads)
    np.testing.assert_allclose(rests[-1].sliders, expected, atol=1e-3 * max(np.abs(rest.motion).max() for rest in rests))
    mu = np.array([contact.law.mu for contact in problem.contacts])
    for loaded, rest in found:
        T, N = rest.forces.reshape(2, 2).T
        assert np.all(N >= 0.0)
        assert np.all(np.abs(T) <= mu * N * (1.0 + 1e-9))
        q = np.linalg.solve(K, loaded.static_load - loaded.B.T @ rest.forces)
        np.testing.assert_allclose(loaded.B @ q, rest.motion, atol=1e-9)


def test_a_slider_slips_where_the_normal_load_falls_and_stays_where_it_rises():
    """Under 6 N and a limit of 3 N, u = 3 m, s = 2 m, which 3 N keep. Under 6 N and 0.5 N it has gone on to 5.5 − 1/6 m."""
    assert place(ss.after_load_steps(mass(3.0), [ss.LoadStep(2.0, normal_load={"slider": 6.0})])) == pytest.approx(2.0)
    steps = [ss.LoadStep(2.0, normal_load={"slider": load}) for load in (6.0, 1.0)]
    _, found = load_history(mass(3.0), steps)
    np.testing.assert_allclose([rest.forces[0] for _, rest in found], [3.0, 0.5, 3.0 * 4.75 - 16.0])
    assert found[-1][1].sliders[0] == pytest.approx(5.5 - 1.0 / 6.0)
    static = mass(3.0).with_forces([ss.Force("m.x", 1.0, static=3.0, name="pull")])
    by_force = ss.after_load_steps(
        static, [ss.LoadStep(static={"pull": 6.0}, normal_load={"slider": load}) for load in (6.0, 1.0)]
    )
    assert place(by_force) == pytest.approx(5.5 - 1.0 / 6.0)


def shrouded(**law):
    """A part on springs of 2 N/m along x and 4 N/m along z, 6 N along x, beside a shroud."""
    structure = ss.Structure(np.eye(2), np.diag([2.0, 4.0]), ("m.x", "m.z"), C=np.eye(2))
    given = {"kt": 3.0, "mu": 0.5, "kn": 8.0, "preload": 12.0} | law
    balanced = given.pop("balanced", False)
    shroud = ss.Contact("shroud", ss.Macroslip(**given), ({"m.x": 1.0},), {"m.z": 1.0}, balanced=balanced)
    return ss.Problem(structure, (shroud,), (ss.Force("m.x", 1.0, static=6.0),), ("m.x",))


def test_an_interference_that_comes_back_after_the_load_carries_no_friction_of_it():
    """Heat takes the interference away: the part moves 3 m under 6 N alone, and the slider with it, where it is caught again."""
    _, found = load_history(shrouded(), [ss.LoadStep(gap={"shroud": 5.0})])
    (_, free), (_, caught) = found
    np.testing.assert_allclose([*free.motion, *free.forces, *free.sliders], [3.0, 0.0, 0.0, 0.0, 3.0])
    np.testing.assert_allclose([*caught.motion, *caught.sliders], [3.0, -1.0, 3.0])
    np.testing.assert_allclose(caught.forces, [0.0, 4.0], atol=1e-12)
    assert at_rest(shrouded()).forces[0] == pytest.approx(2.0)  # of 3.6 N that sticking would take, μN = 2 N


def test_a_balanced_contact_keeps_its_counter_force_at_other_preloads():
    """4 z + (4 + 8 z) = 12: where less presses than in the equilibrium from which z counts, the part moves."""
    _, found = load_history(shrouded(balanced=True), [ss.LoadStep(0.0, preload={"shroud": 4.0})])
    np.testing.assert_allclose([rest.motion[1] for _, rest in found], [2.0 / 3.0, 0.0], atol=1e-12)
    assert found[0][1].forces[1] == pytest.approx(4.0 + 16.0 / 3.0)


def test_the_order_of_steps_matters_only_through_sliding():
    """A contact that stays stuck forgets its steps; one that opens under 12 N is caught there, 6 m away, if that comes last."""
    steps = [ss.LoadStep(2.0, preload={"shroud": 40.0}), ss.LoadStep(0.5, gap={"shroud": -1.0}), 1.5]
    for given in (steps, steps[::-1]):
        assert place(ss.after_load_steps(shrouded(mu=9.0), given)) == 0.0
    loose = [ss.LoadStep(factor, preload={"shroud": 0.0}) for factor in (2.0, 0.0)]
    for given, expected in ((loose, 0.0), (loose[::-1], 6.0)):
        assert place(ss.after_load_steps(shrouded(preload=30.0), given)) == pytest.approx(expected, abs=1e-12)


def test_shares_and_gaps_of_a_surface_are_those_of_its_nodes():
    """Two nodes with a quarter and three quarters of a surface, of which the mesh holds one 0.5 m off: each as it would be alone.

    Alone the parts are in planes of their own, so that only their own numbers move them."""
    structure = ss.Structure(np.eye(4), np.diag([2.0, 4.0, 2.0, 4.0]), ("1.x", "1.z", "2.x", "2.z"), C=np.eye(4))
    forces = (
        ss.Force("1.x", 1.0, static=18.0),
        ss.Force("2.x", static=18.0),
        ss.Force("1.z", static=9.0),
        ss.Force("2.z", static=9.0),
    )
    law, parts = ss.Macroslip(kt=3.0, mu=0.5, kn=8.0, preload=2.0), (OnSurface("S", 0.25), OnSurface("S", 0.75, 0.5))

    def problem(names):
        contacts = [
            ss.Contact(
                name, replace(law.share(part.share), gap=part.further), ({f"{k}.x": 1.0},), {f"{k}.z": 1.0}, surface=surface
            )
            for k, (name, part, surface) in enumerate(zip(("a", "b"), parts, names, strict=True), start=1)
        ]
        return ss.Problem(structure, tuple(contacts), forces, ("1.x",))

    together = ss.after_load_steps(problem(parts), [ss.LoadStep(2.0, preload={"S": 16.0}, gap={"S": -0.25})])
    single = ss.LoadStep(2.0, preload={"a": 4.0, "b": 12.0}, gap={"a": -0.25, "b": 0.25})
    alone = ss.after_load_steps(problem((None, None)), [single])
    for k in range(2):
        assert place(together, k) == pytest.approx(place(alone, k), rel=1e-12)
        assert place(together, k) > 0.1


def test_each_element_of_an_array_has_its_share():
    array = ss.MicroslipArray((1.0, 1.0), 0.5, kn=(4.0, 4.0), gaps=(0.0, 0.0), preload=(6.0, 6.0))
    one, several = shrouded(kt=2.0), shrouded().with_contacts(lambda contact: contact.with_law(array))
    step = ss.LoadStep(2.0, preload={"shroud": 3.0})
    places = [problem.contacts[0].start_values[0] for problem in (ss.after_load_steps(each, [step]) for each in (one, several))]
    np.testing.assert_allclose(places[1], np.repeat(places[0], 2))
    assert places[0][0] > 0.0


def test_steps_of_contacts_that_are_none_are_refused():
    for changed, said in (
        ({"preload": {"shrod": 1.0}}, r"Step 1: preload must name contacts, but is 'shrod'\. Did you mean 'shroud'"),
        ({"normal_load": {"shroud": 1.0}}, r"the Macroslip of shroud has no normal_load here.*its preload and gap"),
        ({"gap": {"shroud": float("nan")}}, "gap of shroud must be finite"),
        ({"static": {"pull": 1.0}}, "must name single forces"),
        ({"factor": float("inf")}, "Step 1: factor must be finite"),
    ):
        with pytest.raises(ss.InputError, match=said):
            ss.after_load_steps(shrouded(), [ss.LoadStep(**changed)])
    with pytest.raises(ss.InputError, match="normal_load must not be negative"):
        ss.after_load_steps(mass(3.0), [ss.LoadStep(normal_load={"slider": -1.0})])
    hanging = shrouded().with_structure(replace(shrouded().structure, K=np.diag([2.0, 0.0])))
    with pytest.raises(ss.InputError, match=r"No state of rest was found under the static load of step 1\."):
        ss.after_load_steps(hanging.with_forces([ss.Force("m.x", 1.0), ss.Force("m.z", static=1.0)]), [ss.LoadStep(-1.0)])


@pytest.mark.parametrize("seed", [1, 8, 52])
def test_forces_out_of_proportion_leave_sliders_where_small_increments_do(seed):
    """Chosen of 60 drawn chains: one slider stops where another begins, between places at which whole and halves of a step agree.

    Of each small increment the tractions T = kt (w − s) within their limits are solved by projection, one after the other.
    """
    rng = np.random.default_rng(seed)
    size = int(rng.integers(2, 6))
    root = rng.normal(size=(size, size))
    K, kt = 1e5 * (root @ root.T / size + 0.5 * np.eye(size)), 1e5 * 10.0 ** rng.uniform(-1, 2, size)
    limits, load = 40.0 * rng.uniform(0.1, 1.0, size), 100.0 * rng.normal(size=size)
    names = [f"{k}.x" for k in range(size)]
    contacts = [
        ss.Contact(name, ss.Macroslip(kt=k, mu=0.4, normal_load=limit / 0.4), ({name: 1.0},))
        for name, k, limit in zip(names, kt, limits, strict=True)
    ]
    forces = [ss.Force(name, float(name == "0.x"), static=each, name=name) for name, each in zip(names, load, strict=True)]
    structure = ss.Structure(np.eye(size), K, tuple(names), C=np.eye(size))
    factors = rng.uniform(-2.0, 3.0, (3, size))
    moved = ss.after_load_steps(
        ss.Problem(structure, tuple(contacts), tuple(forces), names[:1]),
        [ss.LoadStep(static=dict(zip(names, each, strict=True))) for each in (factors * load).tolist()],
    )
    compliance = np.linalg.inv(K)
    whole, s, T = compliance + np.diag(1.0 / kt), np.zeros(size), np.zeros(size)
    for before, after in pairwise([np.zeros(size), *factors * load, load]):
        for share in np.linspace(0.0, 1.0, 401)[1:]:
            free = compliance @ (before + share * (after - before))
            for _ in range(60):
                for k in range(size):
                    T[k] = np.clip(T[k] + (free[k] - s[k] - whole[k] @ T) / whole[k, k], -limits[k], limits[k])
            s = free - compliance @ T - T / kt
    found = np.array([place(moved, k) for k in range(size)])
    np.testing.assert_allclose(found, s, atol=1e-3 * np.abs(s).max())


def test_the_vibration_knows_what_was_before():
    """A stuck contact keeps the mean force of its history; one that slips fully forgets it."""
    for level, remembers in ((0.05, True), (6.0, False)):
        before, after = (
            ss.forced_response(problem, ss.radians_per_second(0.5, 3.0), level, harmonics=3, samples=64).dataset
            for problem in (mass(1.0), ss.after_load_steps(mass(1.0), [8.0]))
        )
        means = [float(each["contact_force"].isel(harmonic=0, part=0).values[0].ravel()[0]) for each in (before, after)]
        peaks = [float(each["amplitude"].max()) for each in (before, after)]
        assert (abs(means[0] - means[1]) > 0.1) == remembers
        assert peaks[1] == pytest.approx(peaks[0], rel=1e-3)


def test_what_has_no_history_is_refused():
    with pytest.raises(ss.InputError, match="static load"):
        ss.after_load_steps(mass(0.0), [1.0])
    for steps, said in (([], "must contain a load"), (1.44, "must be a tuple or list")):
        with pytest.raises(ss.InputError, match=said):
            ss.after_load_steps(mass(1.0), steps)
    held_by_little = mass(3.0).with_structure(replace(mass(3.0).structure, K=np.array([[1e-12]])))
    with pytest.raises(ss.InputError, match=r"rounding hides their friction, but is 'sliders 4\.0e\+12 m away'"):
        ss.after_load_steps(held_by_little, [2.0])
    with pytest.raises(ss.InputError, match="friction starts from a slider offset"):
        ss.after_load_steps(mass(1.0).with_start(ss.TractionRatio(0.5)), [2.0])
    with pytest.raises(ss.InputError, match=r"static must name single forces, but is 'pul'.*pull"):
        ss.after_load_steps(mass(1.0), [ss.LoadStep(static={"pul": 2.0})])
    disc = ss.Contact(
        "disc", ss.FrictionDisc(kt=1.0, mu=0.5, normal_load=1.0), (ss.between("m.x", "ground"), ss.between("m.y", "ground"))
    )
    plane = ss.Structure(np.eye(2), np.eye(2), ("m.x", "m.y"), C=np.eye(2))
    with pytest.raises(ss.InputError, match="friction disc"):
        ss.after_load_steps(ss.Problem(plane, (disc,), (ss.Force("m.x", 1.0, static=1.0),), ("m.x",)), [2.0])


@pytest.mark.parametrize("stiffness", [1e4, 1e8])
def test_the_contacts_are_at_rest_where_the_steps_have_left_them(stiffness):
    """Sliders stand at their limit exactly and the stiff body moves nearly as one: forces cancel, rounding is left."""
    K = stiffness * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]]) + np.eye(3)
    names = ("0.x", "1.x", "2.x")
    contacts = tuple(
        ss.Contact(name, ss.Macroslip(kt=1.0 + k, mu=0.5, normal_load=1.0 + 0.3 * k), (ss.between(name, "ground"),))
        for k, name in enumerate(names)
    )
    problem = ss.Problem(ss.Structure(np.eye(3), K, names, C=np.eye(3)), contacts, (ss.Force("0.x", 1.0, static=12.0),), names)
    moved, found = load_history(problem, [3.0, 0.2])
    rest = at_rest(moved)
    assert rest is not None
    np.testing.assert_allclose(rest.motion, found[-1][1].motion, rtol=1e-6)
    np.testing.assert_allclose(rest.sliders, found[-1][1].sliders, rtol=1e-6)


def of_two(p, gap=0.2, mu=0.5, preload=0.0):
    """A mass on springs of 1 N/m along x and z, a contact of 10 N/m that closes at z = gap, and a load (2,)."""
    structure = ss.Structure(np.eye(2), np.eye(2), ("a.x", "a.z"), C=np.eye(2))
    law = ss.Macroslip(kt=10.0, kn=10.0, mu=mu, gap=gap, preload=preload)
    contact = ss.Contact("c", law, ({"a.x": 1.0},), {"a.z": 1.0})
    forces = ss.Force("a.x", 1.0, static=p[0]), ss.Force("a.z", static=p[1])
    return ss.Problem(structure, (contact,), forces, ("a.x",))


@pytest.mark.parametrize("steps", [[3.0], [0.1, 3.0], [0.0, 3.0]])
def test_a_slider_begins_where_its_contact_closes_in_the_first_step_too(steps):
    """Open until z = 0.2, where x = 0.08 by hand; then it sticks: T = 10 (1.2 − 0.8)/11 (3 p = 1.2), and 0.8/11 less at p."""
    _, (*_, before, (_, rest)) = load_history(of_two((0.4, 1.0)), steps)
    assert before[1].sliders == pytest.approx([0.08], rel=5e-3)
    assert before[1].forces[0] == pytest.approx(10.0 * (1.2 - 0.08) / 11.0, rel=2e-3)
    assert rest.forces[0] == pytest.approx(10.0 * (0.4 - 0.08) / 11.0, rel=2e-3)


@pytest.mark.parametrize(("p", "mu"), [((0.4, 0.1), 0.5), ((0.4, -1.0), 0.0)])
def test_contacts_that_carry_nothing_in_the_end_have_a_history_too(p, mu):
    *_, (_, rest) = load_history(of_two(p, mu=mu), [1.0])[1]
    assert not rest.forces.any()
    assert rest.sliders == pytest.approx([0.4])
