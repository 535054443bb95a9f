"""Surfaces of meshes: areas, normals and interpolation in closed form, and contacts that add up to the whole law."""

import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
from each import each
from hypothesis import given, settings
from hypothesis import strategies as st

import stickslip as ss
from stickslip.support.checks import InputError

UNTURNED = np.eye(3)
TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]


def structure_of(points, name="pad"):
    """Free nodes of 1 kg each at points, as one set."""
    nodes = {f"{name}/{k}": tuple(map(float, point)) for k, point in enumerate(points, start=1)}
    dofs = tuple(f"{node}.{axis}" for node in nodes for axis in "xyz")
    return ss.Structure(np.eye(len(dofs)), 1e6 * np.eye(len(dofs)), dofs, nodes=nodes, sets={name: tuple(nodes)})


def structure_of_many(points):
    """The same for a surface alone, without matrices."""
    nodes = {f"pad/{k}": tuple(map(float, point)) for k, point in enumerate(points, start=1)}
    dofs = tuple(f"{node}.{axis}" for node in nodes for axis in "xyz")
    return SimpleNamespace(dofs=dofs, nodes=nodes, sets={"pad": tuple(nodes)})


def grid(x, y, z=lambda x, y: 0.0 * x):
    X, Y = (part.ravel() for part in np.meshgrid(x, y, indexing="ij"))
    return np.stack([X, Y, z(X, Y)], axis=1)


def surface(points, towards=None, line=None):
    return ss.NodeSurface.of(structure_of(points), "pad", towards, line=line)


