"""What turns a function into a compiled kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

from stickslip.support.kernels.cache import kept

_Function = TypeVar("_Function", bound=Callable[..., Any])


def kernel(function: _Function) -> _Function:
    """A compiled function that Python calls, without holding Python's lock; what is compiled is kept for later processes."""
    return kept(numba.njit(no_cfunc_wrapper=True, nogil=True)(function))  # type: ignore[call-overload, no-any-return]


def inner(function: _Function) -> _Function:
    """A compiled function that other kernels call; without what Python would need to call it, which is a fifth of the work."""
    return kept(numba.njit(no_cpython_wrapper=True, no_cfunc_wrapper=True)(function))  # type: ignore[call-overload, no-any-return]


def inlined(function: _Function) -> _Function:
    """A function written into the kernels that call it, instead of compiled by itself."""
    return numba.njit(inline="always")(function)  # type: ignore[return-value]


def uncompiled(function: _Function) -> _Function:
    """The Python function behind a kernel, for a call that need not be fast."""
    return function.py_func  # type: ignore[attr-defined, no-any-return]
