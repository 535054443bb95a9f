"""Every redundancy of a file is used: what contradicts itself is refused, or at least not read as another model in silence."""

import subprocess
import sys
from pathlib import Path
from random import Random
from types import SimpleNamespace

import numpy as np
import pytest
from readers.conftest import KINDS
from readers.fuzzing import peak_memory
from readers.redundancy import CLASSES, Sound, counts, forked
from readers.test_hostile import archive, bomb
from scipy import sparse

import stickslip as ss
from stickslip.model.readers import ansys, matrix_files, nastran_deck, nastran_op4, process
from stickslip.support.checks import InputError

pytestmark = [pytest.mark.filterwarnings("ignore::UserWarning"), pytest.mark.filterwarnings("ignore::DeprecationWarning")]

PAGE = Path(__file__).parents[2] / "docs" / "models.md"
FORMATS = {
    "NumPy archive": ("npz", "scipy"),
    "MATLAB 5 to 7": ("mat", "mat_compressed"),
    "MATLAB, HDF5": ("mat73",),
    "Matrix Market": ("matrix_market", "matrix_market_dense"),
    "Harwell-Boeing": ("harwell_boeing", "rutherford_boeing"),
    "CalculiX": ("calculix",),
    "Nastran OUTPUT4, text": tuple(kind for kind in KINDS if kind.startswith("op4_text")),
    "Nastran OUTPUT4, binary": tuple(kind for kind in KINDS if kind.startswith("op4_binary")),
    "Nastran DMIG": ("dmig_large", "dmig_free"),
    "Abaqus": ("abaqus", "abaqus_coordinate", "abaqus_substructure"),
}
QUICKLY, THOROUGHLY = 40, 200
"""Faults of each class and format."""


@pytest.fixture
def split_off(monkeypatch):
    """Processes that read are split off this one."""
    own = SimpleNamespace(run=forked, TimeoutExpired=subprocess.TimeoutExpired)
    monkeypatch.setattr(process, "subprocess", own)


def answers(folder, name, number):
    """How often faults of each class got each answer."""
    kinds = FORMATS[name]
    sound = [Sound(folder / kind, kind) for kind in kinds]
    return {
        group: sum(
            (counts(one, group, Random(f"{one.kind} {group}"), -(-number // len(kinds))) for one in sound),
            start=counts(sound[0], group, Random(0), 0),
        )
        for group in CLASSES
    }


LONG = ("MATLAB 5 to 7", "MATLAB, HDF5")


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] if name in LONG else []) for name in FORMATS])
def test_no_fault_that_shows_is_read_as_another_model(name, tmp_path, split_off):
    found = answers(tmp_path, name, QUICKLY)
    assert {group: answer["seen"] for group, answer in found.items()} == dict.fromkeys(CLASSES, 0)
    assert all(answer["refused"] for answer in found.values())


@pytest.mark.nightly
@pytest.mark.parametrize("name", FORMATS)
def test_the_table_of_the_page(name, tmp_path, split_off):
    """A row of docs/models.md: of the faults of each class the refused, those that change nothing, and other models."""
    assert row(name, answers(tmp_path, name, THOROUGHLY)) in PAGE.read_text(encoding="utf-8").splitlines()


def row(name, found):
    cells = []
    for answer in found.values():
        other = answer["said"] + answer["unseen"] + answer["seen"]
        cells.append(f"{answer['refused']} / {answer['same']} / {other}")
    return f"| {name} | {' | '.join(cells)} | {sum(answer['seen'] for answer in found.values())} |"


HEAD = "%%MatrixMarket matrix"
MASS = f"{HEAD} coordinate real symmetric\n2 2 2\n1 1 1.0\n2 2 1.0\n"


def stiffness(folder, content):
    """The stiffness of two rows in Matrix Market."""
    (folder / "a_M.mtx").write_text(MASS)
    (folder / "a_K.mtx").write_text(content)
    return ss.read_model(folder / "a_K.mtx").K.toarray()


@pytest.mark.parametrize("writing", ["2000.5", "2.0005D3", "2.0005d+03", "2.0005+3", "20005.E-1", "+2000.5", "2.0005E3"])
def test_numbers_as_fortran_writes_them(writing, tmp_path):
    found = stiffness(tmp_path, f"{HEAD} coordinate real symmetric\n2 2 2\n1 1 {writing}\n2 2 1.0\n")
    np.testing.assert_array_equal(found, np.diag([2000.5, 1.0]))
    found = stiffness(tmp_path, f"{HEAD} array real symmetric\n2 2\n{writing}\n0.0\n1.0\n")
    np.testing.assert_array_equal(found, np.diag([2000.5, 1.0]))


