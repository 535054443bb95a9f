"""Normal loads at rest, against the mean forces that the harmonic balance finds without vibration."""

from dataclasses import replace

import numpy as np
import pytest
from problem.loose_wedge import wedge_between
from scipy.optimize import brentq, minimize

import stickslip as ss
from stickslip.model.problem.at_rest import at_rest, normal_loads_at_rest, seated
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.sweep import solve_cold
from stickslip.study import job
from stickslip.study.templates import write_new


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blades")
    write_new("two_blades", folder / "study.toml")
    return folder


@pytest.mark.parametrize("across", [0.0, 25.0, 40.0, 100.0])
def test_a_pull_across_is_carried_by_one_platform_more_than_by_the_other(folder, across):
    """Some nodes slip and some open: the states of one round led to those of the next and back."""
    text = (folder / "study.toml").read_text().replace("pull = [0.0, 300.0, 0.0]", f"pull = [{across}, 300.0, 0.0]")
    made = job(text, folder, "study")
    problem = made.sweep.problem
    found = normal_loads_at_rest(problem)
    balance = HarmonicBalance(problem, 1, 8)
    solved = solve_cold(balance.holding(None), 100.0, 0.0)
    assert solved.converged
    normal = [row for row, direction in enumerate(d for c in problem.contacts for d in c.direction_names) if direction == "n"]
    expected = balance.carried_forces(solved.evaluation)[normal, 0]
    np.testing.assert_allclose(list(found.values()), expected, atol=1e-6 * expected.max())
    assert not any("no state of rest" in note for note in made.notes)


@pytest.mark.parametrize("pull", [3.0, 12.0, 30.0])
def test_a_wedge_that_slips_at_rest_carries_what_the_coefficient_of_its_load_lets_it(pull):
    """Both sides slip along their faces at 45° under a pull that begins at nothing: 2 (N + μ(N) N)/√2 = pull."""
    mu = ss.LoadDependentFriction((2.0, 5.0, 15.0), (0.4, 0.25, 0.15))
    wedge = wedge_between()
    problem = replace(
        wedge.with_contacts(lambda c: replace(c, law=replace(c.law, mu=mu, preload=0.0), balanced=False)),
        forces=(*wedge.forces, ss.Force("body.y", static=pull)),
    )
    load = brentq(lambda N: np.sqrt(2.0) * (N + float(mu.limit(N))) - pull, 0.1, pull)
    np.testing.assert_allclose(list(normal_loads_at_rest(problem).values()), [load, load], rtol=1e-9)


def test_contacts_seated_without_friction_have_the_least_energy_and_slide_no_farther_than_they_must():
    """Of the chain masses slide on pads along x, off and on them along y; SciPy minimises ½ qᵀKq − pᵀq + Σ kn max(y, 0)²/2, and
    beside it a small Σ kt u²: the last mass is held along x by nothing else."""
    rng, size = np.random.default_rng(3), 4
    chain = 2.0 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    K = np.block([[3.0 * chain, 0.4 * chain], [0.4 * chain, chain]])
    K[size - 1], K[:, size - 1] = 0.0, 0.0
    dofs = tuple(f"{k}.{axis}" for axis in "xy" for k in range(size))
    kt, kn = np.array([1.0, 200.0, 5.0, 7.0]), 20.0
    tied = dofs[size - 1], dofs[0]  # one pad joins the loose mass to the first one
    for _ in range(5):
        p = rng.normal(size=2 * size)
        p[size - 1] = 0.0
        pads = tuple(
            ss.Contact(
                f"pad {k}",
                ss.Macroslip(float(kt[k]), 0.3, kn),
                (ss.between(*tied) if k == size - 1 else {dofs[k]: 1.0},),
                {dofs[size + k]: 1.0},
            )
            for k in range(size)
        )
        forces = tuple(ss.Force(dof, 0.0, static=float(each)) for dof, each in zip(dofs, p, strict=True))
        problem = ss.Problem(ss.Structure(np.eye(2 * size), K, dofs), pads, (ss.Force("0.y", 1.0), *forces), ("0.y",))

        def energy(q, p=p):
            N, u = kn * np.maximum(q[size:], 0.0), q[size - 1] - q[0]
            slope = K @ q - p + np.concatenate([np.zeros(size), N])
            slope[size - 1] += u
            slope[0] -= u
            return 0.5 * q @ K @ q - p @ q + 0.5 * N @ N / kn + 0.5 * u**2, slope

        q = minimize(energy, 0.0 * p, jac=True, method="L-BFGS-B", options={"ftol": 1e-16, "gtol": 1e-11}).x
        found = seated(problem)
        expected = np.column_stack([[*q[: size - 1], q[size - 1] - q[0]], q[size:]]).ravel()
        np.testing.assert_allclose(found.motion, expected, atol=1e-6)
        assert expected[-2] == pytest.approx(0.0, abs=1e-6)
        assert not found.forces[::2].any()
        np.testing.assert_allclose(found.forces[1::2], kn * np.maximum(q[size:], 0.0), atol=1e-5)


