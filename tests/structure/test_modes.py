"""Natural modes with free bodies and with massless motions."""

import numpy as np
import pytest
from scipy import linalg

from stickslip.model.problem import modal_damping_matrix
from stickslip.model.structure.matrices import ModalDamping
from stickslip.model.structure.modes import definite_modes, natural_modes


def random_stiffness(size: int, seed: int) -> np.ndarray:
    root = np.random.default_rng(seed).standard_normal((size, size))
    return root @ root.T


@pytest.mark.parametrize("seed", range(3))
def test_massless_motions_are_condensed(seed: int):
    K = random_stiffness(6, seed)
    M = np.diag([1.0, 2.0, 3.0, 0.5, 0.0, 0.0])
    modes = natural_modes(M, K)
    condensed = K[:4, :4] - K[:4, 4:] @ linalg.solve(K[4:, 4:], K[4:, :4])
    np.testing.assert_allclose(modes.squares, linalg.eigvalsh(condensed, M[:4, :4]), rtol=1e-9)
    np.testing.assert_allclose(K @ modes.shapes, M @ modes.shapes * modes.squares, atol=1e-9 * np.abs(K).max())
    np.testing.assert_allclose(modes.shapes.T @ M @ modes.shapes, np.eye(4), atol=1e-12)


def test_a_nearly_massless_damper_tends_to_the_massless_one():
    K = random_stiffness(4, 7)
    gaps = []
    exact = natural_modes(np.diag([1.0, 1.0, 1.0, 0.0]), K).frequencies
    for mass in (1e-3, 1e-4, 1e-5):
        gaps.append(np.abs(natural_modes(np.diag([1.0, 1.0, 1.0, mass]), K).frequencies[:3] / exact - 1.0).max())
    assert gaps[1] == pytest.approx(gaps[0] / 10, rel=0.2)
    assert gaps[2] == pytest.approx(gaps[1] / 10, rel=0.2)


def test_rigid_motions_have_no_frequency():
    """A free massless damper adds nothing; a free mass adds a rigid motion."""
    K = np.diag([4.0 * np.pi**2, 0.0, 0.0])
    assert natural_modes(np.diag([1.0, 1.0, 0.0]), K).frequencies == pytest.approx([0.0, 1.0], abs=1e-12)


def test_units_do_not_decide_what_is_massless():
    """A moment of inertia of 1e-13 kg m² beside a mass of 1 kg is a mass."""
    assert natural_modes(np.diag([1.0, 1e-13]), np.diag([1.0, 1e-13])).squares == pytest.approx([1.0, 1.0])


def test_modes_of_a_mass_that_is_not_definite_have_unit_modal_mass_where_they_oscillate():
    """K φ = ω² M φ with M of both signs, as stiffness that grows with the square of the speed makes it."""
    K, M = random_stiffness(4, 3) + np.eye(4), np.diag([1.0, 2.0, -0.5, 0.3])
    modes = definite_modes(M, K)
    assert modes.squares.size == 3
    assert np.all(np.diff(modes.squares) > 0.0)
    np.testing.assert_allclose(K @ modes.shapes, M @ modes.shapes * modes.squares, atol=1e-9 * np.abs(K).max())
    np.testing.assert_allclose(modes.shapes.T @ M @ modes.shapes, np.eye(3), atol=1e-10)


def test_modal_damping_has_the_ratios_that_it_states():
    """φᵀCφ = 2ζω for each mode, and nothing between modes."""
    K, M = random_stiffness(4, 5) + np.eye(4), np.diag([1.0, 2.0, 0.5, 0.3])
    modes = natural_modes(M, K)
    C = modal_damping_matrix(M, modes, ModalDamping([0.01, 0.02, 0.0]))
    expected = np.diag(2.0 * np.array([0.01, 0.02, 0.0, 0.0]) * np.sqrt(linalg.eigvalsh(K, M)))
    np.testing.assert_allclose(modes.shapes.T @ C @ modes.shapes, expected, atol=1e-12)
