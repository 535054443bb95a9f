"""What a kernel returns to Python, safe from Ctrl-C: `return boxed(...)` where arrays or named tuples are part of it.

A Ctrl-C that comes while a kernel runs is handled at the next Python code. With numba's own code that is where it makes the
result: it unpickles the class of each array and calls that of each named tuple, does not look whether these fail, and the process
ends with a segmentation fault. A boxed result is made without running Python code; the Ctrl-C then meets the caller.
"""

from typing import TYPE_CHECKING, Any, TypeVar

from numba import types
from numba.core import boxing, cgutils
from numba.core.imputils import impl_ret_borrowed
from numba.extending import box, intrinsic, models, register_model


class Boxed(types.Type):
    """Type of a result for Python, of what a kernel returns."""

    def __init__(self, whole: Any) -> None:
        self.whole = whole
        super().__init__(name=f"Boxed({whole})")


@register_model(Boxed)
class _BoxedModel(models.StructModel):
    def __init__(self, manager: Any, kind: Boxed) -> None:
        super().__init__(manager, kind, [("whole", kind.whole)])  # type: ignore[no-untyped-call]


if TYPE_CHECKING:
    _Whole = TypeVar("_Whole")

    def boxed(whole: _Whole) -> _Whole:
        """To Python a boxed result is what was boxed."""

else:

    @intrinsic
    def boxed(context: Any, whole: Any) -> tuple[Any, Any]:
        """The result of a kernel that Python calls; other kernels cannot read it."""

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            result = cgutils.create_struct_proxy(signature.return_type)(context, builder)
            result.whole = arguments[0]
            return impl_ret_borrowed(context, builder, signature.return_type, result._getvalue())

        return Boxed(whole)(whole), code


@box(Boxed)
def _box(kind: Boxed, value: Any, context: Any) -> Any:
    result = cgutils.create_struct_proxy(kind)(context.context, context.builder, value=value)
    return _object(kind.whole, result.whole, context)


def _object(kind: Any, value: Any, context: Any) -> Any:
    """Code that turns a native value into a Python object."""
    if isinstance(kind, types.Array):
        return _array(kind, value, context)
    if isinstance(kind, types.BaseNamedTuple):
        return _named_tuple(kind, value, context)
    if isinstance(kind, types.BaseTuple):
        return _tuple(kind, value, context)
    return context.box(kind, value)


def _array(kind: Any, value: Any, context: Any) -> Any:
    """numba's own code, with a constant in place of the class that it would unpickle."""
    api = context.pyapi
    api.serialize_object, api.unserialize = (lambda each: each), (lambda each: _constant(each, context))
    try:
        return boxing.box_array(kind, value, context)
    finally:
        del api.serialize_object, api.unserialize


def _tuple(kind: Any, value: Any, context: Any) -> Any:
    made = context.pyapi.tuple_new(kind.count)
    for i, each in enumerate(kind):
        item = context.builder.extract_value(value, i)
        context.pyapi.tuple_setitem(made, i, _object(each, item, context))
    return made


def _named_tuple(kind: Any, value: Any, context: Any) -> Any:
    """By `tuple.__new__(class, items)`."""
    api = context.pyapi
    parts = _constant(tuple.__new__, context), _constant(kind.instance_class, context), _tuple(kind, value, context)
    made = api.call_function_objargs(parts[0], parts[1:])
    for each in parts:
        api.decref(each)
    return made


def _constant(each: Any, context: Any) -> Any:
    """A reference to an object that the compiled code keeps."""
    found = context.env_manager.read_const(context.env_manager.add_const(each))
    context.pyapi.incref(found)
    return found
