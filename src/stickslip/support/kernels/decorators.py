"""What turns a function into a compiled kernel.

Kernels that are compiled once, by themselves, and called through an address.

numba compiles a kernel with all that it calls, so what many kernels hold is compiled many times. A kernel of this kind is not;
its signatures are known, and a law that no contact has is never compiled. Of kernels with one signature, the one to call may
also be chosen by its number while the caller runs (`numbered`): the caller then need not know them when it is compiled.
"""

import ctypes
import hashlib
import inspect
from collections.abc import Callable
from typing import Any, TypeVar

import numba
from llvmlite import binding, ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

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


_SEPARATE: "dict[Any, list[_Separate]]" = {}
"""The separate kernels, one for each signature, by what stands for them in the kernels that call them."""


class _Separate:
    """A kernel with one signature; `address` is a place in memory, known to compiled code by name, that holds where it lies."""

    def __init__(self, function: Callable[..., Any], signature: Callable[[], Any], number: int) -> None:
        self.function, self.signature = function, signature
        self.name = f"{function.__module__}.{function.__qualname__}".replace(".", "_") + (f"_{number}" if number else "")
        self.address = ctypes.c_size_t(0)
        binding.add_symbol(self.name, ctypes.addressof(self.address))
        self.dispatcher: Any = inner(function)

    def compile(self) -> int:
        """Compile it, or take it from disk; returns where it lies."""
        if not self.address.value:
            wanted = self.signature()
            self.dispatcher.compile(wanted)
            found = self.dispatcher.overloads[wanted.args]
            self.address.value = found.library.get_pointer_to_function(found.fndesc.llvm_func_name)
        return self.address.value

    def code(self, context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        """Code of a call through the address."""
        return _call(
            self.name,
            builder.load(_place(self.name, builder)),
            context,
            builder,
            signature.return_type,
            signature.args,
            arguments,
        )


def _place(name: str, builder: Any) -> Any:
    """The place in memory of a name, which holds an address, or several one after the other."""
    module = builder.module
    return module.globals.get(name) or ir.GlobalVariable(module, ir.IntType(8).as_pointer(), name)


def _call(name: str, found: Any, context: Any, builder: Any, returned: Any, types_: Any, arguments: Any) -> Any:
    """Code of a call of what lies at an address; errors go on to the caller."""
    convention = context.call_conv
    with cgutils.if_unlikely(builder, cgutils.is_null(builder, found)):
        convention.return_user_exc(builder, RuntimeError, (f"{name} is not compiled.",))
    kind = convention.get_function_type(returned, types_).as_pointer()
    status, result = convention.call_function(builder, builder.bitcast(found, kind), returned, types_, arguments)
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
        return _called_by_types(made)  # type: ignore[no-any-return]

    return decorated


def by_types(*kernels: Callable[..., Any]) -> Any:
    """Of several separate kernels the one whose types a call has; their numbers for `compiled` are those of this order."""
    return _called_by_types([each for kernel in kernels for each in _SEPARATE[kernel]])


def _called_by_types(made: list[_Separate]) -> Any:
    """What stands for some kernels in those that call them."""

    def call(context: Any, *arguments: Any) -> tuple[Any, Callable[..., Any]]:
        given = tuple(types.unliteral(each) for each in arguments)
        for each in made:
            wanted = each.signature()
            if given == wanted.args:
                return wanted, each.code
        raise numba.TypingError(f"{made[0].name} takes {made[0].signature().args}, but is called with {arguments}.")

    found = _intrinsic(call, made[0].name, made[0].function)
    _SEPARATE[found] = made
    return found


def _intrinsic(call: Callable[..., Any], name: str, function: Callable[..., Any]) -> Any:
    """What kernels call, with the arguments of a function."""
    names = inspect.signature(function).parameters
    parameters = [inspect.Parameter(each, inspect.Parameter.POSITIONAL_OR_KEYWORD) for each in ("context", *names)]
    call.__name__, call.__signature__ = name, inspect.Signature(parameters)  # type: ignore[attr-defined]
    return intrinsic(call)


NUMBERS = 2**16
"""Of the kernels that can be called by number."""

_NUMBERED: dict[Any, Any] = {}
"""Addresses of the kernels of a `numbered` call, by what stands for it in the kernels that call it."""


def number_of(kernel: Callable[..., Any]) -> int:
    """The number of a separate kernel: of its module and name alone, and so the same in every process."""
    name = _SEPARATE[kernel][0].name.replace("__mp_main__", "__main__")
    return 1 + int(hashlib.sha256(name.encode()).hexdigest(), 16) % (NUMBERS - 1)


def numbered(signature: Callable[[], Any]) -> Callable[[_Function], _Function]:
    """A call of one of several separate kernels of one signature, by number: the function called so, of which only name and
    arguments count, takes the number first. `hold` says which kernel a number stands for; kernels that come later, of whatever
    module, need no change of the caller."""

    def decorated(function: _Function) -> _Function:
        name = f"{function.__module__}.{function.__qualname__}".replace(".", "_")
        addresses = (ctypes.c_size_t * NUMBERS)()
        binding.add_symbol(name, ctypes.addressof(addresses))

        def code(context: Any, builder: Any, given: Any, arguments: Any) -> Any:
            place = builder.gep(_place(name, builder), [arguments[0]])
            return _call(name, builder.load(place), context, builder, given.return_type, given.args[1:], arguments[1:])

        def call(context: Any, *arguments: Any) -> tuple[Any, Callable[..., Any]]:
            given, wanted = tuple(types.unliteral(each) for each in arguments), signature()
            if given != (types.int64, *wanted.args):
                raise numba.TypingError(f"{name} takes a number and {wanted.args}, but is called with {arguments}.")
            return wanted.return_type(types.int64, *wanted.args), code

        found = _intrinsic(call, name, function)
        _NUMBERED[found] = addresses
        return found  # type: ignore[no-any-return]

    return decorated


def hold(call: Callable[..., Any], number: int, kernel: Callable[..., Any]) -> None:
    """Let a number stand for a separate kernel in a `numbered` call; compiles it, or takes it from disk."""
    addresses, found = _NUMBERED[call], _SEPARATE[kernel][0].compile()
    if addresses[number] not in (0, found):
        raise RuntimeError(f"{_SEPARATE[kernel][0].name} has the number {number} of another kernel: give it another name.")
    addresses[number] = found


def compiled(*kernels: Callable[..., Any], number: int = 0) -> None:
    """Compile separate kernels, or take them from disk, unless this process has done so. number: which of their signatures."""
    for each in kernels:
        _SEPARATE[each][number].compile()
