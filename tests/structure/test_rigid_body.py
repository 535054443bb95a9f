"""Rigid bodies: motion of their points against finite rotations, kinetic energy, equilibrium, refusals."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stickslip.model.structure.assembly import SPACE, RigidBody, box_inertia
from stickslip.support.checks import InputError

SEEDS = range(4)


def displaced(motion, body, values: np.ndarray) -> np.ndarray:
    """Displacement of a place along x, y, z for given degrees of freedom of the body."""
    structure = body.structure()
    return np.array([structure.row(motion(axis)) @ values for axis in np.eye(len(np.asarray(body.centre)))])


@pytest.mark.parametrize("seed", SEEDS)
def test_point_moves_as_a_small_rotation_says(seed: int):
    rng = np.random.default_rng(seed)
    body = RigidBody(2.0, np.diag([2.0, 3.0, 4.0]), rng.standard_normal(3))
    point, values, small = rng.standard_normal(3), rng.standard_normal(6), 1e-6
    arm = point - body.centre
    exact = small * values[:3] + Rotation.from_rotvec(small * values[3:]).apply(arm) - arm
    np.testing.assert_allclose(displaced(body.at(point), body, small * values), exact, atol=1e-10)


def test_kinetic_energy_of_a_box_is_that_of_its_points():
    """Gauss points of the box carry its mass exactly."""
    sides, mass = np.array([0.016, 0.010, 0.040]), 0.05
    body = RigidBody(mass, box_inertia(mass, sides), (0.1, 0.2, 0.3))
    offsets = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T / np.sqrt(12.0) * sides
    velocities = np.random.default_rng(5).standard_normal(6)
    points = [displaced(body.at(body.centre + offset), body, velocities) for offset in offsets]
    energy = 0.5 * mass * np.mean(np.sum(np.square(points), axis=1))
    assert 0.5 * velocities @ body.structure().M @ velocities == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_force_at_a_point_is_a_force_and_a_moment_at_the_centre(seed: int):
    rng = np.random.default_rng(seed)
    body = RigidBody(1.0, np.eye(3), rng.standard_normal(3))
    point, force = rng.standard_normal((2, 3))
    wrench = body.structure().row(body.at(point)(force))
    np.testing.assert_allclose(wrench, np.concatenate([force, np.cross(point - body.centre, force)]), atol=1e-14)


def test_names_carry_the_body():
    body = RigidBody(1.0, np.eye(3))
    assert body.structure().dofs == tuple(f"centre.{axis}" for axis in SPACE)
    assert body.at((0.0, 0.0, 0.0), "damper_left")((0.0, 1.0, 0.0)) == {"damper_left/centre.y": 1.0}


@pytest.mark.parametrize(
    ("mass", "inertia", "message"),
    [
        (0.0, np.eye(3), "mass must be positive"),
        (1.0, np.diag([1.0, 1.0, 3.0]), "must have positive principal moments"),
        (1.0, -np.eye(3), "must have positive principal moments"),
        (1.0, np.eye(2), "must have shape"),
    ],
)
def test_impossible_bodies_are_refused(mass, inertia, message):
    with pytest.raises(InputError, match=message):
        RigidBody(mass, inertia)
