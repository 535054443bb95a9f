"""The rig with force separators, other contact models and a stinger: balance of forces, limits, refusals."""

import numpy as np
import pytest
from scipy import linalg

from stickslip.model import rigs
from stickslip.model.structure.assembly import assemble
from stickslip.support.checks import InputError
from verify.rig_models import ForceSeparator, with_separators, with_stinger

SIDES = (-1, 1)


def separator(side, **dimensions):
    return ForceSeparator(**dimensions).placed("s", (side * 0.036, 0.087, 0.0), side, 45.0)


@pytest.mark.parametrize("side", SIDES)
def test_a_separator_is_two_boxes(side):
    """Mass centre and moments from the boxes of both arms, summed over small cubes."""
    part = separator(side)
    s, grid = part.shape, (np.arange(40) + 0.5) / 40
    cubes = []
    for along in part.arms:
        sides = np.where(along != 0.0, s.arm, s.thickness)
        sides[2] = s.depth
        local = np.stack(np.meshgrid(*[(grid - 0.5) * length for length in sides], indexing="ij"), axis=-1).reshape(-1, 3)
        cubes.append(part.corner + 0.5 * s.arm * along + local)
    points = np.vstack(cubes)
    arms = points - points.mean(axis=0)
    inertia = s.mass * (np.mean(np.sum(arms**2, axis=1)) * np.eye(3) - arms.T @ arms / len(points))
    np.testing.assert_allclose(part.body.centre, points.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(part.body.inertia, inertia, atol=1e-3 * inertia.max())


@pytest.mark.parametrize("side", SIDES)
def test_the_contact_force_is_split_along_the_arms(side):
    """A force along the normal of the cylinder side presses both cells alike, each along its axis: no moment, no shear."""
    part = separator(side, cell_shear=1e-9)
    structure = assemble({"s": part.structure}, list(part.cells()))
    push = np.array([side, 1.0, 0.0]) / np.sqrt(2.0)
    load = structure.row(part.at(part.corner - part.shape.pad * push)((100.0 * push).tolist()))
    motion = linalg.solve(structure.K, load)
    for along in part.arms:
        seat = structure.row(part.at(part.corner + part.shape.arm * along)(along.tolist()))
        assert part.shape.cell_stiffness * seat @ motion == pytest.approx(100.0 / np.sqrt(2.0), rel=1e-6)


@pytest.fixture(scope="module")
def rig():
    return with_separators(modes=40)


def test_five_bodies_and_a_softer_support(rig):
    assert len({dof.split("/")[0] for dof in rig.structure.dofs}) == 5
    plain = rigs.single_blade(modes=40).frequencies(stuck=True)[0]
    firm = with_separators(cell_stiffness=1e13, modes=40).frequencies(stuck=True)[0]
    assert rig.frequencies(stuck=True)[0] == pytest.approx(556.1, rel=1e-3)
    assert firm == pytest.approx(plain, rel=1e-5)


def _normal_rows(problem):
    rows, first = [], 0
    for contact in problem.contacts:
        first += len(contact.direction_names)
        rows.append(first - 1)
    return rows


@pytest.mark.parametrize(("points", "elements"), [(4, 1), (9, 5), (15, 1)])
def test_other_contact_models_keep_the_totals(points, elements):
    problem = rigs.single_blade(flat_points=points, cylinder_elements=elements, modes=20)
    stiffness = dict.fromkeys(("flat", "cylinder"), 0.0)
    for contact, row in zip(problem.contacts, _normal_rows(problem), strict=True):
        stiffness[contact.name.split()[1]] += problem.contact_stiffness[row] / 2.0
    assert stiffness == pytest.approx({"flat": 65e6, "cylinder": 260e6})
    assert len(problem.contacts) == 2 * (points + 3)


def test_a_stinger_lies_in_the_load_path():
    """Statically the whole force passes the stinger; a rigid one only adds its mass to the blade."""
    plain, soft = rigs.single_blade(modes=20), with_stinger(1e6, modes=20)
    tip = [linalg.solve(p.stuck_stiffness, p.load(1)[:, 1]) @ p.output_rows[0] for p in (plain, soft)]
    assert tip[1] == pytest.approx(tip[0], rel=1e-9)
    stiff, massless = (with_stinger(1e12, mass, modes=20) for mass in (1.0, 1e-6))
    assert massless.frequencies(stuck=True)[0] == pytest.approx(plain.frequencies(stuck=True)[0], rel=1e-6)
    assert stiff.frequencies(stuck=True)[0] < plain.frequencies(stuck=True)[0] - 0.5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"flat_points": 7}, "flat_points must be one of 4, 5, 9, 15"),
        ({"cylinder_elements": 0}, "elements must be at least 2"),
    ],
)
def test_wrong_input_is_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        rigs.single_blade(modes=20, **arguments)
