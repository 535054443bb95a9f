"""Many small cases in one test: what a test of its own costs, 5 to 10 ms, is often more than what a case computes."""

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any

import pytest


def named(value: Any) -> str:
    return str(getattr(value, "__name__", None) or getattr(value, "name", None) or repr(value))


def each(names: str | tuple[str, ...], cases: Iterable[Any], ids: Callable[[Any], Any] | Iterable[str] = named) -> Any:
    """As `pytest.mark.parametrize`, but within one test: all cases run, and one message names those that fail.

    Fixtures of the test are shared by its cases.
    """
    names = (names,) if isinstance(names, str) else names
    cases = [tuple(case) if len(names) > 1 else (case,) for case in cases]
    assert cases, "no case to test"
    given = None if callable(ids) else list(ids)

    def over_all(test: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(test)
        def test_of_all(**fixtures: Any) -> None:
            failed, first = [], None
            for k, case in enumerate(cases):
                try:
                    test(**fixtures, **dict(zip(names, case, strict=True)))
                except (Exception, pytest.fail.Exception) as error:
                    first = first or error
                    name = given[k] if given else "-".join(str(ids(value)) for value in case)
                    failed.append(f"[{name}] {type(error).__name__}: {error}")
            if failed:
                raise AssertionError(f"{len(failed)} of {len(cases)} cases fail:\n" + "\n".join(failed)) from first

        own = inspect.signature(test)
        left = [parameter for parameter in own.parameters.values() if parameter.name not in names]
        test_of_all.__signature__ = own.replace(parameters=left)  # type: ignore[attr-defined]
        return test_of_all

    return over_all
