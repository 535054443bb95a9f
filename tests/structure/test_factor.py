"""Factors of sparse symmetric matrices by either solver: solutions, signs of eigenvalues, weak pivots; which of them is taken.

MKL PARDISO and METIS are tested where they are installed.
"""

import logging
import os
import subprocess
import sys
from importlib import util

import numpy as np
import pytest
from scipy import linalg, sparse
from threadpoolctl import threadpool_limits

import stickslip as ss
from stickslip.model.structure import factor, pardiso
from stickslip.model.structure.cyclic_reduction import craig_bampton
from stickslip.model.structure.factor import Factor, Singular, nested_dissection
from stickslip.model.structure.solid import box_mesh, solid
from stickslip.support import machine

needs_metis = pytest.mark.skipif(util.find_spec("pymetis") is None, reason="no wheel of pymetis for this machine")
needs_mkl = pytest.mark.skipif(not pardiso.usable(), reason="no wheel of MKL for this machine")
LIMITS = {"SuperLU": 10**9, "SuperLU with METIS": 1, "MKL PARDISO": 1}


@pytest.fixture(
    params=["SuperLU", pytest.param("SuperLU with METIS", marks=needs_metis), pytest.param("MKL PARDISO", marks=needs_mkl)]
)
def chosen(request, monkeypatch):
    """One of the solvers, for matrices of any size."""
    monkeypatch.setattr(factor, "LARGE", LIMITS[request.param])
    monkeypatch.setattr(pardiso, "usable", lambda: request.param == "MKL PARDISO")
    return request.param.partition(" with")[0]


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
    assert any(text.startswith("factorising") and f"by {chosen}" in text for text in messages)
    np.testing.assert_allclose(held.frequencies, fixed_frequencies(free, list(kept.values()))[:5], rtol=1e-8)


def fixed_frequencies(free, rows):
    """Hz, with `rows` held, by a dense solver."""
    inside = np.setdiff1d(np.arange(free.K.shape[0]), rows)
    K, M = (matrix.toarray()[np.ix_(inside, inside)] for matrix in (free.K, free.M))
    return np.sqrt(linalg.eigvalsh(K, M)) / (2.0 * np.pi)


def test_small_matrices_and_those_without_the_extra_go_to_scipy(monkeypatch):
    assert factor.solver(factor.LARGE - 1).name == "SuperLU"
    monkeypatch.setattr(pardiso, "usable", lambda: False)
    assert factor.solver(10**6).name == "SuperLU"
    monkeypatch.setattr(pardiso, "usable", lambda: True)
    assert factor.solver(10**6).name == "MKL PARDISO"


def test_nested_dissection_orders_all_rows_and_saves_memory(monkeypatch):
    """A block of 3375 nodes; without the package the factoriser orders by itself."""
    pytest.importorskip("pymetis")
    grid = np.linspace(0.0, 0.02, 8)
    body = solid(box_mesh(grid, grid, grid)).clamp(lambda points: points[:, 1] < 1e-9)
    order = nested_dissection(body.K)
    assert sorted(order) == list(range(body.size))
    ours = factor.SuperLU(body.K)
    monkeypatch.setattr("stickslip.model.structure.factor.METIS", "no_such_package")
    assert nested_dissection(body.K) is None
    others = factor.SuperLU(body.K)
    assert ours.mebibytes < 0.8 * others.mebibytes
    loads = np.random.default_rng(0).standard_normal((body.size, 2))
    np.testing.assert_allclose(ours.solve(loads), others.solve(loads), rtol=1e-6, atol=1e-9 * np.abs(others.solve(loads)).max())


def test_a_library_that_does_not_load_is_replaced_with_one_sentence(monkeypatch, tmp_path, caplog):
    """A package whose wrapper raises as pypardiso does without MKL."""
    (tmp_path / "broken_pardiso").mkdir()
    (tmp_path / "broken_pardiso" / "__init__.py").write_text("")
    raising = "class PyPardisoSolver:\n    def __init__(self, mtype):\n        raise ImportError('mkl_rt not found')\n"
    (tmp_path / "broken_pardiso" / "pardiso_wrapper.py").write_text(raising)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(pardiso, "PACKAGE", "broken_pardiso")
    pardiso.usable.cache_clear()
    try:
        with caplog.at_level(logging.WARNING, "stickslip"):
            assert [factor.solver(10**6).name for _ in range(2)] == ["SuperLU", "SuperLU"]
    finally:
        pardiso.usable.cache_clear()
    (record,) = caplog.records
    assert "MKL does not load (mkl_rt not found). SuperLU takes its place" in record.getMessage()


