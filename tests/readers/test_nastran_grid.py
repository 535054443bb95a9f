"""Grid points of Nastran in rectangular, cylindrical and spherical systems, against places worked out by hand."""

import numpy as np
import pytest
from each import each
from readers import nastran_files

import stickslip as ss
from stickslip.model.readers.nastran_deck import BULK_CARDS, ELEMENTS, read_grid


def deck(folder, text, **files):
    for name, content in files.items():
        (folder / f"{name}.bdf").write_text(content)
    path = folder / "blade.bdf"
    path.write_text(text)
    return read_grid(path)


def test_cylindrical_and_spherical_coordinates(tmp_path):
    """Axis along z, θ from the x axis: (2, 90°, 3) is (0, 2, 3); (2, 90°, 90°) of the sphere is (0, 2, 0)."""
    found = deck(
        tmp_path,
        "CORD2C,5,,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\nCORD2S,6,0,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\n"
        "GRID,1,5,2.,90.,3.\nGRID,2,6,2.,90.,90.\nGRID,3,6,2.,0.,17.\nGRID,4,,.1,.2,.3\n",
    )
    assert found.nodes["1"] == pytest.approx((0.0, 2.0, 3.0), abs=1e-14)
    assert found.nodes["2"] == pytest.approx((0.0, 2.0, 0.0), abs=1e-14)
    assert found.nodes["3"] == pytest.approx((0.0, 0.0, 2.0), abs=1e-14)
    assert found.nodes["4"] == (0.1, 0.2, 0.3)
    assert found.notes == ()


def test_systems_in_systems_whatever_their_order(tmp_path):
    """System 8 has its origin at r = 1, θ = 90° of system 7 and axes turned with it by its own points; 9 lies at grid points."""
    found = deck(
        tmp_path,
        "CORD1R,9,11,12,13\n"
        "CORD2R,8,7,1.,90.,0.,1.,90.,1.,\n,2.,90.,0.\n"
        "CORD2C,7,0,10.,0.,0.,10.,0.,1.,\n,11.,0.,0.\n"
        "GRID,1,8,1.,0.,0.\nGRID,2,8,0.,1.,0.\nGRID,3,9,0.,0.,2.\n"
        "GRID,11,8,0.,0.,0.\nGRID,12,8,1.,0.,0.\nGRID,13,8,0.,0.,1.\n",
    )
    assert found.nodes["1"] == pytest.approx((10.0, 2.0, 0.0), abs=1e-13)
    assert found.nodes["2"] == pytest.approx((9.0, 1.0, 0.0), abs=1e-13)
    assert found.nodes["3"] == pytest.approx((10.0, 3.0, 0.0), abs=1e-13)


def test_defaults_of_all_grid_points(tmp_path):
    """GRDSET fills what a GRID entry leaves blank; a 0 is the basic system."""
    found = deck(
        tmp_path, "CORD2R,4,,0.,0.,5.,0.,0.,6.,\n,1.,0.,5.\nGRDSET,,4,,,,4\nGRID,1,,1.,2.,3.\nGRID,80000000001,0,1.,2.,3.,0\n"
    )
    assert found.nodes["1"] == pytest.approx((1.0, 2.0, 8.0))
    assert found.nodes["80000000001"] == (1.0, 2.0, 3.0)
    assert (found.turned.file, found.turned.card, list(found.turned.axes)) == ("blade.bdf", "CD of GRID", ["1"])


def test_defaults_of_grid_points_count_wherever_they_stand(tmp_path):
    """The order of bulk data is free: a GRDSET below the points is that of all of them."""
    found = deck(tmp_path, "GRID,1,,1.,90.,3.\nCORD2C,5,,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\nGRDSET,,5,,,,5\n")
    assert found.nodes["1"] == pytest.approx((0.0, 1.0, 3.0))
    assert (found.turned.file, found.turned.card, list(found.turned.axes)) == ("blade.bdf", "CD of GRID", ["1"])


@pytest.mark.parametrize(
    "systems", ["", "CORD2R,7,8,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\nCORD2R,8,7,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\n", "CORD1R,7,1,2,3\n"]
)
def test_grid_points_in_systems_that_are_not_known(tmp_path, systems):
    found = deck(tmp_path, systems + "GRID,1,7,1.,1.,1.\nGRID,2,,1.,0.,1.\n")
    assert list(found.nodes) == ["2"]
    assert found.notes == ("1 grid points of blade.bdf are left out: their coordinate systems are not in the file.",)


def test_points_in_line_are_no_system(tmp_path):
    with pytest.raises(ss.InputError, match=r"Coordinate system 7 must be given by three points that are not in line"):
        deck(tmp_path, "CORD2R,7,,0.,0.,0.,0.,0.,1.,\n,0.,0.,2.\nGRID,1,7,1.,1.,1.\n")


