"""Outer surfaces: closed, with the volume of the body, for every kind of cell; thinned surfaces; the recovery's rows."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.rigs.single_blade import PlatformBlade
from stickslip.model.structure.mesh_surface import (
    MeshSurface,
    boundary,
    outer_faces,
    recovery_rows,
    selection,
    thinned,
    triangulated,
)

CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0.5, 0.5, 0.5]])
FACES_OF_CUBE = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
WHOLE = {
    "hexahedron": [range(8)],
    "wedge": [(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)],
    "pyramid": [(*face[::-1], 8) for face in FACES_OF_CUBE],
    "tetrahedron": [(0, 1, 3, 4), (1, 2, 3, 6), (1, 6, 4, 5), (3, 4, 6, 7), (1, 3, 4, 6)],
}
"""The unit cube in cells of one kind."""


def volume(points, triangles):
    """By the divergence theorem; positive where all triangles are seen from outside against the clock."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def is_closed(triangles):
    """Whether every edge belongs to two triangles, once in each direction."""
    edges = np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    return len(np.unique(edges, axis=0)) == len(edges) and {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}


@pytest.mark.parametrize("kind", WHOLE)
def test_the_surface_of_a_cube_of_any_cells_is_closed_and_holds_its_volume(kind):
    triangles = triangulated(outer_faces({kind: np.array([list(cell) for cell in WHOLE[kind]])}))
    assert len(triangles) == 12
    assert is_closed(triangles)
    assert volume(CUBE, triangles) == pytest.approx(1.0, rel=1e-14)


def test_cells_of_different_kinds_share_faces_and_collapsed_ones_are_what_they_have_become():
    """Half the cube as a wedge, the other half as a hexahedron of which an edge has collapsed."""
    cells = {"wedge": np.array([(0, 1, 2, 4, 5, 6)]), "hexahedron": np.array([(0, 2, 3, 3, 4, 6, 7, 7)])}
    triangles = triangulated(outer_faces(cells))
    assert is_closed(triangles)
    assert volume(CUBE, triangles) == pytest.approx(1.0, rel=1e-14)


def test_shells_are_their_own_surface():
    cells = {"quadrilateral": np.array([(0, 1, 2, 3), (0, 1, 5, 4)]), "triangle": np.array([(4, 5, 6)])}
    assert len(triangulated(outer_faces(cells))) == 5


def test_the_surface_of_a_platform_blade_holds_its_volume():
    blade = PlatformBlade()
    points, faces, numbers = boundary(blade.mesh(), blade.clamped())
    side = blade.platform_reach * (blade.platform_height - 0.5 * blade.rise)
    exact = blade.depth * (blade.thickness * blade.length + 2.0 * side)
    assert is_closed(triangulated(faces))
    assert volume(points, triangulated(faces)) == pytest.approx(exact, rel=1e-12)
    assert np.array_equal(np.all(numbers < 0, axis=1), points[:, 1] < 1e-9)


def test_a_fine_surface_is_thinned_and_keeps_its_volume():
    """A sphere of 40 000 points: few points, all of them of the mesh, and the volume."""
    turn, rise = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 401)[:-1], np.linspace(0.0, np.pi, 102)[1:-1], indexing="ij")
    points = np.stack([np.sin(rise) * np.cos(turn), np.sin(rise) * np.sin(turn), np.cos(rise)], axis=-1).reshape(-1, 3)
    at = np.arange(points.shape[0]).reshape(turn.shape)
    next_turn = np.roll(at, -1, axis=0)
    quads = np.stack([at[:, :-1], at[:, 1:], next_turn[:, 1:], next_turn[:, :-1]], axis=-1).reshape(-1, 4)
    kept, triangles = thinned(points, triangulated(quads), 2000)
    assert 500 < len(kept) <= 2000
    assert len(np.unique(kept)) == len(kept)
    assert np.array_equal(np.unique(triangles), np.arange(len(kept)))
    assert volume(points[kept], triangles) == pytest.approx(4.0 / 3.0 * np.pi, rel=0.02)
    same, all_of_them = thinned(points, triangulated(quads), 50_000)
    assert np.array_equal(same, np.arange(len(points)))
    assert len(all_of_them) == 2 * len(quads)


def test_rows_are_those_of_the_transformation_and_zero_where_clamped():
    rng = np.random.default_rng(1)
    T, q, numbers = rng.normal(size=(7, 3)), rng.normal(size=3), np.array([[5, -1, 2], [-1, -1, -1], [0, 6, 1]])
    surface = MeshSurface(np.zeros((3, 3)), np.array([[0, 1, 2]]), recovery_rows(T, numbers), ("a.x", "b.x", "mode/1.q"))
    expected = np.where(numbers >= 0, (T @ q)[numbers], 0.0)
    np.testing.assert_allclose(surface.motion(q), expected, rtol=1e-6)
    whole = MeshSurface(np.zeros((3, 3)), np.array([[0, 1, 2]]), selection(numbers, 7), tuple(f"{k}.x" for k in range(7)))
    assert np.array_equal(whole.motion(T @ q), expected)


def test_surfaces_go_with_their_body():
    """Into assemblies under its name, and elsewhere when it is shifted."""
    blade = ss.rigs.single_blade(modes=5).structure.with_damping(None)
    (surface,) = blade.surfaces
    assert set(surface.dofs) <= set(blade.dofs)
    assert all(dof.startswith("blade/") for dof in surface.dofs)
    (moved,) = blade.shifted((0.1, 0.0, -0.2)).surfaces
    np.testing.assert_allclose(moved.points - surface.points, np.tile([0.1, 0.0, -0.2], (len(surface.points), 1)), atol=1e-15)
    pair = ss.assemble({"a": blade, "b": blade})
    assert [each.dofs[0] for each in pair.surfaces] == [f"a/{surface.dofs[0]}", f"b/{surface.dofs[0]}"]
