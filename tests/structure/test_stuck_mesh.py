"""Few coordinates of a sparse structure, against the same structure with all its rows, dense."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import linalg, sparse

from stickslip.model.structure.assembly import RigidBody, Spring, assemble
from stickslip.model.structure.matrices import ModalDamping, SparseStructure, Structure
from stickslip.model.structure.mesh_surface import MeshSurface
from stickslip.model.structure.modes import unresisted
from stickslip.model.structure.solid import box_mesh, solid
from stickslip.model.structure.stress import StressRecovery
from stickslip.model.structure.stuck_mesh import StuckMesh
from stickslip.support.checks import InputError

KT, KN, MODES_TO, FREE_TO = 4e6, 6e6, 20e3, 7e3
"""Stiffness of each node on the pad; the modes kept, Hz, of which the stuck beam has three; those without contacts."""


@cache
def beam(clamped):
    """A box of steel, 100 x 20 x 10 mm, its underside beyond 58 mm on the pad; clamped at x = 0, or held by the pad alone."""
    body = solid(box_mesh(np.linspace(0.0, 0.1, 9), np.linspace(0.0, 0.02, 3), np.linspace(0.0, 0.01, 2)))
    free = np.flatnonzero(body.points[:, 0] > (1e-9 if clamped else -1.0))
    rows = body.numbers[free].ravel()
    M, K = (sparse.csc_array(matrix)[rows][:, rows] for matrix in (body.M, body.K))
    nodes = {str(k): tuple(map(float, body.points[k])) for k in free}
    dofs = tuple(f"{name}.{axis}" for name in nodes for axis in "xyz")
    pad = tuple(name for name, (x, _, z) in nodes.items() if z < 1e-9 and x > 0.058)
    tip = max(nodes, key=lambda name: (nodes[name][0], nodes[name][2], nodes[name][1]))
    structure = SparseStructure(M, K, dofs, damping=ModalDamping(0.01), nodes=nodes, sets={"pad": pad}, kept=(f"{tip}.x",))
    return structure, pad, tip


def stuck_mesh(clamped=True, holding="xyz", modes_to=MODES_TO):
    structure, pad, tip = beam(clamped)
    B = structure.rows([{f"{node}.{axis}": 1.0} for node in pad for axis in holding])
    stiffness = np.tile([KN if axis == "z" else KT for axis in holding], len(pad))
    return StuckMesh(structure, B, stiffness, structure.rows([{f"{tip}.y": 1.0}, {f"{tip}.z": 1.0}]), modes_to, 0.35 * modes_to)


def dense(mesh):
    """M, K' and B of all rows."""
    B = mesh.B.toarray()
    return mesh.structure.M.toarray(), mesh.structure.K.toarray() + B.T @ (mesh.stiffness[:, None] * B), B


def few(mesh, forces):
    """The structure on few coordinates, and B there; K, K' and M of it in full."""
    coordinates = mesh.coordinates(forces)
    structure = mesh.structure_on(coordinates, tuple(sorted({mesh.structure.dofs[row] for row in mesh.B.indices})))
    return structure, mesh.B @ coordinates.shapes


@pytest.mark.parametrize("clamped", [True, False])
def test_modes_are_those_of_all_rows(clamped):
    mesh = stuck_mesh(clamped)
    M, K, _ = dense(mesh)
    squares = linalg.eigvalsh(K, M)
    below = int(np.sum(squares <= (2.0 * np.pi * MODES_TO) ** 2))
    assert mesh.modes[0] == pytest.approx(squares[:below], rel=1e-9)
    structure, B = few(mesh, np.zeros((mesh.B.shape[0], 0)))
    found = linalg.eigvalsh(structure.K + B.T @ (mesh.stiffness[:, None] * B), structure.M)
    assert found[:below] == pytest.approx(squares[:below], rel=1e-9)


@pytest.mark.parametrize("clamped", [True, False])
def test_with_all_contact_forces_contacts_see_the_structure_with_all_rows(clamped):
    """Released by nine tenths, and dynamic far below the modes left out: their mass counts by the fourth power."""
    mesh = stuck_mesh(clamped)
    M, K, B = dense(mesh)
    structure, rows = few(mesh, np.eye(B.shape[0]))
    assert structure.size < B.shape[1]
    released = 0.9 * mesh.stiffness
    omega = 0.05 * 2.0 * np.pi * MODES_TO

    def receptance(M, K, B):
        return B @ np.linalg.solve(K - B.T @ (released[:, None] * B) - omega**2 * M, B.T)

    own = structure.K + rows.T @ (mesh.stiffness[:, None] * rows)
    whole = receptance(M, K, B)
    assert np.abs(receptance(structure.M, own, rows) - whole).max() < 1e-6 * np.abs(whole).max()
    without = np.zeros((B.shape[0], 0))
    lacking, fewer = few(mesh, without)
    own = lacking.K + fewer.T @ (mesh.stiffness[:, None] * fewer)
    assert np.abs(receptance(lacking.M, own, fewer) - whole).max() > 1e-2 * np.abs(whole).max()


