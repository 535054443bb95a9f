"""The damper harness: every shape that is listed, wherever it is placed, obeys the balance of forces and moments."""

import numpy as np
import pytest
from scipy import linalg

from stickslip.checks import InputError
from stickslip.contact.macroslip import Macroslip
from stickslip.contact.point import ground
from stickslip.dampers import SHAPES, FlatCylinder
from stickslip.dampers.damper import ContactSurface, Damper

PLACE = (0.02, 0.087, 0.003)
CASES = [(shape, side) for shape in SHAPES for side in (-1, 1)]


def all_contacts(damper: Damper, kt: float = 1e6, kn: float = 1e6):
    """Every surface against the ground, totals kt and kn per surface."""
    names = [surface.name for surface in damper.surfaces]
    return [c for name in names for c in damper.contacts(name, lambda share: Macroslip(share * kt, 0.5, share * kn), ground)]


@pytest.mark.parametrize(("shape", "side"), CASES)
def test_contact_forces_act_as_their_sum_and_moment(shape, side):
    """−Bᵀf on the damper's degrees of freedom is the wrench of f at the contact points."""
    damper = shape().damper("d", PLACE, side, 45.0)
    rows = {
        surface.name: damper.contacts(surface.name, lambda share: Macroslip(1.0, 0.5, 1.0), ground) for surface in damper.surfaces
    }
    rng = np.random.default_rng(2)
    for name, contacts in rows.items():
        forces = rng.standard_normal((len(contacts), 3))
        B = np.array([[d.get(f"d/{dof}", 0.0) for dof in damper.structure.dofs] for c in contacts for d in c.directions])
        np.testing.assert_allclose(-B.T @ forces.ravel(), damper.wrench(name, forces), atol=1e-14)


@pytest.mark.parametrize(("shape", "side"), CASES)
def test_frames_are_orthonormal_and_normals_push_down_against_the_pull(shape, side):
    damper = shape().damper("d", PLACE, side, 45.0)
    for surface in damper.surfaces:
        frame = np.asarray(surface.frame)
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)
        assert frame[2] @ np.asarray(damper.pull) < 0.0
    np.testing.assert_allclose([f.static for f in damper.forces()], [45.0])
    assert [f.at for f in damper.forces()] == ["d/centre.y"]


@pytest.mark.parametrize(("shape", "side"), CASES)
def test_normal_loads_without_friction_balance_the_pull(shape, side):
    """Linear springs, friction springs a millionth as stiff: N of each surface is F_C/(2 cos α), whatever the stiffnesses."""
    dimensions, pull = shape(), 45.0
    damper = dimensions.damper("d", PLACE, side, pull)
    contacts = all_contacts(damper, kt=1.0, kn=1e6)
    B = np.array([[d.get(f"d/{dof}", 0.0) for dof in damper.structure.dofs] for c in contacts for d in c.directions])
    stiffness = np.concatenate([[c.law.kt, c.law.kt, c.law.kn] for c in contacts])
    motion = linalg.solve(B.T @ (stiffness[:, None] * B), [0.0, pull, 0.0, 0.0, 0.0, 0.0])
    normal = (stiffness * (B @ motion)).reshape(-1, 3)[:, 2]
    by_surface = {
        s.name: sum(n for c, n in zip(contacts, normal, strict=True) if f" {s.name} " in c.name) for s in damper.surfaces
    }
    assert list(by_surface.values()) == pytest.approx([dimensions.normal_load(pull)] * 2, rel=1e-4)


def test_flat_cylinder_from_its_dimensions():
    damper = FlatCylinder().damper("damper_right", PLACE, 1, 45.0, "right")
    flat, line = np.asarray(damper.surface("flat").points), np.asarray(damper.surface("cylinder").points)
    np.testing.assert_allclose(flat[-1], PLACE)
    np.testing.assert_allclose(flat[:4].mean(axis=0), PLACE, atol=1e-15)
    np.testing.assert_allclose(np.ptp(flat, axis=0), [8e-3, 8e-3, 40e-3], rtol=1e-9)
    np.testing.assert_allclose(line[1] - PLACE, [16e-3, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(damper.body.centre - PLACE, [8e-3, 0.0, 0.0], atol=1e-15)
    names = [c.name for c in all_contacts(damper)]
    assert names == [f"right flat {i}" for i in range(1, 6)] + [f"right cylinder {i}" for i in range(1, 4)]
    assert FlatCylinder().normal_load(4.6 * 9.81) == pytest.approx(4.6 * 9.81 / np.sqrt(2.0))


def test_left_damper_is_the_mirror_image():
    mirror = np.diag([-1.0, 1.0, 1.0])
    right = FlatCylinder().damper("r", PLACE, 1, 45.0)
    left = FlatCylinder().damper("l", mirror @ PLACE, -1, 45.0)
    for one, other in zip(left.surfaces, right.surfaces, strict=True):
        np.testing.assert_allclose(np.asarray(one.points), np.asarray(other.points) @ mirror, atol=1e-15)
        np.testing.assert_allclose(np.asarray(one.frame), np.asarray(other.frame) @ mirror, atol=1e-15)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [({"mass": 0.0}, "mass must be positive"), ({"platform_angle": 90.0}, "must lie in"), ({"depth": -1.0}, "depth must be")],
)
def test_impossible_dimensions_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        FlatCylinder(**wrong)


def test_faults_of_dampers_say_what_is_known():
    damper = FlatCylinder().damper("d", PLACE, 1, 45.0)
    with pytest.raises(InputError, match=r"no contact surface 'flt'. Did you mean 'flat'"):
        damper.surface("flt")
    with pytest.raises(InputError, match="must be one, or 5, one per point"):
        damper.contacts("flat", lambda share: Macroslip(1.0, 0.5, 1.0), [ground, ground])
    with pytest.raises(InputError, match="must be positive with sum 1"):
        ContactSurface("line", [[0.0, 0.0, 0.0]], np.eye(3), [0.5])
    with pytest.raises(InputError, match=r"side must be 1 \(right\) or -1"):
        FlatCylinder().damper("d", PLACE, 0, 45.0)
