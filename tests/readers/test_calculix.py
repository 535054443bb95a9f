"""A run of CalculiX 2.20 (tests/data/calculix, files as ccx wrote them): its frequencies to the digits that it prints."""

import gzip
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.model.readers.model import describe
from stickslip.model.structure.modes import natural_modes
from stickslip.study import read
from stickslip.support.checks import InputError

DATA = Path(__file__).parents[1] / "data" / "calculix"


def printed_frequencies(dat):
    """The frequencies of a .dat file in Hz, and one unit of their last digit."""
    lines = re.findall(r"^ +\d+ +\S+ +\S+ +(\d\.\d+E[+-]\d+) +\S+$", dat.split("P A R T I C")[0], re.MULTILINE)
    return np.array([float(line) for line in lines]), np.array([10.0 ** (int(line[-3:]) - 7) for line in lines])


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of the run, unpacked."""
    folder = tmp_path_factory.mktemp("calculix")
    for file in DATA.iterdir():
        if file.suffix == ".gz":
            (folder / file.stem).write_bytes(gzip.decompress(file.read_bytes()))
        else:
            shutil.copy(file, folder)
    return folder


def test_frequencies_to_the_printed_digits(run):
    model = ss.read_model(run / "blade.sti", units="mm-t-s")
    printed, last_digit = printed_frequencies((run / "blade.dat").read_text())
    found = natural_modes(model.M.toarray(), model.K.toarray()).frequencies[:8]  # reduced integration: M is singular
    assert printed.size == 8
    assert np.all(np.abs(found - printed) <= last_digit)


def test_names_coordinates_and_sets_come_from_the_deck(run):
    model = ss.read_model(run / "blade.inp", units="mm-t-s")
    assert model.size == 456
    assert {name: len(nodes) for name, nodes in model.sets.items()} == {"ALL": 165, "ROOT": 13, "PAD": 5}
    assert all(model.nodes[node][1] == pytest.approx(0.045) for node in model.sets["PAD"])
    assert not set(model.sets["ROOT"]) & set(model.directions)


def test_description(run):
    """Extent and mass of the box 8 x 120 x 30 mm, less the clamped nodes; first mode of a slender beam (Euler-Bernoulli)."""
    found = describe(ss.read_model(run / "blade.mas", units="mm-t-s"))
    np.testing.assert_allclose(found.box, [0.008, 0.12, 0.03], rtol=1e-12)
    assert found.mass == pytest.approx([0.2198] * 3, rel=1e-6)
    slender = 1.8751**2 / (2 * np.pi) * np.sqrt(210e9 * 0.008**2 / 12 / 7850) / 0.12**2
    assert found.modes.frequencies[0] == pytest.approx(slender, rel=0.03)
    assert found.odd == ()


def test_the_reduced_blade(run):
    structure = ss.read_structure(run / "blade.inp", units="mm-t-s", keep={"pad": "PAD", "tip": (0, 120, 15)}, modes=30)
    printed, _ = printed_frequencies((run / "blade.dat").read_text())
    found = natural_modes(structure.M, structure.K).frequencies[:4]
    np.testing.assert_allclose(found, printed[:4], rtol=1e-4)
    assert structure.dofs[-31] == "tip.z"


def test_the_substructure(run):
    """What *SUBSTRUCTURE GENERATE wrote against the matrices of the other run; the nodes stand in its comments.

    CalculiX 2.20 writes the rows of the retained nodes as they are, K_pp, and does not condense the others onto them.
    """
    model = ss.read_model(run / "blade.inp", units="mm-t-s")
    kept = [model.rows[f"{node}.{axis}"] for node in model.sets["PAD"] for axis in "xyz"]
    K = model.K.toarray()[np.ix_(kept, kept)]
    np.savez(run / "mass.npz", M=np.eye(15))
    files = {"K": run / "blade_pad_K.mtx", "M": run / "mass.npz"}
    written = ss.read_model(files, units="mm-t-s")
    assert written.dofs == tuple(model.dofs[row] for row in kept)
    np.testing.assert_allclose(written.K.toarray(), K, atol=1e-12 * K.max())
    with pytest.raises(InputError, match="matrix M must be in the file, but is missing"):
        ss.read_model(run / "blade_pad_K.mtx")


@pytest.mark.parametrize("missing", ["blade.mas", "blade.dof"])
def test_files_that_are_missing(run, tmp_path, missing):
    shutil.copytree(run, tmp_path / "run")
    (tmp_path / "run" / missing).unlink()
    with pytest.raises(InputError, match=rf"must have {missing} beside blade.inp.*MATRIXSTORAGE"):
        ss.read_model(tmp_path / "run" / "blade.inp")


@pytest.mark.parametrize(("kept", "said"), [(-5, "must end with a whole line"), (-30, "must have as many lines as blade.sti")])
def test_truncated_matrices(run, tmp_path, kept, said):
    shutil.copytree(run, tmp_path / "run")
    lines = (run / "blade.mas").read_bytes()
    (tmp_path / "run" / "blade.mas").write_bytes(lines[:kept] if kept == -5 else b"".join(lines.splitlines(True)[:kept]))
    with pytest.raises(InputError, match=said):
        ss.read_model(tmp_path / "run" / "blade.inp", units="mm-t-s")


@pytest.mark.parametrize(
    ("file", "said"), [("blade.sti", "must hold a matrix"), ("blade.dof", "must hold a line NODE.DIRECTION")]
)
def test_empty_files(run, tmp_path, file, said):
    shutil.copytree(run, tmp_path / "run")
    (tmp_path / "run" / file).write_bytes(b"")
    with pytest.raises(InputError, match=f"{file} {said}.*MATRIXSTORAGE"):
        ss.read_model(tmp_path / "run" / "blade.inp")


def test_a_deck_that_includes_others_is_read_with_them(run, tmp_path):
    shutil.copytree(run, tmp_path / "run")
    whole = ss.read_model(tmp_path / "run" / "blade.inp", units="mm-t-s")
    (tmp_path / "run" / "blade.inp").rename(tmp_path / "run" / "mesh.inp")
    (tmp_path / "run" / "blade.inp").write_text("*INCLUDE, INPUT=mesh.inp\n*STEP\n")
    model = ss.read_model(tmp_path / "run" / "blade.inp", units="mm-t-s")
    assert (model.nodes, model.sets, model.notes) == (whole.nodes, whole.sets, ())
    (tmp_path / "run" / "mesh.inp").unlink()
    with pytest.raises(InputError, match=r"The file that blade\.inp, line 1 includes must exist in the folder of the deck"):
        ss.read_model(tmp_path / "run" / "blade.inp")


def test_nodes_of_shells_have_several_rows_a_direction(tmp_path):
    """CalculiX expands a shell into solids and names each node of these by that of the shell (2.20, tried on S8 and B32R)."""
    rows = ["1.1", "1.2", "1.3", *3 * ["2.1", "2.2", "2.3"], "3.1", "4.2", "4.2"]
    (tmp_path / "s.dof").write_text("\n".join(rows) + "\n")
    for ending, value in (("sti", 5.0), ("mas", 1.0)):
        (tmp_path / f"s.{ending}").write_text("".join(f"{k} {k} {value}\n" for k in range(1, len(rows) + 1)))
    (tmp_path / "s.inp").write_text("*NODE\n1, 0., 0.\n2, 1., 0.\n3, 2., 0.\n4, 3., 0.\n*NSET, NSET=EDGE\n1, 2\n")
    model = ss.read_model(tmp_path / "s.sti")
    middle = [f"2-{part}.{axis}" for part in (1, 2, 3) for axis in "xyz"]
    assert model.dofs == ("1.x", "1.y", "1.z", *middle, "3.x", "4-1.y", "4-2.y")
    assert model.sets == {"EDGE": ("1", "2-1", "2-2", "2-3")}
    assert set(model.nodes) == {"1", "3"}
    assert "s.dof names 2 nodes of shells or beams several times" in model.notes[0]


def test_the_study_of_the_tutorial(run):
    """The same problem as in the example: its natural frequencies, and where its places were found."""
    page = (DATA.parents[2] / "docs" / "calculix.md").read_text()
    (run / "study.toml").write_text(page.split("```toml\n")[1].split("```")[0])
    job = read(run / "study.toml")
    assert job.notes[:3] == ("left: node 76", "right: node 86", "tip: node 162")
    assert job.notes[3:] == ("Modes of the body with what is kept held: 10 of 10 below 24790 Hz",)
    assert job.sweep.problem.frequencies(stuck=True)[0] == pytest.approx(563.69815, rel=1e-6)
    assert job.sweep.problem.load(1)[job.sweep.problem.structure.index("tip.x"), 1] == 1.0


def test_info_at_the_command_line(run):
    result = CliRunner().invoke(app, ["info", str(run / "blade.inp"), "--units", "mm-t-s"])
    assert result.exit_code == 0
    for words in (
        "CalculiX matrices",
        "PAD: 5 nodes",
        "473.5001, 1676.35, 2912.721",
        "10 of 10 below 18698 Hz",
        "positive definite",
    ):
        assert words in result.output
    np.savez(run / "a.npz", KELAST=4.0 * np.eye(2), M=np.eye(2), C=np.eye(2))
    named = CliRunner().invoke(app, ["info", str(run / "a.npz"), "--variables", "K=KELAST", "--no-damping"])
    assert "rows              2 (M 2, K 2 entries)" in named.output
    unnamed = CliRunner().invoke(app, ["info", str(run / "a.npz"), "--variables", "KELAST"])
    assert (unnamed.exit_code, "must be NAME=VALUE, such as K=KELAST" in unnamed.output) == (2, True)
    wrong = CliRunner().invoke(app, ["info", str(run / "blade.dat")])
    assert wrong.exit_code == 2
    assert "must be a file ending in" in wrong.output
