"""Sparse factors by MKL PARDISO, faster and smaller than SciPy's: the extra `mkl`, where wheels of MKL exist.

PARDISO keeps one triangle, A = L D Lᵀ with blocks of 1 and 2 in D, and counts the signs of their eigenvalues: by Sylvester's
law these are the signs of the eigenvalues of A.
"""

import logging
import os
import platform
import sys
import weakref
from contextlib import suppress
from functools import cache
from importlib import import_module, metadata, util
from pathlib import Path

import numpy as np
from scipy import sparse

from stickslip.model.structure.matrices import Report, Sparse
from stickslip.support import machine
from stickslip.support.checks import Array, fault

PACKAGE = "pypardiso"
PATH_OF_MKL = "PYPARDISO_MKL_RT"
"""The environment variable that gives the package the path of MKL."""
REPRODUCIBILITY = "MKL_CBWR"
"""MKL's variable for conditional numerical reproducibility; without it two runs of one study differ in their last digits."""
SYMMETRIC_INDEFINITE = -2
SMALLEST_PIVOT = 13
"""Pivots below 1e-13 of the norm of the matrix are raised to it and counted."""
SETTINGS = {1: 1, 2: 2, 10: SMALLEST_PIVOT, 18: -1, 21: 1}
"""By the numbers of MKL's manual: own settings, nested dissection, smallest pivot, count entries, pivots of 1 and 2."""
NEGATIVE, RAISED, KEPT_KIB, FACTOR_KIB, OUT_OF_MEMORY = 23, 14, 16, 17, -2
ANALYSIS, FACTORISATION, SOLUTION = 11, 22, 33
"""Phases by the numbers of MKL's manual."""
REMEDY = "Take a coarser mesh, let the finite-element program reduce the model, or take a machine with more memory."


def advice() -> str:
    """How to install MKL where it is missing and has wheels; empty elsewhere."""
    has_wheels = sys.platform in ("linux", "win32") and platform.machine() in ("x86_64", "AMD64")
    return ' (MKL is several times faster: pip install "stickslip[mkl]")' if has_wheels and not util.find_spec(PACKAGE) else ""


@cache
def usable() -> bool:
    """Whether the package is there and finds its library; a warning where only the package is."""
    if util.find_spec(PACKAGE) is None:
        return False
    _set_environment_of_mkl()
    try:
        _ = import_module(f"{PACKAGE}.pardiso_wrapper").PyPardisoSolver(mtype=SYMMETRIC_INDEFINITE)._call_pardiso
    except Exception as error:  # whatever a broken installation raises
        logging.getLogger("stickslip").warning(
            "pypardiso is installed, but MKL does not load (%s). SuperLU takes its place, slower and with more memory. "
            "Reinstall both: pip install --force-reinstall pypardiso mkl.",
            error,
        )
        return False
    return True


def _set_environment_of_mkl() -> None:
    """Let threads add up in the same order in each run, and name the path of the library in the wheel of MKL, without which the
    package searches the environment for every matrix; unless the user has set these.
    """
    os.environ.setdefault(REPRODUCIBILITY, "AUTO")
    with suppress(metadata.PackageNotFoundError):
        for file in metadata.files("mkl") or ():
            path = Path(file.locate()).resolve()
            if "mkl_rt" in path.name and path.suffix != ".lib" and path.exists():
                os.environ.setdefault(PATH_OF_MKL, str(path))


class Pardiso:
    """The factor of a symmetric matrix (n, n) whose diagonal has no zeros.

    negative: how many eigenvalues are below zero; weak: how many pivots are indistinguishable from zero.
    report(text): called with the memory that the factor will take, once the order of the rows is known.
    """

    name = "MKL PARDISO"

    def __init__(self, matrix: Sparse, report: Report = lambda text: None) -> None:
        package = import_module(f"{PACKAGE}.pardiso_wrapper")
        self._refusal = package.PyPardisoError
        self._upper = _upper(matrix)
        self._solver = package.PyPardisoSolver(mtype=SYMMETRIC_INDEFINITE)
        for number, value in SETTINGS.items():
            self._solver.set_iparm(number, value)
        weakref.finalize(self, self._solver.free_memory, everything=True).atexit = False
        self._prepare(ANALYSIS)
        self._within_memory(report)
        self._factorise()

    def again(self, matrix: Sparse) -> "Pardiso":
        """Itself with the factor of another matrix with entries at the same places, in the same order and memory."""
        self._upper = _upper(matrix)
        self._factorise()
        return self

    def _factorise(self) -> None:
        self._prepare(FACTORISATION)
        self.negative, self.weak = (int(self._solver.get_iparm(number)) for number in (NEGATIVE, RAISED))

    def _prepare(self, phase: int) -> None:
        """A phase that takes no loads."""
        try:
            self._call(phase, np.zeros((self._upper.shape[0], 1)))
        except self._refusal as error:
            if error.value == OUT_OF_MEMORY:
                raise MemoryError(str(error)) from None
            raise ArithmeticError(str(error)) from None

    @property
    def mebibytes(self) -> float:
        """The memory of the factor, MiB; from the analysis on."""
        return float(self._solver.get_iparm(KEPT_KIB) + self._solver.get_iparm(FACTOR_KIB)) / 1024.0

    def _within_memory(self, report: Report) -> None:
        """Say what the factor will take, and refuse what the machine does not have beside what is taken, before hours of
        swapping."""
        rows, own = self._upper.shape[0], self.mebibytes / 1024.0
        needed, there = own + machine.taken() / 2**30, machine.memory() / 2**30
        if needed > there:
            what = f"The factor of the stiffness of {rows} rows, {own:.1f} GiB, with what is taken already,"
            raise fault(what, f"must fit into {there:.1f} GiB, the machine's memory", f"{needed:.1f} GiB", REMEDY)
        report(f"factorising the stiffness of {rows} rows by {self.name}, {own:.2g} GiB, {needed:.2g} GiB in all")

    def solve(self, loads: Array) -> Array:
        """A⁻¹ loads, for loads (n,) or (n, loads)."""
        return self._call(SOLUTION, np.asfortranarray(loads, dtype=float))

    def _call(self, phase: int, loads: Array) -> Array:
        """One phase. The package's own `solve` compares the whole matrix with a copy of it each time."""
        self._solver.set_phase(phase)
        return np.asarray(self._solver._call_pardiso(self._upper, loads))


def _upper(matrix: Sparse) -> sparse.csr_array:
    """The upper triangle by rows, as the library takes it."""
    upper = sparse.csr_array(sparse.triu(matrix))
    upper.sort_indices()
    return upper
