"""Files of names: coordinates and sets of nodes from a deck of the program or a table, beside a file of matrices."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from readers.conftest import Chain

import stickslip as ss
from stickslip.support.checks import InputError

ARCHIVE = """/COM,ANSYS RELEASE 2024 R1
/PREP7
NBLOCK,6,SOLID,         6,         6
(3i9,6e21.13e3)
        1        0        0 1.0000000000000E-001 2.0000000000000E-002
        2        0        0 2.0000000000000E-001
        3        0        0 3.0000000000000E-001 4.0000000000000E-002-1.0000000000000E-003
        4        0        0
        5        0        0-5.0000000000000E-001
        6        0        0 6.0000000000000E-001
N,R5.3,LOC,       -1,
EBLOCK,19,SOLID,         1,         1
(19i9)
        1        1        1        1        0        0        0        0        8        0        1
       -1
CMBLOCK,PAD     ,NODE,       3  ! users node component definition
(8i10)
         2        -4         6
CMBLOCK,BODY,ELEM,       1
(8i10)
         1
CMBLOCK,ALL,NODE,       10
(8i10)
         1         2         3         4         5         6         1         2
         3         4
"""
BULK = """$ a blade
GRID    1               .1      .02     0.
GRID,2,,.2,0.,0.
GRID*                  3                3.0000000000E-01    4.000000-2
*              -1.0-3
GRID    4       7       1.      1.      1.
CHEXA   1       1       1       2       3       4       5       6
"""


pytestmark = pytest.mark.filterwarnings("ignore:.*implausible")


def named(folder, name, text):
    path = folder / name
    path.write_text(text)
    return ss.read_model(Chain().save(folder, "npz"), names=path)


def test_an_archive_of_ansys_gives_coordinates_and_components(tmp_path):
    model = named(tmp_path, "blade.cdb", ARCHIVE)
    assert model.nodes["1"] == (0.1, 0.02, 0.0)
    assert model.nodes["3"] == (0.3, 0.04, -0.001)
    assert model.nodes["4"] == (0.0, 0.0, 0.0)
    assert model.nodes["5"] == (-0.5, 0.0, 0.0)
    assert model.sets == {"PAD": ("2", "3", "4", "6"), "ALL": ("1", "2", "3", "4", "5", "6", "1", "2", "3", "4")}


def test_an_archive_of_workbench_has_columns_of_several_widths(tmp_path):
    nodes = "NBLOCK,6,SOLID,2,2\n(1i7,2i9,6e21.13)\n" + "".join(
        f"{node:7d}{0:9d}{0:9d}{x:21.13E}{y:21.13E}\n" for node, x, y in ((1, 0.1, 0.02), (2, 0.2, 0.0))
    )
    model = named(tmp_path, "blade.cdb", nodes + "N,R5.3,LOC,       -1,\n")
    assert model.nodes == {"1": (0.1, 0.02, 0.0), "2": (0.2, 0.0, 0.0)}


def test_components_and_coordinates_of_an_archive_are_kept_by_name(tmp_path):
    (tmp_path / "blade.cdb").write_text(ARCHIVE)
    path = Chain().save(tmp_path, "npz")
    structure = ss.read_structure(path, names=tmp_path / "blade.cdb", keep={"pad": "PAD", "foot": (0.1, 0.02, 0.0)}, modes=0)
    assert structure.dofs == ("pad/2.x", "pad/3.x", "pad/4.x", "pad/6.x", "foot.x")
    assert structure.nodes["foot"] == (0.1, 0.02, 0.0)


def test_bulk_data_gives_coordinates_of_grid_points(tmp_path):
    model = named(tmp_path, "blade.bdf", BULK)
    assert model.nodes["1"] == (0.1, 0.02, 0.0)
    assert model.nodes["2"] == (0.2, 0.0, 0.0)
    assert model.nodes["3"] == (0.3, 0.04, -0.001)
    assert "4" not in model.nodes
    assert any("1 grid points of blade.bdf are left out" in note for note in model.notes)


def test_coordinates_of_a_deck_are_in_the_units_of_the_model(tmp_path):
    (tmp_path / "blade.cdb").write_text(ARCHIVE)
    model = ss.read_model(Chain().save(tmp_path, "npz"), names=tmp_path / "blade.cdb", units="mm-t-s")
    np.testing.assert_allclose(model.nodes["3"], [0.3e-3, 0.04e-3, -1e-6], rtol=1e-12)


def test_a_deck_of_abaqus_gives_coordinates_and_sets(tmp_path):
    model = named(tmp_path, "blade.inp", "*NODE\n1, 0.1, 0.02\n2, 0.2\n*NSET, NSET=PAD\n1, 2\n")
    assert model.nodes["1"] == (0.1, 0.02, 0.0)
    assert model.sets["PAD"] == ("1", "2")


def test_a_table_of_nodes_needs_no_directions(tmp_path):
    model = named(tmp_path, "nodes.csv", "node,x,y,z,set\n1,0.1,0.02,0,PAD TIP\n2,0.2,0,0,PAD\n")
    assert model.dofs == Chain().dofs
    assert model.nodes["2"] == (0.2, 0.0, 0.0)
    assert model.sets == {"PAD": ("1", "2"), "TIP": ("1",)}


def test_nodes_need_names_of_rows(tmp_path):
    (tmp_path / "nodes.csv").write_text("node,x,y,z\n1,0.1,0.02,0\n")
    with pytest.raises(InputError, match=r"nodes\.csv must name the rows of the matrices, whose own file does not"):
        ss.read_model(Chain().save(tmp_path, "matrix_market"), names=tmp_path / "nodes.csv")


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("other.inp", "*NODE\n70, 1., 1.\n", "must hold nodes of the model (1, 2, 3, ...), but is ['70']"),
        ("cut.cdb", ARCHIVE[: ARCHIVE.index("(8i10)") + 20], "must hold its 3 numbers"),
        ("wide.cdb", ARCHIVE.replace("(3i9,6e21.13e3)", "(3i9)"), "without those of coordinates"),
        ("text.cdb", ARCHIVE.replace("(3i9,6e21.13e3)", "free"), "must be stated as (3i9,6e21.13e3)"),
        ("large.cdb", ARCHIVE.replace("        -4", "-999999999"), "must have at most"),
        ("missing.cdb", None, "must be a file that exists"),
    ],
)
def test_wrong_files_of_names(tmp_path, name, text, words):
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError) as raised:
        ss.read_model(Chain().save(tmp_path, "npz"), names=tmp_path / name)
    assert words in str(raised.value)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no such devices")
def test_a_device_is_no_file_of_names(tmp_path):
    """A study may name one; this has no end."""
    (tmp_path / "names.csv").symlink_to("/dev/zero")
    with pytest.raises(InputError, match=r"The file of names must be a file, but is .* a device or pipe"):
        ss.read_model(Chain().save(tmp_path, "npz"), names=tmp_path / "names.csv")


INPUT = """*PART, NAME=B
*NODE
1, 0.1, 0.02
3, 0.3, 0.0
*NGEN
1, 3, 1
*ELEMENT, TYPE=T3D2, ELSET=E
1, 1, 2
*NSET, NSET=N, ELSET=E
*END PART
*ASSEMBLY, NAME=A
*INSTANCE, NAME=P-1, PART=B
1., 0., 0.
1., 0., 0., 1., 0., 1., 90.
*END INSTANCE
*NSET, NSET=Y
P-1.2, P-1.N
*END ASSEMBLY
"""


@pytest.mark.parametrize(("name", "text"), [("blade.cdb", ARCHIVE), ("blade.bdf", BULK), ("blade.inp", INPUT)])
@given(data=st.data())
def test_damaged_decks_are_refused_or_read(tmp_path_factory, name, text, data):
    folder = tmp_path_factory.mktemp("damaged")
    place = data.draw(st.integers(0, len(text) - 1))
    changed = data.draw(
        st.one_of(st.just(text[:place]), st.text(max_size=9).map(lambda new: text[:place] + new + text[place + len(new) :]))
    )
    try:
        model = named(folder, name, changed)
    except InputError:
        return
    assert all(np.isfinite(point).all() for point in model.nodes.values())


def test_nodes_without_coordinates_and_strange_nodes_of_sets_are_noted(tmp_path):
    """A table of part of the nodes is taken, but not in silence; clamped nodes, with coordinates and without rows, are usual."""
    model = named(tmp_path, "nodes.csv", "node,x,y,z,set\n1,0.1,0,0,PAD\n2,0.2,0,0,PAD\n70,0,0,0,PAD\n")
    assert [note for note in model.notes if "nodes.csv" in note] == [
        "nodes.csv gives no coordinates of 4 nodes of the model: 3, 4, 5, 6."
    ]
    model = named(tmp_path, "part.inp", "*NODE\n" + "".join(f"{k}, {k}.\n" for k in range(1, 7)) + "*NSET, NSET=PAD\n1, 77\n")
    assert "Sets of part.inp name 1 node that the model does not have: 77." in model.notes


def test_a_cell_left_out_of_a_table_is_no_zero(tmp_path):
    """`1,,0.02,0` lacks its x; a table with columns node, x, y has z = 0 throughout."""
    with pytest.raises(InputError, match=r"The coordinates of node 1 must be finite numbers, but is \['', '0\.02', '0'\]"):
        named(tmp_path, "nodes.csv", "node,x,y,z\n1,,0.02,0\n")
    assert named(tmp_path, "nodes.csv", "node,x,y\n1,0.1,0.02\n").nodes["1"] == (0.1, 0.02, 0.0)
