"""The damper harness: every shape that is listed, wherever it is placed, obeys the balance of forces and moments."""

import itertools

import numpy as np
import pytest
from scipy import linalg
from scipy.spatial import ConvexHull
from wrench import wrench

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import ground
from stickslip.model.dampers import SHAPES, Cylinder, FlatCylinder, HalfCylinder, Wedge
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.model.dampers.damper import ContactSurface, Damper, Section, Touch, hull_of, polygon, rounded_hull
from stickslip.support.checks import InputError

PLACE = (0.02, 0.087, 0.003)
CASES = [(shape, side) for shape in SHAPES.values() for side in (-1, 1)]


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
        np.testing.assert_allclose(-B.T @ forces.ravel(), wrench(damper, name, forces), atol=1e-14)


@pytest.mark.parametrize(("shape", "side"), CASES)
def test_frames_are_orthonormal_and_normals_push_down_against_the_pull(shape, side):
    damper = shape().damper("d", PLACE, side, 45.0)
    for surface in damper.surfaces:
        frame = np.asarray(surface.frame)
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)
        assert frame[2] @ np.asarray(damper.pull) < 0.0
    np.testing.assert_allclose([f.static for f in damper.forces()], [45.0])
    assert [f.direction for f in damper.forces()] == ["d/centre.y"]


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
    assert list(by_surface.values()) == pytest.approx([pull / (2.0 * np.cos(np.pi / 4.0))] * 2, rel=1e-4)


@pytest.mark.parametrize("shape", SHAPES.values())
def test_unequal_slopes_share_the_pull_by_the_sine_rule(shape):
    """Without friction, three forces: N_left/sin α_R = N_right/sin α_L = F_C/sin(α_L + α_R)."""
    left, right, pull = np.radians(35.0), np.radians(50.0), 45.0
    damper = shape(left_angle=35.0, right_angle=50.0).damper(pull=pull)
    total = np.zeros(6)
    for name, share in (("left", right), ("right", left)):
        size = pull * np.sin(share) / np.sin(left + right)
        points = np.asarray(damper.surface(name).points)
        total += wrench(damper, name, np.tile([0.0, 0.0, size / len(points)], (len(points), 1)))
    np.testing.assert_allclose(total[:3], [0.0, -pull, 0.0], atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES.values())
def test_a_mirrored_shape_is_the_shape_of_exchanged_slopes_mirrored(shape):
    """The mirror image has the same loads and the mirror image of every point, normal and principal inertia."""
    one = shape(left_angle=35.0, right_angle=50.0).damper(pull=10.0)
    other = shape(left_angle=35.0, right_angle=50.0).damper(side=-1, pull=10.0)
    mirror = np.diag([-1.0, 1.0, 1.0])
    for here, there in (("left", "right"), ("right", "left")):
        a, b = one.surface(here), other.surface(there)
        np.testing.assert_allclose(np.asarray(b.points), np.asarray(a.points) @ mirror, atol=1e-15)
        np.testing.assert_allclose(np.asarray(b.frame)[2], np.asarray(a.frame)[2] @ mirror, atol=1e-15)
        assert np.linalg.det(np.asarray(a.frame)) == pytest.approx(1.0)
        assert np.linalg.det(np.asarray(b.frame)) == pytest.approx(1.0)
    np.testing.assert_allclose(np.linalg.eigvalsh(other.body.inertia), np.linalg.eigvalsh(one.body.inertia))


@pytest.mark.parametrize("shape", SHAPES.values())
def test_damper_and_both_platforms_moving_as_one_body_cause_no_relative_motion(shape):
    """Translations with rigid platforms as well as with an elastic right one; a rotation moves a contact by θ × arm."""
    damper = shape(left_angle=40.0, right_angle=48.0).damper(pull=10.0)
    rig = BetweenPlatforms.macroslip(damper, 1.0, 1.0, 0.3)
    B = rig.rows(("damper.x", "damper.y", "damper.rz", "left.x", "left.y", "right.x", "right.y"))
    for x, y in ((1.0, 0.0), (0.0, 1.0), (0.3, -0.7)):
        np.testing.assert_allclose(B @ [x, y, 0.0, x, y, x, y], 0.0, atol=1e-15)
    for index, point in enumerate(rig.points):
        moved = -np.array([-point.arm[1], point.arm[0]])
        np.testing.assert_allclose(B[2 * index : 2 * index + 2, 2], [moved @ point.tangent, moved @ point.normal], atol=1e-15)