@settings(deadline=None)
@given(st.integers(0, 1000), st.integers(2, 6), st.integers(2, 6))
def test_areas_of_a_graded_grid_are_those_of_its_cells(seed, columns, rows):
    """Half the way to each neighbour, whatever rounding makes of the squares' diagonals: the grid lies askew in space."""
    rng = np.random.default_rng(seed)
    x, y = (np.cumsum(rng.uniform(0.5, 1.5, count)) for count in (columns, rows))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    found = surface(1e-3 * grid(x, y) @ turn.T + rng.normal(size=3), turn[:, 2])
    widths, heights = (np.diff(np.concatenate([[a[0]], 0.5 * (a[1:] + a[:-1]), [a[-1]]])) for a in (x, y))
    expected = 1e-6 * np.outer(widths, heights).ravel()
    np.testing.assert_allclose(found.weights * found.area, expected, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(found.normals, np.tile(turn[:, 2], (columns * rows, 1)), atol=1e-9)


def test_normals_and_area_of_a_cylinder():
    """A sector of ±40° of a cylinder of radius 20 mm, 61 x 12 nodes: area of the facets, normals along the radius."""
    angle, depth = np.linspace(-40.0, 40.0, 61) * np.pi / 180.0, np.linspace(0.0, 10e-3, 12)
    A, Z = (part.ravel() for part in np.meshgrid(angle, depth, indexing="ij"))
    radial = np.stack([np.sin(A), np.cos(A), np.zeros_like(A)], axis=1)
    found = surface(20e-3 * radial + np.stack([0 * Z, 0 * Z, Z], axis=1), (0.0, 1.0, 0.0))
    assert found.area == pytest.approx(20e-3 * 80.0 * np.pi / 180.0 * 10e-3, rel=5e-3)
    inside = np.abs(A) < np.radians(39.0)
    assert np.min(np.sum(found.normals * radial, axis=1)[inside]) > 1.0 - 1e-5


def test_normals_point_to_the_body_opposite():
    flat = surface(grid([0.0, 1.0, 2.0], [0.0, 1.0]))
    above, below = (flat.facing((1.0, 0.5, z)) for z in (0.3, -0.3))
    np.testing.assert_allclose(above.normals, np.tile([0.0, 0.0, 1.0], (6, 1)), atol=1e-12)
    np.testing.assert_allclose(below.normals, -above.normals, atol=1e-12)


def test_a_direction_to_the_outside_may_have_any_length():
    for size in (1e-250, 1.0, 1e30):
        for points, line in ((grid([0.0, 1.0, 2.0], [0.0, 1.0]), False), (grid([0.0, 1.0, 2.0], [0.0]), True)):
            found = surface(points, (0.0, 0.0, -size), line=line)
            np.testing.assert_allclose(found.normals, np.tile([0.0, 0.0, -1.0], (len(points), 1)), atol=1e-12)


def test_what_touches_a_surface_does_not_say_on_which_side_it_lies():
    """A point in the surface, to rounding, whatever the rotation: refused, not guessed."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        flat = surface(grid([0.0, 1.0, 2.0], [0.0, 1.0]) @ turn.T)
        with pytest.raises(InputError, match="must be given, since what lies opposite touches it"):
            flat.facing(flat.points.mean(axis=0))


@given(st.integers(0, 10_000), st.floats(-18.0, -7.0))
@settings(deadline=None, max_examples=150)
def test_rounding_of_coordinates_decides_nothing(seed, digits):
    """Straight edges that are straight but for rounding, or for the digits of a file: Delaunay triangles without an area stand
    along them. Places between nodes, areas and holes are as without.
    """
    rng = np.random.default_rng(seed)
    x, y = (np.cumsum(rng.uniform(0.6, 1.4, count)) for count in rng.integers(2, 9, 2))
    turn, origin = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.normal(size=3)
    exact = grid(x, y)
    noise = 10.0**digits * rng.normal(size=exact.shape)
    found = surface(1e-3 * (exact + noise) @ turn.T + origin, turn[:, 2])
    assert not found.has_holes
    assert found.area == pytest.approx(1e-6 * np.ptp(x) * np.ptp(y), rel=1e-5)
    places = dict(zip(found.nodes, exact, strict=True))
    for _ in range(5):
        asked = np.array([rng.uniform(x[0], x[-1]), rng.uniform(y[0], y[-1]), 0.0])
        motion = found.at(1e-3 * turn @ (asked + np.array([0.0, 0.0, 0.1])) + origin)((1.0, 0.0, 0.0))
        met = sum(share * places[dof.rpartition(".")[0]] for dof, share in motion.items())
        np.testing.assert_allclose(met, asked, atol=1e-5)


def test_holes_are_noticed():
    full = grid(np.arange(9.0), np.arange(7.0))
    recess = full[~((full[:, 0] > 3.5) & (full[:, 1] > 2.5))]
    assert not surface(full).has_holes
    assert surface(recess).has_holes
    assert surface(np.vstack([full, full + np.array([20.0, 0.0, 0.0])])).has_holes


@pytest.mark.nightly
def test_a_rectangular_hole_is_cut_out():
    """A hole of 10 x 6 cells in 40 x 30: its area but half a cell from each corner; nodes at its edge keep their half outside."""
    full = grid(np.arange(41.0), np.arange(31.0))
    x, y, _ = full.T
    found = surface(1e-3 * full[~((x > 10.0) & (x < 20.0) & (y > 10.0) & (y < 16.0))] @ TURN.T, TURN[:, 2])
    assert found.area == pytest.approx(1e-6 * (1200.0 - 60.0 + 4 * 0.5), rel=1e-9)
    areas = dict(zip(map(tuple, np.round(1e3 * found.points @ TURN).astype(int)), 1e6 * found.area * found.weights, strict=True))
    assert [areas[15, 10, 0], areas[10, 13, 0], areas[15, 9, 0], areas[20, 30, 0]] == pytest.approx([0.5, 0.5, 1.0, 0.5])
    assert found.at(1e-3 * TURN @ [15.0, 13.0, 0.1]) is None
    assert found.at(1e-3 * TURN @ [15.0, 9.5, 0.1]) is not None


@pytest.mark.slow
def test_a_round_hole_is_cut_out():
    """A plate with a hole of 48 nodes on a circle: the area of the plate less that of the polygon, whatever the mesh around."""
    full = grid(np.linspace(-20.0, 20.0, 41), np.linspace(-15.0, 15.0, 31))
    turn = 2.0 * np.pi * np.arange(48) / 48
    circle = 8.0 * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    found = surface(np.vstack([full[np.hypot(full[:, 0], full[:, 1]) > 8.6], circle]))
    assert found.area == pytest.approx(1200.0 - 24.0 * 64.0 * np.sin(2.0 * np.pi / 48), rel=1e-9)
    assert found.weights.min() > 0.0
    assert found.at((0.0, 0.0, 0.1)) is None


def test_areas_of_two_pads_in_one_set_are_theirs():
    pad = grid(np.arange(9.0), np.arange(7.0))
    both = surface(np.vstack([pad, pad + np.array([20.0, 0.0, 0.0])]))
    assert both.area == pytest.approx(96.0, rel=1e-9)
    np.testing.assert_allclose(both.weights[:63], 0.5 * surface(pad).weights, rtol=1e-9)


def test_a_mesh_graded_ten_times_has_no_holes():
    steps = np.cumsum(1.3 ** np.arange(10.0))
    graded = surface(grid(np.concatenate([[0.0], steps]), np.arange(5.0)))
    assert not graded.has_holes
    assert graded.area == pytest.approx(4.0 * steps[-1])


@pytest.mark.nightly
def test_memory_grows_as_the_nodes_do():
    """3000 nodes: a table of one node against all others would take 72 MB."""
    structure = structure_of_many(grid(np.arange(60.0), np.arange(50.0)))
    tracemalloc.start()
    try:
        found = ss.NodeSurface.of(structure, "pad", (0.0, 0.0, 1.0))
        assert found.at((30.2, 20.7, 0.5)) is not None
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()
    assert found.area == pytest.approx(59.0 * 49.0)


def test_a_line_beside_a_body_faces_it():
    line = structure_of([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    found = ss.NodeSurface.of(line, "pad", opposite=(5.0, 0.0, -2.0), line=True)
    np.testing.assert_allclose(found.normals, np.tile([0.0, 0.0, -1.0], (2, 1)), atol=1e-12)


def test_interpolation_is_exact_for_linear_motion_and_ends_at_the_edge():
    rng = np.random.default_rng(4)
    points = np.vstack([grid([0.0, 1.0], [0.0, 1.0]), np.hstack([rng.uniform(0.0, 1.0, (20, 2)), np.zeros((20, 1))])])
    found = surface(points @ TURN.T)
    gradient = rng.normal(size=3)
    for place in rng.uniform(0.0, 1.0, (10, 2)):
        motion = found.at(TURN @ [*place, 0.1])
        moved = {node: gradient @ point for node, point in zip(found.nodes, points @ TURN.T, strict=True)}
        value = sum(share * moved[dof.rpartition(".")[0]] for dof, share in motion((1.0, 0.0, 0.0)).items())
        assert value == pytest.approx(gradient @ (TURN @ [*place, 0.0]), rel=1e-9, abs=1e-12)
    assert found.at(TURN @ [1.02, 0.5, 0.0]) is None
    assert found.at(TURN @ [1.005, 0.5, 0.0]) is not None
    assert set(found.at(points[3] @ TURN.T)((0.0, 1.0, 0.0))) == {f"{found.nodes[3]}.y"}


def test_a_line_of_nodes_takes_its_normal_from_outside():
    line = surface([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (3.0, 0.0, 0.0)], (0.0, 0.0, 2.0), line=True)
    np.testing.assert_allclose(line.weights, [1 / 6, 1 / 2, 1 / 3])
    np.testing.assert_allclose(line.normals, np.tile([0.0, 0.0, 1.0], (3, 1)))
    assert line.area == 0.0
    single = surface([(1.0, 2.0, 3.0)], (0.0, 1.0, 0.0))
    assert (single.weights.tolist(), single.normals.tolist()) == ([1.0], [[0.0, 1.0, 0.0]])


def arc(turns):
    """Points of a circle of radius 7 mm at turns in degrees, scattered in their order, and unit directions from its centre."""
    turns = np.random.default_rng(1).permutation(np.radians(turns))
    away = np.stack([np.cos(turns), np.sin(turns), 0.0 * turns], axis=1)
    return 7e-3 * away, away, np.degrees(turns)


@each("turns", [[0.0, 10.0, 20.0, 30.0, 40.0], [0.0, 20.0, 30.0, 60.0, 100.0, 130.0, 220.0]])
def test_nodes_of_an_arc_share_its_length_and_face_its_centre(turns):
    """A share is half the chords to both neighbours, 2R sin(α/2) each; the normal is radial, at the ends too."""
    points, away, order = arc(turns)
    steps = np.sin(np.radians(np.diff(turns)) / 2.0)
    expected = dict(zip(turns, 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps)) / steps.sum(), strict=True))
    found = ss.NodeSurface.of(structure_of(points @ TURN.T), "pad", opposite=(0.0, 0.0, 0.0), line=True)
    np.testing.assert_allclose(found.weights, [expected[round(turn, 9)] for turn in order], rtol=1e-12)
    np.testing.assert_allclose(found.normals, -away @ TURN.T, atol=1e-12)
    across = surface(points @ TURN.T, TURN[:, 2], line=True)
    np.testing.assert_allclose(across.normals, np.tile(TURN[:, 2], (len(turns), 1)), atol=1e-12)
    assert (found.area, found.has_holes, found.facing((0.0, 0.0, 0.0)).area) == (0.0, False, 0.0)
    loads = [contact.law.preload for contact in ss.surface_contacts("arc", LAW, found)]
    assert loads == pytest.approx(12.0 * found.weights)


def test_patches_of_a_line_follow_it():
    """A hairpin: the halves of its length are its legs, not the ends of both."""
    x = np.arange(0.0, 8.1, 0.5)
    hairpin = np.vstack(
        [np.stack([x, 0.0 * x, 0.0 * x], axis=1), [(8.0, 0.5, 0.0)], np.stack([x[::-1], 1.0 + 0.0 * x, 0.0 * x], axis=1)]
    )
    first, second = surface(hairpin, (0.0, 0.0, 1.0), line=True).patches(2)
    assert [*first, *second] == list(range(len(hairpin)))
    assert abs(len(first) - len(second)) == 1


def test_nodes_of_a_ring_share_it_equally_and_patches_follow_it():
    points, away, _ = arc(np.arange(0.0, 360.0, 30.0))
    ring = ss.NodeSurface.of(structure_of(points), "pad", opposite=(0.0, 0.0, 0.0), line=True)
    np.testing.assert_allclose(ring.weights, np.full(12, 1.0 / 12.0), rtol=1e-12)
    np.testing.assert_allclose(ring.normals, -away, atol=1e-12)
    assert ring.kind == "a closed line"
    open_one = surface(arc(np.arange(0.0, 320.0, 30.0))[0], (0.0, 0.0, 1.0), line=True)
    assert (len(open_one.nodes), open_one.kind) == (11, "a line")
    assert surface([(0.0, 0.0, 0.0)], (0.0, 0.0, 1.0)).kind == "a node"
    for members in ring.patches(4):
        assert np.ptp(np.sort(np.linalg.norm(points[members] - points[members].mean(axis=0), axis=1))) < 5e-3
        assert len(members) == 3
    assert ring.mean_normal is None
    for contact, normal in zip(ss.surface_contacts("ring", LAW, ring), ring.normals, strict=True):
        t1 = np.array([contact.tangential[0].get(f"pad/{contact.name.split()[1]}.{axis}", 0.0) for axis in "xyz"])
        np.testing.assert_allclose([t1 @ normal, t1[2]], 0.0, atol=1e-12)  # along the ring, whose normals lie in its plane
    with pytest.raises(InputError, match="to have places between them"):
        ring.at((0.0, 0.0, 0.0))


BENT = {
    "straight": grid(np.arange(4.0), [0.0]),
    "two nodes": grid([0.0, 1.0], [0.0]),
    "straight in few digits": np.round(grid(np.arange(9.0), [0.0]) @ TURN.T, 5),
    "shallow arc": arc(np.linspace(0.0, 2.0, 40))[0],
    "five of an arc": arc(np.linspace(0.0, 40.0, 5))[0],
    "half a circle": arc(np.linspace(0.0, 180.0, 9))[0],
    "most of a circle": arc(np.linspace(0.0, 330.0, 9))[0],
    "a circle": arc(np.arange(0.0, 360.0, 15.0))[0],
    "a corner": np.vstack([grid(np.arange(5.0), [0.0]), grid([4.0], np.arange(1.0, 5.0))]),
    "an obtuse corner": grid(np.linspace(-1.0, 1.0, 9), [0.0], lambda x, y: np.abs(x)) @ TURN.T,
}
COVERING = {
    "a face": grid([0.0, 1.0], [0.0, 1.0]),
    "a strip of long elements": grid(np.arange(9.0), [0.0, 30.0]),
    "a strip of flat elements": grid(np.arange(9.0), [0.0, 0.05]),
    "a sheared strip": grid(np.arange(9.0), [0.0, 5.0]) + np.where(np.arange(18) % 2, 0.4, 0.0)[:, None] * [1.0, 0.0, 0.0],
    "rows sheared by 45 degrees": (lambda p: p + np.outer(p[:, 1], [1.0, 0.0, 0.0]))(grid(5.0 * np.arange(9), np.arange(3.0))),
    "a tapered strip": np.array([(s * (1.0 + 0.09 * x), x, 0.0) for x in range(9) for s in (-1.0, 1.0)]),
    "two rings": np.vstack([arc(np.arange(0.0, 360.0, 15.0))[0] * f for f in (1.0, 1.5)]),
    "an acute triangle": np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 0.7, 0.0)]),
}


@each("name", BENT)
def test_a_line_is_no_surface_unless_it_is_declared_one(name):
    """Whatever its scale and the way it is turned; five nodes of an arc had an area and shares that fitted none of it."""
    rng = np.random.default_rng(2)
    for scale in (1e-6, 1.0, 1e4):
        points = scale * BENT[name] @ np.linalg.qr(rng.normal(size=(3, 3)))[0].T
        with pytest.raises(
            InputError, match=r"Surface 'pad' must cover an area, but is 'a line of \d+ nodes'. Add `line = true`"
        ):
            surface(points, (1.0, 2.0, 3.0))
        assert surface(points, rng.normal(size=3), line=True).area == 0.0


def test_a_force_along_a_bent_line_shares_its_length_where_it_is_declared():
    """A corner of 5 and 4 nodes: eight steps of 1, half of one to either end."""
    bent = structure_of(BENT["a corner"])
    with pytest.raises(InputError, match="must cover an area"):
        ss.mean_motion(bent, "pad", (0.0, 0.0, 1.0))
    shares = ss.mean_motion(bent, "pad", (0.0, 0.0, 1.0), line=True)
    assert list(shares.values()) == pytest.approx([1 / 16, *[1 / 8] * 7, 1 / 16])
    assert surface(BENT["a corner"], line=False).area == pytest.approx(8.0)


@each("name", COVERING)
def test_nodes_of_elements_are_a_surface_however_they_are_sheared(name):
    rng = np.random.default_rng(2)
    for scale in (1e-6, 1.0, 1e4):
        assert surface(scale * COVERING[name] @ np.linalg.qr(rng.normal(size=(3, 3)))[0].T).area > 0.0


def test_a_line_that_branches_is_refused():
    with pytest.raises(InputError, match="Line 'pad' must be one line of nodes, but is 'branched'"):
        surface(np.vstack([grid(np.arange(5.0), [0.0]), grid([2.0], [1.0, 2.0])]), (0.0, 0.0, 1.0), line=True)


LAW = ss.Macroslip(3e6, 0.4, 6e6, preload=12.0)


def test_contacts_share_the_law_and_resist_as_the_whole_surface():
    """Stuck and moved alike, all nodes together resist as the whole law; turned about the middle, as the area says."""
    structure = structure_of(grid(np.linspace(0.0, 4e-3, 9), np.linspace(0.0, 2e-3, 5)))
    pad = ss.NodeSurface.of(structure, "pad", (0.0, 0.0, 1.0))
    contacts = ss.surface_contacts("pad", LAW, pad, tangent=(1.0, 0.0, 0.0), balanced=True)
    problem = ss.Problem(structure, contacts, (ss.Force("pad/1.x", 1.0),), ("pad/1.x",))
    assert [contact.name for contact in contacts[:2]] == ["pad 1", "pad 2"]
    assert all(contact.balanced for contact in contacts)
    assert sum(contact.law.preload for contact in contacts) == pytest.approx(12.0)
    added = problem.stuck_stiffness - structure.K
    for axis, stiffness in (("x", 3e6), ("y", 3e6), ("z", 6e6)):
        moved = structure.row({f"{node}.{axis}": 1.0 for node in pad.nodes})
        assert moved @ added @ moved == pytest.approx(stiffness, rel=1e-9)
    turned = structure.row({f"{node}.z": point[0] - 2e-3 for node, point in zip(pad.nodes, pad.points, strict=True)})
    cells = np.sum(pad.weights * (pad.points[:, 0] - 2e-3) ** 2)
    assert turned @ added @ turned == pytest.approx(6e6 * cells, rel=1e-9)
    assert cells == pytest.approx((4e-3) ** 2 / 12.0, rel=0.04)


def test_a_body_opposite_moves_as_one():
    """A rigid motion of surface and body together moves no contact: three translations, three rotations."""
    body = ss.RigidBody(0.02, np.diag([1e-6, 2e-6, 2.5e-6]), TURN @ (1e-3, 2e-3, 5e-3), node="damper")
    points = grid(np.linspace(0.0, 4e-3, 4), np.linspace(0.0, 2e-3, 3)) @ TURN.T
    blade = structure_of(points)
    structure = ss.assemble({"": blade, "wedge": body.structure()})
    pad = ss.NodeSurface.of(structure, "pad").facing(body.centre)
    contacts = ss.surface_contacts("left", LAW, pad, lambda point: body.at(point, "wedge"))
    directions = [direction for contact in contacts for direction in contact.directions]
    assert structure.dofs[-1] == "wedge/damper.rz"
    for axis in np.eye(3):
        for shift, turn in ((axis, np.zeros(3)), (np.zeros(3), axis)):
            motion = {f"wedge/damper.{name}": v for name, v in zip("xyz", shift + np.cross(turn, body.centre), strict=True)}
            motion |= {f"wedge/damper.r{name}": v for name, v in zip("xyz", turn, strict=True)}
            for node, point in zip(pad.nodes, pad.points, strict=True):
                motion |= {f"{node}.{name}": v for name, v in zip("xyz", shift + np.cross(turn, point), strict=True)}
            moved = [sum(motion[dof] * c for dof, c in direction.items()) for direction in directions]
            np.testing.assert_allclose(moved, 0.0, atol=1e-12)


def test_surfaces_of_two_meshes_that_do_not_match():
    """Two pads with other nodes: a common linear motion moves no contact; nodes beyond the edge get none."""
    lower = structure_of(grid(np.linspace(0.0, 4e-3, 5), np.linspace(0.0, 2e-3, 3)), "lower")
    upper = structure_of(grid(np.linspace(1e-3, 6e-3, 4), np.linspace(0.2e-3, 1.8e-3, 4), lambda x, y: 0 * x + 1e-4), "upper")
    structure = ss.assemble({"a": lower, "b": upper})
    pads = [ss.NodeSurface.of(structure, name, (0.0, 0.0, z)) for name, z in (("b/upper", -1.0), ("a/lower", 1.0))]
    contacts = ss.surface_contacts("joint", LAW, *pads)
    beyond = np.sum(pads[0].points[:, 0] > 4e-3)
    assert 0 < beyond < len(pads[0].nodes)
    assert len(contacts) == len(pads[0].nodes) - beyond
    slope = {node: 1.0 + 50.0 * x - 20.0 * y for pad in pads for node, (x, y, _) in zip(pad.nodes, pad.points, strict=True)}
    for contact in contacts:
        for direction in contact.directions:
            moved = sum(c * slope[dof.rpartition(".")[0]] for dof, c in direction.items())
            assert moved == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ss.NodeSurface.of(structure_of(grid([0, 1], [0, 1])), "pads"), "'pads' does not exist. Did you mean 'pad'"),
        (lambda: surface([(0, 0, 0), (1, 0, 0)], line=True), "a line or one node, has no normal of its own"),
        (lambda: surface([(0, 0, 0), (1, 0, 0)], (1, 0, 0), True), "must not be zero or lie in it"),
        (lambda: surface(grid([0, 1], [0, 1]), (1.0, 0.0, 0.0)), "must not be zero or lie in it"),
        (lambda: surface(grid([0, 1], [0, 1]), (0.0, 0.0, 0.0)), "must not be zero or lie in it"),
        (lambda: surface([(0, 0, 0), (1, 0, 0), (0, 0, 0)], (0, 0, 1)), "must have different places, but is 'pad/3"),
        (
            lambda: ss.NodeSurface.of(ss.Structure(np.eye(1), np.eye(1), ("a.x",), sets={"p": ()}), "p"),
            "must have nodes that can move",
        ),
        (lambda: ss.surface_contacts("p", LAW, surface(grid([0, 1], [0, 1])), 3.0), "against must be a NodeSurface"),
        (lambda: ss.assemble({"a": ss.RigidBody(1.0, np.eye(3))}), "Body 'a' must be a Structure"),
        (lambda: structure_of([(0, 0, 0)]).shifted((1.0, 2.0)), "by must"),
        (lambda: surface(grid(np.linspace(-1, 1, 21), [0, 1], lambda x, y: 40.0 * x**2)), "must be flat or gently curved"),
        (
            lambda: ss.surface_contacts("p", LAW, surface(grid([0, 1], [0, 1]), (0, 0, 1)), tangent=(0, 0, 1)),
            "must be a direction that is not the normal",
        ),
        (lambda: ss.surface_contacts("p", 3.0, surface(grid([0, 1], [0, 1]))), "law must be a Law"),
        (lambda: ss.surface_contacts("p", LAW, "pad"), "surface must be a NodeSurface"),
        (
            lambda: ss.surface_contacts("p", LAW, surface(grid([0, 1], [0, 1])), surface(grid([5, 6], [0, 1]))),
            "none of its nodes does",
        ),
        (
            lambda: ss.NodeSurface.of(ss.Structure(np.eye(1), np.eye(1), ("a.x",), sets={"p": ("a",)}), "p"),
            "must have coordinates",
        ),
        (
            lambda: ss.NodeSurface.of(
                ss.Structure(np.eye(1), np.eye(1), ("a.x",), sets={"p": ("a",)}, nodes={"a": (0.0, 0.0, 0.0)}), "p"
            ),
            "a without y",
        ),
    ],
)
def test_wrong_input(make, words):
    with pytest.raises(InputError, match=words):
        make()


def facing_surfaces(shape, turn=UNTURNED):
    """Two grids of nodes that face each other along z, the upper one at `shape` above the lower one, turned in space."""
    x, y = np.linspace(0.0, 4e-3, 5), np.linspace(0.0, 3e-3, 4)
    low, up = (structure_of(points @ turn.T, name) for points, name in ((grid(x, y), "low"), (grid(x, y, shape), "up")))
    structure = ss.assemble({"a": low, "b": up})
    return ss.NodeSurface.of(structure, "a/low", turn[:, 2]), ss.NodeSurface.of(structure, "b/up", -turn[:, 2])


@pytest.mark.parametrize("law", [ss.Gap(kn=1e6, gap=2e-6), ss.Macroslip(kt=1e6, mu=0.3, kn=1e6, gap=2e-6)])
def test_gaps_of_the_mesh_add_to_that_of_the_law(law):
    """The upper surface is tilted, its gap from -1 to 5 um; the force under a rigid approach is that of all gaps together."""
    low, up = facing_surfaces(lambda x, y: -1e-6 + 1.5e-3 * x)
    contacts = ss.surface_contacts("s", law, low, up, mesh_gap=True)
    expected = 2e-6 - 1e-6 + 1.5e-3 * low.points[:, 0]
    np.testing.assert_allclose(
        [contact.law.gap for contact in contacts], expected, rtol=1e-4
    )  # the foot on a surface askew by 1.5e-3
    closing = sum(float(contact.elements.normal.forces(4e-6).sum()) for contact in contacts)
    assert closing == pytest.approx(1e6 * np.sum(low.weights * np.maximum(4e-6 - expected, 0.0)), rel=1e-4)


def test_gaps_of_the_mesh_do_not_depend_on_where_it_lies_in_space():
    gaps = []
    for turn in (UNTURNED, TURN):
        low, up = facing_surfaces(lambda x, y: 1e-6 + 1.5e-3 * x + 1e-3 * y, turn)
        gaps.append([contact.law.gap for contact in ss.surface_contacts("s", ss.Gap(kn=1e6), low, up, mesh_gap=True)])
    np.testing.assert_allclose(gaps[1], gaps[0], atol=1e-12)


def test_gaps_of_the_mesh_need_a_mesh_opposite_and_a_law_with_a_gap():
    low, up = facing_surfaces(lambda x, y: 1e-6 + 0.0 * x)
    array = ss.MicroslipArray((1e6,), 0.3, (1e6,), (0.0,))
    for law, against in ((ss.Gap(kn=1e6), None), (array, up), (ss.Macroslip(kt=1e6, mu=0.3, normal_load=1.0), up)):
        with pytest.raises(InputError, match="mesh_gap must go with a surface opposite and a law that has a gap and kn"):
            ss.surface_contacts("s", law, low, against, mesh_gap=True)


def test_a_mean_motion_spreads_a_force_by_area_and_reports_the_mean():
    """Rigid translation moves the mean as itself; shares are those of contacts."""
    points = grid([0.0, 1.0, 3.0], [0.0, 2.0, 3.0])
    structure, along = structure_of(points), np.array([1.0, -2.0, 0.5])
    found = ss.mean_motion(structure, "pad", along)
    rows = {dof: k for k, dof in enumerate(structure.dofs)}
    coefficients = np.zeros(len(rows))
    for dof, coefficient in found.items():
        coefficients[rows[dof]] = coefficient
    np.testing.assert_allclose(coefficients.reshape(-1, 3).sum(axis=0), along, rtol=1e-12)
    np.testing.assert_allclose(coefficients.reshape(-1, 3)[:, 0], surface(points, (0.0, 0.0, 1.0)).weights, rtol=1e-12)


def test_a_mean_motion_of_a_line_and_of_one_node():
    line = structure_of([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    assert ss.mean_motion(line, "pad", (1.0, 0.0, 0.0)) == pytest.approx({"pad/1.x": 1 / 6, "pad/2.x": 0.5, "pad/3.x": 1 / 3})
    assert ss.mean_motion(structure_of([[0.0, 0.0, 0.0]]), "pad", (0.0, 0.0, 2.0)) == {"pad/1.z": 2.0}
    with pytest.raises(InputError, match="direction must not be zero"):
        ss.mean_motion(line, "pad", (0.0, 0.0, 0.0))


def cylinder(columns=31, rows=13):
    """A sector of ±40° of a cylinder of radius 20 mm, 28 x 10 mm, its nodes closer together at one edge."""
    angle = (np.linspace(0.0, 1.0, columns) ** 1.3 * 80.0 - 40.0) * np.pi / 180.0
    points = grid(angle, np.linspace(0.0, 10e-3, rows))
    return np.stack([20e-3 * np.sin(points[:, 0]), 20e-3 * np.cos(points[:, 0]), points[:, 1]], axis=1)


@each("count", (1, 2, 5, 12, 24, 60))
def test_patches_cover_all_nodes_once_with_equal_areas_and_are_compact(count):
    """Areas differ by what a node or two carry; no node lies further from the middle than in a rectangle five times as long as
    wide."""
    found = surface(cylinder(), (0.0, 1.0, 0.0))
    patches = found.patches(count)
    assert len(patches) == count
    np.testing.assert_array_equal(np.sort(np.concatenate(patches)), np.arange(len(found.nodes)))
    areas = np.array([found.weights[members].sum() for members in patches])
    assert np.abs(areas - 1.0 / count).max() <= 1.5 * found.weights.max()
    half_diagonal = 0.5 * np.sqrt(found.area / count) * np.sqrt(5.0 + 1.0 / 5.0)
    for members in patches:
        middle = np.average(found.points[members], axis=0, weights=found.weights[members])
        assert np.linalg.norm(found.points[members] - middle, axis=1).max() <= half_diagonal


def test_a_square_grid_is_divided_into_squares():
    found = surface(grid(np.arange(8.0), np.arange(8.0)), (0.0, 0.0, 1.0))
    blocks = {tuple(8 * i + j for i in range(a, a + 4) for j in range(b, b + 4)) for a in (0, 4) for b in (0, 4)}
    assert {tuple(members.tolist()) for members in found.patches(4)} == blocks


def test_patches_do_not_depend_on_the_order_of_the_nodes():
    """Seven parts of a grid that has no middle line are other ones in a mirror."""
    points = grid(np.arange(5.0) ** 1.3, np.arange(3.0))
    found = surface(points, (0.0, 0.0, 1.0))
    for seed in range(5):
        order = np.random.default_rng(seed).permutation(len(points))
        other = surface(points[order], (0.0, 0.0, 1.0))
        assert [sorted(order[part].tolist()) for part in other.patches(7)] == [part.tolist() for part in found.patches(7)]


def wedge_on_a_pad(points=None, **more):
    """Contacts of a curved pad against a rigid body, and the structure of both."""
    body = ss.RigidBody(0.02, np.diag([1e-6, 2e-6, 2.5e-6]), (1e-3, 30e-3, 2e-3), node="damper")
    structure = ss.assemble({"": structure_of(cylinder(9, 5)), "wedge": body.structure()})
    pad = ss.NodeSurface.of(structure, "pad").facing(body.centre)
    return structure, pad, ss.surface_contacts("L", LAW, pad, lambda point: body.at(point, "wedge"), points=points, **more)


@each("count", (1, 4, 20))
def test_a_patch_moves_as_the_mean_of_its_nodes_and_its_force_acts_on_them_by_area(count):
    """w = frame Σ share_k (u_k - u_body(x_k)) for any motion; so, by virtual work, force and moment of the forces on nodes and
    body are those of the contacts at the middles of the patches. Nothing moves in a rigid motion of all."""
    structure, pad, contacts = wedge_on_a_pad(count)
    assert [contact.name for contact in contacts] == [f"L {number}" for number in range(1, count + 1)]
    rng = np.random.default_rng(count)
    place = {node: k for k, node in enumerate(pad.nodes)}
    u, shift, turn = rng.normal(size=(len(pad.nodes), 3)), rng.normal(size=3), rng.normal(size=3)
    centre = np.array([1e-3, 30e-3, 2e-3])
    q = {f"{node}.{axis}": u[k, a] for node, k in place.items() for a, axis in enumerate("xyz")}
    q |= {f"wedge/damper.{axis}": shift[a] for a, axis in enumerate("xyz")}
    q |= {f"wedge/damper.r{axis}": turn[a] for a, axis in enumerate("xyz")}
    for contact, members in zip(contacts, pad.patches(count), strict=True):
        share = pad.weights[members] / pad.weights[members].sum()
        middle = share @ pad.points[members]
        opposite = shift + np.cross(turn, middle - centre)
        normal = share @ pad.normals[members]
        normal /= np.linalg.norm(normal)
        moved = [sum(q[dof] * c for dof, c in direction.items()) for direction in contact.directions]
        relative = share @ u[members] - opposite
        assert moved[2] == pytest.approx(normal @ relative, rel=1e-9)
        assert np.linalg.norm(moved) == pytest.approx(np.linalg.norm(relative), rel=1e-9)
        assert contact.law.kt == pytest.approx(LAW.kt * pad.weights[members].sum(), rel=1e-12)
        assert contact.law.preload == pytest.approx(LAW.preload * pad.weights[members].sum(), rel=1e-12)
        rows = structure.rows(contact.directions)
        for axis in np.eye(3):
            for rigid_shift, rigid_turn in ((axis, np.zeros(3)), (np.zeros(3), axis)):
                rigid = np.zeros(structure.size)
                for node, k in place.items():
                    for a, value in zip("xyz", rigid_shift + np.cross(rigid_turn, pad.points[k]), strict=True):
                        rigid[structure.index(f"{node}.{a}")] = value
                forces = rows @ rigid
                exact = rigid_shift + np.cross(rigid_turn, middle)
                assert forces[2] == pytest.approx(normal @ exact, abs=1e-12)


def test_as_many_points_as_nodes_or_more_are_the_contacts_at_the_nodes():
    for points in (45, 46, 1000):
        assert wedge_on_a_pad(points)[2] == wedge_on_a_pad()[2]
    assert len(wedge_on_a_pad(44)[2]) == 44


def test_the_nodes_of_patches_have_the_contacts_that_they_have_alone():
    """Law, directions, start and balance of each node come back from the patches, after a change of the law too."""
    structure, _, patches = wedge_on_a_pad(7, balanced=True)
    _, _, alone = wedge_on_a_pad(balanced=True)
    problem = ss.Problem(structure, patches, (ss.Force("pad/1.x", 1.0),), ("pad/1.x",))
    softer = problem.with_contacts(lambda contact: contact.with_law(contact.law.share(0.5)))
    for found, factor in ((problem.at_nodes, 1.0), (softer.at_nodes, 0.5)):
        own = {contact.name: contact for contact in found.contacts}
        assert sorted(own) == sorted(contact.name for contact in alone)
        for contact in alone:
            same = own[contact.name]
            assert (same.tangential, same.normal, same.balanced) == (contact.tangential, contact.normal, True)
            for name in ("kt", "kn", "preload", "mu"):
                expected = getattr(contact.law, name) * (factor if name != "mu" else 1.0)
                assert getattr(same.law, name) == pytest.approx(expected, rel=1e-12)
    assert problem.at_nodes.at_nodes is not problem
    assert found.at_nodes is found


def test_gaps_of_the_mesh_are_means_over_patches():
    low, up = facing_surfaces(lambda x, y: 1e-6 + 1.5e-3 * x)
    law = ss.Gap(kn=1e6, gap=2e-6)
    alone = {contact.name: contact for contact in ss.surface_contacts("s", law, low, up, mesh_gap=True)}
    for patch in ss.surface_contacts("s", law, low, up, mesh_gap=True, points=3):
        own = [alone[node.name].law.gap for node in patch.nodes]
        assert patch.law.gap == pytest.approx(np.dot([node.share for node in patch.nodes], own), rel=1e-12)
        np.testing.assert_allclose([contact.law.gap for contact in patch.at_nodes], own, rtol=1e-12)


def test_a_mean_traction_of_a_patch_is_shared_by_its_nodes():
    _, _, patches = wedge_on_a_pad(3, start=ss.MeanTraction(2.0))
    tractions = [contact.starts[0].value for contact in patches[0].at_nodes]
    assert sum(tractions) == pytest.approx(2.0)


@each("points", (0, -1, 2.5, "a", float("nan")))
def test_a_number_of_points_is_a_whole_one_from_1(points):
    with pytest.raises(InputError, match=r"points must be (at least 1|a whole number)"):
        wedge_on_a_pad(points)
