"""Factors of sparse symmetric matrices by either solver: solutions, signs of eigenvalues, weak pivots; which of them is taken.

MKL PARDISO needs the extra `fast` (pip install "stickslip[fast]"); without it, only SuperLU is tested.
"""

import numpy as np
import pytest
from scipy import linalg, sparse

from stickslip.structure import factor, pardiso
from stickslip.structure.craig_bampton import craig_bampton
from stickslip.structure.factor import Factor, Singular
from stickslip.structure.solid import box_mesh, solid

needs_fast = pytest.mark.skipif(not pardiso.installed(), reason='needs pypardiso: pip install "stickslip[fast]"')
LIMITS = {"SuperLU": 10**9, "MKL PARDISO": 1}


@pytest.fixture(params=["SuperLU", pytest.param("MKL PARDISO", marks=needs_fast)])
def chosen(request, monkeypatch):
    """One of the solvers, for matrices of any size."""
    monkeypatch.setattr(factor, "LARGE", LIMITS[request.param])
    return request.param


@pytest.fixture(scope="module")
def free():
    """A free beam of steel."""
    return solid(box_mesh(np.linspace(0, 0.01, 2), np.linspace(0, 0.01, 2), np.linspace(0, 0.06, 7)))


@pytest.mark.parametrize("share", [-1e-7, 1e-5, 1e-3, 0.1])
def test_signs_and_solutions(chosen, free, share):
    """Against all eigenvalues, by a dense solver, on either side of many of them."""
    shift = share * np.max(free.K.diagonal() / free.M.diagonal())
    matrix = sparse.csc_array(free.K - shift * free.M)
    found = Factor(matrix)
    assert found.negative == int(np.sum(linalg.eigvalsh(free.K.toarray(), free.M.toarray()) < shift))
    assert found.weak == 0
    assert 0.01 < found.megabytes < 10.0
    expected = np.random.default_rng(0).standard_normal((matrix.shape[0], 3))
    np.testing.assert_allclose(found.solve(matrix @ expected), expected, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found.solve(matrix @ expected[:, 0]), expected[:, 0], rtol=1e-6, atol=1e-6)


def test_a_body_that_is_not_held(chosen, free):
    try:
        found = Factor(free.K)
    except Singular:
        return
    assert found.weak or found.negative


def test_a_row_without_a_diagonal_entry(chosen):
    with pytest.raises(Singular):
        Factor(sparse.csc_array([[0.0, 1.0], [1.0, 1.0]]))


def test_progress_names_the_solver(chosen, free):
    messages = []
    kept = {f"{row}.q": row for row in (*free.numbers[0], *free.numbers[3], *free.numbers[-1])}
    held = craig_bampton(free.M, free.K, kept, 5, lambda share, text: messages.append(text))
    assert any(text.endswith(f"rows by {chosen}") for text in messages)
    np.testing.assert_allclose(held.frequencies, fixed_frequencies(free, list(kept.values()))[:5], rtol=1e-8)


def fixed_frequencies(free, rows):
    """Hz, with `rows` held, by a dense solver."""
    inside = np.setdiff1d(np.arange(free.K.shape[0]), rows)
    K, M = (matrix.toarray()[np.ix_(inside, inside)] for matrix in (free.K, free.M))
    return np.sqrt(linalg.eigvalsh(K, M)) / (2.0 * np.pi)


def test_small_matrices_and_those_without_the_extra_go_to_scipy(monkeypatch):
    assert factor.solver(factor.LARGE - 1).name == "SuperLU"
    monkeypatch.setattr(pardiso, "installed", lambda: False)
    assert factor.solver(10**6).name == "SuperLU"
    monkeypatch.setattr(pardiso, "installed", lambda: True)
    assert factor.solver(10**6).name == "MKL PARDISO"
