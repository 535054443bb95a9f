"""Curves and peaks of other harmonic balance codes, from study files through the command line."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.files import open_results
from verify.row import INDEPENDENT, Row, at_most, relative

if TYPE_CHECKING:
    import xarray as xr

TITLE = "Other codes"
ABOUT = (
    "Every case is a study file with matrices and contacts by name, computed by `stickslip run`. One mass: 7 "
    "harmonics, 256 samples, peaks maximised over frequency. NLvib (Krack and Gross): first harmonic, root mean "
    "square and largest value along the curve, 11 harmonics, 1024 samples. Chains of twenty masses: two codes, each "
    "on its own points."
)
DATA = Path(__file__).parents[1] / "tests" / "data"
Contact = tuple[str, str, str]


def run(matrices: dict[str, np.ndarray], dofs: Sequence[str], body: str, sweep: str) -> xr.Dataset:
    """The results of a study in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        np.savez(place / "matrices.npz", **matrices)
        names = ", ".join(f'"{dof}"' for dof in dofs)
        head = '[study]\ntitle = "verification"\nanalysis = "forced_response"\n[structure]\nmatrices = "matrices.npz"\n'
        (place / "study.toml").write_text(f"{head}dofs = [{names}]\n{body}\n[sweep]\n{sweep}\n")
        command = [sys.executable, "-m", "stickslip", "run", str(place / "study.toml"), "--out", str(place / "out")]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(done.stdout + done.stderr)
        return open_results(place / "out" / "results.nc").load()


def slider(a: str, b: str, kt: float, limit: float) -> str:
    return f'[[contact]]\nlaw = "macroslip"\nbetween = ["{a}", "{b}"]\nkt = {kt}\nmu = 1.0\nnormal_load = {limit}\n'


def force(at: str, amplitude: float) -> str:
    return f'[[force]]\ndirection = "{at}"\namplitude = {amplitude}\n'


def band(low: float, high: float, harmonics: int, samples: int, levels: Sequence[float], outputs: Sequence[str]) -> str:
    names = ", ".join(f'"{output}"' for output in outputs)
    common = f"harmonics = {harmonics}\nsamples = {samples}\nforce_levels = {list(levels)}\noutputs = [{names}]"
    return f"frequency = [{low / (2 * pi)!r}, {high / (2 * pi)!r}]\n{common}"


def at(omegas: np.ndarray, harmonics: int, samples: int, outputs: Sequence[str]) -> str:
    names = ", ".join(f'"{output}"' for output in outputs)
    return f"at = {[float(w / (2 * pi)) for w in omegas]}\nharmonics = {harmonics}\nsamples = {samples}\noutputs = [{names}]"


def chain_matrices(masses: int) -> np.ndarray:
    K = 2.0 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    K[-1, -1] = 1.0
    return K


def one_mass() -> Iterator[Row]:
    table = {
        0.1: (1.05850631, 1.406102416, 1.060053763, 1.406102402),
        0.5: (1.567292339, 1.293482122, 1.572294392, 1.293482118),
        1.0: (3.560423909, 1.108840089, 3.537416372, 1.108840082),
        2.0: (37.86808498, 1.003281635, 37.82571321, 1.003282071),
    }
    one = np.eye(1)
    body = slider("1.x", "ground", 1.0, 1.0) + force("1.x", 1.0)
    dataset = run({"M": one, "K": one, "C": 0.02 * one}, ["1.x"], body, band(0.5, 2.0, 7, 256, list(table), ["1.x"]))
    for case, (level, (largest, at_largest, amplitude, at_amplitude)) in enumerate(table.items()):
        found, name = dataset.isel(case=case, output=0), f"One mass, F = {level:g}: "
        yield relative(f"{name}highest max|x|", found.highest_max_abs, largest, 1e-6, INDEPENDENT)
        yield relative(f"{name}ω there", 2 * pi * found.highest_max_abs_frequency, at_largest, 1e-5, INDEPENDENT)
        yield relative(f"{name}peak of the first harmonic", found.peak_amplitude[0], amplitude, 1e-6, INDEPENDENT)
        yield relative(f"{name}ω there", 2 * pi * found.peak_frequency[0], at_amplitude, 1e-5, INDEPENDENT)


