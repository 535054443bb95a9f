"""Tables of studies from the settings of analyses: keys, ranges, defaults and meanings are those of Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import Annotated, Any, get_type_hints

from pydantic import Field, create_model

from stickslip.analyses.settings import Settings, Whole, Within, marks, not_given
from stickslip.study.fields import Table
from stickslip.support.checks import Faults, InputError


def table_of(kind: type[Settings], introduction: str, base: type[Table] = Table, **forms: Any) -> type[Table]:
    """The table whose keys are the settings that have a meaning.

    base: a table whose keys and rules it has too. forms: the type of a key that a file writes in another form than Python, with
    its default where that is another, or the type and the default of a further key.
    """
    hints, keys = get_type_hints(kind), {}
    for setting in fields(kind):
        mark = marks(kind).get(setting.name)
        if mark is None or not mark.means:
            continue
        key = mark.key or setting.name
        default = ... if setting.default is MISSING else setting.default
        form = forms.pop(key, None) or _usual(mark.check) or hints[setting.name]
        form, default = form if isinstance(form, tuple) else (form, default)
        keys[key] = Annotated[form, Field(description=mark.means)], default
    return create_model(f"{kind.__name__}Table", __base__=base, __doc__=introduction, **keys | forms)


def _usual(check: Callable[[str, Any], Any]) -> Any:
    """The type of a key by its check, where that has bounds."""
    match check:
        case Whole(least, most):
            return Annotated[int, Field(ge=least, le=most)]
        case Within(low, high):
            return Annotated[float, Field(gt=low, lt=high)]
    return None


def values_of(kind: type[Settings], table: Table) -> dict[str, Any]:
    """What such a table says, by the names of Python."""
    return {name: getattr(table, mark.key or name) for name, mark in marks(kind).items() if mark.means}


def check_of(kind: type[Settings]) -> Callable[[Table], None]:
    """The checks of Python on such a table, for what its model cannot check."""

    def check(table: Table) -> None:
        faults: list[str] = []
        for name, value in values_of(kind, table).items():
            try:
                if not not_given(kind, name, value):
                    marks(kind)[name].check(name, value)
            except InputError as error:
                faults += error.faults if isinstance(error, Faults) else [str(error)]
        if faults:
            raise Faults(faults)

    return check
