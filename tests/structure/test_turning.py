"""K between two speeds at which the same thin body stands turned, against the body turned half way."""

import numpy as np
import pytest
from scipy import linalg

from stickslip.analyses.speed.models import Turning

ANGLE = 0.02


def body(angle, phase=0.0):
    """M and K of eight nodes that springs hold to each other and to the ground, 3e4 times as stiff along one direction."""
    line = 2.0 * np.eye(8) - np.eye(8, k=1) - np.eye(8, k=-1)
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-along[1], along[0]])
    K = np.kron(3e4 * line, np.outer(along, along)) + np.kron(line @ line, np.outer(across, across))
    wave = np.exp(1j * phase * np.repeat(np.arange(8), 2))
    K = K if phase == 0.0 else wave[:, None] * K * wave.conj()
    return np.kron(np.diag(np.arange(2.0, 10.0)), np.eye(2)), K


def squares(M, K, number=4):
    return linalg.eigh(K, M, eigvals_only=True)[:number]


@pytest.mark.parametrize("phase", [0.0, 0.4])
def test_half_way_between_two_turned_bodies_is_the_body_turned_half_way(phase):
    """The straight line makes its softest motion twenty times as stiff."""
    (M, first), (_, half), (_, last) = (body(share * ANGLE, phase) for share in (0.0, 0.5, 1.0))
    turning = Turning.between(M, first, last)
    for share, K in ((0.0, first), (1.0, last)):
        np.testing.assert_allclose(turning.at(share), K, atol=1e-10 * np.abs(K).max())
    values, shapes = linalg.eigh(half, M)
    np.testing.assert_allclose(squares(M, turning.at(0.5)), values[:4], rtol=1e-2)
    energies = np.sum(shapes[:, :4].conj() * (turning.at(0.5) @ shapes[:, :4]), axis=0).real
    np.testing.assert_allclose(energies, values[:4], rtol=2e-2)
    assert squares(M, 0.5 * (first + last))[0] > 20.0 * values[0]


def test_what_does_not_turn_goes_straight():
    """Equal shapes; and a stiffening of the soft motions alone, which changes their shapes, to a thousandth."""
    M, K = body(0.3)
    np.testing.assert_allclose(Turning.between(M, K, 1.7 * K).at(0.4), 1.28 * K, atol=1e-10 * np.abs(K).max())
    across = np.array([-np.sin(0.3), np.cos(0.3)])
    added = np.kron(np.diag(np.linspace(0.1, 0.9, 8)), np.outer(across, across))
    between = Turning.between(M, K, K + added).at(0.5)
    np.testing.assert_allclose(squares(M, between), squares(M, K + 0.5 * added), rtol=1e-3)


def test_a_free_body_beside_stays_free():
    """Motions that no K resists do not set what is soft."""
    (M, first), (_, last) = body(0.0), body(ANGLE)
    wide = [linalg.block_diag(each, 5.0 * np.eye(3) if each is M else np.zeros((3, 3))) for each in (M, first, last)]
    K = Turning.between(*wide).at(0.5)
    np.testing.assert_allclose(K[16:], 0.0, atol=1e-10 * np.abs(first).max())
    np.testing.assert_allclose(K[:16, :16], Turning.between(M, first, last).at(0.5), atol=1e-9 * np.abs(first).max())


def test_a_row_that_is_much_stiffer_changes_nothing():
    """It made all motions soft in the geometric mean of the lowest and the highest frequency, and nothing turned."""
    (M, first), (_, last) = body(0.0), body(ANGLE)
    wide = [linalg.block_diag(each, 1.0 if each is M else 1e10) for each in (M, first, last)]
    np.testing.assert_allclose(squares(wide[0], Turning.between(*wide).at(0.5)), squares(*body(0.5 * ANGLE)), rtol=1e-2)


def test_from_the_other_end_it_is_the_same():
    (M, first), (_, last) = body(0.0), body(ANGLE)
    there, back = Turning.between(M, first, 1.5 * last).at(0.3), Turning.between(M, 1.5 * last, first).at(0.7)
    np.testing.assert_allclose(there, back, atol=1e-10 * np.abs(first).max())
    assert there.dtype == np.float64


@pytest.mark.parametrize(
    ("first", "last"),
    [((-1.8, 1.0, 4.0), (4.0, 1.0, 0.5)), ((1.0, 4.0, -2.0), (2.0, 4.0, 1.0)), ((-1.0, -1.0, 0.0), (0.0, -2.0, -3.0))],
)
def test_negative_stiffness_is_soft(first, last):
    """Nothing turns; eigenvalues near −c had no polar factor."""
    ends = np.diag(first), np.diag(last)
    np.testing.assert_allclose(Turning.between(np.eye(3), *ends).at(0.25), 0.75 * ends[0] + 0.25 * ends[1], atol=1e-12)
