"""What a check says of the model of a study: natural frequencies, what holds it, and the loads of its contacts at rest."""

from __future__ import annotations

import warnings

import numpy as np
from scipy import linalg

from stickslip.checks import Array, counted, first_of
from stickslip.curves.curve import HELD_BY_FRICTION, held_by_friction_alone
from stickslip.problem import Problem
from stickslip.problem.at_rest import normal_loads_at_rest
from stickslip.study.analysis import Sweep
from stickslip.units import Band

SHOWN = 6
"""How many frequencies, and how many contacts, a sentence lists."""


LARGE = 0.1
"""Linear amplitude over the size of the structure from where on a theory of small motions is left."""

LARGE_WITHOUT_SIZE = 1e3
"""The same in m where no coordinates are known: models of a few masses are often stated without dimensions."""


def model_summary(sweep: Sweep, condition: str = "") -> list[str]:
    """Natural frequencies without contacts and with all stuck, which of them the band holds, whether friction alone holds a body,
    normal loads at rest, and a warning of implausible amplitudes. condition: when all that holds, "at 6000 rev/min".
    """
    free, stuck = (sweep.problem.frequencies(stuck=stuck) for stuck in (False, True))
    when = f" {condition}" if condition else ""
    listed = f"without contacts: {_listed(free)}; all contacts stuck: {_listed(stuck)}"
    lines = [f"Natural frequencies in Hz{when}, {listed}."]
    given = sweep.frequencies
    low, high = (given.low, given.high) if isinstance(given, Band) else (float(np.min(given)), float(np.max(given)))
    inside = [f for stuck in (False, True) for f in sweep.problem.systems.met(stuck) if low <= f <= high]
    if not inside:
        lines.append(f"None of them lies between {low:.6g} and {high:.6g} Hz, where the response is computed.")
    if held_by_friction_alone(sweep.problem):
        lines.append(HELD_BY_FRICTION)
    return lines + _loads(sweep.problem, when) + _amplitudes(sweep, low, high)


def _amplitudes(sweep: Sweep, low: float, high: float) -> list[str]:
    """A warning where the largest force level moves the structure by a part of its size, even at the ends of the band and with
    all contacts stuck.
    """
    problem, level = sweep.problem, max(sweep.force_levels)
    moved = max(float(np.max(np.abs(_linear(problem, level, 2.0 * np.pi * hertz)))) for hertz in (low, high))
    places = np.concatenate([problem.structure.mesh_points, np.reshape(list(problem.structure.nodes.values()), (-1, 3))])
    size = float(np.ptp(places, axis=0).max()) if len(places) else 0.0
    if moved <= (LARGE * size or LARGE_WITHOUT_SIZE):
        return []
    compared = f", {moved / size:.2g} times the size of the structure" if size else ""
    return [
        f"Warning: force level {level:g} moves the stuck structure by {moved:.3g} m{compared}. Motions must be small: check the "
        "units of forces and stiffnesses."
    ]


def _linear(problem: Problem, level: float, omega: float) -> Array:
    """First harmonic of the outputs with all contacts stuck, m; 0 where it is not finite."""
    system = problem.systems.at(1)
    orders = max((harmonic for force in problem.forces for harmonic in force.amplitudes), default=1)
    load = problem.load(orders, level, omega)
    dynamic = system.K - omega**2 * system.M + 1j * omega * system.C
    force = load[:, 1] - 1j * load[:, 2]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", linalg.LinAlgWarning)
            moved = system.outputs @ linalg.solve(dynamic, force)
    except (linalg.LinAlgError, linalg.LinAlgWarning):
        moved = system.outputs @ np.linalg.lstsq(dynamic, force, rcond=None)[0]
    return np.asarray(np.nan_to_num(moved, posinf=0.0, neginf=0.0))


def _listed(frequencies: Array) -> str:
    """The lowest frequencies, and how many rigid motions there are below."""
    moving = frequencies[frequencies > 0.0]
    rigid = [counted(frequencies.size - moving.size, "rigid motion")] if moving.size < frequencies.size else []
    return first_of([*rigid, *(f"{f:.5g}" for f in moving)], SHOWN)


def _loads(problem: Problem, when: str) -> list[str]:
    """Normal loads at rest of contacts where they vary; those that are open by name."""
    loads = normal_loads_at_rest(problem)
    if not loads:
        if not any(contact.normal is not None for contact in problem.contacts):
            return []
        held = ", and does friction hold them" if any(contact.law.rubs for contact in problem.contacts) else ""
        return [f"Normal loads at rest{when}: none found. Do the static loads press the contacts on{held}?"]
    open_ = [name for name, load in loads.items() if load == 0.0]
    closed = [f"{name} {load:.4g}" for name, load in loads.items() if load > 0.0]
    return [
        *([f"Normal loads at rest in N{when}: {first_of(closed, SHOWN)}."] if closed else []),
        *([f"Open at rest{when}: {first_of(open_, SHOWN)}."] if open_ else []),
    ]
