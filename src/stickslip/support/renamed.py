"""Old names of arguments and properties, accepted for one release with a DeprecationWarning."""

import warnings
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

_P = ParamSpec("_P")
_R = TypeVar("_R")


def renamed_arguments(**names: str) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Accept arguments of a function under old names: `@renamed_arguments(old="new")`."""

    def decorate(function: Callable[_P, _R]) -> Callable[_P, _R]:
        @wraps(function)
        def call(*args: _P.args, **kwargs: _P.kwargs) -> _R:
            given: dict[str, Any] = kwargs
            for old in names.keys() & given.keys():
                new = names[old]
                if new in given:
                    raise TypeError(f"{function.__name__}() got both `{old}` and `{new}`, its new name")
                warnings.warn(f"The argument `{old}` is now `{new}`.", DeprecationWarning, stacklevel=2)
                given[new] = given.pop(old)
            return function(*args, **kwargs)

        return call

    return decorate


def renamed_property(old: str, new: str) -> property:
    """A property under its old name: `doubts = renamed_property("doubts", "warnings")`."""

    def get(self: object) -> Any:
        warnings.warn(f"{type(self).__name__}.{old} is now {type(self).__name__}.{new}.", DeprecationWarning, stacklevel=2)
        return getattr(self, new)

    return property(get, doc=f"Old name of `{new}`.")
