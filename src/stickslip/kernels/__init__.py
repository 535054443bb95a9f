"""Compiled kernels: how they are made, kept on disk and called.

Begin with `decorators`: `kernel` for functions that Python calls, `inner` and `inlined` for those that only kernels call. A large
kernel that many others call is `separate`; it sees the tables of its caller through a `view`.
"""

from stickslip.kernels import cache, passes, results
from stickslip.kernels.decorators import inlined, inner, kernel
from stickslip.kernels.separate import compiled, separate

__all__ = ["cache", "compiled", "inlined", "inner", "kernel", "passes", "results", "separate"]
