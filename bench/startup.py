"""What comes before the first point: import and compilation, on a fresh machine and in the next process; peak memory."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from typing import Any

from channel import Side
from environment import BUILD

Settings = dict[str, dict[str, Any]]


def startup(make: Callable[[str], Side], settings: Settings) -> dict[str, Any]:
    """CPU seconds of import, and of the first sweep of each kind less a later one, with an empty and with a filled cache."""
    cache = f"fresh-{make('x').name}"
    shutil.rmtree(BUILD / cache, ignore_errors=True)
    found = {state: _process(make(cache), settings) for state in ("first_process", "next_process")}
    shutil.rmtree(BUILD / cache, ignore_errors=True)
    return found


def _process(side: Side, settings: Settings) -> dict[str, Any]:
    began = time.monotonic()
    greeting = side.start()
    compile_seconds = {}
    until_first = None
    for case, chosen in settings.items():
        first = side.ask("sweep", case=case, settings=chosen, **_short(side, case))
        until_first = until_first or time.monotonic() - began
        later = side.ask("sweep", case=case, settings=chosen, **_short(side, case))
        compile_seconds[case] = max(first["cpu"] - later["cpu"], 0.0) if "cpu" in first and "cpu" in later else None
    side.close()
    return {"import_cpu": greeting["import_seconds"], "compile_cpu": compile_seconds, "wall_until_first_sweep": until_first}


def _short(side: Side, case: str) -> dict[str, Any]:
    """pyHarm's sweeps of B2b take long; the start of the band compiles everything."""
    return {"band": (0.18, 0.183)} if side.name == "pyHarm" and case == "B2b" else {}


def memory(make: Callable[[], Side], settings: Settings) -> dict[str, float | None]:
    """Peak resident memory in MiB of a process that does one sweep."""
    found = {}
    for case, chosen in settings.items():
        side = make()
        answer = side.ask("sweep", case=case, settings=chosen, seconds=400)
        found[case] = answer.get("peak_memory_MiB") if "failed" not in answer else None
        side.close()
    return found
