"""The same model comes out of every format; units, names and pairs of files."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from readers import nastran_files
from readers.conftest import KINDS
from scipy import io, sparse

import stickslip as ss
from stickslip.support.checks import Faults, InputError


@pytest.mark.parametrize("kind", KINDS)
def test_every_format_gives_the_model(chain, tmp_path, kind):
    structure = ss.read_structure(chain.save(tmp_path, kind), dofs=chain.dofs)
    for name in "MKC":
        np.testing.assert_allclose(getattr(structure, name), getattr(chain, name), rtol=1e-14, atol=1e-11)
    assert structure.dofs == chain.dofs


@pytest.mark.parametrize("kind", ["npz", "mat", "mat4", "mat_compressed", "mat73"])
def test_names_in_the_file(chain, tmp_path, kind):
    assert ss.read_structure(chain.save(tmp_path, kind)).dofs == chain.dofs


@pytest.mark.parametrize("version", ["mat", "mat73"])
def test_matrices_in_a_struct(chain, tmp_path, version):
    """rom.M and rom.inner.K; the names of rows in rom.dofs."""
    path = tmp_path / "rom.mat"
    if version == "mat":
        names = np.array(chain.dofs, dtype=object)
        io.savemat(path, {"rom": {"M": chain.M, "inner": {"K": sparse.csc_array(chain.K)}, "dofs": names}, "other": 3.0})
    else:
        shutil.copy(chain.save(tmp_path, "mat73"), path)
        with h5py.File(path, "r+") as file:
            for name, target in (("M", "rom/M"), ("K", "rom/inner/K"), ("dofs", "rom/dofs")):
                file.move(name, target)
            del file["C"]
    model = ss.read_model(path, variables={"M": "rom.M", "K": "rom.inner.K"})
    np.testing.assert_array_equal(model.M.toarray(), chain.M)
    np.testing.assert_allclose(model.K.toarray(), chain.K, rtol=1e-15)
    assert (model.dofs, model.C) == (chain.dofs, None)


def test_a_text_file_of_octave_is_refused_as_such(tmp_path):
    (tmp_path / "rom.mat").write_text("# Created by Octave 8.4.0\n# name: K\n# type: scalar\n1\n")
    with pytest.raises(
        InputError, match=r"rom.mat: .* must be binary, but this is a text file of Octave. Save it again: save -v7"
    ):
        ss.read_model(tmp_path / "rom.mat")


def test_null_damping_of_one_row_is_none(tmp_path):
    """Nastran's EXTSEOUT writes a 1×1 null matrix where there is no damping; K4 is structural damping."""
    rows = {"KAA": np.eye(3), "MAA": np.eye(3), "BXX": np.zeros((1, 1)), "K4XX": np.zeros((1, 1))}
    np.savez(tmp_path / "a.npz", **rows)
    model = ss.read_model(tmp_path / "a.npz")
    assert (model.C, model.notes) == (None, ())
    np.savez(tmp_path / "a.npz", **rows | {"K4XX": 0.1 * np.eye(3)})
    assert ss.read_model(tmp_path / "a.npz").notes == ("K4XX, structural damping of the file, is not used.",)
    np.savez(tmp_path / "a.npz", **rows | {"BXX": np.ones((1, 1))})
    with pytest.raises(InputError, match=r"C must have the shape of M"):
        ss.read_model(tmp_path / "a.npz")


def test_rows_without_names_are_numbered(chain, tmp_path):
    assert ss.read_structure(chain.save(tmp_path, "matrix_market")).dofs == tuple(f"{row}.q" for row in range(1, 7))


def test_units_are_those_of_the_same_model_in_si(chain, tmp_path):
    """In mm, t, s: mass / 1e3, stiffness (N/mm) / 1e3, damping / 1e3; a row of a rotation is 1e3 (mm) times larger."""
    lever = np.diag([1, 1, 1, 1, 1, 1e3])
    names = (*chain.dofs[:5], "6.rz")
    scaled = {name: lever @ getattr(chain, name) @ lever / 1e3 for name in "MKC"}
    np.savez(
        tmp_path / "mm.npz", **scaled, dofs=names, nodes=[[k, 100.0 * k, 40.0 * (k % 2), 40.0 * (k % 3)] for k in range(1, 7)]
    )
    model = ss.read_model(tmp_path / "mm.npz", units="mm-t-s")
    for name in "MKC":
        np.testing.assert_allclose(getattr(model, name).toarray(), getattr(chain, name), rtol=1e-13)
    assert model.nodes["3"] == pytest.approx((0.3, 0.04, 0.0))


