"""Compilation and caching of the numerical kernels.

numba's cache of a kernel does not notice when a kernel that it calls, in another file, has changed. The cache folder therefore
carries a digest of all kernel sources: a change anywhere compiles anew, and an old result is never used with new code.

A Ctrl-C that comes while a kernel runs is handled at the next Python code. With numba's own code that is where it makes the
result: it unpickles the class of each array and calls that of each named tuple, does not look whether these fail, and the process
ends with a segmentation fault. Here results are made without running Python code; the Ctrl-C then meets the caller.

A kernel is compiled with all that it calls, so what many kernels hold is compiled many times. Kernels therefore have no entry for
callers in C, and numba's sentence on shapes that do not fit, which writes both out in text, is a short one; it is so in the whole
process, for kernels of others too.
"""

from __future__ import annotations

import hashlib
import logging
import os
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import types
from numba.core import boxing, event, pythonapi
from numba.np import arrayobj

__all__ = ["inlined", "kernel"]

_Function = TypeVar("_Function", bound=Callable[..., Any])

_PACKAGE = Path(__file__).parent
_FOLDERS = ("contact", "harmonic", "platforms", "solve", "stability", "time")

UNUSED_SECONDS = 3 * 86400.0
"""Age from which a folder of other sources is removed; younger ones may belong to a process that still runs."""


def _digest() -> str:
    """Digest of the sources of all kernels: every file with a compiled function, and this one."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted(path for folder in _FOLDERS for path in (_PACKAGE / folder).glob("*.py")):
        source = path.read_bytes()
        if b"@kernel" in source or b"@inlined" in source:
            digest.update(path.name.encode() + source)
    return digest.hexdigest()[:16]


def _cache_folder() -> Path:
    """A writable folder for this digest: beside the package, else the user's cache; folders unused for days are removed."""
    name = f"kernels-{_digest()}"
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "stickslip"
    for parent in (_PACKAGE / "__pycache__", home):
        try:
            (parent / name).mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=parent / name):
                pass
        except OSError:
            continue
        for old in parent.glob("kernels-*"):
            if old.name != name and time.time() - old.stat().st_mtime > UNUSED_SECONDS:
                shutil.rmtree(old, ignore_errors=True)
        return parent / name
    return Path(tempfile.gettempdir()) / "stickslip" / name


if "NUMBA_CACHE_DIR" not in os.environ:
    numba.config.CACHE_DIR = str(_cache_folder())  # type: ignore[attr-defined]


_COMPILING = "stickslip compiles its kernels, once on this machine: about a minute for the first problem. They are kept on disk."


class _CompilationNotice(event.Listener):
    """Warn once per process that compilation takes time."""

    def on_start(self, what: event.Event) -> None:
        if what.data["dispatcher"].py_func.__module__.startswith("stickslip."):
            event.unregister("numba:compile", self)  # type: ignore[no-untyped-call]
            logging.getLogger("stickslip").warning(_COMPILING)

    def on_end(self, what: event.Event) -> None:
        pass


event.register("numba:compile", _CompilationNotice())  # type: ignore[no-untyped-call]


def _constant(each: Any, context: Any) -> Any:
    """A reference to an object that the compiled code keeps."""
    found = context.env_manager.read_const(context.env_manager.add_const(each))
    context.pyapi.incref(found)
    return found


def _array(kind: Any, value: Any, context: Any) -> Any:
    """Code that turns a native array into a Python object: numba's, with a constant for what it would unpickle."""
    api = context.pyapi
    api.serialize_object, api.unserialize = (lambda each: each), (lambda each: _constant(each, context))
    try:
        return boxing.box_array(kind, value, context)
    finally:
        del api.serialize_object, api.unserialize


def _named_tuple(kind: Any, value: Any, context: Any) -> Any:
    """Code that turns a native named tuple into a Python object, by `tuple.__new__(class, items)`."""
    api = context.pyapi
    parts = _constant(tuple.__new__, context), _constant(kind.instance_class, context), boxing.box_tuple(kind, value, context)
    made = api.call_function_objargs(parts[0], parts[1:])
    for each in parts:
        api.decref(each)
    return made


pythonapi._boxers.functions |= {types.Array: _array, types.NamedTuple: _named_tuple, types.NamedUniTuple: _named_tuple}


def kernel(function: _Function) -> _Function:
    """A compiled function; what is compiled is kept for later processes."""
    return numba.njit(cache=True, no_cfunc_wrapper=True)(function)  # type: ignore[call-overload, no-any-return]


def inlined(function: _Function) -> _Function:
    """A function written into the kernels that call it, instead of compiled by itself."""
    return numba.njit(inline="always")(function)  # type: ignore[return-value]


def _other_shape(source: Any, target: Any) -> None:
    raise ValueError("an array has another shape than the slice that it is assigned to")


arrayobj.raise_with_shape_context = numba.njit(no_cpython_wrapper=True, no_cfunc_wrapper=True)(_other_shape)  # type: ignore[call-overload]
