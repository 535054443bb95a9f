"""Compiled kernels: how they are made, kept on disk and called.

Begin with `decorators`: `kernel` for functions that Python calls, `inner` and `inlined` for those that only kernels call. A large
kernel that many others call is `separate`; it sees the tables of its caller through a `view`.
"""

from stickslip.support.kernels import cache
from stickslip.support.kernels.decorators import by_types, compiled, inlined, inner, kernel, separate, uncompiled
from stickslip.support.kernels.results import boxed

__all__ = ["boxed", "by_types", "cache", "compiled", "inlined", "inner", "kernel", "separate", "uncompiled"]