def test_a_mapping_file_names_the_rows(chain, tmp_path):
    lines = [
        "node,direction,x,y,z,set",
        *(f"{10 * k},{'x' if k % 2 else 2},{k},0,0,{'odd' if k % 2 else ''}" for k in range(1, 7)),
    ]
    (tmp_path / "names.csv").write_text("\n".join(lines))
    model = ss.read_model(chain.save(tmp_path, "matrix_market"), names=tmp_path / "names.csv")
    assert model.dofs[:3] == ("10.x", "20.y", "30.x")
    assert model.sets == {"odd": ("10", "30", "50")}
    assert model.nodes["20"] == (2.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("node,direction\n1,x\n", "must have 6 entries, but is 1"),
        ("node,direction\n" + "1,w\n" * 6, "must be x, y, z, rx, ry, rz or 1 to 6, or 0 for a mode or scalar point, but is 'w'"),
        ("node,direction\n" + ",x\n" * 6, "names.csv, node, must be given in each line"),
        ("node,direction,x\n" + "1,x,far\n" * 6, "must be finite numbers"),
        ("node,direction\n" + "1,x\n" * 6, "must be unique"),
        ("knot,direction\n1,x\n", "must be a known one, but is 'knot'. Did you mean 'node'?"),
        ("node,direction\n1,x,3\n", "must have 2 entries in each line"),
        ("", "must have columns node and direction"),
    ],
)
def test_wrong_mapping_files(chain, tmp_path, text, said):
    (tmp_path / "names.csv").write_text(text)
    with pytest.raises(InputError) as raised:
        ss.read_model(chain.save(tmp_path, "npz"), names=tmp_path / "names.csv")
    assert said in str(raised.value)


def test_matrices_under_other_names(chain, tmp_path):
    np.savez(tmp_path / "a.npz", KELAST=chain.K, MASS=chain.M)
    assert ss.read_structure(tmp_path / "a.npz", variables={"K": "KELAST"}).K[0, 0] == chain.K[0, 0]
    with pytest.raises(Faults, match=r"matrix K must be in the file, but is missing\. Known: KELAST, MASS"):
        ss.read_structure(tmp_path / "a.npz")
    with pytest.raises(InputError, match="variables must name M, K or C, but is 'Q'"):
        ss.read_structure(tmp_path / "a.npz", variables={"Q": "KELAST"})


def test_files_of_the_matrices_by_letter(chain, tmp_path):
    chain.save(tmp_path, "matrix_market")
    files = {"M": tmp_path / "chain_M.mtx", "K": tmp_path / "chain_K.mtx"}
    structure = ss.read_structure(files, dofs=chain.dofs)
    np.testing.assert_allclose(structure.K, chain.K)
    assert structure.C is None
    with pytest.raises(InputError, match="The file of M must be given"):
        ss.read_structure({"K": files["K"]})


def test_a_single_matrix_needs_its_counterpart(chain, tmp_path):
    chain.save(tmp_path, "matrix_market")
    (tmp_path / "chain_K.mtx").rename(tmp_path / "one.mtx")
    with pytest.raises(InputError, match=r"must be one of a pair of files.* model = { M = "):
        ss.read_structure(tmp_path / "one.mtx")
    (tmp_path / "one.mtx").rename(tmp_path / "other_K.mtx")
    with pytest.raises(InputError, match="The file of M must be given"):
        ss.read_structure(tmp_path / "other_K.mtx")