@needs_mkl
def test_the_environment_is_not_searched_for_the_library(monkeypatch):
    """A search of all installed files takes 0.3 s, and the package would make one for every matrix."""
    monkeypatch.delenv(pardiso.PATH_OF_MKL, raising=False)
    pardiso.usable.cache_clear()
    monkeypatch.setattr("glob.glob", lambda *arguments, **options: pytest.fail("a search"))
    assert pardiso.usable()
    assert pardiso.Pardiso(sparse.csc_array(np.eye(2))).negative == 0


TWICE = """
import hashlib
import numpy as np
from stickslip.model.structure.cyclic_reduction import craig_bampton
from stickslip.model.structure.solid import box_mesh, solid
body = solid(box_mesh(*(np.linspace(0.0, size, 1 + cells) for size, cells in ((0.02, 4), (0.05, 6), (0.15, 16)))))
body = body.clamp(lambda points: points[:, 2] < 1e-9)
found = craig_bampton(body.M, body.K, body.named({"tip": (0.02, 0.0, 0.15), "end": (0.0, 0.05, 0.15)}), 20)
print(hashlib.md5(found.transformation.tobytes()).hexdigest())
"""


@pytest.mark.nightly
@needs_mkl
def test_two_runs_with_several_threads_give_the_same_bits():
    """Sums of threads that come in any order differed in the last digits."""
    environment = os.environ | {"MKL_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"}
    environment.pop(pardiso.REPRODUCIBILITY, None)
    runs = [
        subprocess.run([sys.executable, "-c", TWICE], check=True, capture_output=True, text=True, env=environment)
        for _ in range(3)
    ]
    assert len({run.stdout for run in runs}) == 1


@needs_mkl
def test_the_memory_of_a_factor_is_said_before_it_is_made(free, monkeypatch):
    """The analysis knows it: what is said is what the factor then takes, and what the machine has not is refused.

    Several threads have buffers of their own, beside which the factor of so small a matrix is nothing.
    """
    monkeypatch.setattr(factor, "LARGE", 1)
    said = []
    held = free.K + sparse.csc_array(1e-3 * free.M * free.K.diagonal().max() / free.M.diagonal().max())
    with threadpool_limits(1):
        found = Factor(held, said.append)
    (sentence,) = said
    assert sentence.startswith(f"factorising the stiffness of {held.shape[0]} rows by MKL PARDISO, ")
    own, whole = (float(words.partition(" GiB")[0]) for words in sentence.split(", ")[1:])
    assert own == pytest.approx(found.megabytes / 1024.0, rel=0.3)
    assert whole == pytest.approx(own + machine.taken() / 2**30, rel=0.1)
    monkeypatch.setattr(machine, "memory", lambda: machine.taken() + 1000)
    with pytest.raises(ss.InputError, match=r"must fit into .* the machine's memory, but is .* coarser mesh"):
        Factor(held)


def test_a_large_matrix_without_mkl_names_the_extra(monkeypatch):
    said = []
    monkeypatch.setattr(pardiso, "PACKAGE", "no_such_package")
    monkeypatch.setattr(pardiso.sys, "platform", "linux")
    monkeypatch.setattr(pardiso.platform, "machine", lambda: "x86_64")
    factor.SuperLU(sparse.csc_array(sparse.eye_array(factor.LARGE)), said.append)
    factor.SuperLU(sparse.csc_array(np.eye(2)), said.append)
    assert ["stickslip[mkl]" in words for words in said] == [True, False]
    monkeypatch.setattr(pardiso.platform, "machine", lambda: "arm64")
    assert pardiso.advice() == ""
