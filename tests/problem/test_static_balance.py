"""Loads that contacts can and cannot carry: a box on the ground, against the closed forms of sliding, tilting and lifting."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.problem.at_rest import unbearable_loads
from stickslip.study.reading import job
from stickslip.study.templates import write_new

MU, HALF, WEIGHT = 0.3, 0.2, 10.0


def box(static, starts=ss.SliderOffset(), preload=0.0, balanced=False):  # noqa: B008
    """A box on four points at ±HALF in x and y, its mass centre HALF above them; static: coefficients of its load, N and N m."""
    structure = ss.RigidBody(1.0, np.eye(3), node="box").structure()
    law = ss.Macroslip(1e3, MU, kn=1e4, preload=preload)

    def motion(point, direction):
        turned = np.cross(point, direction)
        pairs = zip(("x", "y", "z", "rx", "ry", "rz"), (*direction, *turned), strict=True)
        return {f"box.{axis}": float(c) for axis, c in pairs if c}

    contacts = []
    for x in (-HALF, HALF):
        for y in (-HALF, HALF):
            directions = [motion((x, y, -HALF), np.array(d)) for d in ((1, 0, 0), (0, 1, 0), (0, 0, -1))]
            contacts.append(ss.Contact(f"{x:g} {y:g}", law, tuple(directions[:2]), directions[2], starts, balanced))
    loads = (ss.Force("box.x", 1.0), *(ss.Force(f"box.{axis}", static=size) for axis, size in static.items()))
    return ss.Problem(structure, tuple(contacts), loads, ("box.x",), "box")


@pytest.mark.parametrize(
    ("load", "largest"),
    [
        ({"x": 1.0}, MU * WEIGHT),  # it slides before it tilts, since MU HALF < HALF
        ({"y": -1.0}, MU * WEIGHT),
        ({"ry": 1.0}, HALF * WEIGHT),  # it tilts about two of its points
        ({"rx": -1.0}, HALF * WEIGHT),
        ({"z": 1.0}, WEIGHT),  # it is lifted
        ({"rz": 1.0}, 2.0 * HALF * MU * WEIGHT),  # it turns on the spot: friction of each point within a square
    ],
)
def test_a_box_is_at_rest_up_to_the_load_at_which_it_slides_tilts_lifts_or_turns(load, largest):
    ((axis, sign),) = load.items()

    def loaded(share):
        return box({"z": -WEIGHT, axis: share * largest * sign} if axis != "z" else {"z": (share - 1.0) * WEIGHT})

    assert unbearable_loads(loaded(0.99)) == []
    assert unbearable_loads(loaded(1.01)) == ["box"]


def test_units_of_lengths_decide_nothing():
    """The same box of a thousandth the size, load and moment scaled with it."""
    for share, bodies in ((0.99, []), (1.01, ["box"])):
        problem = box({"z": -WEIGHT, "ry": share * HALF * WEIGHT})
        small = replace(
            problem, contacts=tuple(_scaled(contact, 1e-3) for contact in problem.contacts), forces=_moments(problem, 1e-3)
        )
        assert unbearable_loads(small) == bodies


def _scaled(contact, factor):
    def scaled(direction):
        return {dof: c * (factor if ".r" in dof else 1.0) for dof, c in direction.items()}

    return replace(contact, tangential=tuple(map(scaled, contact.tangential)), normal=scaled(contact.normal))


def _moments(problem, factor):
    return tuple(
        replace(force, static=force.static * factor) if ".r" in str(force.direction) else force for force in problem.forces
    )


def test_a_preload_from_which_contacts_count_is_no_load_to_carry():
    """Balanced contacts of preload 5 N each stay at rest without a load, and under a pull of less than 20 N."""
    assert unbearable_loads(box({}, preload=5.0, balanced=True)) == []
    assert unbearable_loads(box({"z": 19.9}, preload=5.0, balanced=True)) == []
    assert unbearable_loads(box({"z": 20.1}, preload=5.0, balanced=True)) == ["box"]


def lumped(K, contacts, load):
    """Masses of 1 kg in a line, 1.x, 2.x, ..., with sliders {(place, place): limit} and a static load on each [N]."""
    dofs = tuple(f"{k + 1}.x" for k in range(len(load)))
    made = tuple(
        ss.Contact(f"{a} {b}", ss.Macroslip(1e3, 1.0, normal_load=limit), (ss.between(a, b),))
        for (a, b), limit in contacts.items()
    )
    forces = (ss.Force(dofs[-1], 1.0), *(ss.Force(dof, static=size) for dof, size in zip(dofs, load, strict=True)))
    return ss.Problem(ss.Structure(np.eye(len(load)), np.array(K, dtype=float), dofs), made, forces, dofs)


def test_a_load_is_passed_on_from_body_to_body():
    """Two masses, one on the other: the lower contact carries both loads, and a stop on the other side takes its share."""
    zero = np.zeros((2, 2))
    pile = {("1.x", "ground"): 0.5, ("2.x", "1.x"): 5.0}
    assert unbearable_loads(lumped(zero, pile, [0.0, 0.49])) == []
    assert unbearable_loads(lumped(zero, pile, [0.0, 0.51])) == ["1 and 2"]
    assert unbearable_loads(lumped(zero, pile, [-0.3, 0.6])) == []
    assert unbearable_loads(lumped(zero, pile, [0.0, 6.0])) == ["2"]
    assert unbearable_loads(lumped(zero, pile | {("2.x", "ground"): 0.2}, [0.0, 0.69])) == []


@pytest.mark.parametrize(("load", "bodies"), [(1.0, []), (-1.0, ["1"])])
def test_a_stop_presses_and_does_not_pull(load, bodies):
    stop = ss.Contact("stop", ss.Gap(1e3), (), ss.between("1.x", "ground"))
    forces = ss.Force("1.x", 1.0), ss.Force("1.x", static=load)
    assert unbearable_loads(ss.Problem(ss.Structure(np.eye(1), np.zeros((1, 1)), ("1.x",)), (stop,), forces, ("1.x",))) == bodies


@pytest.mark.parametrize("support", [10.0, 1e-2])
def test_a_soft_support_beside_a_stiff_coupling_holds(support):
    coupled = 1e10 * np.array([[1.0, -1.0], [-1.0, 1.0]]) + np.diag([support, 0.0])
    expected = [] if support == 10.0 else ["1"]  # 1e-12 of the coupling is rounding
    assert unbearable_loads(lumped(coupled, {("2.x", "ground"): 0.5}, [0.0, 10.0])) == expected


@pytest.mark.parametrize("angle", range(0, 91, 5))
def test_rounding_of_a_load_that_a_spring_carries_is_no_load(angle):
    """A mass on an inclined spring, its load along the spring and a stop across it."""
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    stop = ss.Contact("stop", ss.Gap(1e3), (), {"1.x": -along[1], "1.y": along[0]})
    loads = (ss.Force("1.x", 1.0), ss.Force({"1.x": along[0], "1.y": along[1]}, static=10.0))
    structure = ss.Structure(np.eye(2), 1e3 * np.outer(along, along), ("1.x", "1.y"))
    assert unbearable_loads(ss.Problem(structure, (stop,), loads, ("1.x",))) == []


@pytest.mark.parametrize("seed", range(60))
def test_loads_that_contacts_and_springs_carry_by_construction_are_not_refused(seed):
    """One to three bodies with two degrees of freedom, springs, and contacts in random directions: the load is the sum of what
    admissible contact forces and a displacement of the springs give."""
    rng = np.random.default_rng(seed)
    bodies = int(rng.integers(1, 4))
    dofs = tuple(f"{k + 1}.{axis}" for k in range(bodies) for axis in "xy")
    springs = rng.normal(size=(int(rng.integers(0, 3)), len(dofs))) * 10.0 ** rng.uniform(1.0, 3.0)
    K, load, contacts = springs.T @ springs, np.zeros(len(dofs)), []
    for number in range(bodies + int(rng.integers(0, 3))):
        tangential, normal = rng.normal(size=(2, len(dofs)))
        mu, force = rng.uniform(0.1, 1.0), rng.uniform(0.0, 50.0)
        load += force * normal + rng.uniform(-1.0, 1.0) * mu * force * tangential
        law = ss.Macroslip(10.0 ** rng.uniform(2.0, 6.0), mu, kn=10.0 ** rng.uniform(2.0, 6.0))
        directions = [dict(zip(dofs, direction.tolist(), strict=True)) for direction in (tangential, normal)]
        contacts.append(ss.Contact(str(number), law, (directions[0],), directions[1]))
    load += K @ rng.normal(size=len(dofs)) * 1e-3
    forces = (ss.Force(dofs[0], 1.0), *(ss.Force(dof, static=float(size)) for dof, size in zip(dofs, load, strict=True)))
    assert unbearable_loads(ss.Problem(ss.Structure(np.eye(len(dofs)), K, dofs), tuple(contacts), forces, dofs[:1])) == []


def test_a_study_whose_damper_is_pulled_off_its_platforms_is_refused(tmp_path):
    write_new("lumped", tmp_path / "study.toml")
    text = (tmp_path / "study.toml").read_text()
    text = text.replace("mu = 0.5", "mu = 0.2")  # with 0.5 the wedge sticks between the platforms by itself
    job(text, tmp_path, "study")
    with pytest.raises(ss.InputError, match="The contacts cannot carry the static load on 'D'"):
        job(text.replace("static = 120.0 ", "static = -120.0 "), tmp_path, "study")