def test_both_matrices_from_one_file(chain, tmp_path):
    """The files of the letters may be one; its matrices are distinguished by their names."""
    path = chain.save(tmp_path, "npz")
    structure = ss.read_structure({"M": path, "K": path})
    np.testing.assert_array_equal(structure.K, chain.K)
    np.testing.assert_array_equal(structure.M, chain.M)
    assert structure.C is None
    np.savez(tmp_path / "named.npz", KELAST=chain.K, KGEOM=0 * chain.K, MASS=chain.M)
    files = {"M": path, "K": tmp_path / "named.npz"}
    np.testing.assert_array_equal(ss.read_structure(files, variables={"K": "KELAST"}).K, chain.K)
    with pytest.raises(InputError, match=r"named.npz: matrix K must be in the file, but is missing\. Known: KELAST"):
        ss.read_structure(files)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"units": 5}, "The system of units must be a known one, but is 5"),
        ({"variables": {"K": 3}}, "variables, K must be a name, but is 3"),
        ({"units": ["SI"]}, "The system of units must be a known one"),
        ({"variables": "K"}, "variables must be a table such as"),
        ({"keep": "12"}, "keep must be a tuple or list"),
        ({"keep": {"a": 12.0}}, r"keep, a: A place must be a node, a set or coordinates \(x, y, z\), but is 12.0"),
        ({"keep": {"a": ("x", 0, 0)}}, "keep, a: Coordinates must hold numbers"),
        ({"dofs": 17}, "dofs must be a tuple or list"),
        ({"dofs": range(6)}, "A name in dofs must be a text, but is 0"),
        ({"names": 5}, "The file of names must be the path of a file, but is 5"),
        ({"damping": 0.02, "own_damping": False}, "damping must be a rule, ModalDamping"),
        ({"own_damping": "no"}, "own_damping must be True or False, but is 'no'"),
    ],
)
def test_arguments_of_a_wrong_kind(chain, tmp_path, arguments, said):
    path = chain.save(tmp_path, "npz")
    with pytest.raises(InputError, match=said):
        ss.read_structure(path, **arguments)
    with pytest.raises(InputError, match="A table of files must name M, K or C, but is 'X'"):
        ss.read_structure({"X": path, "M": path, "K": path})


@pytest.mark.parametrize("path", [None, 17, {"M": 5, "K": "k.mtx"}])
def test_what_is_no_path(path):
    with pytest.raises(InputError, match="must be the path of a file"):
        ss.read_structure(path)


def test_files_that_the_system_refuses(chain, tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"A model file must be readable, but is 'a{300}.mat'. \(File name too long\)"):
        ss.read_structure("a" * 300 + ".mat")
    path = chain.save(tmp_path, "abaqus")

    def locked(self):
        raise PermissionError(13, "Permission denied", "locked")

    monkeypatch.setattr(Path, "read_bytes", locked)
    with pytest.raises(InputError, match=r"must be readable, but is 'locked'. \(Permission denied\)"):
        ss.read_structure(path)


def test_nodes_numbered_by_numpy(chain, tmp_path):
    np.savez(tmp_path / "a.npz", M=chain.M, K=chain.K, dofs=[f"{node}.x" for node in range(1, 7)])
    assert ss.read_structure(tmp_path / "a.npz", keep={"tip": np.int64(6)}, modes=1).dofs == ("tip.x", "mode/1.q")
    assert ss.read_structure(tmp_path / "a.npz", keep=np.array([1, 6]), modes=0).dofs == ("1.x", "6.x")


@pytest.mark.parametrize(("name", "tool"), [("blade.sti.gz", "gunzip"), ("model.zip", "unzip"), ("model.npz.XZ", "unxz")])
def test_a_packed_model_says_how_to_unpack_it(tmp_path, name, tool):
    (tmp_path / name).write_bytes(b"")
    with pytest.raises(InputError, match=f"must be unpacked, but is '{name}'. Unpack it first, with {tool}"):
        ss.read_structure(tmp_path / name)


