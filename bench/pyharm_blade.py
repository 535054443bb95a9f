"""The single-blade rig on pyHarm, as far as it goes: its contact element couples the two tangential directions, the rig's do not,
so only the cost of a point can be compared, not the answer."""

from __future__ import annotations

import logging
import time

import numpy as np
from channel import Answer
from pyHarm import Maestro
from pyharm_calls import count


def blade(request: dict) -> Answer:
    """Sweep the exported rig (request["path"]) until the band ends or request["seconds"] of CPU are over."""
    began = time.process_time()
    rig = dict(np.load(request["path"]))
    maestro = Maestro(_input(rig, request))
    maestro.logger.setLevel(logging.ERROR)
    built = time.process_time()
    analysis = maestro.nls["frf"]
    calls = count(maestro.system, built + request["seconds"])
    try:
        maestro.operate(x0=_stuck_start(rig, request) / request["length"])
        failed = None
    except Exception as reason:
        failed = f"{type(reason).__name__}: {reason}"[:200]
    accepted = [solution for solution in analysis.SolList if solution.flag_accepted]
    return {
        "size": int(maestro.system.ndofs),
        "build_cpu": built - began,
        "cpu": time.process_time() - built,
        "points": len(accepted),
        "attempts": len(analysis.SolList),
        "jacobians": calls["Jacobian"],
        "last_omega": float(accepted[-1].x[-1]) if accepted else None,
        "residual": float(np.linalg.norm(accepted[-1].R[:-1])) if accepted else None,
        "stopped": failed,
    }


def _stuck_start(rig: dict[str, np.ndarray], request: dict) -> np.ndarray:
    """Mean, cosine and sine of the motion with every contact closed and stuck: from rest its contact element divides 0 by 0."""
    K, push = rig["K"].copy(), request["force"] * rig["load"][:, 1]
    rest = rig["load"][:, 0].copy()
    for node, kn, gap, kt, _ in rig["elements"]:
        i = 3 * int(node)
        K[[i, i + 1, i + 2], [i, i + 1, i + 2]] += (kt, kt, kn)
        rest[i + 2] += kn * gap
    omega = 2.0 * np.pi * request["band"][0]
    swing = np.linalg.solve(K + 1j * omega * rig["C"] - omega**2 * rig["M"], push)
    start = np.zeros((2 * request["harmonics"] + 1, K.shape[0]))
    start[0], start[1], start[2] = np.linalg.solve(K, rest), swing.real, -swing.imag
    return start.ravel()


def _input(rig: dict[str, np.ndarray], request: dict) -> dict:
    nodes, size = int(rig["nodes"]), rig["M"].shape[0]
    body = {"matrix": {name: rig[name] for name in "MCK"}, "ndofs": 3, "nmodes": size - 3 * nodes}
    connectors: dict[str, dict] = {
        f"contact {i}": {
            "type": "Penalty3D",
            "connect": {"body": [int(node)]},
            "dirs": [2, 0, 1],
            "mu": mu,
            "N0": 0.0,
            "k_n": kn,
            "k_t": kt,
            "g": gap,
        }
        for i, (node, kn, gap, kt, mu) in enumerate(rig["elements"])
    }
    for row, (static, cosine) in enumerate(rig["load"][3 * nodes :]):
        for harmonic, amplitude in ((0, static), (1, request["force"] * cosine)):
            if amplitude:
                connectors[f"force {row} {harmonic}"] = {
                    "type": "GOForcing",
                    "connect": {"body": [nodes + row]},
                    "dirs": [-1],
                    "dto": 0,
                    "ho": harmonic,
                    "amp": float(amplitude),
                }
    low, high = (2.0 * np.pi * frequency for frequency in request["band"])
    analysis = {
        "study": "frf",
        "puls_inf": low,
        "puls_sup": high,
        "ds0": request["ds"],
        "ds_max": request["ds"],
        "ds_min": 1e-6,
        "solver": request["solver"],
        "solver_options": {"max_iter": 30} if request["solver"] == "NewtonRaphson" else {},
        "verbose": False,
    }
    adim = {"status": True, "lc": request["length"], "wc": 1.0}
    system = {"type": "Base", "nh": request["harmonics"], "nti": 256, "adim": adim}
    return {"analysis": {"frf": analysis}, "system": system, "substructures": {"body": body}, "connectors": connectors}
