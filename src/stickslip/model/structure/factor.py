"""Factorisation of a sparse symmetric matrix: solutions, inertia and memory.

MKL PARDISO does it for large matrices, where it is installed; SciPy's SuperLU for small ones and elsewhere.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from stickslip.model.structure import pardiso
from stickslip.model.structure.pardiso import Pardiso
from stickslip.model.structure.sparse import Report, Sparse
from stickslip.model.structure.superlu import SuperLU
from stickslip.support.checks import Array

LARGE = 3000
"""Rows from which the faster solver is worth its start."""


class Singular(ValueError):
    """The matrix has no factor."""


def solver(rows: int) -> type[SuperLU | Pardiso]:
    """What factorises a matrix of so many rows."""
    return Pardiso if rows >= LARGE and pardiso.usable() else SuperLU


class Factor:
    """A = D⁻¹ F D⁻¹ of symmetric A (n, n), D scaling its diagonal to ±1 and F factorised in an order of little fill.

    negative: how many eigenvalues of A are below zero; weak: how many pivots of F are indistinguishable from zero, so that A
    is singular; megabytes: the memory of the factor, MiB. report(text) is called with what is being done, for large matrices.
    """

    def __init__(self, matrix: Sparse, report: Report = lambda text: None) -> None:
        diagonal = np.abs(matrix.diagonal())
        if np.any(diagonal == 0.0):
            raise Singular("a row without a diagonal entry")
        self.scale = 1.0 / np.sqrt(diagonal)
        scaling = sparse.diags_array(self.scale)
        try:
            self._factor = solver(matrix.shape[0])(sparse.csc_array(scaling @ matrix @ scaling), report)
        except ArithmeticError as error:
            raise Singular(str(error)) from None
        self.negative, self.weak, self.megabytes = self._factor.negative, self._factor.weak, self._factor.mebibytes

    def solve(self, loads: Array) -> Array:
        """A⁻¹ loads, for loads (n,) or (n, loads)."""
        scale = self.scale if loads.ndim == 1 else self.scale[:, None]
        return np.asarray(scale * self._factor.solve(scale * loads))


class HermitianFactor:
    """The factor of a Hermitian A = S + iW (n, n), real or complex; a complex one as the real symmetric [[S, −W], [W, S]].

    negative, weak: as those of `Factor`, twice as many for a complex matrix; megabytes: the memory of the factor, MiB.
    """

    def __init__(self, matrix: Any, report: Report = lambda text: None) -> None:
        self.size, self.complex = matrix.shape[0], np.iscomplexobj(matrix)
        real = (
            sparse.csc_array(sparse.block_array(((matrix.real, -matrix.imag), (matrix.imag, matrix.real))))
            if self.complex
            else matrix
        )
        self._factor = Factor(real, report)
        self.negative, self.weak, self.megabytes = self._factor.negative, self._factor.weak, self._factor.megabytes

    def solve(self, loads: NDArray[Any]) -> NDArray[Any]:
        """A⁻¹ loads, for loads (n,) or (n, loads)."""
        if not self.complex:
            return self._factor.solve(loads)
        both = self._factor.solve(np.concatenate([loads.real, loads.imag]))
        return np.asarray(both[: self.size] + 1j * both[self.size :])