@pytest.mark.parametrize("factor", [1.0, 1e4])
@pytest.mark.parametrize("clamped", [True, False])
def test_modes_without_contacts_are_those_of_all_rows(clamped, factor):
    """However stiff the contacts are that are taken away."""
    mesh = stuck_mesh(clamped)
    mesh = replace(mesh, stiffness=factor * mesh.stiffness)
    squares = linalg.eigvalsh(mesh.structure.K.toarray(), mesh.structure.M.toarray())
    rigid, below = mesh.rigid.shape[1], int(np.sum(squares <= (2.0 * np.pi * FREE_TO) ** 2))
    assert mesh.free_modes.shape[1] == below - rigid > 0

    def lowest(mesh):
        structure, _ = few(mesh, np.zeros((mesh.B.shape[0], 0)))
        return linalg.eigvalsh(structure.K, structure.M)[rigid:below]

    assert lowest(mesh) == pytest.approx(squares[rigid:below], rel=1e-5)
    if factor > 1.0:
        assert lowest(replace(mesh, free_to=1.0)).min() > 1.1 * squares[rigid]


def test_a_mode_at_the_end_of_what_is_sought_is_found():
    """A band that ends at a computed mode: K − σM has no factor there."""
    mesh = stuck_mesh()
    squares = linalg.eigvalsh(mesh.structure.K.toarray(), mesh.structure.M.toarray())
    mesh = replace(mesh, free_to=float(np.sqrt(squares[2])) / (2.0 * np.pi))
    assert mesh.free_modes.shape[1] == 3


def test_equal_bodies_have_each_of_their_modes_without_contacts():
    """More of them than one block of the iteration holds."""
    structure, pad, _ = beam(True)
    many = assemble({f"blade{k}": structure.with_damping(None) for k in range(10)})
    B = many.rows([{f"blade{k}/{node}.{axis}": 1.0} for k in range(10) for node in pad for axis in "xyz"])
    mesh = StuckMesh(many, B, np.full(B.shape[0], KT), many.rows([{many.kept[0]: 1.0}]), MODES_TO, FREE_TO)
    squares = linalg.eigvalsh(structure.K.toarray(), structure.M.toarray())
    shapes = mesh.free_modes
    own = np.repeat(squares[squares <= (2.0 * np.pi * FREE_TO) ** 2], 10)
    assert shapes.shape[1] == own.size
    assert np.linalg.eigvalsh(shapes.T @ (many.K @ shapes)) == pytest.approx(own, rel=1e-9)


def test_loads_and_outputs_are_static_without_any_contact_force():
    mesh = stuck_mesh()
    _, K, _ = dense(mesh)
    load = mesh.directions.toarray().T
    coordinates = mesh.coordinates(np.zeros((mesh.B.shape[0], 0)))
    own = coordinates.shapes.T @ load
    assert load.T @ np.linalg.solve(K, load) == pytest.approx(own.T @ own, rel=1e-8)


def test_directions_that_rounding_tells_apart_are_one():
    """Loads and outputs at one place: their static shapes are equal but for the rounding of a solution, which is no shape."""
    mesh = stuck_mesh()
    y, z = (mesh.directions[[k]] for k in (0, 1))
    equal = np.sqrt([(row @ mesh.flexible(row.toarray().T))[0, 0] for row in (y, z)])
    for apart, count in ((3e-6, 1), (3e-5, 2)):
        beside = y + apart * equal[0] / equal[1] * z
        pair = replace(mesh, directions=sparse.csr_array(sparse.vstack([y, beside])), free_to=1.0)
        assert pair.first_shapes.shape[1] == count


def test_coordinates_are_natural_ones_of_the_stuck_structure():
    mesh = stuck_mesh(clamped=False)
    shapes, squares, modes = mesh.coordinates(mesh.new_forces(mesh.first_shapes, mesh.forces_of_modes))
    assert modes == mesh.modes[0].size
    assert shapes.T @ (mesh.stuck @ shapes) == pytest.approx(np.eye(squares.size), abs=1e-9)
    assert shapes.T @ (mesh.structure.M @ shapes) == pytest.approx(np.diag(squares), abs=1e-9 * squares[0])


