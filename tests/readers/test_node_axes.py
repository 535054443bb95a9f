"""Rows of nodes with axes of their own are turned along those of the model: CD of GRID, *TRANSFORM, angles of Ansys."""

import numpy as np
import pytest
from each import each
from scipy.spatial.transform import Rotation

import stickslip as ss
from stickslip.model.readers.deck import OWN_AXES, Deck, NodeAxes, along_model
from stickslip.model.readers.input_deck import read_deck
from stickslip.model.readers.model import describe
from stickslip.model.readers.nastran_deck import CoordinateSystem
from stickslip.model.structure.solid import box_mesh, solid

SIX = ("x", "y", "z", "rx", "ry", "rz")


def beam():
    """M and K of a free beam element of steel along x, 2 m, two nodes of six rows."""
    E, G, A, moment, J, L = 2.1e11, 8.1e10, 1e-3, 1e-7, 2e-7, 2.0
    K = np.zeros((12, 12))
    for row, k in ((0, E * A / L), (3, G * J / L)):
        K[np.ix_([row, row + 6], [row, row + 6])] += k * np.array([[1, -1], [-1, 1]])
    a, b, c = 12.0, 6.0 * L, 2.0 * L**2
    bending = E * moment / L**3 * np.array([[a, b, -a, b], [b, 2 * c, -b, c], [-a, -b, a, -b], [b, c, -b, 2 * c]])
    K[np.ix_([1, 5, 7, 11], [1, 5, 7, 11])] += bending
    signs = np.diag([1.0, -1.0, 1.0, -1.0])
    K[np.ix_([2, 4, 8, 10], [2, 4, 8, 10])] += signs @ bending @ signs
    mass = 7800.0 * A * L / 2
    return np.diag(2 * [mass, mass, mass, 0.01, 0.01, 0.01]), K


@each("digits", [6, 16])
def test_a_free_beam_has_six_rigid_motions_whatever_the_axes_of_its_nodes(digits, tmp_path):
    """Node 2 is turned by 30° about z. Axes of six digits are those of K within 4e-7, which K resists in four motions."""
    M, K = beam()
    cosine, sine = np.cos(np.pi / 6), np.sin(np.pi / 6)
    A = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    T = np.eye(12)
    T[6:9, 6:9] = T[9:, 9:] = A.T
    dofs = [f"{node}.{axis}" for node in (1, 2) for axis in SIX]
    np.savez(tmp_path / "a.npz", M=T @ M @ T.T, K=T @ K @ T.T, dofs=dofs)
    system = f"CORD2R*,7,,0.,0.\n*,0.,0.,0.,1.\n*,{cosine:.{digits}f},{sine:.{digits}f},0.\n"
    (tmp_path / "a.bdf").write_text(f"{system}GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.,7\n")
    model = ss.read_model(tmp_path / "a.npz", names=tmp_path / "a.bdf")
    np.testing.assert_allclose(model.K.toarray(), K, atol=(1e-6 if digits == 6 else 1e-14) * K.max())
    found = describe(model)
    assert (found.modes.rigid, found.modes.negative) == (6, 0)
    note = "a.bdf gives local axes to 1 node (CD of GRID): their rows are turned along those of the model."
    assert found.odd == (note,)


def test_matrices_are_those_along_the_axes_of_the_model():
    """Any axes at every node, rows in any order, and a C that is not symmetric."""
    draw = np.random.default_rng(2)
    dofs = [f"{node}.{axis}" for node in range(5) for axis in (SIX if node else "xyz")] + ["modes.q1"]
    order = draw.permutation(len(dofs))
    matrices = {letter: draw.standard_normal((len(dofs), len(dofs))) for letter in "MKC"}
    matrices |= {letter: matrices[letter] + matrices[letter].T for letter in "MK"}
    axes = {str(node): Rotation.random(random_state=node).as_matrix() for node in (0, 1, 3, 9)}
    local = np.eye(len(dofs))  # q_model = local q_own
    for node, own in axes.items():
        for triple in (SIX[:3], SIX[3:]):
            rows = [dofs.index(f"{node}.{axis}") for axis in triple if f"{node}.{axis}" in dofs]
            if rows:
                local[np.ix_(rows, rows)] = own
    own = {letter: (local.T @ matrix @ local)[np.ix_(order, order)] for letter, matrix in matrices.items()}
    found = along_model(own, [dofs[k] for k in order], NodeAxes("a.bdf", "CD of GRID", axes))
    assert found.dofs == tuple(dofs[k] for k in order)
    for letter, matrix in matrices.items():
        np.testing.assert_allclose(found.matrices[letter].toarray(), matrix[np.ix_(order, order)], atol=1e-13)
    assert (found.any, found.left) == (True, False)
    assert "to 3 nodes" in found.notes[0]  # one of them has no rows


def cylindrical(angle):
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


@each(("angle", "directions", "expected"), [(90.0, "xz", "yz"), (180.0, "xz", "xz"), (30.0, "xy", "xy"), (270.0, "y", "x")])
def test_a_support_along_an_axis_of_the_model_leaves_the_others(angle, directions, expected):
    """A node whose θ is held at 90°: r is y. Rows that remain span axes of the model, and take their names."""
    size = len(directions)
    K = 3.0 * np.eye(size) + 1.0
    found = along_model(
        {"M": np.eye(size), "K": K}, [f"7.{axis}" for axis in directions], NodeAxes("", "", {"7": cylindrical(angle)})
    )
    assert found.dofs == tuple(f"7.{axis}" for axis in expected)
    kept = cylindrical(angle)[np.ix_(["xyz".index(axis) for axis in expected], ["xyz".index(axis) for axis in directions])]
    np.testing.assert_allclose(found.matrices["K"].toarray(), kept @ K @ kept.T, atol=1e-14)
    assert not found.left