def inside(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether points (k, 2) lie inside a convex polygon given counter-clockwise."""
    edges = np.roll(corners, -1, axis=0) - corners
    arms = points[:, None, :] - corners[None]
    return np.all(edges[:, 0] * arms[..., 1] - edges[:, 1] * arms[..., 0] >= 0.0, axis=1)


def outline(shape) -> np.ndarray:
    """A fine polygon round each section, drawn here anew, with the area's centroid wherever it falls."""
    angle = np.linspace(0.0, 2.0 * np.pi, 101)[:-1]
    if type(shape) is Cylinder:
        return shape.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if isinstance(shape, HalfCylinder):
        half = np.linspace(0.0, np.pi, 101)
        return shape.radius * np.stack([np.cos(half), np.sin(half)], axis=1)
    if isinstance(shape, Wedge):
        return shape.corners()
    circle = shape.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) + [shape.span, 0.0]
    cloud = np.vstack([circle, shape.feet()])
    return cloud[ConvexHull(cloud).vertices]


@pytest.mark.parametrize("shape", [s for s in SHAPES.values() if hasattr(s(), "density")])
def test_mass_and_inertia_are_those_of_the_filled_outline(shape):
    """Against a midpoint sum over the points of a fine grid that lie inside the outline."""
    dimensions = shape(left_angle=40.0, right_angle=48.0)
    corners, n = outline(dimensions), 120
    low, high = corners.min(axis=0), corners.max(axis=0)
    cell = (high - low) / n
    grid = np.stack(np.meshgrid(*(low[i] + cell[i] * (np.arange(n) + 0.5) for i in (0, 1)), indexing="ij"), axis=-1).reshape(
        -1, 2
    )
    points = grid[inside(corners, grid)]
    weight = dimensions.density * dimensions.depth * cell.prod()
    centred = points - points.mean(axis=0)
    body = dimensions.body()
    assert body.mass == pytest.approx(weight * len(points), rel=3e-3)
    xx, yy, xy = (weight * float(np.sum(a * b)) for a, b in ((centred[:, 0],) * 2, (centred[:, 1],) * 2, centred.T))
    along = body.mass * dimensions.depth**2 / 12.0
    expected = [[yy + along, -xy, 0.0], [-xy, xx + along, 0.0], [0.0, 0.0, xx + yy]]
    np.testing.assert_allclose(body.inertia, expected, rtol=6e-3, atol=1e-3 * (xx + yy))


def test_closed_forms_of_sections():
    """Full disc m R²/2; half disc 4R/(3π) and m R² (1/2 − (4/(3π))²); right triangle with legs b, h: moments b³h/36, bh³/36."""
    r, depth, density = 5e-3, 27.6e-3, 7800.0
    body = Cylinder(r, depth, density).body()
    assert body.mass == pytest.approx(density * np.pi * r**2 * depth, rel=1e-13)
    assert np.asarray(body.inertia)[2, 2] == pytest.approx(0.5 * body.mass * r**2, rel=1e-13)
    half = HalfCylinder(r, depth, density)
    assert half.section().centroid[1] == pytest.approx(4.0 * r / (3.0 * np.pi), rel=1e-13)
    moment = half.body().mass * r**2 * (0.5 - (4.0 / (3.0 * np.pi)) ** 2)
    assert np.asarray(half.body().inertia)[2, 2] == pytest.approx(moment, rel=1e-12)
    b, h = 3.0, 2.0
    triangle = Section.bounded_by(polygon([[0.0, 0.0], [b, 0.0], [0.0, h]]))
    assert (triangle.area, *triangle.centroid) == pytest.approx((b * h / 2.0, b / 3.0, h / 3.0))
    assert (triangle.xx, triangle.yy, triangle.xy) == pytest.approx((b**3 * h / 36, b * h**3 / 36, -(b**2) * h**2 / 72))


def test_a_rounded_hull_of_three_circles():
    """Area of the hull of three equal circles: the triangle, a strip along its sides, and one disc."""
    circles = [((0.0, 0.0), 0.3), ((4.0, 0.0), 0.3), ((0.0, 3.0), 0.3)]
    assert Section.bounded_by(rounded_hull(circles)).area == pytest.approx(6.0 + 12.0 * 0.3 + np.pi * 0.09, rel=1e-13)
    with pytest.raises(InputError, match="must not lie inside each other"):
        rounded_hull([((0.0, 0.0), 3.0), ((1.0, 0.0), 0.5)])


