"""Kernels that are compiled once, by themselves, and called through an address.

numba compiles a kernel with all that it calls, so what many kernels hold is compiled many times. A kernel of this kind is not;
its signatures are known, and a law that no contact has is never compiled.
"""

from __future__ import annotations

import ctypes
import inspect
from collections.abc import Callable
from typing import Any, TypeVar

import numba
from llvmlite import binding, ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from stickslip.kernels.decorators import inner

_Function = TypeVar("_Function", bound=Callable[..., Any])

_SEPARATE: dict[Any, list[_Separate]] = {}
"""The separate kernels, one for each signature, by what stands for them in the kernels that call them."""


class _Separate:
    """A kernel with one signature; `address` is a place in memory, known to compiled code by name, that holds where it lies."""

    def __init__(self, function: Callable[..., Any], signature: Callable[[], Any], number: int) -> None:
        self.function, self.signature = function, signature
        self.name = f"{function.__module__}.{function.__qualname__}".replace(".", "_") + (f"_{number}" if number else "")
        self.address = ctypes.c_size_t(0)
        binding.add_symbol(self.name, ctypes.addressof(self.address))
        self.dispatcher: Any = inner(function)

    def compile(self) -> None:
        """Compile it, or take it from disk."""
        if not self.address.value:
            wanted = self.signature()
            self.dispatcher.compile(wanted)
            found = self.dispatcher.overloads[wanted.args]
            self.address.value = found.library.get_pointer_to_function(found.fndesc.llvm_func_name)

    def code(self, context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        """Code of a call through the address; errors go on to the caller."""
        module, convention, place = builder.module, context.call_conv, ir.IntType(8).as_pointer()
        held = module.globals.get(self.name) or ir.GlobalVariable(module, place, self.name)
        found = builder.load(held)
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, found)):
            convention.return_user_exc(builder, RuntimeError, (f"{self.name} is not compiled.",))
        kind = convention.get_function_type(signature.return_type, signature.args).as_pointer()
        status, result = convention.call_function(
            builder, builder.bitcast(found, kind), signature.return_type, signature.args, arguments
        )
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return result


def separate(*signatures: Callable[[], Any]) -> Callable[[_Function], _Function]:
    """A kernel that is compiled once, by itself, and not again with each kernel that calls it; from Python it cannot be called.

    signatures: each gives one signature; the types of a call must be those of one. `compiled` must have been called with it
    before any kernel that calls it runs. A law that no contact has is so never compiled.
    """

    def decorated(function: _Function) -> _Function:
        made = [_Separate(function, signature, number) for number, signature in enumerate(signatures)]

        def call(context: Any, *arguments: Any) -> tuple[Any, Callable[..., Any]]:
            given = tuple(types.unliteral(each) for each in arguments)
            for each in made:
                wanted = each.signature()
                if given == wanted.args:
                    return wanted, each.code
            raise numba.TypingError(f"{made[0].name} takes {wanted.args}, but is called with {arguments}.")

        names = inspect.signature(function).parameters
        parameters = [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in ("context", *names)]
        call.__name__, call.__signature__ = made[0].name, inspect.Signature(parameters)  # type: ignore[attr-defined]
        found: Any = intrinsic(call)
        _SEPARATE[found] = made
        return found  # type: ignore[no-any-return]

    return decorated


def compiled(*kernels: Callable[..., Any], number: int = 0) -> None:
    """Compile separate kernels, or take them from disk, unless this process has done so. number: which of their signatures."""
    for each in kernels:
        _SEPARATE[each][number].compile()