def test_a_counterpart_and_a_table_that_are_still_packed(chain, tmp_path):
    path = chain.save(tmp_path, "matrix_market")
    (tmp_path / "chain_M.mtx").rename(tmp_path / "chain_M.mtx.gz")
    with pytest.raises(InputError, match=r"must be unpacked, but is 'chain_M\.mtx\.gz'\. Unpack it first, with gunzip"):
        ss.read_structure(path)
    (tmp_path / "rows.csv.gz").write_bytes(b"")
    with pytest.raises(InputError, match=r"The file of names must be unpacked, but is 'rows\.csv\.gz'"):
        ss.read_structure(chain.save(tmp_path, "npz"), names=tmp_path / "rows.csv.gz")


def test_a_run_of_calculix_that_is_still_packed(tmp_path):
    for name in ("blade.inp", "blade.sti.gz"):
        (tmp_path / name).write_bytes(b"")
    with pytest.raises(InputError, match=r"must have blade\.sti beside blade\.inp.* Unpack it: gunzip blade\.sti\.gz"):
        ss.read_structure(tmp_path / "blade.inp")


def test_an_unknown_ending_and_units(tmp_path):
    with pytest.raises(InputError, match=r"must be a file that exists, but is '.*nofile'"):
        ss.read_structure(tmp_path / "nofile")
    (tmp_path / "model.doc").write_text("")
    with pytest.raises(InputError, match=r"must be a file ending in .*\.npz.*, but is 'model.doc'"):
        ss.read_structure(tmp_path / "model.doc")
    np.savez(tmp_path / "a.npz", M=np.eye(1), K=np.eye(1))
    with pytest.raises(InputError, match="Did you mean 'mm-t-s'"):
        ss.read_structure(tmp_path / "a.npz", units="mm-t")


def test_names_of_abaqus_and_nastran(chain, tmp_path):
    for kind in ("abaqus", "abaqus_substructure", "dmig_large", "dmig_free"):
        assert ss.read_structure(chain.save(tmp_path, kind)).dofs == chain.dofs


def test_dmig_in_small_fields(chain, tmp_path):
    """Three digits fit into eight characters; Nastran leaves out the E."""
    (tmp_path / "small.pch").write_text(nastran_files.dmig({"K2": chain.K, "M2": chain.M}, "small"))
    structure = ss.read_structure(tmp_path / "small.pch", variables={"K": "K2", "M": "M2"})
    np.testing.assert_allclose(structure.K, chain.K, rtol=6e-3)
    np.testing.assert_allclose(structure.M, chain.M, rtol=6e-3)


def test_a_mass_with_fewer_rows_than_the_stiffness(chain, tmp_path):
    """Abaqus leaves out what is zero: rows are put together by their names."""
    chain.save(tmp_path, "abaqus")
    lines = (tmp_path / "job_MASS1.mtx").read_text().splitlines()
    (tmp_path / "job_MASS1.mtx").write_text("".join(f"{line}\n" for line in lines if not line.startswith("4,")))
    model = ss.read_model(tmp_path / "job_STIF1.mtx")
    expected = chain.M.copy()
    expected[3, 3] = 0.0
    np.testing.assert_allclose(model.M.toarray(), expected)
    np.testing.assert_allclose(model.K.toarray(), chain.K)


