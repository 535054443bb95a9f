"""How the time of a point grows with contacts, harmonics, samples and structure size: one variable at a time.

A row of masses, each grounded by a spring 1 and tied to its neighbours by springs 0.1, all pushed alike, so that near
resonance every slider slips, however many there are. Slip limits are spread by a half, seeded, so that no two slip together.
"""

from __future__ import annotations

import time

import numpy as np
from channel import Answer

from stickslip import Problem
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, between
from stickslip.model.loads import Force
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError
from stickslip.solve.continuation.steps import StepControl

BAND = (0.9, 1.3)
DAMPING = 0.01
BASE = {"size": 400, "contacts": 4, "harmonics": 3, "samples": 128}
"""What stays when another variable grows; harmonics and samples grow on a smaller structure with ten sliders."""
SMALL = {"size": 20, "contacts": 10, "harmonics": 7, "samples": 256}


def oscillators(size: int, contacts: int) -> Problem:
    """The row of masses with sliders to ground, evenly spaced."""
    K = np.eye(size) + 0.1 * (2.0 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1))
    K[0, 0] = K[-1, -1] = 1.1
    names = tuple(f"{i}.x" for i in range(size))
    limits = np.random.default_rng(7).uniform(0.5, 1.5, contacts)
    places = np.linspace(0, size - 1, contacts).round().astype(int)
    sliders = tuple(
        Contact(f"slider {i}", Macroslip(0.5, 1.0, normal_load=float(limit)), (between(f"{i}.x", "ground"),))
        for i, limit in zip(places, limits, strict=True)
    )
    forces = tuple(Force(name, 1.0) for name in names)
    structure = Structure(np.eye(size), K, names, damping=ModalDamping(DAMPING, on="stuck"))
    return Problem(structure, sliders, forces, (names[places[0]],))


def growth(request: dict) -> Answer:
    """CPU seconds a point through the resonance while one variable has a given value; set-up (checks, modes) apart."""
    kind, value = request["kind"], request["value"]
    chosen = (BASE if kind in ("contacts", "size") else SMALL) | {kind: value}
    began = time.process_time()
    problem = oscillators(chosen["size"], chosen["contacts"])
    balance = HarmonicBalance(problem, chosen["harmonics"], chosen["samples"])
    setup = time.process_time() - began
    first = first_point(balance, BAND[0], 1.0)
    began = time.process_time()
    points = _bounded(balance, first, request["seconds"])
    cpu = time.process_time() - began
    return {
        "setup": setup,
        "per_point": cpu / len(points),
        "points": len(points),
        "iterations": float(np.mean([point.iterations for point in points])),
        "active": float(np.mean([point.active for point in points])),
        "most_active": max(point.active for point in points),
    }


def _bounded(balance: HarmonicBalance, first: object, seconds: float) -> list[CurvePoint]:
    """Points of the curve until the end of the band or of the time."""
    points: list[CurvePoint] = []
    ends = time.process_time() + seconds
    try:
        for point in trace(balance, first, "omega", BAND[1], StepControl()):  # type: ignore[arg-type]
            points.append(point)
            if time.process_time() > ends:
                break
    except LostCurveError:
        pass
    return points
