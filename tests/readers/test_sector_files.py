"""One sector in the files of several programs is one disk: frequencies of every nodal diameter, contacts and damped peak."""

import re

import numpy as np
import pytest
from each import each
from readers import sector_files
from readers.sector_files import REDUCED, WHOLE, SectorFiles, sector, superelement
from scipy import linalg, sparse

import stickslip as ss
from stickslip.study import job
from stickslip.study.templates import write_new

DIGITS = {sector_files.nastran_dmig: 3e-6}
"""DMIG has ten digits; K is far stiffer along the blade than across it."""
EXACT = 1e-9


@pytest.fixture(scope="module")
def whole():
    return sector()


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """The template's study, with a place for the model."""
    file = tmp_path_factory.mktemp("study") / "wheel.toml"
    write_new("bladed_disk", file)
    text = re.sub(r"model = .*\nnames = .*\n", "MODEL\n", file.read_text())
    return re.sub(r"keep = .*\n", 'keep = { tip = "TIP" }\n', text)


def problem(given: SectorFiles, write, folder, study):
    folder.mkdir(exist_ok=True)
    return job(study.replace("MODEL", write(given, folder)), folder, "wheel", whole_disk=True).sweep.problem


def waves(problem):
    """The lowest natural frequencies of all nodal diameters without contacts, behind the six free motions of the wedge."""
    disk = problem.structure
    squares = [linalg.eigh(disk.at(n).K, disk.at(n).M, eigvals_only=True)[6:14] for n in range(disk.sectors // 2 + 1)]
    return np.sqrt(squares) / (2.0 * np.pi)


def peak(problem):
    return ss.forced_response(problem, ss.hertz(1068.0, 1088.0), force=5.0, harmonics=1, samples=24).peaks()


@pytest.fixture(scope="module")
def of_whole(whole, study, tmp_path_factory):
    """The sector, and frequencies and peak of its archive of NumPy."""
    disk = problem(whole, sector_files.numpy, tmp_path_factory.mktemp("whole"), study)
    return whole, waves(disk), peak(disk)


@pytest.fixture(scope="module")
def of_superelement(whole, study, tmp_path_factory):
    """The same of the superelement."""
    given = superelement(whole)
    disk = problem(given, sector_files.numpy, tmp_path_factory.mktemp("superelement"), study)
    return given, waves(disk), peak(disk)


@pytest.mark.slow
@pytest.mark.parametrize("write", [each for each in WHOLE if each is not sector_files.numpy])
def test_a_sector_is_the_same_from_every_program(write, of_whole, tmp_path, study):
    agrees(write, of_whole, tmp_path, study)


@pytest.mark.parametrize("write", [each for each in REDUCED if each is not sector_files.numpy])
def test_a_superelement_is_the_same_from_every_program(write, of_superelement, tmp_path, study):
    agrees(write, of_superelement, tmp_path, study)


def agrees(write, reference, folder, study):
    given, frequencies, expected = reference
    disk = problem(given, write, folder, study)
    within = DIGITS.get(write, EXACT)
    np.testing.assert_allclose(waves(disk), frequencies, rtol=within)
    found = peak(disk)
    for column in ("frequency", "amplitude"):
        np.testing.assert_allclose(found[column], expected[column], rtol=30.0 * within)


def test_a_superelement_has_the_frequencies_of_its_sector(of_whole, of_superelement):
    np.testing.assert_allclose(of_superelement[1][:, :3], of_whole[1][:, :3], rtol=1e-5)


def test_rows_that_abaqus_holds_are_left_out(whole, tmp_path):
    """With a note; the model is that of CalculiX, which does not write them."""
    sector_files.abaqus(whole, tmp_path)
    model = ss.read_model(tmp_path / "wheel_STIF1.mtx", units="mm-t-s")
    held = int(whole.held.sum())
    assert model.notes == (f"{held} rows held by boundary conditions, with 1e36 on the diagonal of K, are left out.",)
    assert model.size == whole.K.shape[0] - held
    sector_files.calculix(whole, tmp_path)
    other = ss.read_model(tmp_path / "wheel.inp", units="mm-t-s")
    assert other.dofs == model.dofs
    np.testing.assert_allclose(model.K.toarray(), other.K.toarray(), rtol=1e-12, atol=1e-6)


def test_a_triangle_of_abaqus_may_stand_in_any_order(whole, tmp_path):
    """Nodes in the order of the mesh, so that entries stand on both sides of the diagonal of ascending numbers."""
    sector_files.abaqus(whole, tmp_path)
    entries = np.loadtxt(tmp_path / "wheel_MASS1.mtx", delimiter=",")
    assert np.any(entries[:, 0] > entries[:, 2])
    assert np.any(entries[:, 0] < entries[:, 2])
    mass = ss.read_model(tmp_path / "wheel_STIF1.mtx", units="mm-t-s").M
    rows = np.flatnonzero(~whole.held)
    assert mass.sum() == pytest.approx(1e3 * whole.M[rows][:, rows].sum(), rel=1e-12)


@each(
    ("old", "new", "said"),
    [
        ("     1  ", "     2  ", "Line 1 of wheel_K.mapping below its heading must be 1, a node and UX, UY"),
        ("UX\n", "TEMP\n", "a node and UX, UY, UZ, ROTX, ROTY, ROTZ, but is"),
        (" UZ\n", " UZ 0\n", "below its heading must be"),
    ],
)
def test_a_damaged_mapping_of_ansys_is_refused(tmp_path, old, new, said):
    mapping(tmp_path, lambda text: text.replace(old, new, 1))
    with pytest.raises(ss.InputError, match=re.escape(said)):
        ss.read_model(tmp_path / "wheel_K.matrix")


def test_a_mapping_of_fewer_rows_is_refused(tmp_path):
    mapping(tmp_path, lambda text: text[: text.rindex("     3 ")])
    with pytest.raises(ss.InputError, match=r"wheel_K.mapping must have a line for each of the 3 rows of its matrix, but is 2"):
        ss.read_model(tmp_path / "wheel_K.matrix")


def mapping(folder, change):
    """A model of one node, with a mapping of its stiffness that is changed."""
    node = SectorFiles(
        *(sparse.csc_array(np.diag([4.0, 5.0, 6.0])), sparse.csc_array(np.eye(3))),
        *(np.zeros((1, 3)), np.array([7]), np.zeros(3, dtype=bool), {"TIP": np.array([0])}, ((7, 1), (7, 2), (7, 3))),
    )
    sector_files.ansys_hbmat(node, folder)
    file = folder / "wheel_K.mapping"
    file.write_text(change(file.read_text()))
