"""Many cases by processes: wall time against the number of processes, beside what the cores of the machine give to separate runs.

`python bench/scaling.py KIND PROCESSES` computes one kind alone and prints its seconds; `scaling()` runs it in fresh processes.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

CASES = 8


def force_levels() -> Callable[[int], object]:
    """Force levels of the single blade."""
    import stickslip as ss

    rig, levels = ss.rigs.single_blade(4.6), np.geomspace(20.0, 160.0, CASES).tolist()
    return lambda processes: ss.forced_response(rig, ss.hertz(500.0, 580.0), levels, 11, workers=processes)


def start_states() -> Callable[[int], object]:
    """Start states of the same blade."""
    import stickslip as ss

    rig = ss.rigs.single_blade(4.6, start=ss.SliderOffset())
    return lambda processes: ss.response_samples(rig, ss.hertz(500.0, 580.0), 80.0, CASES, harmonics=7, workers=processes)


def frictions() -> Callable[[int], object]:
    """Frictions and preloads: performance curves over the pull, one for each friction."""
    import stickslip as ss

    settings: dict[str, Any] = {"vary": "preload", "friction": np.linspace(0.15, 0.6, CASES).tolist(), "check_every": 1}
    rig, pulls = ss.rigs.three_mass_wedge(), np.geomspace(2.0, 200.0, 30)
    return lambda processes: ss.performance_curve(rig, pulls, band=ss.hertz(145.0, 300.0), workers=processes, **settings)


KINDS: dict[str, Callable[[], Callable[[int], object]]] = {
    "force levels, single blade": force_levels,
    "start states, single blade": start_states,
    "frictions, wedge": frictions,
}


def scaling() -> list[dict[str, Any]]:
    """Each kind with 1, 2, 4, ... processes up to the cores; and as many separate runs at once as there are cores."""
    cores = os.cpu_count() or 1
    counts = sorted({*(2**k for k in range(cores.bit_length()) if 2**k <= cores), cores})
    rows = []
    for kind in KINDS:
        _together(kind, 1, 1)  # kernels compiled
        found = {count: _together(kind, count, 1)[0] for count in counts}
        apart = _together(kind, 1, cores)
        rows.append({"kind": kind, "cases": CASES, "processes": found, "apart": float(np.mean([run["wall"] for run in apart]))})
    return rows


def _together(kind: str, processes: int, runs: int) -> list[dict[str, float]]:
    """Separate runs at once, each in a process of its own."""
    from environment import ONE_THREAD

    command = [sys.executable, __file__, kind, str(processes)]
    started = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ | ONE_THREAD) for _ in range(runs)]
    return [json.loads(run.communicate()[0].splitlines()[-1]) for run in started]


if __name__ == "__main__":
    began = time.monotonic()
    analysis = KINDS[sys.argv[1]]()
    before = time.monotonic() - began
    analysis(int(sys.argv[2]))
    wall = time.monotonic() - began
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    print(json.dumps({"wall": wall, "before": before, "cpu": sum(one.ru_utime + one.ru_stime for one in used)}))