def test_flat_cylinder_from_its_dimensions():
    damper = FlatCylinder().beside_blade("damper_right", PLACE, 1, 45.0, "right")
    flat, line = np.asarray(damper.surface("flat").points), np.asarray(damper.surface("cylinder").points)
    np.testing.assert_allclose(flat[-1], PLACE)
    np.testing.assert_allclose(flat[:4].mean(axis=0), PLACE, atol=1e-15)
    np.testing.assert_allclose(np.ptp(flat, axis=0), [8e-3, 8e-3, 40e-3], rtol=1e-9)
    np.testing.assert_allclose(line[1] - PLACE, [16e-3, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(damper.body.centre - PLACE, [8e-3, 0.0, 0.0], atol=1e-15)
    names = [c.name for c in all_contacts(damper)]
    assert names == [f"right flat {i}" for i in range(1, 6)] + [f"right cylinder {i}" for i in range(1, 4)]


def test_left_damper_is_the_mirror_image():
    mirror = np.diag([-1.0, 1.0, 1.0])
    right = FlatCylinder().beside_blade("r", PLACE, 1, 45.0)
    left = FlatCylinder().beside_blade("l", mirror @ PLACE, -1, 45.0)
    for one, other in zip(left.surfaces, right.surfaces, strict=True):
        np.testing.assert_allclose(np.asarray(one.points), np.asarray(other.points) @ mirror, atol=1e-15)
        np.testing.assert_allclose(np.asarray(one.frame), np.asarray(other.frame) @ mirror, atol=1e-15)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [({"mass": 0.0}, "mass must be positive"), ({"left_angle": 90.0}, "must lie in"), ({"depth": -1.0}, "depth must be")],
)
def test_impossible_dimensions_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        FlatCylinder(**wrong)


def test_faults_of_dampers_say_what_is_known():
    damper = FlatCylinder().beside_blade("d", PLACE, 1, 45.0)
    with pytest.raises(InputError, match=r"no contact surface 'flt'. Did you mean 'flat'"):
        damper.surface("flt")
    with pytest.raises(InputError, match="must be one, or 5, one per point"):
        damper.contacts("flat", lambda share: Macroslip(1.0, 0.5, 1.0), [ground, ground])
    with pytest.raises(InputError, match="must be positive with sum 1"):
        ContactSurface("line", [[0.0, 0.0, 0.0]], np.eye(3), [0.5])
    with pytest.raises(InputError, match="side must be 1, or -1"):
        FlatCylinder().damper("d", PLACE, 0, 45.0)


@pytest.mark.parametrize("lines", [1, 3])
def test_a_face_of_a_wedge_touches_along_the_middles_of_equal_strips(lines):
    """From the low corner of the face to the high one, through the mass centre of the section as origin."""
    wedge = Wedge(left_angle=40.0, right_angle=55.0, lines=lines)
    corners = wedge.corners() - wedge.section().centroid
    for touch, low, high in ((wedge.left(), corners[0], corners[3]), (wedge.right(), corners[1], corners[2])):
        places = np.unique(np.asarray(touch.points)[:, :2].round(12), axis=0)
        strips = [0.5 * (a + b) for a, b in itertools.pairwise(np.linspace(low, high, lines + 1))]
        np.testing.assert_allclose(sorted(places.tolist()), sorted(np.round(strips, 12).tolist()), atol=1e-11)


def test_a_line_is_three_points_in_the_middles_of_its_thirds():
    edges = np.linspace(-0.5, 0.5, 4) * 0.03
    points = np.array(Touch.on_lines(45.0, [(1.0, 2.0)], 0.03).points)
    np.testing.assert_allclose(points, [(1.0, 2.0, z) for z in 0.5 * (edges[1:] + edges[:-1])], atol=1e-15)


def test_gaps_of_a_microslip_line_are_even_and_reach_twice_their_mean():
    """Of g N/kn in the mean, N the pull shared over the lines: five elements from 0 to 2 g N/kn."""
    rig = BetweenPlatforms.of_law("microslip", Cylinder().damper(pull=100.0), kt=1e7, kn=2e7, mu=0.3, gaps=0.4)
    for law in rig.laws:
        np.testing.assert_allclose(law.gaps, np.linspace(0.0, 2.0, 5) * 0.4 * 50.0 / 2e7, rtol=1e-12)


def test_a_section_so_flat_that_it_has_no_area_is_refused():
    """Feet 1e14 m apart: the circles of 4 mm between them are a line to rounding."""
    with pytest.raises(InputError, match=r"The section of a damper must have a width and a height, but is '.* m by .* m'"):
        hull_of([((0.0, 0.0), 4e-3), ((1e14, 2e14), 4e-3)])
