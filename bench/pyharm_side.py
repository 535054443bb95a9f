"""pyHarm's side of the benchmark, run by the interpreter of its own environment: builds the cases and sweeps them on request.

The set-ups follow pyHarm's documented input: substructures with matrices, connectors between nodes, one analysis "frf".
Run as a script; it imports nothing of stickslip.
"""

from __future__ import annotations

import contextlib
import logging
import math
import sys
import time
from importlib import metadata

import numpy as np
from cases import (
    BY_NAME,
    CHAIN,
    FORCED,
    HARMONICS,
    MASSES,
    SAMPLES,
    SINGLE_MASS,
    STIFFNESS_DAMPING,
    TOUCHING,
    VARYING,
    Case,
    chain_stiffness,
    planar_chain_stiffness,
)
from channel import Answer, serve
from pyHarm import Maestro
from pyharm_blade import blade
from pyharm_calls import count

IMPORT_SECONDS = time.process_time()


def single_mass(level: float) -> dict:
    """One node with one direction and a Jenkins element to ground."""
    p = SINGLE_MASS
    matrices = {"M": np.array([[p["m"]]]), "C": np.array([[p["c"]]]), "K": np.array([[p["k"]]])}
    slider = {"type": "Jenkins", "connect": {"body": [0]}, "dirs": [0], "mu": 1.0, "N0": p["limit"], "k": p["kt"]}
    force = {"type": "CosinusForcing", "connect": {"body": [0]}, "dirs": [0], "amp": level}
    return {
        "substructures": {"body": {"matrix": matrices, "ndofs": 1}},
        "connectors": {"slider": slider, "force": force},
    }


def chain(level: float) -> dict:
    """Twenty nodes with one direction, Jenkins elements to ground."""
    K = chain_stiffness()
    matrices = {"M": np.eye(MASSES), "C": STIFFNESS_DAMPING * K, "K": K}
    connectors: dict[str, dict] = {
        f"slider {i}": {
            "type": "Jenkins",
            "connect": {"body": [i - 1]},
            "dirs": [0],
            "mu": 1.0,
            "N0": CHAIN["limit"],
            "k": CHAIN["kt"],
        }
        for i in TOUCHING
    }
    connectors["force"] = {"type": "CosinusForcing", "connect": {"body": [FORCED - 1]}, "dirs": [0], "amp": level}
    return {"substructures": {"body": {"matrix": matrices, "ndofs": 1}}, "connectors": connectors}


def chain_varying_load(level: float) -> dict:
    """Twenty nodes with directions x, y and Penalty3D elements to ground.

    Penalty3D wants one normal and two tangential directions, its normal counted as opening. Naming x twice as tangential
    spares a third degree of freedom a node: two equal elements of kt/2 make kt, and the slip condition on √2 times the force
    of one is the wanted one with μ/√2. The force is the change N − N0, as in the balanced form of the case.
    """
    K = planar_chain_stiffness()
    matrices = {"M": np.eye(2 * MASSES), "C": STIFFNESS_DAMPING * K, "K": K}
    p = VARYING
    connectors: dict[str, dict] = {
        f"contact {i}": {
            "type": "Penalty3D",
            "connect": {"body": [i - 1]},
            "dirs": [1, 0, 0],
            "coordinatesystem": "opening",
            "mu": p["mu"] / math.sqrt(2.0),
            "N0": p["preload"],
            "k_n": p["kn"],
            "k_t": p["kt"] / 2.0,
            "g": 0.0,
        }
        for i in TOUCHING
    }
    connectors["force"] = {"type": "CosinusForcing", "connect": {"body": [FORCED - 1]}, "dirs": [0], "amp": level}
    connectors |= {
        f"press {i}": {"type": "CosinusForcing", "connect": {"body": [i - 1]}, "dirs": [1], "amp": level} for i in TOUCHING
    }
    return {
        "coordinates": {"opening": [[1.0, 0.0], [0.0, -1.0]]},
        "substructures": {"body": {"matrix": matrices, "ndofs": 2}},
        "connectors": connectors,
    }


MODELS = {"B1": single_mass, "B2a": chain, "B2b": chain_varying_load}
OUTPUT = {"B1": (0, 0), "B2a": (FORCED - 1, 0), "B2b": (FORCED - 1, 0)}


def sweep(request: dict) -> Answer:
    """Sweep a case with settings {ds, solver, length, reductor} and say what it took; seconds: bound of the CPU time."""
    case = BY_NAME[request["case"]]
    began = time.process_time()
    maestro = Maestro(_input(case, request))
    maestro.logger.setLevel(logging.ERROR)
    calls = count(maestro.system, began + request.get("seconds", 600))
    with contextlib.suppress(TimeoutError):
        maestro.operate()
    cpu = time.process_time() - began
    accepted = [solution for solution in maestro.nls["frf"].SolList if solution.flag_accepted]
    length = maestro.system.lc
    rows = _harmonics_of(maestro.system.expl_dofs, *OUTPUT[case.problem])
    omegas = [float(solution.x[-1]) * maestro.system.wc for solution in accepted]
    motion = [[float(value) * length for value in solution.x[:-1][rows]] for solution in accepted]
    return {
        "cpu": cpu,
        "points": len(accepted),
        "refused": len(maestro.nls["frf"].SolList) - len(accepted),
        "iterations": calls["Jacobian"] / max(len(accepted), 1),
        "omega": omegas,
        "motion": motion,
        "reached": bool(omegas and omegas[-1] >= request.get("band", case.band)[1]),
    }


def _input(case: Case, request: dict) -> dict:
    low, high = request.get("band", case.band)
    settings = request["settings"]
    analysis = {
        "study": "frf",
        "puls_inf": low,
        "puls_sup": high,
        "ds0": settings["ds"],
        "ds_max": settings["ds"],
        "ds_min": 1e-6,
        "solver": settings.get("solver", "scipyroot"),
        "predictor": settings.get("predictor", "tangent"),
        "corrector": settings.get("corrector", "arc_length"),
        "reductors": [{"type": settings.get("reductor", "noreductor")}],
        "verbose": False,
    }
    model = MODELS[case.problem](case.level)
    length = settings.get("length", 1.0)
    adim = {"status": length != 1.0, "lc": length, "wc": 1.0}
    return {"analysis": {"frf": analysis}, "system": {"type": "Base", "nh": HARMONICS, "nti": SAMPLES, "adim": adim}} | model


def _harmonics_of(dofs: object, node: int, direction: int) -> list[int]:
    """Where the mean, cosine and sine parts of one degree of freedom stand: 0, c1, s1, c2, s2, ..."""
    table = dofs[(dofs["node_num"] == node) & (dofs["dof_num"] == direction)].sort_values(["harm", "cs"])  # type: ignore[index]
    return [int(i) for i in table.index]


if __name__ == "__main__":
    names = ("pyHarm-os", "numpy", "scipy", "numba", "jax")
    versions = {"python": sys.version.split()[0]} | {name: metadata.version(name) for name in names}
    serve({"sweep": sweep, "blade": blade}, {"import_seconds": IMPORT_SECONDS, "versions": versions})