@pytest.mark.parametrize(
    "writing", ["2000,5", "2OO0.5", "20_00.5", "20 00.5", "2'000.5", "0x7d0", "2000.5*", "2000.5.1", "2000.5e", ""]
)
def test_what_is_no_number(writing, tmp_path):
    with pytest.raises(InputError, match="a_K"):
        stiffness(tmp_path, f"{HEAD} coordinate real symmetric\n2 2 2\n1 1 {writing}\n2 2 1.0\n")
    with pytest.raises(InputError, match="a_K"):
        stiffness(tmp_path, f"{HEAD} array real symmetric\n2 2\n{writing}\n0.0\n1.0\n")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("coordinate integer symmetric\n2 2 2\n1 1 2000.5\n2 2 1\n", "must be whole numbers, as its first line says"),
        ("array real general\n2 3\n1.0\n0.0\n0.0\n1.0\n", "must hold 6 lines of 1 number, as it says"),
        ("array real general\n2 2\n1.0\n0.0\n0.0\n", "must hold 4 lines"),
        ("coordinate real symmetric\n2 2 2\n1 1 1.0\n2 2 1.0\n2 1 0.5\n", "must hold 2 lines of 3 numbers"),
        ("coordinate real symmetric\n2 2 2\n1 1 1.0\n2 2 1.0 0.0\n", "must hold as many numbers as the first"),
        ("coordinate real symmetric\n2 2\n1 1 1.0\n2 2 1.0\n", "must hold the numbers of rows, columns and entries"),
        ("coordinate real symmetric\n2 3 2\n1 1 1.0\n2 2 1.0\n", "must be square"),
        ("coordinate real symmetric\n2 2 2\n1 1 1.0\n3 2 1.0\n", "must be whole numbers from 1 up to 2"),
        ("coordinate real symmetric\n2 2 2\n1 1 1.0\n1.5 2 1.0\n", "must be whole numbers from 1 up to 2"),
    ],
)
def test_counts_and_types_of_matrix_market(content, said, tmp_path):
    with pytest.raises(InputError, match=said):
        stiffness(tmp_path, f"{HEAD} {content}")


@pytest.mark.parametrize(
    ("symmetry", "values", "right"),
    [
        ("symmetric", "1\n2\n3\n", [[1, 2], [2, 3]]),
        ("skew-symmetric", "2\n", [[0, -2], [2, 0]]),
        ("general", "1\n2\n3\n4\n", [[1, 3], [2, 4]]),
    ],
)
def test_arrays_store_columns(symmetry, values, right, tmp_path):
    (tmp_path / "a.mtx").write_text(f"{HEAD} array integer {symmetry}\n% a comment\n\n2 2\n{values}")
    np.testing.assert_array_equal(matrix_files.read_matrix_market(tmp_path / "a.mtx").matrices[""], right)
    (tmp_path / "a.mtx").write_text(f"{HEAD} array complex hermitian\n2 2\n1 0\n2 5\n3 0\n")
    np.testing.assert_array_equal(matrix_files.read_matrix_market(tmp_path / "a.mtx").matrices[""], [[1, 2 - 5j], [2 + 5j, 3]])


def op4(columns="", header="       2       2       6       2KAA     1P,3E23.16"):
    return f"{header}\n{columns}       3       1       1\n 1.4142135623730951E+00\n"


