"""What a check says of the model of a study: natural frequencies and the loads of its contacts at rest."""

from __future__ import annotations

import numpy as np

from stickslip.checks import Array, counted, first_of
from stickslip.problem import Problem
from stickslip.problem.at_rest import normal_loads_at_rest
from stickslip.study.analysis import Sweep
from stickslip.units import Band

SHOWN = 6
"""How many frequencies, and how many contacts, a sentence lists."""


RIGID = 1e-4
"""Share of the lowest stuck frequency below which a motion without contacts counts as rigid."""


def model_summary(sweep: Sweep) -> list[str]:
    """Natural frequencies without contacts and with all stuck, which of them the band holds, and normal loads at rest."""
    free, stuck = (sweep.problem.frequencies(stuck=stuck) for stuck in (False, True))
    lines = [
        f"Natural frequencies in Hz, without contacts: {_listed(free, stuck[0])}; all contacts stuck: {_listed(stuck, stuck[0])}."
    ]
    given = sweep.frequencies
    low, high = (given.low, given.high) if isinstance(given, Band) else (float(np.min(given)), float(np.max(given)))
    inside = [f for f in (*free, *stuck) if low <= f <= high]
    if not inside:
        lines.append(f"None of them lies between {low:.6g} and {high:.6g} Hz, where the response is computed.")
    return lines + _loads(sweep.problem)


def _listed(frequencies: Array, smallest: float) -> str:
    """The lowest frequencies, and how many rigid motions there are below."""
    moving = frequencies[frequencies > RIGID * smallest]
    rigid = [counted(frequencies.size - moving.size, "rigid motion")] if moving.size < frequencies.size else []
    return first_of([*rigid, *(f"{f:.5g}" for f in moving)], SHOWN)


def _loads(problem: Problem) -> list[str]:
    """Normal loads at rest of contacts where they vary; those that are open by name."""
    loads = normal_loads_at_rest(problem)
    if not loads:
        if not any(contact.normal is not None for contact in problem.contacts):
            return []
        return ["Normal loads at rest: none found. Do the static loads press the contacts on, and does friction hold them?"]
    open_ = [name for name, load in loads.items() if load == 0.0]
    closed = [f"{name} {load:.4g}" for name, load in loads.items() if load > 0.0]
    return [
        *([f"Normal loads at rest in N: {first_of(closed, SHOWN)}."] if closed else []),
        *([f"Open at rest: {first_of(open_, SHOWN)}."] if open_ else []),
    ]
