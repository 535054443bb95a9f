"""LU factorisation and added products by SciPy's LAPACK and BLAS, called from compiled code.

Matrices lie by rows, LAPACK reads them by columns: it factorises the transpose, and solves with the transpose of that.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]
from numba import types
from numba.extending import get_cython_function_address
from numpy.typing import NDArray

from stickslip.support.checks import Array
from stickslip.support.kernels import inner

for _name in ("dgetrf", "dgetrs"):
    # A symbol by name, not an address: kernels that call it can be cached.
    binding.add_symbol(f"stickslip_{_name}", get_cython_function_address("scipy.linalg.cython_lapack", _name))
binding.add_symbol("stickslip_dgemm", get_cython_function_address("scipy.linalg.cython_blas", "dgemm"))

_pointer: Any = types.CPointer
_integers, _doubles, _letters = _pointer(types.int32), _pointer(types.float64), _pointer(types.uint8)
_dgetrf: Any = types.ExternalFunction("stickslip_dgetrf", types.void(*[_integers] * 2, _doubles, *[_integers] * 3))
_dgetrs: Any = types.ExternalFunction(
    "stickslip_dgetrs", types.void(_letters, *[_integers] * 2, _doubles, *[_integers] * 2, _doubles, *[_integers] * 2)
)
_dgemm: Any = types.ExternalFunction(
    "stickslip_dgemm",
    types.void(
        *[_letters] * 2, *[_integers] * 3, _doubles, _doubles, _integers, _doubles, _integers, _doubles, _doubles, _integers
    ),
)

_TRANSPOSED, _AS_IT_IS = ord("T"), ord("N")


@inner
def lu_factor(matrix: Array) -> NDArray[np.int32]:
    """Overwrite a matrix (N, N) with its factors; the pivots (N,)."""
    size, info = np.array([matrix.shape[0]], dtype=np.int32), np.zeros(1, dtype=np.int32)
    pivots = np.empty(matrix.shape[0], dtype=np.int32)
    _dgetrf(size.ctypes, size.ctypes, matrix.ctypes, size.ctypes, pivots.ctypes, info.ctypes)
    return pivots


@inner
def lu_solve(lu: Array, pivots: NDArray[np.int32], right: Array) -> None:
    """Overwrite right-hand sides (k, N) with the solutions of A x = b."""
    _solve(lu, pivots, right, _TRANSPOSED)


@inner
def lu_solve_transposed(lu: Array, pivots: NDArray[np.int32], right: Array) -> None:
    """Overwrite right-hand sides (k, N) with the solutions of Aᵀ x = b."""
    _solve(lu, pivots, right, _AS_IT_IS)


@inner
def _solve(lu: Array, pivots: NDArray[np.int32], right: Array, flag: int) -> None:
    form = np.array([flag], dtype=np.uint8)
    size, count = np.array([lu.shape[0]], dtype=np.int32), np.array([right.shape[0]], dtype=np.int32)
    info = np.zeros(1, dtype=np.int32)
    _dgetrs(
        form.ctypes,
        size.ctypes,
        count.ctypes,
        lu.ctypes,
        size.ctypes,
        pivots.ctypes,
        right.ctypes,
        size.ctypes,
        info.ctypes,
    )


@inner
def add_product(left: Array, right: Array, result: Array) -> None:
    """result[:m, :n] += leftᵀ right for left (k, m) and right (k, n); result has m rows or more, and n columns or more."""
    flags = np.array([_AS_IT_IS, _TRANSPOSED], dtype=np.uint8)
    sizes = np.array([right.shape[1], left.shape[1], left.shape[0], result.shape[1]], dtype=np.int32)
    one = np.ones(1)
    _dgemm(
        flags.ctypes,
        flags[1:].ctypes,
        sizes.ctypes,
        sizes[1:].ctypes,
        sizes[2:].ctypes,
        one.ctypes,
        right.ctypes,
        sizes.ctypes,
        left.ctypes,
        sizes[1:].ctypes,
        one.ctypes,
        result.ctypes,
        sizes[3:].ctypes,
    )


@inner
def orientation(lu: Array, pivots: NDArray[np.int32]) -> float:
    """Sign of the determinant of a factorised matrix; 0 when it is singular."""
    sign = 1.0
    for i in range(pivots.size):
        sign *= np.sign(lu[i, i])
        if pivots[i] != i + 1:
            sign = -sign
    return sign