def test_a_body_that_one_contact_holds_is_at_rest_although_stuck_contacts_would_both_slip():
    """The second contact slips, the first one sticks: T2 = µ N2, T1 = -T2, k a = p0 - T2, w = a - T2/kt1. With all stuck both are
    beyond their limits, and where both slip nothing holds the body. Amplitude and mean at 20 Hz: explicit time integration."""
    k, p0, kt1, kt2, load = 1e5, 8.0, 5e5, 1e5, 10.0
    structure = ss.Structure(
        np.diag([1.0, 0.05, 0.05]), np.diag([k, 0.0, 0.0]), ("a.x", "w.x", "w.y"), C=np.diag([4.0, 0.1, 0.1])
    )
    contacts = (
        ss.Contact("one", ss.Macroslip(kt=kt1, mu=0.3, kn=2 * kt1), ({"w.x": 1.0, "a.x": -1.0},), {"w.y": 1.0}),
        ss.Contact("other", ss.Macroslip(kt=kt2, mu=0.5, kn=2 * kt2), ({"w.x": 1.0},), {"w.y": 1.0}),
    )
    forces = ss.Force("a.x", 1.0, static=p0), ss.Force("w.y", 0.0, static=load)
    problem = ss.Problem(structure, contacts, forces, ("a.x", "w.x"))
    T2 = 0.5 * kt2 * load / (kt1 + kt2)
    a = (p0 - T2) / k
    w = a - T2 / kt1
    rest = at_rest(problem)
    np.testing.assert_allclose(rest.forces[[0, 2]], [-T2, T2], rtol=1e-9)
    np.testing.assert_allclose(rest.motion[[0, 2]], [w - a, w], rtol=1e-9)
    dataset = ss.forced_response(problem, [20.0], force=1e-3, harmonics=3).dataset
    assert float(dataset.amplitude[0, 0, 0]) == pytest.approx(5.98825e-9, rel=1e-4)
    assert float(dataset.response[0, 0, 0, 0, 0]) == pytest.approx(7.16717e-5, rel=1e-5)


@pytest.mark.parametrize(
    ("start", "forces"),
    [
        (ss.SliderOffset(0.5), [4.0 * (3.0 - 0.5) / 5.0, 6.0]),
        (ss.TractionRatio(-0.5), [-0.5 * 0.4 * 6.0, 6.0]),
        (ss.MeanTraction(0.7), [0.7, 6.0]),
    ],
    ids=["offset", "ratio", "mean"],
)
def test_what_a_contact_carries_at_rest_follows_from_its_start_state(start, forces):
    """x + T = 3 along, 0.5 y + N = p across with N = 2 y = 6: T = 4 (x − s), or m μN, or the mean traction."""
    structure = ss.Structure(np.eye(2), np.diag([1.0, 0.5]), ("1.x", "1.y"))
    pad = ss.Contact("pad", ss.Macroslip(4.0, 0.4, 2.0), ({"1.x": 1.0},), {"1.y": 1.0}, start)
    loads = (ss.Force("1.x", 1.0, static=3.0), ss.Force("1.y", 0.0, static=7.5))
    rest = at_rest(ss.Problem(structure, (pad,), loads, ("1.x",)))
    np.testing.assert_allclose(rest.forces, forces, rtol=1e-12)
    np.testing.assert_allclose(rest.motion, [3.0 - forces[0], 3.0], rtol=1e-12)


@pytest.mark.parametrize("stiffness", [1e2, 3e3, 1e5])
def test_very_stiff_contacts_that_open(stiffness):
    """By hand: the contact along y is open, and the slider along x, which sticks, carries −0.1 N. From 3000 N/m on none was."""
    structure = ss.Structure(np.eye(2), np.array([[1.0, 0.9], [0.9, 1.0]]), ("a.x", "a.y"), C=0.01 * np.eye(2))
    contacts = (
        ss.Contact("c", ss.Macroslip(kt=stiffness, kn=stiffness, mu=0.3), ({"a.x": 1.0},), {"a.y": 1.0}),
        ss.Contact("d", ss.Macroslip(kt=stiffness, mu=0.3, normal_load=1.0), ({"a.x": 1.0},)),
    )
    forces = ss.Force("a.x", 1.0, static=-1.0), ss.Force("a.y", static=-1.0)
    rest = at_rest(ss.Problem(structure, contacts, forces, ("a.x",)))
    assert rest.forces == pytest.approx([0.0, 0.0, -0.1], rel=20.0 / stiffness)