def test_coordinates_and_sets_of_an_abaqus_deck(chain, tmp_path):
    nodes = "\n".join(f"{k}, {10 * k}., 0., {k % 3}" for k in range(1, 7))
    sets = "*Nset, nset=Ends\n1, 6\n*Nset, nset=even, generate\n2, 6, 2\n*NSET, NSET=ALL\nENDS, EVEN"
    (tmp_path / "job.inp").write_text(f"*Heading\n*Node\n{nodes}\n{sets}\n*Step\n")
    model = ss.read_model(chain.save(tmp_path, "abaqus"), units="mm-t-s")
    assert model.nodes["2"] == pytest.approx((0.02, 0.0, 0.002))
    assert model.sets == {"ENDS": ("1", "6"), "EVEN": ("2", "4", "6"), "ALL": ("1", "6", "2", "4")}


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind.startswith("op4")])
def test_truncated_output4(chain, tmp_path, kind):
    path = chain.save(tmp_path, kind)
    content = path.read_bytes()
    path.write_bytes(content[: 2 * len(content) // 3])
    with pytest.raises(InputError):
        ss.read_model(path)


def test_an_empty_and_a_wrong_dmig(tmp_path):
    for text, said in (
        ("$ nothing\n", "must hold square DMIG entries"),
        ("DMIG,KAA,0,7,2\n", "must be 1 .square., 2, 9 .rectangular. or 6 .symmetric., but is 7"),
        ("DMIG,KAA,0,6,9\n", "TIN of KAA must be 1, 2 .real, single or double., 3 or 4 .complex., but is 9"),
        ("DMIG,KAA,0,6,2\nDMIG,KAA,1,1,,-1,1,2.0\n", "The number of a grid point must be positive, but is -1"),
        ("GRID,-3,,0.,0.,0.\n", "The number of a grid point must be positive, but is -3"),
        ("DMIG,KAA,0,6,2\nDMIG,KAA,1,1,,1,1\n", "A term of DMIG KAA must have a grid point and a value, but is .*was cut short"),
        ("DMIG,KAA,0,6,2\nDMIG,KAA,1,1,,1,1,2.5", "must end with a whole line, but is 'cut off'"),
        (
            "DMIG,KAA,0,6,2\nDMIG,KAA,1,7,,1,7,2.5\n",
            "The component of a grid point must be 1 to 6, or 0 for scalar points, but is 7",
        ),
        ("DMIG,PAX,0,9,2\n", "must hold square DMIG entries"),
        ("DMIG,KAA,1,1,,1,1,2.0\n", "must begin with its header"),
        ("DMIG,KAA,0,6,2\nDMIG,KAA,x,1,,1,1,2.0\n", "must be a whole number, but is 'x'"),
        ("DMIG,KAA,0,6,2\nDMIG,KAA,1,1,,1,1,2.0.0\n", "must be a number, but is '2.0.0'"),
    ):
        (tmp_path / "wrong.pch").write_text(text)
        with pytest.raises(InputError, match=said):
            ss.read_model(tmp_path / "wrong.pch")


ELEMENT = """**
** ELEMENT NUMBER 11 STEP NUMBER 2 INCREMENT NUMBER 1
*USER ELEMENT, NODES= 2, LINEAR
** ELEMENT NODES
** 101, 102
1, 2
2, 1
*MATRIX,TYPE=STIFFNESS
4.0 ,
1.0 , 5.0
-1.0 , 2.0 , 6.0
*MATRIX,TYPE=MASS
1.0 ,
0.0 , 1.0
0.0 , 0.0 , 1.0
"""


def test_directions_that_change_along_the_nodes_of_a_substructure(tmp_path):
    (tmp_path / "a.mtx").write_text(ELEMENT)
    model = ss.read_model(tmp_path / "a.mtx")
    assert model.dofs == ("101.x", "101.y", "102.x")
    np.testing.assert_array_equal(model.K.toarray(), [[4, 1, -1], [1, 5, 2], [-1, 2, 6]])
    (tmp_path / "a.mtx").write_text(ELEMENT + ELEMENT)
    with pytest.raises(InputError, match="must hold one substructure"):
        ss.read_model(tmp_path / "a.mtx")


@pytest.mark.parametrize(
    ("symmetry", "entries", "message"),
    [
        ("symmetric", "1 1 2e6\n1 2 -1e6\n2 1 -1e6\n2 2 2e6\n", "must store one triangle"),
        ("skew-symmetric", "1 1 2e6\n2 2 2e6\n", "must have no diagonal"),
    ],
)
def test_a_triangle_is_not_counted_twice(symmetry, entries, message, tmp_path):
    head = f"%%MatrixMarket matrix coordinate real {symmetry}\n2 2 {entries.count(chr(10))}\n"
    (tmp_path / "a_K.mtx").write_text(head + entries)
    (tmp_path / "a_M.mtx").write_text("%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n1 1 1\n2 2 1\n")
    with pytest.raises(InputError, match=message):
        ss.read_structure(tmp_path / "a_K.mtx")


def test_a_model_without_rows(tmp_path):
    np.savez(tmp_path / "none.npz", M=np.zeros((0, 0)), K=np.zeros((0, 0)))
    with pytest.raises(InputError, match="must have rows"):
        ss.read_structure(tmp_path / "none.npz")
