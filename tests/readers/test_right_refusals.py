"""What is right is read, and what is not says what to give instead: objects of MATLAB, other files of a program, equations."""

import numpy as np
import pytest
from scipy import io
from scipy.io.matlab import MatlabObject

import stickslip as ss
from stickslip.model.readers.ansys_deck import read_archive
from stickslip.model.readers.nastran_deck import read_grid
from stickslip.support.checks import InputError

GRIDS = "".join(f"GRID,{k},,{k - 1}.,0.,0.\n" for k in range(1, 5))


@pytest.mark.parametrize(
    "entry",
    [
        "DEQATN  301     Z(A,B,C,D,E,F,G)=SUM(A,B,C,D,E,F,G)\n",
        "DEQATN  301     Z(A,B,C,D,E,F,G)=SUM(A,B,C,D,E,F,G)+\n        MAX(A,B,C,D,E,F,G,A,B)-\n+       MIN(A,B)\n",
        "DEQATN,301,Z(A,B,C,D,E,F,G)=SUM(A,B,C,D,E,F,G,A,B,C)\n",
        "MONPNT1 WING    Bending, shear, torque, at the root, of the wing, all, of, it\n        WING    0       1.0\n",
    ],
)
@pytest.mark.parametrize("behind", [False, True])
def test_an_equation_or_a_label_with_commas(tmp_path, entry, behind):
    """Its commas part no fields; entries behind it are read, also where blanks stand before them."""
    lines = (entry + GRIDS) if behind else (GRIDS + entry)
    path = tmp_path / "a.bdf"
    path.write_text(lines.replace("GRID,3", "        GRID,3"))
    deck = read_grid(path)
    assert deck.nodes == {str(k): (k - 1.0, 0.0, 0.0) for k in range(1, 5)}
    assert not deck.notes


@pytest.mark.parametrize(("count", "sound"), [("4", True), ("", True), ("0", True), ("5", False), ("3", False)])
def test_a_block_of_nodes_holds_as_many_as_it_says(tmp_path, count, sound):
    rows = "".join(f"{k:8d}{0:8d}{0:8d}" + f"{k - 1.0:20.13E}{0.0:20.13E}{0.0:20.13E}\n" for k in range(1, 5))
    text = f"/PREP7\nNBLOCK,6,SOLID,4,{count}\n(3i8,6e20.13)\n{rows}N,R5.3,LOC,-1,\n"
    if sound:
        assert nodes_of(tmp_path, text) == 4
    else:
        with pytest.raises(InputError, match=rf"The nodes of NBLOCK must be {count}, as the command says, but is 4"):
            nodes_of(tmp_path, text)


def nodes_of(folder, text):
    path = folder / "a.cdb"
    path.write_text(text)
    return len(read_archive(path).nodes)


def stored_object():
    return MatlabObject(np.array([(np.eye(2),)], dtype=[("a", object)]), "ss")


def test_objects_of_matlab_say_what_to_save(tmp_path):
    """A state-space object stands for its matrices in MATLAB alone; beside M and K it does no harm."""
    io.savemat(tmp_path / "a.mat", {"sys": stored_object()})
    io.savemat(tmp_path / "b.mat", {"sys": stored_object(), "M": np.eye(3)})
    for name in ("a.mat", "b.mat"):
        with pytest.raises(InputError, match=r"must hold arrays; objects are not read, but is 'sys'\. Save M and K as arrays"):
            ss.read_model(tmp_path / name)
    with pytest.raises(InputError, match="objects are not read"):
        ss.read_measured_response(tmp_path / "a.mat", force=1.0)
    io.savemat(tmp_path / "c.mat", {"sys": stored_object(), "M": np.eye(3), "K": np.eye(3)})
    assert ss.read_model(tmp_path / "c.mat").size == 3


def test_objects_in_files_of_matlab_7_3(tmp_path):
    """Their numbers look like an array of whole numbers."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "d.mat", "w", userblock_size=512) as file:
        stored = file.create_dataset("K", data=np.zeros((6, 6), dtype="u4"))
        stored.attrs["MATLAB_object_decode"], stored.attrs["MATLAB_class"] = 3, b"ss"
        file["M"] = np.eye(6)
    with pytest.raises(InputError, match="objects are not read, but is 'K'"):
        ss.read_model(tmp_path / "d.mat")


@pytest.mark.parametrize(
    ("name", "said"), [("a.op2", "OUTPUT4"), ("a.sub", "SMAT"), ("a.rst", ".full"), ("a.odb", "MATRIX GENERATE")]
)
def test_other_files_of_a_program_say_what_to_give_instead(tmp_path, name, said):
    (tmp_path / name).write_bytes(b"x")
    with pytest.raises(InputError, match=said):
        ss.read_model(tmp_path / name)
