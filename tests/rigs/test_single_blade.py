"""The single blade with two dampers: calibrated frequencies, rigid motions, loads, contact parameters, refusals."""

import numpy as np
import pytest
from scipy import linalg
from scipy.sparse.linalg import eigsh
from wrench import wrench

from stickslip.model import rigs
from stickslip.model.contact.point import TractionRatio
from stickslip.model.dampers.cylinder import FlatCylinder
from stickslip.model.rigs.single_blade import PUBLISHED, PlatformBlade, pads, placed_dampers, reduced_blade
from stickslip.support.checks import InputError

DAMPERS = placed_dampers(PlatformBlade(), FlatCylinder(), 4.6 * 9.81)


def blade_reduction(modes: int = 150):
    return reduced_blade(PlatformBlade(), tuple(pad for damper in DAMPERS for pad in pads(damper)), modes)


def rigid_motion(rig, translation, rotation) -> np.ndarray:
    """Degrees of freedom when all dampers and pads move as one rigid body; those of the rest of the blade are left at 0."""
    values = dict.fromkeys(rig.structure.dofs, 0.0)
    for damper in DAMPERS:
        for name, point in pads(damper):
            motion = translation + np.cross(rotation, point)
            values |= {f"blade/{name}.{axis}": m for axis, m in zip("xyz", motion, strict=True)}
        motion = np.concatenate([translation + np.cross(rotation, damper.body.centre), rotation])
        values |= {f"{damper.name}/centre.{axis}": m for axis, m in zip(["x", "y", "z", "rx", "ry", "rz"], motion, strict=True)}
    return np.array([values[dof] for dof in rig.structure.dofs])


def test_free_blade_has_the_published_first_frequency():
    """410 Hz is published; 661.92 Hz comes from the calibration of the dimensions."""
    structure = blade_reduction().structure
    frequencies = np.sqrt(linalg.eigvalsh(structure.K, structure.M)) / (2 * np.pi)
    np.testing.assert_allclose(frequencies[:2], [410.00, 661.92], rtol=1e-4)


def test_reduction_keeps_the_modes_of_the_mesh():
    body = PlatformBlade().clamped()
    squares = eigsh(body.K, 8, body.M, sigma=0.0, return_eigenvectors=False, v0=np.ones(body.size))
    structure = blade_reduction().structure
    np.testing.assert_allclose(linalg.eigvalsh(structure.K, structure.M)[:8], np.sort(squares), rtol=1e-5)


@pytest.mark.parametrize(("mass", "frequency"), [(2.6, 544.27), (4.6, 561.1), (6.6, 564.64)])
def test_stuck_frequencies(mass: float, frequency: float):
    """561.1 Hz at 4.6 kg: independent script of this project; the others: this package, kept from drifting."""
    assert rigs.single_blade(mass).frequencies(stuck=True)[0] == pytest.approx(frequency, rel=2e-4)


def test_free_dampers_are_rigid_bodies():
    frequencies = rigs.single_blade().frequencies(stuck=False)
    assert np.all(frequencies[:12] < 1e-2)
    assert frequencies[12] == pytest.approx(410.0, rel=1e-4)


@pytest.mark.parametrize("seed", range(4))
def test_rigid_motion_of_blade_and_dampers_moves_no_flat_contact(seed: int):
    rig = rigs.single_blade()
    translation, rotation = np.random.default_rng(seed).standard_normal((2, 3))
    motion = rigid_motion(rig, translation, rotation)
    flat = [d for c in rig.contacts if "flat" in c.name for d in c.directions]
    np.testing.assert_allclose(rig.structure.rows(flat) @ motion, 0.0, atol=1e-14)
    grounded = [c for c in rig.contacts if "cylinder" in c.name]
    for contact in grounded:
        damper = next(d for d in DAMPERS if contact.name.startswith(d.label))
        surface = damper.surface("cylinder")
        point = np.asarray(surface.points)[int(contact.name[-1]) - 1]
        seen = -np.asarray(surface.frame) @ (translation + np.cross(rotation, point))
        np.testing.assert_allclose(rig.structure.rows(contact.directions) @ motion, seen, atol=1e-14)


@pytest.mark.parametrize("damper", DAMPERS, ids=lambda damper: damper.label)
def test_contact_forces_on_a_damper_are_their_sum_and_moment(damper):
    rig = rigs.single_blade()
    forces = np.random.default_rng(1).standard_normal((len(rig.contacts), 3))
    on_damper = -(rig.B.T @ forces.ravel())[[rig.structure.index(f"{damper.name}/{dof}") for dof in damper.structure.dofs]]
    expected = np.zeros(6)
    for surface in ("flat", "cylinder"):
        own = [i for i, c in enumerate(rig.contacts) if c.name.startswith(f"{damper.label} {surface}")]
        expected += wrench(damper, surface, forces[own])
    np.testing.assert_allclose(on_damper, expected, atol=1e-13)


