"""The time of a point with many contacts on few modes; the process is a fresh one, so that its memory is that of the problem."""

from __future__ import annotations

import time
from itertools import islice

import numpy as np
from channel import Answer
from plate import plate

from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point, trace

BAND = (1.05, 1.3)
HARMONICS, SAMPLES = 3, 128


def contacts(request: dict) -> Answer:
    """CPU and wall seconds a point of the first points of a curve; kernels are compiled by a small problem before."""
    points = _points(HarmonicBalance(plate(12, 12, request["law"]), HARMONICS, SAMPLES), 3)
    began = time.process_time()
    balance = HarmonicBalance(plate(request["nodes"], request["modes"], request["law"]), HARMONICS, SAMPLES)
    setup = time.process_time() - began
    first = first_point(balance, BAND[0], 1.0)
    balance.system.effort[:] = 0
    clocks = time.process_time(), time.perf_counter()
    points = list(islice(trace(balance, first, "omega", BAND[1]), request["points"]))
    cpu, wall = time.process_time() - clocks[0], time.perf_counter() - clocks[1]
    count = len(points)
    return {
        "setup": setup,
        "cpu": cpu / count,
        "wall": wall / count,
        "iterations": float(np.mean([point.iterations for point in points])),
        "factorisations": int(balance.system.effort[1]) / count,
        "multiplications": int(balance.system.effort[2]) / max(int(balance.system.effort[1]), 1),
        "unknowns": max(point.active for point in points),
    }


def _points(balance: HarmonicBalance, count: int) -> list[object]:
    return list(islice(trace(balance, first_point(balance, BAND[0], 1.0), "omega", BAND[1]), count))
