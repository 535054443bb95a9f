"""Other codes' cases from study files through the command line, no Python in between: chains, one mass, three masses."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from stickslip.cli import app
from stickslip.results.files import open_results

DATA = Path(__file__).parents[1] / "data"

pytestmark = pytest.mark.usefixtures("unsaved_figures")


def chain_stiffness(masses, last=0.0):
    K = 2.0 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    K[-1, -1] = 1.0 + last
    return K


def run(folder, text, **matrices):
    """The results of a study run by the command line."""
    np.savez(folder / "matrices.npz", **matrices)
    (folder / "study.toml").write_text(text)
    result = CliRunner().invoke(app, ["run", str(folder / "study.toml"), "--out", str(folder / "out")])
    assert result.exit_code == 0, result.output
    return open_results(next((folder / "out").glob("*.nc")))


def study(dofs, contacts, force, sweep):
    """A study file with matrices.npz."""
    listed = ", ".join(f'"{dof}"' for dof in dofs)
    head = f'[study]\nanalysis = "forced_response"\n[structure]\nmatrices = "matrices.npz"\ndofs = [{listed}]\n'
    return "\n".join([head, *contacts, f"[[force]]\n{force}\n", f"[sweep]\n{sweep}\n"])


def slider(a, b, kt, load=1.0):
    return f'[[contact]]\nlaw = "macroslip"\nbetween = ["{a}", "{b}"]\nkt = {kt}\nmu = 1.0\nnormal_load = {load}\n'


@pytest.mark.slow
def test_chain_of_twenty_masses_with_constant_loads(tmp_path):
    """Peak at mass 10 by two other codes, each on its own points: max |x| 9.589, first harmonic 9.620."""
    dofs = [f"{i}.x" for i in range(1, 21)]
    K = chain_stiffness(20)
    contacts = [slider(f"{i}.x", "ground", 0.5) for i in range(11, 21)]
    band = f"frequency = [{0.2 / (2 * np.pi)!r}, {0.27 / (2 * np.pi)!r}]\nharmonics = 7\nsamples = 256\noutputs = ['10.x']"
    found = run(tmp_path, study(dofs, contacts, 'direction = "10.x"\namplitude = 1.0', band), M=np.eye(20), K=K, C=0.01 * K)
    assert float(found.peak_amplitude[0, 0, 0]) == pytest.approx(9.620, rel=1e-3)
    assert float(found.highest_max_abs[0, 0]) == pytest.approx(9.589, rel=1e-3)
    assert 2 * np.pi * float(found.peak_frequency[0, 0, 0]) == pytest.approx(0.2419, rel=1e-3)


def test_chain_of_twenty_masses_with_varying_loads(tmp_path):
    """First harmonic at mass 10: peak 8.950 near 0.2515 rad/s, and 2.323463262 at 0.18 rad/s by two other codes."""
    dofs = [f"{i}.{axis}" for axis in "xy" for i in range(1, 21)]
    Kx = chain_stiffness(20)
    Ky, zero = Kx + np.eye(20), np.zeros((20, 20))
    K = np.block([[Kx, zero], [zero, Ky]])
    contacts = [
        f'[[contact]]\nlaw = "macroslip"\ntangential = ["{i}.x", "ground"]\nnormal = ["{i}.y", "ground"]\n'
        "kt = 0.5\nkn = 1.0\nmu = 0.5\npreload = 2.0\nbalanced = true\n"
        for i in range(11, 21)
    ]
    pressing = "\n".join(f'[[force]]\ndirection = "{i}.y"\namplitude = 1.0' for i in range(11, 21))
    band = f"frequency = [{0.18 / (2 * np.pi)!r}, {0.3 / (2 * np.pi)!r}]\nharmonics = 7\nsamples = 256\noutputs = ['10.x']"
    text = study(dofs, contacts, f'direction = "10.x"\namplitude = 1.0\n{pressing}', band)
    found = run(tmp_path, text, M=np.eye(40), K=K, C=0.01 * K)
    assert float(found.peak_amplitude[0, 0, 0]) == pytest.approx(8.950, rel=1e-3)
    assert 2 * np.pi * float(found.peak_frequency[0, 0, 0]) == pytest.approx(0.2515, rel=1e-3)
    assert float(found.amplitude[0, 0, 0]) == pytest.approx(2.323463262, rel=1e-8)


@pytest.mark.parametrize("force", ["0.3", "0.9"])
def test_one_mass_follows_the_curve_of_another_code(tmp_path, force):
    curve = np.loadtxt(DATA / f"nlvib_sdof_jenkins_F{force}.csv", delimiter=",", skiprows=1)
    at = ", ".join(repr(float(omega / (2 * np.pi))) for omega in curve[:, 0])
    sweep = f"at = [{at}]\nharmonics = 11\nsamples = 1024\noutputs = ['1.x']"
    text = study(["1.x"], [slider("1.x", "ground", 0.5)], f'direction = "1.x"\namplitude = {force}', sweep)
    one = np.eye(1)
    found = run(tmp_path, text, M=one, K=one, C=0.02 * one)
    order = np.argsort(curve[:, 0])
    np.testing.assert_allclose(found.amplitude[0, :, 0], curve[order, 1], atol=1e-5 * curve[:, 1].max())


def test_three_masses_follow_the_curve_of_another_code(tmp_path):
    curve = np.loadtxt(DATA / "nlvib_chain3_two_jenkins.csv", delimiter=",", skiprows=1)
    at = ", ".join(repr(float(omega / (2 * np.pi))) for omega in curve[:, 0])
    sweep = f"at = [{at}]\nharmonics = 11\nsamples = 1024\noutputs = ['1.x', '2.x', '3.x']"
    contacts = [slider("1.x", "ground", 20.0), slider("2.x", "1.x", 20.0)]
    K = chain_stiffness(3, last=1.0)
    found = run(
        tmp_path,
        study(["1.x", "2.x", "3.x"], contacts, 'direction = "2.x"\namplitude = 1.0', sweep),
        M=np.eye(3),
        K=K,
        C=0.02 * K,
    )
    order = np.argsort(curve[:, 0])
    for output, column in enumerate((2, 5, 8)):
        np.testing.assert_allclose(found.rms[0, :, output], curve[order, column], atol=1e-5 * curve[:, column].max())


def test_the_number_of_harmonics_may_be_chosen(tmp_path):
    sweep = "frequency = [0.15, 0.2]\nforce_levels = [1.0]\nharmonics = 'auto'\ntolerance = 1e-2\noutputs = ['1.x']"
    one = np.eye(1)
    text = study(["1.x"], [slider("1.x", "ground", 1.0)], 'direction = "1.x"\namplitude = 1.0', sweep)
    found = run(tmp_path, text, M=one, K=one, C=0.02 * one)
    assert found.attrs["harmonics"] == 3
    assert float(found.peak_amplitude[0, 0, 0]) == pytest.approx(3.537416372, rel=3e-3)
    assert "harmonics" in found.attrs["harmonics_chosen"]
