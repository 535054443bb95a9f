"""Loads of rotation against closed forms: what contacts alone hold, rods, rigid bodies, and the same on few coordinates."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.performance.work import centrifugal_pull
from stickslip.model.problem import meshed
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.model.readers.model import Model
from stickslip.model.readers.reduction import structure_of, unreduced, whole
from stickslip.model.readers.stress_places import places_of
from stickslip.model.structure.centrifugal import CentrifugalLoads, RotationAxis, softening
from stickslip.model.structure.solid import STEEL, box_mesh, solid

SPEED = 3000.0
OMEGA = 2.0 * np.pi * SPEED / 60.0
FOOT, LENGTH, SIDE = 0.3, 0.1, 0.01


@cache
def bar(elements):
    """A bar of steel along y, from its foot at y = 0.3 m on, that nothing holds."""
    sides = np.linspace(-0.5, 0.5, 3) * SIDE
    body = solid(box_mesh(sides, FOOT + np.linspace(0.0, LENGTH, elements + 1), sides))
    named = {body.numbers[node, k]: f"{node + 1}.{'xyz'[k]}" for node in range(len(body.points)) for k in range(3)}
    nodes = {str(node + 1): tuple(point) for node, point in enumerate(body.points.tolist())}
    foot = tuple(str(node + 1) for node in np.flatnonzero(body.points[:, 1] < FOOT + 1e-9))
    tip = str(1 + int(np.linalg.norm(body.points - [0.0, FOOT + LENGTH, 0.0], axis=1).argmin()))
    dofs = tuple(named[row] for row in range(body.size))
    return Model(body.M, body.K, dofs, nodes=nodes, sets={"FOOT": foot, "TIP": (tip,)}), body


def on_contacts(structure, load, foot, dofs):
    """The problem of a bar whose foot rests in contacts alone, against which it is pulled."""
    law = ss.Macroslip(kt=1e8, kn=2e8, mu=0.5)
    contacts = [ss.Contact(n, law, ({f"{n}.x": 1.0}, {f"{n}.z": 1.0}), {f"{n}.y": 1.0}) for n in foot]
    return structure, contacts, [ss.Force(dofs, 1.0), load], [dofs]


@pytest.mark.parametrize("kind", ["whole", "reduced", "mesh"])
@pytest.mark.parametrize("elements", [3, 8])
def test_contacts_alone_carry_the_centrifugal_load(kind, elements):
    """ΣN = Ω² ∫ρ y dV = Ω² ρ A L (R + L/2), whatever the mesh and however the model is reduced."""
    model, _ = bar(elements)
    places = places_of(model, {"tip": "TIP", "FOOT": "FOOT"}, 1.0)
    if kind == "whole":
        structure, foot, tip = whole(model), model.sets["FOOT"], f"{model.sets['TIP'][0]}.x"
    else:
        many = kind == "mesh"
        structure = unreduced(model, places) if many else structure_of(model, places, 4, None)[0]
        foot, tip = structure.sets["FOOT"], f"{structure.sets['tip'][0]}.x"
    structure, load = ss.in_rotation(structure.with_damping(ss.ModalDamping(0.01)), SPEED, "z")
    expected = OMEGA**2 * STEEL.density * SIDE**2 * LENGTH * (FOOT + 0.5 * LENGTH)
    np.testing.assert_allclose(load.resultant, [0.0, expected, 0.0], rtol=1e-9, atol=1e-9 * expected)
    given = on_contacts(structure, load, foot, tip)
    problem = meshed.meshed_problem(*given, modes_to=2e4) if kind == "mesh" else ss.Problem(*given)
    normal = normal_loads_at_rest(problem)
    assert min(normal.values()) > 0.0
    assert sum(normal.values()) == pytest.approx(expected, rel=1e-6)
    vibrating = ss.forced_response(problem, [50.0], [1e-3], harmonics=1, samples=64).dataset
    mean = vibrating["contact_force"].sel(direction="n", harmonic=0, part="re").values.ravel()
    assert mean.sum() == pytest.approx(expected, rel=1e-6)
    whole_model, load = ss.in_rotation(whole(model), SPEED, "z")
    given = on_contacts(whole_model, load, model.sets["FOOT"], f"{model.sets['TIP'][0]}.x")
    assert mean == pytest.approx(list(normal_loads_at_rest(ss.Problem(*given)).values()), rel=1e-3)


def test_a_flung_damper_presses_its_platforms_with_its_own_mass():
    """On two platforms inclined by 35° Σ N cos 35° + T sin 35° = m Ω² r, with T = kt/kn tan 35° N while they stick."""
    body = ss.RigidBody(0.02, np.diag([1e-6, 2e-6, 2e-6]), (0.0, 0.4, 0.0))
    structure, load = ss.in_rotation(body.structure(), SPEED, "z", part="damper")
    assert load.resultant == pytest.approx((0.0, 0.02 * OMEGA**2 * 0.4, 0.0))
    law, slope, contacts = ss.Macroslip(kt=1e6, kn=2e6, mu=0.9), np.radians(35.0), []
    for side in (-1.0, 1.0):
        normal, along = (side * np.sin(slope), np.cos(slope), 0.0), (-side * np.cos(slope), np.sin(slope), 0.0)
        for depth in (-0.01, 0.01):
            at = body.at((0.01 * side, 0.41, depth), "damper")
            contacts.append(ss.Contact(f"{side} {depth}", law, (at(along), at((0.0, 0.0, 1.0))), at(normal)))
    whole = ss.assemble({"damper": structure}).with_damping(ss.ModalDamping(0.01))
    problem = ss.Problem(whole, contacts, [ss.Force("damper/centre.x", 1.0), load], ["damper/centre.x"])
    assert centrifugal_pull(problem) == pytest.approx(0.02 * OMEGA**2 * 0.4)
    carried = sum(normal_loads_at_rest(problem).values())
    assert carried * (np.cos(slope) + 0.5 * np.tan(slope) * np.sin(slope)) == pytest.approx(0.02 * OMEGA**2 * 0.4, rel=1e-9)


def test_what_has_no_coordinates_is_refused():
    reduced = structure_of(bar(3)[0], places_of(bar(3)[0], {"tip": "TIP", "FOOT": "FOOT"}, 1.0), 4, None)[0]
    for structure, said in (
        (ss.Structure(np.eye(1), np.eye(1), ("1.x",)), "must have coordinates, but is 'none'"),
        (replace(reduced, centrifugal=None), "Node 'mode/1' of a structure"),
    ):
        with pytest.raises(ss.InputError, match=said):
            ss.in_rotation(structure, SPEED)


def test_a_shifted_blade_is_loaded_where_it_stands():
    """A reduced model carries its loads along: moved by s, it is loaded as the model that is reduced there."""
    model, _ = bar(3)
    by = (0.04, -0.1, 0.02)
    there = replace(model, nodes={name: tuple(np.add(point, by)) for name, point in model.nodes.items()})
    axis = ((0.1, -0.2, 0.05), (1.0, 2.0, -0.5))
    loads = []
    for each, step in ((model, by), (there, (0.0, 0.0, 0.0))):
        structure = structure_of(each, places_of(each, {"tip": "TIP", "FOOT": "FOOT"}, 1.0), 4, None)[0].shifted(step)
        load = ss.in_rotation(structure, SPEED, axis)[1]
        loads.append(np.append(load.static * structure.row(load.direction), load.resultant))
    np.testing.assert_allclose(loads[0], loads[1], atol=1e-9 * np.abs(loads[1]).max())


def test_spin_softening_of_nodes_that_are_held_in_part():
    """−Ω² ∫ρ Nᵀ (1 − d dᵀ) N dV; its rows may be held, and what a translation across the axis meets is Ω² times the mass."""
    model, _ = bar(3)
    axis = RotationAxis.of(((0.0, 0.0, 0.0), (1.0, 2.0, -0.5)))
    added = softening(model.M, model.dofs, axis)
    assert abs(added - added.T).max() < 1e-15
    moved = np.array([[float(dof.endswith(axis)) for axis in "xyz"] for dof in model.dofs])
    d = np.array(axis.direction)
    expected = STEEL.density * SIDE**2 * LENGTH * (np.eye(3) - np.outer(d, d))
    np.testing.assert_allclose(moved.T @ (added @ moved), expected, atol=1e-12)


@pytest.mark.parametrize("axis", ["z", ((0.1, -0.2, 0.05), (1.0, 2.0, -0.5))])
def test_a_body_turns_as_its_points_do(axis):
    """Force and moment about the mass centre of m Ω² r⊥ and −Ω × (J Ω), against the sum over point masses."""
    random = np.random.default_rng(3)
    points, masses = random.normal(size=(7, 3)), random.uniform(0.5, 2.0, 7)
    centre = masses @ points / masses.sum()
    arms = points - centre
    J = sum(m * ((a @ a) * np.eye(3) - np.outer(a, a)) for m, a in zip(masses, arms, strict=True))
    body = ss.RigidBody(masses.sum(), J, centre)
    about = RotationAxis.of(axis)
    d = OMEGA * np.array(about.direction)
    forces = masses[:, None] * -np.cross(d, np.cross(d, points - about.point))
    expected = np.concatenate([forces.sum(axis=0), np.cross(arms, forces).sum(axis=0)])
    structure, load = ss.in_rotation(body.structure(), SPEED, axis)
    found = load.static * structure.row(load.direction)
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(load.resultant, expected[:3], atol=1e-9 * np.abs(expected).max())
    moved, twice = ss.in_rotation(body.structure().shifted((0.2, 0.0, 0.0)), SPEED, axis, part="damper")
    assert set(twice.direction) <= {f"damper/{dof}" for dof in moved.dofs}
    # A concentrated mass beside its node: the same load at a place of the body, moved there.
    offset = np.array([0.3, -0.1, 0.2])
    node = centre + offset
    turn = np.eye(6)
    turn[:3, 3:] = np.cross(np.eye(3), offset)  # v of the mass centre by v and ω of the node: v − ω × offset
    M = turn.T @ np.asarray(structure.M) @ turn
    rows = CentrifugalLoads.of(M, structure.dofs, {"centre": node}).about(about)[0]
    np.testing.assert_allclose(OMEGA**2 * rows, turn.T @ expected, atol=1e-9 * np.abs(expected).max())


def test_a_body_on_a_skew_axis_is_not_pulled():
    """Its mass centre lies on the axis to rounding, and its inertia is that of a ball: no load, and none of 1e-14 N."""
    point, direction = np.array([0.1, -0.2, 0.05]), np.array([1.0, 2.0, -0.5])
    body = ss.RigidBody(0.02, 1e-6 * np.eye(3), point + 0.37 * direction)
    _, load = ss.in_rotation(body.structure(), SPEED, (point, direction))
    assert load.resultant == (0.0, 0.0, 0.0)
    assert load.static == 0.0


def test_the_direction_of_an_axis_may_have_any_length():
    """Squares of entries below 1e-162 vanish; below 1e-154 they lose digits."""
    expected = RotationAxis.of(((0.0, 0.0, 0.0), (1.0, 2.0, -2.0))).direction
    np.testing.assert_allclose(expected, (1.0 / 3.0, 2.0 / 3.0, -2.0 / 3.0), rtol=1e-15)
    for size in (1e-300, 1e-250, 1e-160, 1e-150, 1e30):
        found = RotationAxis.of(((0.0, 0.0, 0.0), (size, 2.0 * size, -2.0 * size))).direction
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_a_speed_below_zero_is_refused():
    with pytest.raises(ss.InputError, match="speed must not be negative, but is -3000"):
        ss.in_rotation(whole(bar(3)[0]), -SPEED)
