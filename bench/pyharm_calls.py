"""Counting what pyHarm evaluates, and ending a sweep whose CPU time is over."""

from __future__ import annotations

import time


def count(system: object, deadline: float) -> dict[str, int]:
    """Count calls of the system's residual and Jacobian from now on; end the sweep when its CPU time is over."""
    calls = {"Residual": 0, "Jacobian": 0}
    for name in calls:

        def counted(*arguments: object, _original: object = getattr(system, name), _name: str = name) -> object:
            calls[_name] += 1
            if time.process_time() > deadline:
                raise TimeoutError
            return _original(*arguments)  # type: ignore[operator]

        setattr(system, name, counted)
    return calls
