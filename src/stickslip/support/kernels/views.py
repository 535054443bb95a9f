"""Named tuples of arrays as kernels read them: one address, behind which the fields lie.

As an argument a tuple is all of its arrays, each with seven numbers, and each call counts references of all of them: with tables
of forty arrays that is most of what there is to compile. `view` is called in the kernels that Python calls, whose arguments live
until they return; arrays read through a view belong to the tuple and must not be part of a result.

To take a tuple of forty arrays from Python costs 15 µs a call, as much as a small evaluation. A tuple that many calls need is
`Placed` in memory once, and its address handed over.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import typeof, types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, models, register_model

from stickslip.support.kernels.decorators import kernel


class View(types.Type):
    """Type of a view of a type of named tuples."""

    def __init__(self, whole: Any) -> None:
        self.whole, self.instance_class = whole, whole.instance_class
        super().__init__(name=f"View({whole})")


register_model(View)(models.OpaqueModel)


def view_of(example: Any) -> View:
    """Type of a view of such a named tuple."""
    return View(typeof(example))


_EXAMPLES: dict[type, Callable[[], Any]] = {}
"""Named tuples like those at an address, by the class of the address."""


def placed_as(example: Callable[[], Any]) -> Callable[[type], type]:
    """Decorates the class of an address, a named tuple of one whole number: what lies there is of the type of an example."""

    def decorated(address: type) -> type:
        _EXAMPLES[address] = example
        return address

    return decorated


if TYPE_CHECKING:
    _Whole = TypeVar("_Whole")

    def view(whole: _Whole) -> _Whole:
        """A view is read as what it is a view of."""

else:

    @intrinsic
    def view(context: Any, whole: Any) -> tuple[Any, Any]:
        """A view of an argument of a kernel that Python calls: of a named tuple, or of the one at an address."""
        example = _EXAMPLES.get(getattr(whole, "instance_class", None))
        if example is not None:
            return view_of(example())(whole), _at_address

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            place = cgutils.alloca_once_value(builder, arguments[0])
            return builder.bitcast(place, ir.IntType(8).as_pointer())

        return View(whole)(whole), code


def _at_address(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.inttoptr(builder.extract_value(arguments[0], 0), ir.IntType(8).as_pointer())


class Placed:
    """A named tuple where kernels can read it, as long as this object lives. address: what to call them with."""

    def __init__(self, whole: Any, address: Callable[[int], Any]) -> None:
        self.whole, self._class = whole, address
        self._memory = np.empty(_size(whole), dtype=np.uint8)
        _write(whole, self._memory)
        self.address = address(self._memory.ctypes.data)

    def __reduce__(self) -> tuple[Any, ...]:
        """Elsewhere it lies at another address."""
        return Placed, (self.whole, self._class)


@intrinsic
def _written(context: Any, whole: Any, memory: Any) -> tuple[Any, Any]:
    """Store a named tuple in an array of bytes."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = context.make_array(signature.args[1])(context, builder, arguments[1]).data
        builder.store(arguments[0], builder.bitcast(place, arguments[0].type.as_pointer()))
        return context.get_dummy_value()

    return types.none(whole, memory), code


@intrinsic
def _bytes(context: Any, whole: Any) -> tuple[Any, Any]:
    """Size of a named tuple as kernels have it."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.get_constant(types.int64, context.get_abi_sizeof(arguments[0].type))

    return types.int64(whole), code


@kernel
def _size(whole: Any) -> int:
    return _bytes(whole)  # type: ignore[call-arg]


@kernel
def _write(whole: Any, memory: Any) -> None:
    _written(whole, memory)  # type: ignore[call-arg]


@infer_getattr
class _Fields(AttributeTemplate):
    """Types of the fields; a tuple in a tuple is a view too."""

    key = View

    def generic_resolve(self, seen: View, name: str) -> Any:  # type: ignore[override]
        if name not in seen.whole.fields:
            return None
        found = seen.whole.types[seen.whole.fields.index(name)]
        return View(found) if isinstance(found, types.BaseNamedTuple) else found


@lower_getattr_generic(View)
def _field(context: Any, builder: Any, seen: View, address: Any, name: str) -> Any:
    """Code that reads a field: a number, an array that owns nothing, or the address of a tuple."""
    index = seen.whole.fields.index(name)
    found = seen.whole.types[index]
    whole = builder.bitcast(address, context.get_value_type(seen.whole).as_pointer())
    place = cgutils.gep_inbounds(builder, whole, 0, index)
    if isinstance(found, types.BaseNamedTuple):
        return builder.bitcast(place, ir.IntType(8).as_pointer())
    if not isinstance(found, types.Array):
        return builder.load(place)
    array = context.make_array(found)(context, builder, value=builder.load(place))
    array.meminfo, array.parent = (cgutils.get_null_value(each.type) for each in (array.meminfo, array.parent))
    return array._getvalue()
