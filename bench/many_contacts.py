"""Many contacts on few modes: the time and memory of a point against the number of nodes, each in a fresh process."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from channel import Side

MODES = 300
POINTS = 6
NODES = {"friction disc": (100, 300, 1000, 2000), "macroslip": (300, 1000)}


def many_contacts(make: Callable[..., Side]) -> dict[str, Any]:
    """Rows for each law and number of nodes, with one BLAS thread and with one on every core."""
    rows = [_row(make, law, nodes) for law, counts in NODES.items() for nodes in counts]
    return {"modes": MODES, "cores": os.cpu_count() or 1, "rows": rows}


def _row(make: Callable[..., Side], law: str, nodes: int) -> dict[str, Any]:
    alone, threaded = (_measured(make(threads=threads), law, nodes) for threads in (1, os.cpu_count() or 1))
    return {"law": law, "nodes": nodes, **alone, "threaded_wall": threaded["wall"]}


def _measured(side: Side, law: str, nodes: int) -> dict[str, Any]:
    answer = side.ask("contacts", law=law, nodes=nodes, modes=MODES, points=POINTS)
    side.close()
    if "failed" in answer:
        raise RuntimeError(f"{law}, {nodes} nodes: {answer['failed']}")
    return answer
