"""How results of kernels become Python objects, safe from Ctrl-C.

A Ctrl-C that comes while a kernel runs is handled at the next Python code. With numba's own code that is where it makes the
result: it unpickles the class of each array and calls that of each named tuple, does not look whether these fail, and the process
ends with a segmentation fault. Here results are made without running Python code; the Ctrl-C then meets the caller. It is so in
the whole process, for kernels of others too.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core import boxing, pythonapi


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