def test_rigid_motions_of_a_body_on_contacts_stay_free():
    """Six of them, each in the span of few coordinates to rounding, and K resists none of them."""
    mesh = stuck_mesh(clamped=False)
    structure, _ = few(mesh, np.zeros((mesh.B.shape[0], 0)))
    ((name, rows, rigid),) = mesh.bodies
    assert rigid.shape == (mesh.structure.size, 6)
    assert rows.size == mesh.structure.size
    assert name == mesh.structure.dofs[0].partition(".")[0]
    shapes = mesh.coordinates(np.zeros((mesh.B.shape[0], 0))).shapes
    y = shapes.T @ (mesh.stuck @ rigid)
    assert shapes @ y == pytest.approx(rigid, abs=1e-9 * np.abs(rigid).max())
    assert unresisted(structure.K, y).all()


def test_indices_are_short_where_they_suffice():
    mesh = stuck_mesh()
    assert {each.indices.dtype for each in (mesh.structure.K, mesh.structure.M, mesh.B, mesh.stuck)} == {np.dtype(np.int32)}


def test_forces_whose_shapes_are_known_bring_nothing_new():
    mesh, draw = stuck_mesh(), np.random.default_rng(3)
    none = np.zeros((mesh.B.shape[0], 0))
    forces = draw.standard_normal((mesh.B.shape[0], 4))
    new = mesh.new_forces(
        mesh.first_shapes, np.hstack([forces, forces @ draw.standard_normal((4, 3)), np.zeros((mesh.B.shape[0], 1))])
    )
    assert new.shape == (mesh.B.shape[0], 4)
    assert mesh.new_forces(mesh.coordinates(new).beyond, forces).shape[1] == 0
    assert mesh.new_forces(mesh.first_shapes, none).shape[1] == 0


def test_a_body_that_contacts_do_not_hold_is_refused_by_name():
    with pytest.raises(InputError, match=r"held by nothing.*led by '\d+\.x'"):
        _ = stuck_mesh(clamped=False, holding="yz").modes
    assert stuck_mesh(clamped=True, holding="yz").modes[0].size


def test_without_modes_in_reach_there_are_static_shapes_alone():
    mesh = stuck_mesh(modes_to=1.0)
    coordinates = mesh.coordinates(np.zeros((mesh.B.shape[0], 0)))
    assert coordinates.modes == 0
    assert coordinates.shapes.shape[1] == 2


def test_surfaces_and_stress_follow_the_coordinates():
    """Rows over some degrees of freedom of the mesh become rows over the coordinates."""
    mesh, draw = stuck_mesh(), np.random.default_rng(4)
    dofs = mesh.structure.dofs[5:17]
    surface = MeshSurface(np.zeros((2, 3)), np.zeros((0, 3), dtype=int), draw.standard_normal((6, 12)), dofs)
    stress = StressRecovery(("here",), draw.standard_normal((1, 6, 12)), dofs)
    mesh = replace(mesh, structure=replace(mesh.structure, surfaces=(surface,), stresses=(stress,)))
    coordinates = mesh.coordinates(np.zeros((mesh.B.shape[0], 0)))
    few = mesh.structure_on(coordinates, mesh.structure.kept)
    y = draw.standard_normal(few.size)
    x = coordinates.shapes @ y
    q = dict(zip(few.dofs, few.motion(y), strict=True))
    for made, own in ((few.surfaces[0].recovery, surface.recovery), (few.stresses[0].rows[0], stress.rows[0])):
        moved = made @ np.array([q[dof] for dof in few.surfaces[0].dofs])
        assert moved == pytest.approx(own @ x[5:17], rel=1e-5, abs=1e-6 * np.abs(own @ x[5:17]).max())
    assert q[mesh.structure.kept[0]] == pytest.approx(x[mesh.structure.index(mesh.structure.kept[0])])


def test_an_assembly_with_a_sparse_body_is_sparse():
    """Its matrices are those of the dense assembly, and it keeps what the sparse body keeps and all of the others."""
    structure, pad, tip = beam(True)
    damper = RigidBody(0.1, 1e-4 * np.eye(3), (0.0, 0.0, 0.0)).structure()
    both = assemble({"beam": structure.with_damping(None), "damper": damper})
    bare = Structure(structure.M, structure.K, structure.dofs)
    dense = assemble({"beam": bare, "damper": damper})
    assert isinstance(both, SparseStructure)
    assert both.dofs == dense.dofs
    for own, right in ((both.M, dense.M), (both.K, dense.K)):
        assert np.array_equal(own.toarray(), right)
    assert both.kept == (f"beam/{tip}.x", *(f"damper/{dof}" for dof in damper.dofs))
    assert both.sets["beam/pad"] == tuple(f"beam/{node}" for node in pad)
    with pytest.raises(InputError, match="cannot have springs"):
        assemble({"beam": structure.with_damping(None)}, [Spring({f"beam/{tip}.x": 1.0}, 1.0)])