def test_many_systems_in_a_row_end(tmp_path):
    """Each refers to the one after it: those beyond the hundredth are left out, in bounded time."""
    chain = "".join(f"CORD2R,{k},{k + 1},0.,0.,1.,0.,0.,2.,\n,1.,0.,1.\n" for k in range(1, 300))
    last = "CORD2R,300,0,0.,0.,1.,0.,0.,2.,\n,1.,0.,1.\n"
    found = deck(tmp_path, chain + last + "GRID,1,1,0.,0.,0.\nGRID,2,260,0.,0.,0.\n")
    assert found.nodes.keys() == {"2"}
    np.testing.assert_allclose(found.nodes["2"], (0.0, 0.0, 41.0))


POINTS = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\n"


@each("quoted", ["'mesh.bdf'", '"mesh.bdf"', "mesh.bdf", "'me\n      sh.bdf'", "'.\\mesh.bdf' $ a comment"])
def test_included_files(tmp_path, quoted):
    found = deck(tmp_path, f"SOL 103\nCEND\nBEGIN BULK\nINCLUDE {quoted}\nGRID,3,,2.,0.,0.\nENDDATA\n", mesh=POINTS)
    assert list(found.nodes) == ["1", "2", "3"]
    assert found.notes == ()


def test_included_files_outside_of_the_folder_or_missing(tmp_path):
    (tmp_path / "inner").mkdir()
    (tmp_path / "mesh.bdf").write_text(POINTS)
    with pytest.raises(ss.InputError, match=r"The file that blade\.bdf, line 1 includes must lie in the folder of the deck"):
        deck(tmp_path / "inner", "INCLUDE '../mesh.bdf'\n")
    with pytest.raises(ss.InputError, match=r"The file that blade\.bdf, line 2 includes must exist .* Did you mean 'mesh\.bdf'"):
        deck(tmp_path, "BEGIN BULK\nINCLUDE 'mesg.bdf'\n")


def test_nothing_counts_before_begin_bulk_and_after_enddata(tmp_path):
    found = deck(tmp_path, f"SET 1 = 1,2\nGRID,7,,0.,0.,0.\nBEGIN BULK\n{POINTS}ENDDATA\nGRID,3,,0.,0.,0.\n")
    assert list(found.nodes) == ["1", "2"]


def test_large_fields_in_free_format(tmp_path):
    """GRID* has four fields a line, its continuation the rest: CD = 0 in the one, z alone in the other."""
    found = deck(tmp_path, "GRID*,1,,0.,0.\n*,5.,0\nGRID*,2,,1.,0.\n*,6.\nGRID,3,,1.,2.,7.,0\n")
    assert found.nodes == {"1": (0.0, 0.0, 5.0), "2": (1.0, 0.0, 6.0), "3": (1.0, 2.0, 7.0)}
    with pytest.raises(ss.InputError, match=r"blade\.bdf, line 1 must hold at most 4 fields after its name"):
        deck(tmp_path, "GRID*,1,,0.,0.,5.,0\n")


@each(
    "text",
    [
        "GRID,1,,0.,0.,0.\n=,*1,=,*1.,==\n=(2)\n",
        "GRID,1,,0.,0.,0.\n=,*(1),,*(1.),=,=\n=2\n",
        "GRID           1              0.      0.      0.\n=             *1       =     *1.      =       =\n=(2)\n",
    ],
)
def test_replicated_entries(tmp_path, text):
    """Four grid points one apart along x."""
    assert deck(tmp_path, text).nodes == {str(k): (k - 1.0, 0.0, 0.0) for k in (1, 2, 3, 4)}


def test_replication_out_of_its_columns_is_refused(tmp_path):
    """*1. reaches over the end of its field: what it means is a guess."""
    text = "GRID           1              0.      0.      0.\n=              *1              *1.      =      =\n=(2)\n"
    with pytest.raises(ss.InputError, match=r"blade\.bdf, line 2, replication must hold .* Write the entries out"):
        deck(tmp_path, text)


def test_grid_points_of_superelements_have_numbers_of_their_own(tmp_path):
    part = "BEGIN SUPER=7\nGRID,1,,9.,9.,9.\n"
    found = deck(tmp_path, f"BEGIN BULK\n{POINTS}{part}ENDDATA\n")
    assert found.nodes["1"] == (0.0, 0.0, 0.0)
    assert found.notes == (
        "blade.bdf: the grid points of SUPER 7 are left out, since their numbering is separate. Use a file of the superelement.",
    )
    assert deck(tmp_path, part).nodes == {"1": (9.0, 9.0, 9.0)}  # the punch file of one superelement