def nlvib() -> Iterator[Row]:
    one, three = np.eye(1), np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 2]])
    small = {"M": one, "K": one, "C": 0.02 * one}
    large = {"M": np.eye(3), "K": three, "C": 0.02 * three}
    contacts = slider("1.x", "ground", 20.0, 1.0) + slider("1.x", "2.x", 20.0, 1.0)
    cases = {
        "sdof_jenkins_F0.3": (small, slider("1.x", "ground", 0.5, 1.0) + force("1.x", 0.3)),
        "sdof_jenkins_F0.9": (small, slider("1.x", "ground", 0.5, 1.0) + force("1.x", 0.9)),
        "chain3_two_jenkins": (large, contacts + force("2.x", 1.0)),
    }
    for name, (matrices, body) in cases.items():
        table = np.loadtxt(DATA / f"nlvib_{name}.csv", delimiter=",", skiprows=1)
        expected = table[:, 1:].reshape(len(table), -1, 3)
        dofs = [f"{i}.x" for i in range(1, expected.shape[1] + 1)]
        dataset = run(matrices, dofs, body, at(table[:, 0], 11, 1024, dofs))
        for k, quantity in enumerate(("amplitude", "rms", "max_abs")):
            gap = np.abs(dataset[quantity][0].to_numpy() - expected[..., k]) / expected[..., k].max(axis=0)
            yield at_most(
                f"NLvib {name}, {quantity}: largest deviation over the curve's highest", gap.max(), 1e-5, "NLvib, GNU Octave"
            )


def chains() -> Iterator[Row]:
    K, two = chain_matrices(20), "two independent codes"
    dofs = [f"{i}.x" for i in range(1, 21)]
    body = "".join(slider(f"{i}.x", "ground", 0.5, 1.0) for i in range(11, 21)) + force("10.x", 1.0)
    dataset = run({"M": np.eye(20), "K": K, "C": 0.01 * K}, dofs, body, band(0.05, 0.35, 7, 256, [1.0], ["10.x"]))
    found = dataset.isel(case=0, output=0)
    yield relative("Chain, constant loads: highest max|x|", found.highest_max_abs, 9.589, 1e-3, two)
    yield relative("Chain, constant loads: ω there", 2 * pi * found.highest_max_abs_frequency, 0.2421, 1e-3, two)
    yield relative("Chain, constant loads: peak of the first harmonic", found.peak_amplitude[0], 9.620, 1e-3, two)
    yield relative("Chain, constant loads: ω there", 2 * pi * found.peak_frequency[0], 0.2419, 1e-3, two)
    K = np.kron(K, np.eye(2)) + np.kron(np.eye(20), np.diag([0.0, 1.0]))
    law = "kt = 0.5\nkn = 1.0\nmu = 0.5\npreload = 2.0\nbalanced = true\n"
    sides = 'tangential = ["{0}.x", "ground"]\nnormal = ["{0}.y", "ground"]\n'
    touching = ['[[contact]]\nlaw = "macroslip"\n' + sides.format(i) + law + force(f"{i}.y", 1.0) for i in range(11, 21)]
    dofs = [f"{i}.{axis}" for i in range(1, 21) for axis in "xy"]
    matrices = {"M": np.eye(40), "K": K, "C": 0.01 * K}
    dataset = run(matrices, dofs, "".join(touching) + force("10.x", 1.0), band(0.18, 0.3, 7, 256, [1.0], ["10.x"]))
    found = dataset.isel(case=0, output=0)
    yield relative("Chain, varying loads: peak of the first harmonic", found.peak_amplitude[0], 8.950, 1e-3, two)
    yield relative("Chain, varying loads: ω there", 2 * pi * found.peak_frequency[0], 0.2515, 1e-3, two)
    yield relative("Chain, varying loads: first harmonic at 0.18 rad/s", found.amplitude[0], 2.323463262, 1e-8, two)


def rows() -> Iterator[Row]:
    yield from one_mass()
    yield from nlvib()
    yield from chains()
