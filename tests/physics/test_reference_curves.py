"""Curves and peaks of other harmonic balance codes, at their harmonics and samples."""

from math import pi
from pathlib import Path

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.model.rigs import chain, chain_of_three, chain_varying_load, single_mass
from stickslip.support.units import radians_per_second

DATA = Path(__file__).parents[1] / "data"
CURVES = {
    "nlvib_sdof_jenkins_F0.3": (single_mass(kt=0.5, force=0.3), 2e-6),
    "nlvib_sdof_jenkins_F0.9": (single_mass(kt=0.5, force=0.9), 2e-6),
    "nlvib_chain3_two_jenkins": (chain_of_three(), 1e-5),
}


@pytest.mark.parametrize("name", CURVES)
def test_curves_of_nlvib(name):
    """First harmonic, root mean square and largest value at its frequencies, relative to the highest of the curve."""
    problem, tolerance = CURVES[name]
    table = np.loadtxt(DATA / f"{name}.csv", delimiter=",", skiprows=1)
    frequencies, columns = table[:, 0] / (2.0 * pi), table[:, 1:].reshape(len(table), -1, 3)
    dataset = forced_response(problem, frequencies, harmonics=11, samples=1024).dataset
    assert dataset.sizes["point"] == len(table) >= 24
    found = np.stack([dataset[quantity][0] for quantity in ("amplitude", "rms", "max_abs")], axis=-1)
    assert np.max(np.abs(found - columns) / columns.max(axis=0)) < tolerance


@pytest.mark.parametrize(
    ("level", "largest", "at_largest", "amplitude", "at_amplitude"),
    [
        (0.1, 1.05850631, 1.406102416, 1.060053763, 1.406102402),
        (0.5, 1.567292339, 1.293482122, 1.572294392, 1.293482118),
        (1.0, 3.560423909, 1.108840089, 3.537416372, 1.108840082),
        (2.0, 37.86808498, 1.003281635, 37.82571321, 1.003282071),
    ],
)
def test_peaks_of_one_mass(level, largest, at_largest, amplitude, at_amplitude):
    """H 7, 256 samples; maximised over frequency to 1e-9 by an independent script of this project."""
    response = forced_response(single_mass(), radians_per_second(0.5, 2.0), level, harmonics=7, samples=256)
    dataset, peak = response.dataset, response.peaks().iloc[0]
    assert peak.amplitude == pytest.approx(amplitude, rel=1e-8)
    assert 2.0 * pi * peak.frequency == pytest.approx(at_amplitude, rel=1e-6)
    assert float(dataset.highest_max_abs[0, 0]) == pytest.approx(largest, rel=1e-7)
    assert 2.0 * pi * float(dataset.highest_max_abs_frequency[0, 0]) == pytest.approx(at_largest, rel=3e-6)


def test_chain_of_twenty_with_constant_loads():
    """Two independent codes, each on its own points: max|x| 9.589 at 0.2421 rad/s, first harmonic 9.620 at 0.2419."""
    response = forced_response(chain(), radians_per_second(0.05, 0.35), harmonics=7, samples=256)
    dataset, peak = response.dataset, response.peaks().iloc[0]
    assert peak.amplitude == pytest.approx(9.620, rel=1e-3)
    assert 2.0 * pi * peak.frequency == pytest.approx(0.2419, rel=1e-3)
    assert float(dataset.highest_max_abs[0, 0]) == pytest.approx(9.589, rel=1e-3)
    assert 2.0 * pi * float(dataset.highest_max_abs_frequency[0, 0]) == pytest.approx(0.2421, rel=1e-3)


def test_chain_of_twenty_with_varying_load():
    """First harmonic 8.950 near 0.2515 rad/s; 2.323463262 at 0.18 rad/s by two independent codes. Balanced prestress."""
    response = forced_response(chain_varying_load(), radians_per_second(0.18, 0.3), harmonics=7, samples=256)
    peak, first = response.peaks().iloc[0], response.dataset.isel(case=0, point=0)
    assert peak.amplitude == pytest.approx(8.950, rel=1e-3)
    assert 2.0 * pi * peak.frequency == pytest.approx(0.2515, rel=1e-3)
    assert 2.0 * pi * float(first.frequency) == pytest.approx(0.18, rel=1e-12)
    assert float(first.amplitude[0]) == pytest.approx(2.323463262, rel=1e-8)
