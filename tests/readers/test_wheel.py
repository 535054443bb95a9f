"""The wheel of examples/wheel: its sector at speed against CalculiX 2.20's own cyclic analysis of the same deck."""

import gzip
import re
import runpy
import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy import linalg

import stickslip as ss

WHEEL = Path(__file__).parents[2] / "examples" / "wheel"

# The lowest two frequencies in Hz of nodal diameters 0 to 9: *FREQUENCY with *SELECT CYCLIC SYMMETRY MODES, NMIN=0, NMAX=9 in
# place of the last step of sector.inp.
FREQUENCIES = [
    (717.8082, 1287.663),
    (719.5403, 1284.038),
    (720.6076, 1294.121),
    (720.568, 1347.262),
    (720.2284, 1415.395),
    (719.9178, 1466.076),
    (719.7068, 1497.792),
    (719.5794, 1516.535),
    (719.512, 1526.441),
    (719.4909, 1529.544),
]
STRESS = {352: [90.1477, 3.76659, 0.890397, 6.95242, 0.189163, 0.508007], 354: [96.5925, 3.22749, 2.4158, 7.35079, 0.0, 0.0]}
"""xx, yy, zz, xy, yz, zx in MPa by node, after the static step of sector.inp (*EL FILE)."""


@pytest.fixture(scope="module")
def disk(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    for name in ("sector.inp", "sector.dof"):
        shutil.copy(WHEEL / name, folder)
    for name in ("sector.sti", "sector.mas"):
        (folder / name).write_bytes(gzip.decompress((WHEEL / f"{name}.gz").read_bytes()))
    return ss.read_sector(
        folder / "sector.inp",
        units="mm-t-s",
        sectors=18,
        faces=("LOW", "HIGH"),
        keep={"tip": "TIP"},
        modes=15,
        speed=9000.0,
        stress={"foot": "FILLET"},
    )


def test_frequencies_are_those_of_the_cyclic_analysis_of_calculix(disk):
    for n, expected in enumerate(FREQUENCIES):
        waves = disk.at(n)
        found = np.sqrt(linalg.eigh(waves.K, waves.M, eigvals_only=True)[:2]) / (2.0 * np.pi)
        assert found == pytest.approx(expected, rel=1e-4)


def test_the_sector_is_drawn_by_the_faces_of_its_elements(disk):
    """Closed: each edge of a triangle belongs to two of them."""
    triangles = disk.mesh_triangles
    edges = np.sort(np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}
    assert triangles.max() < len(disk.mesh_points)


def test_the_stress_due_to_rotation_is_that_of_calculix(disk):
    """Linear here, with the prestressed K, and nonlinear there."""
    recovery = disk.stresses[0]
    for node, expected in STRESS.items():
        found = recovery.rotation[recovery.places.index(f"foot/{node}")] / 1e6
        assert found == pytest.approx(expected, abs=3e-3 * max(expected))


def test_the_script_writes_the_deck_of_the_study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(WHEEL / "make_sector.py"))
    written, kept = ((folder / "sector.inp").read_text() for folder in (tmp_path, WHEEL))
    numbers = re.compile(r"-?\d+\.\d+")
    assert numbers.sub("", written).replace("-", "") == numbers.sub("", kept).replace("-", "")
    values = [np.array(numbers.findall(text), dtype=float) for text in (written, kept)]
    np.testing.assert_allclose(*values, atol=2e-9)
