"""Files that say a thing twice: entries, coordinates, damping. What contradicts itself is refused; what adds up is said."""

import numpy as np
import pytest
from readers import nastran_files
from scipy import io, sparse

import stickslip as ss
from stickslip.model.readers import model
from stickslip.study import job
from stickslip.support.checks import InputError


def assert_refused(path, said, **arguments):
    with pytest.raises(InputError, match=said):
        ss.read_structure(path, **arguments)


def test_repeated_entries_of_matrix_market_add_up_and_are_said(chain, tmp_path):
    """As SciPy writes a matrix in coordinates that was put together of elements."""
    chain.save(tmp_path, "matrix_market")
    halves = sparse.coo_array(np.tril(chain.K))
    twice = sparse.coo_array((np.tile(halves.data / 2, 2), tuple(np.tile(row, 2) for row in halves.coords)), (6, 6))
    head = f"%%MatrixMarket matrix coordinate real symmetric\n6 6 {twice.nnz}\n"
    lines = [f"{i + 1} {j + 1} {value!r}" for i, j, value in zip(*twice.coords, twice.data.tolist(), strict=True)]
    (tmp_path / "chain_K.mtx").write_text(head + "\n".join(lines))
    model = ss.read_model(tmp_path / "chain_K.mtx")
    np.testing.assert_allclose(model.K.toarray(), chain.K)
    assert model.notes == (f"chain_K.mtx repeats places of entries {halves.nnz} times: the entries of one place are added up.",)
    io.mmwrite(tmp_path / "chain_K.mtx", sparse.coo_array(chain.K), symmetry="symmetric", precision=17)
    assert ss.read_model(tmp_path / "chain_K.mtx").notes == ()


def test_repeated_entries_of_other_formats_are_refused(chain, tmp_path):
    path = chain.save(tmp_path, "abaqus")
    path.write_text(path.read_text() + "2,1, 1,1, 5.0\n")
    assert_refused(path, "job_STIF1.mtx must hold each entry once, but is 'row 2, column 1 more than once'")
    (tmp_path / "a.pch").write_text(
        nastran_files.dmig(chain._named, "large") + "DMIG    KAA     1       1               1       1       2.0\n"
    )
    assert_refused(tmp_path / "a.pch", "DMIG KAA must hold each entry once, but is '1.x, 1.x more than once'")
    (tmp_path / "a.pch").write_text(
        nastran_files.dmig(chain._named, "large") + "DMIG    KAA     2       1               1       1       2.0\n"
    )
    assert_refused(tmp_path / "a.pch", "must hold each entry once, but is 'row 2, column 1 and its mirror image'")


def test_a_deck_without_nodes_and_nodes_at_one_point_are_said(chain, tmp_path):
    path = chain.save(tmp_path, "abaqus")
    (tmp_path / "job.inp").write_text("")
    assert "job.inp holds no nodes." in ss.read_model(path).notes
    (tmp_path / "job.inp").write_text("*NODE\n" + "".join(f"{k}, 1.0, 2.0, 3.0\n" for k in (1, 2, 3)))
    (one,) = [line for line in model.lines(model.describe(ss.read_model(path))) if "lie at one point" in line]
    assert "All 3 nodes" in one


def test_two_headers_of_a_dmig(chain, tmp_path):
    (tmp_path / "a.pch").write_text(2 * nastran_files.dmig(chain._named, "large"))
    assert_refused(tmp_path / "a.pch", "DMIG KAA must have one header")


def test_rectangular_dmig_is_left_out(chain, tmp_path):
    """EXTSEOUT punches the loads of a superelement beside its matrices, with IFO 9; scalar points have no component."""
    head = "DMIG    PAX            0       9       2       0                       1\n"
    loads = head + "DMIG    PAX     1                       7               1.0\n"
    (tmp_path / "a.pch").write_text(nastran_files.dmig(chain._named, "large") + loads)
    model = ss.read_model(tmp_path / "a.pch")
    assert model.dofs == chain.dofs
    assert model.notes == ("Rectangular matrices of the file are left out: PAX.",)
    (tmp_path / "b.pch").write_text("DMIG,KAA,0,6,2\nDMIG,KAA,7,,,7,,2.0\nDMIG,MAA,0,6,2\nDMIG,MAA,7,0,,7,0,1.0\n")
    assert ss.read_model(tmp_path / "b.pch").dofs == ("7.q0",)


@pytest.mark.parametrize("rows", [[[1, 0, 0, 0], [1, 0, 0, 1]], [[1, 0, 0, 0], [1, 0, 0, 0], [1, 1, 0, 0]]])
def test_a_node_in_two_places(chain, tmp_path, rows):
    np.savez(tmp_path / "a.npz", M=chain.M, K=chain.K, dofs=chain.dofs, nodes=rows)
    assert_refused(tmp_path / "a.npz", "The coordinates of node 1 must be given once")


