"""Any bytes give a model or an `InputError`: damaged files of every format, random bytes, headers that claim too much, studies.

`python -m verify hostile_input` does the same for longer and counts.
"""

import struct
import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from readers.conftest import KINDS
from readers.fuzzing import APART, CHANGES, Victims, peak_memory, studies, study_answer, time_limit

from stickslip.model.readers.read import FORMATS, read_model
from stickslip.support.checks import InputError

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

changes = st.lists(st.tuples(st.sampled_from(CHANGES), st.floats(0, 1, exclude_max=True), st.integers(0, 2**32 - 1)), max_size=4)
budget = settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True, database=None)


@pytest.fixture(scope="module")
def victims(tmp_path_factory):
    return Victims(tmp_path_factory.mktemp("victims"))


SLOWLY_READ = {"mat4", "mapping"}
"""In a process of its own, as `mat` is."""


@pytest.mark.parametrize(
    "kind",
    [
        pytest.param(kind, marks=pytest.mark.nightly) if kind in SLOWLY_READ else kind
        for kind in (*KINDS, "calculix", "substructure", "mapping")
    ],
)
def test_damaged_files(victims, kind):
    assert kind == "substructure" or victims.answer(kind, 0, [])  # the substructure has no mass

    @settings(budget, max_examples=3 if kind in APART else 12)
    @given(st.integers(0, 255), changes)
    def damage(which, several):
        victims.answer(kind, which, several)

    damage()


@pytest.mark.parametrize("ending", sorted({ending for form in FORMATS for ending in form.endings} - {".full"}))
def test_random_bytes(tmp_path, ending):
    path = tmp_path / f"a_K{ending}"

    @budget
    @given(st.binary(max_size=300) | st.text(alphabet="0123456789 .,-+Ee\n*$%DMIGabc", max_size=200).map(str.encode))
    def read(content):
        for name in (path, path.with_stem("a_M"), *(path.with_suffix(other) for other in (".sti", ".mas", ".dof"))):
            name.write_bytes(content)
        with time_limit(), pytest.raises(InputError):
            read_model(path)

    read()


def npy(shape):
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".encode().ljust(118) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + bytes(64)


def archive(path, shape):
    with zipfile.ZipFile(path, "w") as file:
        for name in "MK":
            file.writestr(f"{name}.npy", npy(shape))