def test_what_is_not_obeyed_is_refused_or_said(tmp_path):
    for card in BULK_CARDS.refused:
        with pytest.raises(ss.InputError, match=r"blade\.bdf, line 3 must hold cards that this reader obeys"):
            deck(tmp_path, f"{POINTS}{card},1,2\n")
    for card in BULK_CARDS.noted:
        (note,) = deck(tmp_path, f"{POINTS}{card},1,2\n").notes
        assert note.startswith(f"blade.bdf: {card} is not read; ")
    (note,) = deck(tmp_path, POINTS + "NEWCARD,1\n").notes
    assert note.startswith("blade.bdf: this reader does not know NEWCARD (blade.bdf, line 3)")
    assert deck(tmp_path, POINTS + "".join(f"{card},1\n" for card in BULK_CARDS.harmless)).notes == ()


GEOMETRY = """
CORD1C CORD1R CORD1S CORD2C CORD2R CORD2S CORD3G CORD3R GMCORD GRID GRDSET GRIDB GRIDF GRIDS POINT RINGAX RINGFL SECTAX
SPOINT EPOINT SEQGP SNORM FEEDGE FEFACE GMCURV GMSURF AEGRID FREEPT POINTAX PRESPT SLBDY BNDGRID
"""
"""Bulk data entries of the chapters "Grid points", "Coordinate systems", "Scalar points", "Fluid points" and "Axisymmetry"."""
SUPERELEMENTS = """
CSUPER CSUPEXT EXTRN RELEASE SEBNDRY SEBSET SEBSET1 SEBULK SECONCT SECSET SECSET1 SEELT SEEXCLD SELABEL SELOC SELOAD SEMPLN
SENQSET SEQSEP SEQSET SEQSET1 SESET SESUP SETREE SEUSET SEUSET1
"""
MATRICES_AND_SETS = """
DMI DMIG DMIAX DTI ASET ASET1 BSET BSET1 CSET CSET1 OMIT OMIT1 QSET QSET1 SUPORT SUPORT1 USET USET1 SET1 SET3 MPC SPC SPC1
"""
MESH = """
CHEXA CPENTA CPYRAM CTETRA CQUAD4 CQUAD8 CQUADR CTRIA3 CTRIA6 CTRIAR CBAR CBEAM CBEND CBUSH CROD CTUBE CONROD CSHEAR CELAS1
CELAS2 CELAS3 CELAS4 CDAMP1 CDAMP2 CDAMP3 CDAMP4 CDAMP5 CMASS1 CMASS2 CMASS3 CMASS4 CONM1 CONM2 CVISC CGAP CFAST CWELD CSEAM
CQUAD CQUADX CTRIAX CTRIAX6 GENEL PLOTEL RBAR RBE1 RBE2 RBE3 RROD RSPLINE RTRPLT RSSCON INCLUDE ENDDATA PARAM
"""
"""What the Quick Reference Guide lists under these headings."""


@each("manual", [GEOMETRY, SUPERELEMENTS, MATRICES_AND_SETS, MESH])
def test_the_lists_know_the_entries_of_the_manual(manual):
    assert set(manual.split()) - BULK_CARDS.known == set()
    lists = (BULK_CARDS.obeyed, BULK_CARDS.harmless, BULK_CARDS.refused.keys(), BULK_CARDS.noted.keys())
    assert sum(map(len, lists)) == len(BULK_CARDS.known)
    assert ELEMENTS.keys() < BULK_CARDS.obeyed


def test_a_superelement_names_the_rows_of_its_matrices(tmp_path):
    """OUTPUT4 of EXTSEOUT has no names; its punch file lists them in EXTRN, two grid points and two modes here."""
    pch = "BEGIN SUPER 7\nEXTRN,3,123456,11,13,901,0,902,0\nGRID,3,,0.,0.,0.\nGRID,11,,0.,1.,0.\nSPOINT,901,902\n"
    (tmp_path / "part.pch").write_text(pch)
    np.savez(tmp_path / "part.npz", M=np.eye(10), K=1e4 * np.eye(10))
    model = ss.read_model(tmp_path / "part.npz", names=tmp_path / "part.pch")
    assert model.dofs == (*(f"3.{axis}" for axis in ("x", "y", "z", "rx", "ry", "rz")), "11.x", "11.z", "901.q0", "902.q0")
    assert model.nodes["11"] == (0.0, 1.0, 0.0)
    (tmp_path / "part.op4").write_text(nastran_files.op4_text({"KXX": 1e4 * np.eye(10), "MXX": np.eye(10)}, "dense"))
    assert ss.read_model(tmp_path / "part.op4").dofs == model.dofs
    np.savez(tmp_path / "part.npz", M=np.eye(9), K=1e4 * np.eye(9))
    with pytest.raises(ss.InputError, match=r"dofs, the names of the rows of M, must have 9 entries, but is 10"):
        ss.read_model(tmp_path / "part.npz", names=tmp_path / "part.pch")
