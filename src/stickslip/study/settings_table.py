"""Tables of studies from the settings of analyses: keys, ranges, defaults and meanings are those of Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import Annotated, Any, get_type_hints

from pydantic import Field, create_model

from stickslip.analyses.settings import Settings, Whole, marks, not_given
from stickslip.study.fields import Table


def table_of(kind: type[Settings], introduction: str, **forms: Any) -> type[Table]:
    """The table whose keys are the settings that have a meaning.

    forms: the type of a key that a file writes in another form than Python, or the type and the default of a further key.
    """
    hints, keys = get_type_hints(kind), {}
    for setting in fields(kind):
        mark = marks(kind).get(setting.name)
        if mark is None or not mark.means:
            continue
        usual = Annotated[int, Field(ge=mark.check.least, le=mark.check.most)] if isinstance(mark.check, Whole) else None
        key = mark.key or setting.name
        form = forms.pop(key, usual or hints[setting.name])
        default = ... if setting.default is MISSING else setting.default
        keys[key] = Annotated[form, Field(description=mark.means)], default
    return create_model(f"{kind.__name__}Table", __base__=Table, __doc__=introduction, **keys | forms)


def check_of(kind: type[Settings]) -> Callable[[Table], None]:
    """The checks of Python on such a table, for what its model cannot check."""

    def check(table: Table) -> None:
        for name, mark in marks(kind).items():
            value = getattr(table, mark.key or name, None)
            if mark.means and not not_given(kind, name, value):
                mark.check(name, value)

    return check