def bomb(path):
    """Many zeros in a few bytes."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file, file.open("M.npy", "w", force_zip64=True) as member:
        member.write(npy((2**23,))[:-64])
        for _ in range(2**6):
            member.write(bytes(2**20))


def mat(path, rows):
    """A version 5 file whose matrix claims rows x rows doubles."""

    def element(kind, content):
        return struct.pack("<II", kind, len(content)) + content + bytes(-len(content) % 8)

    parts = (
        element(6, struct.pack("<II", 6, 0)),
        element(5, struct.pack("<ii", rows, rows)),
        element(1, b"M"),
        element(9, bytes(64)),
    )
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + element(14, b"".join(parts)))


def hdf5(path):
    """A version 7.3 file whose matrix claims 10^12 entries and stores none."""
    import h5py

    with h5py.File(path, "w") as file:
        file.create_dataset("M", shape=(10**6, 10**6), dtype="f8", chunks=(1000, 1000))
        file["K"] = np.eye(2)


T = 10**12
CLAIMS = {
    "npz": ("a.npz", lambda path: archive(path, (T, T))),
    "npz with negative": ("a.npz", lambda path: archive(path, (-1, T))),
    "mat": ("a.mat", lambda path: mat(path, 2**30)),
    "mat 7.3": ("a.mat", hdf5),
    "matrix market": ("a_K.mtx", f"%%MatrixMarket matrix coordinate real general\n{T} {T} {T}\n1 1 1.0\n"),
    "matrix market, rows": ("a_K.mtx", f"%%MatrixMarket matrix coordinate real general\n{T} {T} 1\n1 1 1.0\n"),
    "matrix market, columns": ("a_K.mtx", f"%%MatrixMarket matrix coordinate real general\n3 {T} 1\n1 1 1.0\n"),
    "matrix market, array": ("a_K.mtx", f"%%MatrixMarket matrix array real symmetric\n{T} {T}\n1.0\n"),
    "harwell-boeing": ("k.rb", f"title\n3 1 1 1\nRSA {T} {T} {T}\n(10I8) (10I8) (3E25.16)\n1 2\n1\n1.0\n"),
    "op4": ("a.op4", f"{-99999999:8d}{99999999:8d}{6:8d}{2:8d}KAA     1P,3E23.16\n{1:8d}{1:8d}{2:8d}\n 1.0\n"),
    "op4, columns": ("a.op4", f"{99999999:8d}{99999999:8d}{6:8d}{2:8d}KAA     1P,3E23.16\n{100000000:8d}{1:8d}{1:8d}\n 1.0\n"),
    "op4, binary": ("a.op4", struct.pack("<7i8s", 24, 2**31 - 1, 2**31 - 1, 6, 2, 0, 0, b"KAA     ")),
    "abaqus": ("a_STIF1.mtx", f"{T} {T} 1.0\n"),
    "abaqus, substructure": ("a.mtx", "*USER ELEMENT, NODES=999999999, LINEAR\n1,2,3\n*MATRIX, TYPE=STIFFNESS\n1.0\n"),
    "dmig": ("a.pch", f"DMIG,KAA,0,6,2\nDMIG,KAA,{T},1,,{T},1,1.0\n"),
}


@pytest.mark.parametrize("case", CLAIMS)
def test_a_header_that_claims_too_much(tmp_path, case):
    name, content = CLAIMS[case]
    path, before = tmp_path / name, peak_memory()
    if callable(content):
        content(path)
    else:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with time_limit(), pytest.raises(InputError):
        read_model(path)
    assert peak_memory() - before < 200.0


def test_an_archive_that_unpacks_to_far_more(tmp_path, monkeypatch):
    bomb(tmp_path / "a.npz")
    monkeypatch.setattr("stickslip.model.readers.numbers.memory", lambda: 2**24)
    before = peak_memory()
    with time_limit(), pytest.raises(InputError, match="half of the memory"):
        read_model(tmp_path / "a.npz")
    assert peak_memory() - before < 200.0


def test_a_large_array_of_hardly_anything(tmp_path):
    """Zeros that unpack to a thousand times their size are refused before they are unpacked, whatever the memory."""
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as file, file.open("M.npy", "w") as member:
        member.write(npy((2**26,))[:-64])
        for _ in range(2**9):
            member.write(bytes(2**20))
    before = peak_memory()
    with time_limit(), pytest.raises(InputError, match=r"must unpack to at most 100 times its size, but is .*sparse\.save_npz"):
        read_model(tmp_path / "a.npz")
    assert peak_memory() - before < 200.0


@pytest.mark.filterwarnings("ignore")
def test_an_array_that_stands_twice(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as file:
        for name in "MKK":
            file.writestr(f"{name}.npy", npy((2, 4)))
    with pytest.raises(InputError, match="must hold each array once"):
        read_model(tmp_path / "a.npz")


def test_damaged_studies(chain, tmp_path):
    chain.save(tmp_path, "npz")
    sound = studies(tmp_path)
    assert all(study_answer(study, tmp_path, []) for study in sound)

    @settings(budget, max_examples=80)
    @given(st.sampled_from(sound), changes)
    def damage(study, several):
        study_answer(study, tmp_path, several)

    damage()


def test_no_pickle_in_a_sparse_archive(tmp_path):
    np.savez(tmp_path / "a_K.npz", format=np.array({"a": 1}, dtype=object), data=np.ones(1), shape=np.ones(2))
    with pytest.raises(InputError, match="never unpickled"):
        read_model(tmp_path / "a_K.npz")
