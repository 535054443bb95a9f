"""The block Lanczos method against closed forms and dense solutions: equal eigenvalues, massless rows, Hermitian matrices."""

import numpy as np
import pytest
from each import each
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from stickslip.model.structure.block_lanczos import eigenpairs_above


def chain(size):
    """Springs of 1 N/m between unit masses, both ends held: ω² = 4 sin²(πk/(2(n + 1)))."""
    return sparse.diags_array([np.full(size, 2.0), *2 * [np.full(size - 1, -1.0)]], offsets=[0, 1, -1])


def solution(K, M, shift=0.0):
    return splu(sparse.csc_array(K - shift * M)).solve


def test_equal_eigenvalues_are_found_as_often_as_they_are_there():
    """Twelve equal chains, more than vectors of a block."""
    K, M = (sparse.csc_array(sparse.block_diag(12 * [part])) for part in (chain(50), sparse.eye_array(50)))
    squares, shapes = eigenpairs_above(solution(K, M), M, 36)
    expected = np.repeat(4.0 * np.sin(np.pi * np.arange(1, 4) / 102.0) ** 2, 12)
    np.testing.assert_allclose(squares, expected, rtol=1e-11)
    np.testing.assert_allclose(shapes.T @ (M @ shapes), np.eye(36), atol=1e-12)
    np.testing.assert_allclose(K @ shapes, (M @ shapes) * squares, atol=1e-9)


def test_rows_without_mass_have_no_mode_of_their_own():
    mass = np.where(np.arange(300) % 3, 1.0, 0.0)
    K, M = sparse.csc_array(chain(300)), sparse.diags_array(mass, format="csc")
    squares, shapes = eigenpairs_above(solution(K, M), M, 10)
    thetas = linalg.eigh(M.toarray(), K.toarray(), eigvals_only=True)[::-1][:10]
    np.testing.assert_allclose(squares, 1.0 / thetas, rtol=1e-10)
    np.testing.assert_allclose(K @ shapes, (M @ shapes) * squares, atol=1e-9)


def test_where_there_are_fewer_modes_than_asked_for_all_are_found():
    K, M = sparse.csc_array(chain(60)), sparse.diags_array(np.where(np.arange(60) < 11, 1.0, 0.0), format="csc")
    squares, _ = eigenpairs_above(solution(K, M), M, 20)
    assert squares.size == 11
    condensed = linalg.inv(linalg.inv(K.toarray())[:11, :11])
    np.testing.assert_allclose(squares, linalg.eigvalsh(condensed), rtol=1e-8)


@each("shift", [0.0, 0.5, -0.1])
def test_modes_above_a_shift_of_a_hermitian_matrix(shift):
    draw = np.random.default_rng(3).standard_normal((2, 80, 80))
    random = draw[0] + 1j * draw[1]
    K = chain(80).toarray() + 0.01 * (random + random.conj().T)
    M = np.eye(80) + 0.001 * (random @ random.conj().T)
    squares, shapes = eigenpairs_above(lambda loads: linalg.solve(K - shift * M, loads), sparse.csc_array(M), 6, shift, complex)
    every = linalg.eigh(K, M, eigvals_only=True)
    np.testing.assert_allclose(squares, every[every > shift][:6], rtol=1e-10)
    np.testing.assert_allclose(shapes.conj().T @ (M @ shapes), np.eye(6), atol=1e-12)
    np.testing.assert_allclose(K @ shapes, (M @ shapes) * squares, atol=1e-8)


def test_vectors_that_the_solution_leaves_out_are_not_met():
    """As rigid motions are deflated: the lowest mode is projected out."""
    K, M = chain(200), sparse.eye_array(200, format="csc")
    lowest = np.sin(np.pi * np.arange(1, 201) / 201.0)[:, None]
    lowest /= np.linalg.norm(lowest)
    solve = solution(K, M)
    squares, _ = eigenpairs_above(lambda loads: (x := solve(loads)) - lowest @ (lowest.T @ x), M, 3)
    assert squares == pytest.approx(4.0 * np.sin(np.pi * np.arange(2, 5) / 402.0) ** 2, rel=1e-10)
