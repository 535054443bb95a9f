"""Archives of Ansys: nodes without blocks, nodes with axes of their own, and commands that make nodes."""

import numpy as np
import pytest

from stickslip.model.readers.ansys_deck import ARCHIVE_COMMANDS, nodal_axes, read_archive
from stickslip.support.checks import InputError

BLOCK = "NBLOCK,6,SOLID\n(3i8,6e20.13)\n" + "".join(
    f"{node:8d}{0:8d}{0:8d}{node - 1.0:20.12E}{0.0:20.12E}{0.0:20.12E}{angles}\n"
    for node, angles in ((1, ""), (2, f"{30.0:20.12E}"), (3, f"{0.0:20.12E}{0.0:20.12E}{-45.0:20.12E}"))
)


def archive(folder, text):
    (folder / "a.cdb").write_text(text)
    return read_archive(folder / "a.cdb")


def test_nodes_without_blocks(tmp_path):
    """As CDWRITE with UNBLOCKED writes them, and as commands are typed."""
    lines = "".join(f"N,R5.3,LOC,{node:8d}, {node - 1.0}, 0.5, 0.0\nN,R5.3,ANG,{node:8d}, 0.0, 0.0, 0.0\n" for node in (1, 2))
    found = archive(tmp_path, f"/PREP7\n{lines}N,R5.3,LOC,      -1,\nN,3,2.,,7.\n")
    assert found.nodes == {"1": (0.0, 0.5, 0.0), "2": (1.0, 0.5, 0.0), "3": (2.0, 0.0, 7.0)}
    assert (found.notes, dict(found.turned.axes)) == ((), {})


def test_nodes_with_axes_of_their_own(tmp_path):
    found = archive(tmp_path, BLOCK + "N,R5.3,LOC,-1,\nN,R5.3,LOC,4,3.,0.,0.\nN,R5.3,ANG,4,0.,10.,0.\nN,5,4.,0.,0.,,,20.\n")
    assert list(found.nodes) == ["1", "2", "3", "4", "5"]
    assert sorted(found.turned.axes) == ["2", "3", "4", "5"]
    assert found.turned.axes["2"][:, 0] == pytest.approx([np.sqrt(0.75), 0.5, 0.0])  # 30° from x to y
    assert found.turned.axes["3"][:, 2] == pytest.approx([-np.sqrt(0.5), 0.0, np.sqrt(0.5)])  # −45° from z to x
    assert found.turned.axes["4"][:, 1] == pytest.approx([0.0, np.cos(np.pi / 18), np.sin(np.pi / 18)])  # 10° from y to z


def test_angles_of_a_node_turn_about_its_axes_one_after_the_other():
    """z by 90° leads x to Y and y to −X; the new x by 90° leads y to Z and z to X; the new y by 90° leads x to −X and z to Y."""
    X, Y, Z = np.eye(3)
    np.testing.assert_allclose(nodal_axes((90.0, 0.0, 0.0)).T, [Y, -X, Z], atol=1e-15)
    np.testing.assert_allclose(nodal_axes((90.0, 90.0, 0.0)).T, [Y, Z, X], atol=1e-15)
    np.testing.assert_allclose(nodal_axes((90.0, 90.0, 90.0)).T, [-X, Z, Y], atol=1e-15)


def test_nodes_of_an_active_system(tmp_path):
    """N would place its node in the system 11; blocks and R5.3 are always global."""
    local = "LOCAL,R5.0,LOC,11,0,5.,0.,0.\n"
    assert archive(tmp_path, local + "N,R5.3,LOC,1,2.,0.,0.\nCSYS,0\nN,2,3.,0.,0.\n").nodes == {
        "1": (2.0, 0.0, 0.0),
        "2": (3.0, 0.0, 0.0),
    }
    for command in (local, "CSYS,1\n"):
        with pytest.raises(InputError, match=r"A command N must follow CSYS, 0, but is 'N, 1, 2\.'"):
            archive(tmp_path, command + "N,1,2.\n")


def test_what_is_not_obeyed_is_refused_or_said(tmp_path):
    for command in ("NGEN,3,10,ALL", "NROTAT,ALL", "FILL", "NUMMRG,NODE", "/INPUT,mesh,inp", "*DO,I,1,9", "NMODIF,1,2."):
        with pytest.raises(InputError, match=r"a\.cdb, line 2 must hold cards that this reader obeys.*CDWRITE"):
            archive(tmp_path, f"/PREP7\n{command}\n")
    notes = archive(tmp_path, "N,1,0.,0.\nEN,R5.5,ATTR,8\nCM,PAD,NODE\nNEWTHING,1\n_CDRDOFF=\n*ENDIF\n").notes
    assert [note.partition(";")[0] for note in notes[:2]] == ["a.cdb: EN is not read", "a.cdb: CM is not read"]
    assert notes[2].startswith("a.cdb: this reader does not know NEWT (a.cdb, line 4)")


def test_element_types_in_a_block(tmp_path):
    text = "ETBLOCK,2,2\n(2i9,19a9)\n        1      185        0\n        2      181\n       -1\n" + BLOCK + "N,R5.3,LOC,-1,\n"
    elements = "EBLOCK,19,SOLID\n(19i9)\n" + "".join(
        "".join(f"{number:9d}" for number in (1, kind, 1, 1, 0, 0, 0, 0, len(nodes), 0, 7, *nodes)) + "\n"
        for kind, nodes in ((1, range(1, 9)), (2, (1, 2, 3, 4)))
    )
    assert {kind: len(cells) for kind, cells in archive(tmp_path, text + elements + "       -1\n").cells.items()} == {
        "hexahedron": 1,
        "quadrilateral": 1,
    }


NODES = """N NAXIS NANG NDELE NDIST NGEN NLIST NMODIF NORA NORL NPLOT NREAD NROTAT NRRANG NRWRITE NSCALE NSEL NSYM NWPAVE NWRITE
FILL QUAD MOVE TRANSFER MORPH"""
"""Command Reference, PREP7 commands, Nodes."""


def test_the_lists_know_the_commands_of_nodes():
    harmless = {"NAXIS", "NDIST", "NLIST", "NPLOT", "NRRANG", "NRWRITE", "NWPAVE", "NWRITE"}  # they list, draw, write or measure
    assert {name for name in NODES.split() if name[:4] not in ARCHIVE_COMMANDS.known} <= harmless
    makers = {
        "NGEN",
        "NMODIF",
        "NANG",
        "NORA",
        "NORL",
        "NREAD",
        "NROTAT",
        "NSCALE",
        "NSYM",
        "FILL",
        "QUAD",
        "MOVE",
        "TRANSFER",
        "MORPH",
        "NDELE",
    }
    assert {name[:4] for name in makers} <= ARCHIVE_COMMANDS.refused.keys()
    lists = (ARCHIVE_COMMANDS.obeyed, ARCHIVE_COMMANDS.harmless, ARCHIVE_COMMANDS.refused.keys(), ARCHIVE_COMMANDS.noted.keys())
    assert sum(map(len, lists)) == len(ARCHIVE_COMMANDS.known)
