"""Counting what Newton's method does, wherever it was imported to."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from stickslip.solve.continuation import steps
from stickslip.solve.continuation.newton import Correction, Found, correct
from stickslip.solve.continuation.steps import Stepped, step


def calls(found: Correction | Found) -> int:
    """One for each call."""
    return 1


def residuals(found: Correction | Found) -> int:
    """Evaluations of the residual: at the start and after each step; halved steps are not counted."""
    return 1 + found.iterations


@contextmanager
def counted(of: Callable[[Correction | Found], int] = calls) -> Iterator[Callable[[], int]]:
    """The sum over all calls of Newton's method inside the block, those within steps of a continuation included."""
    total = [0]

    def counting(*arguments: Any, **options: Any) -> Correction:
        found = correct(*arguments, **options)
        total[0] += of(found)
        return found

    def counting_step(*arguments: Any) -> Stepped:
        found = step(*arguments)
        total[0] += of(found.found)
        return found

    users = [module for module in list(sys.modules.values()) if getattr(module, "correct", None) is correct]
    users = [module for module in users if module.__name__.startswith("stickslip.")]
    for module in users:
        module.correct = counting  # type: ignore[attr-defined]
    steps.step = counting_step
    try:
        yield lambda: total[0]
    finally:
        for module in users:
            module.correct = correct  # type: ignore[attr-defined]
        steps.step = step
