"""Waves of a disk against the whole ring of its sectors, in both directions and beyond half the number of sectors."""

import numpy as np
import pytest

from stickslip.model.structure.cyclic import circulant, sector_chain
from stickslip.model.structure.matrices import Structure


@pytest.mark.parametrize("sectors", [5, 6])
def test_every_nodal_diameter_is_a_wave_round_the_whole_ring(sectors):
    """q_j = Q exp(−i 2π n j/N): the matrices of the whole ring, times this wave, are those of the wave times Q."""
    own = {"M": np.array([[2.0, 0.3], [0.3, 1.0]]), "K": np.array([[9.0, -1.0], [-1.0, 7.0]]), "C": np.diag([0.1, 0.2])}
    following = {"M": np.array([[0.1, 0.05], [-0.02, 0.0]]), "K": np.array([[-1.0, 0.4], [-0.7, -0.2]]), "C": np.zeros((2, 2))}
    structure = Structure(own["M"], own["K"], ("1.x", "1.y"), C=own["C"])
    disk = sector_chain(structure, sectors, following["K"], following["M"])
    right = np.roll(np.eye(sectors), 1, axis=1)  # row j takes the motion of sector j + 1
    rings = {
        name: np.kron(np.eye(sectors), own[name]) + np.kron(right, following[name]) + np.kron(right.T, following[name].T)
        for name in "MKC"
    }
    for name, waves in (("M", disk.masses), ("K", disk.stiffnesses), ("C", disk.dampings)):
        np.testing.assert_allclose(circulant(waves, sectors), rings[name], atol=1e-12)
    amplitude = np.array([0.6 - 0.2j, 1.1 + 0.5j])
    for n in range(-sectors, 2 * sectors):
        wave = np.exp(-2j * np.pi * n * np.arange(sectors) / sectors)
        for name in "MKC":
            of_wave = getattr(disk.at(n), name)
            np.testing.assert_allclose(rings[name] @ np.kron(wave, amplitude), np.kron(wave, of_wave @ amplitude), atol=1e-12)
