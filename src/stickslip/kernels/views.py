"""Named tuples of arrays as kernels read them: one address, behind which the fields lie.

As an argument a tuple is all of its arrays, each with seven numbers, and each call counts references of all of them: with tables
of forty arrays that is most of what there is to compile. `view` is called in the kernels that Python calls, whose arguments live
until they return; arrays read through a view belong to the tuple and must not be part of a result.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from llvmlite import ir  # type: ignore[import-untyped]
from numba import typeof, types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, models, register_model

__all__ = ["View", "view", "view_of"]


class View(types.Type):
    """Type of a view of a type of named tuples."""

    def __init__(self, whole: Any) -> None:
        self.whole, self.instance_class = whole, whole.instance_class
        super().__init__(name=f"View({whole})")


register_model(View)(models.OpaqueModel)


def view_of(example: Any) -> View:
    """Type of a view of such a named tuple."""
    return View(typeof(example))


if TYPE_CHECKING:
    _Whole = TypeVar("_Whole")

    def view(whole: _Whole) -> _Whole:
        """A view is read as what it is a view of."""

else:

    @intrinsic
    def view(context: Any, whole: Any) -> tuple[Any, Any]:
        """A view of an argument of a kernel that Python calls."""

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            place = cgutils.alloca_once_value(builder, arguments[0])
            return builder.bitcast(place, ir.IntType(8).as_pointer())

        return View(whole)(whole), code


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
