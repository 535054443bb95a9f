"""The block Lanczos method against closed forms and dense solutions: equal eigenvalues, massless rows, Hermitian matrices."""

import numpy as np
import pytest
from each import each
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from stickslip.model.structure.modes import eigenpairs_above


def chain(size):
    """Springs of 1 N/m between unit masses, both ends held: ω² = 4 sin²(πk/(2(n + 1)))."""
    return sparse.diags_array([np.full(size, 2.0), *2 * [np.full(size - 1, -1.0)]], offsets=[0, 1, -1])


def solution(K, M, shift=0.0):
    return splu(sparse.csc_array(K - shift * M)).solve


def lowest(solve, M, number, shift=0.0, **options):
    """The lowest of the pairs, of which the iteration may find more than it is asked for."""
    pairs = eigenpairs_above(solve, M, number, shift, **options)
    return pairs.squares[:number], pairs.shapes[:, :number]


def test_of_equal_eigenvalues_as_many_are_found_as_there_are_vectors_in_a_block():
    """Twelve equal chains, and a block of twelve."""
    K, M = (sparse.csc_array(sparse.block_diag(12 * [part])) for part in (chain(50), sparse.eye_array(50)))
    squares, shapes = lowest(solution(K, M), M, 36, block=12)
    expected = np.repeat(4.0 * np.sin(np.pi * np.arange(1, 4) / 102.0) ** 2, 12)
    np.testing.assert_allclose(squares, expected, rtol=1e-11)
    np.testing.assert_allclose(shapes.T @ (M @ shapes), np.eye(36), atol=1e-12)
    np.testing.assert_allclose(K @ shapes, (M @ shapes) * squares, atol=1e-9)


def test_rows_without_mass_have_no_mode_of_their_own():
    mass = np.where(np.arange(300) % 3, 1.0, 0.0)
    K, M = sparse.csc_array(chain(300)), sparse.diags_array(mass, format="csc")
    squares, shapes = lowest(solution(K, M), M, 10)
    thetas = linalg.eigh(M.toarray(), K.toarray(), eigvals_only=True)[::-1][:10]
    np.testing.assert_allclose(squares, 1.0 / thetas, rtol=1e-10)
    np.testing.assert_allclose(K @ shapes, (M @ shapes) * squares, atol=1e-9)


def test_where_there_are_fewer_modes_than_asked_for_all_are_found():
    K, M = sparse.csc_array(chain(60)), sparse.diags_array(np.where(np.arange(60) < 11, 1.0, 0.0), format="csc")
    squares, _ = lowest(solution(K, M), M, 20)
    assert squares.size == 11
    condensed = linalg.inv(linalg.inv(K.toarray())[:11, :11])
    np.testing.assert_allclose(squares, linalg.eigvalsh(condensed), rtol=1e-8)


@each("shift", [0.0, 0.5, -0.1])
def test_modes_above_a_shift_of_a_hermitian_matrix(shift):
    draw = np.random.default_rng(3).standard_normal((2, 80, 80))
    random = draw[0] + 1j * draw[1]
    K = chain(80).toarray() + 0.01 * (random + random.conj().T)
    M = np.eye(80) + 0.001 * (random @ random.conj().T)
    mass = sparse.csc_array(M)
    squares, shapes = lowest(lambda loads: linalg.solve(K - shift * mass.toarray(), loads), mass, 6, shift)
    every = linalg.eigh(K, M, eigvals_only=True)
    np.testing.assert_allclose(squares, every[every > shift][:6], rtol=1e-10)
    np.testing.assert_allclose(shapes.conj().T @ (M @ shapes), np.eye(6), atol=1e-12)
    np.testing.assert_allclose(K @ shapes, (M @ shapes) * squares, atol=1e-8)


def test_known_vectors_are_not_met_again():
    """As rigid motions and what an earlier iteration found are left out: here the lowest mode."""
    K, M = chain(200), sparse.eye_array(200, format="csc")
    first = np.sin(np.pi * np.arange(1, 201) / 201.0)[:, None]
    squares, _ = lowest(solution(K, M), M, 3, known=first / np.linalg.norm(first))
    assert squares == pytest.approx(4.0 * np.sin(np.pi * np.arange(2, 5) / 402.0) ** 2, rel=1e-10)


@each("scale", [1e-9, 1e9])
def test_units_do_not_matter(scale):
    squares, _ = lowest(solution(scale * chain(200), scale * sparse.eye_array(200)), sparse.eye_array(200, format="csc"), 5)
    assert squares / scale == pytest.approx(4.0 * np.sin(np.pi * np.arange(1, 6) / 402.0) ** 2, rel=1e-10)


def test_what_lies_beyond_is_bounded_from_above():
    """Ritz: the values at which the iteration has not converged yet are too high, never too low."""
    exact = 4.0 * np.sin(np.pi * np.arange(1, 201) / 402.0) ** 2
    K, M = chain(200), sparse.eye_array(200, format="csc")
    squares, _, beyond = eigenpairs_above(solution(K, M), M, 5)
    assert beyond.size > 3
    assert np.all(beyond >= exact[squares.size : squares.size + beyond.size] * (1.0 - 1e-12))