def test_a_node_in_two_places_of_other_files(chain, tmp_path):
    path = chain.save(tmp_path, "abaqus")
    (tmp_path / "job.inp").write_text("*NODE\n1, 0.0, 0.0, 0.0\n*NODE\n1, 0.0, 2.0, 0.0\n")
    assert_refused(path, "The coordinates of node 1 must be given once")
    (tmp_path / "a.pch").write_text(nastran_files.dmig(chain._named, "free") + "GRID,1,,0.,0.,0.\nGRID,1,,0.,0.,1.\n")
    assert_refused(tmp_path / "a.pch", "The coordinates of node 1 must be given once")
    lines = ["node,direction,x", *(f"{node},{axis},{node + (axis == 'y')}" for node in (1, 2, 3) for axis in "xy")]
    (tmp_path / "names.csv").write_text("\n".join(lines))
    assert_refused(chain.save(tmp_path, "matrix_market"), "The coordinates of node 1", names=tmp_path / "names.csv")


@pytest.mark.parametrize("node", [1.5, -1.0, 3e9])
def test_ids_of_nodes_that_are_none(chain, tmp_path, node):
    np.savez(tmp_path / "a.npz", M=chain.M, K=chain.K, dofs=chain.dofs, nodes=[[node, 0, 0, 0]])
    assert_refused(tmp_path / "a.npz", "Ids of nodes must be whole numbers from 0")


def test_a_damping_rule_beside_the_c_of_the_file(chain, tmp_path):
    path, rule = chain.save(tmp_path, "npz"), ss.ModalDamping(0.01)
    assert_refused(path, r"chain.npz has a matrix C beside the damping rule\. .* write own_damping = false", damping=rule)
    structure = ss.read_structure(path, damping=rule, own_damping=False)
    assert (structure.C, structure.damping) == (None, rule)
    chain.C[0, 0] = np.nan  # what counts for nothing need not be sound
    chain.save(tmp_path, "npz")
    assert_refused(path, r"C\[0, 0\] must be finite")
    assert ss.read_structure(path, keep=["2"], modes=2, own_damping=False).C is None


STUDY = """
[study]
analysis = "forced_response"
[structure]
model = { M = "chain.npz", K = "chain.npz", C = "chain.npz" }
own_damping = OWN
[damping]
modal = 0.01
[[force]]
direction = "1.x"
amplitude = 1.0
[sweep]
frequency = [10.0, 30.0]
outputs = ["1.x"]
"""


def test_damping_of_a_study(chain, tmp_path):
    chain.save(tmp_path, "npz")
    with pytest.raises(InputError, match=r"\[structure\]: Damping must be given once, but chain.npz has a matrix C"):
        job(STUDY.replace("OWN", "true"), tmp_path, "study")
    structure = job(STUDY.replace("OWN", "false"), tmp_path, "study").sweep.problem.structure
    assert (structure.C, structure.damping) == (None, ss.ModalDamping(0.01, "stuck"))


def test_more_modes_than_rows(chain, tmp_path):
    path = chain.save(tmp_path, "npz")
    assert ss.read_structure(path, keep=["2"]).size == 6  # 30 unless given, of a small model all
    for modes in (6, 10**12, -1, 1.5):
        assert_refused(
            path, f"modes must be a whole number from 0 to 5, the rows that are not kept, but is {modes}", keep=["2"], modes=modes
        )


@pytest.mark.parametrize("size", [1e42, 1e300])
def test_numbers_beyond_all_sizes(chain, tmp_path, size):
    """Their products leave the range of floating point."""
    for name in "MKC":
        sound = {letter: getattr(chain, letter) for letter in "MKC"}
        sound[name] = sound[name] * size
        np.savez(tmp_path / "a.npz", **sound)
        assert_refused(tmp_path / "a.npz", f"{name} must not be larger than 1e\\+40 in size")
    np.savez(tmp_path / "a.npz", M=chain.M, K=chain.K, dofs=chain.dofs, nodes=[[1, 0, 0, size]])
    assert_refused(tmp_path / "a.npz", r"The coordinates of node 1 must not be larger than 1e\+40")


@pytest.mark.parametrize("share", [0.0, 1e-310])
def test_no_mass(chain, tmp_path, share):
    np.savez(tmp_path / "a.npz", M=share * chain.M, K=chain.K)
    assert_refused(tmp_path / "a.npz", "a.npz: M must have mass")