def test_contacts_loads_and_output():
    rig = rigs.single_blade(4.6, force=2.0)
    names = [f"{side} flat {i}" for side in ("left", "right") for i in range(1, 6)]
    assert [c.name for c in rig.contacts if "flat" in c.name] == names
    elements = sum(f.stiffness.size for c in rig.contacts for f in c.elements.friction)
    assert elements == 80, "the published number of macroslip elements"
    load = rig.load(1)
    assert load[rig.structure.index("blade/force.x")].tolist() == [0.0, 2.0, 0.0]
    for damper in DAMPERS:
        assert load[rig.structure.index(f"{damper.name}/centre.y"), 0] == pytest.approx(4.6 * 9.81)
    assert rig.output_names == ("blade/tip.x",)
    assert rig.structure.size == 32 + 150 + 12


@pytest.mark.parametrize("mass", sorted(PUBLISHED))
def test_contact_stiffness_adds_up_to_the_published_totals(mass: float):
    rig, table = rigs.single_blade(mass), PUBLISHED[mass]
    stiffness = rig.contact_stiffness.reshape(-1, 3)
    flat = np.array(["flat" in c.name for c in rig.contacts])
    np.testing.assert_allclose(stiffness[flat].sum(axis=0) / 2, [table.flat_kt, table.flat_kt, table.flat_kn])
    np.testing.assert_allclose(stiffness[~flat].sum(axis=0) / 2, [table.cylinder_kt, table.cylinder_kt, table.cylinder_kn])
    gaps = next(c.law.gaps for c in rig.contacts if "cylinder" in c.name)
    mean_closure = mass * 9.81 / np.sqrt(2.0) / table.cylinder_kn
    np.testing.assert_allclose(gaps, 2 * 0.9 * mean_closure * np.arange(5) / 4)


def test_every_stuck_mode_has_the_published_damping():
    rig = rigs.single_blade()
    squares, modes = linalg.eigh(rig.stuck_stiffness, rig.structure.M)
    np.testing.assert_allclose(np.diag(modes.T @ rig.C @ modes), 2 * 0.008 * np.sqrt(squares), rtol=1e-6)


def test_static_load_closes_every_contact_of_the_stuck_linear_rig():
    """Left and right carry the same; on average the normal load of each side is near F_C/(2 cos α)."""
    rig = rigs.single_blade()
    motion = linalg.solve(rig.stuck_stiffness, rig.load(1)[:, 0], assume_a="pos")
    normal = (rig.contact_stiffness * (rig.B @ motion)).reshape(-1, 3)[:, 2]
    assert np.all(normal > 0.0)
    np.testing.assert_allclose(normal[:8], normal[8:], rtol=1e-6)
    assert abs(motion[rig.structure.index("blade/tip.x")]) < 1e-12


def test_other_preload_masses_need_all_contact_parameters():
    with pytest.raises(InputError, match=r"must be 2.6, 4.6 or 6.6 kg.*but is 5.0.*give flat_kn, .*nothing is interpolated"):
        rigs.single_blade(5.0, flat_kt=2e7)
    explicit = {"flat_kt": 2e7, "flat_kn": 6e7, "flat_mu": 0.5, "cylinder_kt": 4e7, "cylinder_kn": 2e8, "cylinder_mu": 0.4}
    rig = rigs.single_blade(5.0, **explicit)
    assert rig.contact_stiffness.reshape(-1, 3)[:5].sum(axis=0) == pytest.approx([2e7, 2e7, 6e7])
    softer = rigs.single_blade(4.6, cylinder_kt=1e7)
    assert softer.frequencies(stuck=True)[0] < rigs.single_blade(4.6).frequencies(stuck=True)[0]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"preload_mass": -1.0}, "preload_mass must be positive"),
        ({"flat_kt": -1.0}, "flat_kt must be positive"),
        ({"cylinder_mu": -0.1}, "cylinder_mu must not be negative"),
        ({"platform_angle": 70.0}, "must leave the platform some height"),
        ({"length": 0.1}, "must lie above each other"),
        ({"damping": -0.1}, "damping ratio must not be negative"),
    ],
)
def test_impossible_parameters_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        rigs.single_blade(**wrong)


def test_start_state_and_angle_can_be_chosen():
    rig = rigs.single_blade(platform_angle=30.0, start=TractionRatio(0.2), modes=20)
    assert {c.start for c in rig.contacts} == {TractionRatio(0.2)}
    assert rig.structure.size == 32 + 20 + 12
