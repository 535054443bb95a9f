"""SciPy sparse M, C and K of every format and number type make the structure that dense ones make; wrong ones are refused."""

import numpy as np
import pytest
from each import each
from scipy import sparse

from stickslip.model.structure.cyclic import sector_chain
from stickslip.model.structure.matrices import Structure, symmetric_sparse
from stickslip.support.checks import InputError

DOFS = ("1.x", "2.x", "3.x")
M, C, K = np.diag([2, 3, 4]), np.diag([1, 0, 2]), np.array([[5, -2, 0], [-2, 6, -1], [0, -1, 7]])
FORMATS = ("csr", "csc", "coo", "lil", "dok", "dia", "bsr")
KINDS = [*(getattr(sparse, f"{name}_array") for name in FORMATS), *(getattr(sparse, f"{name}_matrix") for name in FORMATS)]


@each("kind", KINDS, ids=lambda kind: kind.__name__)
@each("dtype", ["int8", "int64", "uint16", "float32", "float64", "complex128"])
def test_every_format_makes_the_same_structure(kind, dtype):
    signed = "int64" if dtype == "uint16" else dtype
    made = Structure(kind(M.astype(dtype)), kind(K.astype(signed)), DOFS, C=kind(C.astype(dtype)))
    for name, expected in (("M", M), ("C", C), ("K", K)):
        found = getattr(made, name)
        assert type(found) is np.ndarray
        assert found.dtype == float
        np.testing.assert_array_equal(found, expected)


def test_entries_stored_twice_are_summed():
    twice = sparse.coo_array(([1.0, 1.0, 3.0], ([0, 0, 1], [0, 0, 1])), shape=(2, 2))
    np.testing.assert_array_equal(Structure(twice, sparse.eye_array(2), DOFS[:2]).M, np.diag([2.0, 3.0]))


def test_damping_set_later_and_couplings_of_a_sector_may_be_sparse():
    structure = Structure(M, K, DOFS)
    np.testing.assert_array_equal(structure.with_damping(sparse.csr_array(C)).C, C)
    dense, stored = (sector_chain(structure, 6, next_) for next_ in (-0.1 * np.eye(3), -0.1 * sparse.eye_array(3)))
    np.testing.assert_array_equal(dense.stiffnesses, stored.stiffnesses)


@each(
    ("matrix", "message"),
    [
        (sparse.csr_array(1j * K), r"K must be real, but is 'complex, as 5j'"),
        (sparse.csr_array(K[:2]), r"K must be a square matrix, but is \(2, 3\)"),
        (sparse.coo_array(np.arange(3.0)), r"K must be a square matrix, but is \(3,\)"),
        (sparse.csr_array(K[:2, :2]), r"K must have shape \(3, 3\), but is \(2, 2\)"),
        (sparse.csr_array(np.triu(K)), r"K must be symmetric"),
        (sparse.csr_array(np.where(K == 7, np.nan, K)), r"K\[2, 2\] must be finite"),
        (sparse.csr_array((100_000, 100_000)), r"K must have at most 20000 rows, but is 100000.*read_structure"),
    ],
)
def test_wrong_sparse_matrices_are_refused(matrix, message):
    with pytest.raises(InputError, match=message):
        Structure(M, matrix, DOFS)


def test_what_was_checked_is_not_checked_again_and_its_copy_is():
    checked = symmetric_sparse("K", np.array([[2.0, -1.0], [-1.0, 2.0]]))
    assert symmetric_sparse("K", checked) is checked
    copy = checked.copy()
    copy.data[1] = -3.0
    with pytest.raises(InputError, match="K must be symmetric"):
        symmetric_sparse("K", copy)
