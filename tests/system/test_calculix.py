"""CalculiX, run here: it solves the blade, and the matrices that it writes give its frequencies to the digits that it prints."""

import shutil
import subprocess

import numpy as np
import pytest
from readers.test_calculix import DATA, printed_frequencies

import stickslip as ss
from stickslip.model.structure.modes import lowest_modes

pytestmark = [pytest.mark.system, pytest.mark.skipif(not shutil.which("ccx"), reason="needs CalculiX (calculix-ccx)")]


def solved(folder, deck):
    """Run ccx on a deck in a folder of its own."""
    folder.mkdir()
    (folder / "blade.inp").write_text(deck)
    subprocess.run(["ccx", "blade"], cwd=folder, check=True, capture_output=True, timeout=300)
    return folder


@pytest.mark.parametrize("element", ["C3D20R", "C3D20"])
def test_frequencies_of_a_run(tmp_path, element):
    deck = (DATA / "blade.inp").read_text().replace("C3D20R", element)
    matrices = solved(tmp_path / "matrices", deck)
    modes = solved(tmp_path / "modes", deck.replace(", SOLVER=MATRIXSTORAGE", ""))
    printed, last_digit = printed_frequencies((modes / "blade.dat").read_text())
    model = ss.read_model(matrices / "blade.inp", units="mm-t-s")
    found = lowest_modes(model.M, model.K, 8).frequencies
    assert printed.size == 8
    assert np.all(np.abs(found - printed) <= last_digit)
