"""Elements of decks: their kinds and corners, what is left out, and when there is no surface."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.readers.ansys_deck import read_archive
from stickslip.model.readers.input_deck import read_deck
from stickslip.model.readers.nastran_deck import read_grid

pytestmark = pytest.mark.filterwarnings("ignore:.*implausible")

DECK = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
*ELEMENT, TYPE=C3D20R, ELSET=A
7, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15,
16, 17, 18, 19, 20
8, 21,22,23,24,25,26,27,28, 9, 10,
11, 12, 13, 14, 15, 16, 17, 18, 19, 20
*ELEMENT, TYPE=C3D8I
9, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D10
10, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10
*Element, type=S8R5
11, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=S3
12, 1, 2, 3
*ELEMENT, TYPE=C3D15
13, 1,2,3,4,5,6, 7,8,9,10,11,12,13,14,15
*ELEMENT, TYPE=SPRINGA
14, 1, 2
*ELEMENT, TYPE=B31
15, 1, 2
"""
BULK = """GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
CHEXA   1       1       1       2       3       4       5       6       +A
+A      7       8       9       10      11      12      13      14      +B
+B      15      16      17      18      19      20
CTETRA,2,1,1,2,3,4
CQUAD4,3,1,1,2,3,4,45.
CTRIA3,4,1,1,2,3
CHEXA,5,1,1,2,3
"""


def test_elements_of_a_deck_by_kind_with_their_corners(tmp_path):
    (tmp_path / "a.inp").write_text(DECK)
    deck = read_deck(tmp_path / "a.inp")
    found = {kind: cells.tolist() for kind, cells in deck.cells.items()}
    assert found == {
        "hexahedron": [[1, 2, 3, 4, 5, 6, 7, 8], [21, 22, 23, 24, 25, 26, 27, 28], [1, 2, 3, 4, 5, 6, 7, 8]],
        "tetrahedron": [[1, 2, 3, 4]],
        "quadrilateral": [[1, 2, 3, 4]],
        "triangle": [[1, 2, 3]],
        "wedge": [[1, 2, 3, 4, 5, 6]],
    }
    assert deck.notes == ()


def test_elements_that_are_cut_off_are_left_out_with_a_note(tmp_path):
    (tmp_path / "a.inp").write_text(DECK + "*ELEMENT, TYPE=C3D4\n20, 1, 2, 3, 4\n21, 1, 2\n*ELEMENT, TYPE=C3D4\n22, 1, 2, x, 4\n")
    deck = read_deck(tmp_path / "a.inp")
    assert deck.cells["tetrahedron"].tolist() == [[1, 2, 3, 4]] * 2
    assert deck.notes == ("2 elements of a.inp are left out: they do not name all their corners.",)


def test_elements_of_bulk_data(tmp_path):
    (tmp_path / "a.bdf").write_text(BULK)
    deck = read_grid(tmp_path / "a.bdf")
    assert {kind: cells.tolist() for kind, cells in deck.cells.items()} == {
        "hexahedron": [[1, 2, 3, 4, 5, 6, 7, 8]],
        "tetrahedron": [[1, 2, 3, 4]],
        "quadrilateral": [[1, 2, 3, 4]],
        "triangle": [[1, 2, 3]],
    }
    assert any("1 elements of a.bdf are left out" in note for note in deck.notes)


def archive(angle=""):
    """A brick of 20 nodes, a prism as a brick that repeats nodes, a shell and a spring, in columns of eight characters."""
    nodes = "".join(f"{node:8d}{0:8d}{0:8d}{1.0:20.12E}{2.0:20.12E}{3.0:20.12E}{angle}\n" for node in range(1, 21))

    def element(kind, nodes):
        numbers = [1, kind, 1, 1, 0, 0, 0, 0, len(nodes), 0, 7, *nodes]
        return "".join(f"{number:8d}" for number in numbers[:19]) + "\n" + "".join(f"{n:8d}" for n in numbers[19:])

    elements = [(1, range(1, 21)), (2, (1, 2, 3, 3, 5, 6, 7, 7)), (3, (1, 2, 3, 4)), (4, (1, 2))]
    lines = [line for each in elements for line in element(*each).splitlines()]
    return (
        "ET,       1,186\nET, 2, SOLID185\nET,3,181\nET,4,14\nNBLOCK,6,SOLID,20,20\n(3i8,6e20.13)\n"
        + nodes
        + "N,R5.3,LOC,       -1,\nEBLOCK,19,SOLID,4,4\n(19i8)\n"
        + "\n".join(lines)
        + "\n      -1\nCMBLOCK,PAD,NODE,2\n(8i10)\n         2         4\n"
    )


def test_elements_of_an_archive_of_ansys(tmp_path):
    (tmp_path / "a.cdb").write_text(archive())
    deck = read_archive(tmp_path / "a.cdb")
    assert {kind: cells.tolist() for kind, cells in deck.cells.items()} == {
        "hexahedron": [list(range(1, 9)), [1, 2, 3, 3, 5, 6, 7, 7]],
        "quadrilateral": [[1, 2, 3, 4]],
    }
    assert deck.sets == {"PAD": ("2", "4")}
    assert len(deck.nodes) == 20
    for angle, turned in ((30.0, 20), (0.0, 0)):
        (tmp_path / "a.cdb").write_text(archive(f"{angle:20.12E}"))
        found = read_archive(tmp_path / "a.cdb")
        assert len(found.turned.axes) == turned
        assert found.cells


def model_of_a_quadrilateral(folder, nodes):
    """Masses at some nodes of one shell element, read with its deck."""
    (folder / "a.inp").write_text("".join(DECK.partition("*ELEMENT")[:1]) + "*ELEMENT, TYPE=S4\n1, 1, 2, 3, 4\n")
    dofs = [f"{node}.{axis}" for node in nodes for axis in "xyz"]
    np.savez(folder / "a.npz", M=np.eye(len(dofs)), K=1e4 * np.eye(len(dofs)), dofs=dofs)
    return ss.read_model(folder / "a.npz", names=folder / "a.inp")


def test_nodes_without_rows_are_fixed_unless_they_are_most_of_the_mesh(tmp_path):
    """A condensed matrix keeps few nodes of a mesh: the others would stand still in the picture, though they move."""
    surface = model_of_a_quadrilateral(tmp_path, (2, 3, 4)).surface
    assert surface.numbers.tolist() == [[-1, -1, -1], [0, 1, 2], [3, 4, 5], [6, 7, 8]]
    assert surface.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    np.testing.assert_array_equal(surface.points[2], [1.0, 1.0, 0.0])
    assert model_of_a_quadrilateral(tmp_path, (2, 3)).surface is None
    structure = ss.read_structure(tmp_path / "a.npz", names=tmp_path / "a.inp")
    assert structure.surfaces == ()