@each("axes", [cylindrical(45.0), None])
def test_rows_that_cannot_be_turned_stay_and_are_said(axes):
    """θ held at 45° leaves a direction between x and y; the other node has axes that the deck does not say."""
    dofs = ("7.x", "7.z", "8.x", "8.y", "8.z")
    K = np.diag([1.0, 2.0, 3.0, 4.0, 5.0])
    found = along_model({"M": np.eye(5), "K": K}, dofs, NodeAxes("a.bdf", "CD of GRID", {"7": axes, "8": cylindrical(90.0)}))
    assert found.dofs == dofs
    np.testing.assert_allclose(found.matrices["K"].diagonal(), [1.0, 2.0, 4.0, 3.0, 5.0])
    assert found.left
    assert f"a.bdf has 1 node with {OWN_AXES} (CD of GRID)" in found.notes[1]
    assert found.notes[1].endswith("leaves rows out: 7.")


@each("kind", ["R", "C", "S"])
def test_displacements_of_a_system_of_nastran_are_along_its_coordinates(kind):
    """Each axis is the direction in which its coordinate grows."""
    system = CoordinateSystem(kind, np.array([1.0, -2.0, 0.5]), Rotation.random(random_state=4).as_matrix())
    at, step = np.array([2.0, 40.0, 70.0]), 1e-4
    axes = system.axes_at(system.place(at))
    for k, direction in enumerate(np.eye(3)):
        grown = system.place(at + step * direction) - system.place(at - step * direction)
        np.testing.assert_allclose(axes[:, k], grown / np.linalg.norm(grown), atol=1e-8)
    assert kind == "R" or system.axes_at(system.place(np.array([0.0, 0.0, 0.0]))) is None


DECK = """*NODE
1, 1., 2., 0.
2, 0., 3., 5.
*NSET, NSET=A
1, 2
"""


def transformed(folder, card, deck=DECK) -> Deck:
    (folder / "a.inp").write_text(deck + card)
    return read_deck(folder / "a.inp")


def test_transform_of_abaqus(tmp_path):
    """R: a on x', b on the plane of x' and y'; C: from a to b; other kinds stay as they are."""
    turned = transformed(tmp_path, "*TRANSFORM, NSET=A\n0., 2., 0., -1., 0., 0.\n").turned.axes
    np.testing.assert_allclose(turned["1"].T, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-15)
    turned = transformed(tmp_path, "*TRANSFORM, NSET=A, TYPE=C\n1., 0., 0., 1., 0., 4.\n").turned.axes
    np.testing.assert_allclose(turned["1"].T, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-15)
    root = np.sqrt(0.1)
    np.testing.assert_allclose(turned["2"].T, [[-root, 3 * root, 0], [-3 * root, -root, 0], [0, 0, 1]], atol=1e-15)
    assert transformed(tmp_path, "*TRANSFORM, NSET=A, TYPE=S\n1., 0., 0., 1., 0., 4.\n").turned.axes == {"1": None, "2": None}


def test_transform_goes_with_its_instance(tmp_path):
    """The part is moved by 10 along x, then turned by 90° about z through (10, 0): x' = (0, 1, 0) becomes (−1, 0, 0)."""
    part = "*PART, NAME=P\n" + DECK + "*TRANSFORM, NSET=A\n0., 1., 0., -1., 0., 0.\n*END PART\n*ASSEMBLY, NAME=W\n"
    card = "*INSTANCE, NAME=I, PART=P\n10., 0., 0.\n10., 0., 0., 10., 0., 1., 90.\n*END INSTANCE\n*END ASSEMBLY\n"
    found = transformed(tmp_path, card, part)
    assert found.nodes["1"] == pytest.approx((8.0, 1.0, 0.0))
    np.testing.assert_allclose(found.turned.axes["1"].T, [[-1, 0, 0], [0, -1, 0], [0, 0, 1]], atol=1e-12)


def test_a_meshed_body_with_cylindrical_axes_is_the_one_without(tmp_path):
    """A free block: its rigid motions, translation mass and frequencies, read with CD = 1 at every node."""
    body = solid(box_mesh(np.linspace(0.01, 0.02, 2), np.linspace(0.0, 0.01, 2), np.linspace(0.0, 0.04, 3)))
    local = np.zeros(body.K.shape)
    rows, lines = [""] * body.size, ["CORD2C,1,,0.,0.,0.,0.,0.,1.", ",1.,0.,0."]
    for node, (numbers, (x, y, z)) in enumerate(zip(body.numbers, body.points.tolist(), strict=True), start=1):
        local[np.ix_(numbers, numbers)] = cylindrical(np.degrees(np.arctan2(y, x)))
        lines.append(f"GRID*,{node},,{x!r},{y!r}\n*,{z!r},1")
        for axis, row in zip("xyz", numbers, strict=True):
            rows[row] = f"{node}.{axis}"
    np.savez(tmp_path / "a.npz", M=local.T @ body.M @ local, K=local.T @ body.K @ local, dofs=rows)
    (tmp_path / "a.bdf").write_text("\n".join(lines) + "\n")
    model = ss.read_model(tmp_path / "a.npz", names=tmp_path / "a.bdf")
    np.testing.assert_allclose(model.K.toarray(), body.K.toarray(), atol=1e-12 * np.abs(body.K.data).max())
    found = describe(model, 8)
    assert found.modes.rigid == 6
    np.testing.assert_allclose(found.mass, 7850 * 0.01 * 0.01 * 0.04, rtol=1e-10)