def column(number, length, *values):
    return f"{number:8d}{1:8d}{length:8d}\n" + "".join(f"{value:23.16E}" for value in values) + "\n"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (op4(column(1, 3, 1.0, 2.0)), "must have 2 words an entry, but is 3"),
        (op4(column(1, 2, 1.0, 2.0) + column(1, 2, 1.0, 2.0)), "must have a number from 2 to 3, but is 1"),
        (op4(column(1, 2, 1.0, 2.0) + column(2, 2, 3.0, 1.0)), "KAA, of symmetric form, must be symmetric"),
        (op4(column(1, 2, 1.0, 2.0) + column(4, 2, 2.0, 1.0)), "must have a number from 2 to 3, but is 4"),
        (op4(header="       2       2       6       7KAA     1P,3E23.16"), "The type of KAA must lie between 1 and 4"),
        (op4(header="       2       2      66       2KAA     1P,3E23.16"), "The form of KAA must lie between 1 and 15"),
        (op4(header="       2       2       6       2K?A     1P,3E23.16"), "must be one to eight letters or digits"),
        (op4(column(1, 2, 1.0, 2.0).replace("2.0000", "2.O000")), "must hold as many numbers"),
        (op4(column(1, 2, 1.0, 0.0)) + op4(), "Matrix KAA must occur once in the file"),
    ],
)
def test_lengths_and_order_of_output4(content, said, tmp_path):
    (tmp_path / "a.op4").write_text(content)
    with pytest.raises(InputError, match=said):
        ss.read_model(tmp_path / "a.op4")


def test_both_lengths_and_widths_of_output4(tmp_path):
    """Nastran counts numbers in dense columns of text, other writers words; |I16 has wide fields in its header, lines may too."""
    for length, header, wide in (
        (2, "{:8d}{:8d}", False),
        (4, "{:8d}{:8d}", False),
        (2, "{:16d}{:16d}", False),
        (2, "{:16d}{:16d}", True),
    ):
        first = header.format(2, 2) + f"{6:8d}{2:8d}KAA     1P,3E23.16|I16"
        lines = op4(column(1, length, 2.0, -1.0) + column(2, length, -1.0, 2.0), first)
        if wide:
            lines = "\n".join(
                "".join(f"{int(word):16d}" for word in line.split()) if "." not in line else line for line in lines.split("\n")
            )
        (tmp_path / "a.op4").write_text(lines)
        np.testing.assert_array_equal(nastran_op4.read(tmp_path / "a.op4").matrices["KAA"].toarray(), [[2, -1], [-1, 2]])


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        (",2,1,-115974.0", "2,1,-115974.0", "must begin with its name, but is '2'"),
        (",2,1,-115974.0", ",2,1,-115974.0\n\x1a", "must begin with its name"),
        ("DMIG,KAA,2,1,,2,1", "DMIG,KAA,2,1,2,1", "must be blank"),
        (",2,1,-115974.0", ",2,1,-115974.0,1.0", "must be real, as its header says"),
        (",2,1,-115974.0", ",2,1,-1159740", "must have a decimal point"),
        (",2,1,-115974.0", ",2,,-115974.0", "must be a grid point with components or a scalar point without"),
        ("DMIG,KAA,0,6,2,0", "DMIG,KAA,0,6,2,0,1", "POLAR of KAA must be 0 or blank"),
        ("DMIG,KAA,0", "DMIG,K?A,0", "must be a letter and up to seven"),
    ],
)
def test_lost_commas_and_stray_lines_of_dmig(before, after, said, chain, tmp_path):
    path = chain.save(tmp_path, "dmig_free")
    assert before in path.read_text()
    path.write_text(path.read_text().replace(before, after, 1))
    with pytest.raises(InputError, match=said):
        nastran_deck.read(path)


def test_columns_that_a_header_of_dmig_names_and_the_file_lacks(chain, tmp_path):
    path = chain.save(tmp_path, "dmig_free")
    path.write_text(path.read_text().replace("DMIG,KAA,6,1,,6,1,294737.0\n", ""))
    assert "DMIG KAA holds 5 columns of the 6 that its header names." in nastran_deck.read(path).notes


def test_places_of_stiffness_and_mass_of_calculix(tmp_path):
    path = Sound(tmp_path / "calculix", "calculix").path
    mass = path.with_suffix(".mas")
    mass.write_text(mass.read_text().replace("2 1 ", "3 1 ", 1))
    with pytest.raises(InputError, match=r"Line 2 of chain.mas must have the same row and column as in chain.sti"):
        ss.read_model(path)


def test_starts_of_columns_that_fall_do_not_end_the_process(tmp_path):
    """SciPy takes a matrix for empty by its last start, does not look at the others, and writes beyond its memory."""
    for name in "MK":
        sparse.save_npz(tmp_path / f"a_{name}.npz", sparse.csr_array(np.eye(50)))
    with np.load(tmp_path / "a_K.npz") as stored:
        parts = dict(stored)
    parts["indptr"][-1] = 0
    np.savez(tmp_path / "a_K.npz", **parts)
    code = f"import stickslip as ss; ss.read_model({str(tmp_path / 'a_K.npz')!r})"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "must have starts of columns that rise to the number of its values" in ended.stderr


def test_a_header_that_leaves_bytes_over(tmp_path):
    archive(tmp_path / "a.npz", (2, 3))
    with pytest.raises(InputError, match="must fill the 64 bytes behind its header"):
        ss.read_model(tmp_path / "a.npz")


def test_masses_that_no_body_has(chain, tmp_path):
    chain.M[0, 1] = chain.M[1, 0] = 0.2
    with pytest.raises(InputError, match=r"M\[0, 1\] must not exceed what the diagonal of its row and column allows"):
        ss.read_model(chain.save(tmp_path, "npz"))


def test_what_is_not_used_is_said(chain, tmp_path):
    np.savez(tmp_path / "a.npz", M=chain.M, K=chain.K, D=chain.C, dofs=chain.dofs)
    assert ss.read_model(tmp_path / "a.npz").notes == ("Arrays as long as the model that are not used: D.",)
    chain.K[5] = chain.K[:, 5] = 0.0
    chain.save(tmp_path, "npz")
    assert ss.read_model(tmp_path / "chain.npz").notes == ("K has no entry on the diagonal of 1 row: 6.x.",)


def test_a_busy_machine_is_no_damaged_file(chain, tmp_path, monkeypatch):
    monkeypatch.setattr(process, "SECONDS", 1e-3)
    with pytest.raises(InputError, match="The file is damaged, or the machine is busy: try again when it is not"):
        ss.read_model(chain.save(tmp_path, "mat"))


READER = """
import numpy as np
from scipy import sparse

class Full:
    def load_km(self, as_sparse, sort):
        if BROKEN:
            raise SystemError("out of bounds")
        K = sparse.csc_array([[2.0, -1.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]])
        return np.array([[4, 0], [5, 1], [6, 2]]), K, sparse.eye_array(3, format="csc")

def read_binary(path):
    return Full()
"""


@pytest.mark.parametrize("broken", [False, True])
def test_full_files_of_ansys_are_read_in_a_process_of_their_own(broken, tmp_path, monkeypatch):
    """With a reader that stands for that of Ansys' files."""
    package = tmp_path / "ansys" / "mapdl" / "reader"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text(READER.replace("BROKEN", str(broken)))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(ansys, "installed", lambda: True)
    (tmp_path / "a.full").write_bytes(b"")
    if broken:
        with pytest.raises(InputError, match=r"The file is damaged \(out of bounds\)"):
            ss.read_model(tmp_path / "a.full")
    else:
        model = ss.read_model(tmp_path / "a.full")
        np.testing.assert_array_equal(model.K.toarray(), [[2.0, -1.0], [-1.0, 2.0]])
        assert (model.dofs, model.notes) == (("4.x", "5.y"), ("1 constrained rows of the file are left out.",))
        assert "ansys.mapdl.reader" not in sys.modules


def test_a_case_that_unpacks_to_far_more_is_computed_again(tmp_path, monkeypatch):
    """So is one whose header claims more than is there; neither takes memory."""
    kept = ss.CheckpointFolder(tmp_path)
    kept.save("a", {"values": np.ones(3)})
    np.testing.assert_array_equal(kept.load("a")["values"], np.ones(3))
    (file,) = tmp_path.glob("*.npz")
    bomb(file)
    monkeypatch.setattr("stickslip.model.readers.numbers.memory", lambda: 2**24)
    before = peak_memory()
    assert kept.load("a") is None
    archive(file, (10**9, 10))
    assert kept.load("a") is None
    assert peak_memory() - before < 50.0


def test_floating_point_numbers_of_a_kind_of_their_own(chain, tmp_path):
    """An exponent that counts from 1024 halves every number."""
    h5py = pytest.importorskip("h5py")
    path = chain.save(tmp_path, "mat73")
    kind = h5py.h5t.IEEE_F64LE.copy()
    kind.set_ebias(1024)
    with h5py.File(path, "r+") as file:
        del file["C"]
        h5py.h5d.create(file.id, b"C", kind, h5py.h5s.create_simple((6, 6)))
    with pytest.raises(InputError, match="C must hold usual floating-point numbers"):
        ss.read_model(path)
